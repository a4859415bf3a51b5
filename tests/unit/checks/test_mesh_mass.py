"""The mass of small meshes is checked before the engine reads them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import trimesh

import scenecc


def codes(folder: Path, shape: dict[str, Any], **keys: Any) -> list[str]:
    trimesh.creation.box((0.1, 0.1, 0.1)).export(folder / "m.obj")  # 1 kg
    document = {"scenecc": 1, "entities": {"m": {"shapes": [{"file": str(folder / "m.obj"), **shape}], **keys}}}
    return [d.code for d in scenecc.validate(document, allow_outside_assets=True) if d.severity != "note"]


@pytest.mark.parametrize(
    ("kind", "scale", "expected"),
    [
        ("convex_parts", 0.011, []),
        ("convex_parts", 0.009, ["SC511"]),
        ("convex_mesh", [0.1, 0.02, 0.001], []),
        ("convex_mesh", [0.1, 0.009, 0.001], ["SC511"]),
        ("convex_parts", {"choice": [0.005, 1]}, ["SC511"]),
    ],
)
def test_a_mesh_of_less_than_a_milligram(tmp_path: Path, kind: str, scale: Any, expected: list[str]) -> None:
    assert codes(tmp_path, {"type": kind, "scale": scale}) == expected


def test_other_shapes_and_an_inertial_give_a_mass(tmp_path: Path) -> None:
    small = {"type": "convex_parts", "scale": 0.005}
    assert codes(tmp_path, small, collisions=[{"type": "sphere", "radius": 0.01}]) == []
    assert codes(tmp_path, small, inertial={"mass": 1e-7, "inertia": [1e-12, 1e-12, 1e-12]}) == []
    assert codes(tmp_path, small, body_type="static") == []
