"""Forms that an instance in some scenes only gives to its prefab."""

from __future__ import annotations

from scenecc import validate


def test_what_has_no_place_beside_a_list_by_scene_is_told() -> None:
    form = {"per_scene": [0.1, 0.2], "weights": [1, 2], "radius": 1}
    entity = {"use": "scenecc:cube", "scene_idxs": [0, 2], "with": {"half_size": form}}
    found = validate({"scenecc": 1, "num_scenes": 3, "entities": {"a": entity}})
    assert [(one.code, one.path) for one in found] == [
        ("SC117", "entities.a.with.half_size.weights"),
        ("SC117", "entities.a.with.half_size.radius"),
    ]
