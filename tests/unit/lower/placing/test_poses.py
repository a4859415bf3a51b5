"""Poses in every form, and what stands relative to what."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plugins.structures import body_of
from trimesh import transformations
from unit.lower.scenes import BALL, codes, compiled, entity, pose_of, scene

from scenecc import compile_scene

HALF = math.sqrt(0.5)
ROT = "entities.body.pose."


def transform(pose: Any) -> np.ndarray:
    """The 4×4 matrix of seven numbers."""
    m = transformations.quaternion_matrix(pose[3:])
    m[:3, 3] = pose[:3]
    return m


def bits(numbers: Any) -> list[bytes]:
    return [struct.pack("d", float(x)) for x in numbers]


def test_left_out_is_the_identity() -> None:
    assert entity(compiled()).pose.data.tolist() == [[0, 0, 0, 1, 0, 0, 0]]


@pytest.mark.parametrize(
    ("pose", "expected"),
    [
        ([1, 2, 3], [1, 2, 3, 1, 0, 0, 0]),
        ({}, [0, 0, 0, 1, 0, 0, 0]),
        ({"p": [1, 2, 3]}, [1, 2, 3, 1, 0, 0, 0]),
        ({"rpy_deg": [180, 0, 0]}, [0, 0, 0, 0, 1, 0, 0]),
        ({"rpy_deg": [0, 180, 0]}, [0, 0, 0, 0, 0, 1, 0]),
        ({"rpy_deg": [0, 0, -180]}, [0, 0, 0, 0, 0, 0, -1]),
        ({"rpy": [0, math.pi / 2, 0]}, [0, 0, 0, HALF, 0, HALF, 0]),
        ({"axis_angle": {"axis": "z", "angle_deg": 90}}, [0, 0, 0, HALF, 0, 0, HALF]),
        ({"axis_angle": {"axis": "y", "angle": math.pi}}, [0, 0, 0, 0, 0, 1, 0]),
        ({"axis_angle": {"axis": [-3, 0, 0], "angle_deg": 90}}, [0, 0, 0, HALF, -HALF, 0, 0]),
        ({"axis_angle": {"axis": [0, 0, 1], "angle": 0}}, [0, 0, 0, 1, 0, 0, 0]),
        ({"look_at": [5, 0, 0]}, [0, 0, 0, 1, 0, 0, 0]),
        ({"look_at": [-5, 0, 0]}, [0, 0, 0, 0, 0, 0, 1]),
        ({"p": [1, 1, 1], "look_at": [1, 4, 1]}, [1, 1, 1, HALF, 0, 0, HALF]),
        ({"p": [0, 0, 1], "look_at": [1, 0, 0]}, [0, 0, 1, math.cos(math.pi / 8), 0, math.sin(math.pi / 8), 0]),
        ({"matrix": [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]}, [1, 2, 3, HALF, 0, 0, HALF]),
        ({"matrix": [[1, 0, 0, 1], [0, -1, 0, 2], [0, 0, -1, 3], [0, 0, 0, 1]]}, [1, 2, 3, 0, 1, 0, 0]),
        ({"matrix": [[-1, 0, 0, 1], [0, 1, 0, 2], [0, 0, -1, 3], [0, 0, 0, 1]]}, [1, 2, 3, 0, 0, 1, 0]),
        ({"matrix": [[-1, 0, 0, 1], [0, -1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]}, [1, 2, 3, 0, 0, 0, 1]),
        ({"relative_to": "world", "p": [1, 2, 3]}, [1, 2, 3, 1, 0, 0, 0]),
    ],
    ids=str,
)
def test_form(pose: Any, expected: list[float]) -> None:
    np.testing.assert_allclose(pose_of(pose), expected, atol=1e-15)


@pytest.mark.parametrize(
    "q",
    [
        [0.7071068, 0, -0.7071068, 0],
        [0.70711, 0.70710, 0, 0],
        [-1, 0, 0, 0],
        [1.0000099, 0, 0, 0],
        [0.9999901, 0, 0, 0],
        [1, -0.0, 0, 0],
    ],
)
def test_a_quaternion_near_unit_length_is_passed_on_to_the_bit(q: list[float]) -> None:
    assert bits(pose_of({"q": q})[3:]) == bits(q)


@pytest.mark.parametrize("q", [[1.00002, 0, 0, 0], [0.99902, 0, 0, 0], [0.7075, 0, 0.7075, 0], [0.5, 0.5, 0.5, 0.5005]])
def test_one_a_little_off_is_normalised(q: list[float]) -> None:
    found = pose_of({"q": q})[3:]
    np.testing.assert_allclose(found, np.array(q) / np.linalg.norm(q), atol=1e-15)
    assert abs(np.linalg.norm(found) - 1) < 1e-15


@pytest.mark.parametrize("q", [[1.0011, 0, 0, 0], [0.9989, 0, 0, 0], [0, 0, 0, 0], [1, 1, 1, 1], [1e-30, 0, 0, 0]])
def test_any_other_is_refused(q: list[float]) -> None:
    assert codes(scene({"pose": {"q": q}})) == [("SC112", ROT + "q")]


@pytest.mark.parametrize("off", [0.0004, -0.0004])
def test_a_matrix_within_a_thousandth_is_rigid(off: float) -> None:
    m = np.eye(4)
    m[0, 0] += off
    pose = pose_of({"matrix": m.tolist()})
    np.testing.assert_allclose(pose, [0, 0, 0, 1, 0, 0, 0], atol=1e-3)
    assert abs(np.linalg.norm(pose[3:]) - 1) < 1e-15


def chain(*poses: Any, **top: Any) -> dict[str, Any]:
    """Frames f0, f1, … each in the last, and a body in the last of them."""
    frames = {f"f{i}": {"pose": p if i == 0 else {**p, "relative_to": f"f{i - 1}"}} for i, p in enumerate(poses)}
    body = {"shapes": BALL, "pose": {"relative_to": f"f{len(poses) - 1}", "p": [0.1, 0.2, 0.3], "rpy": [0.1, 0.2, 0.3]}}
    return {"scenecc": 1, "frames": frames, "entities": {"body": body}, **top}


ANGLE = st.floats(-3, 3)
POSES = st.builds(
    lambda p, rpy: {"p": list(p), "rpy": list(rpy)},
    st.tuples(*[st.floats(-10, 10)] * 3),
    st.tuples(ANGLE, ANGLE, ANGLE),
)


@given(st.lists(POSES, min_size=1, max_size=5))
def test_a_chain_is_the_product_of_its_matrices(poses: list[Any]) -> None:
    found = entity(compile_scene(chain(*poses))).pose.data[0]
    last = {"p": [0.1, 0.2, 0.3], "rpy": [0.1, 0.2, 0.3]}
    expected = np.eye(4)
    for pose in [*poses, last]:
        roll, pitch, yaw = pose["rpy"]
        step = transformations.euler_matrix(roll, pitch, yaw, "sxyz")
        step[:3, 3] = pose["p"]
        expected = expected @ step
    np.testing.assert_allclose(transform(found), expected, atol=1e-12)


def test_relative_to_a_later_entity_and_through_a_frame() -> None:
    document = {
        "scenecc": 1,
        "frames": {"desk": {"pose": {"relative_to": "base", "p": [0, 0, 1]}}},
        "entities": {
            "cup": {"shapes": BALL, "pose": {"relative_to": "desk", "p": [0.5, 0, 0]}},
            "base": {"shapes": BALL, "pose": {"p": [10, 0, 0], "rpy_deg": [0, 0, 90]}},
        },
    }
    plan = compile_scene(document)
    np.testing.assert_allclose(entity(plan, "cup").pose.data[0], [10, 0.5, 1, HALF, 0, 0, HALF], atol=1e-15)
    assert [e.name for e in plan.entities] == ["cup", "base"], "what stands where does not change the order"


def test_a_frame_without_a_turn_leaves_a_quaternion_as_near_as_it_can() -> None:
    q = [0.7071068, 0, -0.7071068, 0]
    plan = compile_scene(scene({"pose": {"relative_to": "f", "q": q}}, frames={"f": {"pose": [0, 0, 0]}}))
    assert bits(entity(plan).pose.data[0][3:]) == bits(q), "the identity changes nothing, not a bit"


def test_a_long_chain_takes_no_recursion() -> None:
    poses = [{"p": [0.001, 0, 0]}] * 5000
    assert entity(compile_scene(chain(*poses))).pose.data[0][0] == pytest.approx(5.1)


def test_a_circle_is_reported_once_and_prints_itself() -> None:
    names = ["a", "b", "c"]
    frames = {name: {"pose": {"relative_to": names[(i + 1) % 3]}} for i, name in enumerate(names)}
    document = scene({"pose": {"relative_to": "b"}}, frames=frames)
    assert codes(document) == [("SC304", "frames.a.pose.relative_to")]
    from scenecc import validate

    assert "a → b → c → a" in validate(document)[0].message


@pytest.mark.parametrize(
    ("idxs", "others", "fine"),
    [([0], [0, 1], True), ([0, 1], [0], False), (None, [0], False), ([1], [0], False), ([0], None, True)],
)
def test_the_other_exists_in_all_of_its_scenes(idxs: Any, others: Any, fine: bool) -> None:
    def body(selection: Any, **keys: Any) -> dict[str, Any]:
        return {"shapes": BALL, **({} if selection is None else {"scene_idxs": selection}), **keys}

    for through in ("table", "f"):
        document = {
            "scenecc": 1,
            "num_scenes": 2,
            "frames": {"f": {"pose": {"relative_to": "table"}}},
            "entities": {"table": body(others), "cup": body(idxs, pose={"relative_to": through})},
        }
        assert codes(document) == ([] if fine else [("SC311", "entities.cup.pose.relative_to")])


def test_unknown_and_misspelt() -> None:
    from scenecc import validate

    (found,) = validate(scene({"pose": {"relative_to": "dsk"}}, frames={"desk": {"pose": [0, 0, 1]}}))
    assert (found.code, found.hint) == ("SC303", "did you mean `desk`?")


@pytest.mark.parametrize(("axis", "q"), [("y", [HALF, 0, 0, HALF]), ("z", [HALF, 0, -HALF, 0])])
def test_axis_turns_before_the_pose(axis: str, q: list[float]) -> None:
    def shape(**pose: Any) -> np.ndarray:
        body = {"shapes": [{"type": "capsule", "radius": 0.1, "half_length": 0.2, "axis": axis, **pose}]}
        found = body_of(entity(compiled(body))).collisions[0].pose
        assert found is not None
        return found.data[0]

    np.testing.assert_allclose(shape(), [0, 0, 0, *q], atol=1e-15)
    np.testing.assert_allclose(shape(pose=[1, 2, 3]), [1, 2, 3, *q], atol=1e-15)
    turned = {"p": [1, 2, 3], "rpy": [0.3, 0.2, 0.1]}
    outer = transformations.euler_matrix(0.3, 0.2, 0.1, "sxyz")
    outer[:3, 3] = [1, 2, 3]
    np.testing.assert_allclose(transform(shape(pose=turned)), outer @ transform([0, 0, 0, *q]), atol=1e-12)


@given(st.tuples(*[st.floats(-5, 5)] * 3).filter(lambda n: math.hypot(*n) > 0.01), st.floats(-5, 5))
def test_a_plane_lies_along_its_normal(normal: Any, offset: float) -> None:
    body = {"body_type": "static", "shapes": [{"type": "plane", "normal": list(normal), "offset": offset}]}
    value = body_of(entity(compiled(body))).collisions[0].pose
    found = [0, 0, 0, 1, 0, 0, 0] if value is None else value.data[0]
    along = np.array(normal) / math.hypot(*normal)
    np.testing.assert_allclose(found[:3], along * offset, atol=1e-12)
    np.testing.assert_allclose(transform(found)[:3, 0], along, atol=1e-7)
