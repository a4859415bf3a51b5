"""Fields of articulations, their links and their joints: two links that fall freely, in a plan and by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
from fidelity.hand import box_shape
from fidelity.setter_rows import Changes, Hooks, Row, RowKey, Setting

from scenecc.plan import ArticulationStructure, BodyStructure, Entity, Joint, Link, Physics, ScenePlan, constant

START = [0.1, -0.2, 1.0]
IN_PARENT, IN_CHILD = [0.2, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [-0.2, 0.0, 0.01, 1.0, 0.0, 0.0, 0.0]
LIMITS, STIFFNESS, DAMPING, FORCE_LIMIT = [-1.5, 1.5], 20.0, 2.0, 50.0
DRIVE = {"stiffness": STIFFNESS, "damping": DAMPING, "force_limit": FORCE_LIMIT, "drive_target": 0.3}


def plan(changes: Changes) -> ScenePlan:
    """The arm, of which some fields are replaced: of its joint, of its second link, or of the whole."""
    given: dict[str, Any] = {
        "pose_in_parent": constant(IN_PARENT),
        "pose_in_child": constant(IN_CHILD),
        "limits": constant(LIMITS),
        **{name: constant(number) for name, number in DRIVE.items()},
        **changes.get(Joint, {}),
    }
    body: dict[str, Any] = {**changes.get(BodyStructure, {})}
    links = (
        Link("base", BodyStructure("link", (box_shape(0.2, 0.05, 0.05),))),
        Link(
            "tip", BodyStructure("link", (box_shape(0.2, 0.03, 0.04),), **body), 0, Joint("revolute", "hinge", **given)
        ),
    )
    whole: dict[str, Any] = {**changes.get(ArticulationStructure, {})}
    arm = ArticulationStructure(links, **whole)
    return ScenePlan("row", 1, (Entity("arm", (0,), constant([*START, 1, 0, 0, 0]), (arm,)),), Physics())


def by_hand(hooks: Hooks) -> Any:
    """The same with SAPIEN's builder, and what a person then calls."""
    import sapien
    from sapien import physx

    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    builder: Any = scene.create_articulation_builder()
    base = builder.create_link_builder()
    base.set_name("base")
    base.add_box_collision(half_size=[0.2, 0.05, 0.05])
    tip = builder.create_link_builder(base)
    tip.set_name("tip")
    tip.set_joint_name("hinge")
    tip.set_joint_properties("revolute", [LIMITS], _pose(IN_PARENT), _pose(IN_CHILD))
    tip.add_box_collision(half_size=[0.2, 0.03, 0.04])
    builder.set_initial_pose(sapien.Pose(START))
    articulation = builder.build(fix_root_link=False)
    articulation.name = "arm"
    joint = articulation.find_joint_by_name("hinge")
    joint.set_drive_properties(STIFFNESS, DAMPING, FORCE_LIMIT)
    joint.set_drive_target(0.3)
    for cls in (Joint, BodyStructure, ArticulationStructure):
        if cls in hooks:
            hooks[cls](find(scene, cls))
    if joint.type == "revolute":
        articulation.set_qpos(articulation.qpos)  # moves the entities of the links to where they belong
    return scene


def find(scene: Any, cls: type) -> Any:
    """The object of a dataclass in a live scene."""
    articulation = scene.get_all_articulations()[0]
    found = {Joint: articulation.find_joint_by_name("hinge"), BodyStructure: articulation.find_link_by_name("tip")}
    return found.get(cls, articulation)


def _pose(numbers: list[float]) -> Any:
    import sapien

    return sapien.Pose(numbers[:3], numbers[3:])


def _whole(joint: Any) -> Any:
    return joint.get_child_link().get_articulation()


def _scale_mass(link: Any, mass: float) -> None:
    before, inertia = float(link.mass), np.asarray(link.inertia, np.float64)
    link.set_mass(mass)
    link.set_inertia(inertia * (mass / before))


def _move_center(link: Any, position: list[float]) -> None:
    from sapien import Pose

    link.set_cmass_local_pose(Pose(position, link.cmass_local_pose.q))
    # A link keeps its joint's frame relative to the centre of mass.
    link.joint.set_pose_in_child(_pose(IN_CHILD))


_JOINT: dict[str, Row] = {
    "pose_in_parent": Row(
        [0.3, 0.02, 0.0, 0.6, 0.0, 0.8, 0.0], lambda joint, pose: joint.set_pose_in_parent(_pose(pose))
    ),
    "pose_in_child": Row(
        [-0.1, 0.02, 0.0, 0.6, 0.0, 0.8, 0.0], lambda joint, pose: joint.set_pose_in_child(_pose(pose))
    ),
    "limits": Row([-0.2, 0.1], lambda joint, ends: joint.set_limits([ends]), [-0.7, 0.9]),
    "friction": Row(0.13, lambda joint, number: joint.set_friction(number), 0.02),
    "armature": Row(0.27, lambda joint, number: joint.set_armature([number]), 0.03),
    "max_velocity": Row(0.35, lambda joint, number: joint.set_max_velocity(number), 2.5),
    "stiffness": Row(7.0, lambda joint, k: joint.set_drive_properties(k, DAMPING, FORCE_LIMIT), 9.0),
    "damping": Row(0.6, lambda joint, d: joint.set_drive_properties(STIFFNESS, d, FORCE_LIMIT), 1.6),
    "force_limit": Row(0.9, lambda joint, most: joint.set_drive_properties(STIFFNESS, DAMPING, most), 4.5),
    "drive_mode": Row(
        "acceleration",
        lambda joint, mode: joint.set_drive_properties(STIFFNESS, DAMPING, FORCE_LIMIT, mode),
        dtype=None,
    ),
    "qpos": Row(0.4, lambda joint, angle: _whole(joint).set_qpos([angle]), 0.1, state=False),
    "qvel": Row(1.3, lambda joint, speed: _whole(joint).set_qvel([speed]), 0.2, state=False),
    "drive_target": Row(-0.4, lambda joint, angle: joint.set_drive_target(angle), 0.2, state=False),
    "drive_velocity_target": Row(0.8, lambda joint, speed: joint.set_drive_velocity_target(speed), 0.1, state=False),
}

_LINK: dict[str, Row] = {
    "mass": Row(0.7, _scale_mass, 2.5),
    "com": Row([0.05, -0.02, 0.01], _move_center, [-0.03, 0.02, 0.0]),
    "disable_gravity": Row(True, lambda link, off: link.set_disable_gravity(off), False, np.bool_),
    "linear_damping": Row(0.31, lambda link, number: link.set_linear_damping(number), 0.05),
    "angular_damping": Row(0.72, lambda link, number: link.set_angular_damping(number), 0.9),
    "max_linear_velocity": Row(0.4, lambda link, number: link.set_max_linear_velocity(number)),
    "max_angular_velocity": Row(0.6, lambda link, number: link.set_max_angular_velocity(number)),
    "max_depenetration_velocity": Row(0.8, lambda link, number: link.set_max_depenetration_velocity(number)),
    "max_contact_impulse": Row(0.02, lambda link, number: link.set_max_contact_impulse(number)),
    "collision_groups": Row(
        [3, 5, 9, 2], lambda link, groups: link.collision_shapes[0].set_collision_groups(groups), None, np.int64
    ),
}


_WHOLE: dict[str, Row] = {
    "solver_position_iterations": Row(9, lambda arm, n: arm.set_solver_position_iterations(n), None, np.int64),
    "solver_velocity_iterations": Row(4, lambda arm, n: arm.set_solver_velocity_iterations(n), None, np.int64),
    "sleep_threshold": Row(0.17, lambda arm, number: arm.set_sleep_threshold(number)),
    "linear_velocity": Row([0.3, -0.2, 0.1], lambda arm, v: arm.set_root_linear_velocity(v), [0, 0.1, 0], state=False),
    "angular_velocity": Row(
        [1.0, 2.0, -0.5], lambda arm, w: arm.set_root_angular_velocity(w), [0, 0.1, 0], state=False
    ),
}

ROWS: dict[RowKey, Row] = {
    (cls, field): row
    for cls, rows in ((Joint, _JOINT), (BodyStructure, _LINK), (ArticulationStructure, _WHOLE))
    for field, row in rows.items()
}

ARMS = Setting(plan, by_hand, find, ROWS)
