"""The assets that ship: made by their script to the byte, and what they are said to be."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[3]
SCRIPT = ROOT / "assets" / "make_assets.py"
ASSETS = ROOT / "scenes" / "assets"


@pytest.fixture(scope="module")
def script() -> Any:
    pytest.importorskip("trimesh")
    spec = importlib.util.spec_from_file_location("make_assets", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # A dataclass looks its module up by name.
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_script_makes_the_committed_meshes(script: Any, tmp_path: Path) -> None:
    script.main(tmp_path)
    made = [path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file()]
    assert [path for path in made if (tmp_path / path).read_bytes() != (ROOT / path).read_bytes()] == []
    assert {path for path in made if path.parts[0] == "scenes"} == {p.relative_to(ROOT) for p in ASSETS.iterdir()}
    assert all((ROOT / path).stat().st_size < 100_000 for path in made)


def test_the_bowl_is_closed_and_hollow(script: Any) -> None:
    trimesh = pytest.importorskip("trimesh")
    bowl = script.bowl()
    solid = trimesh.Trimesh(bowl.vertices, bowl.faces)
    assert solid.is_watertight
    hull = np.pi * 0.08**2 * 0.06 * 2 / 3
    assert 0.05 * hull < solid.volume < 0.3 * hull
    assert solid.vertices[:, 2].min() == 0


def test_sapien_cooks_the_shipped_meshes_as_named() -> None:
    physx = pytest.importorskip("sapien.physx")
    material = physx.PhysxMaterial(0.3, 0.3, 0.1)
    for name in ("bowl.obj", "bowl.glb", "gem.stl"):
        shape = physx.PhysxCollisionShapeConvexMesh(str(ASSETS / name), [1, 1, 1], material)
        assert len(shape.vertices) > 20
    dish = physx.PhysxCollisionShapeTriangleMesh(str(ASSETS / "bowl.obj"), [1, 1, 1], material)
    assert np.allclose(dish.vertices.max(axis=0), [0.08, 0.08, 0.06], atol=1e-6)
    parts = physx.PhysxCollisionShapeConvexMesh.load_multiple(str(ASSETS / "mug.obj"), [1, 1, 1], material)
    assert [len(part.vertices) for part in parts] == [24, *[8] * 15]
