"""Meshes in text as others write them, and meshes that only some readers understand."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import pytest
from PIL import Image
from plugins.mesh_files import codes, diagnose, glb, gltf_document, ply, stl

import scenecc
from scenecc.assets.names import scan_names

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


@pytest.mark.parametrize(
    "text",
    [
        TETRAHEDRON.replace(" ", "\t"),
        TETRAHEDRON.replace("f 1 2", "f\t1 2"),
        "# Größe\ng Größe\n" + TETRAHEDRON,
    ],
)
def test_an_obj_is_read_whatever_separates_its_words(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.obj"
    path.write_bytes(text.encode("latin-1"))
    assert not codes(path, "hull", "triangles", "visual")


def test_an_obj_face_that_cannot_be_read_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text(TETRAHEDRON + "f 1 2 x\n")
    assert codes(path, "hull") == ["SC412"]


def test_an_obj_face_of_two_corners_is_a_line(tmp_path: Path) -> None:
    """SAPIEN takes one of one or two corners for a point or a line, and shows neither."""
    path = tmp_path / "a.obj"
    path.write_text(TETRAHEDRON + "f 1/1 2/1\nf 1\n")
    assert not codes(path, "hull", "triangles", "visual")


def test_a_text_stl_may_have_a_name_in_another_encoding(tmp_path: Path) -> None:
    path = tmp_path / "a.stl"
    corners = [(0, 0, 0), (0, 1, 0), (1, 0, 0), (0, 0, 1)]
    facets = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in (corners[i] for i in face))
        + "endloop\nendfacet\n"
        for face in [(0, 1, 2), (0, 2, 3), (1, 0, 3), (2, 1, 3)]
    ]
    path.write_bytes(f"solid Größe\n{''.join(facets)}endsolid Größe\n".encode("latin-1"))
    assert not codes(path, "hull")


def test_ply_data_that_begins_like_a_line_break_is_refused(tmp_path: Path) -> None:
    """SAPIEN skips that byte, and some such files end its process."""
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\nend_header\n"
    for data, message in ((b"\n", "the first byte of its data"), (b"\r", "the first byte of its data"), (b"x", "")):
        path = tmp_path / "a.ply"
        path.write_bytes(header.encode() + data)
        (fault,) = diagnose(path, "hull")
        assert message in fault.message


def test_a_ply_header_that_repeats_its_format_is_read_once() -> None:
    """It took hours, and 3 s of a good PLY of 50 MB."""
    assert scan_names(b"ply\n" + b"format binary_ " * 100_000, ".ply").references == ()


@pytest.mark.parametrize("words", [b"o part", b"v 1.2", b"# a\ng 1"])
def test_a_binary_stl_may_begin_as_an_obj_does(tmp_path: Path, words: bytes) -> None:
    path = tmp_path / "a.stl"
    path.write_bytes(words.ljust(80) + stl()[80:])
    assert not codes(path, "hull", "triangles", "visual")


def test_a_gltf_triangle_fan_is_refused(tmp_path: Path) -> None:
    """trimesh leaves it out."""
    document, body = gltf_document()
    document["meshes"][0]["primitives"][0]["mode"] = 6
    path = tmp_path / "a.glb"
    path.write_bytes(glb(document, body))
    assert codes(path, "visual") == ["SC410"]


@pytest.mark.parametrize("limits", [(4000, 50_000, 4000), (50_000, 4000, 50_000)])
def test_a_mesh_refused_by_one_limit_is_read_with_a_higher_one(tmp_path: Path, limits: tuple[int, ...]) -> None:
    """What is known of a file does not depend on the limit with which it was read first."""
    stream = io.BytesIO()
    Image.new("RGB", (100, 100)).save(stream, "png")
    document, body = gltf_document()
    document["images"] = [{"uri": f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode()}"}]
    path = tmp_path / "a.glb"
    path.write_bytes(glb(document, body))
    assert [codes(path, "visual", max_asset_bytes=limit) for limit in limits] == [
        ["SC607"] if limit < 40_000 else [] for limit in limits
    ]


@pytest.mark.parametrize(
    "header",
    [
        "ply\nformat ascii 1.0\nend_headerX\ncomment TextureFile a.png\n",
        "PLY\nformat ascii 1.0\ncomment TextureFile a.png\n",
        "ply\nformat ascii 1.0\n end_header\ncomment TEXTUREFILE a.png\n",
    ],
)
def test_a_ply_texture_is_found_wherever_the_header_ends(tmp_path: Path, header: str) -> None:
    path = tmp_path / "a.ply"
    path.write_bytes(ply(kind="ascii").replace(b"ply\nformat ascii 1.0\n", header.encode()))
    assert set(codes(path, "visual")) & {"SC410", "SC412"}


def test_a_gltf_node_with_two_parents_is_refused(tmp_path: Path) -> None:
    """Forty in a chain could show a mesh a billion times."""
    document, body = gltf_document()
    document["nodes"] = [{"children": [1, 1]}, {"mesh": 0}]
    path = tmp_path / "a.glb"
    path.write_bytes(glb(document, body))
    assert codes(path, "hull") == ["SC412"]


def test_a_file_name_that_sapien_would_truncate_is_refused(tmp_path: Path) -> None:
    document, body = gltf_document()
    document["images"] = [{"uri": "./" * 507 + "a.pngg.png"}]
    path = tmp_path / "a.glb"
    path.write_bytes(glb(document, body))
    assert codes(path, "visual") == ["SC419"]


def test_coordinates_whose_square_overflows_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text(TETRAHEDRON.replace("v 1 0 0", "v 1e200 0 0"))
    assert codes(path, "hull") == ["SC414"]


def test_a_file_name_that_is_not_text_is_refused(tmp_path: Path) -> None:
    document, body = gltf_document()
    document["images"] = [{"uri": "a\ud800.png"}]
    (tmp_path / "a.glb").write_bytes(glb(document, body))
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {a: {body_type: static, visuals: [{type: mesh, file: a.glb}]}}\n")
    (fault,) = scenecc.validate(scene)
    assert fault.code in {"SC418", "SC419"}


OBJ = TETRAHEDRON.encode()
STL = b"solid a\nfacet normal 0 0 1\nouter loop\n"
OTHERS = {
    ".glb": {"an OBJ": b"# a\n\n# b\n" + OBJ, "an STL": STL, "neither a GLB": bytes(100), "line 1, column 2": b"{"},
    ".ply": {"an OBJ": OBJ, "an STL": STL, "does not begin with `ply`": bytes(100)},
    ".obj": {"an STL": STL, "a number in it cannot be read": OBJ.replace(b"1 0 0", b"1 0 0,5")},
    ".OBJ": {"a number in it cannot be read": OBJ + b"f 1 2 3 # comment\n"},
}


@pytest.mark.parametrize(("suffix", "words"), [(suffix, words) for suffix, each in OTHERS.items() for words in each])
def test_a_file_of_another_format_is_named_in_the_error(tmp_path: Path, suffix: str, words: str) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_bytes(OTHERS[suffix][words])
    (fault,) = diagnose(path, "hull")
    assert fault.code == "SC412"
    assert words in fault.message
