"""What a decomposition reads, and what a kept one belongs to."""

from __future__ import annotations

import json
import os
from importlib.metadata import version
from pathlib import Path

import pytest
from plugins.mesh_files import TETRA, checked, gltf_document, write

from scenecc.backends.sapien import assets
from scenecc.backends.sapien.engine import EngineFailure
from scenecc.plan import CoacdParams

pytest.importorskip("coacd")


@pytest.fixture
def stub(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Writes a file in place of CoACD, into an empty cache folder."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def run(content: object, arguments: object, result: Path) -> None:
        result.write_bytes(b"ply")

    monkeypatch.setattr(assets, "_run_coacd", run)


@pytest.mark.usefixtures("stub")
@pytest.mark.parametrize("package", ["coacd", "trimesh"])
def test_another_version_decomposes_again(package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = checked(write(tmp_path, "mesh.obj", TETRA), "decomposed")
    first = assets.decompose(file, CoacdParams())
    assert assets.decompose(file, CoacdParams()) == first
    monkeypatch.setattr(assets, "version", lambda name: "99" if name == package else version(name))
    assert assets.decompose(file, CoacdParams()) != first


@pytest.mark.usefixtures("stub")
def test_a_changed_gltf_buffer_decomposes_again(tmp_path: Path) -> None:
    document, body = gltf_document()
    document["buffers"][0]["uri"] = "mesh.bin"
    path, buffer = tmp_path / "mesh.gltf", tmp_path / "mesh.bin"
    path.write_text(json.dumps(document))
    kept: list[Path] = []
    for content in (body, body + b"\x01", body):
        buffer.write_bytes(content)
        kept.append(assets.decompose(checked(path, "decomposed"), CoacdParams()))
    assert kept[0] == kept[2]
    assert kept[0] != kept[1]


@pytest.mark.parametrize("kind", ["obj", "gltf"])
def test_coacd_opens_only_checked_files(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Materials and images are pipes here, which whoever opens them waits for."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    if kind == "obj":
        os.mkfifo(tmp_path / "mesh.mtl")
        path = write(tmp_path, "mesh.obj", "# mtllib mesh.mtl\n" + TETRA)
        changing = path
    else:
        document, body = gltf_document()
        os.mkfifo(tmp_path / "skin.png")
        document |= {"images": [{"uri": "skin.png"}], "textures": [{"source": 0}]}
        document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        document["meshes"][0]["primitives"][0]["material"] = 0
        document["buffers"][0]["uri"] = "mesh.bin"
        changing = write(tmp_path, "mesh.bin", body)
        (tmp_path / "skin.png").unlink()
        path = write(tmp_path, "mesh.gltf", json.dumps(document))
        file = checked(path, "decomposed")
        os.mkfifo(tmp_path / "skin.png")
        assert [one.uri for one in file.names] == ["mesh.bin"]
        assert assets.decompose(file, CoacdParams()).stat().st_size
    file = checked(path, "decomposed") if kind == "obj" else file
    assert assets.decompose(file, CoacdParams(seed=1)).stat().st_size
    changing.write_bytes(changing.read_bytes() + b"\n")
    with pytest.raises(EngineFailure, match="changed while the scene was built"):
        assets.decompose(file, CoacdParams(seed=2))
