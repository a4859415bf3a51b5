"""The valves of ManiSkill's tasks: what their parameters change, and how their distributions draw them.

That the defaults are ManiSkill's own valves, `test_corpus.py` shows.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from plugins.expectations import ROOT

from scenecc import load_scene

FOLDER = ROOT / "scenes" / "maniskill"
GAP = np.pi / 6


def capsules(valve: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the capsules of a valve: poses (n, 7) in its frame, radii (n,) and half lengths (n,) in metres."""
    link = next(link for link in valve.links if link.name == "valve")
    shapes = link.collision_shapes
    poses = np.array([[*shape.local_pose.p, *shape.local_pose.q] for shape in shapes])
    return poses, np.array([shape.radius for shape in shapes]), np.array([shape.half_length for shape in shapes])


def angles_of(valve: Any) -> np.ndarray:
    """Where around the valve its capsules are (n,), from 0 to 2 pi."""
    poses, _, _ = capsules(valve)
    return np.arctan2(poses[:, 1], poses[:, 0]) % (2 * np.pi)


def test_parameters_replace_the_drawn_valve() -> None:
    angles = [0.5, 2.0, 4.0]
    params = {"angles": angles, "radius_scale": 1.2, "capsule_radius_scale": 0.9}
    with load_scene(FOLDER / "RotateValveLevel3-v1.yaml", params=params, render=False) as batch:
        poses, radii, halves = capsules(batch.articulations["valve_station_0"].objs[0])
    half = 1.2 * 0.061706 / 2
    expected = [[half * np.cos(a), half * np.sin(a), 0, np.cos(a / 2), 0, 0, np.sin(a / 2)] for a in angles]
    np.testing.assert_allclose(poses, expected, atol=1e-7)
    np.testing.assert_allclose(radii, 0.9 * 0.0195, rtol=1e-6)
    np.testing.assert_allclose(halves, half, rtol=1e-6)


def test_a_longer_valve_has_exact_angles() -> None:
    with load_scene(FOLDER / "RotateValveLevel3-v1.yaml", params={"radius_scale": 1.5}, render=False) as batch:
        poses, _, halves = capsules(batch.articulations["valve_station_0"].objs[0])
    np.testing.assert_allclose(np.hypot(poses[:, 0], poses[:, 1]), 1.5 * 0.061706 / 2, rtol=1e-6)
    np.testing.assert_allclose(halves, 1.5 * 0.061706 / 2, rtol=1e-6)


def test_heads_of_a_valve_are_evenly_spaced() -> None:
    with load_scene(FOLDER / "RotateValveLevel1-v1.distribution.yaml", render=False) as batch:
        for heads in (3, 4, 5):
            valves = batch.articulations[f"valve_station_{heads}"]
            assert valves.scene_idxs == tuple(range(heads - 3, 8, 3))
            for valve in valves.objs:
                np.testing.assert_allclose(angles_of(valve), np.arange(heads) * 2 * np.pi / heads, atol=1e-6)


def test_drawn_capsules_keep_their_distance() -> None:
    """As ManiSkill's: in order, each pi / 6 from the next at least, and the last so far from the whole circle."""
    with load_scene(FOLDER / "RotateValveLevel4-v1.distribution.yaml", num_scenes=60, render=False) as batch:
        for heads in (3, 4, 5):
            valves = batch.articulations[f"station_{heads}/valve_station"].objs
            found = np.array([angles_of(valve) for valve in valves])
            assert found.shape == (20, heads)
            assert np.diff(np.hstack([found, np.full((20, 1), 2 * np.pi)])).min() > GAP - 1e-5
            assert found[:, 0].min() >= 0
            assert len({tuple(each) for each in found}) == 20
            # The mean of the k-th of n angles of that distribution, within five of its standard errors.
            free = 2 * np.pi - heads * GAP
            share = np.arange(1, heads + 1) / (heads + 1)
            error = free * np.sqrt(share * (1 - share) / (heads + 2) / 20)
            assert (abs(found.mean(0) - free * share - np.arange(heads) * GAP) < 5 * error).all()
            lengths = np.array([capsules(valve)[2][0] for valve in valves])
            assert lengths.std() / lengths.mean() > 0.02
