"""What can be wrong with a picture before it is taken, and plans as they are built for one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import scenecc
from scenecc.extras import install_hint
from scenecc.plan import ArticulationStructure, Intrinsic, Perspective
from scenecc.render import render
from scenecc.render.plan_cameras import resize_camera, restrict_to_camera

CUBE = {"shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}], "shading_mode": 1, "visibility": 0.5}
ARM = {
    "root": {
        "name": "base",
        "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}],
        "children": [{"name": "tip", "joint": {"type": "fixed"}, "visuals": [{"type": "sphere", "radius": 1}]}],
    }
}
LENS = {"fx": 100, "fy": 110, "cx": 50, "cy": {"per_scene": [30, 40]}, "skew": 1}
CAMERAS = {
    "wide": {"fovy": 1.0, "width": 64, "height": 48},
    "matrix": {"intrinsic": LENS, "width": 100, "height": 80},
}
SCENE: dict[str, Any] = {"scenecc": 1, "num_scenes": 2, "entities": {"cube": CUBE, "arm": ARM}, "cameras": CAMERAS}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"what": "colour"}, "what must be one of color, depth"),
        ({"video": "avi", "steps": 1}, "video must be one of gif, mp4"),
        ({"video": "mp4"}, "video needs at least 1 step"),
        ({"every": 2}, "every needs a video"),
        ({"video": "gif", "steps": 3, "every": 4}, "must not exceed its steps"),
        ({"video": "gif", "steps": 3, "every": 0}, "every must be at least 1"),
        ({"size": (0, 4)}, "a size must be at least 1"),
        ({"size": (16385, 4)}, "1 to 16384 pixels a side"),
        ({"steps": -1}, "steps must be at least 0"),
        ({"samples": 0}, "samples must be 1 to 256, not 0"),
        ({"samples": 1000}, "samples must be 1 to 256, not 1000"),
        ({"samples": 4, "what": "depth"}, "samples is for pictures in colour, not for depth"),
        ({"labels": True, "what": "segmentation"}, "labels is for pictures in colour"),
        ({"background": "chartreus"}, "background must be '#rrggbb' or a CSS colour name"),
        ({"background": "#ff000080"}, "background must be"),
        ({"eye": (1, 2, 3), "look_at": (1.0, 2.0, 3.0)}, "look_at must not be the position of the camera"),
        ({"eye": (1, 2, float("nan"))}, "eye must be within"),
        ({"camera": "wide", "focus": "cube"}, "focus is for the camera that frames the scene"),
        ({"contacts": True}, "contacts needs steps"),
        ({"legend": True}, "legend is for depth and segmentation, not for color"),
        ({"legend": True, "what": "depth", "video": "gif", "steps": 3}, "legend is for a picture, not for a video"),
        ({"shader": "minimal", "what": "normal"}, "`minimal` cannot render normals"),
        ({"view": "top", "eye": (1, 2, 3)}, "view contradicts the eye"),
        ({"view": "above"}, "view must be one of iso, front"),
        ({"camera": "wide", "view": "top"}, "view is for the camera that frames the scene"),
        ({"zoom": 0}, "zoom must be 0.1 to 100, not 0"),
        ({"zoom": float("nan")}, "zoom must be 0.1 to 100"),
        ({"preset": "stage"}, "preset must be one of studio, plain, dark"),
    ],
)
def test_a_render_argument_out_of_range_is_a_value_error(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        scenecc.render_scene(SCENE, **arguments)


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ({"focus": "cub"}, "SC910", "the scene has no entity 'cub'"),
        ({"focus": "arm/tap"}, "SC910", "the scene has no entity 'arm/tap'"),
        (
            {"size": (4000, 3000), "samples": 64},
            "SC912",
            "a picture of 4000 × 3000 pixels with 64 samples each exceeds",
        ),
        ({"size": (16384, 16384)}, "SC912", "pixels is larger than"),
    ],
)
def test_unknown_names_and_too_large_pictures_are_refused(arguments: dict[str, Any], code: str, words: str) -> None:
    with pytest.raises(scenecc.SceneError) as caught:
        scenecc.render_scene(SCENE, **arguments)
    (told,) = caught.value.diagnostics
    assert (told.code, words in told.message) == (code, True)
    if "focus" in arguments:
        assert told.hint in {"did you mean `cube`?", "did you mean `arm/tip`?"}


def test_eyes_are_read_from_the_command_line() -> None:
    import typer

    from scenecc.cli.render_options import point

    assert point("1,-0.5,2e-1") == (1, -0.5, 0.2)
    for text in ("1,2", "1,2,x", "1,2,3,4", ""):
        with pytest.raises(typer.BadParameter, match="must be X,Y,Z in metres"):
            point(text)


def test_a_missing_encoder_is_named_with_the_way_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(render, "has_encoder", lambda: False)
    with pytest.raises(scenecc.SceneError) as caught:
        scenecc.render_scene(SCENE, video="mp4", steps=3)
    (found,) = caught.value.diagnostics
    assert (found.code, found.hint) == ("SC812", install_hint("pictures"))
    assert found.message == "an MP4 video needs imageio-ffmpeg, which is not installed here"
    assert caught.value.at_fault == "machine"


@pytest.mark.render
def test_a_failing_renderer_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    from scenecc.backends.sapien import cameras

    def failing(*_: object) -> None:
        raise RuntimeError("vk::Device::allocateMemory: ErrorOutOfDeviceMemory")

    monkeypatch.setattr(cameras, "read_picture", failing)
    with pytest.raises(scenecc.SceneError) as caught:
        scenecc.render_scene(SCENE, camera="wide")
    (told,) = caught.value.diagnostics
    assert told.code == "SC814"
    assert "ErrorOutOfDeviceMemory" in told.message


def test_a_plan_for_one_camera_has_no_other() -> None:
    plan = scenecc.compile_scene(SCENE)
    wide, _ = plan.cameras
    assert restrict_to_camera(plan, wide, collision=False).cameras == (wide,)
    assert restrict_to_camera(plan, None, collision=False).cameras == ()
    assert restrict_to_camera(plan, None, collision=False).entities == plan.entities


def test_a_plan_for_collision_pictures_has_no_visuals() -> None:
    plan = scenecc.compile_scene(SCENE)
    bare = restrict_to_camera(plan, None, collision=True)
    for before, after in zip(plan.entities, bare.entities, strict=True):
        assert [body.collisions for body in after.bodies] == [body.collisions for body in before.bodies]
        for body in after.bodies:
            assert (body.visuals, body.visibility, body.shading_mode) == ((), None, None)
    assert isinstance(bare.entities[1].structures[0], ArticulationStructure)


def test_a_camera_of_another_size_keeps_its_angle_and_scales_its_matrix() -> None:
    wide, matrix = scenecc.compile_scene(SCENE).cameras
    larger = resize_camera(wide, 640, 100)
    assert (larger.width, larger.height, larger.lens) == (640, 100, wide.lens)
    assert isinstance(larger.lens, Perspective)
    lens = resize_camera(matrix, 200, 240).lens
    assert isinstance(lens, Intrinsic)
    found = [np.asarray(value.data).tolist() for value in (lens.fx, lens.fy, lens.cx, lens.cy, lens.skew)]
    assert found == [[200.0], [330.0], [100.0], [90.0, 120.0], [2.0]]
    assert resize_camera(matrix, 100, 80) == matrix
