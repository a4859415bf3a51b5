"""SAPIEN reads a stranger's mesh in a process of its own first: what it refuses, and what would end this process."""

from __future__ import annotations

import json
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from plugins.mesh_files import POINTS, TETRA, checked, glb, gltf_document, plan_of, ply, write
from unit.assets.test_mesh_dae import DAE

from scenecc import SceneError, compile_scene, load_scene, pack_scene, validate
from scenecc.assets import engine, meshes
from scenecc.assets.content_cache import ContentCache
from scenecc.assets.engine import engine_fault
from scenecc.backends.sapien import instantiate
from scenecc.backends.sapien.assets import collision_file
from scenecc.backends.sapien.mesh_reading import report_unreadable_meshes
from scenecc.diagnostics import Sink
from scenecc.plan.body import AssetFile
from scenecc.worker import Worker
from scenecc.worker_process import Message

REFUSED = TETRA + "p 9\n"
"""A missing point, which only SAPIEN's reader minds."""

CRASH = "SAPIEN's reader ended: the file needs too much memory, or crashes the library"


def deep() -> bytes:
    """A good mesh beside 60 000 nodes inside one another, at which SAPIEN's reader overflows its stack."""
    document, body = gltf_document()
    chain: list[dict[str, Any]] = [{"children": [number + 2]} for number in range(60_000)]
    document["nodes"] = [{"mesh": 0}, *chain, {}]
    document["scenes"] = [{"nodes": [0, 1]}]
    return glb(document, body)


class CountingReader:
    """SAPIEN's reader, and what it was asked for."""

    def __init__(self, inner: Worker) -> None:
        self._inner = inner
        self.asked: list[tuple[str, str]] = []

    def ask(self, header: dict[str, Any], parts: list[bytes]) -> Message:
        self.asked.append((Path(header["path"]).name, header["use"]))
        return self._inner.ask(header, parts)


@pytest.fixture(autouse=True)
def reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CountingReader:
    """The reader, with nothing in memory and an empty cache folder."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    engine._READ.forget()
    counting = CountingReader(engine._READER)
    monkeypatch.setattr(engine, "_READER", counting)
    return counting


SCENE = """\
scenecc: 1
entities:
  a:
    body_type: static
    collisions:
      - type: {}
        file: {}
"""


def refused(scene: Path) -> list[tuple[str, int | None, int | None, str]]:
    """Codes, places and messages of a build of a scene that is valid."""
    assert not [one for one in validate(scene) if one.severity == "error"]
    with pytest.raises(SceneError) as caught:
        load_scene(scene, render=False)
    return [
        (one.code, one.line, one.column, one.message) for one in caught.value.diagnostics if one.severity == "error"
    ]


@pytest.mark.parametrize("kind", ["convex_mesh", "convex_parts", "triangle_mesh"])
def test_a_mesh_that_sapien_refuses_is_reported(kind: str, tmp_path: Path) -> None:
    path = write(tmp_path, "a.obj", REFUSED)
    ((code, line, column, message),) = refused(write(tmp_path, "scene.yaml", SCENE.format(kind, "a.obj")))
    assert (code, line, column) == ("SC801", 7, 15)
    assert message.startswith(f"SAPIEN cannot read '{path}': ")


def test_a_mesh_that_crashes_sapien_is_reported(tmp_path: Path) -> None:
    path = write(tmp_path, "deep.glb", deep())
    scene = write(tmp_path, "scene.yaml", SCENE.format("convex_mesh", "deep.glb"))
    assert refused(scene) == [("SC801", 7, 15, f"SAPIEN cannot read '{path}': {CRASH}")]
    write(tmp_path, "deep.glb", glb())
    load_scene(scene, render=False).close()  # by a process that is started again


@pytest.mark.parametrize(
    ("use", "code"), [("hull", "SC801"), ("parts", "SC801"), ("triangles", "SC801"), ("visual", "SC807")]
)
def test_a_mesh_that_crashes_sapien_has_a_code_by_use(use: str, code: str, tmp_path: Path) -> None:
    """A visual mesh is read only for a build that renders."""
    path = write(tmp_path, "deep.glb", deep())
    plan = plan_of([path], use)
    sink = Sink()
    assert report_unreadable_meshes(plan, (0,), sink, rendered=True)
    assert [(one.code, one.path) for one in sink.diagnostics()] == [(code, "bodies[0].file")]
    assert CRASH in sink.diagnostics()[0].message
    assert report_unreadable_meshes(plan, (0,), Sink(), rendered=False) == (use != "visual")


LINE = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"
"""A triangle without an area."""


@pytest.mark.parametrize(
    ("content", "codes"), [(TETRA, []), (REFUSED, ["SC807"]), (LINE, [])], ids=["good", "refused", "line"]
)
def test_a_visual_mesh_that_sapien_refuses_is_reported(content: str, codes: list[str], tmp_path: Path) -> None:
    """One that PhysX only cannot cook is shown."""
    sink = Sink()
    plan = plan_of([write(tmp_path, "a.obj", content)], "visual")
    assert report_unreadable_meshes(plan, (0,), sink, rendered=True) == bool(codes)
    assert [one.code for one in sink.diagnostics()] == codes


@pytest.mark.render
@pytest.mark.parametrize(
    ("name", "content"), [("a.glb", deep()), ("a.obj", REFUSED.encode())], ids=["crash", "refusal"]
)
def test_a_build_that_renders_ends_at_a_visual_mesh(name: str, content: bytes, tmp_path: Path) -> None:
    """Else SAPIEN would load it at the first picture."""
    write(tmp_path, name, content)
    scene = write(tmp_path, "scene.yaml", SCENE.format("mesh", name).replace("collisions", "visuals"))
    assert not validate(scene)
    with pytest.raises(SceneError) as caught:
        load_scene(scene, render=True)
    assert [(one.code, one.line, one.column) for one in caught.value.diagnostics] == [("SC807", 7, 15)]
    load_scene(scene, render=False).close()


def test_each_mesh_is_test_read_once_per_use(tmp_path: Path, reader: CountingReader) -> None:
    paths = [write(tmp_path, name, data) for name, data in (("a.obj", TETRA), ("b.obj", TETRA + "\n"))]
    uses = ("hull", "hull", "parts", "decomposed", "triangles", "visual", "visual")
    for _ in range(2):
        assert not report_unreadable_meshes(plan_of(paths, *uses), (0,), Sink(), rendered=True)
    assert reader.asked == [("a.obj", use) for use in ("hull", "parts", "triangles", "visual")]


def test_a_collision_collada_is_not_test_read(tmp_path: Path, reader: CountingReader) -> None:
    """SAPIEN gets a PLY of ours."""
    path = write(tmp_path, "a.dae", "")
    assert not report_unreadable_meshes(plan_of([path], "hull"), (0,), Sink(), rendered=True)
    assert reader.asked == []
    report_unreadable_meshes(plan_of([path], "visual"), (0,), Sink(), rendered=True)
    assert reader.asked == [("a.dae", "visual")]


def test_a_collada_is_converted_again_after_a_change_of_the_reader(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = AssetFile("a.dae", write(tmp_path, "a.dae", DAE))
    first = collision_file(file)
    assert collision_file(file) == first
    monkeypatch.setattr(meshes, "_RECORDS", replace(meshes._RECORDS, version=99))
    again = collision_file(file)
    assert again != first
    assert again.read_bytes() == first.read_bytes()


@pytest.mark.parametrize("uri", ["pkg://acme/a.obj", "asset://a.obj"])
def test_files_of_packages_and_asset_roots_are_trusted(uri: str, tmp_path: Path, reader: CountingReader) -> None:
    path = write(tmp_path, "a.obj", REFUSED)
    assert engine_fault(AssetFile(uri, path), "hull") is None
    assert reader.asked == []
    assert engine_fault(AssetFile("a.obj", path), "hull") is not None
    assert reader.asked == [("a.obj", "hull")]


def test_a_scene_of_an_asset_root_is_built_without_the_reader(tmp_path: Path, reader: CountingReader) -> None:
    (tmp_path / "root").mkdir()
    write(tmp_path / "root", "a.obj", TETRA)
    scene = write(tmp_path, "scene.yaml", SCENE.format("convex_mesh", "asset://a.obj"))
    load_scene(scene, render=False, asset_roots=[tmp_path / "root"]).close()
    assert reader.asked == []


@pytest.mark.parametrize("uri", ["pkg://acme/a.obj", "asset://a.obj", "a.obj"])
def test_nothing_in_a_pack_is_trusted(
    uri: str, tmp_path: Path, reader: CountingReader, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It brings packages and asset roots of its own."""
    for folder in ("scene", "acme"):
        (tmp_path / folder).mkdir()
        write(tmp_path / folder, "a.obj", REFUSED)
    write(tmp_path / "acme", "__init__.py", "")
    monkeypatch.syspath_prepend(tmp_path)
    scene = write(tmp_path / "scene", "scene.yaml", SCENE.format("convex_mesh", uri))
    pack = tmp_path / "a.scn"
    pack_scene(scene, pack, asset_roots=[tmp_path / "acme"])
    with pytest.raises(SceneError, match="SAPIEN cannot read"):
        load_scene(pack, render=False)
    assert reader.asked == [("a.obj", "hull")]


# --- what is kept -------------------------------------------------------------------------------------------------


def forget() -> None:
    engine._READ.forget()


def test_readable_meshes_are_cached_in_memory_and_on_disk(tmp_path: Path, reader: CountingReader) -> None:
    first, second = (AssetFile(name, write(tmp_path, name, TETRA)) for name in ("a.obj", "b.obj"))
    for file in (first, second, first):
        assert engine_fault(file, "hull") is None
    forget()
    assert engine_fault(second, "hull") is None
    assert reader.asked == [("a.obj", "hull")]


def test_unreadable_meshes_are_read_again(tmp_path: Path, reader: CountingReader) -> None:
    """It may have been too slow on a busy machine."""
    file = AssetFile("a.obj", write(tmp_path, "a.obj", REFUSED))
    faults = [engine_fault(file, "hull") for _ in range(2)]
    assert faults[0] == faults[1] is not None
    assert len(reader.asked) == 2
    assert not list((tmp_path / "cache").rglob("*"))


@pytest.mark.parametrize("changed", ["content", "use", "suffix", "buffer", "version"])
def test_results_for_untrusted_meshes_are_cached_by_content_use_and_version(
    changed: str, tmp_path: Path, reader: CountingReader, monkeypatch: pytest.MonkeyPatch
) -> None:
    document, body = gltf_document()
    document["buffers"][0]["uri"] = "a.bin"
    write(tmp_path, "a.bin", body)
    path = write(tmp_path, "a.gltf", json.dumps(document))
    file, use = checked(path, "hull"), "hull"
    assert engine_fault(file, use) is None
    match changed:
        case "content":
            write(tmp_path, "a.gltf", json.dumps(document) + "\n")
            file = checked(path, "hull")
        case "use":
            use = "triangles"
        case "suffix":
            file = replace(file, path=write(tmp_path, "a.glb", path.read_bytes()))
        case "buffer":
            write(tmp_path, "a.bin", gltf_document(POINTS * 2)[1])
            file = checked(path, "hull")
        case _:
            monkeypatch.setattr(engine, "_READ", ContentCache("engine", 2, ("sapien",)))
    engine_fault(file, use)
    assert len(reader.asked) == 2


def test_a_mesh_that_changed_while_read_is_not_cached(tmp_path: Path) -> None:
    """Else a mesh that SAPIEN crashes at would count as read, once it is put back."""
    path = write(tmp_path, "a.obj", REFUSED)
    file = checked(path, "hull")
    write(tmp_path, "a.obj", TETRA)
    assert engine_fault(file, "hull") is None
    write(tmp_path, "a.obj", REFUSED)
    assert engine_fault(checked(path, "hull"), "hull") is not None


def test_a_mesh_that_changed_after_the_test_read_is_reported(tmp_path: Path) -> None:
    write(tmp_path, "a.obj", REFUSED)
    plan = compile_scene(write(tmp_path, "scene.yaml", SCENE.format("convex_mesh", "a.obj")))
    write(tmp_path, "a.obj", TETRA)
    sink = Sink()
    assert instantiate(plan, sink, render=False) is None
    assert [one.code for one in sink.diagnostics()] == ["SC422"]


@pytest.mark.parametrize("damage", [b"", b"garbage", b"[]", sha256(b"x").hexdigest().encode() + b"\n"])
def test_a_damaged_cache_file_is_ignored(damage: bytes, tmp_path: Path, reader: CountingReader) -> None:
    file = AssetFile("a.obj", write(tmp_path, "a.obj", TETRA))
    assert engine_fault(file, "hull") is None
    (kept,) = [one for one in (tmp_path / "cache").rglob("*") if one.is_file()]
    whole = kept.read_bytes()
    kept.write_bytes(damage)
    forget()
    assert engine_fault(file, "hull") is None
    assert len(reader.asked) == 2
    assert kept.read_bytes() == whole


@pytest.mark.parametrize("instead", ["/dev/null", "/proc/nothing", "/" + "x" * 300, "a file", "a folder"])
def test_an_unusable_cache_folder_does_no_harm(
    instead: str, tmp_path: Path, reader: CountingReader, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = AssetFile("a.obj", write(tmp_path, "a.obj", TETRA))
    if instead == "a folder":  # where the result would lie
        assert engine_fault(file, "hull") is None
        (kept,) = [one for one in (tmp_path / "cache").rglob("*") if one.is_file()]
        kept.unlink()
        kept.mkdir()
        forget()
        reader.asked.clear()
    else:
        monkeypatch.setenv("XDG_CACHE_HOME", instead if instead[0] == "/" else str(write(tmp_path, "file", "")))
    assert [engine_fault(file, "hull") for _ in range(2)] == [None, None]
    assert len(reader.asked) == 1


def test_a_mesh_without_read_permission_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> bytes:
        raise PermissionError(13, "Permission denied", "a.ply")

    monkeypatch.setattr(meshes, "read_checked", refuse)
    assert engine_fault(AssetFile("a.ply", write(tmp_path, "a.ply", ply())), "hull") is not None
