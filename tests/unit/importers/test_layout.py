"""EmbodiedGen's layouts as scenes: bodies as its loader builds them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from scenecc.diagnostics import Sink
from scenecc.importers.import_scene import is_source
from scenecc.importers.imported_scene import ImportContext, ImportedScene
from scenecc.importers.layout import import_layout
from scenecc.source import Limits
from scenecc.source.paths import AssetScope

SHAPE = """<{tag}><origin xyz="0.01 0 0" rpy="0 0 0"/>
  <geometry><mesh filename="mesh/v.obj" scale="0.1 0.1 0.1"/></geometry>
  {rest}</{tag}>"""
URDF = """<robot name="{name}"><link name="{name}">{visual}{collision}
<inertial><mass value="0.4"/>
  <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>{rest}</robot>"""
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
DOOR = """<link name="door"><inertial><mass value="1"/>
  <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="box_1"/><child link="door"/><axis xyz="0 0 1"/>
<limit lower="0" upper="1" effort="1" velocity="1"/></joint>"""
LAYOUT: dict[str, Any] = {
    "tree": {"room": [["table", "FLOOR"], ["franka", "IN"]], "table": [["blue bowl", "ON"]]},
    "relation": {"background": "room", "context": "table", "manipulated_objs": ["blue bowl"], "robot": "franka"},
    "objs_desc": {"table": "a table 🙂", "room": "a/b"},
    "objs_mapping": {"room": "background", "table": "context", "blue bowl": "manipulated_objs", "box 1": "others"},
    "assets": {"room": "background", "table": "assets/table", "blue bowl": "assets/bowl", "box 1": "assets/box/"},
    "quality": {},
    "position": {
        "room": [0, 0, 0, 0, 0, 0, 1],
        "table": [1, 2, 0, 0, 0, 0, 1],
        "blue bowl": [1, 2, 0.8, 0, 0, math.sin(math.pi / 8), math.cos(math.pi / 8)],
        "box 1": [0, 0, 1, 0, 0, 0, 2],
        "franka": [-2, 0, 0, 0, 0, 0, 1],
    },
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    gazebo = "<gazebo><mu1>0.80</mu1><mu2>0.05</mu2></gazebo>"
    for place, name, rest in (("table", "table", ""), ("bowl", "blue_bowl", ""), ("box", "box_1", DOOR)):
        (tmp_path / "assets" / place / "mesh").mkdir(parents=True)
        (tmp_path / "assets" / place / "mesh/v.obj").write_text(OBJ)
        shapes = {"visual": SHAPE.format(tag="visual", rest="")}
        shapes["collision"] = SHAPE.format(tag="collision", rest=gazebo if name != "table" else "")
        (tmp_path / "assets" / place / f"{name}.urdf").write_text(URDF.format(name=name, rest=rest, **shapes))
    return tmp_path


def read(folder: Path, layout: Any) -> tuple[ImportedScene | None, Sink]:
    (folder / "layout.json").write_text(layout if isinstance(layout, str) else json.dumps(layout))
    sink = Sink()
    return import_layout(folder / "layout.json", ImportContext(sink, AssetScope(folder), Limits())), sink


def changed(**keys: Any) -> dict[str, Any]:
    return {**LAYOUT, **keys}


def test_bodies_are_those_of_the_loader(folder: Path) -> None:
    found, sink = read(folder, LAYOUT)
    assert found is not None, sink.diagnostics()
    entities = found.document["entities"]
    assert [*entities] == ["table", "blue_bowl", "box_1"]
    assert entities["table"]["body_type"] == "static"
    bowl = entities["blue_bowl"]
    assert bowl["pose"] == {"p": [1, 2, 0.8], "rpy_deg": [0, 0, 45]}
    assert "mass" not in bowl
    assert "inertial" not in bowl
    material = {"static_friction": 0.7, "dynamic_friction": 0.1, "restitution": 0.05}
    assert bowl["material"] == {"physical": material}
    assert bowl["shapes"][0]["type"] == "convex_parts"
    assert entities["box_1"]["fix_root_link"] is False
    assert [loss.kind for loss in found.losses] == ["visuals", "assumed-masses", "robots"]
    assert "franka" in found.losses[-1].message


def test_a_layout_is_recognised_by_its_name_and_content(folder: Path) -> None:
    read(folder, LAYOUT)
    (folder / "my_layout.json").write_text("{}")
    assert is_source(folder / "layout.json")
    assert not is_source(folder / "my_layout.json")


def test_a_missing_urdf_is_a_loss(folder: Path) -> None:
    (folder / "assets/bowl/blue_bowl.urdf").unlink()
    found, _ = read(folder, LAYOUT)
    assert found is not None
    assert [loss.kind for loss in found.losses] == ["visuals", "models", "robots"]


@pytest.mark.parametrize("text", ["[1]", "{}", "3", '{"tree": {}, "relation": 3}', '{"tree": 1', "[" * 3000, ""])
def test_another_json_is_no_layout(text: str, folder: Path) -> None:
    found, sink = read(folder, text)
    assert found is None
    assert sink.failed
    assert all(fault.location.line for fault in sink.diagnostics())


@pytest.mark.parametrize(
    ("layout", "words"),
    [
        (changed(position={**LAYOUT["position"], "table": [1, 2, 3]}), "7 numbers"),
        (changed(position={**LAYOUT["position"], "table": [0] * 7}), "length 0"),
        (changed(position={**LAYOUT["position"], "table": [0, 0, "x", 0, 0, 0, 1]}), "finite number"),
        (changed(position={"room": [0] * 7}), "no `position`"),
        (changed(objs_mapping={"room": "background"}), "not in `objs_mapping`"),
        (changed(assets={"table": ["assets"]}), "must be a string"),
        (changed(relation={**LAYOUT["relation"], "robot": ["franka"]}), "must be a string"),
    ],
)
def test_a_fault_is_told_at_its_line(layout: dict[str, Any], words: str, folder: Path) -> None:
    found, sink = read(folder, layout)
    assert found is None
    faults = [fault for fault in sink.diagnostics() if fault.severity == "error"]
    assert words in faults[0].message
    assert {fault.code for fault in faults} == {"SC433"}
    assert faults[0].location.line == 1


def test_a_folder_outside_is_not_read(folder: Path) -> None:
    found, _ = read(folder, changed(assets={"table": "../../etc"}))
    assert found is not None
    assert [loss.kind for loss in found.losses] == ["models", "robots"]
