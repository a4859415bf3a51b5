"""USD stages, written here as text and read as scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from scenecc.diagnostics import Sink
from scenecc.importers.imported_scene import ImportContext, ImportedScene
from scenecc.importers.usd_scene import read_stage
from scenecc.options import Options
from scenecc.source.paths import AssetScope

BODY = 'prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"]'


def read(folder: Path, text: str, *, head: str = 'defaultPrim = "World"', name: str = "stage.usda") -> ImportedScene:
    """The scene of a stage whose prims stand in `/World`."""
    file = folder / name
    file.write_text(f'#usda 1.0\n(\n{head}\n)\ndef Xform "World" {{\n{text}\n}}\n', encoding="utf-8")
    sink = Sink()
    found = read_stage(file, ImportContext(sink, AssetScope(folder), Options().limits))
    assert found is not None, sink.diagnostics()
    assert not sink.failed, sink.diagnostics()
    return found


def entities(found: ImportedScene) -> dict[str, Any]:
    return found.document["entities"]


def at(x: float, y: float, z: float) -> str:
    return f'double3 xformOp:translate = ({x}, {y}, {z})\nuniform token[] xformOpOrder = ["xformOp:translate"]\n'


def test_a_box_of_a_stage_in_centimetres_with_y_up(tmp_path: Path) -> None:
    text = f'def Cube "box" ({BODY}) {{ double size = 10\n float physics:mass = 2\n {at(0, 20, 30)} }}'
    found = read(tmp_path, text, head='defaultPrim = "World"\nmetersPerUnit = 0.01\nupAxis = "Y"')
    assert not found.losses
    (box,) = entities(found).values()
    assert box["shapes"] == [{"type": "box", "half_size": [0.05, 0.05, 0.05]}]
    assert box["pose"]["p"] == [0.0, -0.3, 0.2]
    assert box["pose"]["q"] == pytest.approx([0.5**0.5, 0.5**0.5, 0, 0])
    assert box["mass"] == 2
