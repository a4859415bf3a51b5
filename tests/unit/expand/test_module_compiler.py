"""A material that other parameters would name is not unused."""

from __future__ import annotations

import io
from typing import Any

import pytest

from scenecc import validate
from scenecc.expand.module_compiler import _has_in_order

WOODS = "materials: {oak: {visual: {roughness: 1}}, pine: {visual: {roughness: 1}}, rust: {visual: {roughness: 1}}}\n"
SHAPES = "shapes: [{type: sphere, radius: 1}]"
BALL = f"entities: {{a: {{material: NAME, {SHAPES}}}, b: {{material: pine, {SHAPES}}}}}"


def unused(text: str, **options: Any) -> list[str]:
    found = validate(io.StringIO("scenecc: 1\n" + WOODS + text), **options)
    found = [one for one in found if one.code != "SC322"]  # parameters that these cases do not read
    assert {one.code for one in found} <= {"SC313"}, found
    return [one.path.rpartition(".")[2] for one in found]


@pytest.mark.parametrize(
    ("params", "name", "expected"),
    [
        ("m: {type: choice, options: [oak, pine], default: pine}", "${m}", ["rust"]),
        ("m: {type: choice, options: [1, 2], default: 1}", "${['pine', 'oak'][m - 1]}", []),
        ("m: {type: choice, options: [o, p], default: p}", "${m + ('ak' if m == 'o' else 'ine')}", []),
        ("m: {type: string, default: pine}", "${m}", []),
        ("m: {type: material, default: pine}", "${m}", []),
        ("fancy: false", "${'oak' if fancy else 'pine'}", ["rust"]),
        ("i: 0", "${'pine'}", ["oak", "rust"]),
        ("m: ine", "p${m}", ["oak", "rust"]),
        ("m: {type: choice, options: [oak, pine], default: pine}", "{choice: ['${m}', rust]}", []),
        ("size: 1", "{physical: {density: '${size}'}}", ["oak", "rust"]),
    ],
)
def test_by_an_expression(params: str, name: str, expected: list[str]) -> None:
    written = name if name.startswith("{") else f'"{name}"'
    text = f"params: {{{params}}}\n" + BALL.replace("NAME", written)
    assert unused(text) == expected


def test_by_what_is_not_built() -> None:
    text = "params: {n: 0, all: false, which: {type: list, default: [pine]}}\nentities:\n"
    text += f"  b: {{material: pine, {SHAPES}}}\n"
    assert unused(text + f'  a: {{if: "${{all}}", material: oak, {SHAPES}}}') == ["rust"]
    shapes = (
        "shapes: [{repeat: {i: {count: '${n}'}}, type: sphere, radius: 1, material: rust}, {type: sphere, radius: 1}]"
    )
    assert unused(text + f"  a: {{{shapes}}}") == ["oak"]
    assert unused(
        text + f'  a: {{repeat: {{m: [pine, oak]}}, if: "${{m == \'pine\'}}", material: "${{m}}", {SHAPES}}}'
    ) == ["rust"]
    assert unused(text + f'  a: {{repeat: {{m: "${{which}}"}}, material: "${{m}}", {SHAPES}}}') == []


def test_by_what_is_given_to_a_prefab(tmp_path: Any) -> None:
    part = "params: {m: {type: material}}\nentities: {c: {material: '${m}', shapes: [{type: sphere, radius: 1}]}}"
    (tmp_path / "part.yaml").write_text("scenecc: 1\n" + part)
    text = "params: {some: false}\nentities:\n" + f"  b: {{material: pine, {SHAPES}}}\n"
    (tmp_path / "scene.yaml").write_text(
        "scenecc: 1\n" + WOODS + text + '  a: {if: "${some}", use: part.yaml, with: {m: oak}}'
    )
    assert [one.path for one in validate(tmp_path / "scene.yaml")] == ["materials.rust"]


def test_what_nothing_can_name_is_unused() -> None:
    params = "params: {size: 1, m: {type: choice, options: [oak, pine], default: oak}}\n"
    assert unused(params + BALL.replace("NAME", "oak").replace("radius: 1", "radius: '${size}'")) == ["rust"]
    # Drawn, all that it can be is known.
    draws = "draws: {m: {choice: [oak, pine]}}\n"
    assert unused(draws + BALL.replace("NAME", "'${m}'")) == ["rust"]


def test_names_that_a_text_may_give() -> None:
    """In time that grows with the text: a regular expression takes hours for the last one."""
    wild = object()
    assert _has_in_order("red metal", ["red", wild])
    assert _has_in_order("red metal", [wild, "d", wild, "t", wild])
    assert not _has_in_order("red metal", [wild, "t", wild, "d", wild])
    assert not _has_in_order("aa", ["a", wild, "aa"])
    assert not _has_in_order("a" * 60, [wild, "a"] * 15 + ["b"])
