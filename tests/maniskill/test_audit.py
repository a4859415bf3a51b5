"""What is built in a ManiSkill scene is compared with the plan: counts, order, poses and masses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from plugins.maniskill_scenes import new_scene

from scenecc import SceneError
from scenecc.maniskill import load_into

pytestmark = pytest.mark.quick

RING = {"type": "ring", "inner_radius": 0.05, "outer_radius": 0.1, "half_length": 0.05, "axis": "z"}
SOURCE: dict[str, Any] = {
    "scenecc": 1,
    "entities": {
        "ground": {"body_type": "static", "shapes": [{"type": "plane"}]},
        "cube": {
            "pose": [{"uniform": [-1, 1]}, 0, 1],
            "shapes": [{"type": "box", "half_size": [0.1, 0.1, {"uniform": [0.1, 0.2]}]}, RING],
        },
        "arm": {
            "pose": [3, 0, 1],
            "qpos": {"hinge": 0.5},
            "root": {
                "name": "base",
                "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}],
                "children": [
                    {
                        "name": "tip",
                        "shapes": [{"type": "sphere", "radius": 0.1}],
                        "joint": {"name": "hinge", "type": "revolute", "axis": "z", "origin": [0.3, 0, 0]},
                    }
                ],
            },
        },
    },
    "constraints": {"tie": {"type": "weld", "child": "cube", "parent": "ground", "pose_in_parent": [0, 0, 1]}},
}


def loaded(
    monkeypatch: pytest.MonkeyPatch,
    sabotage: Callable[[Any], object] = lambda _: None,
    *,
    gpu: bool = False,
    together: bool = False,
    **options: Any,
) -> list[str]:
    """What the audit reports after `sabotage` has changed the last of three sub-scenes."""
    from scenecc.backends.maniskill import build

    scene = new_scene(3)
    # Objects of the environment's own, before the plan's and after them.
    for each in scene.sub_scenes:
        each.add_entity(_entity("robot"))
    scene.gpu_sim_enabled, scene.parallel_in_single_scene = gpu, together
    scene.scene_offsets_np = np.array([[5, 0, 0], [10, 0, 0], [15, 0, 0]])
    make = build.ConstraintSet

    def constraints(plan: Any, lookup: Any) -> Any:
        made = make(plan, lookup)
        sabotage(scene.sub_scenes[0 if together else 2])
        return made

    monkeypatch.setattr(build, "ConstraintSet", constraints)
    try:
        load_into(scene, SOURCE, **options)
    except SceneError as error:
        return [d.message for d in error.diagnostics if d.code == "SC802"] or [str(error)]
    return []


def _entity(name: str) -> Any:
    import sapien

    entity = sapien.Entity()
    entity.name = name
    return entity


def find(scene: Any, name: str) -> Any:
    return next(entity for entity in scene.entities if entity.name == name)


def move(name: str) -> Callable[[Any], None]:
    def sabotage(scene: Any) -> None:
        entity = find(scene, name)
        entity.set_pose(type(entity.pose)([9, 9, 9]))

    return sabotage


def lighten(scene: Any) -> None:
    find(scene, "scene-2_cube").components[0].mass = 0.5


def lighten_link(scene: Any) -> None:
    find(scene, "tip").components[0].mass = 0.5


def reorder(scene: Any) -> None:
    ground = find(scene, "scene-2_ground")
    scene.remove_entity(ground)
    scene.add_entity(ground)


def untie(scene: Any) -> None:
    cube = find(scene, "scene-2_cube")
    cube.remove_component(cube.components[1])


CASES: dict[str, tuple[Callable[[Any], object], str]] = {
    "pose of an actor": (move("scene-2_cube"), "'cube' in scene 2: the engine holds pose = [9.0, 9.0, 9.0"),
    "pose of a link": (move("tip"), "link 'tip' of 'arm' in scene 2: the engine holds pose"),
    "mass": (lighten, "'cube' in scene 2: the engine holds mass = 0.5"),
    "mass of a link": (lighten_link, "link 'tip' of 'arm' in scene 2: the engine holds mass = 0.5"),
    "order": (reorder, "'ground' in scene 2: the engine holds entity 0 of the build order = 'scene-2_cube'"),
    "missing": (
        lambda scene: scene.remove_entity(find(scene, "scene-2_cube")),
        "the scene in scene 2: the engine holds entities in the scene = 3, but the plan asks for 4",
    ),
    "constraint": (
        untie,
        "'tie' in scene 2: the engine holds constraints of 'cube' = none, but the plan asks for 'tie'",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_the_audit_of_an_environment_reports_differences(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    sabotage, words = CASES[name]
    found = loaded(monkeypatch, sabotage)
    assert any(message.startswith(words) for message in found), found


def test_the_audit_of_an_environment_reports_nothing_for_a_good_build(monkeypatch: pytest.MonkeyPatch) -> None:
    assert loaded(monkeypatch) == []


def test_without_the_audit_of_an_environment_nothing_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    assert loaded(monkeypatch, lighten, audit=False) == []


def test_the_audit_of_an_environment_reports_a_dropped_shape(monkeypatch: pytest.MonkeyPatch) -> None:
    from scenecc.backends.sapien import builder

    attach = builder.attach_shape

    def forgetful(component: Any, shape: Any, row: int) -> None:
        if not shape.many:
            attach(component, shape, row)

    monkeypatch.setattr(builder, "attach_shape", forgetful)
    assert any("the engine holds collision_shapes = 1, but the plan asks for 33" in one for one in loaded(monkeypatch))


def test_on_a_gpu_link_poses_are_not_audited(monkeypatch: pytest.MonkeyPatch) -> None:
    """As with a simulation on a GPU: qpos is not set before there are buffers, and roots and actors are in place."""
    assert loaded(monkeypatch, gpu=True) == []
    monkeypatch.undo()
    assert loaded(monkeypatch, move("tip"), gpu=True) == []
    monkeypatch.undo()
    for name, (sabotage, words) in CASES.items():
        if name != "pose of a link":
            found = loaded(monkeypatch, sabotage, gpu=True)
            assert any(message.startswith(words) for message in found), (name, found)
            monkeypatch.undo()


def test_environments_that_are_shown_together_are_in_one_scene_and_moved_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only with a simulation on a GPU."""
    assert loaded(monkeypatch, gpu=True, together=True) == []
    monkeypatch.undo()
    (found,) = loaded(monkeypatch, lighten, gpu=True, together=True)
    assert found.startswith("'cube' in scene 2: the engine holds mass = 0.5")
