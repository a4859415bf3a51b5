"""Names of exported files."""

from __future__ import annotations

import json
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree as ET

import pytest

from scenecc import compile_scene, export_scene
from scenecc.plan.json_codec import plan_to_json

BALL = {"scenecc": 1, "entities": {"ball": {"shapes": [{"type": "sphere", "radius": 0.1}]}}}


@pytest.mark.parametrize("target", ["mjcf", "glb"])
@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("../../evil", "_.._evil"),
        ("/etc/passwd", "_etc_passwd"),
        ("..", "scene"),
        (".hidden", "hidden"),
        ("a\\b\0c", "a_b_c"),
        ("x" * 300, "x" * 60),
        ("two words, ä", "two words, ä"),
    ],
)
def test_a_name_becomes_a_safe_file_name(name: str, stem: str, target: str) -> None:
    paths = [PurePosixPath(path) for path in export_scene(BALL, target, name=name)]
    assert paths[0].stem == stem
    assert all(".." not in path.parts and not path.is_absolute() for path in paths)


def test_a_scene_name_cannot_leave_the_output_folder() -> None:
    assert list(export_scene(BALL | {"name": "../../evil"}, "mjcf")) == ["_.._evil.xml"]


@pytest.mark.parametrize("name", ["a\ud800", "a\x1b"])
def test_characters_of_a_name_that_xml_cannot_hold_are_replaced(name: str, tmp_path: Path) -> None:
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(json.loads(plan_to_json(compile_scene(BALL))) | {"name": name}))
    (text,) = export_scene(file, "mjcf").values()
    assert ET.fromstring(text).get("model") == "a\ufffd"
