"""Mistakes in the keys of a robot's file are errors whose hints say what to write."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

import scenecc

if TYPE_CHECKING:
    from pathlib import Path

ARM = '<mujoco><worldbody><body name="a"><joint name="j"/><geom size="0.1"/></body></worldbody></mujoco>'


@pytest.mark.parametrize(
    ("keys", "code", "hint"),
    [
        ({"urdf": "a.urdf", "repair": "inertia"}, "SC103", "repairs are a list: `repair: [inertia]`"),
        ({"urdf": "a.urdf", "repair": ["shapes", "shapes"]}, "SC104", "name each repair once"),
        ({"mjcf": "a.xml", "visual_groups": [0, 0]}, "SC104", "name each group once"),
        ({"mjcf": "a.xml", "keyframe": "home"}, "SC482", "it has none: remove the key"),
    ],
)
def test_a_mistake_has_a_hint(keys: dict[str, Any], code: str, hint: str, tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text(ARM, encoding="utf-8")
    scene = tmp_path / "scene.yaml"
    scene.write_text(f"scenecc: 1\nentities: {{r: {keys}}}\n", encoding="utf-8")
    (found,) = [each for each in scenecc.validate(scene) if each.severity == "error"]
    assert (found.code, found.hint) == (code, hint)
