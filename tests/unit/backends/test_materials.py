"""Physical materials, of which PhysX numbers so many in a process: SAPIEN ends by a signal on one more."""

from __future__ import annotations

import gc
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import sapien

import scenecc
from scenecc.backends.sapien import assets

_CHILD = """
import scenecc

def load(num_scenes, shapes):
    drawn = {"physical": {"static_friction": {"uniform": [0.5, 1]}, "dynamic_friction": 0.2, "restitution": 0}}
    shape = {"repeat": {"i": {"count": shapes}}, "type": "sphere", "radius": 0.1, "material": drawn}
    source = {"scenecc": 1, "entities": {"post": {"body_type": "static", "shapes": [shape]}}}
    return scenecc.load_scene(source, num_scenes=num_scenes, render=False, audit=False)

batch = load(302, 217)  # 65 534 in all
print(len(batch))
try:
    load(1, 1)
except scenecc.SceneError as error:
    print(error.diagnostics[0].message)
batch.close()
del batch
print(len(load(1, 1)))
"""


def test_materials_up_to_the_limit_of_physx_are_built() -> None:
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", _CHILD], check=False, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    refused = "these scenes need 1 physical materials besides 65534 of other batches, and a process can hold 65534"
    assert done.stdout.splitlines() == ["302", refused, "1"]


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A process that holds a hundred."""
    gc.collect()
    monkeypatch.setattr(assets, "MATERIAL_LIMIT", 100 + len(assets._live_materials))
    gc.disable()
    yield
    gc.enable()


def load(num_scenes: int, entities: int, **keys: Any) -> scenecc.SceneBatch:
    """Entities whose shapes have two materials: one drawn, one not."""
    drawn = {"physical": {"static_friction": {"uniform": [0.5, 1]}, "dynamic_friction": 0.2, "restitution": 0}}
    shapes = [{"type": "sphere", "radius": 0.1, "material": material} for material in (drawn, "ice")]
    bodies = {f"body_{number}": {"shapes": shapes} for number in range(entities)}
    ice = {"physical": {"static_friction": 0, "dynamic_friction": 0, "restitution": 0}}
    source = {"scenecc": 1, "num_scenes": num_scenes, "materials": {"ice": ice}, "entities": bodies, **keys}
    return scenecc.load_scene(source, render=False)


_DEFAULT = {"default_material": {"static_friction": 1, "dynamic_friction": 1, "restitution": 0}}


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize(("num_scenes", "keys", "count"), [(33, {"physics": _DEFAULT}, 101), (40, {}, 121)])
def test_one_material_too_many_is_refused_with_the_count(num_scenes: int, keys: dict[str, Any], count: int) -> None:
    load(33, 3).close()
    with pytest.raises(scenecc.SceneError) as caught:
        load(num_scenes, 3, **keys)
    (found,) = caught.value.diagnostics
    assert found.message.startswith(f"these scenes need {count} physical materials")
    assert (found.code, found.path, caught.value.at_fault) == ("SC821", "entities.body_2", "machine")
    load(33, 3).close()


@pytest.mark.usefixtures("few")
def test_dropped_batches_free_their_materials() -> None:
    for _ in range(5):
        assert len(load(20, 3)) == 20, "61 each, and none is closed"


def sliders(num_scenes: int, friction: Any) -> scenecc.SceneBatch:
    """Two boxes that slide on a floor. Dynamic friction follows."""
    surface = {"physical": {"static_friction": "${mu}", "dynamic_friction": "${mu * 0.5}", "restitution": 0}}
    box = {"shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1], "material": surface}], "linear_velocity": [2, 0, 0]}
    entities = {
        "floor": {"body_type": "static", "shapes": [{"type": "plane"}]},
        "a": {**box, "pose": [0, 0, 0.1]},
        "b": {**box, "pose": [0, 1, 0.1]},
    }
    source = {"scenecc": 1, "num_scenes": num_scenes, "draws": {"mu": friction}, "entities": entities}
    return scenecc.load_scene(source, render=False)


def track(batch: scenecc.SceneBatch) -> list[Any]:
    found: list[Any] = []
    for _ in range(30):
        for scene in batch.scenes:
            scene.step()
        found.append([batch.entities[name].pose.copy() for name in ("a", "b")])
    return found


def test_drawn_materials_with_few_values_are_shared_to_the_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    few = {"choice": [0.2, 0.4, 0.6, 0.8]}
    gc.collect()
    before = len(assets._live_materials)
    shared = sliders(12, few)
    assert len(assets._live_materials) - before <= 4
    monkeypatch.setattr(assets, "drawn_combinations", lambda *_: None)
    own = sliders(12, few)
    assert np.array_equal(track(shared), track(own))
    for batch in (shared, own):
        batch.reset(seed=5, scene_idxs=[1, 3, 8])
    assert shared.state() == own.state()
    assert np.array_equal(track(shared), track(own))
    assert len(set(shared.drawn()["mu"].tolist())) > 1


def test_a_shared_material_that_a_reset_changes_stays_that_of_other_scenes() -> None:
    batch = sliders(4, {"choice": [0.5, 0.25]})

    def friction() -> list[float]:
        bodies = batch.entities["a"].objs
        found: list[Any] = [body.find_component_by_type(sapien.physx.PhysxRigidDynamicComponent) for body in bodies]
        return [one.collision_shapes[0].physical_material.static_friction for one in found]

    batch.reset(draws={"mu": [0.5] * 4})
    batch.reset(draws={"mu": [0.25, 0.125]}, scene_idxs=[0, 2])
    assert friction() == [0.25, 0.5, 0.125, 0.5]
    state = batch.state()
    batch.reset(seed=3)
    batch.set_state(state)
    assert friction() == [0.25, 0.5, 0.125, 0.5]


def test_validate_warns_of_materials_that_no_process_can_hold() -> None:
    def told(friction: Any) -> list[tuple[str, str]]:
        surface = {"physical": {"static_friction": friction, "dynamic_friction": 0.1, "restitution": 0}}
        shapes = [{"type": "sphere", "radius": 0.1, "material": surface}]
        bodies = {f"body_{number}": {"shapes": shapes, "pose": [number, 0, 0]} for number in range(20)}
        found = scenecc.validate({"scenecc": 1, "num_scenes": 4096, "entities": bodies})
        return [(one.code, one.message) for one in found]

    message = "4096 scenes need 81920 physical materials, and a process can hold 65534"
    assert told({"uniform": [0.5, 1]}) == [("SC586", message)]
    assert told({"choice": [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1]}) == []
