"""Overrides that a stranger might write: circles, thousands of names, long paths, and what counts as objects."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from plugins.nightly import assert_took

from scenecc import validate

BALL = "{type: sphere, radius: 0.1}"
PREFAB = f"scenecc: 1\nentities:\n  ball: {{repeat: {{i: {{count: 1000}}}}, shapes: [{BALL}]}}\n"


def codes(folder: Path, text: str, **limits: int) -> list[str]:
    """The codes of a scene that may use `PREFAB`, each once."""
    (folder / "balls.yaml").write_text(PREFAB)
    file = folder / "scene.yaml"
    file.write_text("scenecc: 1\n" + text)
    return list(dict.fromkeys(found.code for found in validate(file, limits=limits)))


def used(copies: int, override: str) -> str:
    """Entities: the prefab, used so many times."""
    return f"entities:\n  a:\n    repeat: {{i: {{count: {copies}}}}}\n    use: balls.yaml\n    override:\n{override}"


def overrides(count: int, value: str, start: int = 0) -> str:
    return "".join(f"      ball_{i}: {value}\n" for i in range(start, start + count))


def test_a_thousand_names(tmp_path: Path) -> None:
    began = time.perf_counter()
    assert codes(tmp_path, used(1, overrides(1000, "{mass: 2}"))) == []
    assert codes(tmp_path, used(1, overrides(1000, "{mass: 2}", 1000))) == ["SC243"]
    assert_took(time.perf_counter() - began, most=20)


@pytest.mark.parametrize(
    "value", ["{shapes: [" + ", ".join([BALL] * 50) + "]}", "{shapes: [{repeat: {k: {count: 50}}, " + BALL[1:] + "]}"]
)
def test_what_overrides_add_counts(tmp_path: Path, value: str) -> None:
    assert codes(tmp_path, used(10, overrides(100, value)), objects=40_000) == ["SC604"]
    assert codes(tmp_path, used(1, overrides(100, value)), objects=40_000) == []


def test_many_instances_with_many_overrides_count(tmp_path: Path) -> None:
    assert codes(tmp_path, used(1000, overrides(500, "{mass: 2}"))) == ["SC604"]


def test_a_path_of_many_steps(tmp_path: Path) -> None:
    path = "/".join(["a"] * 400)
    assert codes(tmp_path, f"entities: {{a: {{use: balls.yaml, override: {{{path}: {{mass: 1}}}}}}}}") == ["SC243"]
    deep = "{pose: " * 90 + "[0, 0, 0]" + "}" * 90
    found = codes(tmp_path, f"entities: {{a: {{use: balls.yaml, override: {{ball_0: {deep}}}}}}}")
    assert found
    assert "SC500" not in found


def test_a_chain_of_prefabs_that_override_one_another(tmp_path: Path) -> None:
    (tmp_path / "p0.yaml").write_text(f"scenecc: 1\nentities: {{ball: {{shapes: [{BALL}]}}}}\n")
    for i in range(1, 25):
        inside = "/".join(["in"] * (i - 1) + ["ball"])
        (tmp_path / f"p{i}.yaml").write_text(
            f"scenecc: 1\nentities: {{in: {{use: p{i - 1}.yaml, override: {{{inside}: {{mass: {i}}}}}}}}}\n"
        )
    assert codes(tmp_path, "entities: {top: {use: p24.yaml}}") == []


@pytest.mark.parametrize(
    ("override", "code"),
    [
        ("ball_0: {pose: {relative_to: a/ball_1}}, ball_1: {pose: {relative_to: a/ball_0}}", "SC304"),
        ("ball_0: {pose: {relative_to: a/ball_0}}", "SC304"),
        ("ball_0: remove, ball_1: {pose: {relative_to: a/ball_0}}", "SC245"),
    ],
)
def test_circles(tmp_path: Path, override: str, code: str) -> None:
    assert codes(tmp_path, f"entities: {{a: {{use: balls.yaml, override: {{{override}}}}}}}") == [code]


def test_a_prefab_that_overrides_itself_is_a_circle_of_files(tmp_path: Path) -> None:
    assert codes(tmp_path, "entities: {a: {use: scene.yaml, override: {a: {pose: [0, 0, 1]}}}}") == ["SC232"]
