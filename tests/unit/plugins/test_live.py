"""The bench that compares live scenes notices everything that SAPIEN can tell of them."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sapien
import trimesh
from plugins.maniskill_tasks import renamed
from plugins.trajectory import first_difference, trajectory
from sapien import physx

from scenecc.decompiler import tables
from scenecc.decompiler.reading import articulations, comparable_value, read_scene
from scenecc.decompiler.verify import differences
from scenecc.plan.scene import SCENE_CONFIG_FIELDS

TURNED = [0.7071068, 0, 0, 0.7071068]


def built(density: float = 1000, lift: float = 0, hinge: str = "revolute") -> SimpleNamespace:
    """A scene with a body of every type, an articulation of two joints, and a joint of every type between bodies."""
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    arm = _arm(scene, hinge)
    ground = scene.create_actor_builder()
    ground.add_plane_collision(sapien.Pose(q=[0.7071068, 0, -0.7071068, 0]))
    floor = ground.build_static("ground")
    box: Any = scene.create_actor_builder()
    box.set_initial_pose(sapien.Pose([0, 0.5, 0.3]))
    box.add_box_collision(sapien.Pose([0, 0, lift]), half_size=[0.1, 0.1, 0.1], density=density)
    box.add_sphere_collision(sapien.Pose([0, 0, 0.1]), radius=0.05)
    body = box.build("box")
    dynamic: Any = body.find_component_by_type(physx.PhysxRigidDynamicComponent)
    shelf = scene.create_actor_builder()
    shelf.set_initial_pose(sapien.Pose([0, -1, 0.5]))
    shelf.add_capsule_collision(radius=0.1, half_length=0.2)
    shelf.add_cylinder_collision(radius=0.1, half_length=0.2)
    shelf = shelf.build_kinematic("shelf")
    drive = scene.create_drive(shelf, sapien.Pose(), body, sapien.Pose([0, 0, 0.2]))
    gear = scene.create_gear(floor, sapien.Pose(), body, sapien.Pose())
    return SimpleNamespace(
        scene=scene,
        config=scene.physx_system.config,
        entity=body,
        body=dynamic,
        shelf=shelf,
        shape=dynamic.collision_shapes[0],
        arm=arm,
        joint=arm.active_joints[0],
        link=arm.links[1],
        drive=drive,
        gear=gear,
    )


def _arm(scene: Any, hinge: str = "revolute") -> Any:
    builder = scene.create_articulation_builder()
    root = builder.create_link_builder()
    root.set_name("root")
    root.add_box_collision(half_size=[0.1, 0.1, 0.1])
    parent = root
    for name in ("upper", "lower"):
        link = builder.create_link_builder(parent)
        link.set_name(name)
        link.set_joint_name(f"to_{name}")
        link.add_box_collision(sapien.Pose([0.2, 0, 0]), half_size=[0.15, 0.02, 0.02])
        there, here = sapien.Pose([0.15, 0, 0.2], TURNED), sapien.Pose([0, 0, 0], TURNED)
        link.set_joint_properties(hinge, [[-2, 2]], there, here, 0.1, 1)
        parent = link
    builder.set_initial_pose(sapien.Pose([2, 0, 0.5]))
    arm = builder.build(fix_root_link=True)
    arm.name = "arm"
    return arm


def _material(shape: Any, *numbers: float) -> None:
    shape.set_physical_material(physx.PhysxMaterial(*numbers))


A_BIT_ABOVE = np.nextafter(np.float32(0.3), np.float32(1))

SABOTAGES: dict[str, Callable[[SimpleNamespace], object]] = {
    "entity(box).name": lambda it: it.entity.set_name("crate"),
    "entity(box).pose": lambda it: it.entity.set_pose(
        sapien.Pose([0, 0.5, np.nextafter(np.float32(0.3), np.float32(1))])
    ),
    ".timestep": lambda it: it.scene.set_timestep(0.02),
    ".mass": lambda it: it.body.set_mass(0.1),
    ".inertia": lambda it: it.body.set_inertia([1, 1, 1]),
    ".cmass_local_pose": lambda it: it.body.set_cmass_local_pose(sapien.Pose([0, 0, 0.01])),
    ".disable_gravity": lambda it: it.body.set_disable_gravity(True),
    ".linear_damping": lambda it: it.body.set_linear_damping(0.01),
    ".angular_damping": lambda it: it.body.set_angular_damping(0.01),
    ".linear_velocity": lambda it: it.body.set_linear_velocity([0, 0, 1e-9]),
    ".angular_velocity": lambda it: it.body.set_angular_velocity([0, 0, 1e-9]),
    ".max_linear_velocity": lambda it: it.body.set_max_linear_velocity(3),
    ".max_angular_velocity": lambda it: it.body.set_max_angular_velocity(3),
    ".max_depenetration_velocity": lambda it: it.body.set_max_depenetration_velocity(3),
    ".max_contact_impulse": lambda it: it.body.set_max_contact_impulse(3),
    ".kinematic": lambda it: it.body.set_kinematic(True),
    ".locked_motion_axes": lambda it: it.body.set_locked_motion_axes([False, False, True, False, False, False]),
    ".sleep_threshold": lambda it: it.body.set_sleep_threshold(0.1),
    ".solver_position_iterations": lambda it: it.body.set_solver_position_iterations(3),
    ".solver_velocity_iterations": lambda it: it.body.set_solver_velocity_iterations(3),
    ".is_sleeping": lambda it: it.body.put_to_sleep(),
    "PhysxCollisionShapeBox[0].collision_groups": lambda it: it.shape.set_collision_groups([1, 1, 4, 0]),
    "PhysxCollisionShapeBox[0].contact_offset": lambda it: it.shape.set_contact_offset(0.03),
    "PhysxCollisionShapeBox[0].rest_offset": lambda it: it.shape.set_rest_offset(0.001),
    "PhysxCollisionShapeBox[0].patch_radius": lambda it: it.shape.set_patch_radius(0.03),
    "PhysxCollisionShapeBox[0].min_patch_radius": lambda it: it.shape.set_min_patch_radius(0.03),
    "material[0].static_friction": lambda it: _material(it.shape, 0.9, 0.3, 0.1),
    "material[0].dynamic_friction": lambda it: _material(it.shape, 0.3, 0.2, 0.1),
    "material[0].restitution": lambda it: _material(it.shape, 0.3, 0.3, 0.5),
    "articulation(arm).qpos": lambda it: it.arm.set_qpos([0.1, 0]),
    "articulation(arm).qvel": lambda it: it.arm.set_qvel([0.1, 0]),
    "articulation(arm).qf": lambda it: it.arm.set_qf([0.1, 0]),
    "articulation(arm).qlimits": lambda it: it.joint.set_limits([[-1, 2]]),
    "articulation(arm).root_pose": lambda it: it.arm.set_root_pose(sapien.Pose([2, 0, 0.6])),
    "articulation(arm).solver_position_iterations": lambda it: it.arm.set_solver_position_iterations(2),
    "articulation(arm).solver_velocity_iterations": lambda it: it.arm.set_solver_velocity_iterations(2),
    "articulation(arm).sleep_threshold": lambda it: it.arm.set_sleep_threshold(0.1),
    "joint(to_upper).limits": lambda it: it.joint.set_limits([[-1, 2]]),
    "joint(to_upper).friction": lambda it: it.joint.set_friction(0.3),
    "joint(to_upper).armature": lambda it: it.joint.set_armature([0.3]),
    "joint(to_upper).max_velocity": lambda it: it.joint.set_max_velocity(0.3),
    "joint(to_upper).pose_in_parent": lambda it: it.joint.set_pose_in_parent(sapien.Pose([0.1, 0, 0])),
    "joint(to_upper).pose_in_child": lambda it: it.joint.set_pose_in_child(sapien.Pose([0.1, 0, 0])),
    "joint(to_upper).stiffness": lambda it: it.joint.set_drive_properties(5, 1),
    "joint(to_upper).damping": lambda it: it.joint.set_drive_properties(0, 3),
    "joint(to_upper).force_limit": lambda it: it.joint.set_drive_properties(0, 1, 7),
    "joint(to_upper).drive_mode": lambda it: it.joint.set_drive_properties(0, 1, mode="acceleration"),
    "joint(to_upper).drive_target": lambda it: it.joint.set_drive_target(0.2),
    "joint(to_upper).drive_velocity_target": lambda it: it.joint.set_drive_velocity_target(0.2),
    "entity(upper)/PhysxArticulationLinkComponent": lambda it: it.link.set_linear_damping(0.7),
    ".limit_x": lambda it: it.drive.set_limit_x(-1, 1),
    ".limit_twist": lambda it: it.drive.set_limit_twist(-1, 1),
    ".limit_cone": lambda it: it.drive.set_limit_cone(1, 1),
    ".drive_property_y": lambda it: it.drive.set_drive_property_y(4, 1),
    ".drive_property_slerp": lambda it: it.drive.set_drive_property_slerp(4, 1),
    ".pose_in_child": lambda it: it.drive.set_pose_in_child(sapien.Pose()),
    "PhysxDriveComponent[1].drive_target": lambda it: it.drive.set_drive_target(sapien.Pose([1, 0, 0])),
    "PhysxDriveComponent[1].drive_velocity_target": lambda it: it.drive.set_drive_velocity_target([1, 0, 0], [0, 0, 0]),
    ".gear_ratio": lambda it: it.gear.set_gear_ratio(3),
    "PhysxGearComponent[2].is_enabled": lambda it: it.gear.disable(),
    "entity(more): only in the second": lambda it: it.scene.create_actor_builder().build_kinematic("more"),
    "entity(shelf): only in the first": lambda it: it.scene.remove_actor(it.shelf),
}


@pytest.mark.parametrize("told", SABOTAGES)
def test_whatever_is_changed_is_told_with_object_and_property(told: str):
    clean, changed = built(), built()
    SABOTAGES[told](changed)
    found = differences(read_scene(clean.scene), read_scene(changed.scene))
    assert any(told in line for line in found), found
    assert all(" against " in line or "only in the" in line for line in found)


@pytest.mark.parametrize(
    ("told", "other"),
    [
        ("PhysxCollisionShapeBox[0].local_pose", {"lift": 0.01}),
        ("PhysxCollisionShapeBox[0].density", {"density": 5}),
        ("joint(to_upper).type", {"hinge": "revolute_unwrapped"}),
    ],
)
def test_what_only_a_builder_can_change_is_told_too(told: str, other: dict[str, Any]):
    found = differences(read_scene(built().scene), read_scene(built(**other).scene))
    assert any(told in line for line in found), found


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gravity", [0, 0, -3]),
        ("bounce_threshold", 5),
        ("enable_pcm", False),
        ("enable_tgs", False),
        ("enable_ccd", True),
        ("enable_enhanced_determinism", True),
        ("enable_friction_every_iteration", False),
    ],
)
def test_settings_of_the_scene_are_told(name: str, value: Any):
    before = {key: getattr(physx.get_scene_config(), key) for key in SCENE_CONFIG_FIELDS}
    usual = read_scene(built().scene)
    try:
        physx.set_scene_config(**{**before, name: value})
        other = read_scene(built().scene)
    finally:
        physx.set_scene_config(**before)
    (told,) = differences(usual, other)
    assert told.startswith(f"scene[0].{name}: ")


@pytest.mark.parametrize(
    ("told", "add"),
    [
        ("half_size", lambda builder, size: builder.add_box_collision(half_size=[0.1, size, 0.1])),
        ("radius", lambda builder, size: builder.add_sphere_collision(radius=size)),
        ("half_length", lambda builder, size: builder.add_capsule_collision(radius=0.1, half_length=size)),
        ("radius", lambda builder, size: builder.add_cylinder_collision(radius=size, half_length=0.1)),
    ],
)
def test_sizes_of_shapes_are_told(told: str, add: Callable[[Any, float], object]):
    def one(size: float) -> Any:
        builder: Any = sapien.Scene([physx.PhysxCpuSystem()]).create_actor_builder()
        add(builder, size)
        return read_scene(builder.build("body").scene)

    assert differences(one(0.1), one(0.1)) == []
    assert any(f"[0].{told}: " in line for line in differences(one(0.1), one(0.2)))


@pytest.mark.parametrize("kind", ["convex", "nonconvex"])
def test_meshes_are_told_by_their_vertices(kind: str, tmp_path: Path):
    def one(file: str, height: float) -> Any:
        box = trimesh.creation.box((0.1, 0.1, height))
        box.export(tmp_path / file)
        builder: Any = sapien.Scene([physx.PhysxCpuSystem()]).create_actor_builder()
        getattr(builder, f"add_{kind}_collision_from_file")(str(tmp_path / file))
        return read_scene(builder.build_kinematic("body").scene)

    low, high = one("low.stl", 0.1), one("high.stl", 0.2)
    assert differences(low, one("again.stl", 0.1)) == []
    assert any(".vertices: " in line and "numbers, first at" in line for line in differences(low, high))


def test_two_scenes_built_alike_do_not_differ_and_move_alike():
    a, b = built(), built()
    assert differences(read_scene(a.scene), read_scene(b.scene)) == []
    assert first_difference(trajectory(a.scene, 20), trajectory(b.scene, 20)) is None


def test_what_was_read_holds_nothing_of_the_engine():
    facts = read_scene(built().scene)
    assert pickle.loads(pickle.dumps(facts)) == facts
    assert hash(facts) == hash(pickle.loads(pickle.dumps(facts)))


def test_the_sign_of_a_zero_is_no_difference_and_the_last_bit_is():
    assert comparable_value(np.array([0.0], np.float32)) == comparable_value(np.array([-0.0], np.float32))
    assert comparable_value(-0.0) == comparable_value(0.0)
    assert comparable_value(np.float32(0.3)) != comparable_value(np.nextafter(np.float32(0.3), np.float32(1)))
    assert comparable_value(float("nan")) == comparable_value(float("nan"))


def test_the_order_of_two_bodies_counts():
    def stacked(*names: str) -> Any:
        scene = sapien.Scene([physx.PhysxCpuSystem()])
        for name in names:
            builder: Any = scene.create_actor_builder()
            builder.add_box_collision(half_size=[0.1, 0.1, 0.1], density=1000 if name == "a" else 500)
            builder.build(name)
        return read_scene(scene)

    found = differences(stacked("a", "b"), stacked("b", "a"))
    assert "scene[0]/entity(a).name: 'a' against 'b'" in found
    assert "scene[0]/entity(a)/PhysxRigidDynamicComponent(a).mass: 8.0 against 4.0" in found


def test_properties_can_be_left_out_of_a_comparison():
    a, b = built(), built()
    b.entity.name = "crate"
    b.body.linear_damping = 1
    b.joint.set_friction(1)
    found = differences(read_scene(a.scene), read_scene(b.scene), without={"name", "joint.friction"})
    assert [line.split(": ")[1] for line in found] == ["0.0 against 1.0"]
    assert not differences(read_scene(a.scene), read_scene(b.scene), without={"name", "linear_damping", "friction"})


def test_names_can_be_changed_everywhere():
    facts = renamed(read_scene(built().scene), str.upper)
    (arm,) = facts.of_kind("articulation")
    assert arm.name == "ARM"
    assert arm.value("joints") == ("", "TO_UPPER", "TO_LOWER")
    lower = facts.of_kind("PhysxArticulationLinkComponent")[2]
    assert (lower.name, lower.value("parent"), lower.value("articulation")) == ("LOWER", "UPPER", "ARM")


def test_a_trajectory_has_every_step_of_every_body_and_tells_where_two_part():
    a, b = built(), built()
    b.body.set_linear_velocity([0, 0, 1e-3])
    one, other = trajectory(a.scene, 5), trajectory(b.scene, 5)
    assert one.states.shape == (6, 6 * 7 + 5 * 6 + 2 + 2)
    at = one.labels.index("pose of box[0]")
    np.testing.assert_array_equal(one.states[5, at : at + 3], a.entity.pose.p)
    at = one.labels.index("qpos of arm[0]")
    assert not np.array_equal(one.states[0, at : at + 2], one.states[5, at : at + 2])
    told = first_difference(one, other)
    assert told is not None
    assert told.startswith("step 0: velocity of box[2] is 0.0 against 0.001")


def test_scenes_of_different_size_are_told_apart_before_they_are_compared():
    a, b = built(), built()
    b.scene.remove_actor(b.shelf)
    assert first_difference(trajectory(a.scene, 2), trajectory(b.scene, 2)) == (
        "(steps + 1, numbers) are (3, 76) against (3, 63)"
    )


def test_articulations_stand_in_the_order_of_their_links():
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    first, second = _arm(scene), _arm(scene)
    second.name = "other"
    assert [robot.name for robot in articulations(scene)] == [first.name, second.name]


def _component(name: str) -> type:
    return getattr(physx, name, None) or getattr(sapien.render, name)


CLASSES = {
    **{
        name: (getattr(physx, name, None) or getattr(sapien.render, name), read)
        for name, read in tables.COMPONENTS.items()
    },
    **{name: (getattr(physx, name), read) for name, read in tables.SHAPES.items()},
    **{name: (getattr(sapien.render, name), (*read, *tables.VISUAL)) for name, read in tables.VISUALS.items()},
    "PhysxArticulation": (physx.PhysxArticulation, tables.ARTICULATION),
    "PhysxArticulationJoint": (physx.PhysxArticulationJoint, tables.JOINT + tables.AXIS),
    "PhysxMaterial": (physx.PhysxMaterial, tables.PHYSICAL_MATERIAL),
    "PhysxSceneConfig": (physx.PhysxSceneConfig, SCENE_CONFIG_FIELDS),
    "RenderMaterial": (
        sapien.render.RenderMaterial,
        (*tables.VISUAL_MATERIAL, *(f"{name}_texture" for name in tables.TEXTURES)),
    ),
}


DERIVED = {
    "pose": "the entity's, which is read",
    "entity_pose": "the entity's, which is read",
    "global_pose": "follows from the entity's pose and the local one",
    "relative_pose": "follows from the poses of the two bodies",
    "entity": "an object",
    "scene": "an object",
    "articulation": "an object",
    "parent": "an object, read by its name",
    "children": "objects, whose parent is read",
    "joint": "an object, read as a part",
    "parent_link": "an object, read as the link's parent",
    "child_link": "an object: the link that the joint is read for",
    "root": "an object: the first link",
    "links": "objects, read by their names",
    "joints": "objects, read by their names",
    "active_joints": "objects, read by their names",
    "collision_shapes": "objects, read as parts",
    "render_shapes": "objects, read as parts",
    "physical_material": "an object, read as a part",
    "material": "an object, read as a part",
    "parts": "objects, read as parts",
    "name": "stands as the name",
    "limit": "`limits` again",
    "qlimit": "`qlimits` again",
    "fovx": "follows from fx and the width",
    "fovy": "follows from fy and the height",
    "distance": "of the two bodies now: follows from their poses",
    "qacc": "what the last step computed",
    "link_incoming_joint_forces": "what the last step computed",
    "kinematic_target": "cannot be read where none is set, and a step consumes it",
    "gpu_index": "a place in a buffer",
    "gpu_pose_index": "a place in a buffer",
    "per_scene_id": "counts the objects of the process",
    "texture": "of a light, an object of the device",
    "vertices": "of a primitive that is seen: follows from its sizes",
    "triangles": "of a primitive that is seen: follows from its sizes",
    "vertex_normal": "of a primitive that is seen: follows from its sizes",
    "vertex_uv": "of a primitive that is seen: follows from its sizes",
    "diffuse_texture": "`base_color_texture` again",
}
"""Properties that are not read as values, and why."""


@pytest.mark.parametrize("name", CLASSES)
def test_no_property_of_a_class_is_forgotten(name: str):
    cls, read = CLASSES[name]
    has = {
        key
        for base in cls.__mro__
        for key, member in vars(base).items()
        if isinstance(member, property) and not key.startswith("_")
    }
    assert has - set(read) - set(DERIVED) == set()
    assert {key for key in read if not hasattr(cls, key) and not hasattr(cls, f"get_{key}")} == set()
