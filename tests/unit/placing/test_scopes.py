"""What names under `place` mean in prefabs, in overrides and where a parameter of type `entity` gives them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenecc import SceneError, ScenePlan, compile_scene

TABLE = {"body_type": "static", "shapes": [{"type": "box", "half_size": [0.2, 0.2, 0.02]}]}
BALL = [{"type": "sphere", "radius": 0.02}]
INNER = {
    "scenecc": 1,
    "params": {"target": {"type": "entity"}},
    "frames": {"corner": {"pose": [0.1, 0.1, 0]}},
    "entities": {
        "table": {**TABLE, "pose": [0, 0, 3]},
        "ball": {"place": {"on": "${target}", "at": [0, 0], "relative_to": "corner"}, "shapes": BALL},
        "own": {"place": {"on": "table", "at": [0, 0], "relative_to": "world"}, "shapes": BALL},
    },
}
MIDDLE = {
    "scenecc": 1,
    "params": {"target": {"type": "entity"}},
    "entities": {"inner": {"use": "inner.yaml", "with": {"target": "${target}"}, "pose": [0.05, 0, 0]}},
}


def built(folder: Path, instance: dict[str, Any], **others: Any) -> ScenePlan:
    (folder / "inner.yaml").write_text(repr(INNER), encoding="utf-8")
    (folder / "middle.yaml").write_text(repr(MIDDLE), encoding="utf-8")
    document = {"scenecc": 1, "entities": {"table": {**TABLE, "pose": [0, 0, 1]}, **others, "it": instance}}
    (folder / "scene.yaml").write_text(repr(document), encoding="utf-8")
    return compile_scene(folder / "scene.yaml")


def at(plan: ScenePlan, name: str) -> Any:
    return next(one for one in plan.entities if one.name == name).pose.data[0, :3]


def test_names_in_place_are_resolved_in_their_own_file(tmp_path: Path) -> None:
    plan = built(tmp_path, {"use": "middle.yaml", "with": {"target": "table"}, "pose": [0, 0.05, 0]})
    assert np.allclose(at(plan, "it/inner/ball"), [0.15, 0.15, 1.02 + 0.001 + 0.02])
    assert np.allclose(at(plan, "it/inner/own"), [0.05, 0.05, 3.02 + 0.001 + 0.02]), "its own table, and its own world"


def test_an_unknown_entity_in_place_is_reported_at_its_use(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="there is no entity `tabel`") as caught:
        built(tmp_path, {"use": "inner.yaml", "with": {"target": "tabel"}})
    assert [one.code for one in caught.value.diagnostics] == ["SC330"]


def test_names_in_an_override_of_place_are_resolved_in_its_own_file(tmp_path: Path) -> None:
    place = {"on": "plate", "at": [0, 0], "near": {"cube": [0, 5]}, "facing": "cube"}
    others = {
        "plate": {**TABLE, "pose": [0, 0, -1]},
        "cube": {"body_type": "kinematic", "pose": [0, 3, 0], "shapes": BALL},
    }
    instance = {"use": "inner.yaml", "with": {"target": "table"}, "override": {"ball": {"place": place}}}
    plan = built(tmp_path, instance, **others)
    assert np.allclose(at(plan, "it/ball"), [0.1, 0.1, -1 + 0.02 + 0.001 + 0.02])
    assert [one.near[0].entity for one in plan.placements if one.near] == ["cube"]


def test_removing_a_placement_target_is_an_error(tmp_path: Path) -> None:
    instance = {"use": "inner.yaml", "with": {"target": "table"}, "override": {"table": "remove"}}
    with pytest.raises(SceneError, match="own"):
        built(tmp_path, instance)
