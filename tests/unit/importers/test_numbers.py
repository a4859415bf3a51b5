"""Numbers of imported files, as a person would write them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scenecc.geometry.rotations import from_rpy
from scenecc.importers.numbers import clean_pose, plain_pose


@pytest.mark.parametrize(
    ("written", "plain"),
    [
        ([0, 90, 0], [0, 90, 0]),
        ([0, -90, 30], [0, -90, 30]),
        ([30, 90, 45], [0, 90, 15]),
        ([180, -45, 180], [0, -135, 0]),
        ([180, 0, 180], [0, 180, 0]),
        ([90, 0, -180], [90, 0, 180]),
    ],
)
def test_rotations_of_single_precision_become_whole_degrees(written: list[int], plain: list[int]) -> None:
    w, x, y, z = (float(np.float32(each)) for each in from_rpy(*map(math.radians, written)))
    assert plain_pose(clean_pose((0, 0, 0, w, x, y, z))) == {"rpy_deg": plain}


def test_a_rotation_that_is_not_whole_degrees_stays_a_quaternion() -> None:
    w, x, y, z = from_rpy(0.1, math.radians(89.999), 0.2)
    pose = plain_pose(clean_pose((0, 0, 0, w, x, y, z)))
    assert pose["q"] == pytest.approx([w, x, y, z], abs=1e-7)
