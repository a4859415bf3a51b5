"""Audit of a whole batch: entities by order, name and pose; which bodies are read how closely; differences as
diagnostics.
"""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from scenecc.backends.sapien.audit.articulations import ArticulationAudit, center_of_mass_reach, link_poses
from scenecc.backends.sapien.audit.bodies import BodyAudit, compare_bodies
from scenecc.backends.sapien.audit.comparison import (
    AUDIT_CODE,
    BatchComparison,
    BodyLocation,
    DifferenceGroups,
    format_value,
)
from scenecc.backends.sapien.audit.reference import ReferenceMeshes, cooking_differences, scene_differences
from scenecc.backends.sapien.engine import sapien
from scenecc.backends.sapien.preparation import PreparedArticulation
from scenecc.backends.sapien.properties import select_rows

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.audit.comparison import EngineDifference
    from scenecc.backends.sapien.audit.reference import EngineDefaults
    from scenecc.backends.sapien.batch import SceneBatch
    from scenecc.backends.sapien.preparation import PreparedEntity
    from scenecc.diagnostics import Sink


_get_name = sapien.Entity.get_name

LINK_TOLERANCE = 1e-5
"""How far a link may be from where it belongs, by its distance from the world's origin where that is beyond 1 m: the
engine goes from link to link in float32."""


class EntityColumn(NamedTuple):
    """What stands at one place of the build order, once for each scene that has it.

    Attributes:
        numbers: which bodies or articulations of the entity.
        objs: the `sapien.Entity` of each.
        poses: (·, 7) float32 of each; None: those of all bodies of the entity, which are read at once.
        tolerance: of poses; 0: to the bit.
        link: its name; None: a body.
    """

    turn: PreparedEntity
    numbers: Sequence[int]
    name: str
    objs: list[Any]
    poses: NDArray[np.float32] | None = None
    tolerance: float = 0.0
    link: str | None = None

    def place(self, body: int) -> BodyLocation:
        """Of one of `numbers`."""
        return BodyLocation(self.turn, self.numbers[body], self.turn.entity.origin, self.link)


def compare_entities(
    turns: Sequence[PreparedEntity],
    scenes: Sequence[Any],
    scene_idxs: Sequence[int],
    sweep: BatchComparison,
    *,
    every_name: bool,
) -> None:
    """That each scene holds the plan's entities and no others, in the plan's order, with their names and poses.

    `every_name`: in all scenes, not only in the first and the last (order and identity are looked at in all).
    """
    columns = [column for turn in turns for column in _entity_columns(turn)]
    number_of = {index: number for number, index in enumerate(scene_idxs)}
    scene = np.array(
        [number_of[column.turn.scene_idxs[number]] for column in columns for number in column.numbers], dtype=np.intp
    )
    entities: list[list[Any]] = [each.entities for each in scenes]
    if np.bincount(scene, minlength=len(scenes)).tolist() != list(map(len, entities)):
        _compare_counts(columns, entities, number_of, sweep)
        return
    # Entities come column by column here and scene by scene there; a stable sort by scene keeps the columns' order.
    order = np.argsort(scene, kind="stable")
    starts = np.cumsum([0, *(len(column.numbers) for column in columns)])

    def place(body: int) -> BodyLocation:
        which = int(np.searchsorted(starts, body, side="right")) - 1
        return columns[which].place(body - int(starts[which]))

    present = list(chain.from_iterable(entities))
    ordered = order.tolist()
    ends = (
        range(len(present)) if every_name else sorted({*range(len(entities[0])), *_last_scene(present, entities[-1])})
    )
    _compare_names(columns, present, ordered, ends, place, sweep)
    _compare_order(columns, present, ordered, place, sweep)
    # SAPIEN packs q, then p, of each entity of a scene in the order in which they were added.
    packed = np.concatenate([np.frombuffer(each.pack_poses(), dtype=np.float32).reshape(-1, 7) for each in scenes])
    found, wanted = packed[:, [4, 5, 6, 0, 1, 2, 3]], _expected_poses(columns)[order]
    tolerances = np.repeat([column.tolerance for column in columns], [len(column.numbers) for column in columns])[order]
    for i in _wrong_poses(found, wanted, tolerances).tolist():
        sweep.tell(place(int(order[i])), "pose", format_value(wanted[i]), format_value(found[i]))


def _entity_columns(turn: PreparedEntity) -> Iterator[EntityColumn]:
    if not isinstance(turn, PreparedArticulation):
        yield EntityColumn(turn, range(len(turn.rows)), turn.entity.name, turn.objs)
        return
    for part in turn.parts:
        numbers: list[int] = part.numbers.tolist()
        poses = link_poses(turn.entity, part.structure, part.rows)
        tolerance = LINK_TOLERANCE * center_of_mass_reach(turn.links[numbers[0]])
        for which, (link, pose) in enumerate(zip(part.structure.links, poses, strict=True)):
            objs = [turn.entities[number][which] for number in numbers]
            yield EntityColumn(turn, numbers, link.name, objs, pose, tolerance, link.name)


def _wrong_poses(
    found: NDArray[np.float32], wanted: NDArray[np.float32], tolerances: NDArray[np.float64]
) -> NDArray[np.intp]:
    wrong = (found != wanted).any(axis=1)
    if tolerances.any():
        # A rotation has two quaternions, and the engine may hold either.
        sign = np.where((found[:, 3:] * wanted[:, 3:]).sum(axis=1) < 0, -1.0, 1.0)
        far = np.maximum(1.0, np.abs(wanted[:, :3]).max(axis=1))
        apart = np.maximum(
            np.abs(found[:, :3] - wanted[:, :3]).max(axis=1),
            np.abs(found[:, 3:] - sign[:, None] * wanted[:, 3:]).max(axis=1),
        )
        wrong &= (tolerances == 0) | ~(apart <= tolerances * far)
    return np.flatnonzero(wrong)


def _last_scene(present: list[Any], last: list[Any]) -> range:
    return range(len(present) - len(last), len(present))


def _compare_names(
    columns: Sequence[EntityColumn],
    present: list[Any],
    order: list[int],
    which: Sequence[int],
    place: Callable[[int], BodyLocation],
    sweep: BatchComparison,
) -> None:
    names = [name for column in columns for name in [column.name] * len(column.numbers)]
    for i in which:
        wanted, name = names[order[i]], _get_name(present[i])
        if wanted != name:
            sweep.tell(place(order[i]), "name at its place in the build order", repr(wanted), repr(name))


def _compare_order(
    columns: Sequence[EntityColumn],
    present: list[Any],
    order: list[int],
    place: Callable[[int], BodyLocation],
    sweep: BatchComparison,
) -> None:
    objs = list(chain.from_iterable(column.objs for column in columns))
    handed_out = [objs[body] for body in order]
    # Comparing lists looks at identity first, and needs no loop in Python for the usual case.
    if handed_out != present:
        for body, ours, entity in zip(order, handed_out, present, strict=True):
            if ours is not entity:
                sweep.tell(place(body), "entity", "the one of the batch", "another")


def _expected_poses(columns: Sequence[EntityColumn]) -> NDArray[np.float32]:
    """Of all entities, column by column; rounded at once for all that have one pose."""
    fixed = [(0.0,) * 7 if column.turn.entity.pose.varies else column.turn.entity.pose.as_drawn() for column in columns]
    counts = [len(column.numbers) for column in columns]
    poses = np.repeat(np.array(fixed).astype(np.float32), counts, axis=0)
    for column, end in zip(columns, np.cumsum(counts).tolist(), strict=True):
        if column.poses is not None:
            poses[end - len(column.numbers) : end] = column.poses
        elif column.turn.entity.pose.varies:
            poses[end - len(column.numbers) : end] = select_rows(column.turn.entity.pose, column.turn.rows)
    return poses


def _compare_counts(
    columns: Sequence[EntityColumn], entities: list[list[Any]], number_of: dict[int, int], sweep: BatchComparison
) -> None:
    counted: dict[int, list[tuple[PreparedEntity, int]]] = {}
    for column in columns:
        for number in column.numbers:
            counted.setdefault(column.turn.scene_idxs[number], []).append((column.turn, number))
    for index, bodies in counted.items():
        found = len(entities[number_of[index]])
        if found != len(bodies):
            turn, body = bodies[0]
            sweep.tell(BodyLocation(turn, body, None), "entities in the scene", len(bodies), found)


def audit_batch(
    batch: SceneBatch, turns: list[PreparedEntity], present: EngineDefaults, sink: Sink, level: Literal["full", "fast"]
) -> bool:
    """Compares what the engine holds with the plan, reports every difference, and says whether there is none.

    To be called before anything is stepped, and while the process-wide defaults are those of the build;
    `present` are the engine's as they were before the build set any.
    """
    plan, scenes = batch.plan, batch.scenes
    defaults = present.asked(plan.physics)
    told = DifferenceGroups(sink)
    settings = [(batch.scene_idxs[0], difference) for difference in cooking_differences(defaults)]
    for index, scene in zip(batch.scene_idxs, scenes if level == "full" else scenes[:1], strict=False):
        settings += [(index, difference) for difference in scene_differences(defaults, scene)]
    for index, difference in settings:
        origin = plan.physics.origin or plan.origin
        told.add("the scene", difference.words, index, origin, key=(difference.what, index))
    sweep = BatchComparison()
    if turns:
        _compare_objects(batch, turns, defaults, sweep, level)
    found: dict[str, list[tuple[BodyLocation, EngineDifference]]] = {}
    for place, difference in sweep.differences():
        found.setdefault(place.turn.entity.name, []).append((place, difference))
    for turn in turns:
        _tell_entity(told, turn, found.get(turn.entity.name, []))
    return told.report()


def _compare_objects(
    batch: SceneBatch,
    turns: list[PreparedEntity],
    defaults: EngineDefaults,
    sweep: BatchComparison,
    level: Literal["full", "fast"],
) -> None:
    meshes = ReferenceMeshes(batch.plan, defaults.material)
    bodies = BodyAudit(batch.plan, defaults, meshes, sweep, rendered=batch.render)
    compare_entities(turns, batch.scenes, batch.scene_idxs, sweep, every_name=level == "full")
    articulations = ArticulationAudit(bodies, defaults, meshes, sweep)
    for turn in turns:
        if isinstance(turn, PreparedArticulation):
            articulations.look_at(turn, every=level == "full")
            continue
        for part in turn.parts:
            closely = part.numbers if level == "full" else part.numbers[:1]
            for number in closely.tolist():
                bodies.look_at(turn, part.structure, number)
            if len(closely) < len(part.numbers) and part.structure.body_type != "none":
                components: list[Any] = [turn.components[number] for number in part.numbers]
                compare_bodies(turn, part, components, meshes, sweep)


def _tell_entity(
    told: DifferenceGroups, turn: PreparedEntity, found: list[tuple[BodyLocation, EngineDifference]]
) -> None:
    """One group a property and place."""
    # What follows from a mistake of the scene is not told beside it.
    causes = [(place, difference) for place, difference in found if difference.code != AUDIT_CODE]
    for place, difference in causes or found:
        who = f"'{turn.entity.name}'" if place.link is None else f"link '{place.link}' of '{turn.entity.name}'"
        told.add(
            who,
            difference.words,
            turn.scene_idxs[place.number],
            difference.origin or turn.entity.origin,
            key=(difference.what, difference.origin),
            code=difference.code,
        )
