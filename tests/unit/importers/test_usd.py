"""USD stages, written here as text and read as scenes."""

from __future__ import annotations

import math
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from packaging.version import Version
from PIL import Image

from scenecc.diagnostics import Sink
from scenecc.importers import usd
from scenecc.importers.imported_scene import Asset, ImportContext, ImportedScene
from scenecc.importers.usd_scene import read_stage
from scenecc.options import Options
from scenecc.source.paths import AssetScope

RIGID = 'prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]'
BODY = 'prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"]'
COLLIDER = 'prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "MaterialBindingAPI"]'
HEAD = 'defaultPrim = "World"\nmetersPerUnit = 1\nupAxis = "Z"'
TETRAHEDRON = (
    "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]\nint[] faceVertexCounts = [3, 3, 3, 3]\n"
    "int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]\n"
)


def attempt(folder: Path, text: str, *, head: str = HEAD) -> tuple[ImportedScene | None, Sink]:
    """What is read of a stage whose prims stand in `/World`."""
    file = folder / "stage.usda"
    file.write_text(f'#usda 1.0\n(\n{head}\n)\ndef Xform "World"\n{{\n{text}\n}}\n', encoding="utf-8")
    sink = Sink()
    return read_stage(file, ImportContext(sink, AssetScope(folder), Options().limits)), sink


def read(folder: Path, text: str, *, head: str = HEAD) -> ImportedScene:
    found, sink = attempt(folder, text, head=head)
    assert found is not None, sink.diagnostics()
    return found


def entities(found: ImportedScene) -> dict[str, Any]:
    return found.document["entities"]


def at(x: float, y: float, z: float, *, scale: tuple[float, float, float] = (1, 1, 1)) -> str:
    return (
        f"double3 xformOp:translate = ({x}, {y}, {z})\nfloat3 xformOp:scale = {scale}\n"
        'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]\n'
    )


def kinds(found: ImportedScene) -> list[str]:
    return [loss.kind for loss in found.losses]


def joint(kind: str, first: str | None, second: str | None, more: str = "", *, name: str = "joint") -> str:
    bodies = "".join(
        f"rel physics:body{k} = </World/{body}>\n" for k, body in enumerate((first, second)) if body is not None
    )
    return f'def {kind} "{name}"\n{{\n{bodies}{more}\n}}\n'


def test_a_box_of_a_stage_in_centimetres_with_y_up(tmp_path: Path) -> None:
    text = f'def Cube "box" ({BODY})\n{{\ndouble size = 10\nfloat physics:mass = 2\n{at(0, 20, 30)}}}'
    found = read(tmp_path, text, head='defaultPrim = "World"\nmetersPerUnit = 0.01\nupAxis = "Y"')
    assert not found.losses
    (box,) = entities(found).values()
    assert box["shapes"] == [{"type": "box", "half_size": [0.05, 0.05, 0.05]}]
    assert box["pose"] == {"p": [0.0, -0.3, 0.2], "rpy_deg": [90, 0, 0]}
    assert box["mass"] == 2


@pytest.mark.parametrize(("up", "turn"), [("X", {"rpy_deg": [0, -90, 0]}), ("Z", {})])
def test_other_up_axes(tmp_path: Path, up: str, turn: dict[str, list[int]]) -> None:
    found = read(tmp_path, f'def Sphere "a" ({BODY})\n{{\n}}', head=f'upAxis = "{up}"\nmetersPerUnit = 1')
    assert entities(found)["a"].get("pose", {}) == turn


def test_forces_and_masses_are_converted_to_si_units(tmp_path: Path) -> None:
    """A gram and a centimetre: a torque is g·cm²/s², and a spring's counts for a degree."""
    drive = (
        'uniform token physics:axis = "Z"\nfloat drive:angular:physics:stiffness = 5\n'
        "float drive:angular:physics:maxForce = 7\nfloat drive:angular:physics:targetPosition = 90\n"
    )
    text = (
        f'def Cube "a" ({BODY})\n{{\nfloat physics:density = 2\n}}\n'
        f'def Cube "b" ({BODY})\n{{\n{at(4, 0, 0)}}}\n'
        + joint("PhysicsRevoluteJoint", "a", "b", "point3f physics:localPos0 = (4, 0, 0)\n" + drive).replace(
            '"joint"', '"joint" (prepend apiSchemas = ["PhysicsDriveAPI:angular"])'
        )
    )
    found = read(tmp_path, text, head='metersPerUnit = 0.01\nkilogramsPerUnit = 0.001\nupAxis = "Z"')
    (robot,) = entities(found).values()
    assert robot["root"]["density"] == pytest.approx(2000)
    assert "density" not in robot["root"]["children"][0]  # 1000 kg/m³ in every unit
    assert robot["drives"]["joint"] == {
        "stiffness": pytest.approx(5e-7 * 180 / math.pi),
        "force_limit": pytest.approx(7e-7),
        "target": pytest.approx(math.pi / 2),
    }


@pytest.mark.parametrize(
    ("kind", "attributes", "scale", "expected"),
    [
        ("Cube", "double size = 2", (1, 2, -3), {"type": "box", "half_size": [1, 2, 3]}),
        ("Sphere", "double radius = 0.5", (2, -2, 2), {"type": "sphere", "radius": 1}),
        ("Capsule", 'double radius = 1\ndouble height = 4\nuniform token axis = "Y"', (2, 2, 2),
         {"type": "capsule", "radius": 2, "half_length": 4, "axis": "y"}),
        ("Cylinder", 'double radius = 1\ndouble height = 4\nuniform token axis = "X"', (3, 2, 2),
         {"type": "cylinder", "radius": 2, "half_length": 6}),
        ("Cone", "double radius = 1\ndouble height = 4", (1, 1, 2),
         {"type": "cone", "radius": 1, "half_length": 4, "axis": "z"}),
    ],
)  # fmt: skip
def test_scales_are_applied_to_sizes(
    tmp_path: Path, kind: str, attributes: str, scale: tuple[float, float, float], expected: dict[str, Any]
) -> None:
    found = read(tmp_path, f'def {kind} "a" ({BODY})\n{{\n{attributes}\n{at(0, 0, 0, scale=scale)}}}')
    (shape,) = entities(found)["a"]["shapes"]
    assert shape == expected
    assert not found.losses


def test_an_unevenly_scaled_solid_becomes_a_hull_with_its_mass(tmp_path: Path) -> None:
    found = read(tmp_path, f'def Sphere "egg" ({BODY})\n{{\ndouble radius = 1\n{at(0, 0, 0, scale=(1, 2, 3))}}}')
    (shape,) = entities(found)["egg"]["shapes"]
    assert shape["type"] == "convex_mesh"
    assert points_of(shape["file"]).max(axis=0) == pytest.approx([1, 2, 3])
    assert kinds(found) == ["hulls"]
    assert entities(found)["egg"]["inertial"]["mass"] == pytest.approx(4 / 3 * math.pi * 6000, rel=0.03)


def points_of(asset: Asset) -> np.ndarray:
    assert isinstance(asset.source, bytes)
    return np.array([line.split()[1:] for line in asset.source.decode().splitlines() if line.startswith("v ")], float)


def volume_of(asset: Asset) -> float:
    assert isinstance(asset.source, bytes)
    rows = [line.split()[1:] for line in asset.source.decode().splitlines() if line.startswith("f ")]
    faces = points_of(asset)[np.array([[int(corner.split("/")[0]) - 1 for corner in row] for row in rows])]
    return float(np.einsum("ij,ij->", faces[:, 0], np.cross(faces[:, 1], faces[:, 2]))) / 6


def test_a_mirrored_mesh_faces_outwards_and_equal_meshes_share_a_file(tmp_path: Path) -> None:
    meshes = "".join(
        f'def Mesh "{name}" ({BODY})\n{{\n{TETRAHEDRON}{more}{at(x, 0, 0, scale=scale)}}}\n'
        for name, x, scale, more in (
            ("plain", 0, (1, 1, 1), ""),
            ("twice", 5, (2, 2, 2), ""),
            ("mirrored", 9, (-1, 1, 1), ""),
            ("left", 12, (1, 1, 1), 'uniform token orientation = "leftHanded"\n'),
        )
    )
    found = entities(read(tmp_path, meshes))
    plain, twice, mirrored, left = (found[name]["shapes"][0] for name in ("plain", "twice", "mirrored", "left"))
    assert plain["type"] == "convex_mesh"
    assert plain["file"].source == twice["file"].source
    assert twice["scale"] == 2
    assert "scale" not in mirrored
    assert volume_of(plain["file"]) == pytest.approx(1 / 6)
    assert volume_of(mirrored["file"]) == pytest.approx(1 / 6)
    assert volume_of(left["file"]) == pytest.approx(-1 / 6)  # its faces do look inwards


@pytest.mark.parametrize(
    ("approximation", "expected"),
    [
        ("convexHull", "convex_mesh"),
        ("convexDecomposition", "convex_parts"),
        ("none", "triangle_mesh"),
        ("meshSimplification", "triangle_mesh"),
        ("sdf", "triangle_mesh"),
        ("boundingCube", "box"),
        ("boundingSphere", "sphere"),
    ],
)
def test_each_mesh_approximation_gives_a_collision_shape(tmp_path: Path, approximation: str, expected: str) -> None:
    text = f'def Mesh "a" ({COLLIDER})\n{{\n{TETRAHEDRON}uniform token physics:approximation = "{approximation}"\n}}'
    found = entities(read(tmp_path, text))["a"]
    (shape,) = found.get("shapes") or found["collisions"]
    assert shape["type"] == expected
    assert shape.get("sdf", False) == (approximation == "sdf")
    assert found["body_type"] == "static"


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        ("", {"density": None}),
        ("float physics:density = 500", {"density": 500}),
        ("float physics:mass = 3", {"mass": 3}),
        ("float physics:mass = 12\npoint3f physics:centerOfMass = (1, 0, 0)",
         {"inertial": {"mass": 12, "com": [1, 0, 0], "inertia": [8, 20, 20]}}),
        ("float physics:mass = 2\nfloat3 physics:diagonalInertia = (1, 2, 2.5)",
         {"inertial": {"mass": 2, "inertia": [1, 2, 2.5]}}),
        ("float physics:mass = 2\nfloat3 physics:diagonalInertia = (1, 1, 1)\nquatf physics:principalAxes=(0, 1, 0, 0)",
         {"inertial": {"mass": 2, "inertia": [1, 1, 1]}}),
        ("float physics:mass = 2\nfloat3 physics:diagonalInertia = (1, 2, 2)\nquatf physics:principalAxes=(1, 0, 0, 1)",
         {"inertial": {"mass": 2, "inertia": [2, 1, 2]}}),
        ("float physics:mass = 2\nfloat3 physics:diagonalInertia = (1e-7, 1e-7, 1e-7)",
         {"inertial": {"mass": 2, "inertia": [1e-7, 1e-7, 1e-7]}}),
    ],
)  # fmt: skip
def test_the_mass_properties_of_a_body_are_imported(tmp_path: Path, said: str, expected: dict[str, Any]) -> None:
    """Of a cube of 2 m: what is left open follows as UsdPhysics has it."""
    found = entities(read(tmp_path, f'def Cube "a" ({BODY})\n{{\n{said}\n}}'))["a"]
    for key, value in expected.items():
        if key == "inertial":
            got = found[key]
            assert got["mass"] == value["mass"]
            assert got.get("com") == value.get("com")
            assert sorted(got["inertia"]) == pytest.approx(sorted(value["inertia"]), rel=1e-5)
        else:
            assert found.get(key) == value
    assert ("inertial" in found) == ("inertial" in expected)


@pytest.mark.parametrize("said", ["", "float physics:mass = 1"])
def test_the_inertia_of_a_small_body_is_written(tmp_path: Path, said: str) -> None:
    """SAPIEN raises moments that it computes from densities to 1e-6 kg·m²."""
    found = entities(read(tmp_path, f'def Cube "a" ({BODY})\n{{\ndouble size = 0.01\n{said}\n}}'))["a"]
    mass = 1 if said else 0.001
    assert found["inertial"] == {"mass": mass, "inertia": pytest.approx([mass * 1e-4 / 6] * 3)}


@pytest.mark.skipif(Version(version("usd-core")) < Version("26.11"), reason="older ones weigh what is switched off")
def test_a_disabled_collider_has_no_mass(tmp_path: Path) -> None:
    heavy = COLLIDER.replace('"PhysicsCollisionAPI"', '"PhysicsCollisionAPI", "PhysicsMassAPI"')
    text = (
        f'def Xform "a" ({RIGID})\n{{\ndef Cube "x" ({heavy})\n{{\nfloat physics:mass = 3\n}}\n'
        f'def Cube "y" ({heavy})\n{{\nfloat physics:mass = 1\nbool physics:collisionEnabled = 0\n{at(4, 0, 0)}}}\n}}'
    )
    found = entities(read(tmp_path, text))["a"]
    assert found["mass"] == 3  # UsdPhysics weighs what collides
    assert len(found["shapes"]) == 1
    assert len(found["visuals"]) == 1


def test_impossible_and_missing_inertias_are_reported(tmp_path: Path) -> None:
    said = "float physics:mass = 2\nfloat3 physics:diagonalInertia = (1, 1, 5)"
    found = read(tmp_path, f'def Cube "a" ({BODY})\n{{\n{said}\n}}\ndef Xform "b" ({RIGID})\n{{\n}}')
    assert entities(found)["a"]["inertial"]["inertia"] == [1, 1, 2]
    assert kinds(found) == ["inertias", "assumed-masses", "assumed-masses"]
    assert entities(found)["b"]["root"]["inertial"]["mass"] == 1


MATERIALS = """
def Material "rubber" (prepend apiSchemas = ["PhysicsMaterialAPI"])
{
    float physics:dynamicFriction = 0.5
    float physics:staticFriction = 0.75
    float physics:density = 200
}
def Material "paint"
{
    token outputs:surface.connect = </World/paint/s.outputs:surface>
    def Shader "s"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </World/paint/t.outputs:rgb>
        float inputs:roughness = 0.25
        float inputs:metallic = 1
        token outputs:surface
    }
    def Shader "t"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @FILE@
        token inputs:wrapS = "clamp"
        token inputs:wrapT = "clamp"
        float3 outputs:rgb
    }
}
"""


def test_materials_are_named_and_shared(tmp_path: Path) -> None:
    Image.new("RGB", (2, 2)).save(tmp_path / "image.png")
    bound = "rel material:binding:physics = </World/rubber>\nrel material:binding = </World/paint>\n"
    schemas = BODY.replace("[", '["MaterialBindingAPI", ')
    cubes = "".join(f'def Cube "{name}" ({schemas})\n{{\n{bound}}}\n' for name in "ab")
    found = read(tmp_path, MATERIALS.replace("FILE", "./image.png") + cubes)
    assert list(found.document["materials"]) == ["paint_rubber"]
    material = found.document["materials"]["paint_rubber"]
    assert material["physical"] == {"static_friction": 0.75, "dynamic_friction": 0.5, "restitution": 0}
    texture = material["visual"].pop("base_color_texture")
    assert material["visual"] == {"roughness": 0.25, "metallic": 1}
    assert texture == {"file": Asset("image.png", tmp_path / "image.png"), "address_mode": "edge"}
    assert entities(found)["a"]["density"] == 200


def test_a_missing_texture_is_a_loss_and_a_web_texture_is_an_error(tmp_path: Path) -> None:
    cube = 'def Cube "a" (prepend apiSchemas = ["MaterialBindingAPI"])\n{\nrel material:binding = </World/paint>\n}\n'
    assert kinds(read(tmp_path, MATERIALS.replace("FILE", "./none.png") + cube)) == ["missing-files"]
    _, sink = attempt(tmp_path, MATERIALS.replace("FILE", "https://example.com/a.png") + cube)
    assert [each.code for each in sink.diagnostics()] == ["SC403"]


def test_a_mesh_with_several_materials_is_split(tmp_path: Path) -> None:
    subset = (
        'def GeomSubset "red" (prepend apiSchemas = ["MaterialBindingAPI"])\n{\nuniform token elementType = "face"\n'
        'uniform token familyName = "materialBind"\nint[] indices = [0, 1]\n'
        "rel material:binding = </World/paint>\n}\n"
    )
    paint = MATERIALS.replace("color3f inputs:diffuseColor.connect = </World/paint/t.outputs:rgb>", "")
    found = read(tmp_path, f'{paint}def Mesh "a"\n{{\n{TETRAHEDRON}{subset}}}')
    first, second = entities(found)["a"]["visuals"]
    assert first["material"] == "paint"
    assert "material" not in second
    faces = [visual["file"].source.decode().count("\nf ") for visual in (first, second)]
    assert faces == [2, 2]
    assert entities(found)["a"]["body_type"] == "none"


def test_instances_and_references_are_resolved(tmp_path: Path) -> None:
    mesh = f'def Mesh "mesh" ({COLLIDER})\n{{\n{TETRAHEDRON}uniform token physics:approximation = "convexHull"\n}}\n'
    wheel = f'#usda 1.0\n(\ndefaultPrim = "wheel"\n)\ndef Xform "wheel"\n{{\n{mesh}}}\n'
    (tmp_path / "wheel.usda").write_text(wheel, encoding="utf-8")
    heads = [
        f"{RIGID}\ninstanceable = {flag}\nprepend references = @./wheel.usda@" for flag in ("true", "true", "false")
    ]
    text = "".join(f'def Xform "w{k}" (\n{head}\n)\n{{\n{at(3 * k, 0, 0)}}}\n' for k, head in enumerate(heads))
    found = entities(read(tmp_path, text))
    assert list(found) == ["w0", "w1", "w2"]
    assert len({row["shapes"][0]["file"].source for row in found.values()}) == 1


def test_static_prims_are_grouped_by_their_parent(tmp_path: Path) -> None:
    text = (
        f'def Xform "table"\n{{\n{at(0, 0, 1)}def Cube "top" ({COLLIDER})\n{{\n}}\n'
        f'def Cube "look"\n{{\n{at(0, 0, 2)}}}\n}}\n'
        f'def Plane "ground" ({COLLIDER})\n{{\nuniform token purpose = "guide"\n}}\n'
    )
    found = entities(read(tmp_path, text))
    assert found["table"]["body_type"] == "static"
    assert found["table"]["pose"] == [0, 0, 1]
    assert len(found["table"]["shapes"]) == 1
    assert len(found["table"]["visuals"]) == 1
    assert found["ground"] == {"body_type": "static", "collisions": [{"type": "plane"}]}


def test_a_collider_and_a_visual_of_equal_geometry_become_one_shape(tmp_path: Path) -> None:
    cubes = f'def Cube "hull" ({COLLIDER})\n{{\nuniform token purpose = "guide"\n}}\ndef Cube "look"\n{{\n}}\n'
    found = entities(read(tmp_path, f'def Xform "a" ({RIGID})\n{{\nfloat physics:density = 5\n{cubes}}}'))
    assert found["a"] == {"density": 5, "shapes": [{"type": "box", "half_size": [1, 1, 1]}]}


def test_locked_axes_are_turned_with_the_stage(tmp_path: Path) -> None:
    locks = ("int physxRigidBody:lockedPosAxis = 2", "float physxRigidBody:lockedRotAxis = inf")
    text = f'def Cube "a" ({BODY})\n{{\n{locks[0]}\n{locks[1]}\n}}\n'
    assert entities(read(tmp_path, text))["a"]["locked_axes"] == ["y"]
    found = read(tmp_path, text, head='upAxis = "Y"\nmetersPerUnit = 1')
    assert entities(found)["a"]["locked_axes"] == ["z"]


def test_kinematic_and_disabled_bodies_are_imported(tmp_path: Path) -> None:
    text = (
        f'def Cube "a" ({BODY})\n{{\nbool physics:kinematicEnabled = 1\n}}\n'
        f'def Cube "b" ({BODY})\n{{\nbool physics:rigidBodyEnabled = 0\n{at(5, 0, 0)}}}\n'
        f'def Cube "c" ({BODY})\n{{\nvector3f physics:velocity = (1, 0, 0)\n'
        f"vector3f physics:angularVelocity = (0, 0, 180)\n{at(9, 0, 0)}}}\n"
    )
    found = entities(read(tmp_path, text))
    assert [row.get("body_type", "dynamic") for row in found.values()] == ["kinematic", "static", "dynamic"]
    assert found["c"]["linear_velocity"] == [1, 0, 0]
    assert found["c"]["angular_velocity"] == pytest.approx([0, 0, math.pi])


def bodies(*names: str) -> str:
    return "".join(f'def Cube "{name}" ({BODY})\n{{\n{at(4 * k, 0, 0)}}}\n' for k, name in enumerate(names))


MIDDLE = "point3f physics:localPos0 = (2, 0, 0)\npoint3f physics:localPos1 = (-2, 0, 0)\n"


def test_a_chain_becomes_a_link_tree_and_a_loop_joint_a_constraint(tmp_path: Path) -> None:
    limits = 'uniform token physics:axis = "Z"\nfloat physics:lowerLimit = -90\nfloat physics:upperLimit = 45\n'
    text = bodies("a", "b", "c") + (
        joint("PhysicsFixedJoint", None, "a", name="foot")
        + joint("PhysicsRevoluteJoint", "a", "b", MIDDLE + limits, name="one")
        # Its bodies stand in the other order.
        + joint("PhysicsRevoluteJoint", "c", "b", MIDDLE.replace("(2", "(9").replace("(-2", "(2").replace("(9", "(-2")
                + limits, name="two")
        + joint("PhysicsFixedJoint", "a", "c", "point3f physics:localPos0 = (8, 0, 0)\n", name="three")
    )  # fmt: skip
    found = read(tmp_path, text)
    assert not found.losses
    (robot,) = entities(found).values()
    assert robot["fix_root_link"]
    first, second = robot["root"]["children"]
    assert (robot["root"]["name"], first["name"], second["name"]) == ("a", "b", "c")
    assert first["joint"]["type"] == "revolute"
    assert first["joint"]["limits_deg"] == [-90, 45]
    assert second["joint"] == {"type": "fixed", "origin": [8, 0, 0]}
    loop = found.document["constraints"]["two"]
    assert (loop["parent"], loop["child"]) == ("a/c", "a/b")
    assert (loop["type"], loop["axis"]) == ("hinge", "z")
    assert loop["limits"] == pytest.approx([-math.pi / 2, math.pi / 4])


def test_a_joint_with_several_freedoms_becomes_joints_in_series(tmp_path: Path) -> None:
    d6 = joint("PhysicsJoint", "a", "b", MIDDLE).replace(
        '"joint"', '"joint" (prepend apiSchemas = ["PhysicsLimitAPI:transX", "PhysicsLimitAPI:transY", '
        '"PhysicsLimitAPI:transZ", "PhysicsLimitAPI:rotZ"])'
    )  # fmt: skip
    locks = "".join(
        f"float limit:{each}:physics:low = 1\nfloat limit:{each}:physics:high = -1\n"
        for each in ("transX", "transY", "transZ")
    )
    d6 = d6.replace("\n}\n", f"\n{locks}float limit:rotZ:physics:low = -30\nfloat limit:rotZ:physics:high = 30\n}}\n")
    text = f'def Xform "robot" (prepend apiSchemas = ["PhysicsArticulationRootAPI"])\n{{\n}}\n{bodies("a", "b")}{d6}'
    found = read(tmp_path, text)
    assert kinds(found) == ["ball-joints"]
    (robot,) = entities(found).values()
    first = robot["root"]["children"][0]
    second = first["children"][0]
    third = second["children"][0]
    assert [each["name"] for each in (first, second, third)] == ["b_dummy_0", "b_dummy_1", "b"]
    assert third["joint"]["limits_deg"] == [-30, 30]
    assert "qpos" not in robot
    # Two links in a row would touch otherwise: PhysX keeps only direct neighbours apart.
    assert robot["disable_self_collisions"]
    assert third["mass"] == 8000
    assert first["inertial"] == {"mass": 8, "inertia": pytest.approx([16 / 3] * 3)}
    assert {*found.bodies.values()} == {"/World/a", "/World/b"}


@pytest.mark.parametrize(
    ("kind", "more", "expected"),
    [
        ("PhysicsFixedJoint", "", {"type": "weld"}),
        ("PhysicsDistanceJoint", "float physics:maxDistance = 3\n", {"type": "distance", "limits": [0, 3]}),
        ("PhysicsSphericalJoint", "", {"type": "ball"}),
        ("PhysicsPrismaticJoint", 'uniform token physics:axis = "Y"\nfloat physics:lowerLimit = -1\n',
         {"type": "slider", "axis": "y", "limits": [-1, math.inf]}),
    ],
)  # fmt: skip
def test_joints_excluded_from_articulations_become_constraints(
    tmp_path: Path, kind: str, more: str, expected: dict[str, Any]
) -> None:
    out = "bool physics:excludeFromArticulation = 1\nbool physics:collisionEnabled = 1\n"
    found = read(tmp_path, bodies("a", "b") + joint(kind, "a", "b", MIDDLE + more + out))
    (constraint,) = found.document["constraints"].values()
    assert {key: constraint[key] for key in expected} == expected
    assert (constraint["parent"], constraint["child"]) == ("a", "b")
    assert "collision_groups" not in found.document


def test_what_a_constraint_cannot_hold_of_a_joint_is_a_loss(tmp_path: Path) -> None:
    physx = "".join(
        f"custom float {name}\n"
        for name in (
            "physxJoint:maxJointVelocity = 2",
            "physxJoint:jointFriction = 0.1",
            "physxJointAxis:linear:dynamicFrictionEffort = 3",
            "physxJoint:armature = 0",
        )
    )
    out = "bool physics:excludeFromArticulation = 1\n" + physx
    found = read(tmp_path, bodies("a", "b") + joint("PhysicsPrismaticJoint", "a", "b", MIDDLE + out))
    assert sorted(loss.kind for loss in found.losses) == ["joint-friction", "joint-friction", "joint-limits"]


def test_filtered_pairs_become_collision_groups(tmp_path: Path) -> None:
    filtered = BODY.replace("[", '["PhysicsFilteredPairsAPI", ')
    text = bodies("b", "c") + (
        f'def Cube "a" ({filtered})\n{{\nrel physics:filteredPairs = </World/b>\n{at(0, 5, 0)}}}\n'
        'def PhysicsCollisionGroup "debris" (prepend apiSchemas = ["CollectionAPI:colliders"])\n{\n'
        "rel collection:colliders:includes = [</World/b>, </World/c>]\n"
        "rel physics:filteredGroups = </World/debris>\n}\n"
    )
    found = read(tmp_path, text)
    groups = found.document["collision_groups"]
    of = {name: row["collision_group"] for name, row in entities(found).items()}
    apart = {frozenset((a, b)) for a in of for b in of if a != b and of[b] in groups[of[a]]["ignore"]}
    assert apart == {frozenset("ab"), frozenset("bc")}


def test_joint_frames_that_do_not_coincide_are_reported(tmp_path: Path) -> None:
    found = read(tmp_path, bodies("a", "b") + joint("PhysicsRevoluteJoint", "a", "b"))
    assert kinds(found) == ["joint-frames"]


def test_lights_and_a_camera_are_mounted_on_a_body(tmp_path: Path) -> None:
    text = (
        'def DistantLight "sun"\n{\nfloat inputs:intensity = 2000\ncolor3f inputs:color = (1, 0.5, 0)\n}\n'
        f'def Cube "a" ({BODY})\n{{\ndef Camera "eye"\n{{\nfloat focalLength = 10\nfloat horizontalAperture = 20\n'
        "float verticalAperture = 20\n}\n}\n"
    )
    found = read(tmp_path, text)
    assert found.document["lights"] == {
        "sun": {"type": "directional", "color": [2, 1, 0], "direction": [0, 0, -1]},
    }
    eye = found.document["cameras"]["eye"]
    assert eye["mount"] == "a"
    assert eye["fovy_deg"] == 90
    assert (eye["width"], eye["height"]) == (640, 640)


def test_unsupported_prims_and_attributes_are_reported(tmp_path: Path) -> None:
    text = (
        f'def Cube "a" ({BODY})\n{{\nfloat physxRigidBody:cfmScale = 0.5\n'
        "float physxRigidBody:linearDamping = 0.25\n}\n"
        'def PointInstancer "many"\n{\n}\ndef BasisCurves "hair"\n{\n}\ndef Robot "robot"\n{\n}\n'
    )
    found = read(tmp_path, text)
    assert set(kinds(found)) == {"visuals", "point-instancers", "unknown-prims", "vendor-attributes"}
    assert entities(found)["a"]["linear_damping"] == 0.25


@pytest.mark.parametrize(
    ("reference", "code"),
    [
        ("https://example.com/a.usd", "SC403"),
        ("../a.usd", "SC402"),
        ("/etc/a.usd", "SC402"),
        ("./none.usd", "SC401"),
    ],
)
@pytest.mark.parametrize("kind", ["references", "payload", "variant"])
def test_layers_outside_the_roots_or_on_the_web_are_errors_with_a_line(
    tmp_path: Path, reference: str, code: str, kind: str
) -> None:
    """Also in a variant that is not chosen, since nothing is opened before all is checked."""
    text = f'def Xform "a" (\nprepend {kind} = @{reference}@\n)\n{{\n}}\n'
    if kind == "variant":
        inner = f'"one" (prepend references = @{reference}@)\n{{\n}}\n"two"\n{{\n}}\n'
        head = 'variants = { string v = "two" }\nprepend variantSets = "v"'
        text = f'def Xform "a" (\n{head}\n)\n{{\nvariantSet "v" = {{\n{inner}}}\n}}\n'
    (tmp_path / "inner").mkdir()
    found, sink = attempt(tmp_path / "inner", text)
    assert found is None
    (told,) = sink.diagnostics()
    assert told.code == code
    assert told.location.line is not None


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\x7fELF nothing of USD", "neither USD text nor USD crate"),
        (b"PXR-USDC" + bytes(100), "cannot read"),
        (b"#usda 1.0\ndef Xform 'a\n", "cannot read"),
        (b'#usda 1.0\ndef Xform "a" (prepend references = @./bad.usda@</a>)\n{\n}\n', "does not compose"),
        (b'#usda 1.0\n(\nmetersPerUnit = 0\n)\ndef Xform "a"\n{\n}\n', "metersPerUnit"),
        (f'#usda 1.0\ndef Xform "a"\n{{\n{at(math.nan, 0, 0)}}}\n'.encode(), "not finite"),
    ],
)  # fmt: skip
def test_a_file_that_is_not_a_stage_is_refused(tmp_path: Path, content: bytes, words: str) -> None:
    (tmp_path / "bad.usda").write_bytes(content)
    sink = Sink()
    assert read_stage(tmp_path / "bad.usda", ImportContext(sink, AssetScope(tmp_path), Options().limits)) is None
    assert words in sink.diagnostics()[0].message


def test_wrong_mesh_indices_and_negative_sizes_are_losses(tmp_path: Path) -> None:
    bad = TETRAHEDRON.replace("[0, 2, 1,", "[0, 2, 999999999,")
    text = f'def Mesh "a" ({BODY})\n{{\n{bad}}}\ndef Sphere "b" ({BODY})\n{{\ndouble radius = -1\n}}'
    found = read(tmp_path, text)
    assert {"visuals", "colliders"} <= set(kinds(found))


def test_large_layers_are_refused(tmp_path: Path) -> None:
    (tmp_path / "big.usda").write_text("#usda 1.0\n" + "#" * 2000, encoding="utf-8")
    sink = Sink()
    limits = Options.of(limits={"asset_bytes": 1000}).limits
    assert read_stage(tmp_path / "big.usda", ImportContext(sink, AssetScope(tmp_path), limits)) is None
    assert "asset_bytes" in sink.diagnostics()[0].message


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (f'def Sphere "a" ({BODY})\n{{\nstring radius = "x"\n}}', "`radius` of /World/a has type `text`"),
        (f'def Sphere "a" ({BODY})\n{{\nfloat3 physics:mass = (1, 2, 3)\n}}', "has type `GfVec3`, not `number`"),
        (f'def Sphere "a" ({BODY})\n{{\ntoken physxRigidBody:linearDamping = "x"\n}}', "not `number`"),
        (MATERIALS.replace("float inputs:roughness = 0.25", 'string inputs:roughness = "x"'), "not `number`"),
    ],
)
def test_attributes_of_the_wrong_type_are_errors(tmp_path: Path, text: str, told: str) -> None:
    found, sink = attempt(tmp_path, text)
    assert found is None
    assert [each.code for each in sink.diagnostics()] == ["SC430"]
    assert told in sink.diagnostics()[0].message


def test_numbers_of_any_precision_are_accepted(tmp_path: Path) -> None:
    found = read(tmp_path, f'def Sphere "a" ({BODY})\n{{\nhalf radius = 0.5\ndouble physics:mass = 3\n}}')
    assert entities(found)["a"]["mass"] == 3
    assert entities(found)["a"]["shapes"][0]["radius"] == 0.5


def test_an_unknown_up_axis_is_an_error(tmp_path: Path) -> None:
    _, sink = attempt(tmp_path, "", head='upAxis = "Q"')
    assert "`upAxis` is `Q`" in sink.diagnostics()[0].message


def test_materials_without_a_surface_or_with_an_impossible_ior_are_accepted(tmp_path: Path) -> None:
    bound = "rel material:binding = </World/paint>\n"
    schemas = BODY.replace("[", '["MaterialBindingAPI", ')
    cube = f'def Cube "a" ({schemas})\n{{\n{bound}}}\n'
    found = read(tmp_path, 'def Material "paint"\n{\n}\n' + cube)
    assert "materials" not in found.document
    paint = MATERIALS.replace(
        "color3f inputs:diffuseColor.connect = </World/paint/t.outputs:rgb>", "float inputs:ior = -1"
    )
    assert "specular" not in read(tmp_path, paint + cube).document["materials"]["paint"]["visual"]


def test_an_exception_in_the_reader_process_is_reported_at_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "stage.usda"
    file.write_text(f"#usda 1.0\n(\n{HEAD}\n)\n")
    monkeypatch.setattr(usd, "asdict", lambda _: {"unknown": 1})  # the process makes its limits of this
    sink = Sink()
    assert usd.import_usd(file, ImportContext(sink, AssetScope(tmp_path), Options.of().limits)) is None
    (found,) = sink.diagnostics()
    assert (found.code, found.file) == ("SC430", str(file))
    assert found.message.startswith("scenecc's USD reader failed:  TypeError: ")


def mdl(inputs: str, name: str = "OmniPBR", more: str = "") -> str:
    """A material of MDL alone, and a body that it is bound to by the plain `material:binding`."""
    return f"""def Material "paint"
{{
    {more}
    token outputs:mdl:surface.connect = </World/paint/s.outputs:out>
    def Shader "s"
    {{
        uniform token info:implementationSource = "sourceAsset"
        uniform asset info:mdl:sourceAsset = @{name}.mdl@
        uniform token info:mdl:sourceAsset:subIdentifier = "{name}"
        {inputs}
        token outputs:out
    }}
}}
{PAINTED}"""


PAINTED = (
    f'def Cube "a" ({BODY.replace("[", "[" + chr(34) + "MaterialBindingAPI" + chr(34) + ", ")})\n'
    "{\nrel material:binding = </World/paint>\n}\n"
)


@pytest.mark.parametrize(
    ("inputs", "look", "unread"),
    [
        ([], {"base_color": [0.2, 0.2, 0.2], "roughness": 0.5}, ""),
        (["color3f diffuse_color_constant = (1, 0, 0)"], {"base_color": [1, 0, 0], "roughness": 0.5}, ""),
        (
            [
                "color3f diffuse_tint = (0.5, 1, 0)",
                "float metallic_constant = 1",
                "bool enable_opacity = 1",
                "float opacity_constant = 0.25",
                "float albedo_brightness = 1",
                "float specular_level = 1",
            ],
            {"base_color": [0.1, 0.2, 0, 0.25], "roughness": 0.5, "metallic": 1, "specular": 1},
            "",
        ),
        (
            ["bool enable_emission = 1", "color3f emissive_color = (0, 1, 0)", "float emissive_intensity = 500"],
            {"base_color": [0.2, 0.2, 0.2], "roughness": 0.5, "emission": [0, 0.5, 0]},
            "",
        ),
        (
            ["float opacity_constant = 0", "color3f emissive_color = (0, 1, 0)", "float albedo_brightness = 2"],
            {"base_color": [0.2, 0.2, 0.2], "roughness": 0.5},
            "`albedo_brightness` of a material of type `OmniPBR`",
        ),
        (
            [
                "asset diffuse_texture = @./t.png@",
                "color3f diffuse_tint = (0.5, 1, 0)",
                "asset reflectionroughness_texture = @./t.png@",
                "asset metallic_texture = @./t.png@",
                "float reflection_roughness_texture_influence = 1",
            ],
            {"base_color_texture": "t.png", "roughness_texture": "t.png"},
            "`diffuse_tint` of a material of type `OmniPBR`",
        ),
    ],
)
def test_the_inputs_of_omni_pbr_are_read(tmp_path: Path, inputs: list[str], look: dict[str, Any], unread: str) -> None:
    Image.new("RGB", (2, 2)).save(tmp_path / "t.png")
    found = read(tmp_path, mdl("\n".join(each.replace(" ", " inputs:", 1) for each in inputs)))
    made = found.document["materials"]["paint"]["visual"]
    assert {key: value.name if isinstance(value, Asset) else value for key, value in made.items()} == look
    assert [loss.message.partition(" (/")[0] for loss in found.losses] == ([unread] if unread else [])


def test_other_materials_are_a_loss_by_name_and_a_preview_surface_is_preferred(tmp_path: Path) -> None:
    found = read(tmp_path, mdl("color3f inputs:glass_color = (1, 0, 0)", "OmniGlass"))
    assert "materials" not in found.document
    assert "`glass_color` of a material of type `OmniGlass`" in found.losses[0].message
    preview = """token outputs:glslfx:surface.connect = </World/paint/p.outputs:surface>
    def Shader "p"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (0, 0, 1)
        token outputs:surface
    }"""
    found = read(tmp_path, mdl("color3f inputs:diffuse_color_constant = (1, 0, 0)", more=preview))
    assert found.document["materials"]["paint"]["visual"] == {"base_color": [0, 0, 1], "roughness": 0.5}
    assert not found.losses


@pytest.mark.parametrize(
    ("material", "content"),
    [
        ('(prepend apiSchemas = ["PhysicsMaterialAPI"])\n{\nfloat physics:staticFriction = 0.5\n}\n', {"physical"}),
        ("\n{\n}\n", set()),
        ("\n{\ntoken outputs:mdl:surface.connect = </World/paint/none.outputs:out>\n}\n", set()),
    ],
)
def test_materials_without_a_surface_are_accepted(tmp_path: Path, material: str, content: set[str]) -> None:
    found = read(tmp_path, f'def Material "paint" {material}{PAINTED}')
    assert {*found.document.get("materials", {}).get("paint", {})} == content
    assert not found.losses


SLIDE = 'uniform token physics:axis = "X"\nbool physics:collisionEnabled = 1\n'


def test_bodies_of_a_joint_with_collisions_collide_in_an_articulation(tmp_path: Path) -> None:
    bodies = "".join(f'def Cube "{name}" ({BODY})\n{{\n}}\n' for name in ("rail", "cart"))
    found = read(tmp_path, bodies + joint("PhysicsPrismaticJoint", "rail", "cart", SLIDE))
    (robot,) = entities(found).values()
    (between,) = robot["root"]["children"]
    assert (between["name"], between["joint"]) == ("cart_dummy_0", {"type": "fixed"})
    (cart,) = between["children"]
    assert cart["joint"]["name"] == "joint"
    assert "collision_groups" not in found.document
    assert not found.losses
    bodies = f'def Cube "rail" ({BODY})\n{{\n}}\ndef Xform "cart" ({RIGID})\n{{\nfloat physics:mass = 1\n}}\n'
    (robot,) = entities(read(tmp_path, bodies + joint("PhysicsPrismaticJoint", "rail", "cart", SLIDE))).values()
    assert robot["root"]["children"][0]["name"] == "cart"


@pytest.mark.parametrize(
    ("kind", "more", "rail"),
    [
        ("PhysicsPrismaticJoint", "bool physics:excludeFromArticulation = 1", ""),
        ("PhysicsPrismaticJoint", "", "bool physics:kinematicEnabled = 1"),
        ("PhysicsDistanceJoint", "float physics:maxDistance = 50", ""),
        ("PhysicsFixedJoint", "bool physics:excludeFromArticulation = 1", ""),
    ],
)
@pytest.mark.parametrize("collides", [True, False])
def test_bodies_of_a_constraint_collide_if_the_joint_says_so(
    tmp_path: Path, kind: str, more: str, rail: str, collides: bool
) -> None:
    bodies = f'def Cube "rail" ({BODY})\n{{\n{rail}\n}}\ndef Cube "cart" ({BODY})\n{{\n}}\n'
    told = SLIDE if "Prismatic" in kind else SLIDE.partition("\n")[2]
    if not collides:
        told = told.replace("= 1", "= 0")
    found = read(tmp_path, bodies + joint(kind, "rail", "cart", told + more))
    assert found.document["constraints"]["joint"].get("collide", False) == collides
    assert ("collision_groups" in found.document) != collides


def test_a_joint_with_a_kinematic_body_without_shapes_is_one_with_the_world(tmp_path: Path) -> None:
    hand = f'def Xform "hand" ({RIGID})\n{{\nbool physics:kinematicEnabled = 1\n{at(0, 0, 2)}}}\n'
    found = read(
        tmp_path, f'{hand}def Cube "a" ({BODY})\n{{\n{at(0, 0, 2)}}}\n' + joint("PhysicsFixedJoint", "hand", "a")
    )
    assert found.document["constraints"]["joint"] == {
        "type": "weld",
        "parent": "world",
        "child": "a",
        "pose_in_parent": [0, 0, 2],
    }


def contact(name: str, friction: float, *attributes: str) -> str:
    """A physical material and a body of it."""
    values = (
        "\n".join(attributes)
        .replace("token ", "uniform token physxMaterial:")
        .replace("float ", "float physxMaterial:")
    )
    schemas = BODY.replace("[", '["MaterialBindingAPI", ')
    return (
        f'def Material "{name}" (prepend apiSchemas = ["PhysicsMaterialAPI"])\n{{\n'
        f"float physics:staticFriction = {friction}\nfloat physics:dynamicFriction = {friction}\n{values}\n}}\n"
        f'def Cube "body_{name}" ({schemas})\n{{\nrel material:binding:physics = </World/{name}>\n}}\n'
    )


MAX, MIN, MULTIPLY = (f'token frictionCombineMode = "{mode}"' for mode in ("max", "min", "multiply"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            contact("a", 1, MAX) + contact("b", 0.2, MAX),
            "`max`: a static friction of 1 with `b`, where SAPIEN's mean is 0.6",
        ),
        (contact("a", 1) + contact("b", 0.2, MIN), "`min`: a static friction of 0.2 with `a`"),
        (contact("a", 0.5, MULTIPLY) + contact("b", 0.5), "`multiply`: a static friction of 0.25 with `b`"),
        (contact("a", 0.4, MAX) + contact("b", 0.4, MIN), ""),
        (contact("a", 1, 'token frictionCombineMode = "average"') + contact("b", 0.2), ""),
        (contact("a", 0.5, MULTIPLY), ""),
        (contact("a", 0.4, 'token restitutionCombineMode = "max"') + contact("b", 0.4), ""),
        (contact("a", 0.5, "float compliantContactStiffness = 100"), "compliant contacts of stiffness 100"),
        (contact("a", 0.5, "float compliantContactStiffness = 0"), ""),
        (contact("a", 1, MAX) + contact("b", 0.2) + "FIXED", ""),
    ],
)
def test_combine_modes_are_reported_where_contacts_differ(tmp_path: Path, text: str, words: str) -> None:
    found = read(tmp_path, text.replace("FIXED", joint("PhysicsFixedJoint", "body_a", "body_b")))
    assert kinds(found) == (["contact-materials"] if words else [])
    assert words in "".join(loss.message for loss in found.losses)


@pytest.mark.parametrize("name", ["physxJointAxis:angular:dynamicFrictionEffort", "mjc:frictionloss"])
@pytest.mark.parametrize("is_driven", [False, True])
def test_a_friction_force_of_a_joint(tmp_path: Path, name: str, is_driven: bool) -> None:
    """A torque is g·cm²/s²."""
    drive = "float drive:angular:physics:stiffness = 5\n" if is_driven else ""
    made = joint("PhysicsRevoluteJoint", "a", "b", f"{MIDDLE}float {name} = 3\n{drive}")
    if is_driven:
        made = made.replace('"joint"', '"joint" (prepend apiSchemas = ["PhysicsDriveAPI:angular"])')
    found = read(tmp_path, bodies("a", "b") + made, head='metersPerUnit = 0.01\nkilogramsPerUnit = 0.001\nupAxis = "Z"')
    (robot,) = entities(found).values()
    keys = robot["root"]["children"][0]["joint"]
    assert keys.get("friction_force") == (None if is_driven else pytest.approx(3e-7))
    assert ("joint-friction" in kinds(found)) == is_driven


ROCK = f'def Cube "rock" ({BODY})\n{{\n{at(0, 0, 0.5)}}}\n'
POST = f'def Xform "post"\n{{\ndef Cylinder "pole" ({BODY})\n{{\n{at(0, 0, 1)}}}\n}}\n'


def instancer(name: str, count: int, prototypes: str, inside: str, more: str = "") -> str:
    """Instances 2 m apart along x, of each prototype in turn."""
    paths = [f"</World/{each}>" for each in prototypes.split()]
    indices = [number % len(paths) for number in range(count)]
    points = ", ".join(f"({2 * number}, 0, 0)" for number in range(count))
    arrays = f"int[] protoIndices = {indices}\npoint3f[] positions = [{points}]\n"
    return f'def PointInstancer "{name}"\n{{\nrel prototypes = [{", ".join(paths)}]\n{arrays}{more}{inside}}}\n'


def test_instances_are_where_usd_core_puts_them(tmp_path: Path) -> None:
    more = (
        "quath[] orientations = [(1, 0, 0, 0), (0.8, 0.6, 0, 0), (0, 0.6, 0, 0.8), (0.5, 0.5, 0.5, 0.5)]\n"
        f"float3[] scales = [(1, 1, 1), (2, 2, 2), (1, 1, 1), (1, 1, 2)]\nint64[] invisibleIds = [2]\n{at(1, 2, 3)}"
    )
    text = instancer("many", 4, "many/rock many/post", ROCK + POST, more)
    found = read(tmp_path, text, head='defaultPrim = "World"\nmetersPerUnit = 0.01\nupAxis = "Z"')
    assert not found.losses
    assert list(entities(found)) == ["rock", "pole", "pole_2"]
    assert [each["shapes"][0]["type"] for each in entities(found).values()] == ["box", "cylinder", "cylinder"]
    core, geom = (pytest.importorskip(name) for name in ("pxr.Usd", "pxr.UsdGeom"))
    stage = core.Stage.Open(str(tmp_path / "stage.usda"))
    judge = geom.PointInstancer(stage.GetPrimAtPath("/World/many"))
    made = judge.ComputeInstanceTransformsAtTime(0, 0)
    world = judge.GetLocalTransformation()
    local = {"rock": (0, 0, 0), "pole": (0, 0, 1)}
    for matrix, (name, entity) in zip(made, entities(found).items(), strict=True):
        expected = (matrix * world).Transform(local[name.removesuffix("_2")])
        place = entity["pose"]["p"] if isinstance(entity["pose"], dict) else entity["pose"]
        assert place == pytest.approx([each / 100 for each in expected], abs=1e-5)


def test_instancers_in_prototypes_and_in_native_instances_are_expanded(tmp_path: Path) -> None:
    nested = instancer("outer", 2, "outer/inner", instancer("inner", 2, "outer/inner/rock", ROCK))
    native = f'def Xform "copy" (instanceable = true\nreferences = </World/outer>)\n{{\n{at(0, 9, 0)}}}\n'
    found = read(tmp_path, nested + native)
    assert not found.losses
    places = sorted(tuple(each["pose"]) for each in entities(found).values())
    assert places == sorted((x, y, 0.5) for x in (0, 2, 2, 4) for y in (0, 9))


def test_what_instances_cannot_be_is_a_loss(tmp_path: Path) -> None:
    more = (
        "vector3f[] velocities = [(1, 0, 0), (1, 0, 0)]\n"
        'color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)] (interpolation = "vertex")\n'
    )
    first = instancer("first", 2, "first/rock", ROCK, more)
    hidden = instancer("hidden", 1, "hidden/rock", ROCK, "int64[] invisibleIds = [0]\nfloat3[] scales = []\n")
    third = hidden + instancer("third", 1, "third", ROCK) + instancer("fourth", 1, "none", ROCK)
    found = read(tmp_path, first + third)
    assert list(entities(found)) == ["rock", "rock_2"]
    lost = [("animations", "first"), ("material-looks", "first")]
    lost += [("point-instancers", name) for name in ("hidden", "third", "fourth")]
    assert [(loss.kind, loss.path.removeprefix("/World/")) for loss in found.losses] == lost


def test_instancers_that_contain_one_another_are_refused(tmp_path: Path) -> None:
    text = f'def Xform "p"\n{{\n{instancer("b", 1, "q", "")}}}\ndef Xform "q"\n{{\n{instancer("c", 1, "p", "")}}}\n'
    found, sink = attempt(tmp_path, text)
    assert found is None
    assert [(one.code, "Cycle detected" in one.message) for one in sink.diagnostics()] == [("SC430", True)]


@pytest.mark.parametrize("head", [HEAD, "metersPerUnit = 1"])
def test_no_entity_is_named_after_the_world(tmp_path: Path, head: str) -> None:
    bottle = 'def Cube "bottle" (prepend apiSchemas = ["PhysicsCollisionAPI"])\n{\n}\n'
    assert list(entities(read(tmp_path, bottle, head=head))) == ["bottle"]
    bodies = "".join(f'def Cube "{name}" ({BODY})\n{{\n}}\n' for name in ("rail", "cart"))
    found = read(tmp_path, bottle + bodies + joint("PhysicsPrismaticJoint", "rail", "cart"), head=head)
    assert list(entities(found)) == ["bottle", "rail"]


def test_moving_surfaces_are_a_loss_of_their_own(tmp_path: Path) -> None:
    schemas = BODY.replace("[", '["PhysxSurfaceVelocityAPI", ')
    velocity = "vector3f physxSurfaceVelocity:surfaceVelocity = (1, 0, 0)"
    assert kinds(read(tmp_path, f'def Cube "belt" ({schemas})\n{{\n{velocity}\n}}\n')) == ["moving-surfaces"]


@pytest.mark.parametrize(
    ("source", "schema", "mimic"),
    [
        ("joint", "PhysxMimicJointAPI", {"joint": "joint", "multiplier": -2, "offset": -0.17453292}),
        ("missing", "PhysxMimicJointAPI", None),
        ("joint", "NewtonMimicAPI", None),
    ],
)
def test_a_joint_that_follows_another(tmp_path: Path, source: str, schema: str, mimic: dict[str, Any] | None) -> None:
    """PhysX's relation is position + gearing · reference + offset = 0, angles in degrees."""
    keys = (
        f"rel physxMimicJoint:rotZ:referenceJoint = </World/{source}>\nfloat physxMimicJoint:rotZ:gearing = 2\n"
        "float physxMimicJoint:rotZ:offset = 10\n"
    )
    follower = joint("PhysicsRevoluteJoint", "b", "c", keys)
    follower = follower.replace('"joint"', f'"follower" (prepend apiSchemas = ["{schema}:rotZ"])')
    found = read(tmp_path, bodies("a", "b", "c") + joint("PhysicsRevoluteJoint", "a", "b") + follower)
    assert ("joint-couplings" in kinds(found)) == (mimic is None)
    middle = entities(found)["a"]["root"]["children"][0]
    assert middle["children"][0]["joint"].get("mimic") == mimic


@pytest.mark.parametrize(("purpose", "kind"), [("", "material-looks"), (":physics", "contact-materials")])
@pytest.mark.parametrize("target", ["missing", "box"])
def test_a_material_that_is_missing(tmp_path: Path, purpose: str, kind: str, target: str) -> None:
    schemas = BODY.replace("[", '["MaterialBindingAPI", ')
    text = f'def Cube "box" ({schemas})\n{{\nrel material:binding{purpose} = </World/{target}>\n}}\n'
    assert kinds(read(tmp_path, text)) == [kind]


def test_colours_beyond_the_range_are_cut(tmp_path: Path) -> None:
    """A colour of 1.2 is no reason to refuse a stage."""
    schemas = BODY.replace("[", '["MaterialBindingAPI", ')
    inputs = (
        "color3f inputs:diffuseColor = (1.2, nan, 0.5)\ncolor3f inputs:emissiveColor = (10, inf, 0)\n"
        "float inputs:roughness = -3\n"
    )
    shader = f'def Shader "s"\n{{\nuniform token info:id = "UsdPreviewSurface"\n{inputs}token outputs:surface\n}}\n'
    text = (
        f'def Material "m"\n{{\ntoken outputs:surface.connect = </World/m/s.outputs:surface>\n{shader}}}\n'
        f'def Cube "box" ({schemas})\n{{\nrel material:binding = </World/m>\n}}\n'
    )
    found = read(tmp_path, text)
    assert kinds(found) == ["material-looks"] * 3
    look = {"base_color": [1, 0, 0.5], "emission": [10, 1, 0], "roughness": 0}
    assert found.document["materials"]["m"] == {"visual": look}
