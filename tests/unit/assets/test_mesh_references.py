"""Which files a mesh names: what the engine's reader takes for a name is checked, or the mesh is refused.

SAPIEN 3.0.3 opened each `outside` from a mesh that had passed, or reads something else than was checked.
"""

from __future__ import annotations

import json
import os
import struct
from pathlib import Path

import pytest
from plugins.mesh_files import FACES, POINTS, TETRA, checked, codes, glb, gltf_document, named, ply, write
from unit.assets.test_assets import png
from unit.assets.test_mesh_dae import DAE, EFFECT

DOCUMENT, BODY = gltf_document()
DOCUMENT["buffers"][0]["uri"] = "mesh.bin"
GLTF = json.dumps(DOCUMENT)
HEAVY = (POINTS * 7).astype("<f4").tobytes() + FACES.astype("<u4").tobytes()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scene's folder with files that may be named, and others beside it that may not."""
    inside = tmp_path / "scene"
    inside.mkdir()
    write(tmp_path, "outside.mtl", "newmtl a\n")
    write(tmp_path, "outside.png", png())
    write(tmp_path, "outside.bin", HEAVY)
    write(inside, "ok.png", png())
    write(inside, "ok.mtl", "newmtl a\n")
    write(inside, "mesh.bin", BODY)
    # What a path that leads out and in again would find.
    write(inside, "outside.png", png())
    return inside


def chunks(*parts: tuple[bytes, bytes]) -> bytes:
    body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in parts)
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def padded(text: str) -> bytes:
    return text.encode() + b" " * (-len(text) % 4)


GLTFS = {
    "uri twice": GLTF.replace('"uri": "mesh.bin"', '"uri": "../outside.bin", "uri": "mesh.bin"'),
    "uri twice, once escaped": GLTF.replace('"uri": "mesh.bin"', '"u\\u0072i": "../outside.bin", "uri": "mesh.bin"'),
    "buffers twice": GLTF[:-1] + ', "buffers": [{"uri": "mesh.bin", "byteLength": 96}]}',
    "images twice": GLTF[:-1] + ', "images": [{"uri": "../outside.png"}], "images": []}',
    "a byte order mark": "\ufeff" + GLTF,
    "something after it": GLTF + "{}",
    "a number that JSON lacks": GLTF[:-1] + ', "extras": NaN}',
    "infinity": GLTF[:-1] + ', "extras": -Infinity}',
    "a comment": "/* */" + GLTF,
    "a version that is a number": GLTF.replace('"2.0"', "2.0"),
    "UTF-16": GLTF.encode("utf-16"),
    "a data URI with escapes": GLTF.replace("mesh.bin", "data:;base64,%41%41"),
}
GLBS = {
    "a first buffer with a name": glb(DOCUMENT, BODY),
    "another second chunk": chunks((b"JSON", padded(GLTF)), (b"XXXX", BODY), (b"BIN\0", BODY)),
}


@pytest.mark.parametrize("content", GLTFS.values(), ids=GLTFS.keys())
def test_gltf_json_that_readers_disagree_on_is_refused(content: str | bytes, folder: Path) -> None:
    assert codes(write(folder, "a.gltf", GLTF), "hull") == []
    assert codes(write(folder, "a.gltf", content), "hull") == ["SC412"]


@pytest.mark.parametrize("content", GLBS.values(), ids=GLBS.keys())
def test_glb_chunks_that_readers_disagree_on_are_refused(content: bytes, folder: Path) -> None:
    assert codes(write(folder, "a.glb", content), "hull") == ["SC412"]


def test_a_zero_byte_in_a_file_name_is_refused(folder: Path) -> None:
    content = GLTF.replace("mesh.bin", "../outside.bin\\u0000/../scene/mesh.bin")
    assert codes(write(folder, "a.gltf", content), "hull")[0] in {"SC412", "SC418", "SC419"}


OBJS = {
    "after a carriage return": ("# a comment\rmtllib ../outside.mtl\n", "SC412"),
    "with a blank behind": ("mtllib ok.mtl \n", "SC418"),
    "two of them": ("mtllib ok.mtl ok.mtl\n", "SC418"),
    "in other letters": (b"mtllib \xe9.mtl\n", "SC419"),
    "with a tab inside": ("mtllib\tok.mtl\tx\n", "SC418"),
    "on two lines": ("mtllib ../out\\\nside.mtl\n", "SC412"),
    "in the middle of its word": ("mtl\\\nlib ../outside.mtl\n", "SC412"),
    "behind its word": ("mtllib\\\n ../outside.mtl\n", "SC412"),
    "with a blank before": (" mtllib ok.mtl\n", "SC412"),
}


@pytest.mark.parametrize(("line", "code"), OBJS.values(), ids=OBJS.keys())
def test_material_files_of_an_obj_are_found_as_in_sapien(line: str | bytes, code: str, folder: Path) -> None:
    assert codes(write(folder, "a.obj", "mtllib ok.mtl\n" + TETRA), "visual") == []
    data = line if isinstance(line, bytes) else line.encode()
    assert codes(write(folder, "a.obj", data + TETRA.encode()), "visual") == [code]


def test_obj_lines_are_continued_as_in_sapien(folder: Path) -> None:
    """Without a blank between, and where the backslash is the last of its line alone."""
    whole = checked(write(folder, "a.obj", TETRA.replace("v 0 0 0.1", "v 0 0 0.\\\n1")), "hull")
    assert whole.names == ()
    assert codes(write(folder, "a.obj", "# C:\\\\path\n" + TETRA), "hull") == []
    assert codes(write(folder, "a.obj", "\ufeff" + TETRA), "hull") == ["SC412"]
    assert codes(write(folder, "a.obj", TETRA.replace("v 0 0 0.1", " v 0 0 0.1")), "hull") == ["SC412"]


MTLS = {
    "a word that goes on": ("map_Kd.x ../outside.png", "SC419"),
    "bumps of another kind": ("bumpy ../outside.png", "SC419"),
    "after a comment with a backslash": ("# a comment \\\nmap_Kd ../outside.png", "SC419"),
    "after a carriage return": ("Kd 1 1 1\rmap_Kd ../outside.png", "SC412"),
    "after too few numbers": ("map_Kd -o 1 1 ok.png ../outside.png", "SC419"),
    "after an option that is none": ("map_Kd -cc on ok.png", "SC412"),
    "no name after options": ("map_Kd -s 1 1 ok.png", "SC412"),
    "with a blank behind": ("map_Kd ok.png ", "SC418"),
}


@pytest.mark.parametrize(("line", "code"), MTLS.values(), ids=MTLS.keys())
def test_images_of_an_mtl_are_found_as_in_sapien(line: str, code: str, folder: Path) -> None:
    path = write(folder, "a.obj", "mtllib a.mtl\n" + TETRA)
    write(folder, "a.mtl", "newmtl a\nmap_Kd -s 1 1 1 -clamp on ok.png\n")
    assert named(path) == {"a.mtl": folder / "a.mtl", "ok.png": folder / "ok.png"}
    write(folder, "a.mtl", f"newmtl a\n{line}\n")
    assert codes(path, "visual") == [code]


@pytest.mark.parametrize("library", ["missing.mtl", "far/away/missing.mtl"])
@pytest.mark.parametrize("instead", ["a.mtl", "missing.mtl", "scene/missi"])
def test_fallbacks_of_a_missing_material_file_are_found(library: str, instead: str, folder: Path) -> None:
    """A mesh that only collides may lack its materials; what is read for them is checked all the same."""
    path = write(folder, "a.obj", f"mtllib {library}\n" + TETRA)
    assert named(path, "hull") == {}
    (folder / "scene").mkdir()
    (folder / instead).unlink(missing_ok=True)
    write(folder, instead, "newmtl a\n")
    is_tried = library == instead or instead != "scene/missi" or "/" not in library
    assert list(named(path, "hull")) == ([instead] if is_tried else [])
    if is_tried:
        assert codes(path, "hull", max_asset_bytes=300) == []
        (folder / instead).write_bytes(bytes(301))
        assert codes(path, "hull", max_asset_bytes=300) == ["SC607"]
        (folder / instead).unlink()
        (folder / instead).symlink_to(folder.parent / "outside.mtl")
        assert codes(path, "hull") == ["SC419"]


def test_a_pipe_that_a_mesh_names_is_never_opened(folder: Path) -> None:
    os.mkfifo(folder / "pipe.mtl")
    for use in ("visual", "hull"):
        assert codes(write(folder, "a.obj", "mtllib pipe.mtl\n" + TETRA), use) == ["SC418"]
    os.mkfifo(folder / "pipe.obj")
    assert codes(folder / "pipe.obj", "hull") == ["SC407"]


@pytest.mark.parametrize("comment", ["TextureFile ../outside.png", "TextureFile ok.png"])
def test_a_ply_that_names_a_texture_cannot_be_a_visual(comment: str, folder: Path) -> None:
    data = ply().replace(b"comment made by hand", f"comment {comment}".encode())
    path = write(folder, "a.ply", data)
    assert codes(path, "visual") == ["SC410"]
    assert codes(path, "hull") == [], "where it is only in the way"


INIT = "<init_from>ok.png</init_from>"
DAES = {
    "a comment inside": "<init_from>../outside.png<!-- x -->/../scene/ok.png</init_from>",
    "a section inside": "<init_from>../outside.png<![CDATA[/../scene/ok.png]]></init_from>",
    "an element inside": "<init_from>../outside.png<x/></init_from>",
    "two of them": f"{INIT}<init_from>../outside.png</init_from>",
    "blanks around": "<init_from> ok.png </init_from>",
    "an escape at the end": "<init_from>ok.pn%67</init_from>",
}


@pytest.mark.parametrize("init", DAES.values(), ids=DAES.keys())
def test_images_of_a_collada_are_found_as_in_sapien(init: str, folder: Path) -> None:
    text = DAE.replace(
        "<library_geometries>", EFFECT.replace("<init_from>a b.png</init_from>", INIT) + "<library_geometries>"
    )
    assert named(write(folder, "a.dae", text)) == {"ok.png": folder / "ok.png"}
    assert codes(write(folder, "a.dae", text.replace(INIT, init)), "visual") == ["SC412"]


def test_a_collada_image_outside_of_the_library_is_refused(folder: Path) -> None:
    text = DAE.replace("<library_geometries>", EFFECT.replace("a b.png", "ok.png") + "<library_geometries>")
    hidden = '<profile_COMMON><image id="i"><init_from>../outside.png</init_from></image>'
    assert codes(write(folder, "a.dae", text.replace("<profile_COMMON>", hidden)), "visual") == ["SC412"]
