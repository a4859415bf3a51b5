"""Mesh files: their triangles and looks against SAPIEN's own reading of the same files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose
from plugins.mesh_files import TETRA, checked, glb, gltf_document, ply, stl, write
from plugins.plan_parts import ROOT
from unit.assets.test_mesh_dae import DAE

from scenecc.meshes import AssetError
from scenecc.meshes.files import MeshFiles
from scenecc.plan.body import AssetFile

MTL = "newmtl glass\nKd 0.2 0.4 0.6\nd 0.5\nKe 0.1 0 0.2\nNs 500\nKs 0.3 0.2 0.1\n"


def coloured() -> bytes:
    document, body = gltf_document()
    document["materials"] = [
        {
            "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 0.6, 1], "roughnessFactor": 0.3},
            "emissiveFactor": [0.1, 0.2, 0.3],
        }
    ]
    document["meshes"][0]["primitives"][0]["material"] = 0
    return glb(document, body)


def turned() -> bytes:
    """A node that is turned, moved and scaled."""
    document, body = gltf_document()
    document["nodes"] = [
        {"children": [1], "translation": [1, 2, 3], "rotation": [0, 0, 0.70710678, 0.70710678]},
        {"mesh": 0, "scale": [1, 2, 3]},
    ]
    return glb(document, body)


def made(folder: Path, name: str) -> Path:
    if name in {"bowl.obj", "bowl.glb", "mug.obj", "gem.stl"}:
        return ROOT / "scenes" / "assets" / name
    write(folder, "glass.mtl", MTL)
    return write(
        folder,
        name,
        {
            "glass.obj": f"mtllib glass.mtl\nusemtl glass\n{TETRA}",
            "plain.glb": glb(),
            "coloured.glb": coloured(),
            "turned.glb": turned(),
            "plain.ply": ply(),
            "plain.stl": stl(),
            "centimetres.dae": DAE,
        }[name],
    )


@pytest.mark.render
@pytest.mark.parametrize(
    "name",
    [
        "bowl.obj",
        "bowl.glb",
        "mug.obj",
        "gem.stl",
        "glass.obj",
        "plain.glb",
        "coloured.glb",
        "turned.glb",
        "plain.ply",
        "plain.stl",
        "centimetres.dae",
    ],
)
def test_a_mesh_file_is_read_as_in_sapien(name: str, tmp_path: Path) -> None:
    from sapien import render

    path = made(tmp_path, name)
    theirs = render.RenderShapeTriangleMesh(str(path)).parts
    mine = MeshFiles().parts(checked(path, "visual"))
    assert len(mine) == len(theirs)
    for part, other in zip(mine, theirs, strict=True):
        surface, look, material = part.surface, part.look, other.material
        assert len(surface.faces) == len(other.triangles)
        assert_allclose(surface.vertices.min(axis=0), other.vertices.min(axis=0), atol=1e-6)
        assert_allclose(surface.vertices.max(axis=0), other.vertices.max(axis=0), atol=1e-6)
        red, green, blue, strength = material.emission
        assert_allclose(look.base_color, material.base_color, atol=1e-6)
        assert_allclose(look.emission, np.array([red, green, blue]) * strength, atol=1e-6)
        assert_allclose(
            [look.roughness, look.metallic, look.specular],
            [material.roughness, material.metallic, material.specular],
            atol=1e-6,
        )
        assert (look.base_color_image is None) == (material.base_color_texture is None)


LINES = {
    "map_Kd": "a.png",
    "map_Bump": "b.png",
    "norm": "c.png",
    "map_Ke": "d.png",
    "map_Pr": "-bm 1 e.png",
    "map_Pm": "f.png",
}
"""Of a material, with names that are in its folder."""


def painted(folder: Path, lines: dict[str, str]) -> Path:
    """A triangle with a material and its images."""
    for words in lines.values():
        name = words.removeprefix("-bm 1 ").removeprefix("-s 2 2 1 ")
        (folder / name).write_bytes((ROOT / "scenes" / "assets" / "checker.png").read_bytes())
    write(folder, "m.mtl", "newmtl m\n" + "".join(f"{key} {words}\n" for key, words in lines.items()))
    uvs = "vt 0 0\nvt 1 0\nvt 0 1\n"
    return write(folder, "m.obj", f"mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{uvs}f 1/1 2/2 3/3\n")


@pytest.mark.render
@pytest.mark.parametrize(
    "lines",
    [
        {**LINES, "map_Ks": "g.png"},
        {key: words.replace(".png", " of the mug.png") for key, words in LINES.items()},
        {"map_Kd": "-s 2 2 1 a.png", "norm": "-bm 1 my normal.png"},
    ],
    ids=["plain", "blanks", "options"],
)
def test_images_of_a_mesh_material_are_those_that_sapien_loads(tmp_path: Path, lines: dict[str, str]) -> None:
    from sapien import render

    path = painted(tmp_path, lines)
    theirs = render.RenderShapeTriangleMesh(str(path)).parts[0].material
    assert theirs.base_color_texture is not None
    (part,) = MeshFiles().parts(checked(path, "visual"))
    for slot in ("base_color", "normal", "emission", "roughness", "metallic", "transmission"):
        image, texture = getattr(part.look, f"{slot}_image"), getattr(theirs, f"{slot}_texture")
        assert (image is None) == (texture is None), slot
        if image is not None and slot != "base_color":
            assert f"{image.name}.png" == Path(texture.filename).name


def test_images_of_a_material_may_have_names_with_blanks(tmp_path: Path) -> None:
    lines = {"map_Kd": "-s 2 2 1 my color.png", "map_Pr": "-bm 1 my rough.png", "norm": "my normal.png"}
    (part,) = MeshFiles().parts(checked(painted(tmp_path, lines), "visual"))
    assert part.look.base_color_image is not None
    assert part.look.roughness_image is not None
    assert (part.look.roughness_image.name, part.look.metallic_image) == ("my rough", None)
    assert part.look.normal_image is not None


@pytest.mark.render
@pytest.mark.parametrize("name", ["bowl.obj", "bowl.glb"])
def test_texture_coordinates_equal_sapiens(name: str) -> None:
    from sapien import render

    path = ROOT / "scenes" / "assets" / name
    (theirs,), (mine,) = render.RenderShapeTriangleMesh(str(path)).parts, MeshFiles().parts(checked(path, "visual"))
    assert mine.surface.uvs is not None
    there = np.column_stack([theirs.vertices, theirs.get_vertex_uv()])
    here = np.column_stack([mine.surface.vertices, mine.surface.uvs])
    for row in here[np.unique(mine.surface.faces)]:
        assert np.abs(there - row).max(axis=1).min() < 1e-6


def test_normals_come_from_the_mesh_file(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=1)
    trimesh.Trimesh(ball.vertices, ball.faces, vertex_normals=ball.vertices, process=False).export(
        tmp_path / "ball.glb"
    )
    ball.export(tmp_path / "ball.ply", vertex_normal=True)
    for name in ("ball.glb", "ball.ply"):
        (part,) = MeshFiles().parts(checked(tmp_path / name, "visual"))
        assert part.surface.normals is not None
        lengths = np.linalg.norm(part.surface.vertices, axis=1, keepdims=True)
        assert_allclose(part.surface.normals, part.surface.vertices / lengths, atol=1e-5)
    (flat,) = MeshFiles().parts(checked(write(tmp_path, "flat.obj", TETRA), "visual"))
    assert flat.surface.normals is None


def test_files_with_the_same_content_are_read_once(tmp_path: Path) -> None:
    files = MeshFiles()
    first, second = (checked(write(tmp_path, f"{name}.stl", stl()), "visual") for name in "ab")
    assert files.parts(first) is files.parts(second)
    assert files.parts(first) is not files.parts(checked(write(tmp_path, "c.stl", stl(np.eye(4, 3))), "visual"))
    # An OBJ is more than its own text.
    (tmp_path / "there").mkdir()
    for folder, blue in ((tmp_path, "0"), (tmp_path / "there", "1")):
        write(folder, "m.mtl", f"newmtl m\nKd 0 0 {blue}\n")
        write(folder, "m.obj", f"mtllib m.mtl\nusemtl m\n{TETRA}")
    here, there = (files.parts(checked(folder / "m.obj", "visual")) for folder in (tmp_path, tmp_path / "there"))
    assert [here[0].look.base_color[2], there[0].look.base_color[2]] == [0, 1]


@pytest.mark.parametrize(
    ("name", "data"),
    [("missing.stl", None), ("broken.glb", b"glTF and so on"), ("empty.obj", "v 0 0 0\nv 1 0 0\n")],
)
def test_an_unreadable_mesh_file_is_an_error(name: str, data: str | bytes | None, tmp_path: Path) -> None:
    path = tmp_path / name
    if data is not None:
        write(tmp_path, name, data)
    with pytest.raises(AssetError, match=name.partition(".")[0]) as problem:
        MeshFiles().parts(AssetFile(name, path))
    assert problem.value.code == "SC747"


def test_roughness_and_metallic_are_separate_channels_of_one_image(tmp_path: Path) -> None:
    document, body = gltf_document()
    image = (ROOT / "scenes" / "assets" / "wear.png").read_bytes()
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(body), "byteLength": len(image)})
    document["buffers"][0]["byteLength"] = len(body) + len(image)
    document["images"] = [{"bufferView": 2, "mimeType": "image/png"}]
    document["textures"] = [{"source": 0}]
    document["materials"] = [{"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}}]
    document["meshes"][0]["primitives"][0]["material"] = 0
    path = write(tmp_path, "worn.glb", glb(json.loads(json.dumps(document)), body + image))
    (part,) = MeshFiles().parts(checked(path, "visual"))
    rough, metal = part.look.roughness_image, part.look.metallic_image
    assert rough is not None
    assert metal is not None
    assert (rough.channel, metal.channel) == ("g", "b")
    assert rough.digest == metal.digest


def test_only_checked_files_of_a_mesh_are_read(tmp_path: Path) -> None:
    """A reader takes this comment for the name of a library; the check and the engine do not."""
    image = (ROOT / "scenes" / "assets" / "checker.png").read_bytes()
    write(tmp_path, "secret.mtl", "newmtl a\nKd 0 0 1\nmap_Kd secret.png\n")
    write(tmp_path, "secret.png", image)
    (tmp_path / "scene").mkdir()
    uvs = "vt 0 0\nvt 1 0\nvt 0 1\n"
    faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/2 3/3\n"
    path = write(tmp_path / "scene", "a.obj", f"# mtllib ../secret.mtl\n{uvs}usemtl a\n{faces}")
    (part,) = MeshFiles().parts(checked(path, "visual"))
    assert part.look.base_color[:3] != (0, 0, 1)
    # What the reader makes of a mesh without a material, and not what lies outside.
    assert part.look.base_color_image is None or part.look.base_color_image.pixels.size == (2, 2)


def test_a_mesh_file_that_changed_since_the_check_is_an_error(tmp_path: Path) -> None:
    path = write(tmp_path, "a.stl", stl())
    file = checked(path, "visual")
    write(tmp_path, "a.stl", stl(np.eye(4, 3)))
    with pytest.raises(AssetError, match="changed") as problem:
        MeshFiles().parts(file)
    assert problem.value.code == "SC422"
