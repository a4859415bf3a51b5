"""Which materials are reported as unused."""

from __future__ import annotations

import io
from typing import Any

import pytest

from scenecc import validate

WOODS = "materials: {oak: {visual: {roughness: 1}}, pine: {visual: {roughness: 1}}, rust: {visual: {roughness: 1}}}\n"
SHAPES = "shapes: [{type: sphere, radius: 1}]"
BALL = f"entities: {{a: {{material: NAME, {SHAPES}}}, b: {{material: pine, {SHAPES}}}}}"


def unused(text: str) -> list[str]:
    found = validate(io.StringIO("scenecc: 1\n" + WOODS + text))
    assert {one.code for one in found} <= {"SC313"}, found
    return [one.path.rpartition(".")[2] for one in found]


@pytest.mark.parametrize(
    ("params", "name"),
    [
        ("m: {type: choice, options: [oak, pine], default: pine}", "${m}"),
        ("m: {type: string, default: pine}", "${m}"),
        ("m: {type: material, default: pine}", "${m}"),
        ("fancy: false", "${'oak' if fancy else 'pine'}"),
    ],
)
def test_no_material_of_a_scene_with_parameters_is_reported(params: str, name: str) -> None:
    assert unused(f"params: {{{params}}}\n" + BALL.replace("NAME", f'"{name}"')) == []


def test_materials_of_a_scene_without_parameters_are_followed_through_expressions() -> None:
    assert unused(BALL.replace("NAME", "oak")) == ["rust"]
    assert unused(BALL.replace("NAME", "\"${'o' + 'ak'}\"")) == ["rust"]
    assert unused("draws: {m: {choice: [oak, pine]}}\n" + BALL.replace("NAME", "'${m}'")) == ["rust"]
    copies = f'entities: {{a: {{repeat: {{m: [pine, oak]}}, if: "${{m == \'pine\'}}", material: "${{m}}", {SHAPES}}}}}'
    assert unused(copies) == ["oak", "rust"]


def test_a_material_that_a_prefab_is_given_is_used(tmp_path: Any) -> None:
    part = "params: {m: {type: material}}\nentities: {c: {material: '${m}', shapes: [{type: sphere, radius: 1}]}}"
    (tmp_path / "part.yaml").write_text("scenecc: 1\n" + part)
    (tmp_path / "scene.yaml").write_text("scenecc: 1\n" + WOODS + "entities: {a: {use: part.yaml, with: {m: oak}}}")
    assert [one.path for one in validate(tmp_path / "scene.yaml")] == ["materials.pine", "materials.rust"]
