"""What `describe_scene` says of built scenes."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import pytest

import scenecc
from scenecc.simulation.relations import TOUCH

ROOT = Path(__file__).parents[3]

ROOM = """\
scenecc: 1
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  table:
    body_type: static
    shapes:
      - {type: box, half_size: [0.5, 0.5, 0.02], pose: [0, 0, 0.38], color: "#8b5a2b"}
      - {type: box, half_size: [0.02, 0.02, 0.18], pose: [0.4, 0.4, 0.18]}
  under: {pose: [0, 0, 0.05], shapes: [{type: box, half_size: [0.05, 0.05, 0.05]}]}
  bin:
    body_type: kinematic
    pose: {p: [0.2, 0, 0.4], rpy_deg: [0, 0, 30]}
    shapes:
      - {type: box, half_size: [0.1, 0.1, 0.005], pose: [0, 0, 0.005]}
      - {type: box, half_size: [0.1, 0.005, 0.05], pose: [0, 0.1, 0.05]}
      - {type: box, half_size: [0.1, 0.005, 0.05], pose: [0, -0.1, 0.05]}
      - {type: box, half_size: [0.005, 0.1, 0.05], pose: [0.1, 0, 0.05]}
      - {type: box, half_size: [0.005, 0.1, 0.05], pose: [-0.1, 0, 0.05]}
  ball: {pose: [0.2, 0, 0.43], mass: 0.3, shapes: [{type: sphere, radius: 0.02, color: "#d62828"}]}
  lid: {pose: [0.2, 0, 0.461], shapes: [{type: cylinder, radius: 0.02, half_length: 0.01, axis: z}]}
  cup: {pose: [-0.2, 0, 0.46], shapes: [{type: cylinder, radius: 0.03, half_length: 0.03, axis: z}]}
  side: {pose: [-0.14, 0, 0.43], shapes: [{type: cylinder, radius: 0.03, half_length: 0.03, axis: z}]}
  deep: {pose: [-0.3, -0.3, 0.415], shapes: [{type: box, half_size: [0.02, 0.02, 0.02]}]}
  high: {pose: [-0.3, 0.3, 1], shapes: [{type: box, half_size: [0.02, 0.02, 0.02]}]}
  bob: {pose: [1, 0, 0.7], shapes: [{type: sphere, radius: 0.02}]}
  mark: {body_type: none, pose: [0.2, 0.3, 0.401], visuals: [{type: box, half_size: [0.02, 0.02, 0.001]}]}
constraints:
  string: {type: ball, parent: world, child: bob, pose_in_child: [0, 0, 0.1], pose_in_parent: [1, 0, 0.8]}
"""


@pytest.fixture(scope="module")
def room() -> dict[str, Any]:
    data = dict(scenecc.describe_scene(io.StringIO(ROOM)).data)
    json.dumps(data, allow_nan=False)
    return data | {one["name"]: one for one in data["objects"]}


@pytest.mark.parametrize("kind", ["static", "kinematic", "dynamic"])
@pytest.mark.parametrize(
    "shape", ["box, half_size: [0.1, 0.1, 0.1]", "cylinder, radius: 0.1, half_length: 0.1, axis: z"]
)
def test_contacts_of_bodies_that_never_move_are_found(kind: str, shape: str) -> None:
    text = f"""\
scenecc: 1
entities:
  ground: {{body_type: static, shapes: [{{type: plane}}]}}
  low: {{body_type: {kind}, pose: [0, 0, 0.1], shapes: [{{type: {shape}}}]}}
  high: {{body_type: {kind}, pose: [0, 0, 0.33], shapes: [{{type: {shape}}}]}}
"""
    _, low, high = scenecc.describe_scene(io.StringIO(text)).data["objects"]
    assert low["stands_on"] == ["ground"]
    assert high["above"] == {"name": "low", "gap_m": pytest.approx(0.03, abs=1e-5)}


def test_what_a_body_stands_on_and_is_in(room: dict[str, Any]) -> None:
    assert room["table"]["stands_on"] == ["ground"]
    assert (room["under"]["stands_on"], room["under"]["is_in"]) == (["ground"], [])
    assert (room["bin"]["stands_on"], room["bin"]["is_in"]) == (["table"], [])
    assert (room["ball"]["stands_on"], room["ball"]["is_in"]) == (["bin"], ["bin"])
    assert (room["lid"]["stands_on"], room["lid"]["is_in"]) == (["ball"], ["bin"])
    assert set(room["table"]["carries"]) == {"bin", "side", "deep"}
    assert {name for name, one in room.items() if isinstance(one, dict) and one["falls"]} == {"cup", "high"}


def test_what_lies_on_a_slope_is_not_in_it_and_a_lamp_carries_no_ceiling() -> None:
    text = """\
scenecc: 1
entities:
  ramp: {body_type: static, pose: {p: [0, 0, 0.5], rpy_deg: [0, 30, 0]}, shapes: [{type: box, half_size: [1, 1, 0.1]}]}
  ball: {pose: [0.1, 0, 0.7402], shapes: [{type: sphere, radius: 0.158}]}
  ceiling: {body_type: static, pose: [5, 0, 2.05], shapes: [{type: box, half_size: [1, 1, 0.05]}]}
  lamp: {pose: [5, 0, 1.9], shapes: [{type: sphere, radius: 0.1}]}
  tray:
    pose: {p: [9, 0, 0], rpy_deg: [0, 20, 45]}
    shapes:
      - {type: box, half_size: [0.2, 0.2, 0.01]}
      - {type: box, half_size: [0.2, 0.01, 0.05], pose: [0, 0.2, 0.05]}
      - {type: box, half_size: [0.2, 0.01, 0.05], pose: [0, -0.2, 0.05]}
      - {type: box, half_size: [0.01, 0.2, 0.05], pose: [0.2, 0, 0.05]}
  egg:
    pose: {p: [0, 0.14, 0.04], relative_to: tray}
    shapes: [{type: sphere, radius: 0.03}]
"""
    objects = {one["name"]: one for one in scenecc.describe_scene(io.StringIO(text)).data["objects"]}
    assert (objects["ball"]["stands_on"], objects["ball"]["is_in"]) == (["ramp"], [])
    assert (objects["ceiling"]["stands_on"], objects["lamp"]["carries"]) == ([], [])
    assert (objects["ceiling"]["touches"], objects["lamp"]["touches"], objects["lamp"]["falls"]) == (
        ["lamp"],
        ["ceiling"],
        True,
    )
    assert (objects["egg"]["stands_on"], objects["egg"]["is_in"]) == (["tray"], ["tray"])


def test_gaps_contacts_and_overlaps_are_exact(room: dict[str, Any]) -> None:
    assert room["cup"]["above"] == {"name": "table", "gap_m": pytest.approx(0.03, abs=1e-5)}
    assert room["cup"]["touches"] == ["side"]
    assert room["high"]["above"] is None
    assert room["deep"]["overlaps"] == [{"name": "table", "depth_m": pytest.approx(0.005, abs=1e-5)}]
    assert (room["bob"]["hangs_on"], room["bob"]["attached_to"]) == (["world"], ["world"])
    assert room["touch_m"] == TOUCH


def test_sizes_masses_and_places(room: dict[str, Any]) -> None:
    table, ball = room["table"], room["ball"]
    assert table["size_m"] == [1, 1, 0.4]
    assert table["box_m"] == {"low": [-0.5, -0.5, 0], "high": [0.5, 0.5, 0.4]}
    assert (table["kind"], table["mass_kg"], table["line"]) == ("static", None, 4)
    assert (ball["kind"], ball["mass_kg"]) == ("dynamic", 0.3)
    assert room["bin"]["rpy_deg"] == [0, 0, 30]
    assert (room["ground"]["size_m"], room["ground"]["box_m"], room["ground"]["plane_height_m"]) == (None, None, 0)
    assert room["mark"]["size_m"] == [0.04, 0.04, 0.002]


def test_the_text_folds_copies_and_fits_a_screen() -> None:
    text = scenecc.describe_scene(ROOT / "scenes/tabletop.yaml").text
    assert len(text.splitlines()) < 40
    assert "cube: dynamic, line 35, 0.04 × 0.04 × 0.04 m, 0.0704 kg\n" in text
    assert "  at (-0.1, 0, 0.02), yaw 30°, z from 0 to 0.04; on table\n" in text
    scene = (
        "scenecc: 1\nentities:\n  ground: {body_type: static, shapes: [{type: plane}]}\n  thing:\n"
        "    repeat: {i: {count: 30}}\n    pose: ['${i}', 0, 0.1]\n"
        "    shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]\n"
    )
    text = scenecc.describe_scene(io.StringIO(scene)).text
    assert "thing_0 … thing_29 (30): dynamic" in text
    assert "at (0…29, 0, 0.1), z from 0 to 0.2; on ground" in text
    assert "  a plane at z = 0" in text
    assert "carries thing_0 … thing_29 (30)" in text


def test_a_scene_that_does_not_exist_is_an_error() -> None:
    with pytest.raises(scenecc.SceneError):
        scenecc.describe_scene(io.StringIO(ROOM), scene=1)
    with pytest.raises(TypeError, match="scenes"):
        scenecc.describe_scene(io.StringIO(ROOM), scenes=1)  # pyright: ignore[reportCallIssue]
