"""Several environments: who has what, under which names, and what is one view."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from plugins.maniskill_scenes import new_scene
from plugins.trajectory import first_difference, trajectory

import scenecc
from scenecc import SceneError
from scenecc.decompiler.reading import read_scene
from scenecc.decompiler.verify import differences

CUBE = {"shapes": [{"type": "box", "half_size": [0.02, 0.02, 0.02]}], "pose": [0, 0, 1]}


def load(entities: dict[str, Any], num_envs: int = 3, **options: Any) -> Any:
    return scenecc.load_scene({"scenecc": 1, "entities": entities}, scene=new_scene(num_envs), **options)


def test_every_environment_has_its_row_of_the_plan() -> None:
    cube = {**CUBE, "pose": {"p": [{"uniform": [-1, 1]}, 0, 1]}, "density": {"per_scene": [100, 200, 300]}}
    loaded = load({"cube": cube}, seed=4)
    entities = [scene.entities[0] for scene in loaded.scene.sub_scenes]
    assert [entity.name for entity in entities] == ["scene-0_cube", "scene-1_cube", "scene-2_cube"]
    wanted = loaded.plan.entities[0].pose.data.astype(np.float32)
    assert len({float(x) for x in wanted[:, 0]}) == 3
    assert (loaded.actors["cube"].pose.raw_pose.numpy() == wanted).all()
    assert np.allclose(loaded.actors["cube"].mass, [0.0064, 0.0128, 0.0192])


def test_an_environment_is_what_bare_sapien_builds_of_its_scene() -> None:
    """Whatever ManiSkill's builder does in between: but for its names and settings, nothing differs."""
    physics = {
        "contact_offset": 0.02,
        "solver_position_iterations": 15,
        "default_material": {"static_friction": 0.3, "dynamic_friction": 0.3, "restitution": 0},
        "timestep": 0.01,
        "cpu_workers": 0,
    }
    cube = {**CUBE, "pose": {"p": [{"uniform": [-1, 1]}, 0, {"uniform": [0.1, 0.3]}], "rpy": [20, 30, 0]}}
    entities = {"ground": {"body_type": "static", "shapes": [{"type": "plane"}]}, "cube": cube}
    document = {"scenecc": 1, "num_scenes": 3, "physics": physics, "entities": entities}
    loaded = scenecc.load_scene(document, scene=new_scene(3))
    with scenecc.load_scene(document, render=False) as batch:
        for index, (ours, bare) in enumerate(zip(loaded.scene.sub_scenes, batch.scenes, strict=True)):
            for entity in ours.entities:
                entity.name = entity.name.removeprefix(f"scene-{index}_")
            assert differences(read_scene(bare), read_scene(ours)) == []
            assert first_difference(trajectory(bare, 200), trajectory(ours, 200)) is None


def test_an_object_of_some_environments_is_only_in_these() -> None:
    loaded = load({"cube": CUBE, "other": {**CUBE, "scene_idxs": [0, 2]}})
    assert [[entity.name for entity in scene.entities] for scene in loaded.scene.sub_scenes] == [
        ["scene-0_cube", "scene-0_other"],
        ["scene-1_cube"],
        ["scene-2_cube", "scene-2_other"],
    ]
    assert loaded.actors["other"]._scene_idxs.tolist() == [0, 2]


VARIANTS = {"variants": [{"shapes": CUBE["shapes"]}, {"shapes": [{"type": "sphere", "radius": 0.03}]}]}


@pytest.mark.parametrize(
    "entity",
    [
        {**VARIANTS, "pick": {"cycle": [0, 1, 0]}, "pose": [0, 0, 1]},
        {"shapes": [{"type": "sphere", "radius": {"per_scene": [0.1, 0.2, 0.3]}}], "pose": [0, 0, 1]},
    ],
    ids=["variants", "sizes"],
)
def test_an_actor_with_different_shapes_is_one_merged_view_in_scene_order(entity: dict[str, Any]) -> None:
    loaded = load({"thing": entity})
    actor, scene = loaded.actors["thing"], loaded.scene
    assert actor.merged
    assert actor is scene.actor_views["thing"]
    assert actor.name == "thing"
    assert [each.name for each in actor._objs] == ["scene-0_thing", "scene-1_thing", "scene-2_thing"]
    assert actor._scene_idxs.tolist() == [0, 1, 2]
    with pytest.raises(AssertionError, match="merged"):
        actor.get_first_collision_mesh()
    # Its bodies are in the state once, under the one name.
    assert list(scene.state_dict_registry.actors) == ["thing"]
    assert list(scene.actors) == ["thing"]


def test_an_actor_with_equal_shapes_is_not_a_merged_view() -> None:
    loaded = load({"cube": CUBE})
    assert not loaded.actors["cube"].merged
    assert loaded.actors["cube"] is loaded.scene.actors["cube"]
    assert not loaded.scene.actor_views


def test_variants_of_several_types_are_refused() -> None:
    variants = [{"shapes": CUBE["shapes"]}, {"shapes": CUBE["shapes"], "body_type": "static"}]
    with pytest.raises(SceneError, match="have different body types: dynamic and static") as caught:
        load({"thing": {"variants": variants, "pick": {"cycle": [0, 1]}}})
    assert [d.code for d in caught.value.diagnostics] == ["SC811"]


def test_static_visuals_are_actors_but_not_in_the_state() -> None:
    sign = {"body_type": "none", "visuals": [{"type": "sphere", "radius": 0.1}], "pose": [0, 0, 2]}
    loaded = load({"sign": sign, "cube": CUBE}, num_envs=1)
    assert loaded.actors["sign"].px_body_type == "static"
    assert loaded.actors["sign"].pose.p.tolist() == [[0, 0, 2]]
    assert list(loaded.scene.get_sim_state()["actors"]) == ["cube"]
    loaded.initialize(seed=1)


def test_the_process_keeps_the_settings_of_the_environment() -> None:
    from sapien import physx

    scene = new_scene()
    before = physx.get_sdf_config().spacing
    document = {"scenecc": 1, "physics": {"sdf": {"spacing": 0.02}}, "entities": {"cube": CUBE}}
    scenecc.load_scene(document, scene=scene)
    assert physx.get_sdf_config().spacing == before
    assert physx.get_shape_config().contact_offset == pytest.approx(0.02)
