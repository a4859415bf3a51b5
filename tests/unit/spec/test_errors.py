"""What a user is told about the shape of a document: one diagnostic a mistake, and a hint that helps."""

from __future__ import annotations

from typing import Any

import pytest

from scenecc import validate
from scenecc.spec.hints import UNSUPPORTED_KEYS
from scenecc.variation.forms import FORM_KEYS

BALL: dict[str, Any] = {"type": "sphere", "radius": 0.1}


def only(document: dict[str, Any]) -> Any:
    (found,) = validate({"scenecc": 1, **document})
    return found


def body(**keys: Any) -> dict[str, Any]:
    return {"entities": {"body": {"shapes": [BALL], **keys}}}


@pytest.mark.parametrize(
    ("document", "meant"),
    [
        ({"entitys": {}}, "entities"),
        ({"physics": {"time_step": 1}}, "timestep"),
        ({"physics": {"sdf": {"space": 1}}}, "spacing"),
        ({"physics": {"gpu_memory": {"heap_capacit": 1}}}, "heap_capacity"),
        (body(lineardamping=1), "linear_damping"),
        (body(pose={"rpy_degs": [0, 0, 0]}), "rpy_deg"),
        (body(pose={"axis_angle": {"axis": "z", "angle": 1, "angel_deg": 1}}), "angle_deg"),
        (body(inertial={"mass": 1, "inertia": [1, 1, 1], "coms": [0, 0, 0]}), "com"),
        (body(material={"visuals": {}}), "visual"),
        (body(material={"visual": {"rougness": 1}}), "roughness"),
        (body(material={"visual": {"normal_texture": {"file": "a.png", "mipmap_level": 1}}}), "mipmap_levels"),
        (body(shapes=[{**BALL, "colour": [1, 1, 1]}]), "color"),
        (body(collisions=[{**BALL, "contactoffset": 1}]), "contact_offset"),
        (body(visuals=[{**BALL, "frontface": "clockwise"}]), "front_face"),
        ({"materials": {"oak": {"physical": {"densty": 1}}}}, "density"),
        ({"collision_groups": {"a": {"ignores": []}}}, "ignore"),
        (body(body_type="dynamik"), "dynamic"),
        (body(shapes=[{**BALL, "type": "spheer"}]), "sphere"),
        (body(locked_axes=["rxx"]), "rx"),
    ],
    ids=str,
)
def test_the_nearest_known_word_is_suggested(document: dict[str, Any], meant: str) -> None:
    found = [diagnostic for diagnostic in validate({"scenecc": 1, **document}) if diagnostic.severity == "error"]
    assert [diagnostic.hint for diagnostic in found] == [f"did you mean `{meant}`?"]


@pytest.mark.parametrize(
    ("keys", "code", "path", "words"),
    [
        ({"pose": [0, 0, 0, 1, 0, 0, 0]}, "SC106", "entities.body.pose", "`pose: {p: [0, 0, 0], q: [1, 0, 0, 0]}`"),
        ({"pose": [0, 0, 0, 1, 0, 0]}, "SC106", "entities.body.pose", "rpy: [1, 0, 0]"),
        ({"mass": "1.5"}, "SC103", "entities.body.mass", "`mass: 1.5`, without quotes"),
        (
            {"material": {"restitution": 0.5}},
            "SC101",
            "entities.body.material.restitution",
            "`physical: {restitution: 0.5}`",
        ),
        ({"material": {"roughness": 0.5}}, "SC101", "entities.body.material.roughness", "`visual`"),
    ],
)
def test_what_was_probably_meant_is_said(keys: dict[str, Any], code: str, path: str, words: str) -> None:
    found = only(body(**keys))
    assert (found.code, found.path) == (code, path)
    assert words in found.hint


def test_a_length_says_how_many_values_it_must_be() -> None:
    assert only(body(shapes=[{"type": "box", "half_size": [1, 1]}])).message == "`half_size` must have 3 values, not 2"
    assert only(body(inertial={"mass": 1, "inertia": [1, 1, 1, 1]})).message == "`inertia` must have 3 values, not 4"


@pytest.mark.parametrize("count", [float("inf"), float("nan")])
def test_what_is_not_finite_is_no_whole_number(count: float) -> None:
    found = only(body(collision_bits=[count, 2, 3, 4]))
    assert (found.code, found.hint) == ("SC103", None)


def test_an_underscore_makes_no_number_so_that_there_are_no_quotes_to_take_off() -> None:
    assert only(body(mass="1_0")).hint is None


def test_a_file_that_says_no_version_is_told_how_it_starts() -> None:
    (found,) = validate({"entities": {}})
    assert (found.code, found.hint) == ("SC102", "a scene file starts with `scenecc: 1`")


def test_where_nothing_is_near_three_known_keys_are_listed() -> None:
    hint = only(body(pose={"zzz": 1})).hint
    assert hint == "the nearest here: rpy_deg, rpy, relative_to and 6 others (`scenecc schema` lists all)"


@pytest.mark.parametrize("key", UNSUPPORTED_KEYS)
def test_a_key_that_the_language_leaves_out_is_refused_by_name(key: str) -> None:
    assert {only(document).code for document in ({key: {}}, body(**{key: 1}))} == {"SC110"}


@pytest.mark.parametrize("form", sorted(FORM_KEYS))
@pytest.mark.parametrize(
    "path",
    [("physics",), ("physics", "sdf"), ("entities", "body", "inertial"), ("entities", "body", "shapes", 0)],
    ids=str,
)
def test_a_form_in_place_of_a_mapping_is_one_diagnostic(form: str, path: tuple[Any, ...]) -> None:
    document: Any = {"physics": {}, **body(inertial={"mass": 1, "inertia": [1, 1, 1]})}
    node = document
    for key in path[:-1]:
        node = node[key]
    node[path[-1]] = {form: [1, 2], "weights": [1, 2], "clip": [0, 1]}
    found = only(document)
    if form == "normal" and path[-1] == 0:
        # A plane has one; what is missing is its type.
        assert found.code == "SC102"
        return
    assert found.code == "SC116"
    assert found.message.endswith(f"cannot differ from scene to scene as a whole: `{form}`")


@pytest.mark.parametrize(
    ("keys", "path"),
    [
        ({"body_type": {"cycle": ["static"]}}, "body_type"),
        ({"scene_idxs": {"cycle": [1]}}, "scene_idxs"),
        ({"locked_axes": ["x", {"choice": ["y"]}]}, "locked_axes[1]"),
        ({"shapes": {"choice": [[BALL]]}}, "shapes.choice"),
    ],
)
def test_structure_never_varies(keys: dict[str, Any], path: str) -> None:
    found = only(body(**keys))
    assert (found.code, found.path) == ("SC116", f"entities.body.{path}")


@pytest.mark.parametrize(
    ("keys", "code", "path", "words"),
    [
        ({"mass": {"unifrom": [1, 2]}}, "SC103", "mass", "did you mean `{uniform: [1, 2]}`?"),
        (
            {"solver_position_iterations": {"uniform": [1, 2]}},
            "SC116",
            "solver_position_iterations.uniform",
            "integers",
        ),
        ({"mass": {"normal": [1, 2]}}, "SC120", "mass", "clip: [low, high]"),
        ({"pose": {"uniform": [0, 1], "q": "uniform"}}, "SC117", "pose.q", "`p: {uniform: …}`"),
        ({"pose": {"q": {"choice": [[1, 0, 0, 0]]}}}, "SC116", "pose.q.choice", "`rpy`"),
        ({"material": {"choice": [{"physicl": {}}]}}, "SC101", "material.choice[0].physicl", "physical"),
        ({"with": {}}, "SC101", "with", "`use`"),
        ({"pick": 0}, "SC101", "pick", "`variants`"),
        ({"repaet": {}}, "SC101", "repaet", "`repeat`"),
        ({"if": "n > 1"}, "SC103", "if", '"${n > 1}"'),
    ],
)
def test_what_was_probably_meant_of_variation_is_said(keys: dict[str, Any], code: str, path: str, words: str) -> None:
    found = only(body(**keys))
    assert (found.code, found.path) == (code, f"entities.body.{path}")
    assert words in found.hint


def test_an_entity_or_a_material_may_be_named_like_a_form() -> None:
    document = {
        "materials": {"choice": {"physical": {"density": 1}}},
        "frames": {"uniform": {"pose": [0, 0, 1]}},
        "entities": {"cycle": {"material": "choice", "pose": {"relative_to": "uniform"}, "shapes": [BALL]}},
    }
    assert validate({"scenecc": 1, **document}) == []
    document["entities"]["cycle"]["poze"] = 1
    assert only(document).code == "SC101"


def test_a_strangers_words_are_cut() -> None:
    word = "x" * 100_000
    for document in ({"y" + word: 1}, body(body_type=word), body(material=word), {"entities": {word + " ": {}}}):
        assert all(
            len(diagnostic.message) + len(diagnostic.hint or "") < 1000
            for diagnostic in validate({"scenecc": 1, **document})
        )


def test_the_normal_of_a_plane_is_no_form() -> None:
    plane = {"type": "plane", "normal": [0, 0, 1]}
    assert only(body(body_type="static", shapes=[{**plane, "colour": "#ff0000"}])).code == "SC101"
    assert only(body(body_type="static", shapes=[{"normal": [0, 0, 1]}])).code == "SC102"


@pytest.mark.parametrize(("given", "size"), [(0.02, "0.02"), (1, "1"), ([0.02], "0.02")])
def test_one_size_of_a_box_is_told_that_it_has_three(given: Any, size: str) -> None:
    found = only({"entities": {"box": {"shapes": [{"type": "box", "half_size": given}]}}})
    assert found.code == ("SC106" if isinstance(given, list) else "SC103")
    assert found.hint == f"write `half_size: [{', '.join(3 * [size])}]`"
