"""What was built of each entity, in numbers."""

from __future__ import annotations

import io

import pytest

import scenecc
from scenecc.inspect import summarize

TEXT = """
scenecc: 1
entities:
  sign: {body_type: kinematic, visuals: [{type: sphere, radius: 0.1}]}
  cart: {body_type: kinematic, shapes: [{type: box, half_size: [0.5, 0.5, 0.5]}]}
  probe: {inertial: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}, visuals: [{type: sphere, radius: 0.1}]}
  wall: {body_type: static, shapes: [{type: box, half_size: [1, 1, 1]}]}
"""


def test_bodies_without_mass_have_none_in_the_summary() -> None:
    plan = scenecc.compile_scene(io.StringIO(TEXT))
    with scenecc.load_scene(plan, render=False) as batch:
        masses = {row.name: row.mass for row in summarize(plan, batch)}
    assert masses == {"sign": None, "cart": pytest.approx(1000), "probe": pytest.approx(2), "wall": None}
