"""Names and hashes of the files of a scene do not depend on the machine, and tell of a change."""

from __future__ import annotations

import shutil
from hashlib import sha256
from pathlib import Path

import pytest

from scenecc.diagnostics import Sink
from scenecc.files import ChangedError
from scenecc.options import Options
from scenecc.pipeline import compile_source
from scenecc.source.provenance import hash_document, hash_files

SCENE = """scenecc: 1
include: [parts/base.yaml]
entities:
  cup: {use: scenecc:cube}
  mug: {body_type: static, visuals: [{type: mesh, file: asset://mug.obj}]}
"""
BASE = """scenecc: 1
entities:
  bowl: {body_type: static, visuals: [{type: mesh, file: ../../shared/bowl.obj}]}
"""


def _hashes(folder: Path, *, scenes: Path) -> dict[str, str]:
    for file, text in {"home/scene.yaml": SCENE, "home/parts/base.yaml": BASE}.items():
        path = folder / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    for name, where in {"bowl": "shared", "mug": "assets"}.items():
        (folder / where).mkdir(exist_ok=True)
        shutil.copy(scenes / f"assets/{name}.obj", folder / where)
    shutil.copy(scenes / "assets/bowl.mtl", folder / "shared")
    shutil.copy(scenes / "assets/checker.png", folder / "shared")
    options = Options.of(asset_roots=[folder / "assets"], allow_outside_assets=True)
    sink = Sink()
    result = compile_source(folder / "home/scene.yaml", options, sink)
    assert result is not None, sink.diagnostics()
    assert result.document is not None
    assert hash_document(result.document) == sha256(SCENE.encode()).hexdigest()
    found = hash_files(result.scope)
    (folder / "assets/mug.obj").touch()
    with pytest.raises(ChangedError):
        hash_files(result.scope)
    return found


def test_names_and_hashes_of_files_do_not_depend_on_the_folder(tmp_path: Path) -> None:
    """Those of packages, of the scene, of asset roots and outside; a later change is noticed."""
    scenes = Path(__file__).parents[3] / "scenes"
    first = _hashes(tmp_path / "a", scenes=scenes)
    assert list(first) == [
        "../shared/bowl.mtl",
        "../shared/bowl.obj",
        "../shared/checker.png",
        "asset://mug.obj",
        "parts/base.yaml",
        "pkg://scenecc/prefabs/cube.yaml",
    ]
    assert first["asset://mug.obj"] == sha256((scenes / "assets/mug.obj").read_bytes()).hexdigest()
    assert _hashes(tmp_path / "b/c", scenes=scenes) == first


def test_the_hash_of_a_dict_is_that_of_its_content() -> None:
    """Whatever the order of its keys."""
    a, b = ({"num_scenes": 2, "seed": 1}, {"seed": 1, "num_scenes": 2})
    found = [compile_source({"scenecc": 1, **each}, Options(), Sink()) for each in (a, b)]
    hashes = {hash_document(one.document) for one in found if one is not None and one.document is not None}
    assert len(hashes) == 1
