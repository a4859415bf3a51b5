"""GLB: read back by trimesh, and its header as JSON."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose
from PIL import Image
from plugins.plan_parts import ROOT
from trimesh.exchange.gltf import validate

import scenecc
from scenecc import export_scene, open_scene
from scenecc.backends.sapien import instantiate
from scenecc.diagnostics import Diagnostic, Sink

Emitted = tuple[bytes, list[Diagnostic]]

Y_UP = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
"""Rows: where x, y and z of a file are in a scene's."""


def emitted(
    source: Any, *, show: Literal["visual", "collision"] = "visual", grid: bool = False, outside: bool = False
) -> Emitted:
    made = open_scene(source, allow_outside_assets=outside).emit("glb", name="out", show=show, grid=grid)
    assert list(made.files) == ["out.glb"]
    return made.files["out.glb"], made.diagnostics


def loaded(data: bytes) -> trimesh.Scene:
    return trimesh.load_scene(io.BytesIO(data), file_type="glb")


def header(data: bytes) -> dict[str, Any]:
    (size,) = struct.unpack("<I", data[12:16])
    return json.loads(data[20 : 20 + size])


def bounds(scene: trimesh.Scene, name: str) -> np.ndarray:
    """(2, 3) lowest and highest corner of all shapes below a node, in the scene's frame with z up."""
    points = []
    for node in scene.graph.nodes_geometry:
        if node == name or node.startswith(f"{name}/"):
            place, geometry = scene.graph[node]
            points.append(trimesh.transform_points(scene.geometry[geometry].vertices, place) @ Y_UP)
    every = np.concatenate(points)
    return np.array([every.min(axis=0), every.max(axis=0)])


def box(**more: Any) -> dict[str, Any]:
    return {"body_type": "static", "shapes": [{"type": "box", "half_size": [0.1, 0.2, 0.3]}], **more}


def test_a_glb_has_extents_names_and_nodes() -> None:
    data, told = emitted(
        {
            "scenecc": 1,
            "entities": {
                "crate": box(pose=[1, 2, 3]),
                "rod": {
                    "body_type": "kinematic",
                    "pose": [0, 0, 5],
                    "shapes": [{"type": "capsule", "radius": 0.1, "half_length": 0.4, "axis": "z"}],
                },
                "sign": {
                    "body_type": "none",
                    "visuals": [
                        {"type": "sphere", "radius": 0.5, "name": "knob"},
                        {"type": "cylinder", "radius": 0.1, "half_length": 1, "axis": "y"},
                        {"type": "cylinder", "radius": 0.1, "half_length": 2, "axis": "x"},
                    ],
                },
            },
        }
    )
    assert not told
    scene = loaded(data)
    assert_allclose(bounds(scene, "crate"), [[0.9, 1.8, 2.7], [1.1, 2.2, 3.3]], atol=1e-6)
    assert_allclose(bounds(scene, "rod"), [[-0.1, -0.1, 4.5], [0.1, 0.1, 5.5]], atol=1e-6)
    assert_allclose(bounds(scene, "sign/knob"), [[-0.5] * 3, [0.5] * 3], atol=1e-6)
    assert_allclose(bounds(scene, "sign/cylinder"), [[-0.1, -1, -0.1], [0.1, 1, 0.1]], atol=1e-6)
    assert_allclose(bounds(scene, "sign/cylinder 2"), [[-2, -0.1, -0.1], [2, 0.1, 0.1]], atol=1e-6)
    assert set(scene.graph.nodes) == {
        "world",
        "out",
        *("crate", "crate/box", "rod", "rod/capsule"),
        *("sign", "sign/knob", "sign/cylinder", "sign/cylinder 2"),
    }
    # z is up in the scene, and y in the file.
    assert scene.bounds[1][1] == pytest.approx(5.5, abs=1e-6)


def test_glb_colours_are_those_of_the_file_to_the_last_bit(tmp_path: Path) -> None:
    look = {
        "base_color": [0.123456, 0.2, 0.3, 0.5],
        "metallic": 0.7,
        "roughness": 0.33,
        "specular": 0.25,
        "emission": [1, 0.5, 0, 4],
    }
    data, told = emitted(
        {
            "scenecc": 1,
            "materials": {"paint": {"visual": look}, "lamp": {"visual": {"specular": 0.75, "ior": 1.2}}},
            "entities": {"a": box(material="paint"), "b": box(material="lamp", pose=[1, 0, 0])},
        }
    )
    assert not told
    tree = header(data)
    paint, lamp = tree["materials"]
    assert paint["pbrMetallicRoughness"] == {
        "baseColorFactor": [0.123456, 0.2, 0.3, 0.5],
        "metallicFactor": 0.7,
        "roughnessFactor": 0.33,
    }
    assert paint["alphaMode"] == "BLEND"
    assert paint["emissiveFactor"] == [1, 0.5, 0]
    assert paint["extensions"]["KHR_materials_emissive_strength"] == {"emissiveStrength": 4}
    assert paint["extensions"]["KHR_materials_specular"] == {"specularFactor": 0.5}
    assert lamp["extensions"]["KHR_materials_specular"] == {
        "specularFactor": 1,
        "specularColorFactor": [1.5, 1.5, 1.5],
    }
    assert "alphaMode" not in lamp
    validate(tree)


def test_glb_textures_are_unchanged(tmp_path: Path) -> None:
    for name in ("checker.png", "wear.png", "bumps.png"):
        (tmp_path / name).write_bytes((ROOT / "scenes" / "assets" / name).read_bytes())
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scenecc: 1\nmaterials:\n"
        "  checked: {visual: {base_color: [1, 0, 0], base_color_texture: {file: checker.png, filter_mode: nearest, "
        "address_mode: mirror}, normal_texture: {file: bumps.png, srgb: false}}}\n"
        "  worn: {visual: {roughness_texture: {file: wear.png, srgb: false}, metallic: 0.25}}\n"
        "entities:\n  a: {body_type: static, material: checked, shapes: [{type: sphere, radius: 1}]}\n"
        "  b: {body_type: static, material: worn, shapes: [{type: sphere, radius: 1}]}\n",
        encoding="utf-8",
    )
    data, told = emitted(scene)
    assert not told
    tree = header(data)
    assert (ROOT / "scenes" / "assets" / "checker.png").read_bytes() in data
    assert (ROOT / "scenes" / "assets" / "bumps.png").read_bytes() in data
    checked, worn = tree["materials"]
    # SAPIEN shows an image in place of the colour; glTF multiplies them.
    assert checked["pbrMetallicRoughness"]["baseColorFactor"] == [1, 1, 1, 1]
    texture = tree["textures"][checked["pbrMetallicRoughness"]["baseColorTexture"]["index"]]
    assert tree["samplers"][texture["sampler"]] == {
        "magFilter": 9728,
        "minFilter": 9728,
        "wrapS": 33648,
        "wrapT": 33648,
    }
    assert "normalTexture" in checked
    assert worn["pbrMetallicRoughness"]["roughnessFactor"] == 1
    image = loaded(data).geometry["mesh 1"].visual.material.metallicRoughnessTexture
    wear = np.asarray(Image.open(ROOT / "scenes" / "assets" / "wear.png").convert("RGB"))
    pixels = np.asarray(image)
    assert (pixels[..., 1] == wear[..., 0]).all()
    assert (pixels[..., 2] == 64).all()
    validate(tree)


def test_glb_images_have_the_colour_space_of_gltf(tmp_path: Path) -> None:
    """SAPIEN reads an image as sRGB unless it is told otherwise, also where it stands in place of a number."""
    (tmp_path / "wear.png").write_bytes((ROOT / "scenes" / "assets" / "wear.png").read_bytes())
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scenecc: 1\nmaterials:\n  worn: {visual: {roughness_texture: wear.png, "
        "base_color_texture: {file: wear.png, srgb: false}}}\n"
        "entities:\n  a: {body_type: static, material: worn, shapes: [{type: sphere, radius: 1}]}\n",
        encoding="utf-8",
    )
    material = loaded(emitted(scene)[0]).geometry["mesh 0"].visual.material
    value = np.asarray(Image.open(ROOT / "scenes" / "assets" / "wear.png").convert("RGB"))[..., 0] / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    encoded = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    assert_allclose(np.asarray(material.metallicRoughnessTexture)[..., 1] / 255, linear, atol=0.5 / 255)
    assert_allclose(np.asarray(material.baseColorTexture.convert("RGB"))[..., 0] / 255, encoded, atol=0.5 / 255)


def test_glb_visibility_becomes_opacity() -> None:
    faint = {"body_type": "kinematic", "shapes": [{"type": "sphere", "radius": 1}]}
    data, _ = emitted(
        {"scenecc": 1, "entities": {"gone": {**faint, "visibility": 0}, "mist": {**faint, "visibility": 0.25}}}
    )
    tree = header(data)
    names = {node["name"] for node in tree["nodes"]} - {"world"}  # of older versions of trimesh
    assert names == {"out", "gone", "mist", "mist/sphere"}
    assert tree["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][3] == 0.25
    assert tree["materials"][0]["alphaMode"] == "BLEND"


def test_glb_visibility_becomes_opacity_with_an_image() -> None:
    paint = {"base_color": [1, 0, 0, 0.5], "base_color_texture": str(ROOT / "scenes" / "assets" / "checker.png")}
    ball = {"body_type": "kinematic", "material": "paint", "shapes": [{"type": "sphere", "radius": 1}]}
    data, _ = emitted(
        {
            "scenecc": 1,
            "materials": {"paint": {"visual": paint}},
            "entities": {"solid": ball, "mist": {**ball, "visibility": 0.25}},
        },
        outside=True,
    )
    solid, mist = header(data)["materials"]
    assert solid["pbrMetallicRoughness"]["baseColorFactor"] == [1, 1, 1, 1]
    assert mist["pbrMetallicRoughness"]["baseColorFactor"] == [1, 1, 1, 0.25]
    assert ("alphaMode" in solid, mist["alphaMode"]) == (False, "BLEND")


def test_glb_roughness_and_metallic_images_share_a_sampler() -> None:
    wear = str(ROOT / "scenes" / "assets" / "wear.png")
    for rough, metal, words in (
        (
            {},
            {"filter_mode": "nearest"},
            ["`metallic_texture` (wear) uses the sampler of `roughness_texture`: glTF stores both in one image"],
        ),
        ({}, {}, []),
        (None, {"address_mode": "border"}, ["`address_mode: border` of wear is written as `edge`"]),
    ):
        visual = {"metallic_texture": {"file": wear, "srgb": False, **metal}}
        if rough is not None:
            visual["roughness_texture"] = {"file": wear, "srgb": False, **rough}
        ball = {"body_type": "static", "material": "worn", "shapes": [{"type": "sphere", "radius": 1}]}
        scene = {"scenecc": 1, "materials": {"worn": {"visual": visual}}, "entities": {"ball": ball}}
        _, told = emitted(scene, outside=True)
        assert [one.message for one in told] == words


def test_export_scene_refuses_text_targets() -> None:
    for target in ("python", "json", "stl"):
        with pytest.raises(ValueError, match=r"the targets are glb, mjcf, urdf, usd"):
            export_scene({"scenecc": 1, "entities": {}}, target)


def test_glb_contains_hidden_entities_and_may_be_empty() -> None:
    ghost = {"body_type": "none", "hidden": True, "visuals": [{"type": "sphere", "radius": 1}]}
    assert_allclose(
        bounds(loaded(emitted({"scenecc": 1, "entities": {"out": ghost}})[0]), "out 2"), [[-1] * 3, [1] * 3]
    )
    tree = header(emitted({"scenecc": 1, "entities": {}})[0])
    assert {node["name"] for node in tree["nodes"]} - {"world"} == {"out"}


def test_a_mirrored_mesh_faces_outwards_in_glb(tmp_path: Path) -> None:
    (tmp_path / "gem.stl").write_bytes((ROOT / "scenes" / "assets" / "gem.stl").read_bytes())
    scene = tmp_path / "scene.yaml"
    text = "scenecc: 1\nentities:\n  gem: {{body_type: none, visuals: [{{type: mesh, file: gem.stl, scale: {}{}}}]}}\n"
    for scale, face, sign in (
        ("[1, 1, 1]", "", 1),
        ("[1, -1, 2]", "", 1),
        ("[1, 1, 1]", ", front_face: clockwise", -1),
        ("[1, -1, 1]", ", front_face: counterclockwise", -1),
    ):
        scene.write_text(text.format(scale, face), encoding="utf-8")
        data, _ = emitted(scene)
        # trimesh turns the triangles of a mirrored node around, as viewers do.
        volume = loaded(data).to_mesh().volume
        assert np.sign(volume) == sign, (scale, face)


def test_equal_shapes_are_written_once_in_glb() -> None:
    entities = {f"box_{i}": box(pose=[i, 0, 0]) for i in range(20)}
    entities["large"] = {"body_type": "static", "shapes": [{"type": "box", "half_size": [1, 1, 1]}], "pose": [0, 5, 0]}
    tree = header(emitted({"scenecc": 1, "entities": entities})[0])
    assert len(tree["meshes"]) == 1
    assert len([node for node in tree["nodes"] if node["name"] != "world"]) == 1 + 2 * 21


def test_a_robot_is_a_tree_of_links_at_engine_poses_in_glb() -> None:
    path = ROOT / "scenes" / "robot_arm.yaml"
    data, _ = emitted(path)
    tree, scene = header(data), loaded(data)
    by_name = {node["name"]: node for node in tree["nodes"]}
    children = [tree["nodes"][index]["name"] for index in by_name["arm/upper"].get("children", [])]
    assert "arm/lower" in children
    batch = instantiate(scenecc.compile_scene(path), Sink(), scene_idxs=[0], render=False)
    assert batch is not None
    with batch:
        for name in ("arm", "tumbling"):
            for link in batch.articulations[name].objs[0].get_links():
                place = scene.graph[f"{name}/{link.name}"][0]
                assert_allclose(Y_UP.T @ place[:3, 3], link.entity_pose.p, atol=2e-6)
                assert_allclose(Y_UP.T @ place[:3, :3], link.entity_pose.to_transformation_matrix()[:3, :3], atol=2e-6)


def test_glb_collision_shapes_are_those_of_the_engine(tmp_path: Path) -> None:
    (tmp_path / "mug.obj").write_bytes((ROOT / "scenes" / "assets" / "mug.obj").read_bytes())
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scenecc: 1\nentities:\n"
        "  ground: {body_type: static, shapes: [{type: plane}]}\n"
        "  mug: {pose: [0, 0, 1], collisions: [{type: convex_mesh, file: mug.obj, scale: 2}]}\n",
        encoding="utf-8",
    )
    data, told = emitted(scene, show="collision")
    (note,) = told
    assert (note.code, note.severity) == ("SC746", "note")
    assert note.location.line == 3
    read = loaded(data)
    seen = trimesh.load_mesh(ROOT / "scenes" / "assets" / "mug.obj")
    assert_allclose(bounds(read, "mug"), seen.bounds * 2 + [0, 0, 1], atol=1e-5)
    mesh = read.geometry[read.graph["mug/convex_mesh"][1]]
    # Its hull: corners of the file, behind each face of which all of them lie, but for what cooking takes off.
    behind = np.einsum("fi,pfi->pf", mesh.face_normals, seen.vertices[:, None] * 2 - mesh.triangles[:, 0])
    assert behind.max() < 2e-3
    assert np.linalg.norm(mesh.vertices[:, None] - seen.vertices * 2, axis=-1).min(axis=1).max() < 1e-5
    low, high = bounds(read, "ground")
    assert low[2] == pytest.approx(0, abs=1e-6)
    assert (low[:2] < bounds(read, "mug")[0][:2]).all()
    assert (high[:2] > bounds(read, "mug")[1][:2]).all()


def test_a_glb_of_four_scenes_is_a_grid(tmp_path: Path) -> None:
    data, told = emitted(
        {
            "scenecc": 1,
            "num_scenes": 4,
            "entities": {
                "ground": {"body_type": "static", "shapes": [{"type": "plane"}]},
                "ball": {
                    "pose": {"per_scene": [[0, 0, 1], [0.5, 0, 1], [1, 0, 1], [1.5, 0, 1]]},
                    "shapes": [{"type": "sphere", "radius": 0.25}],
                },
                "second_only": {**box(), "scene_idxs": [1]},
            },
        },
        grid=True,
    )
    assert [one.code for one in told] == ["SC746"]
    scene = loaded(data)
    names = set(scene.graph.nodes)
    assert {f"scene {k}/ball/sphere" for k in range(4)} <= names
    assert "scene 1/second_only" in names
    assert "scene 0/second_only" not in names
    grounds = [bounds(scene, f"scene {k}/ground") for k in range(4)]
    balls = [bounds(scene, f"scene {k}/ball").mean(axis=0) for k in range(4)]
    origins = [bounds(scene, f"scene {k}/ground").mean(axis=0) for k in range(4)]
    for k in range(4):
        assert_allclose(balls[k] - origins[k], [0.5 * k, 0, 1], atol=1e-5)
        for other in range(k):
            (low, high), (from_, to) = grounds[k][:, :2], grounds[other][:, :2]
            assert (low >= to - 1e-5).any() or (high <= from_ + 1e-5).any(), "squares of two scenes overlap"
    # As one reads: to the right, then down.
    assert origins[1][0] > origins[0][0]
    assert origins[2][1] < origins[0][1]


def test_features_that_glb_does_not_support_are_reported_with_their_line(tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scenecc: 1\nenvironment: {ambient_light: [1, 1, 1]}\n"
        "lights:\n  sun: {type: directional, direction: [0, 0, -1], color: [1, 1, 1]}\n"
        "cameras:\n  eye: {pose: [1, 0, 1], width: 64, height: 64, fovy: 1}\n"
        "entities:\n  a: {body_type: static, shapes: [{type: sphere, radius: 1}]}\n",
        encoding="utf-8",
    )
    _, told = emitted(scene)
    found = {(one.code, one.location.line) for one in told}
    assert found == {("SC745", 2), ("SC745", 4), ("SC745", 6)}
