"""Rotations against independent references: trimesh's transformations in float64, SAPIEN's own in float32."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
import sapien
from hypothesis import assume, example, given
from hypothesis import strategies as st
from trimesh import transformations

from scenecc.geometry import rotations

ANGLES = st.floats(-10, 10)
COMPONENTS = st.floats(-100, 100, allow_subnormal=False)
VECTORS = st.tuples(COMPONENTS, COMPONENTS, COMPONENTS)
QUARTERS = (-math.pi, -math.pi / 2, 0.0, math.pi / 2, math.pi)


def unit(v: Any) -> Any:
    return np.asarray(v) / np.linalg.norm(v)


def matrix(q: Any) -> np.ndarray:
    return transformations.quaternion_matrix(q)[:3, :3]


def assert_same_rotation(q: Any, reference: Any, tolerance: float = 1e-12) -> None:
    """Equal up to the sign, which means the same rotation."""
    q, reference = np.asarray(q), np.asarray(reference)
    assert min(np.abs(q - reference).max(), np.abs(q + reference).max()) <= tolerance, (q, reference)


@st.composite
def quaternions(draw: st.DrawFn) -> tuple[float, ...]:
    q = draw(st.tuples(COMPONENTS, COMPONENTS, COMPONENTS, COMPONENTS))
    assume(np.linalg.norm(q) > 1e-3)
    return tuple(unit(q))


@given(ANGLES, ANGLES, ANGLES)
def test_rpy_turns_about_fixed_axes(roll: float, pitch: float, yaw: float) -> None:
    q = rotations.from_rpy(roll, pitch, yaw)
    assert_same_rotation(q, transformations.quaternion_from_euler(roll, pitch, yaw, "sxyz"))
    pose = sapien.Pose()
    pose.set_rpy([roll, pitch, yaw])
    assert_same_rotation(q, pose.q, 1e-5)


@pytest.mark.parametrize("angles", list(itertools.product(QUARTERS, repeat=3)))
def test_from_rpy_at_quarter_turns(angles: tuple[float, float, float]) -> None:
    assert_same_rotation(rotations.from_rpy(*angles), transformations.quaternion_from_euler(*angles, "sxyz"))


@given(quaternions())
@example((0.5**0.5, 0.0, -(0.5**0.5), 0.0))
@example((0.5, 0.5, 0.5, -0.5))
@example((0.6532815, 0.27059805, 0.6532815, -0.27059805))
def test_rpy_and_back(q: Any) -> None:
    roll, pitch, yaw = rotations.to_rpy(q)
    assert_same_rotation(rotations.from_rpy(roll, pitch, yaw), q, 1e-6)
    assert roll == 0 or abs(pitch) < math.pi / 2


@given(VECTORS, ANGLES)
def test_from_axis_angle(axis: tuple[float, float, float], angle: float) -> None:
    assume(np.linalg.norm(axis) > 1e-3)
    reference = transformations.quaternion_about_axis(angle, unit(axis))
    assert_same_rotation(rotations.from_axis_angle(axis, angle), reference, 1e-9)


@given(quaternions(), quaternions())
def test_multiply_is_the_hamilton_product(a: Any, b: Any) -> None:
    np.testing.assert_allclose(
        rotations.multiply_quaternions(a, b), transformations.quaternion_multiply(a, b), atol=1e-12
    )


@given(quaternions(), VECTORS)
def test_rotate_turns_a_vector(q: Any, v: Any) -> None:
    np.testing.assert_allclose(rotations.rotate(q, v), matrix(q) @ v, atol=1e-9)


@given(quaternions())
@example((0.0, 1.0, 0.0, 0.0))
@example((0.0, 0.0, 1.0, 0.0))
@example((0.0, 0.0, 0.0, 1.0))
@example((0.5, 0.5, 0.5, 0.5))
@example((0.5, -0.5, 0.5, -0.5))
def test_matrix_to_quaternion_and_back(q: Any) -> None:
    assert_same_rotation(rotations.from_matrix(matrix(q).tolist()), q, 1e-9)


@pytest.mark.parametrize("largest", range(4))
@pytest.mark.parametrize("sign", [1, -1])
def test_each_branch_of_the_matrix_step(largest: int, sign: int) -> None:
    q = np.full(4, 0.1)
    q[largest] = sign
    q = unit(q)
    found = rotations.from_matrix(matrix(q).tolist())
    assert int(np.argmax(np.abs(found))) == largest
    assert found[largest] > 0
    assert_same_rotation(found, q)


@given(VECTORS)
@example((1.0, 0.0, 0.0))
@example((-1.0, 0.0, 0.0))
@example((-1.0, 1e-9, 0.0))
@example((0.0, 0.0, -5.0))
def test_shortest_from_x(target: Any) -> None:
    assume(np.linalg.norm(target) > 1e-3)
    q = rotations.shortest_from_x(target)
    assert abs(np.linalg.norm(q) - 1) < 1e-12
    np.testing.assert_allclose(rotations.rotate(q, (1, 0, 0)), unit(target), atol=1e-7)
    # The shortest: about an axis across x and the target, by the angle between them.
    assert abs(q[1]) < 1e-12
    assert abs(2 * math.acos(min(1.0, abs(q[0]))) - math.acos(np.clip(unit(target)[0], -1, 1))) < 1e-6


@given(VECTORS)
def test_shortest_from_x_is_sapiens(target: Any) -> None:
    direction = unit(target) if np.linalg.norm(target) > 1e-3 else np.array([0, 0, 1])
    # Near the opposite direction single precision cannot tell one of the many shortest turns.
    assume(direction[0] > -0.99)
    shortest: Any = sapien.math.shortest_rotation  # its stub asks for shapes that no array has a type for
    theirs = shortest([1, 0, 0], direction)
    assert_same_rotation(rotations.shortest_from_x(tuple(direction)), theirs, 1e-3)


@pytest.mark.parametrize("target", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (-2.0, 0.0, 0.0)])
def test_no_component_is_minus_zero(target: Any) -> None:
    """A zero with a sign is another bit in the engine than what a person writes."""
    assert all(math.copysign(1, part) > 0 for part in rotations.shortest_from_x(target) if part == 0)


@given(VECTORS)
def test_looking_keeps_z_as_far_up_as_it_goes(forward: Any) -> None:
    length, across = np.linalg.norm(forward), math.hypot(*forward[:2])
    assume(length > 1e-3 and across / length > 1e-3)
    q = rotations.looking(forward)
    assert q is not None
    x, y, z = matrix(q).T
    np.testing.assert_allclose(x, unit(forward), atol=1e-9)
    assert abs(y[2]) < 1e-9, "y stays level"
    assert z[2] > 0


@pytest.mark.parametrize("forward", [(0, 0, 0), (0, 0, 1), (0, 0, -3.5), (1e-9, 0, 1)])
def test_looking_nowhere_or_straight_up_is_none(forward: Any) -> None:
    assert rotations.looking(forward) is None


@given(quaternions(), VECTORS)
def test_rigidity_of_a_rigid_motion_is_0(q: Any, p: Any) -> None:
    m = np.eye(4)
    m[:3, :3], m[:3, 3] = matrix(q), p
    assert rotations.rigidity(m.tolist()) < 1e-9


@given(quaternions(), st.integers(0, 2), st.integers(0, 3), st.floats(0.01, 10))
def test_rigidity_sees_every_entry_of_the_rotation(q: Any, row: int, column: int, change: float) -> None:
    assume(column < 3)
    m = np.eye(4)
    m[:3, :3] = matrix(q)
    m[row, column] += change
    assert rotations.rigidity(m.tolist()) > 1e-5


@pytest.mark.parametrize("entry", range(4))
def test_rigidity_sees_the_last_row(entry: int) -> None:
    m = np.eye(4)
    m[3, entry] += 0.01
    assert rotations.rigidity(m.tolist()) == pytest.approx(0.01)
