from __future__ import annotations

from typing import Any

import pytest

from scenecc import validate

BOX = {"type": "box", "half_size": [0.1, 0.1, 0.1]}
ARM: dict[str, Any] = {
    "root": {
        "name": "base",
        "shapes": [BOX],
        "children": [{"name": "rim", "shapes": [BOX], "joint": {"name": "wheel", "type": "revolute", "axis": "x"}}],
    }
}


@pytest.mark.parametrize(
    ("qvel", "enough"),
    [(60, 60), ({"uniform": [-70, 60]}, 70), ({"choice": [10, 52.5]}, 53), ({"uniform": [10, 50]}, None)],
)
def test_a_speed_limit_that_the_hint_names_is_enough(qvel: Any, enough: int | None) -> None:
    arm = {**ARM, "fix_root_link": True, "disable_self_collisions": True, "qvel": {"wheel": qvel}}
    document: dict[str, Any] = {"scenecc": 1, "num_scenes": 3, "entities": {"arm": arm}}
    found = [one for one in validate(document) if one.code == "SC567"]
    assert [f"`max_angular_velocity: {enough}`" in str(one.hint) for one in found] == [True] * (enough is not None)
    if enough is not None:
        document["entities"]["arm"] = {**arm, "links": {"rim": {"max_angular_velocity": enough}}}
        assert not [one for one in validate(document) if one.code == "SC567"]
