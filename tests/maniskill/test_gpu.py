"""Environments that share a simulation on a GPU."""

from __future__ import annotations

from typing import Any

import pytest

pytestmark = pytest.mark.gpu

SCENE = {
    "scenecc": 1,
    "entities": {
        "ground": {"body_type": "static", "shapes": [{"type": "plane"}]},
        "panda": {
            "urdf": "pkg://mani_skill/assets/robots/panda/panda_v2.urdf",
            "pose": [-0.615, 0, 0],
            "qpos": [{"uniform": [-0.1, 0.1]}, 0.4, 0, -2, 0, 2.4, 0.8, 0.04, 0.04],
        },
        "cube": {
            "shapes": [{"type": "box", "half_size": [0.02, 0.02, 0.02]}],
            "pose": {"p": [{"uniform": [-0.1, 0.1]}, 0, 0.02]},
            "linear_velocity": [0, 0, {"uniform": [0.1, 0.2]}],
        },
        "thing": {
            "variants": [
                {"shapes": [{"type": "box", "half_size": [0.02, 0.02, 0.02]}]},
                {"shapes": [{"type": "sphere", "radius": 0.03}]},
            ],
            "pick": {"cycle": [0, 1]},
            "pose": [0.3, 0, 0.03],
        },
    },
}


def make(num_envs: int, source: Any = SCENE) -> Any:
    import gymnasium

    from scenecc.maniskill import register_env

    register_env("OnGpu-v0", source, override=True)
    return gymnasium.make("OnGpu-v0", num_envs=num_envs, sim_backend="physx_cuda", render_backend="none").unwrapped


def starts(env: Any) -> Any:
    import torch

    objects = env.scene_builder
    cube, arm = objects.scene_objects["cube"], objects.articulations["panda"]
    return torch.hstack([cube.pose.raw_pose, cube.linear_velocity, arm.qpos]).cpu()


def test_partial_resets_on_a_gpu_change_no_other_environment() -> None:
    import torch

    env = make(4)
    env.reset(seed=0)
    for _ in range(5):
        env.step(None)
    before = starts(env)
    env.reset(options={"env_idx": torch.tensor([1, 3], device=env.device)})
    after = starts(env)
    assert (after[[0, 2]] == before[[0, 2]]).all()
    assert (after[[1, 3]] != before[[1, 3]]).any(dim=1).all()


def test_resets_on_a_gpu_repeat_by_their_seed() -> None:
    env = make(4)
    env.reset(seed=5)
    first = starts(env)
    assert len({float(x) for x in first[:, 0]}) == 4
    for _ in range(5):
        env.step(None)
    env.reset(seed=5)
    assert (starts(env) == first).all()


def test_shapes_that_differ_are_one_view_and_planes_are_built_once() -> None:
    env = make(4)
    assert env.scene_builder.scene_objects["thing"].merged
    assert not env.scene_builder.scene_objects["ground"].merged
    ground = env.scene.actors["ground"]
    assert [len(body.collision_shapes) for body in ground._bodies] == [1, 0, 0, 0]
    assert list(env.get_state_dict()["actors"]) == ["cube", "thing"]


def test_planes_that_differ_are_refused_on_a_gpu() -> None:
    from scenecc import SceneError

    plane = {"body_type": "static", "shapes": [{"type": "plane"}], "pose": [0, 0, {"uniform": [-0.1, 0]}]}
    with pytest.raises(SceneError, match="differs between environments"):
        make(2, {"scenecc": 1, "entities": {"ground": plane}})


def test_a_build_on_a_gpu_is_audited(monkeypatch: pytest.MonkeyPatch) -> None:
    """Masses and places of actors, before there are buffers; links are not where they belong until then."""
    from scenecc import SceneError
    from scenecc.backends.maniskill import build
    from scenecc.plan import Mount

    build_constraints = build.ConstraintSet

    def lightened(plan: Any, lookup: Any) -> Any:
        lookup.component(Mount("cube"), 2).mass = 0.5
        lookup.component(Mount("panda", "panda_hand"), 1).mass = 0.25
        return build_constraints(plan, lookup)

    monkeypatch.setattr(build, "ConstraintSet", lightened)
    with pytest.raises(SceneError) as caught:
        make(4)
    messages = [d.message for d in caught.value.diagnostics if d.code == "SC802"]
    assert len(messages) == 2
    assert messages[0].startswith("'cube' in scene 2: the engine holds mass = 0.5")
    assert messages[1].startswith("link 'panda_hand' of 'panda' in scene 1: the engine holds mass = 0.25")
