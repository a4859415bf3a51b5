"""Where things stand by chance: as an independent sampler puts them, one after the other, each by rejection."""

from __future__ import annotations

import numpy as np

from scenecc import compile_scene

SCENES = 10_000
HALF, RADIUS, APART = np.array([0.3, 0.2]), 0.06, 0.03
COUNT = 3


def placed() -> np.ndarray:
    table = {"body_type": "static", "shapes": [{"type": "box", "half_size": [*HALF.tolist(), 0.02]}]}
    mug = {
        "place": {"on": "table", "apart": APART},
        "shapes": [{"type": "cylinder", "radius": RADIUS, "half_length": 0.05, "axis": "z"}],
    }
    entities = {"table": table, **{f"mug_{i}": mug for i in range(COUNT)}}
    plan = compile_scene({"scenecc": 1, "num_scenes": SCENES, "seed": 11, "entities": entities})
    return np.stack([entity.pose.data[:, :2] for entity in plan.entities[1:]], axis=1)


def rejected() -> np.ndarray:
    """(scenes, mugs, 2) by numpy's own generator."""
    chance = np.random.default_rng(5)
    found = np.full((SCENES, COUNT, 2), np.inf)
    for number in range(COUNT):
        left = np.arange(SCENES)
        while left.size:
            point = chance.uniform(-HALF, HALF, (len(left), 2))
            fits = (np.abs(point) <= HALF - RADIUS).all(axis=1)
            away = np.hypot(*np.moveaxis(found[left, :number] - point[:, None], 2, 0))
            fits &= (away >= 2 * RADIUS + APART).all(axis=1)
            found[left[fits], number] = point[fits]
            left = left[~fits]
    return found


def chi_squared(a: np.ndarray, b: np.ndarray, edges: list[np.ndarray]) -> tuple[float, int]:
    """Of two samples (n, d) in bins, and the degrees of freedom."""
    first, second = (np.histogramdd(one, edges)[0].ravel() for one in (a, b))
    both = first + second
    used = both > 0
    return float((((first - second) ** 2)[used] / both[used]).sum()), int(used.sum()) - 1


def test_positions_equal_those_of_sequential_rejection() -> None:
    ours, theirs = placed(), rejected()
    x, y = (np.linspace(-half, half, 11) for half in HALF - RADIUS)
    far = np.linspace(-0.5, 0.5, 13)
    for number in range(COUNT):
        statistic, freedom = chi_squared(ours[:, number], theirs[:, number], [x, y])
        assert statistic < freedom + 3.1 * np.sqrt(2 * freedom), number
        for other in range(number):
            between = [sample[:, number] - sample[:, other] for sample in (ours, theirs)]
            statistic, freedom = chi_squared(between[0], between[1], [far, far])
            assert statistic < freedom + 3.1 * np.sqrt(2 * freedom), (number, other)
    # The test can fail: against mugs that ignore one another it does.
    shuffled = np.stack([ours[:, 1], np.roll(ours[:, 0], 1, axis=0)], axis=1)
    statistic, freedom = chi_squared(shuffled[:, 0] - shuffled[:, 1], ours[:, 1] - ours[:, 0], [far, far])
    assert statistic > freedom + 10 * np.sqrt(2 * freedom)
