"""Contacts and forces of a loaded scene by the names of the plan, against ManiSkill's own figures."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from maniskill.test_articulations import DOOR
from plugins.maniskill_scenes import new_scene

import scenecc

if TYPE_CHECKING:
    from scenecc.maniskill import LoadedScene

SCENE = {
    "scenecc": 1,
    "entities": {
        "floor": {"body_type": "static", "shapes": [{"type": "plane"}]},
        "cube": {"pose": [0.3, 0, 0.019], "shapes": [{"type": "box", "half_size": [0.02, 0.02, 0.02]}]},
        "door": {**DOOR, "pose": [0, 0, 0.43]},
    },
}


@pytest.fixture
def loaded() -> LoadedScene:
    scene = new_scene(2)
    found: Any = scenecc.load_scene(SCENE, scene=scene)
    for _ in range(5):
        for each in scene.sub_scenes:
            each.step()
    return found


def test_a_batch_and_an_environment_say_the_same(loaded: LoadedScene) -> None:
    physics = {"contact_offset": 0.02, "solver_position_iterations": 15, "timestep": 0.01}
    material = {"static_friction": 0.3, "dynamic_friction": 0.3, "restitution": 0}
    document = {**SCENE, "physics": {**physics, "default_material": material}}
    with scenecc.load_scene(document, num_scenes=2, render=False) as batch:
        batch.step(5)
        for ours, theirs in zip(batch.contacts(), loaded.contacts(), strict=True):
            assert (ours == theirs).all()
        for name in ("cube", "door", "door/frame"):
            assert (batch.net_contact_force(name) == loaded.net_contact_force(name)).all()
    assert {"floor", "door/panel"} <= set(loaded.contacts("cube").b)


def test_maniskill_gives_the_same_force(loaded: LoadedScene) -> None:
    theirs = loaded.actors["cube"].get_net_contact_forces().numpy()
    ours = loaded.net_contact_force("cube")
    assert ours[0] == pytest.approx(theirs[0], rel=1e-5)
    assert ours[0, 2] > 0
    assert np.isfinite(ours).all()


def test_contacts_of_unknown_names_are_refused_in_an_environment(
    loaded: LoadedScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(KeyError, match=r"no link 'pannel' of 'door'; did you mean `panel`"):
        loaded.contacts("door/pannel")
    with pytest.raises(KeyError, match=r"no actor 'cub'; did you mean `cube`"):
        loaded.actors["cub"]
    monkeypatch.setattr(loaded, "scene", SimpleNamespace(gpu_sim_enabled=True))
    for read in (loaded.contacts, lambda: loaded.net_contact_force("cube")):
        with pytest.raises(RuntimeError, match="on a GPU: use get_net_contact_forces"):
            read()
