"""Large files: read in little time and memory, and to the same mesh as line by line."""

from __future__ import annotations

import resource
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from plugins.mesh_files import codes, write
from plugins.nightly import assert_took

from scenecc.checks.mesh_data import AssetBudget, AssetError, AssetReference, MeshData, MeshReadContext, MeshTextReader
from scenecc.checks.meshes import read_mesh

MIB = 2**20


def no_file(reference: AssetReference) -> bytes:
    raise AssertionError(reference)


def read(data: bytes, suffix: str, max_bytes: int = 256 * MIB) -> MeshData:
    return read_mesh(data, suffix, MeshReadContext(no_file, max_bytes, AssetBudget(2**40)))


def table(rows: int, columns: int, seed: int) -> list[list[float]]:
    return np.random.default_rng(seed).normal(size=(rows, columns)).tolist()


def corners(rows: int, of: int) -> list[list[int]]:
    return np.random.default_rng(7).integers(0, of, (rows, 3)).tolist()


def made(kind: str, rows: int) -> bytes:
    """A file of `rows` vertices and twice as many triangles."""
    points, faces = table(rows, 3, 1), corners(2 * rows, rows)
    header = "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
    header += "property uchar red\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n"
    match kind:
        case "obj":
            text = [" ".join(["v", *map(repr, point)]) for point in points]
            text += [" ".join(["f", *(f"{c + 1}/1/{c + 1}" for c in face)]) for face in faces]
        case "text.ply":
            text = header.format("ascii", rows, 2 * rows).splitlines()
            text += [" ".join([*map(repr, point), "7"]) for point in points]
            text += [" ".join(["3", *map(str, face)]) for face in faces]
        case "stl":
            text = ["solid x"]
            for three in table(rows, 9, 2):
                text += ["facet normal 0 0 1", "outer loop"]
                text += [" ".join(["vertex", *map(repr, three[i : i + 3])]) for i in (0, 3, 6)] + ["endloop"]
                text += ["endfacet"]
            text += ["endsolid x"]
        case _:
            vertices = np.zeros(rows, [("p", "<f4", 3), ("c", "u1")])
            vertices["p"], vertices["p"][0] = points, 1
            triangles = np.zeros(2 * rows, [("n", "u1"), ("i", "<i4", 3)])
            triangles["n"], triangles["i"] = 3, faces
            head = header.format("binary_little_endian", rows, 2 * rows).encode()
            return head + vertices.tobytes() + triangles.tobytes()
    return "\n".join([*text, ""]).encode()


KINDS = {"obj": ".obj", "text.ply": ".ply", "stl": ".stl", "binary.ply": ".ply"}


@pytest.mark.parametrize("kind", ["obj", "text.ply", "stl"])
def test_the_quick_path_reads_what_the_slow_one_does(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    data = made(kind, 9000)
    quick = read(data, KINDS[kind])
    monkeypatch.setattr(MeshTextReader, "run", lambda *_: b"")
    slow = read(data, KINDS[kind])
    assert len(quick.parts) == len(slow.parts) == 1
    assert np.array_equal(quick.parts[0].vertices, slow.parts[0].vertices)
    assert np.array_equal(quick.parts[0].faces, slow.parts[0].faces)


def test_mixed_faces_of_a_binary_ply_are_fans() -> None:
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
    head += (
        b"property float z\nelement face 3\nproperty list uchar int vertex_indices\nproperty uchar red\nend_header\n"
    )
    points = np.arange(1, 16, dtype="<f4").tobytes()
    faces = [[0, 1, 2], [0, 1, 2, 3], [4, 3, 2, 1, 0]]
    body = b"".join(bytes([len(face)]) + np.array(face, "<i4").tobytes() + b"\7" for face in faces)
    (part,) = read(head + points + body, ".ply").parts
    assert part.faces.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3], [4, 3, 2], [4, 2, 1], [4, 1, 0]]


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_takes_a_few_times_its_size(kind: str) -> None:
    data = made(kind, 20_000)
    tracemalloc.start()
    read(data, KINDS[kind], len(data))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 9 * len(data)


@pytest.mark.parametrize(
    "data",
    [
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf " + b"1 " * 100_000 + b"\n",
        b"".join(b"o %d\n" % i for i in range(50_000)),
        b"f 1 1 1\n" * 10_000 + b"f" + b" 1" * 200_000,
    ],
    ids=["a polygon", "groups", "both"],
)
def test_what_unpacks_to_far_more_is_refused(data: bytes) -> None:
    with pytest.raises(AssetError) as caught:
        read(data, ".obj", len(data))
    assert caught.value.code == "SC607"


@pytest.mark.parametrize("word", [b"1" * 200_000 + b"x", b"1." + b"1" * 200_000 + b"x", b"-" * 200_000])
def test_a_long_number_takes_no_long_time(tmp_path: Path, word: bytes) -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    for name in ("a.obj", "b.obj"):
        line = b"v 0 0 " + word if name == "a.obj" else b"f 1 1 " + word
        assert codes(write(tmp_path, name, b"v 0 0 0\n" + line + b"\n"), "hull") == ["SC412"]
    assert_took(resource.getrusage(resource.RUSAGE_SELF).ru_utime - before, most=1)
