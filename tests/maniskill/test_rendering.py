"""Cameras of a file as sensors, its lights, and what sensors do not see."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from plugins.maniskill_scenes import new_scene

import scenecc

CAMERAS = {
    "wide": {"width": 64, "height": 48, "fovy_deg": 90, "pose": {"p": [0, 0, 2], "rpy_deg": [0, 90, 0]}},
    "hand": {"width": 32, "height": 32, "fovy_deg": 60, "mount": "cube"},
    "render_camera": {"width": 96, "height": 64, "fovy_deg": 60, "pose": {"p": [-1, 0, 0.1]}},
}
SCENE: dict[str, Any] = {
    "scenecc": 1,
    "entities": {
        "cube": {"shapes": [{"type": "box", "half_size": [0.2, 0.2, 0.2]}], "pose": [0, 0, 0.2]},
        "goal": {
            "body_type": "kinematic",
            "hidden": True,
            "visuals": [{"type": "box", "half_size": [0.4, 0.4, 0.01]}],
            "pose": [0, 0, 1],
        },
    },
    "cameras": CAMERAS,
}


def test_cameras_are_configurations_of_sensors() -> None:
    loaded = scenecc.load_scene(SCENE, scene=new_scene())
    wide, hand, shown = loaded.sensor_configs
    assert [wide.uid, hand.uid, shown.uid] == ["wide", "hand", "render_camera"]
    assert (wide.width, wide.height) == (64, 48)
    assert wide.fov == pytest.approx(np.pi / 2)
    assert wide.mount is None
    assert hand.mount is loaded.actors["cube"]
    assert wide.pose.p.tolist() == [[0, 0, 2]]


def test_camera_values_that_differ_between_environments_are_rows() -> None:
    camera = {"width": 64, "height": 48, "fovx_deg": {"per_scene": [60, 70]}, "pose": [0, 0, {"per_scene": [1, 2]}]}
    loaded = scenecc.load_scene({**SCENE, "cameras": {"eye": camera}}, scene=new_scene(2))
    (eye,) = loaded.sensor_configs
    across = np.radians([60, 70])
    assert eye.fov == pytest.approx(2 * np.arctan(np.tan(across / 2) * 48 / 64))
    assert eye.pose.p[:, 2].tolist() == [1, 2]


@pytest.mark.render
def test_sensors_see_the_scene_without_hidden_entities() -> None:
    import gymnasium

    from scenecc.maniskill import register_env

    lit = {**SCENE, "lights": {"lamp": {"type": "point", "position": [0, 0, 3], "color": [5, 5, 5]}}}
    register_env("Seen-v0", lit, override=True)
    env = gymnasium.make("Seen-v0", obs_mode="depth", render_mode="rgb_array", render_backend="cpu")
    observation, _ = env.reset(seed=0)
    sensors = observation["sensor_data"]
    assert set(sensors) == {"wide", "hand"}
    # The camera looks down from 2 m: through the hidden goal at 1 m, to the top of the cube at 0.4 m.
    assert int(sensors["wide"]["depth"][0, 24, 32, 0]) == pytest.approx(1600, abs=2)
    plain: Any = env.unwrapped
    assert plain.scene_builder.builds_lighting
    names = [type(c).__name__ for entity in plain.scene.sub_scenes[0].entities for c in entity.components]
    assert names.count("RenderPointLightComponent") == 1
    assert "RenderDirectionalLightComponent" not in names
    assert tuple(env.render().shape) == (1, 64, 96, 3)  # pyright: ignore[reportAttributeAccessIssue, reportOptionalMemberAccess]


@pytest.mark.render
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"entities": {"cube": {**SCENE["entities"]["cube"], "hidden": True}}, "cameras": {}}, "'cube' is hidden"),
        ({"cameras": {"eye": {"width": 8, "height": 8, "orthographic": {"top": 1}}}}, "not a perspective camera"),
    ],
)
def test_unsupported_cameras_and_hidden_entities_are_refused(change: dict[str, Any], message: str) -> None:
    from scenecc.backends.maniskill.builders import unsupported_cameras

    (failure,) = unsupported_cameras(scenecc.compile_scene({**SCENE, **change}))
    assert failure.code == "SC811"
    assert message in failure.message


def test_a_camera_on_robots_whose_links_differ_is_refused_where_anything_renders_and_no_sensor_elsewhere() -> None:
    from scenecc.backends.maniskill.builders import unsupported_cameras

    robots = "pkg://mani_skill/assets/robots/panda/"
    arm = {"urdf": {"per_scene": [f"{robots}panda_v2.urdf", f"{robots}panda_stick.urdf"]}}
    cameras = {"eye": {"mount": "arm/panda_hand"}, "plain": {"pose": [0, 0, 1]}}
    scene = {"scenecc": 1, "num_scenes": 2, "entities": {"arm": arm}, "cameras": cameras}
    (failure,) = unsupported_cameras(scenecc.compile_scene(scene))
    assert failure.code == "SC811"
    assert "links differ" in failure.message
    loaded = scenecc.load_scene(scene, scene=new_scene(2))
    assert [config.uid for config in loaded.sensor_configs] == ["plain"]


def test_without_rendering_unsupported_hidden_entities_are_skipped() -> None:
    box = [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]
    cube = {**SCENE["entities"]["cube"], "hidden": True}
    entities = {**SCENE["entities"], "cube": cube, "arm": {"root": {"name": "base", "shapes": box}, "hidden": True}}
    loaded = scenecc.load_scene({"scenecc": 1, "entities": entities}, scene=new_scene())
    assert loaded.hidden_objects == [loaded.actors["goal"]]


@pytest.mark.render
def test_lights_follow_what_a_reset_draws_again() -> None:
    import gymnasium

    from scenecc.maniskill import register_env

    cube = {**SCENE["entities"]["cube"], "pose": {"p": [{"uniform": [-1, 1]}, 0, 0.2]}}
    lamp = {"type": "point", "color": [5, 5, 5], "pose": {"p": [0, 0, 1], "relative_to": "cube"}}
    document = {"scenecc": 1, "entities": {"cube": cube}, "lights": {"lamp": lamp}}
    register_env("Followed-v0", document, override=True)
    env: Any = gymnasium.make("Followed-v0", render_backend="cpu").unwrapped
    places = []
    for seed in (1, 2):
        env.reset(seed=seed)
        (light,) = [entity for entity in env.scene.sub_scenes[0].entities if entity.name == "lamp"]
        at = env.scene.actors["cube"].pose.p[0]
        assert light.pose.p == pytest.approx([float(at[0]), 0, 1.2])
        places.append(float(at[0]))
    assert places[0] != places[1]


LENSES = {
    "fovy": {"fovy_deg": {"uniform": [30, 80]}},
    "fovx": {"fovx_deg": {"uniform": [30, 80]}},
    "intrinsic": {"intrinsic": {"fx": {"uniform": [50, 90]}, "fy": {"uniform": [50, 90]}, "cx": {"uniform": [20, 40]}}},
}
DRAWN_POSE = {"p": [{"uniform": [-1, 1]}, 0, 2], "rpy_deg": [0, {"uniform": [60, 90]}, 0]}


@pytest.mark.render
@pytest.mark.parametrize("lens", LENSES)
def test_cameras_are_drawn_again_as_in_a_fresh_environment(lens: str) -> None:
    import gymnasium

    from scenecc.maniskill import register_env

    size = {"width": 64, "height": 48}
    cameras = {
        "eye": {**size, **LENSES[lens], "pose": DRAWN_POSE, "near": {"uniform": [0.01, 0.1]}},
        "hand": {**size, "mount": "cube", "pose": DRAWN_POSE},
        "render_camera": {**size, "pose": {**DRAWN_POSE, "relative_to": "cube"}, "far": {"uniform": [10, 20]}},
    }
    cube = {**SCENE["entities"]["cube"], "pose": {"p": [{"uniform": [-1, 1]}, 0, 0.2]}}
    document = {"scenecc": 1, "entities": {"cube": cube}, "cameras": cameras}
    register_env("Drawn-v0", document, override=True)

    def made(seed: int) -> Any:
        env: Any = gymnasium.make("Drawn-v0", obs_mode="rgb", render_backend="cpu").unwrapped
        env.reset(seed=seed)
        return env

    def numbers(env: Any) -> dict[str, list[float]]:
        found: dict[str, list[float]] = {}
        for name, sensor in {**env.scene.sensors, **env.scene.human_render_cameras}.items():
            params = sensor.camera
            parts = (params.get_local_pose().raw_pose, params.get_intrinsic_matrix(), params.near, params.far)
            found[name] = np.concatenate([np.ravel(part) for part in parts]).tolist()
        return found

    env = made(1)
    before = numbers(env)
    env.reset(seed=5)
    again, fresh = numbers(env), numbers(made(5))
    assert before.keys() == again.keys() == cameras.keys()
    for name, found in again.items():
        assert before[name] != found
        assert found == pytest.approx(fresh[name], rel=1e-6)
