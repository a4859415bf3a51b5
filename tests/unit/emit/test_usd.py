"""USD, opened again by usd-core."""

from __future__ import annotations

import math
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from plugins.plan_parts import ROOT

import scenecc
from scenecc import open_scene
from scenecc.backends.sapien import instantiate
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.extras import install_hint

Gf: Any = import_module("pxr.Gf")  # usd-core says nothing of its types
Usd: Any = import_module("pxr.Usd")
UsdGeom: Any = import_module("pxr.UsdGeom")
UsdPhysics: Any = import_module("pxr.UsdPhysics")
UsdShade: Any = import_module("pxr.UsdShade")

Emitted = tuple[dict[str, bytes], list[Diagnostic]]


def emitted(source: Any, **options: Any) -> Emitted:
    choices = {name: options.pop(name) for name in ("show", "binary", "scene") if name in options}
    made = open_scene(source, **options).emit("usd", name="out", **choices)
    return made.files, made.diagnostics


def opened(files: dict[str, bytes], folder: Path) -> Any:
    """The stage of a file and its images, in a folder of their own."""
    for name, data in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(data)
    return Usd.Stage.Open(str(folder / next(iter(files))))


def place(stage: Any, path: str) -> np.ndarray:
    """(4, 4) from a prim's frame to the world, as a matrix that stands before a column."""
    return np.array(UsdGeom.Xformable(stage.GetPrimAtPath(path)).ComputeLocalToWorldTransform(Usd.TimeCode.Default())).T


def bounds(stage: Any, path: str, *purposes: str) -> np.ndarray:
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), list(purposes or ["default"]))
    box = cache.ComputeWorldBound(stage.GetPrimAtPath(path)).ComputeAlignedRange()
    return np.array([list(box.GetMin()), list(box.GetMax())])


TOYS = {
    "scenecc": 1,
    "physics": {"gravity": [0, 0, -1.62]},
    "entities": {
        "my-box": {"pose": [1, 2, 3], "shapes": [{"type": "box", "half_size": [0.1, 0.2, 0.3]}], "mass": 2},
        "rod": {"shapes": [{"type": "capsule", "radius": 0.1, "half_length": 0.4, "axis": "z"}], "pose": [5, 0, 0]},
        "can": {"shapes": [{"type": "cylinder", "radius": 0.1, "half_length": 0.4}], "body_type": "kinematic"},
        "ball": {
            "body_type": "static",
            "material": {"physical": {"static_friction": 0.9, "dynamic_friction": 0.8, "restitution": 0.7}},
            "shapes": [{"type": "sphere", "radius": 0.5}],
        },
        "ground": {"body_type": "static", "shapes": [{"type": "plane"}]},
        "ghost": {"body_type": "none", "visuals": [{"type": "sphere", "radius": 1}]},
    },
}


def test_a_stage_is_in_metres_with_z_up_and_its_gravity(tmp_path: Path) -> None:
    files, told = emitted(TOYS)
    assert not told
    assert list(files) == ["out.usda"]
    stage = opened(files, tmp_path)
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    scene = UsdPhysics.Scene(stage.GetPrimAtPath("/World/PhysicsScene"))
    assert scene.GetGravityMagnitudeAttr().Get() == pytest.approx(1.62)
    assert list(scene.GetGravityDirectionAttr().Get()) == [0, 0, -1]


def test_usd_extents_of_visual_and_collision_shapes(tmp_path: Path) -> None:
    stage = opened(emitted(TOYS)[0], tmp_path)
    for purpose in ("default", "guide"):
        assert_allclose(bounds(stage, "/World/my_box", purpose), [[0.9, 1.8, 2.7], [1.1, 2.2, 3.3]], atol=1e-6)
        assert_allclose(bounds(stage, "/World/rod", purpose), [[4.9, -0.1, -0.5], [5.1, 0.1, 0.5]], atol=1e-6)
        assert_allclose(bounds(stage, "/World/can", purpose), [[-0.4, -0.1, -0.1], [0.4, 0.1, 0.1]], atol=1e-6)
        assert_allclose(bounds(stage, "/World/ball", purpose), [[-0.5] * 3, [0.5] * 3], atol=1e-6)
    assert stage.GetPrimAtPath("/World/my_box").GetDisplayName() == "my-box"
    # A plane's normal is its x, which the pose turns up.
    assert_allclose(place(stage, "/World/ground/plane_collision")[:3, 0], [0, 0, 1], atol=1e-6)


def test_usd_masses_and_body_types_are_those_of_the_engine(tmp_path: Path) -> None:
    stage = opened(emitted(TOYS)[0], tmp_path)
    batch = instantiate(scenecc.compile_scene(TOYS), Sink(), render=False)
    assert batch is not None
    with batch:
        for name in ("my-box", "rod"):
            obj: Any = batch.entities[name].objs[0]
            component = next(one for one in obj.components if hasattr(one, "mass"))
            mass = UsdPhysics.MassAPI(stage.GetPrimAtPath(f"/World/{name.replace('-', '_')}"))
            assert mass.GetMassAttr().Get() == component.mass
            assert_allclose(mass.GetDiagonalInertiaAttr().Get(), component.inertia)
            assert_allclose(mass.GetCenterOfMassAttr().Get(), component.cmass_local_pose.p)
            axes = mass.GetPrincipalAxesAttr().Get()
            assert_allclose([axes.real, *axes.imaginary], component.cmass_local_pose.q)
    prims = {name: stage.GetPrimAtPath(f"/World/{name}") for name in ("my_box", "can", "ball", "ghost")}
    rigid = {name: prim.HasAPI(UsdPhysics.RigidBodyAPI) for name, prim in prims.items()}
    assert rigid == {"my_box": True, "can": True, "ball": False, "ghost": False}
    assert UsdPhysics.RigidBodyAPI(prims["can"]).GetKinematicEnabledAttr().Get()
    assert not UsdPhysics.RigidBodyAPI(prims["my_box"]).GetKinematicEnabledAttr().Get()
    assert stage.GetPrimAtPath("/World/ball/sphere_collision").HasAPI(UsdPhysics.CollisionAPI)
    assert not stage.GetPrimAtPath("/World/ghost/sphere").HasAPI(UsdPhysics.CollisionAPI)


def test_usd_friction_is_a_physics_material(tmp_path: Path) -> None:
    stage = opened(emitted(TOYS)[0], tmp_path)
    binding = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/World/ball/sphere_collision"))
    material = UsdPhysics.MaterialAPI(binding.ComputeBoundMaterial("physics")[0].GetPrim())
    numbers = [material.GetStaticFrictionAttr(), material.GetDynamicFrictionAttr(), material.GetRestitutionAttr()]
    assert_allclose([one.Get() for one in numbers], [0.9, 0.8, 0.7])


def test_usd_materials_are_preview_surfaces_with_image_files(tmp_path: Path) -> None:
    (tmp_path / "checker.png").write_bytes((ROOT / "scenes" / "assets" / "checker.png").read_bytes())
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scenecc: 1\nmaterials:\n"
        "  paint: {visual: {base_color: [0.1, 0.2, 0.3, 0.5], metallic: 0.25, roughness: 0.75, specular: 0.5, "
        "emission: [1, 0.5, 0, 2]}}\n"
        "  checked: {visual: {base_color_texture: checker.png}}\n"
        "entities:\n  a: {body_type: static, material: paint, shapes: [{type: sphere, radius: 1}]}\n"
        "  b: {body_type: static, material: checked, shapes: [{type: sphere, radius: 1}], visibility: 0.25}\n",
        encoding="utf-8",
    )
    files, told = emitted(scene)
    assert not told
    _, image = files
    assert files[image] == (ROOT / "scenes" / "assets" / "checker.png").read_bytes()
    stage = opened(files, tmp_path)

    def surface(path: str) -> Any:
        material, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)).ComputeBoundMaterial()
        return material.ComputeSurfaceSource()[0]

    paint = surface("/World/a/sphere")
    assert paint.GetIdAttr().Get() == "UsdPreviewSurface"
    numbers = {name: paint.GetInput(name).Get() for name in ("opacity", "metallic", "roughness", "ior")}
    assert numbers == pytest.approx({"opacity": 0.5, "metallic": 0.25, "roughness": 0.75, "ior": 1.5})
    assert_allclose(paint.GetInput("diffuseColor").Get(), [0.1, 0.2, 0.3])
    assert_allclose(paint.GetInput("emissiveColor").Get(), [2, 1, 0])
    texture, _, _ = surface("/World/b/sphere").GetInput("diffuseColor").GetConnectedSource()
    assert surface("/World/b/sphere").GetInput("opacity").Get() == 0.25
    file = UsdShade.Shader(texture.GetPrim()).GetInput("file").Get()
    assert Path(file.resolvedPath) == tmp_path / image


def test_usd_meshes_are_scaled_and_collide_as_cooked(tmp_path: Path) -> None:
    (tmp_path / "gem.stl").write_bytes((ROOT / "scenes" / "assets" / "gem.stl").read_bytes())
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scenecc: 1\nentities:\n  gem:\n    collisions: [{type: convex_mesh, file: gem.stl, scale: [2, 2, 4]}]\n"
        "    visuals: [{type: mesh, file: gem.stl, scale: [2, -2, 4]}]\n"
        "  dish: {body_type: static, shapes: [{type: triangle_mesh, file: gem.stl}]}\n",
        encoding="utf-8",
    )
    stage = opened(emitted(scene)[0], tmp_path)
    for purpose in ("default", "guide"):
        found = bounds(stage, "/World/gem", purpose)
        assert_allclose(found, [[-0.06, -0.06, 0], [0.06, 0.06, 0.18]], atol=2e-3)
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/gem/mesh"))
    points, faces = np.array(mesh.GetPointsAttr().Get()), np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    a, b, c = (points[faces[:, k]].astype(float) for k in range(3))
    assert (np.cross(a, b) * c).sum() > 0, "a mirrored mesh is seen from outside"

    def approximation(path: str) -> str:
        return UsdPhysics.MeshCollisionAPI(stage.GetPrimAtPath(path)).GetApproximationAttr().Get()

    assert approximation("/World/gem/convex_mesh_collision") == "convexHull"
    assert approximation("/World/dish/triangle_mesh_collision") == "none"


def test_a_robot_has_joints_limits_and_drives_in_usd(tmp_path: Path) -> None:
    path = ROOT / "scenes" / "robot_door.yaml"
    stage = opened(emitted(path, scene=2)[0], tmp_path)
    door = stage.GetPrimAtPath("/World/door")
    assert door.HasAPI(UsdPhysics.ArticulationRootAPI)
    hinge = UsdPhysics.RevoluteJoint(stage.GetPrimAtPath("/World/door/hinge"))
    assert [str(one) for one in hinge.GetBody0Rel().GetTargets()] == ["/World/door/frame"]
    assert [str(one) for one in hinge.GetBody1Rel().GetTargets()] == ["/World/door/panel"]
    assert hinge.GetLowerLimitAttr().Get() == pytest.approx(0)
    assert hinge.GetUpperLimitAttr().Get() == pytest.approx(90)
    batch = instantiate(scenecc.compile_scene(path), Sink(), scene_idxs=[2], render=False)
    assert batch is not None
    with batch:
        robot = batch.articulations["door"].objs[0]
        drive = UsdPhysics.DriveAPI(hinge.GetPrim(), "angular")
        (joint,) = robot.get_active_joints()
        assert drive.GetStiffnessAttr().Get() == pytest.approx(math.radians(joint.stiffness))
        assert drive.GetDampingAttr().Get() == pytest.approx(math.radians(joint.damping))
        assert drive.GetTargetPositionAttr().Get() == pytest.approx(math.degrees(joint.drive_target[0]), rel=1e-6)
        for link in robot.get_links():
            world = place(stage, f"/World/door/{link.name}")
            assert_allclose(world, link.entity_pose.to_transformation_matrix(), atol=2e-6)
            mass = UsdPhysics.MassAPI(stage.GetPrimAtPath(f"/World/door/{link.name}"))
            assert mass.GetMassAttr().Get() == link.mass
    fixed = UsdPhysics.FixedJoint(stage.GetPrimAtPath("/World/door/fix_root_link"))
    assert not fixed.GetBody0Rel().GetTargets()


def test_both_frames_of_a_usd_joint_coincide_at_rest(tmp_path: Path) -> None:
    """At the start a fixed joint's frames are in one place, and others' origins are on one axis."""
    stage = opened(emitted(ROOT / "scenes" / "robot_arm.yaml")[0], tmp_path)
    joints = [UsdPhysics.Joint(prim) for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)]
    assert len(joints) >= 6
    for joint in joints:
        frames = []
        for targets, position, rotation in (
            (joint.GetBody0Rel(), joint.GetLocalPos0Attr(), joint.GetLocalRot0Attr()),
            (joint.GetBody1Rel(), joint.GetLocalPos1Attr(), joint.GetLocalRot1Attr()),
        ):
            local = np.eye(4)
            local[:3, :3] = np.array(Gf.Matrix3d(Gf.Quatd(rotation.Get()))).T
            local[:3, 3] = position.Get()
            body = [str(one) for one in targets.GetTargets()]
            frames.append(place(stage, body[0]) @ local if body else local)
        first, second = frames
        if joint.GetPrim().IsA(UsdPhysics.FixedJoint):
            assert_allclose(first, second, atol=1e-5)
        else:
            assert_allclose(first[:3, 0], second[:3, 0], atol=1e-5)
            across = np.cross(second[:3, 3] - first[:3, 3], first[:3, 0])
            assert_allclose(across, 0, atol=1e-5)


def test_constraints_are_joints_in_usd(tmp_path: Path) -> None:
    body = {"shapes": [{"type": "sphere", "radius": 0.1}]}
    drive = {
        "limits": {"x": [-0.5, 0.25], "twist": [-math.pi / 2, math.pi / 4]},
        "drive": {"y": {"stiffness": 7, "damping": 3, "force_limit": 11}, "slerp": {"stiffness": 180, "damping": 90}},
        "target": [0, 0.125, 0],
    }
    source = {
        "scenecc": 1,
        "entities": {name: {**body, "pose": [i, 0, 1]} for i, name in enumerate("abcde")},
        "constraints": {
            "glue": {"type": "weld", "parent": "a", "child": "b"},
            "joint": {"type": "connection", "parent": "b", "child": "c"},
            "rope": {
                "type": "distance",
                "parent": "world",
                "child": "d",
                "limits": [0.5, 2],
                "pose_in_parent": [0, 0, 2],
            },
            "motor": {"type": "drive", "parent": "a", "child": "e", **drive},
        },
    }
    files, told = emitted(source)
    assert not told
    stage = opened(files, tmp_path)
    kinds = {name: stage.GetPrimAtPath(f"/World/{name}").GetTypeName() for name in ("glue", "joint", "rope", "motor")}
    assert kinds == {
        "glue": "PhysicsFixedJoint",
        "joint": "PhysicsSphericalJoint",
        "rope": "PhysicsDistanceJoint",
        "motor": "PhysicsJoint",
    }
    rope = UsdPhysics.DistanceJoint(stage.GetPrimAtPath("/World/rope"))
    assert (rope.GetMinDistanceAttr().Get(), rope.GetMaxDistanceAttr().Get()) == (0.5, 2)
    assert list(rope.GetLocalPos0Attr().Get()) == [0, 0, 2]
    assert not rope.GetBody0Rel().GetTargets()
    # As in PhysX: what a constraint ties to the world collides with it, and two bodies do not collide.
    assert rope.GetCollisionEnabledAttr().Get()
    assert not UsdPhysics.Joint(stage.GetPrimAtPath("/World/glue")).GetCollisionEnabledAttr().Get()
    motor = stage.GetPrimAtPath("/World/motor")

    def limits(freedom: str) -> tuple[float, float]:
        api = UsdPhysics.LimitAPI(motor, freedom)
        return api.GetLowAttr().Get(), api.GetHighAttr().Get()

    assert limits("transX") == (-0.5, 0.25)
    assert limits("rotX") == pytest.approx((-90, 45))
    pull = UsdPhysics.DriveAPI(motor, "transY")
    numbers = [pull.GetStiffnessAttr(), pull.GetDampingAttr(), pull.GetMaxForceAttr(), pull.GetTargetPositionAttr()]
    assert [one.Get() for one in numbers] == [7, 3, 11, 0.125]
    for freedom in ("rotX", "rotY", "rotZ"):
        turn = UsdPhysics.DriveAPI(motor, freedom)
        numbers = [turn.GetStiffnessAttr().Get(), turn.GetDampingAttr().Get()]
        assert numbers == pytest.approx([math.pi, math.pi / 2])


def test_usd_core_reads_the_physics_that_was_written(tmp_path: Path) -> None:
    for name in ("robot_door", "constraints", "knobs"):
        stage = opened(emitted(ROOT / "scenes" / f"{name}.yaml")[0], tmp_path)
        found = UsdPhysics.UsdPhysicsLoadStageFromPrimRange(stage, ["/World"])
        for paths, descriptions in found.values():
            for path, description in zip(paths, descriptions, strict=True):
                assert description.isValid, path


@pytest.mark.parametrize("name", ["materials", "robot_door", "constraints"])
def test_the_validators_of_usd_core_find_nothing(name: str, tmp_path: Path) -> None:
    validation: Any = import_module("pxr.UsdValidation")
    validators = validation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 10
    stage = opened(emitted(ROOT / "scenes" / f"{name}.yaml")[0], tmp_path)
    found = validation.ValidationContext(validators).Validate(stage)
    assert [one.GetMessage() for one in found] == []


def test_binary_usd_equals_text_usd(tmp_path: Path) -> None:
    (name,) = emitted(TOYS, binary=True)[0]
    assert name == "out.usdc"
    data = emitted(TOYS, binary=True)[0][name]
    assert data.startswith(b"PXR-USDC")
    stage = opened({name: data}, tmp_path)
    assert stage.GetRootLayer().ExportToString() == emitted(TOYS)[0]["out.usda"].decode()


def test_usd_shows_collision_shapes_on_request(tmp_path: Path) -> None:
    stage = opened(emitted(TOYS, show="collision")[0], tmp_path)
    assert not stage.GetPrimAtPath("/World/my_box/box")
    assert_allclose(bounds(stage, "/World/my_box"), [[0.9, 1.8, 2.7], [1.1, 2.2, 3.3]], atol=1e-6)


def test_features_that_usd_does_not_support_are_reported_with_their_line(tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scenecc: 1\nphysics: {timestep: 0.004}\n"
        "lights:\n  sun: {type: directional, direction: [0, 0, -1], color: [1, 1, 1]}\n"
        "entities:\n  a:\n    linear_damping: 1\n    shapes: [{type: sphere, radius: 1, contact_offset: 0.1}]\n"
        "  goal: {body_type: none, hidden: true, visuals: [{type: sphere, radius: 1}]}\n"
        "  empty: {body_type: static, shapes: []}\n",
        encoding="utf-8",
    )
    _, told = emitted(scene)
    assert {(one.code, one.severity) for one in told} == {("SC750", "warning")}
    assert {one.location.line for one in told} == {2, 4, 7, 8, 9}
    words = " ".join(one.message for one in told)
    for word in ("timestep", "a light", "linear_damping", "contact_offset", "`hidden`"):
        assert word in words


def test_a_friction_force_is_a_drive_in_usd_and_loses_nothing(tmp_path: Path) -> None:
    shapes = [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]
    joint = {"name": "slide", "type": "prismatic", "friction_force": 5}
    root = {"name": "rail", "shapes": shapes, "children": [{"name": "cart", "joint": joint, "shapes": shapes}]}
    files, told = emitted({"scenecc": 1, "entities": {"rig": {"fix_root_link": True, "root": root}}})
    assert told == []
    stage = opened(files, tmp_path)
    slide = next(prim for prim in stage.Traverse() if prim.GetName() == "slide")
    drive = UsdPhysics.DriveAPI(slide, "linear")
    assert drive.GetMaxForceAttr().Get() == 5


def test_without_usd_core_the_export_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pxr.Usd", None)
    with pytest.raises(scenecc.SceneError) as failure:
        emitted(Path("no_such_file.yaml"))
    (error,) = failure.value.diagnostics
    assert error.code == "SC813"
    assert "usd-core" in error.message
    assert error.hint == install_hint("export")
