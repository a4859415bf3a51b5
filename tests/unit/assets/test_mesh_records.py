"""Records of meshes: kept by content in memory and in the cache folder, and read again where that is damaged."""

from __future__ import annotations

import io
import json
import random
import subprocess
import sys
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from plugins.mesh_files import FACES, POINTS, TETRA, checked, glb, gltf_document, ply, stl, write

from scenecc.assets import content_cache, meshes
from scenecc.assets.errors import AssetError, AssetReference
from scenecc.assets.meshes import (
    MeshContent,
    MeshRecord,
    checked_content,
    read_hulls,
    read_mesh,
    read_triangles,
)
from scenecc.plan.body import AssetFile
from scenecc.worker_process import Message

LIMIT = 2**26


class CountingReader:
    """The reader of meshes, and what it was asked for."""

    def __init__(self, inner: Any) -> None:
        self._inner = inner
        self.asked: list[str] = []

    def ask(self, header: dict[str, Any], parts: list[bytes]) -> Message:
        self.asked.append(header["wanted"])
        return self._inner.ask(header, parts)


@pytest.fixture(autouse=True)
def reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CountingReader:
    """The reader, with nothing in memory and an empty cache folder."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    meshes._RECORDS.forget()
    counting = CountingReader(meshes._READER)
    monkeypatch.setattr(meshes, "_READER", counting)
    return counting


def content(
    data: str | bytes, suffix: str = ".obj", *, buffers: dict[str, bytes] | None = None, max_bytes: int = LIMIT
) -> MeshContent:
    """A mesh in memory, with its buffers."""
    data = data.encode() if isinstance(data, str) else data

    def open_buffer(reference: AssetReference) -> Any:
        found = (buffers or {})[reference.uri]
        return sha256(found).hexdigest(), lambda: found

    return MeshContent(sha256(data).hexdigest(), suffix, lambda: data, max_bytes, open_buffer)


def everything(mesh: MeshContent) -> tuple[Any, ...]:
    """All that can be asked of a mesh."""
    triangles = [(vertices.tolist(), faces.tolist()) for vertices, faces in read_triangles(mesh)]
    return read_mesh(mesh), triangles, read_hulls(mesh, parts=False), read_hulls(mesh, parts=True)


ALL = ["record", "triangles", "hull", "hulls"]


def test_a_mesh_record_is_cached_in_memory(reader: CountingReader) -> None:
    first = everything(content(TETRA))
    assert isinstance(first[0], MeshRecord)
    assert first[0].whole is not None
    assert (first[0].whole.vertices, first[0].whole.faces, first[0].whole.high) == (4, 4, (0.1, 0.1, 0.1))
    assert first[2][0].hull_volume == pytest.approx(0.001 / 6)
    assert everything(content(TETRA)) == first
    assert sorted(reader.asked) == sorted(ALL)


def test_a_mesh_record_is_cached_on_disk(reader: CountingReader) -> None:
    first = everything(content(stl(), ".stl"))
    meshes._RECORDS.forget()
    assert everything(content(stl(), ".stl")) == first
    assert len(reader.asked) == len(ALL)


def test_a_mesh_record_is_shared_between_processes(tmp_path: Path) -> None:
    path = write(tmp_path, "a.obj", TETRA)
    file = AssetFile("a.obj", path)
    everything(checked_content(file))
    script = (
        "from pathlib import Path\n"
        "from scenecc.assets import meshes\n"
        "from scenecc.plan.body import AssetFile\n"
        "meshes._READER = None\n"
        f"mesh = meshes.checked_content(AssetFile('a.obj', Path({str(path)!r})))\n"
        "meshes.read_triangles(mesh), meshes.read_hulls(mesh, parts=True), meshes.read_hulls(mesh, parts=False)\n"
        "print(meshes.read_mesh(mesh))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == (f"{read_mesh(checked_content(file))}\n", "")


@pytest.mark.parametrize("changed", ["content", "suffix", "library"])
def test_a_mesh_record_is_cached_by_content_and_versions(
    changed: str, reader: CountingReader, monkeypatch: pytest.MonkeyPatch
) -> None:
    read_mesh(content(TETRA))
    match changed:
        case "content":
            read_mesh(content(TETRA + "\n"))
        case "suffix":
            with pytest.raises(AssetError):
                read_mesh(content(TETRA, ".stl"))
        case _:
            monkeypatch.setattr(meshes, "_RECORDS", replace(meshes._RECORDS, version=99))
            read_mesh(content(TETRA))
    assert reader.asked == ["record"] * 2


def gltf(body: bytes) -> tuple[str, dict[str, bytes]]:
    document, _ = gltf_document()
    document["buffers"][0]["uri"] = "mesh.bin"
    return json.dumps(document), {"mesh.bin": body}


def test_a_changed_buffer_gives_another_mesh_record(reader: CountingReader) -> None:
    (text, small), (_, large) = gltf(gltf_document()[1]), gltf(gltf_document(POINTS * 7)[1])
    sizes = []
    for buffers in (small, large, small):
        mesh = content(text, ".gltf", buffers=buffers)
        whole = read_mesh(mesh).whole
        assert whole is not None
        sizes.append(whole.high[0])
        assert read_triangles(mesh)[0][0].max() == whole.high[0]
        assert read_hulls(mesh, parts=False)[0].high == whole.high
    np.testing.assert_allclose(sizes, [0.1, 0.7, 0.1], rtol=1e-6)
    # The names of buffers are asked for once, and each buffer once for each thing.
    assert len(reader.asked) == 1 + 2 * 3


def test_buffers_of_a_cached_mesh_are_looked_up() -> None:
    """One that may not be read is reported, whatever was read of it before."""
    text, buffers = gltf(gltf_document()[1])
    read_mesh(content(text, ".gltf", buffers=buffers))

    def refuse(reference: AssetReference) -> Any:
        raise AssetError("SC419", reference.uri)

    mesh = content(text, ".gltf")
    with pytest.raises(AssetError, match=r"mesh\.bin"):
        read_mesh(MeshContent(mesh.digest, mesh.suffix, mesh.read, LIMIT, refuse))


DAMAGE: dict[str, Any] = {
    "empty": lambda whole: b"",
    "a half": lambda whole: whole[: len(whole) // 2],
    "all but the end": lambda whole: whole[:-1],
    "garbage": lambda whole: random.Random(0).randbytes(len(whole)),
    "zeros": lambda whole: bytes(len(whole)),
    "one byte": lambda whole: whole[:-3] + bytes([whole[-3] ^ 1]) + whole[-2:],
    "more": lambda whole: whole + b"\n",
    "a list": lambda whole: b"[]",
    "an object": lambda whole: b"{}",
    "names that are a number": lambda whole: b'{"names": 3}',
    "a length of gigabytes": lambda whole: b"\xff\xff\xff\x7f" + whole,
    "without its checksum": lambda whole: whole.partition(b"\n")[2],
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
def test_a_damaged_mesh_record_is_read_again(damage: Any, tmp_path: Path, reader: CountingReader) -> None:
    first = everything(content(TETRA))
    kept = {file: file.read_bytes() for file in (tmp_path / "cache").rglob("*") if file.is_file()}
    assert len(kept) == len(ALL)
    for file, whole in kept.items():
        file.write_bytes(damage(whole))
    meshes._RECORDS.forget()
    assert everything(content(TETRA)) == first
    assert sorted(reader.asked) == sorted(ALL * 2)
    assert {file: file.read_bytes() for file in kept} == kept


@pytest.mark.parametrize("instead", ["a folder for each file", "a file", "a device", "a name that is too long"])
def test_an_unusable_cache_folder_of_mesh_records_does_no_harm(
    instead: str, tmp_path: Path, reader: CountingReader, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = everything(content(TETRA))
    match instead:
        case "a folder for each file":
            for file in [file for file in (tmp_path / "cache").rglob("*") if file.is_file()]:
                file.unlink()
                file.mkdir()
        case "a file":
            monkeypatch.setenv("XDG_CACHE_HOME", str(write(tmp_path, "file", "")))
        case "a device":
            monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
        case _:
            monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / ("x" * 300)))
    meshes._RECORDS.forget()
    for _ in range(2):
        assert everything(content(TETRA)) == first
    # What is kept in memory is asked for once more, and triangles each time.
    assert sorted(reader.asked) == sorted([*ALL, *ALL, "triangles"])


def test_meshes_are_read_without_a_home_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(Path, "home", no_home)
    assert read_mesh(content(TETRA)).whole is not None


def test_the_number_of_mesh_records_in_memory_is_limited(
    monkeypatch: pytest.MonkeyPatch, reader: CountingReader
) -> None:
    monkeypatch.setattr(content_cache, "_MOST_KEPT", 3)
    for number in range(5):
        read_mesh(content(f"# {number}\n{TETRA}"))
    assert len(meshes._RECORDS._results) == 3
    read_mesh(content(f"# 0\n{TETRA}"))
    assert len(reader.asked) == 5


def test_unreadable_meshes_are_not_cached(tmp_path: Path, reader: CountingReader) -> None:
    for _ in range(2):
        with pytest.raises(AssetError, match="cannot be read"):
            read_mesh(content(ply()[:-1], ".ply"))
    assert reader.asked == ["record"] * 2
    assert not list((tmp_path / "cache").rglob("*"))


# --- limits -------------------------------------------------------------------------------------------------------


@pytest.fixture
def painted() -> bytes:
    """A GLB with an image of 30 kB once it is unpacked."""
    image = io.BytesIO()
    Image.new("RGB", (100, 100)).save(image, "PNG")
    document, body = gltf_document()
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(body), "byteLength": len(image.getvalue())})
    document["images"] = [{"bufferView": 2, "mimeType": "image/png"}]
    body += image.getvalue()
    document["buffers"][0]["byteLength"] = len(body)
    return glb(document, body)


def test_a_limit_of_images_can_be_raised(painted: bytes) -> None:
    """What the lower one refused is not kept."""
    faults = [read_mesh(content(painted, ".glb", max_bytes=most)).visual_faults for most in (20_000, 20_000, LIMIT)]
    assert [[code for code, _, _ in each] for each in faults] == [["SC607"], ["SC607"], []]
    meshes._RECORDS.forget()
    assert read_mesh(content(painted, ".glb")).visual_faults == ()


def test_a_lower_limit_of_images_is_respected(painted: bytes) -> None:
    faults = [read_mesh(content(painted, ".glb", max_bytes=most)).visual_faults for most in (LIMIT, 20_000, LIMIT)]
    assert [[code for code, _, _ in each] for each in faults] == [[], ["SC607"], []]


def test_a_limit_of_triangles_can_be_raised_and_lowered() -> None:
    for _ in range(2):
        for read in (read_mesh, read_triangles, lambda mesh: read_hulls(mesh, parts=False)):
            with pytest.raises(AssetError, match="more than 30 bytes"):
                read(content(TETRA, max_bytes=10))
        assert len(read_triangles(content(TETRA))) == 1
        assert len(read_hulls(content(TETRA), parts=False)) == 1


# --- files of a plan ------------------------------------------------------------------------------------------------


def test_a_checked_file_is_read_again_whatever_the_limit_was(tmp_path: Path) -> None:
    """It was checked with that of the scene, which a build does not have."""
    file = checked(write(tmp_path, "a.ply", ply()), "hull")
    assert checked_content(file).max_bytes > 2**40
    assert read_hulls(checked_content(file), parts=False)[0].vertices == 4


def test_a_checked_mesh_that_changed_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "a.ply", ply())
    file = checked(path, "hull")
    write(tmp_path, "a.ply", ply(POINTS * 2))
    for _ in range(2):
        with pytest.raises(AssetError, match="changed while the scene was built") as caught:
            read_triangles(checked_content(file))
        assert caught.value.code == "SC422"
    path.unlink()
    with pytest.raises(AssetError, match="changed while the scene was built"):
        read_triangles(checked_content(file))


def test_a_checked_mesh_whose_buffer_changed_is_refused(tmp_path: Path) -> None:
    document, body = gltf_document()
    document["buffers"][0]["uri"] = "mesh.bin"
    write(tmp_path, "mesh.bin", body)
    file = checked(write(tmp_path, "a.gltf", json.dumps(document)), "hull")
    assert len(read_triangles(checked_content(file))) == 1
    write(tmp_path, "mesh.bin", gltf_document(POINTS * 2, FACES)[1])
    with pytest.raises(AssetError, match=r"mesh\.bin' changed"):
        read_hulls(checked_content(file), parts=False)


def test_a_buffer_that_was_not_checked_is_refused(tmp_path: Path) -> None:
    document, body = gltf_document()
    document["buffers"][0]["uri"] = "mesh.bin"
    write(tmp_path, "mesh.bin", body)
    with pytest.raises(AssetError, match=r"`mesh\.bin`, which was not checked"):
        read_mesh(checked_content(AssetFile("a.gltf", write(tmp_path, "a.gltf", json.dumps(document)))))
