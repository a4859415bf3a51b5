"""Distances between convex parts: by hand, and by coal where it is installed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from scenecc.placing.bodies import Part, matrices
from scenecc.placing.distances import Cores, are_apart, distances
from scenecc.placing.pairs import core_pairs

KINDS = ("box", "sphere", "capsule", "cylinder", "hull")
CLOUD = np.random.default_rng(4).normal(size=(20, 3)) * 0.05


def cores(kind: np.ndarray, size: np.ndarray, q: np.ndarray, p: np.ndarray) -> Cores:
    half = np.where((kind == 0)[:, None], size, 0.0)
    lying = (kind == 2) | (kind == 3)
    half[lying, 0] = size[lying, 0]
    disk = np.where(kind == 3, size[:, 1], 0.0)
    margin = np.where(kind == 1, size[:, 0], np.where(kind == 2, size[:, 1], 0.0))
    return Cores(
        half, disk, margin, matrices(q), p, np.where(kind == 4, 0, -1), np.ones((len(kind), 3)), (CLOUD,)
    )  # fmt: skip


def some(count: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    chance = np.random.default_rng(seed)
    q = chance.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    return chance.integers(0, 5, count), chance.uniform(0.02, 0.1, (count, 3)), q, chance.uniform(-0.2, 0.2, (count, 3))


def one(kind: str, size: Any, p: Any, q: Any = (1, 0, 0, 0)) -> Cores:
    given = (np.array([item], np.float64) for item in (size, q, p))
    return cores(np.array([KINDS.index(kind)]), *given)


@pytest.mark.parametrize(
    ("a", "b", "distance"),
    [
        (one("sphere", [0.1, 0, 0], [0, 0, 0]), one("sphere", [0.2, 0, 0], [0.5, 0, 0]), 0.2),
        (one("box", [0.1, 0.1, 0.1], [0, 0, 0]), one("box", [0.1, 0.1, 0.1], [0.3, 0.3, 0]), np.sqrt(0.02)),
        (one("box", [0.1, 0.1, 0.1], [0, 0, 0]), one("sphere", [0.05, 0, 0], [0, 0, 0.3]), 0.15),
        (one("cylinder", [0.1, 0.05, 0], [0, 0, 0]), one("cylinder", [0.1, 0.05, 0], [0, 0.3, 0]), 0.2),
        (one("capsule", [0.1, 0.05, 0], [0, 0, 0]), one("capsule", [0.1, 0.05, 0], [0.35, 0, 0]), 0.05),
        (one("box", [0.1, 0.1, 0.1], [0, 0, 0]), one("box", [0.1, 0.1, 0.1], [0.05, 0, 0]), 0.0),
    ],
)
def test_known_distances_are_computed(a: Cores, b: Cores, distance: float) -> None:
    assert distances(a, b)[0] == pytest.approx(distance, abs=1e-7)
    assert are_apart(a, b, np.array([distance - 1e-5]))[0] == (distance > 0)
    assert not are_apart(a, b, np.array([distance + 1e-5]))[0]


@pytest.mark.parametrize("of", ["any", "boxes", "upright boxes"])
def test_are_apart_agrees_with_the_distance(of: str) -> None:
    rows = [some(2000, seed) for seed in (1, 2)]
    for kind, _, q, _ in rows:
        if of != "any":
            kind[:] = 0
        if of == "upright boxes":
            q[:, 1:3] = 0
            q[:] = q / np.linalg.norm(q, axis=1)[:, None]
    a, b = (cores(*row) for row in rows)
    found = distances(a, b)
    for least in (0.001, 0.01, 0.1):
        clear = np.abs(found - least) > 1e-6
        assert (are_apart(a, b, np.full(2000, least)) == (found >= least))[clear].all()


def test_distances_agree_with_coal() -> None:
    coal = pytest.importorskip("coal")
    mine, theirs = some(500, 3), some(500, 4)
    found = distances(cores(*mine), cores(*theirs))
    points = coal.StdVec_Vec3s()
    points.extend(list(CLOUD))
    hull = coal.Convex.convexHull(points, True, "Qt")
    upright = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], float)
    made: Any = {
        0: lambda s: coal.Box(*(2 * s)),
        1: lambda s: coal.Sphere(s[0]),
        2: lambda s: coal.Capsule(s[1], 2 * s[0]),
        3: lambda s: coal.Cylinder(s[1], 2 * s[0]),
        4: lambda _s: hull,
    }
    for row in range(500):
        pair: list[Any] = []
        for kind, size, q, p in (mine, theirs):
            turn = matrices(q[row : row + 1])[0] @ (upright if kind[row] in (2, 3) else np.eye(3))
            pair += [made[int(kind[row])](size[row]), coal.Transform3s(turn, p[row])]
        judged = coal.distance(*pair, coal.DistanceRequest(), coal.DistanceResult())
        assert max(judged, 0.0) == pytest.approx(found[row], abs=1e-5)


def test_the_distance_of_a_distant_mesh_is_that_of_its_hull() -> None:
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    count = 300
    _, _, q, p = some(count, 7)
    zero, one_ = np.zeros(count), np.ones((count, 3))

    def part(turn: np.ndarray, at: np.ndarray, triangles: np.ndarray | None) -> Part:
        return Part(
            np.ones(count, bool), np.zeros((count, 3)), zero, zero, one_, corners, turn, at,
            np.full(count, 0.1), np.ones((count, 4), np.int64), triangles=triangles,
        )  # fmt: skip

    still = np.broadcast_to(np.eye(3), (count, 3, 3))
    at = np.zeros((count, 3))
    rows = np.arange(count)
    hulls = distances(part(still, at, None).cores(rows), part(matrices(q), p, None).cores(rows))
    for first, second in ((None, faces), (faces, None), (faces, faces)):
        pair, a, b = core_pairs(part(still, at, first), rows, part(matrices(q), p, second), rows, 1.0)
        nearest = np.full(count, np.inf)
        np.minimum.at(nearest, pair, distances(a, b))
        apart = hulls > 0
        assert apart.sum() > 200
        assert np.allclose(nearest[apart], hulls[apart], atol=1e-7)
