"""Truncated files: trimesh reads the first triangles of some, and each is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from plugins.mesh_files import POINTS, TETRA, codes, diagnose, ply, stl, stl_text, write

TEXT_PLY = ply(kind="ascii")
LINES = len(TEXT_PLY.splitlines(keepends=True))


def refusal(folder: Path, name: str, data: bytes) -> str:
    """Why a file is refused."""
    (one,) = diagnose(write(folder, name, data), "triangles")
    assert one.code == "SC412"
    return one.message.removeprefix(f"{name}: the mesh cannot be read: ")


@pytest.mark.parametrize("faces", range(4))
def test_a_text_ply_without_its_last_faces_is_refused(faces: int, tmp_path: Path) -> None:
    data = b"".join(TEXT_PLY.splitlines(keepends=True)[: LINES - 4 + faces])
    assert refusal(tmp_path, "a.ply", data) == f"its header declares 4 faces, but it has {faces}"
    windows = data.replace(b"\n", b"\r\n")
    assert refusal(tmp_path, "a.ply", windows) == f"its header declares 4 faces, but it has {faces}"


@pytest.mark.parametrize("lines", range(LINES - 4))
def test_a_text_ply_that_ends_before_its_faces_is_refused(lines: int, tmp_path: Path) -> None:
    assert refusal(tmp_path, "a.ply", b"".join(TEXT_PLY.splitlines(keepends=True)[:lines]))


@pytest.mark.parametrize("cut", [2, 3, 4, 5, 7])
def test_a_text_ply_that_ends_within_a_line_is_refused(cut: int, tmp_path: Path) -> None:
    assert refusal(tmp_path, "a.ply", TEXT_PLY[:-cut])


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_a_ply_that_declares_more_faces_is_refused(kind: str, tmp_path: Path) -> None:
    assert refusal(tmp_path, "a.ply", ply(kind=kind).replace(b"element face 4", b"element face 5"))


@pytest.mark.parametrize("cut", [1, 12, 13, 26, 60])
@pytest.mark.parametrize("kind", ["binary_little_endian", "binary_big_endian"])
def test_a_truncated_binary_ply_is_refused(kind: str, cut: int, tmp_path: Path) -> None:
    assert refusal(tmp_path, "a.ply", ply(kind=kind)[:-cut])


def test_a_text_ply_without_its_last_line_break_is_accepted(tmp_path: Path) -> None:
    assert codes(write(tmp_path, "a.ply", TEXT_PLY[:-1]), "hull") == []


def test_ply_faces_with_more_corners_are_accepted(tmp_path: Path) -> None:
    square = TEXT_PLY.replace(b"element face 4", b"element face 3").replace(b"3 0 2 1\n3 0 1 3\n", b"4 0 2 1 3\n")
    assert codes(write(tmp_path, "a.ply", square), "hull") == []


WRONG = "its length does not match the number of triangles in its header"
BINARY = {
    "without its last byte": stl()[:-1],
    "without its last triangle": stl()[:-50],
    "with one byte more": stl() + b"\0",
    "with one triangle more": stl() + stl()[-50:],
    "with a lower number": stl()[:80] + b"\3" + stl()[81:],
    "with a higher number": stl()[:80] + b"\5" + stl()[81:],
    "with a number of gigabytes": stl()[:80] + b"\xff\xff\xff\xff" + stl()[84:],
    "without a triangle": stl()[:84],
    "without its number": stl()[:83],
    "without a whole header": stl()[:40],
    "an OBJ": TETRA.encode(),
}


@pytest.mark.parametrize("data", BINARY.values(), ids=BINARY.keys())
def test_a_binary_stl_of_wrong_length_is_refused(data: bytes, tmp_path: Path) -> None:
    assert refusal(tmp_path, "a.stl", data) == WRONG


def test_a_binary_stl_whose_header_looks_like_text_is_accepted(tmp_path: Path) -> None:
    data = b"solid a" + stl()[7:]
    assert codes(write(tmp_path, "a.stl", data), "hull") == []
    (one,) = diagnose(write(tmp_path, "a.stl", data[:-1]), "hull")
    assert one.code in {"SC412", "SC413"}


TEXT_STL = stl_text()
FACETS = [end for end in range(len(TEXT_STL)) if TEXT_STL[:end].endswith(b"endfacet\n")]


@pytest.mark.parametrize("end", [*FACETS, *(end - 30 for end in FACETS)])
@pytest.mark.parametrize("first", [b"", stl_text(POINTS + 1)], ids=["one solid", "the second solid"])
def test_a_text_stl_without_its_end_is_refused(first: bytes, end: int, tmp_path: Path) -> None:
    """Of several solids, trimesh keeps those that are whole."""
    assert codes(write(tmp_path, "a.stl", first + TEXT_STL), "hull") == []
    faces = 4 if first else 0
    assert f"only {faces} whole triangles" in refusal(tmp_path, "a.stl", first + TEXT_STL[:end])


def test_a_text_stl_with_a_word_instead_of_a_number_is_refused(tmp_path: Path) -> None:
    """NumPy refuses it, or does not read what follows the word."""
    at = TEXT_STL.index(b"vertex", FACETS[1])
    damaged = TEXT_STL[:at] + TEXT_STL[at:].replace(b"vertex 0", b"vertex x", 1)
    assert refusal(tmp_path, "a.stl", damaged)


@pytest.mark.parametrize("data", [bytes(84), b"solid\nendsolid\n"], ids=["binary", "text"])
def test_an_stl_without_triangles_is_reported_as_empty(data: bytes, tmp_path: Path) -> None:
    assert codes(write(tmp_path, "a.stl", data), "hull") == ["SC413"]
