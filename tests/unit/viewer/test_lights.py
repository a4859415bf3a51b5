"""The lights of a file on a page: their places, colours and brightness."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra `view`")

from scenecc import ViewOptions
from scenecc.options import Options
from scenecc.viewer.surfaces import SurfaceFiles
from scenecc.viewer.world import World, load

SCENE: dict[str, Any] = {
    "scenecc": 1,
    "num_scenes": 2,
    "environment": {"ambient_light": [0.2, 0.1, 0.0]},
    "lights": {
        "sun": {"type": "directional", "direction": [0, 0, -1], "color": [2, 1, 0], "shadow": True},
        "bulb": {"type": "point", "position": [1, 2, 3], "color": [0.5, 0.5, 0.5], "scene_idxs": [1]},
        "lamp": {
            "type": "spot",
            "mount": "ball",
            "pose": [0, 0, 1],
            "inner_fov": 0.5,
            "outer_fov": 1,
            "color": [1, 1, 1],
        },
        "panel": {"type": "area", "pose": [0, 0, 2], "half_width": 1, "half_height": 1, "color": [1, 1, 1]},
    },
    "entities": {"ball": {"pose": [5, 0, 0], "shapes": [{"type": "sphere", "radius": 0.1}]}},
}


def lights(scene: dict[str, Any], look: ViewOptions) -> Any:
    loaded = load(scene, Options.of(), {}).loaded
    assert loaded is not None, load(scene, Options.of(), {}).diagnostics
    world = World(loaded, look)
    found = world.picture(look, SurfaceFiles()).lights, world.has_lights
    world.close()
    return found


def test_lights_are_as_bright_as_in_sapien() -> None:
    found, possible = lights(SCENE, ViewOptions(lights=True))
    assert possible
    ambient, sun, lamp = found
    # Pictures of a white box in SAPIEN and in the browser gave these factors.
    assert (ambient.kind, ambient.intensity) == ("ambient", pytest.approx(0.2 * np.pi))
    assert ambient.color == (255, 188, 0), "half of the largest component, as sRGB"
    assert (sun.kind, sun.intensity, sun.color, sun.shadow) == ("directional", 2, (255, 188, 0), True)
    assert sun.position == pytest.approx((0, 0, 1)), "where it comes from"
    assert (lamp.kind, lamp.position, lamp.shadow) == ("spot", pytest.approx((5, 0, 1)), False)
    assert lamp.cone[0] == pytest.approx((1, 0, 0))
    assert lamp.cone[1:] == (0.5, 0.5)


def test_lights_are_those_of_the_scene_shown_and_on_request() -> None:
    found, _ = lights(SCENE, ViewOptions(scene=1, lights=True))
    assert [light.kind for light in found] == ["ambient", "directional", "point", "spot"]
    assert found[2].position == (1, 2, 3)
    assert lights(SCENE, ViewOptions()) == ((), True)
    plain = {"scenecc": 1, "entities": SCENE["entities"]}
    assert lights(plain, ViewOptions(lights=True)) == ((), False)
