"""Expectations: what holds, what does not, and what names mean in prefabs and included files."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest

from scenecc import SceneError, check_scene, compile_scene, emit_scene
from scenecc.plan.diff import diff_plans

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic

GROUND = {"body_type": "static", "shapes": [{"type": "plane"}]}
CUBE = {"shapes": [{"type": "box", "half_size": [0.05, 0.05, 0.05]}]}


def found(expect: dict[str, Any], settle: float = 0, **other: Any) -> list[Diagnostic]:
    entities = {"ground": GROUND, "cube": {**CUBE, "pose": [0, 0, 0.05]}, "high": {**CUBE, "pose": [1, 0, 0.25]}}
    document = {"scenecc": 1, "entities": entities | other.pop("entities", {}), "expect": expect, **other}
    return check_scene(document, settle=settle)


def codes(diagnostics: list[Diagnostic]) -> list[str]:
    return [each.code for each in diagnostics]


@pytest.mark.parametrize(
    ("that", "after", "holds"),
    [
        ("position('high')[2] > 0.24", 0, True),
        ("position('high')[2] > 0.24", 1, False),
        ("speed('high') > 0.9", 0.1, True),
        ("abs(distance('cube', 'high') - hypot(0.9, 0.1)) < 1e-6", 0, True),
        ("abs(distance('high', 'ground') - 0.2) < 1e-6", 0, True),
        ("touching('cube', 'ground')", 0.5, True),
        ("touching('high', 'ground')", 0.05, False),
        ("tilt('cube') < 0.001 and scene == 0", 1, True),
    ],
)
def test_a_condition_is_checked_at_its_time(that: str, after: float, *, holds: bool) -> None:
    diagnostics = found({"holds": [{"after": after, "that": f"${{{that}}}"}]})
    assert codes(diagnostics) == ([] if holds else ["SC861"])


def test_a_missed_number_is_shown_with_enough_digits() -> None:
    entities = {"third": {**CUBE, "pose": [2, 0, 0.3]}}
    (told,) = found({"holds": [{"that": "${position('third')[2] == 0.3}"}]}, entities=entities)
    assert "0.300000012" in told.message


def test_a_simulation_is_as_long_as_an_expectation_needs() -> None:
    (told,) = found({"settled": {"seconds": 0.5}})
    assert told.code == "SC860"
    assert "200 mm away" in told.message
    assert not found({"settled": {"seconds": 0.5, "except": ["high"]}})


@pytest.mark.parametrize(
    ("rules", "expected"),
    [
        ({}, ["SC850"]),
        ({"deeper_than": 0.005}, []),
        ({"except": [["ground", "deep"]]}, []),
        ({"except": [["cube", "deep"]]}, ["SC850", "SC863"]),
    ],
)
def test_expectations_allow_and_excuse_overlaps(rules: dict[str, Any], expected: list[str]) -> None:
    deep = {**CUBE, "pose": [3, 0, 0.047]}
    assert sorted(codes(found({"no_overlap": rules}, entities={"deep": deep}))) == expected


def test_reading_a_missing_value_is_an_error_only_in_that_scene() -> None:
    only = {**CUBE, "pose": [2, 0, 0.05], "scene_idxs": [1]}
    reads = {"that": "${position('only')[2] > 0}"}
    guarded = {"that": "${scene == 0 or position('only')[2] > 0}"}
    (told,) = found({"holds": [reads, {**reads, "scene_idxs": [1]}, guarded]}, entities={"only": only}, num_scenes=2)
    assert (told.code, told.message.endswith("in scene 0")) == ("SC862", True)


def test_expectations_in_prefabs_use_inner_names_and_includes_add(tmp_path: Path) -> None:
    (tmp_path / "part.yaml").write_text(
        "scenecc: 1\nentities: {mug: {pose: [0, 0, 0.05], shapes: [{type: box, half_size: [0.05, 0.05, 0.05]}]}}\n"
        "expect:\n  settled: {seconds: 0.1}\n  holds:\n    - {that: \"${position('mug')[0] < 4}\"}\n"
    )
    (tmp_path / "more.yaml").write_text("scenecc: 1\nexpect: {holds: [{that: \"${position('a/mug')[0] > 1}\"}]}\n")
    top = tmp_path / "top.yaml"
    top.write_text(
        "scenecc: 1\ninclude: [more.yaml]\nentities:\n  ground: {use: 'scenecc:ground'}\n"
        "  falls: {pose: [9, 0, 1], shapes: [{type: sphere, radius: 0.1}]}\n"
        "  a: {use: part.yaml}\n  b: {use: part.yaml, pose: [5, 0, 0]}\nexpect: {holds: [{that: true}]}\n"
    )
    told = check_scene(top, settle=0)
    assert [(one.code, (one.file or "").rpartition("/")[2], one.line) for one in told] == [
        ("SC861", "more.yaml", 2),
        ("SC861", "top.yaml", 7),
    ]


def test_an_error_is_reported_at_its_place_in_the_expression(tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scenecc: 1\nentities: {cube: {shapes: [{type: box, half_size: [1, 1, 1]}]}}\nexpect:\n  holds:\n"
        "    - that: \"${speed('cube') < 1 and tilt('cub') < 0.1}\"\n"
        "    - that: \"${speed('cube') < 1 and qpos('cube', 'j') < 0.1}\"\n"
    )
    assert [(one.code, one.line, one.column) for one in check_scene(scene)] == [("SC330", 5, 44), ("SC325", 6, 52)]
    scene.write_text("scenecc: 1\nexpect: {holds: [{that: speed('cube') < 1}]}\n")
    (told,) = check_scene(scene)
    assert (told.code, told.hint) == ("SC103", "an expression is written `that: \"${speed('cube') < 1}\"`")


def test_each_prefab_instance_is_checked_with_its_own_bodies(tmp_path: Path) -> None:
    (tmp_path / "part.yaml").write_text(
        "scenecc: 1\nparams: {x: {default: 0}}\nentities: {mug: {shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}}\n"
        "expect: {holds: [{that: \"${abs(position('mug')[0] - x) < 0.1}\"}]}\n"
    )
    top, uses = tmp_path / "top.yaml", "  {0}: {{use: part.yaml, pose: [{1}, 0, 0.1], with: {{x: {2}}}}}\n"
    top.write_text(
        "scenecc: 1\nentities:\n  ground: {use: 'scenecc:ground'}\n"
        + "".join(uses.format(name, at, wanted) for name, at, wanted in (("a", 0, 0), ("b", 3, 4), ("c", 6, 6)))
    )
    (told,) = check_scene(top, settle=0)
    assert told.code == "SC861"
    assert "is [3, 0, 0.1]" in told.message
    assert "other use" not in told.message
    assert told.related[-1].location.line == 5


HOSTILE = [None, -1, 1e308, 10**400, "${", "${exit()}", "${position('a')}", "${'a' * 10**9 == h}", [], {}, ["a"] * 9999]


def places(node: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    for key in node if isinstance(node, dict) else range(len(node) if isinstance(node, list) else 0):
        yield (*path, key)
        yield from places(node[key], (*path, key))


def test_hostile_expectations_in_a_plan_do_not_crash() -> None:
    expect = {
        "settled": {"seconds": 0.1, "except": ["a"]},
        "no_overlap": {"except": [["a", "ground"]]},
        "holds": [{"that": "${qpos('a', 'j') < h}", "scene_idxs": [0], "because": "it is low"}],
    }
    joint = {"type": "revolute", "name": "j"}
    robot = {"fix_root_link": True, "root": {"name": "base", "children": [{"name": "arm", "joint": joint, **CUBE}]}}
    scene = {"scenecc": 1, "draws": {"h": {"uniform": [1, 2]}}, "entities": {"ground": GROUND, "a": robot}}
    text = emit_scene(compile_scene({**scene, "expect": expect}), "json")
    tried = refused = 0
    for *path, last in list(places(json.loads(text)["expectations"])):
        for value in HOSTILE:
            plan = json.loads(text)
            node = plan["expectations"]
            for key in path:
                node = node[key]
            node[last] = value
            tried += 1
            try:
                check_scene(compile_scene(json.dumps(plan)), settle=0)
            except SceneError:
                refused += 1
    assert tried > 300
    assert refused > 0.8 * tried


def test_a_plan_keeps_its_expectations() -> None:
    expect = {"settled": {}, "holds": [{"after": 1, "that": "${position('a')[0] < h}"}]}
    entities = {"ground": GROUND, "a": {**CUBE, "pose": [0, 0, 0.05]}}
    scene = {"scenecc": 1, "draws": {"h": {"uniform": [1, 2]}}, "entities": entities, "expect": expect}
    plan = compile_scene(scene)
    text = emit_scene(plan, "json")
    assert compile_scene(text) == plan
    assert emit_scene(compile_scene(text), "json") == text
    other = compile_scene({**scene, "expect": {"settled": {"within": 1}}})
    assert [(one.kind, one.section, one.name) for one in diff_plans(plan, other)] == [
        ("changed", "expect", "settled"),
        ("removed", "expect", "holds[0]"),
    ]
