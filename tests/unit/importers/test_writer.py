"""The writer of described worlds: names, shapes, joints, constraints, ignored pairs."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import pytest

import scenecc
from scenecc.diagnostics.diagnostic import Location
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, from_rpy
from scenecc.importers.writer import write_world
from scenecc.robots.description import (
    IN_WORLD,
    DescribedCollision,
    DescribedConstraint,
    DescribedDrive,
    DescribedDynamics,
    DescribedInertial,
    DescribedJoint,
    DescribedLink,
    DescribedMaterial,
    DescribedMotion,
    DescribedRobot,
    DescribedVisual,
    LimitAxis,
    SolidGeometry,
)
from scenecc.robots.rules import enforce_triangle_rule, light_link, split_joint
from scenecc.robots.world import DescribedCamera, DescribedEntity, DescribedLight, DescribedPhysics, DescribedWorld

if TYPE_CHECKING:
    from scenecc.scene_file import Node

HERE = Location("world.x", 1, 1)
BALL = SolidGeometry("sphere", (0.1,))
MASS = DescribedInertial(2.0, IDENTITY_POSE, (0.1, 0.2, 0.25), HERE)


def shape(geometry: SolidGeometry = BALL, pose: Pose7 = IDENTITY_POSE, **keys: Any) -> DescribedCollision:
    return DescribedCollision(geometry, pose, HERE, **keys)


def link(name: str, parent: int | None = None, joint: DescribedJoint | None = None, **keys: Any) -> DescribedLink:
    return DescribedLink(name, HERE, parent, joint, **{"collisions": (shape(),), "inertial": MASS, **keys})


def hinge(name: str, **keys: Any) -> DescribedJoint:
    return DescribedJoint(
        name, "revolute", IDENTITY_POSE, IDENTITY_POSE, HERE, **{"limits": (-math.inf, math.inf), **keys}
    )


def body(name: str, **keys: Any) -> DescribedEntity:
    return DescribedEntity(name, DescribedRobot((link(name, **keys),), "dynamic"), HERE)


def written(*entities: DescribedEntity, **keys: Any) -> Node:
    """The document, which must compile."""
    document = write_world(DescribedWorld("test", entities, **keys)).document
    scenecc.compile_scene(document)
    return document


def test_a_collision_and_an_equal_visual_become_one_shape_and_common_keys_move_up() -> None:
    look = DescribedMaterial(base_color=(1.0, 0.0, 0.0, 1.0))
    shapes = [shape(density=500.0, friction=(0.5, 0.5, 0.0)), shape(pose=(0, 0, 1, 1, 0, 0, 0), density=500.0)]
    visual = DescribedVisual(BALL, IDENTITY_POSE, HERE, "red", look)
    inertial = DescribedInertial(3.0, IDENTITY_POSE, None, HERE)
    made = written(
        body("a::b", collisions=tuple(shapes), visuals=(visual,), inertial=inertial),
        physics=DescribedPhysics(friction=(1.0, 1.0, 0.0)),
    )
    friction = {"physical": {"static_friction": 0.5, "dynamic_friction": 0.5, "restitution": 0.0}}
    assert made["entities"]["a.b"] == {
        "mass": 3.0,
        "density": 500.0,
        "color": [1.0, 0.0, 0.0],
        "shapes": [{"type": "sphere", "radius": 0.1, "name": "red", "material": friction}],
        "collisions": [{"type": "sphere", "radius": 0.1, "pose": [0.0, 0.0, 1.0]}],
    }


@pytest.mark.parametrize(
    ("rpy", "axis"),
    [
        ((0, 0, 0), {}),
        ((0, -90, 0), {"axis": "z"}),
        ((0, 90, 0), {"axis": "z"}),
        ((0, 90, 180), {"axis": "z"}),
        ((0, 0, 90), {"axis": "y"}),
    ],
)
def test_round_solids_lie_along_an_axis(rpy: tuple[float, float, float], axis: Node) -> None:
    pose = (0.0, 0.0, 0.0, *from_rpy(*map(math.radians, rpy)))
    made = written(body("a", collisions=(shape(SolidGeometry("capsule", (0.1, 0.2)), pose),)))
    assert made["entities"]["a"]["collisions"] == [{"type": "capsule", "radius": 0.1, "half_length": 0.2, **axis}]


def test_principal_axes_along_those_of_the_link_need_no_rotation() -> None:
    turned = DescribedInertial(2.0, (0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5), (0.1, 0.2, 0.25), HERE)
    made = written(body("a", inertial=turned))
    assert made["entities"]["a"]["inertial"] == {"mass": 2.0, "inertia": [0.25, 0.1, 0.2]}


def test_an_inertial_of_the_shapes_is_a_mass() -> None:
    half, mass = (0.1, 0.2, 0.3), 3.0
    moments = (mass / 3 * (0.04 + 0.09), mass / 3 * (0.01 + 0.09), mass / 3 * (0.01 + 0.04))
    pose = (0.1, 0.0, 0.0, *from_rpy(0.1, 0.2, 0.3))
    inertial = DescribedInertial(mass, pose, moments, HERE)
    box = (shape(SolidGeometry("box", half), pose),)
    assert written(body("a", collisions=box, inertial=inertial))["entities"]["a"]["mass"] == 3.0
    other = DescribedInertial(mass, pose, (*moments[:2], moments[2] * 1.001), HERE)
    assert "inertial" in written(body("a", collisions=box, inertial=other))["entities"]["a"]
    ball = (shape(SolidGeometry("sphere", (0.01,))),)
    small = DescribedInertial(mass, IDENTITY_POSE, (1.2e-4, 1.2e-4, 1.2e-4), HERE)  # SAPIEN computes 6 times as much
    assert "inertial" in written(body("a", collisions=ball, inertial=small))["entities"]["a"]


def test_named_materials_are_shared() -> None:
    box = SolidGeometry("box", (0.1, 0.1, 0.1))
    steel = DescribedMaterial((0.5, 0.5, 0.5, 1.0), name="steel")
    looks = tuple(DescribedVisual(box, IDENTITY_POSE, HERE, look=look) for look in (steel, replace(steel, name="")))
    grip = shape(box, friction=(1.0, 1.0, 0.0), material="rubber")
    bodies = [body("a", visuals=looks), body("b", collisions=(grip,), visuals=looks[:1]), body("c", collisions=(grip,))]
    made = written(*bodies)
    assert [*made["materials"]] == ["steel", "steel_rubber", "rubber"]
    assert made["materials"]["steel"] == {"visual": {"base_color": [0.5, 0.5, 0.5]}}
    first, second = made["entities"]["a"]["visuals"]
    assert (first["material"], second["color"]) == ("steel", [0.5, 0.5, 0.5])
    assert made["entities"]["b"]["material"] == "steel_rubber"
    assert made["entities"]["c"]["material"] == "rubber"


def test_settings_of_all_joints_are_grouped_and_states_are_by_name() -> None:
    drive = DescribedDrive(10.0, 1.0, 5.0, 2.0, "acceleration", 0.5)
    joints = [
        hinge("a b", friction=0.0, damping=0.5, velocity=3.0, limits=(-1.0, 1.0), qpos=2.0, drive=drive),
        hinge("", friction=0.0, damping=0.5, qvel=1.0),
    ]
    robot = DescribedRobot(
        (link("base"), link("one", 0, joints[0]), link("two", 1, joints[1], motion=DescribedMotion(0.1))),
        fixed=False,
        dynamics=DescribedDynamics(linear_velocity=(1.0, 0.0, 0.0), solver_position_iterations=20),
    )
    node = written(DescribedEntity("robot", robot, HERE))["entities"]["robot"]
    assert node["joints"] == {".*": {"friction": 0.0}}
    keys = {"stiffness": 10.0, "damping": 1.5, "force_limit": 5.0, "mode": "acceleration", "velocity_target": 0.5}
    assert node["drives"] == {"a_b": keys}
    assert (node["qpos"], node["qvel"], node["beyond_limits"]) == ({"a_b": 2.0}, {"two_joint": 1.0}, True)
    assert (node["linear_velocity"], node["solver_position_iterations"]) == ([1.0, 0.0, 0.0], 20)
    first = node["root"]["children"][0]
    assert first["joint"] == {"name": "a_b", "type": "revolute", "limits": [-1.0, 1.0], "max_velocity": 3.0}
    assert first["children"][0]["joint"] == {"name": "two_joint", "type": "continuous", "damping": 0.5}
    assert first["children"][0]["linear_damping"] == pytest.approx(0.1)


def test_constraints_lights_and_cameras_are_written() -> None:
    limits: tuple[tuple[LimitAxis, float, float], ...] = (("x", 0.0, 0.5),)
    span = (-1.0, math.inf)
    drive = DescribedDrive(10.0, 1.0, target=0.5)
    ends = (("a", "a"), ("b", "b"), IDENTITY_POSE, IDENTITY_POSE, HERE)
    made = written(
        body("a"),
        body("b"),
        constraints=(
            DescribedConstraint("w", "weld", IN_WORLD, *ends[1:]),
            DescribedConstraint("h", "hinge", *ends, span=span, drives=(("twist", drive),)),
            DescribedConstraint("d", "drive", *ends, limits=limits, drives=(("swing", drive),)),
            DescribedConstraint("l", "distance", *ends, span=(0.1, 0.2)),
        ),
        lights=(DescribedLight("sun", "directional", (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), HERE),),
        cameras=(DescribedCamera("a", IDENTITY_POSE, ("fovy", math.radians(60)), HERE, mount=("a", "a")),),
    )
    named, place = made["constraints"], {"parent": "a", "child": "b", "pose_in_parent": [0.0, 0.0, 0.0]}
    assert named["w"] == {"type": "weld", **place, "parent": "world"}
    motor = {"stiffness": 10.0, "damping": 1.0, "target": 0.5}
    assert named["h"] == {"type": "hinge", **place, "limits": [-1.0, math.inf], "drive": motor}
    swing = {"swing": {"stiffness": 10.0, "damping": 1.0}}
    assert named["d"] == {"type": "drive", **place, "limits": {"x": [0.0, 0.5]}, "drive": swing}
    assert named["l"]["limits"] == pytest.approx([0.1, 0.2])
    assert made["lights"] == {"sun": {"type": "directional", "color": [1.0] * 3, "direction": [0.0, 0.0, -1.0]}}
    assert made["cameras"] == {"a_2": {"mount": "a", "fovy_deg": 60.0}}


def colliding_pairs(document: Node) -> set[frozenset[str]]:
    """Pairs of bodies that collide in the compiled scene, by their integers."""
    plan = scenecc.compile_scene(document)
    bodies = [(entity.name, body) for entity in plan.entities for body in entity.structures[0].bodies]
    found: set[frozenset[str]] = set()
    for (one, first), (two, second) in combinations(bodies, 2):
        rows = [
            [(1, 1, 0, 0) if groups is None else tuple(map(int, groups.numbers())) for groups in body.shape_groups()]
            for body in (first, second)
        ]
        for a in rows[0]:
            for b in rows[1]:
                if (a[0] & b[1] or b[0] & a[1]) and not (a[2] & b[2] and a[3] == b[3]):
                    found.add(frozenset((one, two)))
    return found


def test_ignored_pairs_become_groups() -> None:
    pairs = frozenset(frozenset({("a", "a"), (name, name)}) for name in ("b", "c"))
    made = written(*map(body, "abcd"), ignored=pairs)
    assert made["collision_groups"] == {"a": {"ignore": ["b"]}, "b": {"ignore": ["a"]}}
    assert colliding_pairs(made) == {frozenset(pair) for pair in ("ad", "bc", "bd", "cd")}


def test_bits_that_all_collide_are_not_written() -> None:
    made = written(body("a", collisions=(shape(bits=(3, 2)),)), body("b", collisions=(shape(bits=(65535, 65535)),)))
    assert "collision" not in repr([made.get("collision_groups"), *made["entities"].values()]).replace("collisions", "")


def test_bits_that_separate_single_shapes_stay_bits() -> None:
    two = (shape(bits=(2, 2)), shape(bits=(4, 4)))
    made = written(
        body("a", collisions=two),
        body("b", collisions=(shape(bits=(2, 2)),)),
        body("c", collisions=(shape(bits=(4, 4)),), ignore_bits=1),
        body("d", collisions=(shape(bits=(4, 4)),), ignore_bits=1),
    )
    assert [entry["collision_bits"] for entry in made["entities"]["a"]["collisions"]] == [[2, 2, 0, 0], [4, 4, 0, 0]]
    assert colliding_pairs(made) == {frozenset(pair) for pair in ("ab", "ac", "ad")}


def test_any_number_of_groups_that_ignore_only_themselves_is_written() -> None:
    entities = (body(f"m{i}.{j}", ignore_bits=1 << i) for i in range(40) for j in "ab")
    world = write_world(DescribedWorld("test", tuple(entities)))
    assert world.unwritten == ()
    apart = {frozenset((f"m{i}.a", f"m{i}.b")) for i in range(40)}
    assert len(colliding_pairs(world.document)) == 80 * 79 / 2 - 40
    assert not apart & colliding_pairs(world.document)


def test_robots_without_self_collisions_that_ignore_one_another_share_a_group() -> None:
    links = (link("base", ignore_bits=1), link("one", 0, hinge("x"), ignore_bits=1))
    robot = DescribedRobot(links, self_collisions=False)
    made = written(*(DescribedEntity(name, robot, HERE) for name in ("m.a", "m.b")), body("c"))
    assert made["collision_groups"] == {"m": {"ignore": ["m"]}}
    assert [made["entities"][name].get("collision_group") for name in ("m.a", "m.b", "c")] == ["m", "m", None]


def test_links_that_all_ignore_one_another_have_no_groups() -> None:
    links = (link("base"), link("one", 0, hinge("x")), link("two", 1, hinge("y")), link("three", 2, hinge("z")))
    ignored = frozenset(frozenset({("r", a.name), ("r", b.name)}) for a, b in combinations(links, 2))
    made = written(DescribedEntity("r", DescribedRobot(links), HERE), ignored=ignored)
    assert "collision_groups" not in made
    assert made["entities"]["r"]["disable_self_collisions"] is True


def test_a_joint_of_several_freedoms_gets_light_links() -> None:
    made = split_joint(link("end", 0), [hinge("x"), hinge("y"), hinge("z")], ["p", "q"], 1)
    assert [(each.name, each.parent) for each in made] == [("p", 0), ("q", 1), ("end", 2)]
    assert made[0].inertial == light_link(2.0, 0.25, HERE)
    assert light_link(2.0, 0.25, HERE).inertia == pytest.approx((2.5e-4,) * 3)
    written(DescribedEntity("r", DescribedRobot((link("base"), *made)), HERE))


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"damping": 0.5}, {"friction_force": 5.0}),
        ({"damping": 0.6}, {"damping": 0.6}),
        ({"damping": 0.5, "drive": DescribedDrive(1.0, 0.0)}, {}),
    ],
)
def test_a_joint_has_its_friction_force_or_its_damping(keys: dict[str, Any], expected: dict[str, float]) -> None:
    links = (link("base"), link("arm", 0, hinge("j", friction_force=5.0, **keys)))
    made = written(DescribedEntity("r", DescribedRobot(links), HERE))
    joint = made["entities"]["r"]["root"]["children"][0]["joint"]
    assert joint == {"name": "j", "type": "continuous", **expected}


def test_hinges_have_the_axis_that_needs_the_fewest_rotations() -> None:
    turn = (0.5**0.5, 0.0, 0.0, 0.5**0.5)
    frames = (1.0, 0.0, 0.0, *turn), (0.0, 0.0, 0.0, *turn)
    named = DescribedConstraint("h", "hinge", IN_WORLD, ("a", "a"), *frames, HERE)
    made = written(body("a"), constraints=(named,))["constraints"]["h"]
    assert made == {"type": "hinge", "parent": "world", "child": "a", "axis": "y", "pose_in_parent": [1.0, 0.0, 0.0]}


def test_the_largest_moment_is_at_most_the_sum_of_the_others() -> None:
    assert enforce_triangle_rule((1.0, 2.0, 4.0)) == (1.0, 2.0, 3.0)
    assert enforce_triangle_rule((1.0, 2.0, 2.5)) == (1.0, 2.0, 2.5)
