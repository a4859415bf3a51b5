"""What a document holds: whether it needs expansion, and how many objects it counts for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from scenecc import validate
from scenecc.diagnostics import Sink
from scenecc.expand.documents import needs_expansion
from scenecc.source import read_text

PLAIN = [
    "entities: {a: {mass: 1, shapes: [{type: box, half_size: [1, 1, 1]}]}}",
    "# ${not an expression}: a comment\nentities: {cube: {mass: 1}}",
    "description: repeat after me, if you use it\nentities: {a: {mass: {uniform: [1, 2]}}}",
    "x-note: {use: nothing, if: never}\nentities: {}",
    r'description: "a \"quoted\" text"',
    "entities: {use: {mass: 1}, if: {mass: 1}}",
    "entities: {repeat: {mass: 1}}\nmaterials: {repeat: {visual: {base_color_texture: {address_mode: repeat}}}}",
    "entities: {a: {visuals: [{type: tiled_plane, texture_repeat: [1, 2]}]}}",
    "entities: {a: {x-note: {repeat: {i: [1]}}, shapes: [{x-note: [{repeat: 1}], type: box}]}}",
]
EXPANDED = [
    "params: {}",
    "draws: {}",
    "include: []",
    "entities: {a: {mass: '${1}'}}",
    "entities: {a: {if: true}}",
    "entities: {a: {use: b.yaml}}",
    "entities: {a: {repeat: {i: [1]}}}",
    "entities: {a: {shapes: [{repeat: {i: [1]}, type: box}]}}",
    "entities: {a: {variants: [{shapes: [{repeat: {i: [1]}, type: box}]}]}}",
    'entities: {a: {material: "\\x24{m}"}}',
    'entities: {a: {"r\\x65peat": {i: [1]}}}',
    'entities: {a: {material: "$\\\n  {m}"}}',
    "x: &a {repeat: {i: [1]}}\nentities: {a: {<<: *a}}",
]


@pytest.mark.parametrize(("text", "needed"), [*((text, False) for text in PLAIN), *((text, True) for text in EXPANDED)])
def test_what_needs_it(text: str, *, needed: bool) -> None:
    document = read_text("scenecc: 1\n" + text, "s.yaml", Sink())
    assert document is not None
    found = needs_expansion(document.data, document.text)
    # What is not looked through may be thought to need it.
    assert found is needed or (not needed and "${" in text)
    assert needs_expansion(document.data, None) is needed


BALL = "{type: sphere, radius: 0.1}"


def codes(top: Path, **limits: int) -> list[str]:
    return [diagnostic.code for diagnostic in validate(top, limits=limits)]


def prefab(folder: Path, text: str) -> Path:
    """A scene with 100 instances of a prefab."""
    (folder / "part.yaml").write_text(f"scenecc: 1\n{text}\n", encoding="utf-8")
    top = folder / "top.yaml"
    top.write_text("scenecc: 1\nentities: {a: {use: part.yaml, repeat: {i: {count: 100}}}}\n", encoding="utf-8")
    return top


def named(count: int, node: str) -> str:
    return "{" + ", ".join(f"n{i}: {node}" for i in range(count)) + "}"


@pytest.mark.parametrize(
    "text",
    [
        "frames: " + named(50, "{pose: [0, 0, 0]}"),
        "materials: " + named(50, "{physical: {density: 3}}"),
        "draws: " + named(50, "{uniform: [0, 1]}"),
        "collision_groups: " + named(50, "{ignore: []}"),
        "params: " + named(200, "{type: number, default: 1}"),
        f"entities: {named(50, f'{{shapes: [{BALL}]}}')}",
        f"entities: {{b: {{shapes: [{', '.join([BALL] * 50)}]}}}}",
        f"entities: {{b: {{pick: 0, variants: [{', '.join([f'{{shapes: [{BALL}]}}'] * 50)}]}}}}",
        f"entities: {{b: {{mass: {{cycle: [{', '.join(['1'] * 2000)}]}}, shapes: [{BALL}]}}}}",
    ],
    ids=lambda text: text[:12],
)
def test_everything_in_a_prefab_counts_in_each_use(tmp_path: Path, text: str) -> None:
    top = prefab(tmp_path, text)
    assert "SC604" in codes(top, objects=4000)
    assert "SC604" not in codes(top, objects=60_000)


def test_shapes_and_long_lists_count_in_each_copy() -> None:
    ball: dict[str, Any] = {"type": "sphere", "radius": 0.1}
    many = {"repeat": {"i": {"count": 100}}, "shapes": [ball] * 50}
    long = {"repeat": {"i": {"count": 100}}, "shapes": [ball], "mass": {"cycle": [1] * 2000}}
    for entity in (many, long):
        document = {"scenecc": 1, "entities": {"a": entity}}
        assert [found.code for found in validate(document, limits={"objects": 4000})] == ["SC604"]
        assert validate(document, limits={"objects": 26_000}) == []


def test_lists_that_double_from_parameter_to_parameter() -> None:
    params: dict[str, Any] = {"p0": {"type": "list", "default": [1]}}
    for i in range(1, 60):
        params[f"p{i}"] = {"type": "list", "default": [f"${{p{i - 1}}}"] * 2}
    assert [found.code for found in validate({"scenecc": 1, "params": params}, limits={"objects": 10_000})] == ["SC604"]
    # The name is read before anything else is.
    document = {"scenecc": 1, "name": "${p1[0][0]}", "params": params}
    assert [found.code for found in validate(document, limits={"objects": 10_000})] == ["SC604"]


def test_lists_that_double_from_use_to_use(tmp_path: Path) -> None:
    head = "scenecc: 1\nparams: {l: {type: list, default: [1]}}\nentities: "
    for i in range(30):
        use = f"{{a: {{use: p{i + 1}.yaml, with: {{l: ['${{l}}', '${{l}}']}}}}}}\n"
        (tmp_path / f"p{i}.yaml").write_text(head + use, encoding="utf-8")
    (tmp_path / "p30.yaml").write_text(head + f"{{b: {{shapes: [{BALL}]}}}}\n", encoding="utf-8")
    assert codes(tmp_path / "p0.yaml", objects=10_000) == ["SC604"]


def test_repeat_is_a_key_of_shapes_and_entities_alone() -> None:
    rows = {"type": "list", "default": [{"repeat": {"i": {"count": 10**9}}, "a": "${1}"}]}
    assert validate({"scenecc": 1, "name": "x${len(l)}", "params": {"l": rows}}) == []
