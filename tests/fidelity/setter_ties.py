"""Fields of constraints: two boxes that are tied together and fall, in a plan and by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
from fidelity.hand import box_shape
from fidelity.setter_rows import Changes, Hooks, Row, RowKey, Setting

from scenecc.plan import (
    BodyStructure,
    Connection,
    Constraint,
    Distance,
    Drive,
    Entity,
    Gear,
    Mount,
    Physics,
    ScenePlan,
    Weld,
    constant,
)
from scenecc.plan.constraint import AxisDrive, AxisLimit

POST, BOB = [0.0, 0.0, 1.0], [0.4, 0.1, 1.1]
HALF_SIZE = [0.1, 0.05, 0.06]
DISTANCE = {"limits": [0.1, 0.35], "stiffness": 40.0, "damping": 2.0}
AXIS_LIMIT = {"limits": [-0.1, 0.2], "stiffness": 30.0, "damping": 1.0}
AXIS_DRIVE = {"stiffness": 20.0, "damping": 2.0, "force_limit": 5.0, "mode": "force"}
TARGET = [0.1, 0.2, 0.0, 0.8, 0.6, 0.0, 0.0]


def _joint(changes: Changes) -> Any:
    """The joint of the constraint: of the dataclass that is changed, or a drive about three axes."""
    if Distance in changes:
        return Distance(**{**{name: constant(number) for name, number in DISTANCE.items()}, **changes[Distance]})
    if Gear in changes:
        return Gear(**{"ratio": constant(2.0), **changes[Gear]})
    for cls in (Weld, Connection):
        if cls in changes:
            return cls()
    if AxisLimit in changes:
        numbers: Any = {name: constant(number) for name, number in AXIS_LIMIT.items()}
        return Drive(limits=(AxisLimit(**{**numbers, **changes[AxisLimit]}),))
    if AxisDrive in changes:
        given: Any = {name: it if isinstance(it, str) else constant(it) for name, it in AXIS_DRIVE.items()}
        return Drive(drives=(AxisDrive(**{**given, **changes[AxisDrive]}),), target=constant(TARGET))
    own: Any = {**changes.get(Drive, {})}
    return Drive(drives=tuple(AxisDrive(axis, constant(20.0), constant(2.0)) for axis in ("x", "y", "slerp")), **own)


def plan(changes: Changes) -> ScenePlan:
    """Two boxes and the constraint, of which some fields are replaced."""
    box = BodyStructure("dynamic", (box_shape(*HALF_SIZE),))
    own: Any = {**changes.get(Constraint, {})}
    tie = Constraint("tie", (0,), _joint(changes), Mount("bob"), Mount("post"), **own)
    entities = (
        Entity("post", (0,), constant([*POST, 1, 0, 0, 0]), (BodyStructure("dynamic", box.collisions),)),
        Entity(
            "bob",
            (0,),
            constant([*BOB, 1, 0, 0, 0]),
            (BodyStructure("dynamic", box.collisions, angular_velocity=constant([1.0, 2.0, 0.0])),),
        ),
    )
    return ScenePlan("row", 1, entities, Physics(), constraints=(tie,))


def by_hand(hooks: Hooks) -> Any:
    """The same with SAPIEN's components."""
    import sapien
    from sapien import physx

    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    bodies: list[Any] = []
    for name, at in (("post", POST), ("bob", BOB)):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=HALF_SIZE)
        builder.initial_pose = sapien.Pose(at)
        bodies.append(builder.build(name=name))
    post, bob = bodies
    bob.components[0].set_angular_velocity([1.0, 2.0, 0.0])
    _tie(scene, post, bob, hooks).name = "tie"
    for cls, change in hooks.items():
        change(find(scene, cls))
    return scene


def _tie(scene: Any, post: Any, bob: Any, hooks: Hooks) -> Any:
    from sapien import Pose, physx

    if Distance in hooks or Connection in hooks:
        joint: Any = physx.PhysxDistanceJointComponent(bob.components[0])
        joint.parent = post.components[0]
        joint.pose_in_child = joint.pose_in_parent = Pose()
        bob.add_component(joint)
        joint.set_limit(*DISTANCE["limits"], DISTANCE["stiffness"], DISTANCE["damping"])
        return joint
    if Gear in hooks:
        gear: Any = scene.create_gear(post, Pose(), bob, Pose())
        gear.gear_ratio = 2.0
        return gear
    drive: Any = scene.create_drive(post, Pose(), bob, Pose())
    if AxisDrive in hooks:
        drive.set_drive_target(_pose(TARGET))
    elif AxisLimit not in hooks and Weld not in hooks:
        drive.set_drive_property_x(20, 2)
        drive.set_drive_property_y(20, 2)
        drive.set_drive_property_slerp(20, 2)
    return drive


def find(scene: Any, cls: type) -> Any:
    """The component of the constraint in a live scene."""
    del cls
    return next(entity for entity in scene.entities if entity.name == "bob").components[1]


def _pose(numbers: list[float]) -> Any:
    import sapien

    return sapien.Pose(numbers[:3], numbers[3:])


def _distance(joint: Any, **changed: Any) -> None:
    numbers = {**DISTANCE, **changed}
    joint.set_limit(*numbers["limits"], numbers["stiffness"], numbers["damping"])


def _limit(drive: Any, axis: str, **changed: Any) -> None:
    numbers = {**AXIS_LIMIT, **changed}
    setter = {"x": drive.set_limit_x, "y": drive.set_limit_y, "z": drive.set_limit_z, "twist": drive.set_limit_twist}
    setter[axis](*numbers["limits"], numbers["stiffness"], numbers["damping"])


def _gains(drive: Any, axis: str, **changed: Any) -> None:
    numbers = {**AXIS_DRIVE, **changed}
    setter = {
        "x": drive.set_drive_property_x,
        "y": drive.set_drive_property_y,
        "z": drive.set_drive_property_z,
        "twist": drive.set_drive_property_twist,
        "swing": drive.set_drive_property_swing,
        "slerp": drive.set_drive_property_slerp,
    }
    setter[axis](numbers["stiffness"], numbers["damping"], numbers["force_limit"], numbers["mode"])


def _enable(joint: Any, flag: bool) -> None:
    if flag and not joint.is_enabled:
        joint.enable()
    elif not flag and joint.is_enabled:
        joint.disable()


_TIE: dict[str, Row] = {
    "pose_in_parent": Row(
        [0.3, 0.02, 0.0, 0.6, 0.0, 0.8, 0.0], lambda joint, pose: joint.set_pose_in_parent(_pose(pose))
    ),
    "pose_in_child": Row(
        [-0.1, 0.02, 0.0, 0.8, 0.0, 0.6, 0.0], lambda joint, pose: joint.set_pose_in_child(_pose(pose))
    ),
    "enabled": Row(False, _enable, True, np.bool_),
}

_DRIVE: dict[str, Row] = {
    "target": Row(
        TARGET, lambda drive, pose: drive.set_drive_target(_pose(pose)), [0.2, 0, 0, 1, 0, 0, 0], state=False
    ),
    "linear_velocity_target": Row(
        [0.3, -0.2, 0.1], lambda drive, v: drive.set_drive_velocity_target(v, [0, 0, 0]), [0, 0.1, 0], state=False
    ),
    "angular_velocity_target": Row(
        [1.3, -1.2, 0.1], lambda drive, w: drive.set_drive_velocity_target([0, 0, 0], w), [0, 0.1, 0], state=False
    ),
    "inv_mass_scales": Row([0.2, 3.0], lambda drive, scales: drive.set_inv_mass_scales(*scales)),
    "inv_inertia_scales": Row([0.2, 3.0], lambda drive, scales: drive.set_inv_inertia_scales(*scales)),
}

ROWS: dict[RowKey, Row] = {
    **{(Constraint, field): row for field, row in _TIE.items()},
    **{(Drive, field): row for field, row in _DRIVE.items()},
    (Gear, "ratio"): Row(-0.7, lambda gear, ratio: gear.set_gear_ratio(ratio)),
    (Distance, "limits"): Row([0.05, 0.2], lambda joint, ends: _distance(joint, limits=ends)),
    (Distance, "stiffness"): Row(90.0, lambda joint, k: _distance(joint, stiffness=k)),
    (Distance, "damping"): Row(9.0, lambda joint, d: _distance(joint, damping=d)),
    **{
        (AxisLimit, field, axis): Row(
            value, lambda drive, number, axis, field=field: _limit(drive, axis, **{field: number})
        )
        for field, value in (("limits", [-0.02, 0.04]), ("stiffness", 90.0), ("damping", 7.0))
        for axis in ("x", "y", "z", "twist")
    },
    **{
        (AxisDrive, field, axis): Row(
            value, lambda drive, number, axis, field=field: _gains(drive, axis, **{field: number}), other, dtype
        )
        for field, value, other, dtype in (
            ("stiffness", 7.0, 9.0, np.float64),
            ("damping", 0.6, 1.6, np.float64),
            ("force_limit", 0.9, 4.5, np.float64),
            ("mode", "acceleration", None, None),
        )
        for axis in ("x", "y", "z", "twist", "swing", "slerp")
    },
}

TIES = Setting(plan, by_hand, find, ROWS)
