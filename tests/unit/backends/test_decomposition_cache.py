"""What a kept decomposition belongs to."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from plugins.mesh_files import glb, gltf_document

from scenecc.backends.sapien import decomposition
from scenecc.plan import CoacdParams

pytest.importorskip("coacd")


def test_a_mesh_in_a_buffer_beside_the_gltf_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def run(mesh: Path, arguments: object, result: Path) -> None:
        result.write_bytes(b"ply")

    monkeypatch.setattr(decomposition, "_run", run)
    document, body = gltf_document()
    document["buffers"][0]["uri"] = "mesh.bin"
    path, buffer = tmp_path / "mesh.gltf", tmp_path / "mesh.bin"
    path.write_text(json.dumps(document))
    kept: list[Path] = []
    for content in (body, body[:-1] + b"\x01", body):
        buffer.write_bytes(content)
        kept.append(decomposition.decompose(path, CoacdParams()))
    assert kept[0] == kept[2]
    assert kept[0] != kept[1]
    buffer.unlink()
    assert decomposition.decompose(path, CoacdParams()) not in kept


def test_a_binary_gltf_names_files_too(tmp_path: Path) -> None:
    from scenecc.backends.sapien.assets_on_disk import named_by

    path = tmp_path / "mesh.glb"
    path.write_bytes(glb())
    assert named_by(path) == []
    text = json.dumps({"buffers": [{"uri": "mesh.bin"}]}).encode()
    text += b" " * (-len(text) % 4)
    chunk = len(text).to_bytes(4, "little") + b"JSON" + text
    path.write_bytes(b"glTF" + (2).to_bytes(4, "little") + (12 + len(chunk)).to_bytes(4, "little") + chunk)
    assert named_by(path) == [tmp_path / "mesh.bin"]
