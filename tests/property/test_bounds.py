"""What `validate` says nothing about compiles with any seed, and what it calls an error compiles with none."""

from __future__ import annotations

from random import Random
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from plugins.nightly import examples

from scenecc import SceneError, compile_scene, plan_text, validate

RANDOMS = st.integers(0, 2**32).map(Random)
"""What scenes are made of: to draw each end by Hypothesis takes longer than to compile it."""

NUMBERS = (0, 0.1, 0.5, 1, 2, -1, 3)
DRAWS = {
    "a": {"uniform": [0, 1]},
    "n": {"integers": [0, 3]},
    "k": {"choice": [1, 2]},
    "v": {"uniform": [[0.1] * 3, [1] * 3]},
}
READS = (
    "a",
    "n",
    "k",
    "v",
    "scene",
    "num_scenes",
    "p",
    "-a",
    "a + 1",
    "a - 0.5",
    "v / 2",
    "v * 2",
    "v[n]",
    "1 / n",
    "a / a",
)
READS += (
    "max(a, 0.5)",
    "min(n, 1)",
    "[a, a, k]",
    "floor(a)",
    "sqrt(a - 0.5)",
    "'abc'",
    "a > 0.5",
    "v[0] if a > 0.5 else 1",
)

FIELDS = ("mass", "gravity", "color", "linear_velocity", "pose", "shading_mode", "solver_position_iterations")


def plain(random: Random) -> Any:
    vector = [random.choice(NUMBERS) for _ in range(random.choice([3, 3, 3, 4, 2]))]
    return random.choice([random.choice(NUMBERS)] * 4 + [vector] * 3 + [True, "abc", "#457b9d", "#10101080", "x"])


def end(random: Random, depth: int) -> Any:
    """A plain value, an expression, a form, or a list of them."""
    kind = random.random()
    if kind < 0.5 or not depth:
        return plain(random)
    if kind < 0.7:
        return f"${{{random.choice(READS)}}}"
    if kind < 0.9:
        return form(random, depth - 1)
    return [end(random, 0) if random.random() < 0.7 else f"${{{random.choice(READS)}}}" for _ in range(3)]


def form(random: Random, depth: int = 2) -> Any:
    name = random.choice(["uniform", "uniform", "integers", "log_uniform", "normal", "choice", "cycle", "per_scene"])
    if name in {"choice", "cycle"}:
        return {name: [end(random, depth) for _ in range(random.randint(1, 3))]}
    if name == "per_scene":
        return {name: {"0": end(random, depth), "default": end(random, depth)}}
    made = {name: [end(random, depth), end(random, depth)]}
    return {**made, "clip": [end(random, depth), end(random, depth)]} if name == "normal" else made


def scene_of(random: Random) -> dict[str, Any]:
    """A scene with one form that is read by a field, or is a field, or is read by nothing."""
    made, field = form(random), random.choice(FIELDS)
    how = random.choice(["read", "inside", "unread"])
    body: dict[str, Any] = {"shapes": [{"type": "sphere", "radius": 0.1}]}
    if how != "unread":
        body[field] = made if how == "inside" else "${h}"
    draws = DRAWS if how == "inside" else {**DRAWS, "h": made}
    return {"scenecc": 1, "num_scenes": 3, "params": {"p": 0.7}, "draws": draws, "entities": {"body": body}}


UNREAD = ("SC319", "SC322")


def contradictions(scene: dict[str, Any]) -> list[str | None]:
    """What compilations with some seeds say against what was said before anything was drawn."""
    found = validate(scene)
    failures = [failure(scene, seed) for seed in range(4)]
    if any(one.severity == "error" for one in found):
        return [one for one in failures if one is None]
    return [one for one in failures if one is not None] if all(one.code in UNREAD for one in found) else []


def failure(scene: dict[str, Any], seed: int) -> str | None:
    """The first error of a compilation."""
    try:
        plan_text(compile_scene(scene, seed=seed))
    except SceneError as error:
        return next(str(one) for one in error.diagnostics if one.severity == "error")
    return None


@given(RANDOMS)
@settings(max_examples=examples(150))
def test_what_is_said_of_a_draw_before_it_is_drawn_holds(random: Random) -> None:
    assert contradictions(scene_of(random)) == []
