"""Constraints in live scenes: SAPIEN's components and their setters, their batches, and their targets at a reset."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.live_properties import components_of, set_enabled
from scenecc.backends.sapien.objects import ComponentBatch, is_dynamic
from scenecc.backends.sapien.properties import Column, select_rows, to_poses, to_scalars, to_vectors, zip_columns
from scenecc.backends.sapien.reset import check_drawn_finite, part_in_scenes, sample_value
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import Connection, Distance, Drive, Gear, Weld, literal
from scenecc.plan.constraint import WELD_SWING, ConstraintJoint, colliding_constraints, component_joints
from scenecc.plan.properties import FLOAT32_MAX

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.preparation import EntityLookup
    from scenecc.plan import Constraint, ScenePlan, Value
    from scenecc.variation.evaluation import Batch
    from scenecc.variation.nodes import Node

_COMPONENTS: dict[type, Any] = {
    Weld: physx.PhysxDriveComponent,
    Drive: physx.PhysxDriveComponent,
    Connection: physx.PhysxDistanceJointComponent,
    Distance: physx.PhysxDistanceJointComponent,
    Gear: physx.PhysxGearComponent,
}

_IDENTITY = literal(IDENTITY_POSE)

_ZERO = literal(0.0)

_UNLIMITED = literal(FLOAT32_MAX)


@dataclass(frozen=True, slots=True)
class SetterCall:
    """A call of an engine's setter.

    Attributes:
        set: name of the setter.
        rows: its arguments, one tuple for all scenes or one for each.
    """

    set: str
    rows: list[tuple[Any, ...]]

    def arguments(self, number: int) -> tuple[Any, ...]:
        """Returns the arguments for the scene with this number among those that are built."""
        return self.rows[0 if len(self.rows) == 1 else number]


class PreparedConstraint:
    """A constraint, prepared for the built scenes that have it.

    Attributes:
        constraint: of the plan.
        scene_idxs: the scenes, ascending.
        rows: their rows in the plan's values.
        calls: what to set on each of its components once it is in its entity, in order.
    """

    def __init__(self, constraint: Constraint, scene_idxs: tuple[int, ...]) -> None:
        having = {index: row for row, index in enumerate(constraint.scene_idxs)}
        self.constraint = constraint
        self.scene_idxs = tuple(index for index in scene_idxs if index in having)
        self.rows = np.array([having[index] for index in self.scene_idxs], dtype=np.intp)
        enabled = literal(1, "bool") if constraint.enabled is None else constraint.enabled
        self.enabled: list[bool] = select_rows(enabled, self.rows).tolist()
        self.in_parent = self._poses(constraint.pose_in_parent)
        self.in_child = self._poses(constraint.pose_in_child)
        joints = component_joints(constraint.joint) if self.scene_idxs else ()
        self.calls = [list(_joint_calls(joint, self.rows)) for joint in joints]

    def _poses(self, value: Value | None) -> Column:
        return to_poses(select_rows(_IDENTITY if value is None else value, self.rows))

    def build(self, lookup: EntityLookup) -> list[Any]:
        """Makes the components of each scene in its child's entity, as `sapien.Scene.create_drive` does.

        Returns the first of each scene.
        """
        number_of = {index: number for number, index in enumerate(lookup.scene_idxs)}
        made = [
            [self._make_component(lookup, number_of[index], row, calls) for calls in self.calls]
            for row, index in enumerate(self.scene_idxs)
        ]
        return [first for first, *_ in made]

    def _make_component(self, lookup: EntityLookup, number: int, row: int, calls: Sequence[SetterCall]) -> Any:
        constraint = self.constraint
        component = _COMPONENTS[type(constraint.joint)](lookup.component(constraint.child, number))
        component.set_name(constraint.name)
        if constraint.parent is not None:
            component.set_parent(lookup.component(constraint.parent, number))
        component.set_pose_in_child(self.in_child[row % len(self.in_child)])
        component.set_pose_in_parent(self.in_parent[row % len(self.in_parent)])
        lookup.entity(constraint.child, number).add_component(component)
        for call in calls:
            getattr(component, call.set)(*call.arguments(row))
        if not self.enabled[row % len(self.enabled)]:
            component.disable()
        return component


def _joint_calls(joint: ConstraintJoint, rows: NDArray[np.intp]) -> Iterator[SetterCall]:
    match joint:
        case Weld():
            for axis in ("x", "y", "z", "twist"):
                yield SetterCall(f"set_limit_{axis}", [(0.0, 0.0, 0.0, 0.0)])
            swing = (*WELD_SWING, FLOAT32_MAX, "acceleration")
            yield SetterCall("set_drive_property_swing", [swing])
        case Connection():
            yield SetterCall("set_limit", [(0.0, 0.0)])
        case Distance(limits, stiffness, damping):
            yield SetterCall("set_limit", _limit_columns(limits, stiffness, damping, rows))
        case Gear(ratio, enable_hinges):
            yield SetterCall("set_gear_ratio", zip_columns([_scalar_column(ratio, rows)]))
            if enable_hinges:
                yield SetterCall("enable_hinges", [()])
        case Drive() as drive:
            yield from _drive_calls(drive, rows)


def _drive_calls(drive: Drive, rows: NDArray[np.intp]) -> Iterator[SetterCall]:
    for limit in drive.limits:
        arguments = _limit_columns(limit.limits, limit.stiffness, limit.damping, rows)
        yield SetterCall(f"set_limit_{limit.axis}", arguments)
    for each in drive.drives:
        values = (each.stiffness, each.damping, each.force_limit or _UNLIMITED)
        columns: list[Column] = [*(_scalar_column(value, rows) for value in values), [each.mode or "force"]]
        yield SetterCall(f"set_drive_property_{each.axis}", zip_columns(columns))
    yield from _target_calls(drive, lambda field: _target_rows(drive, field, rows))
    for name in ("inv_mass_scales", "inv_inertia_scales"):
        value: Value | None = getattr(drive, name)
        if value is not None:
            yield SetterCall(f"set_{name}", list(map(tuple, select_rows(value, rows).tolist())))


_TARGET_DEFAULTS: dict[str, Value] = {
    "target": _IDENTITY,
    "linear_velocity_target": literal((0.0, 0.0, 0.0)),
    "angular_velocity_target": literal((0.0, 0.0, 0.0)),
}
"""Targets of `Drive`, with the engine's defaults."""


def _target_rows(drive: Drive, field: str, rows: NDArray[np.intp]) -> NDArray[Any]:
    return select_rows(getattr(drive, field) or _TARGET_DEFAULTS[field], rows)


def _target_calls(drive: Drive, read: Callable[[str], NDArray[Any]], *, every: bool = False) -> Iterator[SetterCall]:
    """Yields calls that set a drive's targets. `read`: returns a field's rows; `every`: also for unset fields."""
    if every or drive.target is not None:
        yield SetterCall("set_drive_target", zip_columns([to_poses(read("target"))]))
    if every or drive.linear_velocity_target is not None or drive.angular_velocity_target is not None:
        velocities = [to_vectors(read(f"{kind}_velocity_target")) for kind in ("linear", "angular")]
        yield SetterCall("set_drive_velocity_target", zip_columns(velocities))


def _scalar_column(value: Value, rows: NDArray[np.intp]) -> Column:
    return to_scalars(select_rows(value, rows))


def _limit_columns(
    limits: Value, stiffness: Value | None, damping: Value | None, rows: NDArray[np.intp]
) -> list[tuple[Any, ...]]:
    pairs = select_rows(limits, rows)
    spring = [_scalar_column(value or _ZERO, rows) for value in (stiffness, damping)]
    return zip_columns([to_scalars(pairs[:, 0]), to_scalars(pairs[:, 1]), *spring])


TargetCalls = list[tuple[Any, str, tuple[Any, ...]]]
"""Components, their setters and the arguments."""


class ConstraintBatch(ComponentBatch):
    """One constraint of the plan, in every scene that has it.

    `objs` are `sapien.physx.PhysxDriveComponent`s of a weld or a drive, `PhysxDistanceJointComponent`s of a connection
    or a distance, and `PhysxGearComponent`s of a gear. A hinge whose drive has a stiffness has two components of its
    name in each entity; these are the first, and the second holds its axis.
    """

    @property
    def enabled(self) -> NDArray[np.bool_]:
        """(B,) whether the constraint is active in each of its scenes. Assign one flag, or one for each scene.

        SAPIEN's `enable` and `disable` add PhysX's joint to the simulation and remove it. A change wakes the bodies. A
        reset sets the flag only if it is drawn.

        Raises:
            RuntimeError: the scenes are closed. ValueError: flags of a wrong shape or type.
        """
        return np.array([component.is_enabled for component in self.objs], dtype=np.bool_)

    @enabled.setter
    def enabled(self, flags: Any) -> None:
        rows = np.asarray(flags)
        if rows.dtype != np.bool_ or rows.shape not in ((), (1,), (len(self),)):
            raise ValueError(f"enabled must be true or false, or ({len(self)},) of these, not {flags!r}"[:200])
        for component, flag in zip(self.objs, np.broadcast_to(rows, len(self)).tolist(), strict=True):
            if flag != component.is_enabled:
                set_enabled(component, flag)
                for body in _bodies_of(component):
                    body.wake_up()

    def in_scene(self, scene_idx: int) -> Any:
        """Returns the component in a scene of the plan, or None. Raises RuntimeError once closed."""
        return self.objs[self._scene_idxs.index(scene_idx)] if scene_idx in self._scene_idxs else None


def _bodies_of(component: Any) -> Iterator[Any]:
    """Yields the bodies of a component that PhysX can put to sleep."""
    own = (one for one in component.get_entity().components if isinstance(one, physx.PhysxRigidBodyComponent))
    for body in (*own, component.get_parent()):
        if isinstance(body, physx.PhysxArticulationLinkComponent) or is_dynamic(body):
            yield body


class ConstraintSet:
    """The constraints of a batch.

    Attributes:
        batches: by name, in the order of the plan.
    """

    def __init__(self, plan: ScenePlan, lookup: EntityLookup) -> None:
        """Builds them in order in each scene. The connected bodies must exist already."""
        self._prepared = [
            prepared
            for each in plan.constraints
            if (prepared := PreparedConstraint(each, lookup.scene_idxs)).scene_idxs
        ]
        self._colliding = colliding_constraints([each.constraint for each in self._prepared])
        self.batches: dict[str, ConstraintBatch] = {
            prepared.constraint.name: ConstraintBatch(
                prepared.constraint.name, prepared.scene_idxs, prepared.build(lookup)
            )
            for prepared in self._prepared
        }
        for index in lookup.scene_idxs:
            self.allow_collisions(index)

    @property
    def has_targets(self) -> bool:
        """Returns whether any drive has a target, which a reset sets."""
        return any(
            isinstance(prepared.constraint.joint, Drive) and prepared.constraint.joint.drives
            for prepared in self._prepared
        )

    def sample_targets(self, batch: Batch) -> TargetCalls:
        """Samples the initial targets of drives, without setting them. Raises ValueError if a value is undefined."""
        steps: TargetCalls = []
        for prepared in self._prepared:
            steps += sample_targets(prepared, self.batches[prepared.constraint.name].objs, batch)
        return steps

    @contextmanager
    def suspend(self, scene_idx: int) -> Generator[None, None, None]:
        """Removes the constraints of a scene from its simulation within the block, then adds them again in build order.

        PhysX solves constraints in an order that depends on when their bodies were added. Another order changes the
        last bit.
        """
        removed = [
            (component.get_entity(), component)
            for each in self.batches.values()
            if (first := each.in_scene(scene_idx)) is not None
            for component in components_of(first)
        ]
        for entity, component in reversed(removed):
            entity.remove_component(component)
        try:
            yield
        finally:
            for entity, component in removed:
                entity.add_component(component)
            self.allow_collisions(scene_idx)

    def allow_collisions(self, scene_idx: int) -> None:
        """Lets the bodies of constraints with `collide` collide in a scene. They must be in its simulation.

        SAPIEN has no setter for it. PhysX has a table of the pairs whose joints prevent contacts. The end of any joint
        between two bodies removes their pair, until they enter a simulation again.
        """
        for name, scenes in self._colliding.items():
            component = self.batches[name].in_scene(scene_idx) if scene_idx in scenes else None
            if component is not None:
                own = next(
                    each for each in component.entity.components if isinstance(each, physx.PhysxRigidBodyComponent)
                )
                physx.PhysxDistanceJointComponent(own).set_parent(component.parent)

    def close(self) -> None:
        """Releases all objects."""
        for each in self.batches.values():
            each._close()  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
        self.batches, self._prepared = {}, []


def sample_targets(
    prepared: PreparedConstraint, objs: Sequence[Any], batch: Batch
) -> Iterator[tuple[Any, str, tuple[Any, ...]]]:
    """Samples the initial targets of one constraint. `objs`: its components in the order of its scenes.

    Raises:
        ValueError: a drawn value is undefined.
    """
    joint = prepared.constraint.joint
    number_of = {index: number for number, index in enumerate(prepared.scene_idxs)}
    part = part_in_scenes(batch, number_of)
    if not isinstance(joint, Drive) or part is None:
        return
    numbers = [number_of[index] for index in part.scenes.tolist()]

    def read(field: str) -> NDArray[Any]:
        value: Value | None = getattr(joint, field)
        if value is None or value.recipe is None:
            return _target_rows(joint, field, prepared.rows[numbers])
        return _sample_target(prepared, "target" if field == "target" else "velocity_target", value.recipe, part)

    calls = list(_target_calls(joint, read, every=True))
    for place, number in enumerate(numbers if joint.drives else ()):
        for call in calls:
            yield objs[number], call.set, call.arguments(place)


def _sample_target(prepared: PreparedConstraint, what: str, recipe: Node, batch: Batch) -> NDArray[np.float64]:
    """Samples a target, (B, 7) or (B, 3)."""
    found = sample_value(batch, recipe, prepared.constraint.name, what)
    check_drawn_finite(found, batch, prepared.constraint.name, what)
    return found
