"""A document's models to the plan of its scenes."""

from __future__ import annotations

from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.lower.bodies import Bodies
from scenecc.lower.bounds import BoundedRobots, Bounds, built_within, within
from scenecc.lower.drawing import Drawing
from scenecc.lower.draws import lower_draws
from scenecc.lower.draws import report_unused as report_unused_draws
from scenecc.lower.entities import Entities
from scenecc.lower.fastened import Seen, lower_seen
from scenecc.lower.groups import allot
from scenecc.lower.materials import SAPIEN_DEFAULT, Materials
from scenecc.lower.names import WORLD, Names
from scenecc.lower.shapes import Shapes
from scenecc.lower.tables import FileResolver, Tables
from scenecc.plan import Friction, GpuMemory, Physics, ScenePlan, SdfConfig
from scenecc.spec.known import SHARED_NAMES
from scenecc.variation.compute_limit import COMPUTE_LIMIT_HINT

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.articulations.articulations import Articulations
    from scenecc.lower.articulations.reader import RobotReader
    from scenecc.lower.groups import Bits
    from scenecc.lower.placing.places import Places
    from scenecc.plan import Constraint, Entity
    from scenecc.spec.document import SceneFile
    from scenecc.spec.physics import Physics as PhysicsKeys


@frozen
class Lowered:
    """A plan, and what its draw stage and its checks have to know.

    Attributes:
        plan: whose values are not drawn yet, and have no recipes.
        file_origins: for each file, the first place that names it.
        material_origins: for each physical material, the first place that asks for it.
        drawing: the draws, and the values that only their rows can be judged by.
        places: where its entities stand.
    """

    plan: ScenePlan
    file_origins: Mapping[int, Origin]
    material_origins: Mapping[int, Origin]
    drawing: Drawing
    places: Places


_AS_WRITTEN = Names()


def lower(
    scene: SceneFile,
    *,
    name: str,
    num_scenes: int,
    seed: int,
    origin: Origin,
    resolve: FileResolver,
    robots: RobotReader,
    bounds: Bounds,
    sink: Sink,
    names: Names = _AS_WRITTEN,
    selections: Mapping[str, tuple[int, ...]] | None = None,
    draws: Mapping[str, Any] | None = None,
) -> Lowered | None:
    """The plan of a batch; None where anything was reported as an error. Nothing is drawn: that is `draw`'s.

    Args:
        scene: the document, expanded where it has anything to expand.
        name: of the plan, where the document gives none.
        num_scenes: how many scenes; the document's unless overridden.
        seed: of every draw; likewise.
        origin: of the document's root.
        resolve: finds the files that it names.
        robots: reads those of robots.
        bounds: limits.
        sink: takes the diagnostics.
        names: what its names mean, where it has instances.
        selections: the scenes of the entities and frames that instances narrow.
        draws: arrays, (num_scenes,) or (num_scenes, k), that take the place of shared draws.
    """
    narrowed = selections or {}
    if not within(scene, num_scenes, narrowed, bounds, origin, sink):
        return None
    _names(scene, origin, sink)
    drawing = Drawing(seed, num_scenes, sink, bounds.computed)
    lower_draws(scene.draws, draws or {}, drawing, names, narrowed, origin.child("draws"))
    physics = _physics(scene.physics, origin.child("physics"))
    tables = Tables(resolve)
    default = physics.default_material or SAPIEN_DEFAULT
    materials = Materials(scene.materials, tables, default, origin.child("materials"), sink)
    groups = allot(scene.collision_groups, origin.child("collision_groups"), sink)
    shapes = Shapes(tables, materials, sink)
    bounded = BoundedRobots(robots, bounds.objects, sink)
    articulations = partial(_articulations, scene, tables, shapes, materials, groups, bounded.read, sink)
    entities = Entities(scene, narrowed, drawing, names, origin, sink)
    built = entities.lower(Bodies(shapes, materials, groups, sink), articulations)
    if bounded.exhausted or not built_within(entities.linked, bounds, origin, sink):
        return None
    seen = lower_seen(scene, built, entities, names, tables, materials, drawing.leaves(), origin, sink)
    constraints = _constraints(scene, built, entities, drawing, names, origin)
    if sink.failed:
        # A material may be unused only because its name was misspelt where it was meant.
        return None
    if drawing.foreseen.exhausted:
        sink.report("SC609", drawing.foreseen.message, origin, hint=COMPUTE_LIMIT_HINT)
        return None
    materials.report_unused(frozenset(names.used_materials), drawing.leaves())
    report_unused_draws(scene.draws, drawing, names, origin.child("draws"))
    if sink.failed:
        return None
    plan = _plan(scene, name, built, constraints, seen, physics, tables, drawing, origin)
    return Lowered(plan, tables.file_origins, tables.material_origins, drawing, entities.places)


def _articulations(
    scene: SceneFile,
    tables: Tables,
    shapes: Shapes,
    materials: Materials,
    groups: dict[str, Bits],
    robots: RobotReader,
    sink: Sink,
) -> Articulations:
    from scenecc.lower.articulations.articulations import Articulations  # noqa: PLC0415 - loaded where there are any

    return Articulations(scene.entities, tables, shapes, materials, groups, robots, sink)


def _constraints(
    scene: SceneFile, built: tuple[Entity, ...], entities: Entities, drawing: Drawing, names: Names, origin: Origin
) -> tuple[Constraint, ...]:
    if not scene.constraints:
        return ()
    from scenecc.lower.constraints import Constraints  # noqa: PLC0415 - loaded where there are any
    from scenecc.lower.mounts import Mounts  # noqa: PLC0415 - likewise

    mounts = Mounts(built, entities.places.unread, names, drawing.sink)
    lowering = Constraints(built, entities, mounts, drawing, names, drawing.sink)
    return lowering.lower(scene.constraints, origin.child("constraints"))


def _plan(
    scene: SceneFile,
    name: str,
    entities: tuple[Entity, ...],
    constraints: tuple[Constraint, ...],
    seen: Seen,
    physics: Physics,
    tables: Tables,
    drawing: Drawing,
    origin: Origin,
) -> ScenePlan:
    """The plan of what was lowered. `name`: where the document gives none."""
    return ScenePlan(
        name=scene.name or name,
        description=scene.description,
        num_scenes=drawing.num_scenes,
        seed=drawing.seed,
        entities=entities,
        constraints=constraints,
        environment=seen.environment,
        lights=seen.lights,
        cameras=seen.cameras,
        physics=physics,
        files=tables.files.rows,
        physical_materials=tables.physical_materials.rows,
        visual_materials=tables.visual_materials.rows,
        origin=origin,
    )


def _names(scene: SceneFile, origin: Origin, sink: Sink) -> None:
    """Frames, entities and cameras share one namespace, and nothing is called like the world."""
    sections: dict[str, Mapping[str, Any]] = {section: getattr(scene, section) for section in _ONES}
    for section, names in sections.items():
        if WORLD in names:
            sink.report("SC306", "`world` is the world's own name", origin.child(section, WORLD), at="key")
    for first, second in combinations(SHARED_NAMES, 2):
        for name in sections[first].keys() & sections[second].keys():
            sink.report(
                "SC305",
                f"`{name}` names {_ONES[first]} and {_ONES[second]}",
                origin.child(second, name),
                at="key",
                related=[(f"the {_ONES[first].partition(' ')[2]}", origin.child(first, name), "key")],
            )


_ONES = {
    "frames": "a frame",
    "entities": "an entity",
    "cameras": "a camera",
    "constraints": "a constraint",
    "lights": "a light",
}
"""What a thing of each section is called."""


def _physics(given: PhysicsKeys | None, origin: Origin) -> Physics:
    """The same keys; those left out stay None."""
    if given is None:
        return Physics(origin=origin)
    values = {name: getattr(given, name) for name in type(given).model_fields}
    if given.default_material is not None:
        values["default_material"] = Friction(**given.default_material.model_dump())
    if given.sdf is not None:
        values["sdf"] = SdfConfig(**given.sdf.model_dump())
    if given.gpu_memory is not None:
        values["gpu_memory"] = GpuMemory(**given.gpu_memory.model_dump())
    return Physics(**values, origin=origin)
