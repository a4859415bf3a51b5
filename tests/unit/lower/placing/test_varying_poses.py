"""Poses that vary: the same numbers give the same bits, and names are looked up where they are written."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from plugins.structures import body_of
from unit.lower.scenes import BALL, codes, compiled, entity, scene

from scenecc import SceneError, compile_scene

NUMBERS = st.floats(-4, 4, allow_nan=False).map(lambda x: 0.0 if abs(x) < 1e-6 else x)
VECTORS = st.lists(NUMBERS, min_size=3, max_size=3)
DIRECTIONS = VECTORS.filter(lambda v: math.hypot(*v) > 1e-2)


def unit(q: list[float]) -> list[float]:
    length = math.hypot(*q)
    return [x / length for x in q]


QUATERNIONS = st.lists(NUMBERS, min_size=4, max_size=4).filter(lambda q: math.hypot(*q) > 0.1).map(unit)
ROTATIONS = st.one_of(
    st.just({}),
    QUATERNIONS.map(lambda q: {"q": q}),
    VECTORS.map(lambda v: {"rpy": v}),
    st.lists(st.sampled_from([0, 30, 90, -180, 12.5]), min_size=3, max_size=3).map(lambda v: {"rpy_deg": v}),
    st.tuples(DIRECTIONS, NUMBERS).map(lambda t: {"axis_angle": {"axis": t[0], "angle": t[1]}}),
    st.tuples(st.sampled_from("xyz"), NUMBERS).map(lambda t: {"axis_angle": {"axis": t[0], "angle_deg": 40 * t[1]}}),
    DIRECTIONS.map(lambda v: {"look_at": v}),
)
POSES = st.builds(lambda p, r: {"p": p, **r}, VECTORS, ROTATIONS)


def expression(number: float) -> str:
    """One that gives the same in every scene, and looks as if it might not."""
    return f"${{{number!r} + 0 * scene}}"


def varied(node: Any) -> Any:
    """The same pose, each of its numbers given scene by scene; scene 1 has others, so that arrays are computed."""
    if isinstance(node, dict):
        return {key: varied(item) for key, item in node.items() if key != "q"} | (
            {"q": [expression(x) for x in node["q"]]} if "q" in node else {}
        )
    if isinstance(node, list):
        return {"per_scene": {"1": [0.3, 0.2, 0.1], "default": node}}
    return {"per_scene": {"1": 0.5, "default": node}} if isinstance(node, int | float) else node


def poses(pose: Any, outer: Any, axis: str) -> tuple[np.ndarray, np.ndarray, Any]:
    """Of an entity in a frame, of the frame itself and of a capsule of the entity, in scene 0."""
    capsule = {"type": "capsule", "radius": 1, "half_length": 1, "axis": axis, "pose": pose}
    document = scene({"pose": {**pose, "relative_to": "place"}, "shapes": [capsule]}, frames={"place": {"pose": outer}})
    document["entities"]["at"] = {"shapes": BALL, "pose": {"relative_to": "place"}}
    plan = compile_scene(document, num_scenes=3)
    body = entity(plan)
    local = body_of(body).collisions[0].pose
    return body.pose.row(0), entity(plan, "at").pose.row(0), None if local is None else local.row(0)


@settings(deadline=None, max_examples=60)
@given(POSES, POSES, st.sampled_from("xyz"))
def test_equal_numbers_give_equal_bits(pose: Any, outer: Any, axis: str) -> None:
    try:
        plain = poses(pose, outer, axis)
        arrays = poses(varied(pose), varied(outer), axis)
    except SceneError:
        # A point looked at straight above; the arrays may meet one in scene 1.
        assume(False)
        raise
    for one, other in zip(plain, arrays, strict=True):
        identity = np.array([0, 0, 0, 1.0, 0, 0, 0])
        assert (identity if one is None else one).tobytes() == (identity if other is None else other).tobytes()


@settings(deadline=None, max_examples=30)
@given(DIRECTIONS, NUMBERS, POSES)
def test_planes_turn_alike(normal: list[float], offset: float, pose: Any) -> None:
    def plane(normal: Any, offset: Any) -> np.ndarray:
        shape = {"type": "plane", "normal": normal, "offset": offset, "pose": pose}
        body = {"body_type": "static", "shapes": [shape]}
        local = body_of(entity(compiled(body, num_scenes=2))).collisions[0].pose
        return np.array([0, 0, 0, 1.0, 0, 0, 0]) if local is None else local.row(0)

    try:
        plain = plane(normal, offset)
    except SceneError:
        assume(False)
        raise
    by_scene = plane(normal, {"per_scene": {"1": 5, "default": offset}})
    assert plain.tobytes() == by_scene.tobytes()
    by_both = plane([expression(x) for x in normal], offset)
    assert plain.tobytes() == by_both.tobytes()


def test_a_position_is_drawn_alike_however_it_is_written() -> None:
    low, high = [0, 0, 0], [1, 2, 3]
    parts = [{"uniform": [0, 1]}, {"uniform": [0, 2]}, {"uniform": [0, 3]}]
    written = [{"uniform": [low, high]}, parts, {"p": {"uniform": [low, high]}}, {"p": parts}]
    first, *others = (entity(compiled({"pose": pose}, num_scenes=4)).pose.data for pose in written)
    assert len(set(first[:, 2])) == 4
    assert all((first == other).all() for other in others)
    choice = [low, high]
    one, other = (
        entity(compiled({"pose": pose}, num_scenes=9)).pose.data
        for pose in ({"choice": choice}, {"p": {"choice": choice}})
    )
    assert (one == other).all()


def test_whole_poses_by_scene() -> None:
    pose = {"cycle": [[1, 2, 3], {"p": [0, 0, 1], "rpy_deg": [0, 0, 90]}, {"p": {"uniform": [[0, 0, 0], [1, 1, 1]]}}]}
    data = entity(compiled({"pose": pose}, num_scenes=3)).pose.data
    half = math.sqrt(0.5)
    np.testing.assert_allclose(data[:2], [[1, 2, 3, 1, 0, 0, 0], [0, 0, 1, half, 0, 0, half]], atol=1e-15)
    assert (data[2, :3] < 1).all()


def test_an_even_rotation() -> None:
    data = entity(compiled({"pose": {"q": "uniform"}}, num_scenes=500)).pose.data[:, 3:]
    np.testing.assert_allclose(np.linalg.norm(data, axis=1), 1)
    # Turned at random, +x points anywhere: its mean is near 0.
    w, x, y, z = data.T
    forward = np.stack((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)))
    assert (np.abs(forward.mean(axis=1)) < 0.1).all()


def test_alternatives_do_not_stand_relative_to_something_each() -> None:
    pose = {"choice": [[0, 0, 0], {"relative_to": "place"}]}
    document = scene({"pose": pose}, frames={"place": {"pose": [0, 0, 1]}})
    assert codes(document) == [("SC316", "entities.body.pose.choice[1].relative_to")]


@pytest.mark.parametrize(
    ("pose", "code", "path"),
    [
        ({"choice": [[0, 0, 0], {"q": [1, 1, 0, 0]}]}, "SC112", "choice[1].q"),
        ({"p": {"uniform": [[0, 0, 0], [1, 1, 1]]}, "q": [1, 1, 0, 0]}, "SC112", "q"),
        ({"p": {"cycle": [[0, 0, 0]]}, "axis_angle": {"axis": [0, 0, 0], "angle": 1}}, "SC114", "axis_angle.axis"),
        ({"axis_angle": {"axis": {"cycle": ["x", [0, 0, 0]]}, "angle": 1}}, "SC114", "axis_angle.axis.cycle[1]"),
        ({"rpy": [0, 0, {"uniform": [0, 1]}], "q": [1, 0, 0, 0]}, "SC111", "rpy"),
        ({"p": {"per_scene": [[0, 0, 0], [1, 1, 1]]}, "look_at": [1, 1, 1]}, "SC515", "look_at"),
    ],
)
def test_what_is_wrong_in_a_pose_that_varies(pose: Any, code: str, path: str) -> None:
    assert codes(scene({"pose": pose}, num_scenes=2)) == [(code, f"entities.body.pose.{path}")]


def test_a_turned_shape_that_is_drawn_for_one_scene() -> None:
    capsule = {
        "type": "capsule",
        "radius": 1,
        "half_length": 1,
        "axis": "z",
        "pose": {"p": {"uniform": [[0, 0, 0], [1, 1, 1]]}},
    }
    one = body_of(entity(compiled({"shapes": [capsule]}))).collisions[0].pose
    several = body_of(entity(compiled({"shapes": [capsule]}, num_scenes=3))).collisions[0].pose
    assert one is not None
    assert several is not None
    assert one.row(0).tolist() == several.row(0).tolist()
