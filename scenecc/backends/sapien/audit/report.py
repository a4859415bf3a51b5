"""The audit as a whole: which bodies are read how closely, and how differences become diagnostics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from scenecc.backends.sapien.audit.articulation import ArticulationAudit
from scenecc.backends.sapien.audit.bodies import look_at_all
from scenecc.backends.sapien.audit.body import BodyAudit
from scenecc.backends.sapien.audit.difference import CODE, tell
from scenecc.backends.sapien.audit.entities import look_at_entities
from scenecc.backends.sapien.audit.meshes import Meshes
from scenecc.backends.sapien.audit.scene import cooking_differences, scene_differences
from scenecc.backends.sapien.audit.sweep import Sweep
from scenecc.backends.sapien.turn import ArticulationTurn

if TYPE_CHECKING:
    from scenecc.backends.sapien.audit.defaults import Defaults
    from scenecc.backends.sapien.audit.difference import Difference
    from scenecc.backends.sapien.audit.sweep import Place
    from scenecc.backends.sapien.batch import SceneBatch
    from scenecc.backends.sapien.turn import AnyTurn
    from scenecc.diagnostics import Sink


def audit(
    batch: SceneBatch, turns: list[AnyTurn], present: Defaults, sink: Sink, level: Literal["full", "fast"]
) -> bool:
    """Compares what the engine holds with the plan, reports every difference, and says whether there is none.

    To be called before anything is stepped, and while the process-wide defaults are those of the build;
    `present` are the engine's as they were before the build set any.
    """
    plan, scenes = batch.plan, batch.scenes
    defaults = present.asked(plan.physics)
    settings = [(batch.scene_idxs[0], difference) for difference in cooking_differences(defaults)]
    for index, scene in zip(batch.scene_idxs, scenes if level == "full" else scenes[:1], strict=False):
        settings += [(index, difference) for difference in scene_differences(defaults, scene)]
    for index, difference in settings:
        tell(sink, difference, "the scene", [index], plan.physics.origin or plan.origin)
    sweep = Sweep()
    if turns:
        _look_at_bodies(batch, turns, defaults, sweep, level)
    found: dict[str, list[tuple[Place, Difference]]] = {}
    for place, difference in sweep.differences():
        found.setdefault(place.turn.entity.name, []).append((place, difference))
    for turn in turns:
        _tell_all(sink, turn, found.get(turn.entity.name, []))
    return not settings and not found


def _look_at_bodies(
    batch: SceneBatch, turns: list[AnyTurn], defaults: Defaults, sweep: Sweep, level: Literal["full", "fast"]
) -> None:
    meshes = Meshes(batch.plan, defaults.material)
    bodies = BodyAudit(batch.plan, defaults, meshes, sweep, rendered=batch.render)
    look_at_entities(turns, batch.scenes, batch.scene_idxs, sweep, every_name=level == "full")
    articulations = ArticulationAudit(bodies, defaults, meshes, sweep)
    for turn in turns:
        if isinstance(turn, ArticulationTurn):
            articulations.look_at(turn, every=level == "full")
            continue
        for part in turn.parts:
            closely = part.numbers if level == "full" else part.numbers[:1]
            for number in closely.tolist():
                bodies.look_at(turn, part.structure, number)
            if len(closely) < len(part.numbers) and part.structure.body_type != "none":
                components: list[Any] = [turn.components[number] for number in part.numbers]
                look_at_all(turn, part, components, meshes, sweep)


def _tell_all(sink: Sink, turn: AnyTurn, found: list[tuple[Place, Difference]]) -> None:
    """One diagnostic a property and place, however many scenes have it."""
    groups: dict[tuple[str, Any, str | None], tuple[Difference, list[int]]] = {}
    # What follows from a mistake of the scene is not told beside it.
    causes = [(place, difference) for place, difference in found if difference.code != CODE]
    for place, difference in causes or found:
        key = (difference.what, difference.origin, place.link)
        groups.setdefault(key, (difference, []))[1].append(turn.scene_idxs[place.number])
    for (_, _, link), (difference, scene_idxs) in groups.items():
        who = f"'{turn.entity.name}'" if link is None else f"link '{link}' of '{turn.entity.name}'"
        tell(sink, difference, who, sorted(set(scene_idxs)), turn.entity.origin)
