"""Sabotage of surroundings, lights and cameras: the audit names line and property. Needs a device."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

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


def audited(
    plan: ScenePlan, monkeypatch: pytest.MonkeyPatch, sabotage: Sabotage, level: Literal["full", "fast", "off"]
) -> list[Diagnostic]:
    """What the audit says after `sabotage` was let loose on the lights and cameras."""

    def dress(plan: ScenePlan, standing: EntityLookup, *, rendered: bool) -> LightsAndCameras:
        made = LightsAndCameras(plan, standing, rendered=rendered)
        sabotage(made, standing)
        return made

    monkeypatch.setattr(build, "LightsAndCameras", dress)
    sink = Sink()
    batch = instantiate(plan, sink, render=True, audit=level)
    assert (batch is None) == bool(sink.diagnostics())
    if batch is not None:
        batch.close()
    return sink.diagnostics()


def nothing(_dress: LightsAndCameras, _standing: EntityLookup) -> None:
    return


def light(name: str, attribute: str, value: Any, scene: int = 0) -> Sabotage:
    return lambda dress, _: setattr(dress.lights[name].objs[scene], attribute, value)


def camera(name: str, attribute: str, value: Any, scene: int = 0) -> Sabotage:
    return lambda dress, _: setattr(dress.cameras[name].objs[scene], attribute, value)


def moved(name: str) -> Sabotage:
    def sabotage(dress: LightsAndCameras, _standing: EntityLookup) -> None:
        held = {**dress.lights, **dress.cameras}[name]
        held.objs[0].get_entity().set_pose(sapien.Pose([9, 0, 0]))

    return sabotage


def remounted(dress: LightsAndCameras, standing: EntityLookup) -> None:
    torch = dress.lights["torch"].objs[0]
    torch.get_entity().remove_component(torch)
    next(entity for name, entity in standing.entities(0) if name == "other").add_component(torch)


def removed(dress: LightsAndCameras, standing: EntityLookup) -> None:
    standing.scenes[0].remove_entity(dress.lights["bulb"].objs[0].get_entity())


def swapped(dress: LightsAndCameras, _standing: EntityLookup) -> None:
    """The right pieces in the wrong scenes."""
    objs = dress.lights["bulb"].objs
    objs[0], objs[1] = objs[1], objs[0]


def another(_dress: LightsAndCameras, standing: EntityLookup) -> None:
    standing.scenes[1].add_camera("more", 8, 6, 1, 0.1, 10)


def ambient(_dress: LightsAndCameras, standing: EntityLookup) -> None:
    standing.scenes[1].set_ambient_light([0, 0, 0])


def unmapped(_dress: LightsAndCameras, standing: EntityLookup) -> None:
    standing.scenes[0].render_system.cubemap = None


def untextured(dress: LightsAndCameras, _standing: EntityLookup) -> None:
    dress.lights["film"].objs[0].texture = sapien.render.RenderTexture2D(PICTURE, filter_mode="linear")


CASES: dict[str, tuple[Sabotage, str, tuple[str, ...]]] = {
    "colour": (light("bulb", "color", [0.1, 0.7, 2]), "lights.bulb", ("color = [0.1, 0.7, 2.0]", "scene 0")),
    "colour, last scene": (light("bulb", "color", [0, 0, 0], 1), "lights.bulb", ("color", "scene 1")),
    "shadow": (light("bulb", "shadow", False), "lights.bulb", ("shadow",)),
    "shadow's end": (light("bulb", "shadow_far", 9), "lights.bulb", ("shadow_far = 9.0", "10.0")),
    "shadow's edge": (light("sun", "shadow_half_size", 4), "lights.sun", ("shadow_half_size",)),
    "shadow's map": (light("sun", "shadow_map_size", 64), "lights.sun", ("shadow_map_size",)),
    "cone": (light("torch", "outer_fov", 0.2), "lights.torch", ("outer_fov",)),
    "name": (light("torch", "name", "lamp"), "lights.torch", ("name = 'lamp'",)),
    "local pose": (light("torch", "local_pose", sapien.Pose([1, 0, 0])), "lights.torch", ("local_pose",)),
    "another mount": (remounted, "lights.torch", ("entity", "'cart'")),
    "moved light": (moved("panel"), "lights.panel", ("entity.pose", "9.0")),
    "edge of an area": (
        lambda dress, _: dress.lights["panel"].objs[0].set_shape(0.3, 0.3),
        "lights.panel",
        ("half_height",),
    ),
    "picture of a light": (untextured, "lights.film", ("texture.filter_mode = 'linear'", "'nearest'")),
    "removed light": (removed, "lights.bulb", ("scene = none",)),
    "one light less": (removed, "environment", ("lights = 4", "5")),
    "swapped scenes": (swapped, "lights.bulb", ("scene = another", "1 more")),
    "one camera more": (another, "environment", ("cameras = 5", "scene 1")),
    "ambient light": (ambient, "environment", ("ambient_light", "scene 1", "[0.3, 0.2, 0.1]")),
    "map": (unmapped, "environment", ("cubemap = 'none'",)),
    "angle": (lambda dress, _: dress.cameras["tall"].objs[0].set_fovx(0.7, True), "cameras.tall", ("fovy",)),
    "angle, last scene": (
        lambda dress, _: dress.cameras["tall"].objs[1].set_fovy(0.7, True),
        "cameras.tall",
        ("fovy", "scene 1"),
    ),
    "pixels that are not square": (
        lambda dress, _: dress.cameras["wide"].objs[0].set_fovy(0.7, False),
        "cameras.wide",
        ("fx / fy", "scene 1"),
    ),
    "middle": (
        lambda dress, _: dress.cameras["tall"].objs[0].set_principal_point(1, 3),
        "cameras.tall",
        ("cx = 1.0", "4.0"),
    ),
    "near": (camera("wide", "near", 0.01), "cameras.wide", ("near = 0.01", "0.1")),
    "far": (camera("matrix", "far", 9), "cameras.matrix", ("far = 9.0", "100.0")),
    "matrix": (
        lambda dress, _: dress.cameras["matrix"].objs[0].set_focal_lengths(7.1, 7.1),
        "cameras.matrix",
        ("fy = 7.1", "9.3"),
    ),
    "mounted camera": (camera("matrix", "local_pose", sapien.Pose()), "cameras.matrix", ("local_pose",)),
    "moved camera": (moved("tall"), "cameras.tall", ("entity.pose",)),
    "edges": (
        lambda dress, _: dress.cameras["flat"].objs[0].set_orthographic_parameters(0.01, 100, -1, 1, -0.7, 0.7),
        "cameras.flat",
        ("ortho_right = 1.0",),
    ),
    "mode": (
        lambda dress, _: dress.cameras["flat"].objs[0].set_perspective_parameters(0.01, 100, 6, 6, 4, 3, 0),
        "cameras.flat",
        ("mode = 'perspective'",),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_sabotage(name: str, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    sabotage, path, words = CASES[name]
    found = audited(plan, monkeypatch, sabotage, "fast")
    assert {d.code for d in found} <= {"SC802"}
    told = [d for d in found if d.path.startswith(path) and all(word in d.message for word in words)]
    assert told, "\n".join(map(str, found))


def test_nothing_is_said_of_what_is_right(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    assert audited(plan, monkeypatch, nothing, "full") == []


def test_a_plan_without_lights_and_cameras_has_none_before_its_first_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    bare = compile_scene({"scenecc": 1, "entities": {"ball": {"shapes": SHAPES}}})
    assert audited(bare, monkeypatch, nothing, "full") == []
    (found,) = audited(
        bare, monkeypatch, lambda _, standing: standing.scenes[0].add_point_light([0, 0, 1], [1, 1, 1]), "fast"
    )
    assert "the scene in scene 0: the engine holds lights = 1, and the plan asks for 0" in found.message


def test_off_reads_nothing(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    assert audited(plan, monkeypatch, light("bulb", "color", [0, 0, 0]), "off") == []
