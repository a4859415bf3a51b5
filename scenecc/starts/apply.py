"""Makes the scenes of a plan begin at the starts of a file, after comparing the scene with that of the file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut, index_ranges
from scenecc.errors import SceneError
from scenecc.plan.articulation import VELOCITY_FIELDS, ArticulationStructure
from scenecc.plan.properties import Quantity
from scenecc.plan.scene import Entity, SettledStart
from scenecc.plan.schema import ListKind, ObjectKind, UnionKind, plan_fields
from scenecc.plan.starts import StartTable, are_states, places_followers, start_parts
from scenecc.plan.value import per_scene
from scenecc.plan.walk import walk_fields
from scenecc.source.paths import Refusal, ResolvedFile, resolve_path
from scenecc.starts.file import InvalidStartsError, StartsFile, read_starts
from scenecc.starts.fingerprint import is_unrelated, other_versions, scene_differences
from scenecc.variation.evaluation import Batch, to_field_rows
from scenecc.variation.nodes import placements_read_by

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import Link, ScenePlan, Value
    from scenecc.plan.starts import StartPart
    from scenecc.source.paths import AssetScope
    from scenecc.starts.file import StartRecord
    from scenecc.variation.nodes import Node

    _Rows = dict[tuple[str, str | None], NDArray[np.float64]]
    """The poses of entities (joint None), and joint positions, by entity and joint."""

_SHOWN = 5
"""Most differences in one message."""


@dataclass(frozen=True, slots=True)
class KnownStarts:
    """A file of starts that was read and belongs to the scene.

    Attributes:
        name: of the file, for messages.
        content: the starts.
        place: where the file is named.
    """

    name: str
    content: StartsFile
    place: Origin | Location


def find_starts(
    written: str | None, given: Path | None, origin: Origin, scope: AssetScope, most: int, sink: Sink
) -> KnownStarts | None:
    """Reads the file of starts that a scene or an option names; None if that fails, which is reported.

    Args:
        written: the value of `starts` in the scene; None: it has none.
        given: the path in the option, relative to the current folder, which replaces it; None: not given.
        origin: of the key `starts`.
        scope: what may be read; receives the used files.
        most: maximum size of a file [bytes].
        sink: collects diagnostics.
    """
    place: Origin | Location = origin
    base = scope.root or Path.cwd()
    if given is not None:
        place, path = Location(str(given)), Path(os.path.abspath(given))  # noqa: PTH100 - keeps links
        scope.memory.note(ResolvedFile(path, str(given)), "--starts", "starts")
    else:
        found = resolve_path(written or "", base=base, scope=scope)
        if isinstance(found, Refusal):
            hint = found.hint or "make it with `scenecc settle`"
            sink.report(found.code, found.message, place, hint=hint)
            return None
        path = found.path
        scope.memory.note(found, origin.file or "", "starts")

    def find(table: str) -> Path:
        """Finds the table beside the file."""
        if given is not None:
            return path.parent / table
        found = resolve_path((Path(written or "").parent / table).as_posix(), base=base, scope=scope)
        if isinstance(found, Refusal):
            raise InvalidStartsError(f"its table is missing: {found.message}")
        scope.memory.note(found, path.name, "starts")
        return found.path

    name = cut(str(written if given is None else given), 200)
    try:
        return KnownStarts(name, read_starts(path, find, most), place)
    except InvalidStartsError as error:
        sink.report("SC935", f"`{name}` is not a valid file of starts: {error}", place)
    except OSError as error:
        which = name if error.filename in {None, str(path)} else Path(error.filename).name
        sink.report("SC935", f"`{which}` cannot be read: {error.strerror}", place)
    return None


def compare_starts(starts: KnownStarts, now: dict[str, Any], num_scenes: int, name: str, sink: Sink) -> None:
    """Reports whether the starts are of another scene, another number of scenes, or other versions.

    Args:
        starts: the starts.
        now: the fingerprint of the scene.
        num_scenes: number of scenes.
        name: name of the scene.
        sink: collects diagnostics.
    """
    was, of = starts.content.made_from, cut(starts.content.scene)
    is_chosen = any(row.chosen for row in starts.content.rows)
    found = scene_differences(was, now)
    versions = ", ".join(other_versions(was, now))
    made_with = f"`{starts.name}` was made with {versions}"
    if found and starts.content.scene != name and is_unrelated(was, now):
        hint = "name the starts of this scene; `scenecc settle` makes them"
        sink.report("SC936", f"`{starts.name}` has starts of another scene (`{of}`)", starts.place, hint=hint)
    elif found:
        shown = "; ".join([*found[:_SHOWN], *(["…"] if len(found) > _SHOWN else [])])
        hint = f"{'cover' if is_chosen else 'settle'} the scene again, or restore what changed" + (
            f"; {made_with}" if versions else ""
        )
        sink.report("SC936", f"the scene is not the one of `{starts.name}`: {shown}", starts.place, hint=hint)
    elif starts.content.num_scenes != num_scenes:
        known = starts.content.num_scenes
        message = f"`{starts.name}` was made with {known} scene{'s' * (known > 1)}, and {num_scenes} are built"
        hint = f"settle with `--num-scenes {num_scenes}`"
        hint = f"build with `--num-scenes {known}`, or set `num_scenes: {known}`" if is_chosen else hint
        sink.report("SC937", message, starts.place, hint=hint)
    elif versions:
        message = f"{made_with}: the scenes begin at the same poses, but may move differently from there"
        sink.report("SC936", message, starts.place, severity="warning")


def apply_starts(plan: ScenePlan, starts: KnownStarts, sink: Sink) -> ScenePlan | None:
    """Returns a plan that begins at the starts of its seed; None if there are none, which is reported."""
    rows = starts.content.rows
    if any(row.chosen for row in rows):
        return plan  # its values were chosen as they were drawn
    if _has_built_draws(plan):
        rows = [row for row in rows if row.seed == plan.seed]
    if not rows:
        seeds = sorted({row.seed for row in starts.content.rows})
        message = f"`{starts.name}` has no start with seed {plan.seed}, which determines what is built"
        hint = f"use one of its seeds ({index_ranges(seeds)}), or settle with `--seeds {plan.seed}:{plan.seed + 1}`"
        sink.report("SC937", message, starts.place, hint=hint)
        return None
    by_scene: dict[int, list[StartRecord]] = {}
    for row in rows:
        by_scene.setdefault(row.scene, []).append(row)
    made: list[SettledStart] = []
    for scene, records in by_scene.items():
        parts = list(start_parts(plan, scene)) if scene < plan.num_scenes else []
        states = _states(parts, records)
        if states is None or not are_states(parts, states):
            seeds = index_ranges(sorted(row.seed for row in records))
            message = f"the poses and joint positions of scene {scene} with seed {seeds} do not fit the scene"
            sink.report("SC935", f"`{starts.name}`: {message}", starts.place)
            return None
        made += [SettledStart(row.seed, scene, state.tobytes()) for row, state in zip(records, states, strict=True)]
    return _begin_at_starts(replace(plan, starts=tuple(made)))


def _states(parts: Sequence[StartPart], records: Sequence[StartRecord]) -> NDArray[np.float32] | None:
    """Returns the numbers of starts of one scene, a row for each; None if they have other entities or joints."""
    names = {entity.name: tuple(joint.name for joint in joints) for entity, _, joints in parts}
    jointed = {name: joints for name, joints in names.items() if joints}
    if any(row.poses.keys() != names.keys() or row.joints.keys() != jointed.keys() for row in records):
        return None
    if any({*row.joints[name]} != {*joints} for row in records for name, joints in jointed.items()):
        return None
    numbers = [
        [
            number
            for name, joints in names.items()
            for number in (*row.poses[name], *(row.joints[name][joint] for joint in joints))
        ]
        for row in records
    ]
    with np.errstate(over="ignore"):
        return np.array(numbers, np.float64).astype("<f4")


def require_starts(plan: ScenePlan, scene_idxs: Sequence[int] | None, sink: Sink) -> None:
    """Raises SceneError if scenes to build have no start, in a plan with starts. `scene_idxs`: None: all."""
    lacking = StartTable(plan).lacks(range(plan.num_scenes) if scene_idxs is None else scene_idxs)
    if lacking:
        are, who = ("scene {} has", "it") if len(lacking) == 1 else ("scenes {} have", "they")
        message = f"{are.format(index_ranges(lacking))} no start: {who} did not rest, or broke `expect`"
        hint = "build only the other scenes, or settle more seeds with `--seeds`"
        sink.report("SC937", message, plan.origin.child("starts") if plan.origin else Location(None), hint=hint)
        raise SceneError(sink.diagnostics())


def _has_built_draws(plan: ScenePlan) -> bool:
    """Returns whether anything that is simulated is drawn from the seed and kept by a reset, such as a size."""
    holders = (*plan.entities, *plan.constraints, *plan.physical_materials)
    return any(
        isinstance(kind, Quantity) and not value.known and value.recipe is None
        for holder in holders
        for path, kind, value in walk_fields(holder)
        if not path.startswith("visuals")
    )


def _begin_at_starts(plan: ScenePlan) -> ScenePlan:
    """Returns a plan whose values are those of its starts: everything that a reset draws, then poses and joints."""
    table = StartTable(plan)
    lacking = {*table.lacks(range(plan.num_scenes))}
    scenes = [scene for scene in range(plan.num_scenes) if scene not in lacking]
    seeds = table.seeds(scenes, [plan.seed] * len(scenes))
    if any(seed != plan.seed for seed in seeds):
        plan = _redrawn(plan, Batch(np.array(scenes), tuple(seeds), plan.num_scenes, dict(plan.draws), {}))
    rows: _Rows = {}
    for scene, seed in zip(scenes, seeds, strict=True):
        for (entity, row, active), pose, qpos in table.states(scene, seed):
            _rows_of(rows, entity, None, entity.pose)[row] = pose
            for joint, position in zip(active, qpos, strict=True):
                _rows_of(rows, entity, joint.name, joint.qpos)[row] = position
    return replace(plan, entities=tuple(_placed(entity, rows) for entity in plan.entities))


def _rows_of(rows: _Rows, entity: Entity, joint: str | None, value: Value | None) -> NDArray[np.float64]:
    """Returns the rows of a value, one for each scene of the entity; 0 for a joint position that is not set."""
    if (entity.name, joint) not in rows:
        data = np.zeros(1) if value is None else value.data
        rows[entity.name, joint] = np.repeat(data, len(entity.scene_idxs) // len(data), axis=0)
    return rows[entity.name, joint]


def _placed(entity: Entity, rows: _Rows) -> Entity:
    """Returns an entity with these poses and joint positions, at rest."""
    if (entity.name, None) not in rows:
        return entity
    structures: list[Any] = []
    for structure in entity.structures:
        still: dict[str, Any] = {
            name: value.with_data(np.zeros((len(entity.scene_idxs), 3)))
            for name in VELOCITY_FIELDS
            if (value := getattr(structure, name)) is not None
        }
        if isinstance(structure, ArticulationStructure):
            still["links"] = tuple(_with_position(entity.name, link, rows) for link in structure.links)
        structures.append(replace(structure, **still) if still else structure)
    return replace(entity, pose=entity.pose.with_data(rows[entity.name, None]), structures=tuple(structures))


def _with_position(entity: str, link: Link, rows: _Rows) -> Link:
    """Returns a link whose joint begins at its position."""
    joint = link.joint
    if joint is None or (entity, joint.name) not in rows:
        return link
    data = rows[entity, joint.name]
    return replace(
        link, joint=replace(joint, qpos=per_scene(data) if joint.qpos is None else joint.qpos.with_data(data))
    )


def _redrawn(plan: ScenePlan, batch: Batch) -> ScenePlan:
    """Returns a plan whose values that a reset redraws are those of the batch."""
    if places_followers(plan):
        from scenecc.placing.at_reset import place_anew  # noqa: PLC0415 - loaded where something is placed

        known = {
            one.name: (part, np.array([one.pose.row(one.scene_idxs.index(scene)) for scene in part]))
            for one in plan.entities
            if (part := [scene for scene in batch.scenes.tolist() if scene in one.scene_idxs])
        }
        place_anew(plan, batch, known)
    return _redraw(plan, batch)


def _redraw(node: Any, batch: Batch) -> Any:
    """Returns an object of the plan with its redrawn values, except the poses of placed entities: starts set them."""
    changed: dict[str, Any] = {}
    for slot in plan_fields(node.__class__):
        item = getattr(node, slot.name)
        if item is None:
            continue
        if isinstance(slot.kind, Quantity) and item.recipe is not None:
            if not (isinstance(node, Entity) and placements_read_by(item.recipe)):
                changed[slot.name] = _draw_value(item, item.recipe, batch)
        elif isinstance(slot.kind, ObjectKind | UnionKind):
            changed[slot.name] = _redraw(item, batch)
        elif isinstance(slot.kind, ListKind) and isinstance(slot.kind.item, ObjectKind | UnionKind):
            changed[slot.name] = tuple(_redraw(one, batch) for one in item)
    return replace(node, **changed) if changed else node


def _draw_value(value: Value, recipe: Node, batch: Batch) -> Value:
    row_of = {scene: row for row, scene in enumerate(value.scenes)}
    numbers = [number for number, scene in enumerate(batch.scenes.tolist()) if scene in row_of]
    if not numbers:
        return value
    part = batch.only(np.array(numbers, np.intp))
    data = np.repeat(value.data, len(row_of), axis=0) if len(value.data) == 1 else value.data.copy()
    data[[row_of[scene] for scene in part.scenes.tolist()]] = to_field_rows(part.evaluate(recipe))
    return value.with_data(data)
