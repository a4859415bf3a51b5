"""Poses composed one by one and many at once: to the bit the same, and untouched where one does not turn."""

from __future__ import annotations

import numpy as np
import pytest

from scenecc.geometry import rotation_arrays
from scenecc.geometry.rotations import IDENTITY_POSE, compose

# Seven digits: not of unit length, and normalised no longer the same.
Q = (0.9238795, 0.2209424, 0.2209424, 0.2209424)
TURNED = (0.1, -0.2, 0.3, *Q)
OTHER = (1.0, 2.0, 3.0, 0.5, -0.5, 0.5, 0.5)
MOVED = (4.0, 5.0, 6.0, 1.0, 0.0, 0.0, 0.0)
POSES = [IDENTITY_POSE, TURNED, OTHER, MOVED]


@pytest.mark.parametrize("outer", POSES)
@pytest.mark.parametrize("inner", POSES)
def test_batched_composition_equals_single_composition(outer: tuple[float, ...], inner: tuple[float, ...]) -> None:
    one = compose(outer, inner)  # type: ignore[arg-type]
    many = rotation_arrays.compose(np.array([outer, OTHER]), np.array([inner, TURNED]))
    assert many[0].tobytes() == np.array(one).tobytes()


@pytest.mark.parametrize("still", [IDENTITY_POSE, MOVED])
def test_composing_with_a_pure_translation_keeps_the_rotation_exactly(still: tuple[float, ...]) -> None:
    assert compose(still, TURNED)[3:] == Q  # type: ignore[arg-type]
    assert compose(TURNED, still)[3:] == Q  # type: ignore[arg-type]


def test_the_product_of_two_rotations_has_unit_length() -> None:
    assert np.linalg.norm(compose(TURNED, TURNED)[3:]) == pytest.approx(1, abs=1e-15)
