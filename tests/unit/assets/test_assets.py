"""The rules of the asset checks, one file at a time."""

from __future__ import annotations

import base64
import json
import os
import struct
import subprocess
import sys
import time
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.mesh_files import (
    FACES,
    POINTS,
    TETRA,
    codes,
    diagnose,
    glb,
    gltf_document,
    named_by,
    plan_of,
    ply,
    stl,
    stl_text,
    write,
)
from plugins.nightly import assert_took
from plugins.sample_plans import indices

from scenecc import validate
from scenecc.assets import files
from scenecc.assets.measures import hull_parts
from scenecc.checks.assets import check_assets
from scenecc.diagnostics import Sink
from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.diagnostic import Origin
from scenecc.files import open_regular
from scenecc.plan import BodyStructure, Entity, Physics, ScenePlan, Sphere, VisualShape, constant, per_scene
from scenecc.plan.body import AssetFile, Texture, VisualMaterial

USES = ("hull", "triangles", "parts", "decomposed", "visual")
WHOLE: dict[str, bytes] = {
    "a.obj": TETRA.encode(),
    "A.OBJ": TETRA.encode(),
    "crlf.obj": TETRA.replace("\n", "\r\n").encode(),
    "bom.obj": b"\xef\xbb\xbf# a comment\n" + TETRA.encode(),
    "negative.obj": TETRA.replace("f 1 3 2", "f -4 -2 -3").encode(),
    "slashes.obj": TETRA.replace("f 1 3 2", "f 1/1/1 3//1 2/1").encode(),
    "continued.obj": TETRA.replace("v 0.1 0 0", "v 0.1 \\\n0 0").encode(),
    "coloured.obj": TETRA.replace("v 0 0 0", "v 0 0 0 1 0.5 0", 1).encode(),
    "weighted.obj": TETRA.replace("v 0 0 0.1", "v 0 0 0.2 2").encode(),
    "normals.obj": ("vn 0 0 1\nvn nan nan nan\n" + TETRA.replace("f 1 3 2", "f 1//-1 3//1 2//1")).encode(),
    "lines.obj": (TETRA + "l 1 2 3\np 4\ng a\n").encode(),
    "everything.obj": b"vt 0 1\nvt 1 1 0\nvn 0 0 1\n" + TETRA.replace("f 1 3 2", "f 1/2/1 3/1/1 2/1/1").encode(),
    "quads.obj": b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nf 1 4 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n",
    "a.stl": stl(),
    "text.stl": stl_text(),
    "a.ply": ply(),
    "big.ply": ply(kind="binary_big_endian"),
    "text.ply": ply(kind="ascii"),
    "number_in_comment.ply": ply(kind="ascii").replace(b"by hand", b"by hand\ncomment 2 by hand"),
    "binary_comment.ply": ply().replace(b"comment made", b"comment 2"),
    "a.glb": glb(),
}


@pytest.mark.parametrize("name", WHOLE)
def test_whole_files_pass_in_every_use(tmp_path: Path, name: str) -> None:
    path = write(tmp_path, name, WHOLE[name])
    expected = ["SC421"] if name.endswith(".stl") else []
    assert codes(path, *USES) == expected


NORMALS = "vn 0 0 1\n" + TETRA.replace("f 1 3 2", "f 1//1 3//1 2//1")
BROKEN: dict[str, tuple[str | bytes, str]] = {
    "words.obj": ("for a mesh\n", "SC413"),
    "index.obj": (TETRA.replace("f 3 1 4", "f 3 1 9"), "SC412"),
    "before_the_first.obj": (TETRA.replace("f 3 1 4", "f 3 1 -9"), "SC412"),
    "huge_index.obj": (TETRA.replace("f 3 1 4", f"f 3 1 {10**30}"), "SC412"),
    "float_index.obj": (TETRA.replace("f 3 1 4", "f 3 1 4.5"), "SC412"),
    "two_coordinates.obj": (TETRA.replace("v 0.1 0 0", "v 0.1 0"), "SC412"),
    "comma.obj": (TETRA.replace("v 0.1 0 0", "v 0,1 0 0"), "SC412"),
    "python_number.obj": (TETRA.replace("v 0.1 0 0", "v 1_0 0 0"), "SC412"),
    "binary.obj": (bytes(range(256)) * 10, "SC412"),
    "an_stl.obj": (stl(), "SC412"),
    "comment_in_a_face.obj": (TETRA.replace("f 3 1 4", "f 3 1 4 # the last"), "SC412"),
    "indented.obj": (TETRA.replace("v 0.1 0 0", "  v 0.1 0 0"), "SC412"),
    "mark.obj": (b"\xef\xbb\xbf" + TETRA.encode(), "SC412"),
    "old_line_breaks.obj": ("# a comment\rf 9 9 9\n" + TETRA, "SC412"),
    "no_break_space.obj": (TETRA.replace("v 0.1 0 0", "v 0.1 0\u00a00"), "SC412"),
    "only_lines.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n", "SC413"),
    "empty.obj": ("", "SC413"),
    "comment.obj": ("# nothing\n", "SC413"),
    "points.obj": ("v 0 0 0\nv 1 0 0\n", "SC413"),
    "an_obj.stl": (TETRA, "SC412"),
    "end.ply": (ply().replace(b"end_header", b"end_headers"), "SC412"),
    "cut.stl": (stl()[:-1], "SC412"),
    "longer.stl": (stl() + b"x", "SC412"),
    "header.stl": (stl()[:50], "SC412"),
    "no_triangles.stl": (bytes(84), "SC413"),
    "empty.stl": ("", "SC412"),
    "text_cut.stl": (stl_text()[:200], "SC412"),
    "text_empty.stl": ("solid\nendsolid\n", "SC413"),
    "text_split.stl": (stl_text().replace(b"vertex 0.1 ", b"vertex 0.1\n"), "SC412"),
    "cut.ply": (ply()[:-1], "SC412"),
    "longer.ply": (ply() + b"x", "SC412"),
    "index.ply": (ply(faces=FACES + 3), "SC412"),
    "negative_index.ply": (ply(faces=FACES - 1), "SC412"),
    "flat_faces.ply": (
        ply().replace(b"element face 4\nproperty list uchar int", b"element face 4\nproperty list uchar uchar"),
        "SC412",
    ),
    "no_faces.ply": (ply(faces=np.zeros((0, 3), int)), "SC413"),
    "claims.ply": (ply().replace(b"element vertex 4", b"element vertex 99999999999"), "SC412"),
    "claims_more.ply": (ply().replace(b"element vertex 4", b"element vertex 9999999999999999999999"), "SC412"),
    "no_x.ply": (ply().replace(b"float x", b"float u"), "SC412"),
    "type.ply": (ply().replace(b"float x", b"flaot x"), "SC412"),
    "no_end.ply": (ply().replace(b"end_header", b"the_header"), "SC412"),
    "empty.ply": ("", "SC412"),
    "cut.glb": (glb()[:-4], "SC412"),
    "header.glb": (glb()[:10], "SC412"),
    "no_json.glb": (glb().replace(b'{"asset"', b'("asset"'), "SC412"),
    "list.gltf": ("[1, 2]", "SC412"),
    "deep.gltf": ("[" * 100_000, "SC412"),
    "empty.gltf": ("", "SC412"),
    "nothing.gltf": ('{"asset": {"version": "2.0"}, "scenes": [{}]}', "SC413"),
    "no_scene.gltf": ('{"asset": {"version": "2.0"}}', "SC413"),
    "list_type.ply": (ply().replace(b"list uchar int", b"list uchar itn"), "SC412"),
    "list_count.ply": (ply().replace(b"list uchar int", b"list float int"), "SC412"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_mesh_files_are_reported(tmp_path: Path, name: str) -> None:
    data, code = BROKEN[name]
    path = write(tmp_path, name, data)
    for use in ("hull", "visual"):
        assert codes(path, use) == [code]


def in_all_uses(expected: list[str]) -> dict[str, list[str]]:
    return dict.fromkeys(USES, expected)


SHAPES: dict[str, tuple[np.ndarray, dict[str, list[str]]]] = {
    "one nan": (np.where(POINTS == 0.1, np.nan, POINTS), in_all_uses(["SC414"])),
    "an infinity": (np.where(POINTS == 0.1, np.inf, POINTS), in_all_uses(["SC414"])),
    "beyond float32": (POINTS * 1e40, in_all_uses(["SC414"])),
    "far away": (POINTS * 1e8, in_all_uses(["SC417"])),
    "flat": (
        POINTS * [1, 1, 0],
        {"hull": ["SC415"], "parts": ["SC415"], "triangles": [], "decomposed": [], "visual": []},
    ),
    "a line": (
        POINTS * [1, 0, 0],
        {"hull": ["SC415"], "parts": ["SC415"], "triangles": ["SC415"], "decomposed": ["SC415"], "visual": []},
    ),
    "flat and tilted": (
        np.array([[0, 0, 0], [1, 0, 1], [0, 1, 1], [1, 1, 2]]) / 10,
        {"hull": ["SC415"], "parts": ["SC415"], "triangles": [], "decomposed": [], "visual": []},
    ),
    "a millimetre": (
        POINTS / 100,
        {"hull": [], "parts": [], "triangles": [], "decomposed": [], "visual": []},
    ),
    "a micrometre": (
        POINTS / 1e5,
        {"hull": ["SC415"], "parts": ["SC415"], "triangles": [], "decomposed": [], "visual": []},
    ),
    "a kilometre": (POINTS * 1e4, in_all_uses([])),
    "off centre": (POINTS + np.array([100, -20, 3]), in_all_uses([])),
    "off centre by kilometres": (
        POINTS + np.array([0, 20_000, 0]),
        {"hull": ["SC417"], "parts": ["SC417"], "triangles": [], "decomposed": [], "visual": []},
    ),
}


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize("name", SHAPES)
def test_requirements_of_a_mesh_by_use(tmp_path: Path, name: str, use: str) -> None:
    points, expected = SHAPES[name]
    text = "".join("v {:.9g} {:.9g} {:.9g}\n".format(*p) for p in points) + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    assert codes(write(tmp_path, "a.obj", text), use) == expected[use]


def test_a_flat_part_among_others_is_reported(tmp_path: Path) -> None:
    text = "o solid\n" + TETRA + "o flat\nv 1 0 0\nv 2 0 0\nv 1 1 0\nf 5 6 7\n"
    path = write(tmp_path, "a.obj", text)
    assert codes(path, "parts") == ["SC415"]
    assert codes(path, "hull", "triangles", "visual", "decomposed") == []
    # Parts of a PLY are those that share no vertex.
    points = np.concatenate([POINTS, [[1, 0, 0], [2, 0, 0], [1, 1, 0]]])
    path = write(tmp_path, "a.ply", ply(points, np.concatenate([FACES, [[4, 5, 6]]])))
    assert codes(path, "parts") == ["SC415"]
    assert codes(path, "hull") == []


def test_unsupported_mesh_formats_are_reported(tmp_path: Path) -> None:
    for name in ("a.fbx", "a.blend", "a", "a.txt", "a.png"):
        assert codes(write(tmp_path, name, TETRA), "visual") == ["SC410"], name
    for name in ("a.usd", "a.USDZ", "a.usda", "a.usdc"):
        assert codes(write(tmp_path, name, "#usda 1.0"), "visual") == ["SC411"], name


def test_a_mesh_above_the_limit_of_bytes_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "a.obj", TETRA)
    assert codes(path, "hull", max_asset_bytes=len(TETRA)) == []
    assert codes(path, "hull", max_asset_bytes=len(TETRA) - 1) == ["SC607"]


def test_a_missing_mesh_file_is_reported(tmp_path: Path) -> None:
    assert codes(tmp_path / "gone.obj", "hull") == ["SC407"]


# --- what assets name ---------------------------------------------------------------------------------------------


def png(columns: int = 2, rows: int = 2) -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    pixels = zlib.compress(b"\0" * (3 * 2 + 1) * 2)
    header = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def painted(folder: Path, mtl: str, name: str = "paint.mtl") -> Path:
    write(folder, "paint.mtl", mtl)
    return write(folder, "a.obj", f"mtllib {name}\n{TETRA}")


def test_an_obj_material_and_its_images_are_checked(tmp_path: Path) -> None:
    (tmp_path / "my images").mkdir()
    write(tmp_path, "my images/a b.png", png())
    path = painted(
        tmp_path, "newmtl x\nmap_Kd -s 1 1 1 -o 0.5 -clamp on my images/a b.png\nbump -bm 0.3 my images/a b.png\n"
    )
    assert codes(path, *USES) == []
    path = painted(tmp_path, "newmtl x\nmap_Kd my images/c.png\n")
    assert [(d.code, d.path) for d in diagnose(path, "hull", "visual")] == [("SC418", "bodies[1].file")]
    path = painted(tmp_path, "newmtl x\n", "other.mtl")
    assert codes(path, "hull", "triangles") == []
    assert codes(path, "hull", "visual") == ["SC418"]


def test_files_outside_of_the_scene_that_an_asset_names_are_refused(tmp_path: Path) -> None:
    write(tmp_path, "secret.mtl", "newmtl x\n")
    folder = tmp_path / "scene"
    folder.mkdir()
    assert codes(painted(folder, "", "../secret.mtl"), "hull") == ["SC419"]
    assert codes(painted(folder, "newmtl x\nmap_Kd http://example.org/a.png\n"), "visual") == ["SC419"]
    document, body = gltf_document()
    document["images"] = [{"uri": "../secret.png"}, {"uri": "%2e%2e/other.png"}]
    assert codes(write(folder, "a.glb", glb(document, body)), "hull") == ["SC419", "SC419"]
    document["buffers"][0]["uri"] = "file:///etc/passwd"
    assert codes(write(folder, "a.gltf", json.dumps(document)), "hull") == ["SC419"]


def test_an_invalid_image_of_a_mesh_is_reported(tmp_path: Path) -> None:
    write(tmp_path, "a.png", b"hello")
    assert codes(painted(tmp_path, "newmtl x\nmap_Kd a.png\n"), "hull", "visual") == ["SC420"]
    write(tmp_path, "a.webp", b"RIFF")
    assert codes(painted(tmp_path, "newmtl x\nmap_Kd a.webp\n"), "visual") == ["SC410"]


# --- glTF ---------------------------------------------------------------------------------------------------------


def test_gltf_buffers_and_images_in_files_are_checked(tmp_path: Path) -> None:
    document, body = gltf_document()
    document["buffers"][0]["uri"] = "the data.bin"
    path = write(tmp_path, "a.gltf", json.dumps(document))
    assert codes(path, "hull") == ["SC418"]
    write(tmp_path, "the data.bin", body[:-1])
    assert codes(path, "hull") == ["SC412"]
    write(tmp_path, "the data.bin", body)
    assert codes(path, *USES) == []
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(body).decode()
    assert codes(write(tmp_path, "b.gltf", json.dumps(document)), *USES) == []


@pytest.mark.parametrize("kind", ["buffers", "images"])
def test_file_names_with_percent_escapes_are_refused(tmp_path: Path, kind: str) -> None:
    document, body = gltf_document()
    document["buffers"][0]["uri"] = "data.bin"
    write(tmp_path, "data.bin", body)
    for name in ("a b", "a%20b", "50%"):
        write(tmp_path, name + ".bin", body)
        write(tmp_path, name + ".png", png())
        named = {"buffers": {"byteLength": len(body), "uri": name + ".bin"}, "images": {"uri": name + ".png"}}
        path = write(tmp_path, "a.gltf", json.dumps({**document, kind: [named[kind]]}))
        assert codes(path, "visual") == (["SC418"] if name == "a%20b" else [])
        assert codes(path, "hull") == (["SC418"] if name == "a%20b" and kind == "buffers" else [])


def changed(change: Any) -> bytes:
    document, body = gltf_document()
    change(document)
    return glb(document, body)


def with_normals(document: dict[str, Any], **accessor: Any) -> None:
    """Gives the first primitive normals, which are its positions but for what is said."""
    document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = len(document["accessors"])
    document["accessors"].append({**document["accessors"][0], **accessor})


GLTF_FAULTS: dict[str, tuple[Any, str]] = {
    "normals that are not there": (lambda d: with_normals(d, bufferView=9), "SC412"),
    "normals of no kind": (lambda d: with_normals(d, componentType=7), "SC412"),
    "normals past the buffer": (lambda d: with_normals(d, byteOffset=40), "SC412"),
    "positions of integers": (lambda d: d["accessors"][0].update(componentType=5122), "SC415"),
    "indices of floats": (lambda d: d["accessors"][1].update(componentType=5126), "SC415"),
    "half a character": (lambda d: d["nodes"][0].update(name="\ud800"), "SC412"),
    "a node that is not there": (lambda d: d["scenes"][0].update(nodes=[7]), "SC412"),
    "an index that is true": (lambda d: d["scenes"][0].update(nodes=[True]), "SC412"),
    "a negative index": (lambda d: d["nodes"][0].update(mesh=-1), "SC413"),
    "past the buffer": (lambda d: d["accessors"][0].update(byteOffset=8), "SC412"),
    "far past the buffer": (lambda d: d["accessors"][0].update(count=10**7), "SC412"),
    "stride past the buffer": (lambda d: d["bufferViews"][0].update(byteStride=60), "SC412"),
    "no bytes claimed": (
        lambda d: d["accessors"].__setitem__(0, {"componentType": 5126, "count": 10**9, "type": "VEC3"}),
        "SC607",
    ),
    "compressed": (lambda d: d.update(extensionsUsed=["KHR_draco_mesh_compression"]), "SC410"),
    "a matrix of three": (lambda d: d["nodes"][0].update(matrix=[1, 2, 3]), "SC412"),
    "nan in a node": (lambda d: d["nodes"][0].update(translation=[float("nan"), 0, 0]), "SC412"),
    "flattened by a node": (lambda d: d["nodes"][0].update(scale=[1, 1, 0]), "SC415"),
    "points": (lambda d: d["meshes"][0]["primitives"][0].update(mode=0), "SC413"),
    "not in the scene": (lambda d: d["scenes"][0].update(nodes=[]), "SC413"),
    "text for a list": (lambda d: d.update(nodes="abc"), "SC412"),
    "null for a mapping": (lambda d: d.update(accessors=None), "SC412"),
}


@pytest.mark.parametrize("name", GLTF_FAULTS)
def test_broken_gltf_files_are_refused_quickly(tmp_path: Path, name: str) -> None:
    change, code = GLTF_FAULTS[name]
    start = time.process_time()
    assert codes(write(tmp_path, "a.glb", changed(change)), "hull") == [code]
    assert_took(time.process_time() - start, most=1)


@pytest.mark.parametrize("limit", [None, 40_000])
def test_gltf_instances_count_for_the_limit_of_bytes(tmp_path: Path, limit: int | None) -> None:
    """A mesh that a small file places a thousand times takes as much as it says; what is known is not read again."""
    document, body = gltf_document(POINTS * (1 if limit is None else 2))
    document["nodes"] = [{"mesh": 0} for _ in range(1000)]
    document["scenes"] = [{"nodes": list(range(1000))}]
    path = write(tmp_path, "b.glb", glb(document, body))
    if limit is None:
        assert codes(path, "hull") == []
    else:
        assert codes(path, "hull", max_asset_bytes=limit) == ["SC607"]


def test_gltf_nodes_move_and_turn(tmp_path: Path) -> None:
    """Three flat squares, each turned by its node, enclose a volume; unturned they lie in one plane."""
    flat = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) / 10.0
    document, body = gltf_document(flat, np.array([[0, 1, 2]]))
    assert codes(write(tmp_path, "a.glb", glb(document, body)), "hull") == ["SC415"]
    half = 2**-0.5
    document["nodes"] = [
        {"mesh": 0, "children": [1]},
        {"mesh": 0, "rotation": [half, 0, 0, half], "translation": [0, 0, 0.1]},
    ]
    assert codes(write(tmp_path, "a.glb", glb(document, body)), "hull") == []
    document["nodes"][1] = {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1]}
    assert codes(write(tmp_path, "a.glb", glb(document, body)), "hull") == []


def test_gltf_sparse_positions_are_refused(tmp_path: Path) -> None:
    document, body = gltf_document()
    indices = {"bufferView": 1, "componentType": 5125}
    document["accessors"][0]["sparse"] = {"count": 1, "indices": indices, "values": {"bufferView": 0}}
    assert codes(write(tmp_path, "a.glb", glb(document, body)), "hull") == ["SC410"]


# --- places, and what is read ---------------------------------------------------------------------------------------


def test_a_file_is_read_once_and_reported_at_its_first_use(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path, "a.obj", TETRA.replace("v 0 0 0.1", "v 0.2 0 0"))
    opened: list[Path] = []
    monkeypatch.setattr(files, "open_regular", lambda path: opened.append(path) or open_regular(path))
    found = diagnose(path, "visual", "triangles", "hull", "hull", "parts")
    assert [(d.code, d.path) for d in found] == [("SC415", "bodies[2].file")]
    assert opened == [path]


def test_every_alternative_of_a_varying_file_is_checked(tmp_path: Path) -> None:
    paths = [write(tmp_path, f"{i}.obj", text) for i, text in enumerate([TETRA, "", TETRA, "v 0 0 0\nf 1 2 3\n"])]
    sink = Sink()
    plan = plan_of(paths, "hull", files=per_scene([0, 1, 0, 3], np.int64))
    check_assets(plan, sink, resolve_named=named_by(tmp_path), max_asset_bytes=2**26)
    assert sorted((d.code, d.message.split(":")[0]) for d in sink.diagnostics()) == [
        ("SC412", "3.obj"),
        ("SC413", "1.obj"),
    ]


def textured(path: Path) -> ScenePlan:
    material = VisualMaterial(base_color_texture=Texture(indices(0)), normal_texture=Texture(indices(0)))
    shape = VisualShape(Sphere(constant(1)), material=constant(1, np.int64), origin=Origin("s", ("ball",)))
    body = BodyStructure("none", visuals=(shape,))
    entity = Entity("ball", (0,), constant([0, 0, 0, 1, 0, 0, 0]), (body,))
    files = (AssetFile(path.name, path),)
    return ScenePlan("p", 1, (entity,), Physics(), files, visual_materials=(VisualMaterial(), material))


IMAGES: dict[str, tuple[bytes, str | None]] = {
    "a.png": (png(), None),
    "renamed.jpg": (png(), None),
    "no_pixels.jpg": (bytes.fromhex("ffd8ffe000104a46494600010100000100010000ffc0000b080010002001011100ffd9"), "SC420"),
    "no_header.bmp": (b"BM" + bytes(12) + struct.pack("<Iii", 40, 4, -4) + bytes(40), "SC420"),
    "a.tga": (struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, 4, 4, 24, 0) + bytes(48), None),
    "a.hdr": (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes(128), None),
    "cut.png": (png()[:-8], "SC420"),
    "head.png": (png()[:20], "SC420"),
    "no_pixels.png": (png()[:33] + png()[-12:], "SC420"),
    "empty.png": (b"", "SC420"),
    "zero.png": (png(0, 2), "SC420"),
    "bomb.png": (png(65535, 65535), "SC607"),
    "lossless.jpg": (bytes.fromhex("ffd8ffc3000b080010002001011100ffd9"), "SC420"),
    "no_size.jpg": (bytes.fromhex("ffd8ffda000200"), "SC420"),
    "words.bmp": (b"BMW is a car", "SC420"),
    "no_size.hdr": (b"#?RADIANCE\n", "SC420"),
    "a.gif": (b"GIF89a", "SC410"),
    "a.svg": (b"<svg/>", "SC410"),
}


@pytest.mark.parametrize("name", IMAGES)
def test_textures_are_checked(tmp_path: Path, name: str) -> None:
    data, code = IMAGES[name]
    plan = textured(write(tmp_path, name, data))
    sink = Sink()
    check_assets(plan, sink, resolve_named=named_by(tmp_path), max_asset_bytes=2**26)
    assert [(d.code, d.path) for d in sink.diagnostics()] == ([(code, "ball.material")] if code else [])
    sink = Sink()
    named = replace(plan, files=(replace(plan.files[0], origin=Origin("s", ("materials", "m"))),))
    check_assets(named, sink, resolve_named=named_by(tmp_path), max_asset_bytes=2**26)
    assert [(d.code, d.path) for d in sink.diagnostics()] == ([(code, "materials.m")] if code else [])


def test_importing_assets_loads_no_heavy_package() -> None:
    code = (
        "import sys, scenecc.checks.assets; print(sorted({'trimesh', 'sapien', 'yaml', 'pydantic'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout == "[]\n"


def test_every_asset_code_is_in_the_table() -> None:
    # From SC430 on they are of imports, and from SC450 on of robots' files.
    assert [code for code in CODES if "SC400" < code < "SC430"] == [f"SC40{i}" for i in range(1, 8)] + [
        f"SC4{i}" for i in [*range(10, 25), 28, 29]
    ]


def loose_parts(faces: np.ndarray) -> list[set[int]]:
    """Connected vertices, found the slow way."""
    parts: list[set[int]] = []
    for face in faces.tolist():
        met = [one for one in parts if one & set(face)]
        parts = [one for one in parts if one not in met] + [set(face).union(*met)]
    return parts


@pytest.mark.parametrize("seed", range(20))
def test_connected_parts_equal_a_reference(seed: int) -> None:
    draw = np.random.default_rng(seed)
    faces = draw.integers(0, 60, (draw.integers(1, 60), 3))
    used, inverse = np.unique(faces, return_inverse=True)
    points, mesh = draw.random((len(used), 3)), inverse.reshape(-1, 3)
    parts = hull_parts([(points, mesh)], ".ply")
    assert sorted(len(vertices) for vertices, _ in parts) == sorted(map(len, loose_parts(mesh)))
    assert sum(len(each) for _, each in parts) == len(faces)
    corners = np.concatenate([vertices[each].reshape(-1, 9) for vertices, each in parts])
    assert sorted(corners.tolist()) == sorted(points[mesh].reshape(-1, 9).tolist())


@pytest.mark.parametrize("order", ["along", "against", "mixed"])
def test_connected_parts_of_a_long_strip_are_found_quickly(order: str) -> None:
    count = 200_000
    along = {
        "along": np.arange(count),
        "against": np.arange(count)[::-1],
        "mixed": np.random.default_rng(0).permutation(count),
    }
    strip = along[order]
    faces = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
    start = time.process_time()
    assert len(hull_parts([(np.zeros((count, 3)), faces)], ".ply")) == 1
    assert_took(time.process_time() - start, most=5)


@pytest.mark.parametrize("use", ["mesh", "image"])
def test_a_path_that_is_not_in_utf_8_is_reported(tmp_path: Path, use: str) -> None:
    """Which SAPIEN's functions do not take."""
    folder = tmp_path / os.fsdecode(b"bad\xff")
    folder.mkdir()
    write(folder, "a.obj", TETRA)
    write(folder, "a.png", png(4, 4))
    shape: dict[str, Any] = {"type": "mesh", "file": "a.obj"}
    if use == "image":
        shape = {"type": "sphere", "radius": 1, "material": {"visual": {"base_color_texture": "a.png"}}}
    scene = {"scenecc": 1, "entities": {"a": {"body_type": "none", "visuals": [shape]}}}
    write(folder, "scene.yaml", json.dumps(scene))
    (found,) = validate(folder / "scene.yaml")
    assert (found.code, found.message.partition(": ")[2].partition(",")[0]) == (
        "SC403", f"the path of a.{'obj' if use == 'mesh' else 'png'} is not in UTF-8",
    )  # fmt: skip
