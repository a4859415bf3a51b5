"""Poses in single precision against SAPIEN's own, bit by bit."""

from __future__ import annotations

import numpy as np
import pytest
import sapien
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from scenecc.geometry.rotations import Pose7
from scenecc.robots.poses import compose_poses, pose_numbers, pose_of_matrix

COUNT = 100_000


def bits(pose: Pose7 | sapien.Pose) -> tuple[int, ...]:
    """The bits of seven numbers, which tell the zeros apart."""
    values = (*pose.p, *pose.q) if isinstance(pose, sapien.Pose) else pose
    return tuple(np.asarray(values, np.float32).view(np.uint32).tolist())


def rotations(generator: np.random.Generator, count: int) -> NDArray[np.float64]:
    """(count, 3, 3) rotation matrices: half of them all over, half of quarter turns and small ones."""
    angles = generator.uniform(-np.pi, np.pi, (count, 3))
    angles[: count // 4] = generator.integers(-2, 3, (count // 4, 3)) * (np.pi / 2)
    angles[count // 4 : count // 2] *= 10.0 ** generator.uniform(-8, 0, (count // 2 - count // 4, 1))
    (c3, c2, c1), (s3, s2, s1) = np.cos(angles).T, np.sin(angles).T
    rows = (
        (c1 * c2, c1 * s2 * s3 - c3 * s1, s1 * s3 + c1 * c3 * s2),
        (c2 * s1, c1 * c3 + s1 * s2 * s3, c3 * s1 * s2 - c1 * s3),
        (-s2, c2 * s3, c2 * c3),
    )
    return np.array(rows).transpose(2, 0, 1)


@pytest.fixture(scope="module")
def matrices() -> NDArray[np.float64]:
    """(COUNT, 4, 4)."""
    generator = np.random.default_rng(7)
    made = np.tile(np.eye(4), (COUNT, 1, 1))
    made[:, :3, :3] = rotations(generator, COUNT)
    made[:, :3, 3] = generator.normal(size=(COUNT, 3)) * 10.0 ** generator.integers(-4, 4, (COUNT, 1))
    generator.shuffle(made)
    return made


def test_poses_of_matrices_and_their_products_have_sapiens_bits(matrices: NDArray[np.float64]) -> None:
    before, ours = sapien.Pose(), (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    for matrix in matrices:
        theirs = sapien.Pose(matrix)
        mine = pose_of_matrix(matrix)
        assert bits(mine) == bits(theirs), matrix
        assert bits(compose_poses(ours, mine)) == bits(before * theirs), matrix
        before, ours = theirs, mine


@given(
    st.lists(st.floats(-1, 1, width=32), min_size=8, max_size=8), st.lists(st.floats(-99, 99), min_size=6, max_size=6)
)
def test_products_of_any_quaternions_have_sapiens_bits(q: list[float], p: list[float]) -> None:
    first, second = (p[:3], q[:4]), (p[3:], q[4:])
    theirs = sapien.Pose(*first) * sapien.Pose(*second)
    mine = [pose_numbers((a, b, c), (w, x, y, z)) for (a, b, c), (w, x, y, z) in (first, second)]
    assert bits(compose_poses(mine[0], mine[1])) == bits(theirs)
