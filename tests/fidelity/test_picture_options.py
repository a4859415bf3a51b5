"""The default light, and what is added to pictures: samples, background, ground, overlays. Needs a device."""

from __future__ import annotations

import json
import os
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
import trimesh
import trimesh.visual
from PIL import Image

from scenecc import load_scene, render_scene
from scenecc.backends.sapien import engine
from scenecc.backends.sapien.engine import ray_tracing_quality, render

pytestmark = [pytest.mark.render, pytest.mark.usefixtures("held_renderer")]

GREY = {"body_type": "kinematic", "shapes": [{"type": "box", "half_size": [0.1, 0.15, 0.2], "color": [0.5, 0.5, 0.5]}]}
FLOOR = {"body_type": "static", "shapes": [{"type": "plane"}]}
SIZE = (120, 90)


def scene(**entities: Any) -> dict[str, Any]:
    return {"scenecc": 1, "entities": entities}


def box(*rpy_deg: float, z: float = 0.2, **keys: Any) -> dict[str, Any]:
    return {**GREY, "pose": {"p": [0, 0, z], "rpy_deg": list(rpy_deg)}, **keys}


def seen(source: dict[str, Any] | Path, **choices: Any) -> np.ndarray[Any, Any]:
    """(H, W, …) of the PNG."""
    options: Any = {"size": SIZE, **choices}
    return np.asarray(Image.open(BytesIO(render_scene(source, **options).png()))).astype(int)


def shades_of_faces(source: dict[str, Any], **choices: Any) -> list[float]:
    """The middle shade of each face of the box that is seen, 0 to 255, ascending."""
    color = seen(source, samples=1, **choices)[..., 0]
    normals = np.round(render_scene(source, size=SIZE, what="normal").pictures[0].pixels, 2).reshape(-1, 3)
    faces, which, counts = np.unique(normals, axis=0, return_inverse=True, return_counts=True)
    which = which.reshape(color.shape)
    return sorted(
        float(np.median(color[which == number]))
        for number, (face, count) in enumerate(zip(faces, counts, strict=True))
        if face.any() and count >= 25
    )


@pytest.mark.parametrize("preset", [None, "studio", "plain", "dark"])
def test_the_faces_of_a_grey_box_have_different_shades(preset: Any) -> None:
    turns = [(0, 0, yaw) for yaw in (0, 20, 37, 45, 60, 82)] + [(25, 0, 70), (-15, 10, 20), (10, -20, 120)]
    several = 0
    for turn in turns:
        shades = shades_of_faces(scene(box=box(*turn)), preset=preset)
        several += len(shades) == 3
        assert len(shades) >= 2
        assert min(b - a for a, b in pairwise(shades)) >= 12, (turn, shades)
        assert shades[-1] <= 235
    assert several >= 5


def test_the_preset_plain_can_be_set_by_hand() -> None:
    eye = {"pose": {"p": [1, 0.7, 0.6], "look_at": [0, 0, 0.2]}, "width": SIZE[0], "height": SIZE[1]}
    source = {**scene(box=box(0, 0, 30)), "cameras": {"eye": eye}}
    with load_scene(source, render=True) as batch:
        pose = batch.cameras["eye"].objs[0].get_entity().get_pose()
    hand: Any = sapien.Scene()
    hand.set_ambient_light([0.24] * 3)
    for azimuth, elevation, brightness in ((-68, 49, 1.65), (30, 16, 0.04), (-170, 43, 0.3)):
        around, up = np.arctan2(0.75, 1) + np.radians(azimuth), np.radians(elevation)
        direction = [-np.cos(up) * np.cos(around), -np.cos(up) * np.sin(around), -np.sin(up)]
        hand.add_directional_light(direction, [brightness] * 3)
    builder = hand.create_actor_builder()
    material = sapien.render.RenderMaterial(base_color=[0.5, 0.5, 0.5, 1])
    builder.add_box_visual(half_size=[0.1, 0.15, 0.2], material=material)
    builder.initial_pose = sapien.Pose([0, 0, 0.2], [np.cos(np.pi / 12), 0, 0, np.sin(np.pi / 12)])
    builder.build_kinematic()
    camera = hand.add_camera("eye", *SIZE, np.radians(60), 0.01, 100)
    camera.get_entity().set_pose(pose)
    hand.update_render()
    camera.take_picture()
    color = camera.get_picture("Color")
    expected = np.where(color[..., 3:] == 0, 1, color[..., :3])
    assert np.array_equal(seen(source, camera="eye", preset="plain"), (expected.clip(0, 1) * 255).astype(int))


def test_a_cpu_that_compiles_shaders_is_told_of_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.render.render._COMPILED", set())
    monkeypatch.setattr("scenecc.backends.sapien.engine.cpu_renderer", lambda: "llvmpipe")
    told: list[str] = []
    for _ in range(2):
        seen(scene(box=box(0, 0, 0)), compiling=told.append)
    assert told == ["llvmpipe"]


def test_the_renderer_is_kept_with_its_shaders_until_the_process_forks() -> None:
    seen(scene(box=box(0, 0, 0)))
    assert engine.keep_renderer.cache_info().currsize == 1
    child = os.fork()
    if child == 0:
        os._exit(0)
    os.waitpid(child, 0)
    assert engine.keep_renderer.cache_info().currsize == 0, "a child could not use it"


def test_a_view_shows_one_side_and_a_zoom_magnifies_it() -> None:
    source = scene(box=box(0, 0, 0))
    for view, width, height in (("front", 0.3, 0.4), ("left", 0.2, 0.4), ("top", 0.3, 0.2)):
        rows, columns = np.nonzero(seen(source, what="segmentation", view=view))
        assert np.ptp(rows) / np.ptp(columns) == pytest.approx(height / width, rel=0.05), view
    eye = {"eye": (1, 0, 0.2), "what": "segmentation"}
    near, whole, far = (np.count_nonzero(seen(source, zoom=zoom, **eye)) for zoom in (1.5, 1, 0.5))
    assert (near / whole, far / whole) == pytest.approx((2.25, 0.25), rel=0.05)


def test_white_is_not_blown_out_and_the_key_light_throws_a_shadow() -> None:
    white = {**GREY, "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1], "color": [1, 1, 1]}]}
    source = scene(floor=FLOOR, box={**white, "pose": [0, 0, 0.1]})
    shades: dict[str, np.ndarray[Any, Any]] = {}
    ids = seen(source, what="segmentation")
    for preset in ("studio", "plain"):
        picture = seen(source, preset=preset, samples=1)
        assert picture.max() <= 252
        shades[preset] = picture[..., 0][ids == 1]
    assert (shades["studio"] < shades["studio"].max() - 50).mean() > 0.01, "a shadow on the floor"
    assert np.ptp(shades["plain"]) < 5, "none"


def test_a_mesh_with_a_metallic_texture_of_factor_0_shows_a_shadow(tmp_path: Path) -> None:
    plate = trimesh.creation.box([2, 2, 0.02])
    rough_metal = Image.fromarray(np.full((4, 4, 3), (0, 128, 255), np.uint8))
    material = trimesh.visual.material.PBRMaterial(metallicFactor=0.0, metallicRoughnessTexture=rough_metal)
    plate.visual = trimesh.visual.TextureVisuals(uv=np.zeros((len(plate.vertices), 2)), material=material)
    plate.export(tmp_path / "plate.glb")
    floor = {"body_type": "static", "pose": [0, 0, -0.01], "visuals": [{"type": "mesh", "file": "plate.glb"}]}
    file = tmp_path / "scene.yaml"
    file.write_text(json.dumps(scene(floor=floor, box=box(0, 0, 0))))
    ground = seen(file, samples=1)[..., 0][seen(file, what="segmentation") == 1]
    assert (ground < np.median(ground) - 50).mean() > 0.01


@pytest.mark.parametrize("half_size", [0.0005, 25.0])
def test_what_is_tiny_or_large_is_seen_and_shaded_alike(half_size: float) -> None:
    def cube(half: float) -> dict[str, Any]:
        shapes = [{"type": "box", "half_size": [half] * 3, "color": [0.5, 0.5, 0.5]}]
        return scene(floor=FLOOR, box={"shapes": shapes, "pose": [0, 0, half]})

    box_seen = seen(cube(0.1), what="segmentation") == 2
    assert (seen(cube(half_size), what="segmentation") == 2).sum() == pytest.approx(box_seen.sum(), rel=0.02)
    assert np.abs(seen(cube(half_size)) - seen(cube(0.1)))[box_seen].mean() < 2


def test_the_light_comes_from_the_side_of_the_camera() -> None:
    source = scene(box=box(0, 0, 0))
    front, back = seen(source, eye=(1.2, 0.9, 0.9)), seen(source, eye=(-1.2, -0.9, 0.9))
    assert np.abs(front - back).mean() < 1, "a box is the same from either side"


def test_samples_smooth_edges_and_leave_depth_and_the_camera_alone() -> None:
    source = scene(box=box(0, 0, 30))
    rough, smooth = seen(source, samples=1, zoom=0.5), seen(source, samples=16, zoom=0.5)
    inner = (np.abs(np.diff(rough[..., 0], axis=0)).max(), np.abs(np.diff(smooth[..., 0], axis=0)).max())
    assert inner[1] < 0.85 * inner[0]
    assert len(np.unique(smooth)) > 3 * len(np.unique(rough))
    assert np.abs(rough - smooth).mean() < 2
    for lens in ({}, {"orthographic": {"top": 0.4}}):
        eye = {"pose": {"p": [1, 0.7, 0.6], "look_at": [0, 0, 0.2]}, "width": 60, "height": 40, **lens}
        with load_scene({**source, "cameras": {"eye": eye}}, render=True) as batch:
            camera = batch.cameras["eye"]
            before = camera.capture("depth")["depth"]
            moved = camera.capture("depth", shift=(3, -2))["depth"]
            assert np.allclose(moved[0, :-2, 3:], before[0, 2:, :-3], atol=1e-3)
            assert np.array_equal(camera.capture("depth")["depth"], before)


def test_a_background_is_where_nothing_is() -> None:
    source = scene(box=box(0, 0, 30))
    assert seen(source, background="steelblue")[0, 0].tolist() == pytest.approx([70, 130, 180], abs=1)
    assert seen(source, preset="plain")[0, 0].tolist() == [255, 255, 255]
    lit = {**source, "lights": {"sun": {"type": "directional", "direction": [-1, 0, -1], "color": [3, 0, 0]}}}
    assert seen(lit)[0, 0].tolist() == [0, 0, 0], "the file's own"
    assert seen(lit)[..., 1].max() == 0
    assert seen(lit, preset="dark")[..., 1].max() > 40, "a preset stands in for the file's lights"
    picture = render_scene(lit, size=SIZE, background="white", samples=1).pictures[0].pixels
    assert (picture[0, 0] == [1, 1, 1, 0]).all()


def test_a_ground_grid_is_as_wide_as_it_says() -> None:
    source = scene(floor=FLOOR, box=box(0, 0, 0))
    choices: Any = {"eye": (0, 0, 3), "samples": 1, "size": (200, 200)}
    found = render_scene(source, ground=True, **choices)
    assert found.cell == 0.05
    changed = (seen(source, ground=True, **choices) != seen(source, **choices)).any(axis=2)
    scale = 100 / np.tan(np.radians(18)) / 3  # pixels a metre of the floor, straight down
    columns = np.arange(200)[changed[10:60].all(axis=0)]
    heavy = 100 + 0.25 * scale * np.array([-3, -2, -1, 1, 2, 3])
    assert all(np.abs(columns + 0.5 - line).min() <= 1.5 for line in heavy)
    assert not changed[90:110, 92:108].any(), "not on the box"
    assert changed[-14:, :40].any(), "the scale in the corner"


def test_contacts_and_names_are_drawn_where_things_are() -> None:
    cube = {"shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1], "color": [0.5, 0.5, 0.5]}], "pose": [0, 0, 0.1]}
    source = scene(floor=FLOOR, cube=cube)
    plain = seen(source, steps=30)
    touched = seen(source, steps=30, contacts=True)
    force = (np.abs(touched - [190, 0, 140]).max(axis=2) < 40).any(axis=1)
    middle = np.nonzero(seen(source, steps=30, what="segmentation") == 2)[0].mean()
    assert force.any()
    assert np.nonzero(force)[0].mean() < middle + 15, "up from the floor"
    for choice in ("labels", "frames"):
        assert (seen(source, steps=30, **{choice: True}) != plain).any()


def test_a_focus_fills_the_picture() -> None:
    source = scene(floor=FLOOR, large=box(0, 0, 0), small={**GREY, "shapes": CUBE, "pose": [0.5, 0.5, 0.02]})
    ids = seen(source, focus="small", what="segmentation")
    rows, columns = np.nonzero(ids == 3)
    assert 0.65 < np.ptp(rows) / SIZE[1] < 0.85
    assert abs(rows.mean() - SIZE[1] / 2) < 8
    assert abs(columns.mean() - SIZE[0] / 2) < 8


CUBE = [{"type": "box", "half_size": [0.02, 0.02, 0.02]}]


def test_a_legend_leaves_the_picture_beside_it() -> None:
    source = scene(floor=FLOOR, box=box(0, 0, 0))
    found = render_scene(source, size=SIZE, what="depth", legend=True)
    image = Image.open(BytesIO(found.png()))
    assert (image.mode, image.height) == ("RGB", SIZE[1])
    assert image.width > SIZE[0] + 40
    assert found.pictures[0].pixels.dtype == np.float32
    names = np.asarray(Image.open(BytesIO(render_scene(source, size=SIZE, what="segmentation", legend=True).png())))
    assert names[:, : SIZE[0]].reshape(-1, 3).tolist().count([0, 128, 0]) > 100
    assert [0, 128, 0] in names[:, SIZE[0] :].reshape(-1, 3).tolist()


def test_rays_are_timed_before_they_are_traced() -> None:
    told: list[float] = []
    before = render.get_ray_tracing_samples_per_pixel(), render.get_ray_tracing_denoiser()
    found = render_scene(
        scene(box=box(0, 0, 30)), size=(24, 18), shader="rt", samples=2, background="white", estimate=told.append
    )
    assert len(told) == 1
    assert 0 < told[0] < 60
    pixels = found.pictures[0].pixels
    assert pixels[0, 0].tolist() == [1, 1, 1, 0]
    assert pixels[9, 12, 3] == 1
    assert (render.get_ray_tracing_samples_per_pixel(), render.get_ray_tracing_denoiser()) == before
    with ray_tracing_quality(7, denoise=False):
        assert render.get_ray_tracing_samples_per_pixel() == 7
