"""Rotations and poses of many scenes are those of the scalar code, row by row and bit by bit."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scenecc.geometry import rotation_arrays as arrays
from scenecc.geometry import rotations as scalar

NUMBERS = st.one_of(st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, math.pi]), st.floats(-100, 100, allow_subnormal=False))
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS)
DIRECTIONS = VECTORS.filter(lambda v: math.hypot(*v) > 1e-3)
QUATERNIONS = st.one_of(
    st.sampled_from([(1.0, 0.0, 0.0, 0.0), (-1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (1.0, 0.0, -0.0, 0.0)]),
    st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS).filter(lambda q: math.hypot(*q) > 1e-3).map(scalar.normalized),
)
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
POSES = st.tuples(VECTORS, QUATERNIONS).map(lambda parts: (*parts[0], *parts[1]))


def assert_same(one: Callable[..., Any], many: Callable[..., Any], rows: list[tuple[Any, ...]]) -> None:
    columns = [np.array(column, dtype=np.float64) for column in zip(*rows, strict=True)]
    found = many(*columns)
    expected = np.array([one(*row) for row in rows], dtype=np.float64)
    assert found.shape == expected.shape
    assert found.tobytes() == expected.tobytes(), (found, expected)


def rows(*columns: st.SearchStrategy[Any]) -> st.SearchStrategy[list[tuple[Any, ...]]]:
    return st.lists(st.tuples(*columns), min_size=1, max_size=6)


@given(rows(QUATERNIONS, QUATERNIONS))
def test_batched_products_equal_single_products(cases: list[Any]) -> None:
    assert_same(scalar.multiply_quaternions, arrays.multiply_quaternions, cases)


@given(rows(QUATERNIONS, VECTORS))
def test_batched_rotated_vectors_equal_single_ones(cases: list[Any]) -> None:
    assert_same(scalar.rotate, arrays.rotate, cases)
    assert_same(scalar.normalized, arrays.normalized, [(q,) for q, _ in cases])


@given(rows(VECTORS))
def test_batched_rpy_rotations_equal_single_ones(cases: list[Any]) -> None:
    assert_same(lambda angles: scalar.from_rpy(*angles), arrays.from_rpy, cases)


@given(rows(DIRECTIONS, NUMBERS))
def test_batched_axis_angle_rotations_equal_single_ones(cases: list[Any]) -> None:
    assert_same(scalar.from_axis_angle, arrays.from_axis_angle, cases)


@given(rows(st.one_of(DIRECTIONS, st.tuples(st.sampled_from([-1.0, 1.0]), *[st.floats(-1e-9, 1e-9)] * 2))))
def test_batched_shortest_rotations_equal_single_ones(cases: list[Any]) -> None:
    assert_same(scalar.shortest_from_x, arrays.shortest_from_x, cases)


@given(rows(QUATERNIONS.map(lambda q: tuple(zip(*(scalar.rotate(q, axis) for axis in AXES), strict=True)))))
def test_batched_rotations_of_matrices_equal_single_ones(cases: list[Any]) -> None:
    assert_same(scalar.from_matrix, arrays.from_matrix, cases)


@given(rows(VECTORS))
def test_batched_looking_equals_single_looking(cases: list[Any]) -> None:
    found, known = arrays.looking(np.array([row[0] for row in cases]))
    for q, found_one, (forward,) in zip(found, known.tolist(), cases, strict=True):
        expected = scalar.looking(forward)
        assert (expected is not None) == found_one
        assert expected is None or q.tobytes() == np.array(expected).tobytes()


@given(rows(POSES, POSES))
def test_batched_composed_poses_equal_single_ones(cases: list[Any]) -> None:
    assert_same(scalar.compose, arrays.compose, cases)


@given(rows(POSES, QUATERNIONS, st.one_of(st.just((0.0, 0.0, 0.0)), VECTORS)))
def test_batched_turned_poses_equal_single_ones(cases: list[Any]) -> None:
    assert_same(scalar.turned, arrays.turned, cases)


@given(rows(POSES, st.floats(-0.1, 0.1)))
def test_batched_rigidity_equals_single_rigidity(cases: list[Any]) -> None:
    matrices: list[Any] = []
    for pose, off in cases:
        axes = zip(*(scalar.rotate(pose[3:], axis) for axis in AXES), strict=True)
        matrices.append([*([*row, p * (1 + off)] for row, p in zip(axes, pose[:3], strict=True)), [0.0, 0.0, off, 1.0]])
    expected = [scalar.rigidity(matrix) for matrix in matrices]
    np.testing.assert_allclose(arrays.rigidity(np.array(matrices)), expected, rtol=1e-12, atol=1e-14)


@given(st.lists(st.tuples(*[st.floats(-7, 7)] * 3), min_size=1, max_size=20))
def test_rpy_rotations_equal_those_of_transforms3d(cases: list[tuple[float, float, float]]) -> None:
    """With a negative w and with -0.0 where these have them: SAPIEN comes with `transforms3d`."""
    euler: Any = importlib.import_module("transforms3d.euler")
    turns = np.array(cases)
    expected = np.array([euler.euler2quat(*angles) for angles in cases])
    # Sums in another order: the last bit of a float64 may differ, which float32 does not see.
    np.testing.assert_allclose(arrays.from_rpy(turns), expected, rtol=0, atol=1e-15)
    yaws = turns * (0, 0, 1)
    expected = np.array([euler.euler2quat(*angles) for angles in yaws.tolist()])
    assert arrays.from_rpy(yaws).tobytes() == expected.tobytes()
