"""Articulations written by hand, with `sapien.ArticulationBuilder` and what a user then calls, and plans for the same.

Nothing here uses our builder. The arm stands on a ground and has every type of joint, two branches, links with and
without shapes; a box lies in its way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from fidelity.hand import UP, box_shape

from scenecc.plan import (
    ArticulationStructure,
    BodyStructure,
    Capsule,
    CollisionShape,
    Entity,
    Inertial,
    Joint,
    Link,
    Mimic,
    Physics,
    Plane,
    ScenePlan,
    constant,
    per_scene,
)
from scenecc.plan.body import PhysicalMaterial

SCENES = 3
TILTED = [0.9238795, 0, 0.3826834, 0]
START = [0.1, -0.2, 0.3, 0.9238795, 0, 0, 0.3826834]

Hand = Callable[[Any, int], object]
"""What a person calls on the articulation of a scene once it is built and at its start."""


def pose(p: list[float], q: list[float] | None = None) -> Any:
    import sapien

    return sapien.Pose(p, q or [1, 0, 0, 0])


def number(p: list[float], q: list[float] | None = None) -> list[float]:
    return [*p, *(q or [1, 0, 0, 0])]


@dataclass(frozen=True)
class Case:
    """An arm in the plan, and what a person does beyond SAPIEN's builder.

    Attributes:
        change: makes another articulation of the arm of the plan.
        before, hand: what a person calls on the articulation before and after `qpos` is set.
        builder: what a person changes of SAPIEN's builder, for a scene.
        qpos: at the start, a row a scene, in the order of the plan's joints.
        fixed: whether the root is.
    """

    change: Callable[[ArticulationStructure], ArticulationStructure] = field(default=lambda arm: arm)
    before: Hand = field(default=lambda articulation, scene: None)
    hand: Hand = field(default=lambda articulation, scene: None)
    builder: Hand = field(default=lambda builder, scene: None)
    qpos: tuple[tuple[float, ...], ...] = ((0.1, 0.05, -0.3, 0.2), (0.0, 0.0, 0.0, 0.0), (-0.5, 0.1, 0.7, -0.2))
    fixed: bool = True


LIMITS = {"shoulder": [-1.5, 1.5], "slide": [-0.2, 0.2], "elbow": [-2.0, 2.0], "side": [-np.inf, np.inf]}
MOVING = tuple(LIMITS)
FRICTION = PhysicalMaterial(constant(0.7), constant(0.6), constant(0.05))


def arm(case: Case) -> ArticulationStructure:
    """The arm in the plan."""
    qpos = dict(zip(MOVING, np.array(case.qpos).T, strict=True))

    def joint(kind: Any, name: str, parent: list[float], child: list[float], **more: Any) -> Joint:
        limits = constant(LIMITS[name]) if kind != "fixed" else None
        start = per_scene(qpos[name]) if kind != "fixed" else None
        return Joint(kind, name, constant(parent), constant(child), limits, qpos=start, **more)

    inertial = Inertial(constant(0.8), constant([0.01, 0, 0.02, 1, 0, 0, 0]), constant([0.004, 0.005, 0.006]))
    capsule = CollisionShape(Capsule(constant(0.03), constant(0.1)), pose=constant(number([0.1, 0, 0])))
    finger = box_shape(0.1, 0.02, 0.02, material=constant(0, np.int64), pose=constant(number([0.05, 0, 0], TILTED)))
    links = (
        Link("base", BodyStructure("link", (box_shape(0.1, 0.1, 0.1),))),
        Link(
            "upper",
            BodyStructure("link", (capsule, box_shape(0.02, 0.03, 0.04, density=constant(500.0)))),
            0,
            joint("revolute_unwrapped", "shoulder", number([0.1, 0, 0.1], TILTED), number([-0.1, 0, 0])),
        ),
        Link(
            "lower",
            BodyStructure("link", (finger,), collision_groups=constant([1, 1, 4, 0], np.int64)),
            1,
            joint("prismatic", "slide", number([0.2, 0, 0]), number([0, 0.01, 0], TILTED), damping=constant(0.3)),
        ),
        Link(
            "tool",
            BodyStructure("link", inertial=inertial),
            2,
            joint("fixed", "mount", number([0.1, 0, 0]), number([0, 0, 0])),
        ),
        Link(
            "tip",
            BodyStructure("link", (box_shape(0.02, 0.02, 0.05),), mass=constant(0.25)),
            3,
            joint("revolute", "elbow", number([0.05, 0, 0]), number([0, 0, 0.06])),
        ),
        Link(
            "flap",
            BodyStructure("link", (box_shape(0.1, 0.01, 0.05),)),
            0,
            joint("revolute", "side", number([-0.1, 0, 0.1]), number([0.1, 0, 0]), damping=constant(0.05)),
        ),
    )
    return case.change(ArticulationStructure(links, fix_root_link=case.fixed))


def plan_of(case: Case, *, scenes: int = SCENES, physics: Physics | None = None) -> ScenePlan:
    """Ground, the arm, and a box beside it, in every scene."""
    every = tuple(range(scenes))
    ground = BodyStructure("static", (CollisionShape(Plane(), pose=constant([0, 0, 0, *UP])),))
    box = BodyStructure("dynamic", (box_shape(0.05, 0.06, 0.07),))
    return ScenePlan(
        "case",
        scenes,
        (
            Entity("ground", every, constant([0, 0, 0, 1, 0, 0, 0]), (ground,)),
            Entity("arm", every, constant(START), (arm(case),)),
            Entity("box", every, constant([0.4, -0.1, 0.8, 1, 0, 0, 0]), (box,)),
        ),
        physics or Physics(),
        physical_materials=(FRICTION,),
    )


def by_hand(case: Case, *, scenes: int = SCENES, rendered: bool = False) -> list[Any]:
    """The same scenes as a person would write them."""
    return [_scene(case, index, rendered=rendered) for index in range(scenes)]


def _scene(case: Case, index: int, *, rendered: bool) -> Any:
    import sapien
    from sapien import physx

    scene: Any = sapien.Scene() if rendered else sapien.Scene([physx.PhysxCpuSystem()])
    ground = scene.create_actor_builder()
    ground.add_plane_collision(pose=sapien.Pose([0, 0, 0], UP))
    ground.build_static(name="ground")

    builder: Any = scene.create_articulation_builder()
    _links(builder, physx.PhysxMaterial(0.7, 0.6, 0.05))
    builder.set_initial_pose(sapien.Pose(START[:3], START[3:]))
    case.builder(builder, index)
    articulation = builder.build(fix_root_link=case.fixed)
    articulation.name = "arm"
    case.before(articulation, index)
    qpos = dict(zip(MOVING, case.qpos[index], strict=True))
    articulation.set_qpos([qpos[joint.name] for joint in articulation.active_joints])
    case.hand(articulation, index)

    box: Any = scene.create_actor_builder()
    box.add_box_collision(half_size=[0.05, 0.06, 0.07])
    box.initial_pose = sapien.Pose([0.4, -0.1, 0.8])
    box.build(name="box")
    return scene


def _links(builder: Any, material: Any) -> None:
    base = builder.create_link_builder()
    base.set_name("base")
    base.add_box_collision(half_size=[0.1, 0.1, 0.1])

    upper = builder.create_link_builder(base)
    upper.set_name("upper")
    upper.set_joint_name("shoulder")
    upper.set_joint_properties(
        "revolute_unwrapped", [LIMITS["shoulder"]], pose([0.1, 0, 0.1], TILTED), pose([-0.1, 0, 0])
    )
    upper.add_capsule_collision(pose([0.1, 0, 0]), radius=0.03, half_length=0.1)
    upper.add_box_collision(half_size=[0.02, 0.03, 0.04], density=500.0)

    lower = builder.create_link_builder(upper)
    lower.set_name("lower")
    lower.set_joint_name("slide")
    lower.set_joint_properties(
        "prismatic", [LIMITS["slide"]], pose([0.2, 0, 0]), pose([0, 0.01, 0], TILTED), damping=0.3
    )
    lower.add_box_collision(pose([0.05, 0, 0], TILTED), half_size=[0.1, 0.02, 0.02], material=material)
    lower.collision_groups = [1, 1, 4, 0]

    tool = builder.create_link_builder(lower)
    tool.set_name("tool")
    tool.set_joint_name("mount")
    tool.set_joint_properties("fixed", [], pose([0.1, 0, 0]), pose([0, 0, 0]))
    tool.set_mass_and_inertia(0.8, pose([0.01, 0, 0.02]), [0.004, 0.005, 0.006])

    tip = builder.create_link_builder(tool)
    tip.set_name("tip")
    tip.set_joint_name("elbow")
    tip.set_joint_properties("revolute", [LIMITS["elbow"]], pose([0.05, 0, 0]), pose([0, 0, 0.06]))
    tip.add_box_collision(half_size=[0.02, 0.02, 0.05])
    # As `mass: 0.25` has it: the inertia that the density gives, by the ratio of the masses.
    tip.set_mass_and_inertia(*_lighter([0.02, 0.02, 0.05], 0.25))

    flap = builder.create_link_builder(base)
    flap.set_name("flap")
    flap.set_joint_name("side")
    flap.set_joint_properties("revolute", [LIMITS["side"]], pose([-0.1, 0, 0.1]), pose([0.1, 0, 0]), damping=0.05)
    flap.add_box_collision(half_size=[0.1, 0.01, 0.05])


def _lighter(half_size: list[float], mass: float) -> tuple[float, Any, Any]:
    from sapien import physx

    body: Any = physx.PhysxRigidDynamicComponent()
    body.attach(physx.PhysxCollisionShapeBox(half_size, physx.get_default_material()))
    return mass, body.cmass_local_pose, body.inertia.astype(np.float64) * (mass / body.mass)


def with_joint(name: str, **fields: Any) -> Callable[[ArticulationStructure], ArticulationStructure]:
    """Changes one joint of the plan's arm."""

    def change(structure: ArticulationStructure) -> ArticulationStructure:
        links = [
            replace(link, joint=replace(link.joint, **fields)) if link.joint and link.joint.name == name else link
            for link in structure.links
        ]
        return replace(structure, links=tuple(links))

    return change


def with_body(name: str, **fields: Any) -> Callable[[ArticulationStructure], ArticulationStructure]:
    """Changes the body of one link of the plan's arm."""

    def change(structure: ArticulationStructure) -> ArticulationStructure:
        links = [
            replace(link, body=replace(link.body, **fields)) if link.name == name else link for link in structure.links
        ]
        return replace(structure, links=tuple(links))

    return change


def with_mimic(joint: str, source: str, multiplier: float, offset: float) -> Callable[..., ArticulationStructure]:
    """Has one joint of the plan's arm mimic another."""
    mimic = Mimic(joint, source, constant(multiplier), constant(offset))
    return lambda structure: replace(structure, mimics=(mimic,))
