"""Lights, surroundings and cameras against hand-written SAPIEN, and pictures pixel for pixel. Needs a device."""

from __future__ import annotations

import struct
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
import sapien

import scenecc
from scenecc.backends.sapien import cameras
from scenecc.backends.sapien.cameras import shader_folder
from scenecc.backends.sapien.engine import summary_has_ray_tracing, supports_ray_tracing

if TYPE_CHECKING:
    from collections.abc import Sequence

pytestmark = [pytest.mark.render, pytest.mark.usefixtures("held_renderer")]

ASSETS = Path(__file__).parents[1] / "scenes" / "good" / "assets"
LIGHT = ("color", "shadow", "shadow_near", "shadow_far", "shadow_map_size", "name")
CAMERA = ("width", "height", "near", "far", "fovx", "fovy", "fx", "fy", "cx", "cy", "skew", "mode", "name")
BOX = {"shapes": [{"type": "box", "half_size": [0.1, 0.2, 0.3]}]}
DARK = {"ambient_light": [0, 0, 0]}


def load(entities: dict[str, Any], **sections: Any) -> scenecc.SceneBatch:
    return scenecc.load_scene({"scenecc": 1, "entities": entities, **sections}, render=True)


def same(ours: Any, theirs: Any, *names: str) -> None:
    for name in names:
        assert np.array_equal(getattr(ours, name), getattr(theirs, name)), name


def same_pose(ours: sapien.Pose, theirs: sapien.Pose, tolerance: float = 0.0) -> None:
    assert np.array_equal(ours.p, theirs.p)
    # SAPIEN turns to a direction in single precision.
    assert np.abs(np.subtract(ours.q, theirs.q)).max() <= tolerance


DIRECTION, POSITION, COLOR = [0.3, -0.2, -1], [0.5, 1, 2], [2, 1, 0.5]
SHADOW = {"shadow": True, "shadow_near": 0.2, "shadow_far": 7, "shadow_map_size": 512}
CASES = [
    ({"type": "point", "position": POSITION}, lambda s: s.add_point_light(POSITION, COLOR)),
    (
        {"type": "point", "position": POSITION, **SHADOW},
        lambda s: s.add_point_light(POSITION, COLOR, True, 0.2, 7, 512),
    ),
    ({"type": "directional", "direction": DIRECTION}, lambda s: s.add_directional_light(DIRECTION, COLOR)),
    (
        {"type": "directional", "direction": DIRECTION, "position": POSITION, "shadow_scale": 3, **SHADOW},
        lambda s: s.add_directional_light(DIRECTION, COLOR, True, POSITION, 3, 0.2, 7, 512),
    ),
    (
        {"type": "spot", "position": POSITION, "direction": DIRECTION, "inner_fov": 0.4, "outer_fov_deg": 40, **SHADOW},
        lambda s: s.add_spot_light(POSITION, DIRECTION, 0.4, radians(40), COLOR, True, 0.2, 7, 512),
    ),
    (
        {"type": "area", "pose": {"p": POSITION, "q": [0.5, 0.5, 0.5, 0.5]}, "half_width": 0.5, "half_height": 0.3},
        lambda s: s.add_area_light_for_ray_tracing(sapien.Pose(POSITION, [0.5] * 4), COLOR, 0.5, 0.3),
    ),
]
OF_TYPE = {
    "directional": ("shadow_half_size",),
    "spot": ("inner_fov", "outer_fov"),
    "area": ("half_width", "half_height"),
}


@pytest.mark.parametrize(("light", "add"), CASES, ids=lambda item: item["type"] if isinstance(item, dict) else "")
def test_a_light_is_what_sapien_adds(light: dict[str, Any], add: Any) -> None:
    scene = sapien.Scene()
    theirs = add(scene)
    theirs.name = "lamp"
    with load({"box": BOX}, lights={"lamp": {**light, "color": COLOR}}) as batch:
        (ours,) = batch.lights["lamp"].objs
        assert type(ours) is type(theirs)
        same(ours, theirs, *LIGHT, *OF_TYPE.get(light["type"], ()))
        same_pose(ours.get_entity().get_pose(), theirs.get_entity().get_pose(), 1e-7)
        same_pose(ours.local_pose, theirs.local_pose)
        assert np.array_equal(batch.scenes[0].ambient_light, [0, 0, 0])
        assert [light.name for light in batch.scenes[0].render_system.lights] == ["lamp"]


def test_a_textured_light_throws_its_picture() -> None:
    film = {"type": "textured", "pose": [0, 0, 1], "color": COLOR, "inner_fov": 0.4, "outer_fov": 0.6}
    film["texture"] = {"file": str(ASSETS / "checker.png"), "filter_mode": "nearest"}
    document = {"scenecc": 1, "entities": {"box": BOX}, "lights": {"film": film}}
    with scenecc.load_scene(document, render=True, allow_outside_assets=True) as batch:
        (light,) = batch.lights["film"].objs
        assert type(light) is sapien.render.RenderTexturedLightComponent
        assert Path(light.texture.filename) == ASSETS / "checker.png"
        assert light.texture.filter_mode == "nearest"
        assert np.allclose([light.inner_fov, light.outer_fov], [0.4, 0.6])


def with_a_box(scene: sapien.Scene) -> sapien.Scene:
    """Adds a box that stands on the origin."""
    builder = scene.create_actor_builder()
    builder.add_box_visual(half_size=(0.1, 0.2, 0.3))
    builder.build_kinematic("box")
    return scene


def test_a_textured_light_is_seen_as_one_made_by_hand() -> None:
    """From above, so that the light falls on what is seen."""
    place, down = [0.1, 0, 2], [0.5**0.5, 0, 0.5**0.5, 0]
    scene = with_a_box(sapien.Scene())
    light = sapien.render.RenderTexturedLightComponent()
    light.set_color(COLOR)
    light.inner_fov, light.outer_fov = 0.2, 0.4
    light.shadow, light.shadow_near, light.shadow_far, light.shadow_map_size = True, 0.2, 7, 512
    light.texture = sapien.render.RenderTexture2D(str(ASSETS / "checker.png"))
    entity = sapien.Entity()
    entity.add_component(light)
    entity.set_pose(sapien.Pose(place, down))
    scene.add_entity(entity)
    camera = scene.add_camera("eye", 32, 24, radians(60), 0.01, 100)
    camera.get_entity().set_pose(sapien.Pose([0, 0, 1], down))
    scene.update_render()
    camera.take_picture()
    film = {"type": "textured", "pose": {"p": place, "q": down}, "color": COLOR, "inner_fov": 0.2, "outer_fov": 0.4}
    document = {
        "scenecc": 1,
        "entities": {"box": {"body_type": "kinematic", "visuals": BOX["shapes"]}},
        "lights": {"film": {**film, **SHADOW, "texture": str(ASSETS / "checker.png")}},
        "cameras": {"eye": {"pose": {"p": [0, 0, 1], "q": down}, "width": 32, "height": 24}},
    }
    with scenecc.load_scene(document, render=True, allow_outside_assets=True) as batch:
        found = batch.cameras["eye"].capture("color")["color"][0]
    assert np.array_equal(found, camera.get_picture("Color"))
    lit = found[..., :3].sum(axis=2)
    # A checkerboard in light: bright squares and dark ones.
    assert lit.max() > 3 * lit[lit > 0].min()


def test_rays_are_traced_as_by_hand() -> None:
    if not supports_ray_tracing():
        pytest.skip("the render device cannot trace rays")
    scene = with_a_box(sapien.Scene())
    scene.set_ambient_light([0.1, 0.2, 0.3])
    scene.add_area_light_for_ray_tracing(sapien.Pose([-2, 0, 0]), COLOR, 0.5, 0.3)
    theirs = sapien.render.RenderCameraComponent(16, 12, shader_folder("rt"))
    theirs.set_fovy(radians(60))
    theirs.near, theirs.far = 0.01, 100
    entity = sapien.Entity()
    entity.add_component(theirs)
    entity.set_pose(sapien.Pose([-1, 0, 0]))
    scene.add_entity(entity)
    scene.update_render()
    theirs.take_picture()
    light = {"type": "area", "pose": [-2, 0, 0], "color": COLOR, "half_width": 0.5, "half_height": 0.3}
    camera = {"pose": [-1, 0, 0], "width": 16, "height": 12, "shader": "rt"}
    box = {"body_type": "kinematic", "visuals": BOX["shapes"]}
    lit = {"environment": {"ambient_light": [0.1, 0.2, 0.3]}, "lights": {"panel": light}}
    with load({"box": box}, cameras={"eye": camera}, **lit) as batch:
        found = batch.cameras["eye"].capture()
    ids = theirs.get_picture("Segmentation")[..., 1:2]
    there = ids > 0
    assert there.any()
    assert np.array_equal(found["segmentation"][0], ids)
    position = theirs.get_picture("Position")[..., :3]
    assert np.array_equal(found["position"][0], np.where(there, position, 0))
    assert np.abs(found["depth"][0][6, 8] - 0.9).max() <= 1e-3
    assert np.array_equal(found["color"][0], theirs.get_picture("Color"))


def test_a_device_that_traces_no_rays_is_told_from_a_mistake(monkeypatch: pytest.MonkeyPatch) -> None:
    """SAPIEN writes a line to its log there, and crashes with the first picture."""
    monkeypatch.setattr(cameras, "supports_ray_tracing", lambda: False)
    with pytest.raises(scenecc.SceneError) as caught:
        load({"box": BOX}, cameras={"eye": {"shader": "rt"}})
    (found,) = caught.value.diagnostics
    assert (found.code, found.path) == ("SC807", "cameras.eye.shader")
    assert found.message == "'eye' needs ray tracing, which the render device does not support"
    with load({"box": BOX}, cameras={"eye": {"shader": "minimal"}}) as batch:
        assert len(batch.cameras["eye"].objs) == 1


def test_the_device_is_found_in_the_summary_of_devices() -> None:
    name = sapien.render.RenderSystem().device.name
    assert f"GPU: {name}\n" in sapien.render.get_device_summary()
    two = "GPU: Old\n  Supported: 1\n  rayTrace:  0\nGPU: New\n  Supported: 1\n  rayTrace:  1\n"
    assert [summary_has_ray_tracing(two, name) for name in ("Old", "New", "Other")] == [False, True, True]


LENSES = [
    ({"fovy": 0.8}, lambda c: c.set_fovy(0.8)),
    ({"fovx_deg": 70}, lambda c: c.set_fovx(radians(70))),
    ({}, lambda c: c.set_fovy(radians(60))),
    (
        {"intrinsic": {"fx": 50, "fy": 60, "cx": 30, "cy": 20, "skew": 0.5}},
        lambda c: c.set_perspective_parameters(0.02, 9, 50, 60, 30, 20, 0.5),
    ),
    ({"intrinsic": {"fx": 50, "fy": 60}}, lambda c: c.set_perspective_parameters(0.02, 9, 50, 60, 32, 24, 0)),
    (
        {"orthographic": {"top": 1.5}},
        lambda c: c.set_orthographic_parameters(0.02, 9, -1.5 * 64 / 48, 1.5 * 64 / 48, -1.5, 1.5),
    ),
]
POSE = {"p": [-2, 0.1, 0.4], "q": [0.9, 0.1, 0.3, -0.3]}
POSE["q"] = (np.array(POSE["q"]) / np.linalg.norm(POSE["q"])).tolist()


@pytest.mark.parametrize(("lens", "aim"), LENSES, ids=[next(iter(lens), "default") for lens, _ in LENSES])
def test_a_camera_sees_what_one_made_by_hand_sees(lens: dict[str, Any], aim: Any) -> None:
    scene = sapien.Scene()
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=(0.1, 0.2, 0.3))
    builder.add_box_visual(half_size=(0.1, 0.2, 0.3))
    builder.build("box")
    scene.set_ambient_light([0.1, 0.2, 0.3])
    scene.add_point_light([-1, 1, 1], [3, 2, 1], shadow=True)
    theirs = sapien.render.RenderCameraComponent(64, 48)
    theirs.near, theirs.far = 0.02, 9
    aim(theirs)
    theirs.name = "eye"
    entity = sapien.Entity()
    entity.add_component(theirs)
    entity.set_pose(sapien.Pose(POSE["p"], POSE["q"]))
    scene.add_entity(entity)
    aim(theirs)  # SAPIEN forgets what an orthographic camera sees when it comes into a scene
    lights = {"lamp": {"type": "point", "position": [-1, 1, 1], "color": [3, 2, 1], "shadow": True}}
    camera = {"pose": POSE, "width": 64, "height": 48, "near": 0.02, "far": 9, **lens}
    environment = {"ambient_light": [0.1, 0.2, 0.3]}
    with load({"box": BOX}, lights=lights, environment=environment, cameras={"eye": camera}) as batch:
        (ours,) = batch.cameras["eye"].objs
        same(ours, theirs, *(name for name in CAMERA if theirs.mode == "perspective" or name[0] != "f"))
        assert np.array_equal(ours.get_projection_matrix(), theirs.get_projection_matrix())
        assert np.array_equal(ours.get_model_matrix(), theirs.get_model_matrix())
        found = batch.cameras["eye"].capture([*scenecc_pictures(), "Normal", "Segmentation"])
        scene.update_render()
        theirs.take_picture()
        assert np.array_equal(found["color"][0], theirs.get_picture("Color"))
        assert np.array_equal(found["Normal"][0], theirs.get_picture("Normal"))
        # The third number counts the shapes that were made in the process so far.
        assert np.array_equal(found["Segmentation"][0, ..., :2], theirs.get_picture("Segmentation")[..., :2])
        assert np.array_equal(found["position"][0], theirs.get_picture("Position")[..., :3])
        assert np.array_equal(found["depth"][0, ..., 0], -theirs.get_picture("Position")[..., 2])
        assert np.array_equal(found["segmentation"][0, ..., 0], theirs.get_picture("Segmentation")[..., 1])
        assert (found["segmentation"] > 0).any()


def scenecc_pictures() -> tuple[str, ...]:
    return ("color", "depth", "segmentation", "position")


def test_pictures_are_of_the_geometry() -> None:
    """A box a metre before the camera, and a ball behind it that stands out to the left."""
    entities = {
        "box": {"body_type": "static", "pose": [1.1, 0, 0], **BOX},
        "ball": {"body_type": "static", "pose": [3, 1, 0], "shapes": [{"type": "sphere", "radius": 0.5}]},
    }
    camera = {"width": 65, "height": 49, "fovy_deg": 60}
    with load(entities, cameras={"eye": camera}) as batch:
        eye = batch.cameras["eye"]
        found = eye.capture()
        assert {name: (array.shape, array.dtype.name) for name, array in found.items()} == {
            "color": ((1, 49, 65, 4), "float32"),
            "depth": ((1, 49, 65, 1), "float32"),
            "segmentation": ((1, 49, 65, 1), "int32"),
            "position": ((1, 49, 65, 3), "float32"),
        }
        names = eye.names(0)
        ids = found["segmentation"][0, ..., 0]
        assert names[ids[24, 32]] == "box"
        assert found["depth"][0, 24, 32, 0] == pytest.approx(1.0, abs=1e-5)
        # x right, y up, z backwards; left in the picture is +y of the camera.
        assert {names[one] for one in np.unique(ids[:, :28]) if one} == {"box", "ball"}
        assert {names[one] for one in np.unique(ids[:, 40:]) if one} <= {"box"}
        world = found["position"][0] @ eye.objs[0].get_model_matrix()[:3, :3].T + eye.objs[0].get_model_matrix()[:3, 3]
        ball = world[ids == next(key for key, name in names.items() if name == "ball")]
        assert np.abs(np.linalg.norm(ball - [3, 1, 0], axis=1) - 0.5).max() < 1e-2
        nothing = ids == 0
        assert nothing.any()
        assert not found["depth"][0][nothing].any()
        assert not found["position"][0][nothing].any()


def pictures_by_hand(distances: Sequence[float], width: int, height: int) -> list[dict[str, Any]]:
    """What a camera at the origin sees of a box before it under two lights, at one distance after the other."""
    scene = sapien.Scene()
    builder = scene.create_actor_builder()
    builder.add_box_visual(half_size=(0.1, 0.2, 0.3))
    box = builder.build_kinematic("box")
    scene.set_ambient_light([0.3, 0.3, 0.3])
    scene.add_directional_light([1, 1, -1], [1, 1, 1])
    scene.add_directional_light([0, 0, -1], [1, 1, 1])
    camera = scene.add_camera("eye", width, height, radians(60), 0.01, 100)
    found: list[dict[str, Any]] = []
    for distance in distances:
        box.set_pose(sapien.Pose([distance, 0, 0]))
        scene.update_render()
        camera.take_picture()
        position = camera.get_picture("Position")[..., :3]
        ids = camera.get_picture("Segmentation")[..., 1:2]
        pictures = {"color": camera.get_picture("Color"), "depth": 0 - position[..., 2:], "segmentation": ids}
        found.append({**pictures, "position": position})
    return found


def test_each_scene_is_seen_by_its_own_camera() -> None:
    document = {
        "scenecc": 1,
        "num_scenes": 3,
        "entities": {"box": {"body_type": "static", "pose": [{"per_scene": [1, 2, 3]}, 0, 0], **BOX}},
        "cameras": {"eye": {"width": 33, "height": 25, "scene_idxs": [0, 2]}, "all": {"width": 33, "height": 25}},
        "environment": {"ambient_light": [0.3, 0.3, 0.3]},
        "lights": {
            "sun": {"type": "directional", "direction": [1, 1, -1], "color": [1, 1, 1]},
            "top": {"type": "directional", "direction": [0, 0, -1], "color": [1, 1, 1]},
        },
    }
    by_hand = pictures_by_hand([1, 2, 3], 33, 25)
    # A millimetre is what is promised; how a device interpolates between corners is its own affair.
    for picture, depth in zip(by_hand, (0.9, 1.9, 2.9), strict=True):
        assert picture["depth"][12, 16, 0] == pytest.approx(depth, abs=1e-3)
    with scenecc.load_scene(document, render=True) as batch:
        eye = batch.cameras["eye"]
        assert eye.scene_idxs == (0, 2)
        for name, scene_idxs, seen in (
            ("eye", None, (0, 2)),
            ("eye", [2], (2,)),
            ("all", [2, 1], (2, 1)),
        ):
            found = batch.cameras[name].capture(scene_idxs=scene_idxs)
            assert set(found) == set(by_hand[0])
            for kind, pictures in found.items():
                assert np.array_equal(pictures, [by_hand[index][kind] for index in seen]), (name, scene_idxs, kind)
        with pytest.raises(KeyError, match="is not in scene 1"):
            eye.capture("depth", [1])
        with pytest.raises(ValueError, match="no picture 'colour'; did you mean `color`"):
            eye.capture("colour")


def test_what_is_mounted_moves_along() -> None:
    camera = {"mount": "cart", "pose": {"p": [0.2, 0, 0.1]}, "width": 33, "height": 25}
    lamp = {"type": "spot", "mount": "cart", "direction": [1, 0, 0], "inner_fov": 1, "outer_fov": 1, "color": [1, 1, 1]}
    cart = {"body_type": "kinematic", "pose": [1, 2, 3], **BOX}
    with load({"cart": cart}, lights={"lamp": lamp}, cameras={"eye": camera}) as batch:
        (body,), (eye,), (light,) = batch.entities["cart"].objs, batch.cameras["eye"].objs, batch.lights["lamp"].objs
        assert eye.get_entity() == body == light.get_entity()
        assert np.array_equal(eye.local_pose.p, np.array([0.2, 0, 0.1], np.float32))
        assert np.allclose(eye.global_pose.p, [1.2, 2, 3.1])
        batch.entities["cart"].set_pose([5, 0, 0, 1, 0, 0, 0])
        assert np.allclose(eye.global_pose.p, [5.2, 0, 0.1])
        batch.remove("cart")
        with pytest.raises(RuntimeError, match="is not in scene 0 now"):
            batch.cameras["eye"].capture("depth")


def test_a_reset_draws_what_a_camera_follows_and_its_own() -> None:
    document = {
        "scenecc": 1,
        "num_scenes": 2,
        "entities": {"box": {"pose": {"p": {"uniform": [[0, 0, 1], [9, 9, 9]]}}, **BOX}},
        "cameras": {
            "eye": {
                "pose": {"p": {"uniform": [[-2, 0, 0], [-1, 0, 0]]}, "relative_to": "box"},
                "width": 8,
                "height": 8,
            },
            "free": {"pose": {"p": {"uniform": [[-2, 0, 0], [-1, 0, 0]]}}, "width": 8, "height": 8},
        },
    }
    with scenecc.load_scene(document, seed=1, render=True) as batch:

        def places(name: str) -> Any:
            return np.array([obj.get_entity().get_pose().p for obj in batch.cameras[name].objs])

        fresh = scenecc.load_scene(document, seed=2, render=True)
        wanted = [
            np.array([obj.get_entity().get_pose().p for obj in fresh.cameras[name].objs]) for name in ("eye", "free")
        ]
        boxes, eyes, free = batch.entities["box"].pose[:, :3], places("eye"), places("free")
        assert np.allclose((eyes - boxes)[:, 1:], 0, atol=1e-6)
        batch.reset(seed=2)
        moved = batch.entities["box"].pose[:, :3]
        assert (moved != boxes).any(axis=1).all()
        assert np.array_equal(places("eye"), wanted[0])
        assert np.array_equal(places("free"), wanted[1])
        assert not np.array_equal(places("free"), free)
        batch.reset(seed=1, scene_idxs=[1])
        assert np.allclose(places("eye")[1], eyes[1], atol=1e-6)
        assert not np.allclose(places("eye")[0], eyes[0])


def test_sensors_do_not_see_what_is_hidden() -> None:
    goal = {"hidden": True, "body_type": "kinematic", "pose": [1, 0, 0], "visuals": [{"type": "sphere", "radius": 0.2}]}
    with load({"goal": goal}, cameras={"eye": {"width": 33, "height": 25}}) as batch:
        eye = batch.cameras["eye"]
        assert not eye.capture("segmentation")["segmentation"].any()
        seen = sapien.render.RenderBodyComponent
        (body,) = [one for one in batch.entities["goal"].objs[0].components if isinstance(one, seen)]
        assert body.visibility == 1
        assert eye.capture("segmentation", human=True)["segmentation"][0, 12, 16, 0] == 1


def test_a_file_without_lights_and_cameras_is_lit_and_framed() -> None:
    entities = {
        "ground": {"use": "scenecc:ground", "prefix": ""},
        "a": {"pose": [3, 1, 0.3], **BOX},
        "b": {"pose": [4, 1, 0.3], **BOX},
    }
    with load(entities) as batch:
        scene = batch.scenes[0]
        assert len(scene.render_system.cameras) == 0
        assert scene.render_system.lights == []
        found = batch.cameras["default"].capture(["color", "segmentation"])
        names = batch.cameras["default"].names(0)
        ids = found["segmentation"][0, ..., 0]
        assert found["color"].shape == (1, 480, 640, 4)
        for name in ("a", "b"):
            rows, columns = np.nonzero(ids == next(key for key, one in names.items() if one == name))
            assert len(rows) > 500
            assert 0 < rows.min() <= rows.max() < 479
            assert 0 < columns.min() <= columns.max() < 639
            assert found["color"][0, rows, columns, :3].mean() > 0.2
        assert scene.ambient_light.any()
        for _ in range(2):
            assert len(scene.render_system.cameras) == 1
            assert [light.shadow for light in scene.render_system.lights] == [True, False, False]
            batch.cameras["default"].capture("color")


def test_a_light_that_was_added_by_hand_is_enough_to_have_no_other() -> None:
    with load({"box": BOX}) as batch:
        batch.scenes[0].add_point_light([0, 0, 1], [1, 1, 1])
        batch.cameras["default"].capture("color")
        assert len(batch.scenes[0].render_system.lights) == 1
        assert not batch.scenes[0].ambient_light.any()


def test_one_light_or_ambient_light_is_enough_to_have_no_other() -> None:
    with load({"box": BOX}, environment=DARK) as batch:
        batch.cameras["default"].capture("color")
        assert batch.scenes[0].render_system.lights == []
        assert np.array_equal(batch.scenes[0].ambient_light, [0, 0, 0])


def bmp(pixels: np.ndarray) -> bytes:
    """An image (H, W, 3), W a multiple of 4."""
    height, width, _ = pixels.shape
    head = struct.pack("<2sIHHI", b"BM", 54 + pixels.size, 0, 0, 54)
    return head + struct.pack("<IiiHHIIiiII", 40, width, height, 1, 24, 0, pixels.size, 0, 0, 0, 0) + pixels.tobytes()


@pytest.mark.parametrize("six", [False, True])
def test_the_surroundings_are_seen(six: bool, tmp_path: Path) -> None:
    file = str(ASSETS / "checker.png")
    if not six:
        file = str(tmp_path / "sky.bmp")
        pixels = np.zeros((32, 64, 3), np.uint8)
        pixels[:, :, 0], pixels[:, :, 1] = np.arange(64) * 4, np.arange(32)[:, None] * 8
        Path(file).write_bytes(bmp(pixels))
    scene = sapien.Scene()
    if six:
        scene.set_environment_map_from_files(*[file] * 6)
    else:
        scene.set_environment_map(file)
    theirs = scene.add_camera("eye", 32, 24, radians(60), 0.01, 100)
    scene.update_render()
    theirs.take_picture()
    map_ = dict.fromkeys(("px", "nx", "py", "ny", "pz", "nz"), file) if six else file
    document = {"scenecc": 1, "environment": {"map": map_}, "cameras": {"eye": {"width": 32, "height": 24}}}
    with scenecc.load_scene(document, render=True, allow_outside_assets=True) as batch:
        found = batch.cameras["eye"].capture("color")["color"][0]
    assert found[..., :3].any()
    assert np.array_equal(found, theirs.get_picture("Color"))


@pytest.mark.parametrize("shader", ["minimal", "trivial"])
def test_a_shader_pack_gives_the_same_places(shader: str) -> None:
    entities = {"box": {"body_type": "static", "pose": [1.1, 0, 0], **BOX}}
    cameras = {name: {"width": 32, "height": 24, "shader": name} for name in ("default", shader)}
    with load(entities, cameras=cameras) as batch:
        found = [batch.cameras[name].capture(["depth", "segmentation", "position"]) for name in cameras]
        assert np.array_equal(found[0]["segmentation"], found[1]["segmentation"])
        assert np.abs(found[0]["depth"] - found[1]["depth"]).max() <= 1e-3
        assert np.abs(found[0]["position"] - found[1]["position"]).max() <= 1e-3
