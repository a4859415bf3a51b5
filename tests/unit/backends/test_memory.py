"""Scenes that are built and closed leave no memory behind."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest

from scenecc import compile_scene, load_scene

STATM = Path("/proc/self/statm")
BOX = {"type": "box", "half_size": [0.1, 0.1, 0.1]}
DOOR = {
    "fix_root_link": True,
    "pose": [2, 0, 1],
    "root": {
        "name": "frame",
        "shapes": [BOX],
        "children": [
            {
                "name": "panel",
                "joint": {"name": "hinge", "type": "revolute", "pose_in_parent": [0.3, 0, 0]},
                "shapes": [BOX],
            }
        ],
    },
}
SCENE = {
    "scenecc": 1,
    "entities": {
        "ground": {"body_type": "static", "shapes": [{"type": "plane"}]},
        "boxes": {"repeat": {"i": {"count": 5}}, "pose": [0, 0, "${0.1 + 0.2 * i}"], "shapes": [BOX]},
        "door": DOOR,
    },
    "constraints": {"rope": {"type": "distance", "parent": "world", "child": "boxes_0", "limits": [0, 1]}},
}


@pytest.mark.skipif(not STATM.exists(), reason="the memory of a process is read from /proc")
def test_two_hundred_scenes_take_no_more_memory_than_fifty() -> None:
    """Batches that stayed would take 50 MiB and more."""
    plan = compile_scene(SCENE)
    pages = []
    for number in range(200):
        with load_scene(plan, render=False) as batch:
            batch.step(2)
        if number in {49, 199}:
            gc.collect()
            pages.append(int(STATM.read_text().split()[1]))
    assert (pages[1] - pages[0]) * 4096 < 5 * 2**20
