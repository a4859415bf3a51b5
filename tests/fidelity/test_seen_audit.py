"""Sabotage of lights and cameras: the audit names line and fault. Needs a device."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sapien

from scenecc import compile_scene
from scenecc.backends.sapien import build, instantiate
from scenecc.backends.sapien.preparation import EntityLookup
from scenecc.backends.sapien.rendering import LightsAndCameras
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.plan import ScenePlan

pytestmark = pytest.mark.render

PICTURE = str(Path(__file__).parents[1] / "scenes" / "good" / "assets" / "checker.png")
SHAPES = [{"type": "sphere", "radius": 0.1}]
WHITE = {"color": [1, 1, 1]}
CONE = {"position": [0, 0, 1], "direction": [0, 0, -1], "inner_fov": 0.4, "outer_fov": 0.6, **WHITE}
TURNED = [0.9238795325112867, 0, 0, 0.3826834323650898]
DOCUMENT: dict[str, Any] = {
    "scenecc": 1,
    "num_scenes": 2,
    "entities": {name: {"body_type": "kinematic", "shapes": SHAPES} for name in ("cart", "other")},
    "environment": {
        "ambient_light": {"per_scene": [[0.1, 0.2, 0.3], [0.3, 0.2, 0.1]]},
        "map": dict.fromkeys(("px", "nx", "py", "ny", "pz", "nz"), PICTURE),
    },
    "lights": {
        "bulb": {"type": "point", "position": [{"per_scene": [1, 2]}, 0, 1], "color": [0.1, 0.7, 3], "shadow": True},
        "sun": {"type": "directional", "direction": [0.3, 0.1, -1], "shadow": True, "shadow_scale": 3, **WHITE},
        "torch": {"type": "spot", "mount": "cart", **CONE},
        "panel": {"type": "area", "pose": [0, 0, 2], "half_width": 0.3, "half_height": 0.2, **WHITE},
        "film": {"type": "textured", "texture": {"file": PICTURE, "filter_mode": "nearest"}, **CONE},
    },
    "cameras": {
        "tall": {"pose": {"p": [-1, 0, 0], "q": TURNED}, "width": 8, "height": 6, "fovy_deg": {"per_scene": [40, 50]}},
        "wide": {"width": 8, "height": 6, "fovx": 1.3, "near": 0.1, "scene_idxs": [1]},
        "matrix": {"mount": "cart", "pose": [0.1, 0, 0], "width": 8, "height": 6, "intrinsic": {"fx": 7.1, "fy": 9.3}},
        "flat": {"width": 8, "height": 6, "orthographic": {"top": 0.7}},
    },
}

Sabotage = Callable[[LightsAndCameras, EntityLookup], None]


@pytest.fixture(scope="module")
def plan() -> ScenePlan:
    return compile_scene(DOCUMENT, allow_outside_assets=True)


def audited(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch, sabotage: Sabotage) -> list[Diagnostic]:
    """What the audit reports after `sabotage` has changed the lights and cameras."""

    def dress(plan: ScenePlan, standing: EntityLookup, *, rendered: bool) -> LightsAndCameras:
        made = LightsAndCameras(plan, standing, rendered=rendered)
        sabotage(made, standing)
        return made

    monkeypatch.setattr(build, "LightsAndCameras", dress)
    sink = Sink()
    batch = instantiate(plan, sink, render=True)
    assert (batch is None) == bool(sink.diagnostics())
    if batch is not None:
        batch.close()
    return sink.diagnostics()


def nothing(_dress: LightsAndCameras, _standing: EntityLookup) -> None:
    return


def moved(name: str) -> Sabotage:
    def sabotage(dress: LightsAndCameras, _standing: EntityLookup) -> None:
        held = {**dress.lights, **dress.cameras}[name]
        held.objs[0].get_entity().set_pose(sapien.Pose([9, 0, 0]))

    return sabotage


def removed(dress: LightsAndCameras, standing: EntityLookup) -> None:
    standing.scenes[0].remove_entity(dress.lights["bulb"].objs[0].get_entity())


def swapped(dress: LightsAndCameras, _standing: EntityLookup) -> None:
    """The right pieces in the wrong scenes."""
    objs = dress.lights["bulb"].objs
    objs[0], objs[1] = objs[1], objs[0]


def another(_dress: LightsAndCameras, standing: EntityLookup) -> None:
    standing.scenes[1].add_camera("more", 8, 6, 1, 0.1, 10)


def unmounted(dress: LightsAndCameras, _standing: EntityLookup) -> None:
    torch = dress.lights["torch"].objs[1]
    torch.get_entity().remove_component(torch)


CASES: dict[str, tuple[Sabotage, str, tuple[str, ...]]] = {
    "moved light": (moved("panel"), "lights.panel", ("pose", "9.0")),
    "moved camera": (moved("tall"), "cameras.tall", ("pose", "9.0")),
    "removed light": (removed, "", ("entities in the scene", "scene 0")),
    "one light less": (unmounted, "lights", ("scene 1", "lights = 'bulb', 'film', 'panel', 'sun', but the plan")),
    "swapped scenes": (swapped, "lights.bulb", ("build order", "1 more")),
    "one camera more": (another, "cameras", ("cameras = 'flat', 'matrix', 'more', 'tall', 'wide', but", "scene 1")),
}


@pytest.mark.parametrize("name", CASES)
def test_sabotage(name: str, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    sabotage, path, words = CASES[name]
    found = audited(plan, monkeypatch, sabotage)
    assert {d.code for d in found} == {"SC802"}
    assert [d for d in found if d.path.startswith(path) and all(word in d.message for word in words)], found


def test_nothing_is_said_of_what_is_right(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    assert audited(plan, monkeypatch, nothing) == []


def test_a_plan_without_lights_and_cameras_has_none_before_its_first_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    bare = compile_scene({"scenecc": 1, "entities": {"ball": {"shapes": SHAPES}}})
    assert audited(bare, monkeypatch, nothing) == []
    found = audited(bare, monkeypatch, lambda _, standing: standing.scenes[0].add_point_light([0, 0, 1], [1, 1, 1]))
    assert any("the scene in scene 0: the engine holds entities in the scene = 2" in d.message for d in found)
