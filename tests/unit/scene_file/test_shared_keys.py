"""Shapes that become one, and keys that move up."""

from __future__ import annotations

from typing import Any

import pytest

from scenecc.scene_file.shared_keys import form_of, merge_shapes, move_shape_keys_up

BALL = {"type": "sphere", "radius": 0.1, "pose": [0.0, 0.0, 1.0]}


@pytest.mark.parametrize(
    ("collision", "visual", "equal"),
    [
        (BALL, {**BALL, "color": [1.0, 0.0, 0.0]}, True),
        (BALL, {**BALL, "pose": [0.0, 0.0, 2.0]}, False),
        ({"type": "plane", "offset": 1.0}, {"type": "plane", "offset": 1.0, "half_size": [2.0, 2.0]}, True),
        ({"type": "convex_mesh", "file": "a.obj"}, {"type": "mesh", "file": "a.obj"}, True),
        ({"type": "convex_mesh", "file": "a.obj", "scale": 2.0}, {"type": "mesh", "file": "a.obj"}, False),
        ({"type": "heightfield", "size": [1, 1, 1]}, {"type": "heightfield", "size": [1, 1, 2]}, False),
    ],
)
def test_a_collision_and_a_visual_have_one_form(collision: Any, visual: Any, equal: bool) -> None:
    assert (form_of(collision) == form_of(visual)) is equal


def test_a_merged_shape_has_both_materials_and_the_size_that_is_seen() -> None:
    grip, look = {"physical": {"restitution": 0.5}}, {"visual": {"roughness": 0.2}}
    seen = {"type": "plane", "half_size": [2.0, 2.0], "material": look}
    assert merge_shapes({"type": "plane", "material": grip}, seen) == {**seen, "material": {**grip, **look}}


def test_keys_move_up_where_all_shapes_that_have_them_share_them() -> None:
    def node() -> dict[str, Any]:
        ball = {**BALL, "color": "#ff0000", "density": 500.0}
        return {"shapes": [ball], "visuals": [{**BALL, "color": "#ff0000"}], "collisions": [dict(BALL)]}

    body, link = node(), node()
    move_shape_keys_up(body, is_link=False)
    assert body == {"shapes": [{**BALL, "density": 500.0}], "visuals": [BALL], "collisions": [BALL], "color": "#ff0000"}
    move_shape_keys_up(link, is_link=True)
    assert link == node()
    alone = {"shapes": [{**BALL, "density": 500.0, "collision_bits": [1, 1, 2, 0]}]}
    move_shape_keys_up(alone, is_link=False, least=2)
    assert alone == {"shapes": [{**BALL, "density": 500.0}], "collision_bits": [1, 1, 2, 0]}
