"""Values that a reset redraws, besides poses, velocities, joints and targets: masses, gains, materials, lights and
cameras.

Each field of a plan with a recipe is looked up once, with its objects. A reset draws all of them before it sets any.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.live_properties import (
    ANGLE_TOLERANCE,
    ENTITY_POSE,
    LOCAL_POSE,
    MASS_AND_INERTIA,
    ROTATION_TOLERANCE,
    LiveProperty,
    live_property,
    read_all,
    set_all,
    stored_rows,
)
from scenecc.backends.sapien.objects import ArticulationObjects, BodyObjects, ComponentBatch, DrawnObjects
from scenecc.backends.sapien.preparation import StructureRows, group_by_structure
from scenecc.backends.sapien.properties import JOINT_FRAMES, rows_in_scenes
from scenecc.backends.sapien.reset import check_drawn_finite, part_in_scenes, sample_value
from scenecc.backends.sapien.state import DrawnFieldState
from scenecc.plan import ArticulationStructure, Value
from scenecc.plan.articulation import Joint
from scenecc.plan.body import BodyStructure, Inertial, PhysicalMaterial, VisualMaterial
from scenecc.plan.constraint import Constraint, Drive
from scenecc.plan.properties import Quantity
from scenecc.plan.rendering import Camera, Environment, Intrinsic, Light, Orthographic, Perspective
from scenecc.plan.schema import plan_fields

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.geometry.rotation_arrays import Floats
    from scenecc.plan import Entity, ScenePlan
    from scenecc.variation.evaluation import Batch


class Holder(NamedTuple):
    """A dataclass of the plan with its objects in the engine.

    Attributes:
        who: name for messages: "cube", "arm/finger", "lights/lamp".
        node: the dataclass.
        objs: scene index → engine object.
        rows: scene index → row of the plan's values.
        origin: of the node.
        moved: for a link, called with a scene after its centre of mass is set there.
        local: whether an unmounted camera's pose is set on its component, as in ManiSkill.
    """

    who: str
    node: Any
    objs: Mapping[int, Any]
    rows: Mapping[int, int]
    origin: Origin | None = None
    moved: Callable[[int], None] | None = None
    local: bool = False


@dataclass(frozen=True, slots=True)
class DrawnField:
    """A field that a reset redraws.

    Attributes:
        holder: has the field.
        name: of the plan's field.
        value: of the plan.
        quantity: its type.
        prop: its setter and getter.
        scenes: those that have it.
        densities: for a mass that scales an inertia, mass and inertia by density in each scene.
    """

    holder: Holder
    name: str
    value: Value
    quantity: Quantity
    prop: LiveProperty
    scenes: frozenset[int]
    densities: Mapping[Any, tuple[float, Any]]

    def objs(self, scenes: Sequence[int]) -> list[Any]:
        """Returns the objects of some scenes, in their order."""
        objs = self.holder.objs
        return list(objs.values()) if scenes == list(objs) else [objs[scene] for scene in scenes]

    @property
    def key(self) -> str:
        """Its key in a saved state."""
        return f"{self.holder.who}.{self.name}"

    @property
    def is_visual(self) -> bool:
        """Whether only a rendering batch has it."""
        return is_visual(self.holder)

    def draw(self, batch: Batch) -> FieldWrite:
        """Draws the value in the scenes of a batch, without setting it. All of these scenes must have the field.

        Raises:
            ValueError: the value is undefined or out of range.
        """
        assert self.value.recipe is not None
        who, what = self.holder.who, self.name
        drawn = sample_value(batch, self.value.recipe, who, what, cite=True)
        check_drawn_finite(drawn, batch, who, what)
        self._check_bounds(drawn, batch)
        return FieldWrite(self, batch.scenes.tolist(), self.engine_rows(drawn, batch.scenes.tolist()))

    def engine_rows(self, drawn: Floats, scenes: Sequence[int]) -> Floats:
        """Converts rows of the plan to the numbers that the engine receives."""
        if self.prop is not MASS_AND_INERTIA:
            return drawn
        masses, inertias = zip(*map(self.densities.__getitem__, self.objs(scenes)), strict=True)
        # In float64, and rounded once by the engine, as in a build.
        inertia = np.array(inertias) * (drawn / np.array(masses))[:, None]
        return np.concatenate((drawn[:, None], inertia), axis=1)

    def _check_bounds(self, drawn: Floats, batch: Batch) -> None:
        bounds = self.quantity.bounds
        wrong = (drawn < bounds.low) | (drawn > bounds.high)
        if bounds.nonzero:
            wrong |= drawn == 0
        if wrong.any():
            row = int(np.flatnonzero(wrong.reshape(len(drawn), -1).any(axis=1))[0])
            raise ValueError(
                f"'{self.holder.who}' in scene {int(batch.scenes[row])}: the drawn {self.name} is "
                f"{drawn[row].tolist()}, but must be {bounds}"
            )


class FieldWrite(NamedTuple):
    """New values of a field in some scenes: engine numbers, a row for each scene."""

    field: DrawnField
    scenes: list[int]
    rows: Floats

    def apply(self) -> None:
        """Sets the values."""
        prop, holder = self.field.prop, self.field.holder
        rows = self.rows if self.field.quantity.dtype != "bool" else self.rows != 0
        set_all(prop, self.field.objs(self.scenes), rows)
        if holder.moved is not None and self.field.name == "com":
            for scene in self.scenes:
                holder.moved(scene)

    def read(self) -> NDArray[np.float32]:
        """Returns what the engine holds, (B, n)."""
        return read_all(self.field.prop, self.field.objs(self.scenes))

    def differing(self) -> list[tuple[int, Floats, Floats]]:
        """Returns the scenes in which the engine holds other values, with the wanted and the found values."""
        found, wanted = self.read(), stored_rows(self.field.prop, self.rows)
        if self.field.prop.stored == "pose":
            sign = np.where((found[:, 3:] * wanted[:, 3:]).sum(axis=1) < 0, np.float32(-1), np.float32(1))
            near = np.abs(found[:, 3:] * sign[:, None] - wanted[:, 3:]) <= ROTATION_TOLERANCE
            same = (found[:, :3] == wanted[:, :3]).all(axis=1) & near.all(axis=1)
        elif self.field.prop.stored == "angle":
            same = (np.abs(found - wanted) <= ANGLE_TOLERANCE * wanted).all(axis=1)
        else:
            same = (found == wanted).all(axis=1)
        return [(self.scenes[row], wanted[row], found[row]) for row in np.flatnonzero(~same).tolist()]


class DrawnFieldSet:
    """The fields of a batch that a reset redraws. `rendered`: include visual fields."""

    def __init__(self, holders: Iterable[Holder], drawn: DrawnObjects, *, rendered: bool) -> None:
        self._rendered = rendered
        self._fields = [one for holder in holders for one in _drawn_fields(holder, drawn)]
        # Scenes of each field, and the last values given in each.
        self._scenes = [sorted(one.scenes) for one in self._fields]
        self._given = list(map(self._read_built_rows, self._fields, self._scenes))

    def __len__(self) -> int:
        return len(self._fields)

    @staticmethod
    def _read_built_rows(one: DrawnField, scenes: list[int]) -> Floats:
        rows = np.array([one.value.row(one.holder.rows[scene]) for scene in scenes], np.float64)
        return one.engine_rows(rows, scenes)

    def draw(self, batch: Batch) -> list[FieldWrite]:
        """Draws all fields in the scenes of a batch, without setting them.

        Raises:
            ValueError: a value is undefined or out of range; the message names holder, field and scene.
        """
        parts: dict[frozenset[int], Batch | None] = {}
        writes: list[FieldWrite] = []
        for one in self._fields:
            if one.scenes not in parts:
                parts[one.scenes] = part_in_scenes(batch, one.scenes)
            part = parts[one.scenes]
            if part is not None:
                writes.append(one.draw(part))
        _check_rules(writes)
        return writes

    def apply(self, writes: Sequence[FieldWrite]) -> None:
        """Sets values that were drawn or saved."""
        number_of = {id(one): number for number, one in enumerate(self._fields)}
        for write in writes:
            write.apply()
            number = number_of[id(write.field)]
            if write.scenes == self._scenes[number]:
                self._given[number] = write.rows
            else:
                whole = self._given[number] = self._given[number].copy()
                whole[np.searchsorted(self._scenes[number], write.scenes)] = write.rows

    def state(self, scene_idxs: Sequence[int]) -> dict[str, DrawnFieldState]:
        """Returns the values of all fields in some scenes, by their keys in a saved state."""
        found: dict[str, DrawnFieldState] = {}
        for one, mine, given in zip(self._fields, self._scenes, self._given, strict=True):
            scenes = [scene for scene in scene_idxs if scene in one.scenes]
            if not scenes:
                continue
            write = FieldWrite(one, scenes, given[np.searchsorted(mine, scenes)])
            # A value that was set by hand since then is only in the engine.
            for scene, _, there in write.differing():
                write.rows[scenes.index(scene)] = there.reshape(write.rows.shape[1:])
            # Each variant of an entity has the field in its own scenes.
            other = found.get(one.key, DrawnFieldState((), write.rows[:0]))
            scenes = [*other.scene_idxs, *scenes]
            order = np.argsort(scenes)
            rows = np.concatenate((other.numbers, write.rows))[order]
            found[one.key] = DrawnFieldState(tuple(np.array(scenes)[order].tolist()), rows, is_visual(one.holder))
        return found

    def saved(self, state: Mapping[str, DrawnFieldState], scene_idxs: Sequence[int]) -> list[FieldWrite]:
        """Returns the writes that restore a state in some scenes.

        Raises:
            ValueError: the state is of another plan.
        """
        writes: list[FieldWrite] = []
        for one, given in zip(self._fields, self._given, strict=True):
            scenes, there = sorted(one.scenes.intersection(scene_idxs)), state.get(one.key)
            if not scenes or (there is None and is_visual(one.holder)):
                # The state of a batch without rendering has no visual fields.
                continue
            row_of = {} if there is None else {scene: row for row, scene in enumerate(there.scene_idxs)}
            if there is None or not row_of.keys() >= set(scenes):
                raise ValueError(f"the state is of another plan: '{one.key}', which a reset draws, is missing")
            shape = given.shape[1:]
            if there.numbers.shape[1:] != shape or not np.isfinite(there.numbers).all():
                raise ValueError(f"'{one.key}' must be finite numbers ({len(there.scene_idxs)}, *{shape})")
            writes.append(FieldWrite(one, scenes, there.numbers[[row_of[scene] for scene in scenes]]))
        known = {one.key for one in self._fields}
        unknown = [key for key, there in state.items() if key not in known and (self._rendered or not there.seen)]
        if unknown:
            raise ValueError(f"the state is of another plan: a reset of this plan does not draw '{min(unknown)}'")
        return writes


def is_visual(holder: Holder) -> bool:
    """Returns whether a holder exists only if the batch renders."""
    return isinstance(holder.node, _SEEN)


_SEEN = VisualMaterial | Light | Camera | Perspective | Intrinsic | Orthographic | Environment


def drawn_names(holders: Iterable[Holder]) -> list[str]:
    """Returns the keys of all fields of some holders that a reset redraws."""
    return [
        f"{holder.who}.{slot.name}"
        for holder in holders
        for slot in plan_fields(holder.node.__class__)
        if isinstance(value := getattr(holder.node, slot.name), Value)
        and value.recipe is not None
        and live_property(holder.node, slot.name) is not None
    ]


def _drawn_fields(found: Holder, drawn: DrawnObjects) -> Iterator[DrawnField]:
    for slot in plan_fields(found.node.__class__):
        holder, value = found, getattr(found.node, slot.name)
        if isinstance(value, Value) and value.recipe is not None and isinstance(slot.kind, Quantity):
            prop = live_property(holder.node, slot.name)
            if prop is ENTITY_POSE and holder.local:
                prop = LOCAL_POSE
            elif prop is ENTITY_POSE:
                holder = holder._replace(objs={scene: obj.get_entity() for scene, obj in holder.objs.items()})
            if prop is not None and holder.objs:
                scenes = frozenset(holder.objs)
                yield DrawnField(holder, slot.name, value, slot.kind, prop, scenes, drawn.densities)


class _Rule(NamedTuple):
    """A condition between fields of one holder that must hold for every draw."""

    fields: tuple[str, ...]
    holds: Callable[..., NDArray[np.bool_]]
    words: str


def _has_ordered_limits(limits: Floats) -> NDArray[np.bool_]:
    return limits[:, 0] <= limits[:, 1]


def _is_inertia(moments: Floats) -> NDArray[np.bool_]:
    return 2 * moments.max(axis=1) <= moments.sum(axis=1) * (1 + 1e-9)


_RULES: dict[type, _Rule] = {
    PhysicalMaterial: _Rule(
        ("dynamic_friction", "static_friction"), np.less_equal, "the drawn dynamic friction exceeds the static friction"
    ),
    Joint: _Rule(("limits",), _has_ordered_limits, "the drawn lower limit exceeds the upper limit"),
    Inertial: _Rule(("inertia",), _is_inertia, "a drawn moment of inertia exceeds the sum of the others"),
    Camera: _Rule(("near", "far"), np.less, "the drawn near plane is not in front of the far plane"),
}


def _check_rules(writes: Sequence[FieldWrite]) -> None:
    """Raises ValueError if drawn fields violate a condition."""
    by_node: dict[int, dict[str, FieldWrite]] = {}
    for write in writes:
        if type(write.field.holder.node) in _RULES:
            by_node.setdefault(id(write.field.holder.node), {})[write.field.name] = write
    for drawn in by_node.values():
        one = next(iter(drawn.values()))
        holder, rule = one.field.holder, _RULES[type(one.field.holder.node)]
        if drawn.keys().isdisjoint(rule.fields):
            continue
        rows = [holder.rows[scene] for scene in one.scenes]
        columns = [
            drawn[name].rows if name in drawn else np.array([getattr(holder.node, name).row(row) for row in rows])
            for name in rule.fields
        ]
        wrong = np.flatnonzero(~rule.holds(*columns))
        if wrong.size:
            raise ValueError(f"'{holder.who}' in scene {one.scenes[wrong[0]]}: {rule.words}")


def plan_holders(
    plan: ScenePlan,
    scene_idxs: tuple[int, ...],
    objects: Mapping[str, BodyObjects | ArticulationObjects],
    drawn: DrawnObjects,
    components: Mapping[str, ComponentBatch],
    render_systems: Mapping[int, Any],
) -> Iterator[Holder]:
    """Yields everything in a plan that has fields that a reset may redraw, with its objects.

    `components` are constraints, lights and cameras, by section and name: "lights/lamp".
    """
    for entity in plan.entities:
        present, rows = rows_in_scenes(entity, scene_idxs)
        if not present:
            continue
        for part in group_by_structure(entity, rows):
            row_of = _rows_by_scene(present, part)
            yield from _structure_holders(entity.name, part.structure, row_of, objects[entity.name])
    yield from _material_holders(plan, drawn)
    for section, nodes in (("constraints", plan.constraints), ("lights", plan.lights), ("cameras", plan.cameras)):
        for node in nodes:
            if f"{section}/{node.name}" in components:
                yield from component_holders(section, node, components[f"{section}/{node.name}"])
    around = plan.environment
    if around is not None and render_systems:
        rows = {scene: scene for scene in render_systems}
        yield Holder("environment", around, render_systems, rows, around.origin)


def _rows_by_scene(scene_idxs: tuple[int, ...], part: StructureRows[Any]) -> dict[int, int]:
    numbers: list[int] = part.numbers.tolist()
    rows: list[int] = part.rows.tolist()
    return {scene_idxs[number]: row for number, row in zip(numbers, rows, strict=True)}


def _structure_holders(
    who: str,
    structure: BodyStructure | ArticulationStructure,
    rows: Mapping[int, int],
    objects: BodyObjects | ArticulationObjects,
) -> Iterator[Holder]:
    if isinstance(objects, ArticulationObjects):
        assert isinstance(structure, ArticulationStructure)
        for number, link in enumerate(structure.links):
            links = {scene: objects.links[objects.row_of[scene]][number] for scene in rows}
            moved = partial(_set_joint_frames, structure, number, rows, objects)
            yield from _body_holders(f"{who}/{link.name}", link.body, links, rows, moved)
            if link.joint is not None and link.joint.type != "fixed":
                joints = {scene: obj.get_joint() for scene, obj in links.items()}
                yield Holder(f"{who}/{link.joint.name or link.name}", link.joint, joints, rows, link.joint.origin)
        return
    assert isinstance(structure, BodyStructure)
    if structure.body_type not in {"static", "none"}:
        components = {scene: objects.components[objects.row_of[scene]] for scene in rows}
        yield from _body_holders(who, structure, components, rows)


def _set_joint_frames(
    structure: ArticulationStructure, number: int, rows: Mapping[int, int], objects: ArticulationObjects, scene: int
) -> None:
    """Sets the frames of the joints at a link again, because the engine stores them relative to the centre of mass."""
    links, row = objects.links[objects.row_of[scene]], np.array([rows[scene]])
    for other, link in enumerate(structure.links):
        if link.joint is not None and number in {other, link.parent}:
            for name, frame in JOINT_FRAMES.items():
                frame.set(links[other].get_joint(), frame.column(getattr(link.joint, name), row)[0])


def _body_holders(
    who: str,
    body: BodyStructure,
    objs: Mapping[int, Any],
    rows: Mapping[int, int],
    moved: Callable[[int], None] | None = None,
) -> Iterator[Holder]:
    yield Holder(who, body, objs, rows, body.origin, moved)
    if body.inertial is not None:
        yield Holder(f"{who}.inertial", body.inertial, objs, rows, body.origin, moved)


def _material_users(plan: ScenePlan, drawn: DrawnObjects) -> dict[tuple[str, int], Entity]:
    """Returns the first entity that has each of the drawn materials, because their rows are its scenes'."""
    users: dict[tuple[str, int], Entity] = {}
    for entity in plan.entities if drawn.physical or drawn.visual else ():
        for body in entity.bodies:
            shapes = [("physical", shape) for shape in body.collisions] + [("visual", shape) for shape in body.visuals]
            for kind, shape in shapes:
                for index in () if shape.material is None else np.unique(shape.material.data).tolist():
                    users.setdefault((kind, index), entity)
    return users


def _material_holders(plan: ScenePlan, drawn: DrawnObjects) -> Iterator[Holder]:
    users = _material_users(plan, drawn)
    kinds = (("physical", plan.physical_materials, drawn.physical), ("visual", plan.visual_materials, drawn.visual))
    for kind, table, made in kinds:
        for index, objs in made.items():
            entity = users[kind, index]
            rows = {scene: row for row, scene in enumerate(entity.scene_idxs)}
            yield Holder(f"{entity.name}/{kind} material {index}", table[index], objs, rows, entity.origin)


def component_holders(section: str, node: Constraint | Light | Camera, batch: ComponentBatch) -> Iterator[Holder]:
    """Yields the parts of a constraint, light or camera with fields that a reset may redraw."""
    objs = {scene: obj for scene, obj in zip(batch.scene_idxs, batch.objs, strict=True) if obj is not None}
    rows = {scene: row for row, scene in enumerate(node.scene_idxs)}
    who = f"{section}/{node.name}"
    yield Holder(who, node, objs, rows, node.origin)
    if isinstance(node, Constraint):
        for drive in node.joint.drives if isinstance(node.joint, Drive) else ():
            yield Holder(f"{who}.drive.{drive.axis}", drive, objs, rows, node.origin)
    if isinstance(node, Camera):
        yield Holder(f"{who}.lens", node.lens, objs, rows, node.origin)
