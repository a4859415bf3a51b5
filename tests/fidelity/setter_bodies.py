"""Fields of bodies, colliding shapes and physical materials: a box that falls on a ground, in a plan and by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
from fidelity.hand import UP
from fidelity.setter_rows import Changes, Hooks, Row, RowKey, Setting

from scenecc.plan import (
    BodyStructure,
    Box,
    CollisionShape,
    Entity,
    Inertial,
    Physics,
    Plane,
    ScenePlan,
    constant,
)
from scenecc.plan.body import PhysicalMaterial

HALF_SIZE = [0.1, 0.06, 0.03]
START = [0.0, 0.0, 0.08]
FRICTIONS = (0.5, 0.4, 0.1)
OTHER_FRICTIONS = (0.9, 0.8, 0.7)
MASS, COM, INERTIA = 1.5, [0.01, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.01, 0.012, 0.011]


def plan(changes: Changes) -> ScenePlan:
    """The ground and the box, of which some fields are replaced."""
    shape = CollisionShape(
        **{"geometry": Box(constant(HALF_SIZE)), "material": constant(0, np.int64), **changes.get(CollisionShape, {})}
    )
    body: dict[str, Any] = {**changes.get(BodyStructure, {})}
    if Inertial in changes:
        given: Any = {"mass": constant(MASS), "com": constant(COM), "inertia": constant(INERTIA), **changes[Inertial]}
        body["inertial"] = Inertial(**given)
    names = ("static_friction", "dynamic_friction", "restitution")
    frictions: Any = {**dict(zip(names, map(constant, FRICTIONS), strict=True)), **changes.get(PhysicalMaterial, {})}
    ground = BodyStructure("static", (CollisionShape(Plane(), pose=constant([0, 0, 0, *UP])),))
    return ScenePlan(
        "row",
        1,
        (
            Entity("ground", (0,), constant([0, 0, 0, 1, 0, 0, 0]), (ground,)),
            Entity("body", (0,), constant([*START, 1, 0, 0, 0]), (BodyStructure("dynamic", (shape,), **body),)),
        ),
        Physics(),
        physical_materials=(PhysicalMaterial(**frictions), PhysicalMaterial(*map(constant, OTHER_FRICTIONS))),
    )


def by_hand(hooks: Hooks) -> Any:
    """The same with SAPIEN's components."""
    import sapien
    from sapien import physx

    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    ground = scene.create_actor_builder()
    ground.add_plane_collision(pose=sapien.Pose([0, 0, 0], UP))
    ground.build_static(name="ground")

    material: Any = physx.PhysxMaterial(*FRICTIONS)
    _call(hooks, PhysicalMaterial, material)
    shape: Any = physx.PhysxCollisionShapeBox(HALF_SIZE, material)
    _call(hooks, CollisionShape, shape)
    body: Any = physx.PhysxRigidDynamicComponent()
    body.attach(shape)
    body.name = "body"
    if Inertial in hooks:
        body.set_mass(MASS)
        body.set_cmass_local_pose(sapien.Pose(COM[:3], COM[3:]))
        body.set_inertia(INERTIA)
    _call(hooks, Inertial, body)
    _call(hooks, BodyStructure, body)
    entity: Any = sapien.Entity()
    entity.add_component(body)
    entity.name = "body"
    entity.pose = sapien.Pose(START)
    scene.add_entity(entity)
    return scene


def _call(hooks: Hooks, cls: type, obj: Any) -> None:
    if cls in hooks:
        hooks[cls](obj)


def find(scene: Any, cls: type) -> Any:
    """The object of a dataclass in a live scene."""
    body = scene.entities[1].components[0]
    shape = body.collision_shapes[0]
    return {CollisionShape: shape, PhysicalMaterial: shape.physical_material}.get(cls, body)


def _pose(numbers: list[float]) -> Any:
    import sapien

    return sapien.Pose(numbers[:3], numbers[3:])


def _scale_mass(body: Any, mass: float) -> None:
    before, inertia = float(body.mass), np.asarray(body.inertia, np.float64)
    body.set_mass(mass)
    body.set_inertia(inertia * (mass / before))


def _move_center(body: Any, position: list[float]) -> None:
    from sapien import Pose

    body.set_cmass_local_pose(Pose(position, body.cmass_local_pose.q))


def _other_material(shape: Any, _number: int) -> None:
    from sapien import physx

    shape.set_physical_material(physx.PhysxMaterial(*OTHER_FRICTIONS))


def _own_groups(body: Any, groups: list[int]) -> None:
    body.collision_shapes[0].set_collision_groups(groups)


_BODY: dict[str, Row] = {
    "mass": Row(0.7, _scale_mass, 2.5),
    "com": Row([0.03, -0.02, 0.01], _move_center, [-0.01, 0.02, 0.0]),
    "disable_gravity": Row(True, lambda body, off: body.set_disable_gravity(off), False, np.bool_),
    "locked_motion_axes": Row(
        [True, False, False, False, True, False],
        lambda body, locked: body.set_locked_motion_axes(locked),
        None,
        np.bool_,
    ),
    "linear_velocity": Row([0.3, -0.2, 0.1], lambda body, v: body.set_linear_velocity(v), [0.0, 0.1, 0.0], state=False),
    "angular_velocity": Row(
        [1.0, 2.0, -0.5], lambda body, w: body.set_angular_velocity(w), [0.0, 0.1, 0.0], state=False
    ),
    "linear_damping": Row(0.31, lambda body, number: body.set_linear_damping(number), 0.05),
    "angular_damping": Row(0.72, lambda body, number: body.set_angular_damping(number), 0.9),
    "max_linear_velocity": Row(0.4, lambda body, number: body.set_max_linear_velocity(number)),
    "max_angular_velocity": Row(0.6, lambda body, number: body.set_max_angular_velocity(number)),
    "max_depenetration_velocity": Row(0.8, lambda body, number: body.set_max_depenetration_velocity(number)),
    "max_contact_impulse": Row(0.02, lambda body, number: body.set_max_contact_impulse(number)),
    "sleep_threshold": Row(0.15, lambda body, number: body.set_sleep_threshold(number)),
    "solver_position_iterations": Row(7, lambda body, n: body.set_solver_position_iterations(n), None, np.int64),
    "solver_velocity_iterations": Row(3, lambda body, n: body.set_solver_velocity_iterations(n), None, np.int64),
    "collision_groups": Row([3, 5, 9, 2], _own_groups, None, np.int64),
}

_SHAPE: dict[str, Row] = {
    "pose": Row([0.02, 0.01, 0.0, 0.6, 0.8, 0.0, 0.0], lambda shape, pose: shape.set_local_pose(_pose(pose))),
    "material": Row(1, _other_material, None, np.int64),
    "density": Row(350.0, lambda shape, number: shape.set_density(number)),
    "contact_offset": Row(0.023, lambda shape, number: shape.set_contact_offset(number)),
    "rest_offset": Row(0.004, lambda shape, number: shape.set_rest_offset(number)),
    "patch_radius": Row(0.2, lambda shape, number: shape.set_patch_radius(number)),
    "min_patch_radius": Row(0.1, lambda shape, number: shape.set_min_patch_radius(number)),
    "collision_groups": Row([3, 5, 9, 2], lambda shape, groups: shape.set_collision_groups(groups), None, np.int64),
}

_INERTIAL: dict[str, Row] = {
    "mass": Row(2.7, lambda body, mass: body.set_mass(mass), 1.1),
    "com": Row(
        [0.02, -0.01, 0.03, 0.6, 0.8, 0.0, 0.0],
        lambda body, pose: body.set_cmass_local_pose(_pose(pose)),
        [0.01, 0.02, 0.0, 1.0, 0.0, 0.0, 0.0],
    ),
    "inertia": Row([0.02, 0.025, 0.03], lambda body, moments: body.set_inertia(moments), [0.011, 0.012, 0.013]),
}

_MATERIAL: dict[str, Row] = {
    "static_friction": Row(0.83, lambda material, number: material.set_static_friction(number), 0.61),
    "dynamic_friction": Row(0.22, lambda material, number: material.set_dynamic_friction(number), 0.33),
    "restitution": Row(0.64, lambda material, number: material.set_restitution(number), 0.2),
}

ROWS: dict[RowKey, Row] = {
    (cls, field): row
    for cls, rows in (
        (BodyStructure, _BODY),
        (CollisionShape, _SHAPE),
        (Inertial, _INERTIAL),
        (PhysicalMaterial, _MATERIAL),
    )
    for field, row in rows.items()
}

BODIES = Setting(plan, by_hand, find, ROWS)
