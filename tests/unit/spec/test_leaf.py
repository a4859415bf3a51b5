"""Values that vary, as the models hold them."""

from __future__ import annotations

from typing import Any

import pytest
from plugins.diagnostics import TakingSink

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Origin
from scenecc.spec.document import SceneFile
from scenecc.spec.parse import parse
from scenecc.variation.forms import (
    MISSING,
    Choice,
    Cycle,
    DrawForm,
    PerScene,
    RandomRotation,
    SceneMap,
    Template,
    Vector,
)

BALL: dict[str, Any] = {"type": "sphere", "radius": 0.1}


def read(document: dict[str, Any], *, expanded: bool = False) -> SceneFile:
    sink = Sink()
    scene = parse({"scenecc": 1, **document}, Origin("scene.yaml"), sink, expanded=expanded)
    assert scene is not None, sink.diagnostics()
    return scene


def body(keys: dict[str, Any], *, expanded: bool = False) -> Any:
    return read({"entities": {"body": {"shapes": [BALL], **keys}}}, expanded=expanded).entities["body"]


@pytest.mark.parametrize(
    ("key", "node", "value"),
    [
        ("mass", 2, 2.0),
        ("mass", {"per_scene": [1, 2]}, PerScene((1.0, 2.0))),
        ("mass", {"per_scene": {"0": 1, "3": 2}}, SceneMap(((0, 1.0), (3, 2.0)), MISSING)),
        ("mass", {"per_scene": {"3": 2, "default": 5}}, SceneMap(((3, 2.0),), 5.0)),
        ("mass", {"cycle": [1, 2]}, Cycle((1.0, 2.0))),
        ("mass", {"choice": [1, 2], "weights": [1, 3]}, Choice((1.0, 2.0), (1.0, 3.0))),
        ("mass", {"uniform": [1, 2], "x-why": "a note"}, DrawForm("uniform", (1.0, 2.0))),
        ("mass", {"integers": [1, 2]}, DrawForm("integers", (1, 2))),
        ("mass", {"log_uniform": [1, 2]}, DrawForm("log_uniform", (1.0, 2.0))),
        ("mass", {"normal": [1, 2], "clip": [1, 2]}, DrawForm("normal", (1.0, 2.0, 1.0, 2.0))),
        ("mass", {"normal": [-1, 0], "clip": [1, 2]}, DrawForm("normal", (-1.0, 0.0, 1.0, 2.0))),
        ("mass", {"choice": [{"uniform": [1, 2]}, 3]}, Choice((DrawForm("uniform", (1.0, 2.0)), 3.0))),
        ("mass", {"uniform": [{"cycle": [1, 2]}, 3]}, DrawForm("uniform", (Cycle((1.0, 2.0)), 3.0))),
        ("gravity", {"cycle": [True, False]}, Cycle((True, False))),
        (
            "linear_velocity",
            {"uniform": [[0, 0, 0], [1, 2, 3]]},
            DrawForm("uniform", ((0.0, 0.0, 0.0), (1.0, 2.0, 3.0))),
        ),
        # A number bounds every component of a vector.
        ("linear_velocity", {"uniform": [-1, [1, 2, 3]]}, DrawForm("uniform", ((-1.0, -1.0, -1.0), (1.0, 2.0, 3.0)))),
        ("linear_velocity", [0, {"uniform": [0, 1]}, 2], Vector((0.0, DrawForm("uniform", (0.0, 1.0)), 2.0))),
        ("pose", {"normal": [0, 1]}, DrawForm("normal", ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))),
        ("color", {"uniform": ["#000000", "#ffffff"]}, DrawForm("uniform", ("#000000", "#ffffff"))),
        (
            "color",
            {"uniform": [[0, 0, 0, 1], [1, 1, 1, 1]]},
            DrawForm("uniform", ((0.0, 0.0, 0.0, 1.0), (1.0, 1.0, 1.0, 1.0))),
        ),
        ("material", {"choice": ["a", "b"]}, Choice(("a", "b"))),
        ("solver_position_iterations", {"integers": [1, 4]}, DrawForm("integers", (1, 4))),
    ],
)
def test_forms_become_values(key: str, node: Any, value: Any) -> None:
    assert getattr(body({key: node}), key) == value
    assert getattr(body({key: node}, expanded=True), key) == value


def test_a_scale_may_be_drawn_as_one_number() -> None:
    shape = {"type": "convex_mesh", "file": {"choice": ["a.obj", "b.obj"]}, "scale": {"uniform": [1, 2]}}
    (found,) = body({"shapes": [shape]}).shapes
    assert (found.file, found.scale) == (Choice(("a.obj", "b.obj")), DrawForm("uniform", (1.0, 2.0)))


def test_whole_poses_are_alternatives() -> None:
    pose = body({"pose": {"cycle": [[0, 0, 1], {"p": [0, 0, 2], "rpy": [0, 0, {"uniform": [0, 1]}]}]}}).pose
    assert pose.items[0] == (0.0, 0.0, 1.0)
    assert pose.items[1].rpy == Vector((0.0, 0.0, DrawForm("uniform", (0.0, 1.0))))


def test_a_rotation_is_drawn_by_a_word() -> None:
    assert body({"pose": {"q": "uniform"}}).pose.q == RandomRotation()


def test_expressions_become_templates() -> None:
    found = body({"mass": "${m}", "pose": ["${x}", 0, 1], "color": "${c}", "linear_damping": {"uniform": [0, "${d}"]}})
    assert found.mass == Template("${m}")
    assert found.pose == Vector((Template("${x}"), 0.0, 1.0))
    assert found.color == Template("${c}")
    assert found.linear_damping == DrawForm("uniform", (0.0, Template("${d}")))


def test_what_is_left_of_an_expression_is_taken_as_it_is() -> None:
    mass = Template("${m + n}", {"n": 1})
    assert body({"mass": mass, "pose": [0, mass, 0]}, expanded=True).mass is mass


def test_once_expanded_a_text_is_literal() -> None:
    shape = {**BALL, "name": "costs ${price}"}
    (found,) = body({"shapes": [shape]}, expanded=True).shapes
    assert found.name == "costs ${price}"


def test_what_is_fixed_cannot_read_a_draw(sink: TakingSink) -> None:
    document = {"scenecc": 1, "entities": {"a": {"body_type": Template("${kind}"), "shapes": [BALL]}}}
    assert parse(document, Origin("scene.yaml"), sink, expanded=True) is None
    found = sink.take("SC116", path="entities.a.body_type")
    assert "`body_type` reads `kind`" in found.message


@pytest.mark.parametrize("section", ["entities", "frames", "materials", "collision_groups", "draws"])
def test_only_expansion_makes_names_with_slashes(section: str, sink: TakingSink) -> None:
    entry: Any = {"frames": {"pose": [0, 0, 0]}, "draws": 1, "entities": {"shapes": [BALL]}}.get(section, {})
    document = {"scenecc": 1, section: {"leg/foot": entry}}
    assert parse(document, Origin("scene.yaml"), sink, expanded=True) is not None
    assert parse(document, Origin("scene.yaml"), sink) is None
    sink.take("SC107")


def test_an_expanded_document_is_over_when_the_next_is_read(sink: TakingSink) -> None:
    read({}, expanded=True)
    assert parse({"scenecc": 1, "name": "${"}, Origin("scene.yaml"), sink) is None
    sink.take("SC118")


def test_structures_and_their_pick() -> None:
    found: Any = read(
        {"entities": {"bin": {"variants": [{"shapes": [BALL]}, {"mass": 2}], "pick": {"cycle": [0, 1]}, "visuals": []}}}
    ).entities["bin"]
    assert [variant.model_fields_set for variant in found.variants] == [{"shapes"}, {"mass"}]
    assert found.pick == Cycle((0, 1))


@pytest.mark.parametrize(
    "entity",
    [
        {"use": "leg.yaml", "with": {"length": {"uniform": [1, 2]}}, "prefix": "", "repeat": {"i": {"count": 3}}},
        {"repeat": {"i": [-1, 1], "j": "${list}"}, "name": "leg_${i}", "if": "${with_legs}", "shapes": [BALL]},
        {"shapes": [{"repeat": {"i": [1, 2]}, "type": "sphere", "radius": "${i}"}]},
        # Judged once its type is known.
        {"shapes": [{"type": "${kind}", "anything": 1}]},
        {"use": "${kind}.yaml"},
    ],
    ids=str,
)
def test_what_expansion_takes_out_may_be_written(entity: dict[str, Any]) -> None:
    scene = read(
        {
            "params": {"kind": "sphere"},
            "include": ["a.yaml"],
            "draws": {"u": {"uniform": [0, 1]}},
            "entities": {"a": entity},
        }
    )
    (found,) = scene.entities.values()
    assert {type(found).model_fields[name].alias or name for name in found.model_fields_set} == entity.keys()


@pytest.mark.parametrize(
    "node", [1, True, "a", [1, 2, 3], {"choice": ["a", "b"]}, "${a}", {"uniform": [[0, 0], [1, 1]]}]
)
def test_shared_draws_are_any_plain_value_or_form(node: Any) -> None:
    assert list(read({"draws": {"u": node}}).draws) == ["u"]


def test_copies_that_share_a_node_share_what_it_was_read_as() -> None:
    drawn = {"uniform": [0.1, 0.2]}
    copies = {name: {"shapes": [{"type": "sphere", "radius": drawn}]} for name in "ab"}
    bodies: Any = read({"entities": copies}, expanded=True).entities
    a, b = bodies.values()
    assert a.shapes[0].radius is b.shapes[0].radius


def test_a_shared_node_is_read_anew_for_another_kind_of_value() -> None:
    drawn = {"uniform": [1, 2]}
    found = body({"mass": drawn, "linear_velocity": drawn, "shapes": [{**BALL, "density": drawn}]}, expanded=True)
    assert found.mass == found.shapes[0].density == DrawForm("uniform", (1.0, 2.0))
    assert found.linear_velocity == DrawForm("uniform", ((1.0,) * 3, (2.0,) * 3))


def test_a_shared_node_that_is_wrong_is_wrong_in_every_copy() -> None:
    drawn = {"uniform": [2, 1]}
    copies = {name: {"shapes": [{"type": "sphere", "radius": drawn}]} for name in "ab"}
    sink = Sink()
    assert parse({"scenecc": 1, "entities": copies}, Origin("scene.yaml"), sink, expanded=True) is None
    assert [found.code for found in sink.diagnostics()] == ["SC119", "SC119"]
