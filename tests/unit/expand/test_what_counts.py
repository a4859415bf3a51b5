"""What a file from a stranger may ask for: all that a use makes counts, however it is written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from scenecc import validate

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
