"""Articulations, every property of every link and joint, against hand-written SAPIEN."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fidelity.compare import assert_same_scene, assert_same_trajectory, entity_facts
from fidelity.hand import built, counts, flags
from fidelity.hand_articulations import Case, by_hand, plan_of, pose, with_body, with_joint, with_mimic

from scenecc.backends.sapien.properties import ARTICULATION_PROPERTIES, JOINT_PROPERTIES, LINK_FIELDS, ROOT_PROPERTIES
from scenecc.plan import Box, Capsule, Sphere, VisualShape, constant, per_scene
from scenecc.plan.body import VisualMaterial
from scenecc.plan.tendons import soft_tendon


def assert_same(case: Case) -> None:
    batch, hand = built(plan_of(case)), by_hand(case)
    for ours, theirs in zip(batch.scenes, hand, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, hand)


@pytest.mark.parametrize("fixed", [True, False])
def test_arm(fixed: bool) -> None:
    assert_same(Case(fixed=fixed))


LINK_KNOBS: dict[str, tuple[Any, list[Any]]] = {
    "disable_gravity": (flags, [True, False, True]),
    "linear_damping": (per_scene, [0.0, 0.5, 3.25]),
    "angular_damping": (per_scene, [0.0, 0.5, 3.25]),
    "max_linear_velocity": (per_scene, [0.3, 1.0, 20.0]),
    "max_angular_velocity": (per_scene, [0.3, 1.0, 20.0]),
    "max_depenetration_velocity": (per_scene, [0.1, 1.0, 20.0]),
    "max_contact_impulse": (per_scene, [0.01, 1.0, 20.0]),
}


def test_every_knob_of_a_link_has_a_case() -> None:
    assert set(LINK_KNOBS) == set(LINK_FIELDS)


@pytest.mark.parametrize("name", LINK_KNOBS)
def test_link_knob(name: str) -> None:
    make, values = LINK_KNOBS[name]

    def hand(articulation: Any, scene: int) -> None:
        for link in ("upper", "tip"):
            getattr(articulation.find_link_by_name(link), f"set_{name}")(values[scene])

    change = with_body("upper", **{name: make(values)})
    assert_same(Case(lambda arm: with_body("tip", **{name: make(values)})(change(arm)), hand=hand))


def test_every_knob_of_a_joint_has_a_case() -> None:
    assert set(JOINT_VALUES) == set(JOINT_PROPERTIES.by_field)


JOINT_VALUES: dict[str, list[Any]] = {
    "friction": [0.0, 0.3, 5.0],
    "armature": [0.0, 0.01, 0.3],
    "max_velocity": [0.1, 1.0, 200.0],
    "drive_target": [0.1, 0.15, -0.1],
    "drive_velocity_target": [0.3, 0.0, -1.0],
}


@pytest.mark.parametrize("name", JOINT_VALUES)
@pytest.mark.parametrize("joint", ["shoulder", "slide", "side"])
def test_joint_knob(joint: str, name: str) -> None:
    def hand(articulation: Any, scene: int) -> None:
        found = articulation.find_joint_by_name(joint)
        found.set_drive_properties(20.0, 2.0)
        value = JOINT_VALUES[name][scene]
        getattr(found, f"set_{name}")([value] if name == "armature" else value)

    drive = {"stiffness": constant(20.0), "damping": constant(2.0), name: per_scene(JOINT_VALUES[name])}
    assert_same(Case(with_joint(joint, **drive), hand=hand))


@pytest.mark.parametrize("mode", ["force", "acceleration"])
def test_drives_by_scene(mode: Any) -> None:
    stiffness, damping, limit = [10.0, 200.0, 0.0], [1.0, 0.0, 5.0], [0.5, 1e4, 2.0]

    def hand(articulation: Any, scene: int) -> None:
        joint = articulation.find_joint_by_name("shoulder")
        joint.set_drive_properties(stiffness[scene], damping[scene], limit[scene], mode)
        joint.set_drive_target(0.7)

    fields = {"stiffness": stiffness, "damping": damping, "force_limit": limit}
    change = with_joint(
        "shoulder",
        **{name: per_scene(rows) for name, rows in fields.items()},
        drive_mode=mode,
        drive_target=constant(0.7),
    )
    assert_same(Case(change, hand=hand))


def test_a_joint_of_which_nothing_is_said_is_that_of_sapiens_builder() -> None:
    def builder(made: Any, scene: int) -> None:
        side = made.link_builders[5]
        side.set_joint_properties("revolute", [-np.inf, np.inf], *[type(made.initial_pose)()] * 2)

    blank = with_joint("side", pose_in_parent=None, pose_in_child=None, limits=None, damping=None)
    assert_same(Case(blank, builder=builder))


def test_limits_and_frames_by_scene() -> None:
    limits = [[-0.6, 0.3], [0.0, 0.0], [-0.9, np.inf]]
    frames = [[0.1, 0, 0.1 + 0.01 * i, 0.9238795, 0, 0.3826834, 0] for i in range(3)]

    def builder(made: Any, scene: int) -> None:
        record = made.link_builders[1].joint_record
        record.limits = [limits[scene]]
        record.pose_in_parent = type(made.initial_pose)(frames[scene][:3], frames[scene][3:])

    assert_same(
        Case(with_joint("shoulder", limits=per_scene(limits), pose_in_parent=per_scene(frames)), builder=builder)
    )


def test_everything_of_the_articulation() -> None:
    values = {
        "solver_position_iterations": [1, 4, 40],
        "solver_velocity_iterations": [0, 2, 8],
        "sleep_threshold": [0.0, 0.5, 5.0],
        "linear_velocity": [[1, 2, 3], [0, 0, 0], [-1, 0.5, 0]],
        "angular_velocity": [[1, 2, 3], [0, 0, 0], [-1, 0.5, 0]],
    }
    assert set(values) == {*ARTICULATION_PROPERTIES.by_field, *ROOT_PROPERTIES.by_field}

    def hand(articulation: Any, scene: int) -> None:
        for name, rows in values.items():
            root = "root_" if name.endswith("velocity") else ""
            getattr(articulation, f"set_{root}{name}")(rows[scene])

    given = {name: (counts if name.startswith("solver") else per_scene)(rows) for name, rows in values.items()}
    assert_same(Case(lambda arm: replace(arm, **given), before=hand, fixed=False))


def test_velocities_of_joints() -> None:
    def hand(articulation: Any, scene: int) -> None:
        numbers = {"shoulder": 0.5, "elbow": [0.0, -1.0, -2.0][scene]}
        articulation.set_qvel([numbers.get(joint.name, 0.0) for joint in articulation.active_joints])

    change = with_joint("elbow", qvel=per_scene([0.0, -1.0, -2.0]))
    assert_same(Case(lambda arm: with_joint("shoulder", qvel=constant(0.5))(change(arm)), hand=hand))


@pytest.mark.parametrize(("joint", "source"), [("side", "shoulder"), ("slide", "shoulder"), ("shoulder", "side")])
def test_mimic_is_a_tendon_before_the_articulation_is_in_the_scene(joint: str, source: str) -> None:
    """The same call by a person, where SAPIEN's own builder makes its tendons."""
    import sapien

    chains = {("side", "shoulder"): (0, 1, 5), ("slide", "shoulder"): (0, 1, 2), ("shoulder", "side"): (0, 5, 1)}

    def builder(made: Any, scene: int) -> None:
        build_entities = made.build_entities

        def with_tendon(**options: Any) -> list[Any]:
            entities = build_entities(**options)
            every = [entity.find_component_by_type(sapien.physx.PhysxArticulationLinkComponent) for entity in entities]
            links = [every[i] for i in chains[joint, source]]
            factors, timestep = [0.0, -0.5, 1.0], float(np.float32(0.01))
            shares, stiffness = soft_tendon(every, list(chains[joint, source]), factors, timestep, temporal=True)
            links[0].articulation.create_fixed_tendon(links, factors, shares, rest_length=0.1, stiffness=stiffness)
            return entities

        made.build_entities = with_tendon

    assert_same(Case(with_mimic(joint, source, 0.5, 0.1), builder=builder))


@pytest.mark.render
def test_what_is_seen_of_links() -> None:
    """The look of a link is its entity's last component, as SAPIEN's builder makes it, and moves with it."""

    def builder(made: Any, scene: int) -> None:
        upper, tool = made.link_builders[1], made.link_builders[3]
        upper.add_box_visual(pose([0.1, 0, 0]), half_size=[0.1, 0.02, 0.02], material=[0.8, 0.2, 0.1], name="shell")
        upper.add_sphere_visual(radius=0.05, material=[0.8, 0.2, 0.1])
        tool.add_capsule_visual(radius=0.02, half_length=0.1, material=[0.8, 0.2, 0.1])

    def seen(geometry: Any, **more: Any) -> VisualShape:
        return VisualShape(geometry, material=constant(0, np.int64), **more)

    shell = seen(Box(constant([0.1, 0.02, 0.02])), pose=constant([0.1, 0, 0, 1, 0, 0, 0]), name="shell")
    upper = with_body("upper", visuals=(shell, seen(Sphere(constant(0.05)))))
    tool = with_body("tool", visuals=(seen(Capsule(constant(0.02), constant(0.1))),))
    case = Case(lambda arm: tool(upper(arm)), builder=builder)
    paint = VisualMaterial(base_color=constant([0.8, 0.2, 0.1, 1]))
    batch = built(replace(plan_of(case), visual_materials=(paint,)), render=True)
    hand = by_hand(case, rendered=True)
    for again in range(2):
        for number, scene in enumerate(hand if not again else by_hand(case, rendered=True)):
            # Lights and a camera are ours alone.
            ours = {each.name: each for each in batch.scenes[number].entities}
            for theirs in scene.entities:
                assert entity_facts(ours[theirs.name]) == entity_facts(theirs), theirs.name
            for _ in range(50):
                batch.scenes[number].step()
                scene.step()
                for theirs in scene.entities:
                    assert ours[theirs.name].pose.__getstate__() == theirs.pose.__getstate__()
        batch.reset(exact=True)
