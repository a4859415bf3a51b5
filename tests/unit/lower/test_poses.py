"""Poses as written, fixed and varying, to seven numbers."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from plugins.nightly import examples
from plugins.structures import body_of
from trimesh import transformations
from unit.lower.scenes import BALL, codes, compiled, entity, pose_of, scene

from scenecc import SceneError, compile_scene, validate

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
VARYING_POSES = st.builds(lambda p, r: {"p": p, **r}, VECTORS, ROTATIONS)


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


@settings(deadline=None, max_examples=examples(60))
@given(VARYING_POSES, VARYING_POSES, st.sampled_from("xyz"))
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


@settings(deadline=None, max_examples=examples(30))
@given(DIRECTIONS, NUMBERS, VARYING_POSES)
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


FORMS = [
    {"normal": [[1, 0, 0], 0]},
    {"normal": [[1, 0, 0], [0, 0, 0]]},
    {"normal": [[1, 0, 0], 0.1], "clip": [[0, 0, 0], [1, 1, 1]]},
    {"uniform": [[0, 0, 0], [1, 1, 1]]},
]


def scenes(direction: Any) -> list[dict[str, Any]]:
    light = {"type": "directional", "color": [1, 1, 1], "direction": direction}
    shape = {"type": "sphere", "radius": 1}
    turned = {"pose": {"axis_angle": {"axis": direction, "angle": 1}}, "shapes": [shape]}
    joint = {"type": "continuous", "axis": direction}
    arm = {"root": {"name": "base", "shapes": [shape], "children": [{"name": "l", "joint": joint, "shapes": [shape]}]}}
    return [
        {"scenecc": 1, "lights": {"sun": light}},
        {"scenecc": 1, "entities": {"ball": turned}},
        {"scenecc": 1, "entities": {"arm": arm}},
    ]


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_bounds_may_be_zero(form: dict[str, Any]) -> None:
    for document in scenes(form):
        assert validate(document) == []
        compile_scene(document)


def test_a_range_of_nothing_but_zero_is_none() -> None:
    for document in scenes({"uniform": [[0, 0, 0], [0, 0, 0]]}):
        with pytest.raises(SceneError, match="length 0"):
            compile_scene(document)
