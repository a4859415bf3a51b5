"""Distributions: moments, edges, what is refused of their operands, and that all else follows from the class."""

from __future__ import annotations

import json
import math
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest

from scenecc import CompileOptions, compile_scene, json_schema, plan_text, validate
from scenecc.spec import forms as written_forms
from scenecc.spec.forms import COMPANIONS
from scenecc.variation.distributions import DISTRIBUTIONS, OperandRule, Uniform
from scenecc.variation.evaluation import Batch
from scenecc.variation.node_bounds import BoundsAnalysis
from scenecc.variation.nodes import Drawn, Key

MANY = 60_000
KEY = Key("entities", "cube", "mass")
BALL = {"shapes": [{"type": "sphere", "radius": 0.1}]}


def drawn(kind: str, *operands: Any, shape: tuple[int, ...] = (), count: int = MANY) -> np.ndarray:
    return Batch(np.arange(count), 3, count, {}, {}).evaluate(Drawn(kind, operands, shape, KEY))


def scene(mass: Any, **keys: Any) -> dict[str, Any]:
    return {"scenecc": 1, "num_scenes": 4, "entities": {"ball": {"mass": mass, **BALL}}, **keys}


def codes(source: dict[str, Any], **options: Any) -> list[tuple[str, str | None]]:
    return [(one.code, one.path) for one in validate(source, **CompileOptions(**options))]


@pytest.mark.parametrize(("low", "mode", "high"), [(0, 0.2, 1), (-2, -2, 3), (1, 4, 4), (-1, 0, 1)])
def test_a_triangular_draw_has_its_moments(low: float, mode: float, high: float) -> None:
    found = drawn("triangular", low, mode, high)
    spread = (low**2 + mode**2 + high**2 - low * mode - low * high - mode * high) / 18
    assert found.mean() == pytest.approx((low + mode + high) / 3, abs=0.01)
    assert found.var() == pytest.approx(spread, rel=0.03)
    assert low <= found.min() < low + 0.1 * (high - low)
    assert high >= found.max() > high - 0.1 * (high - low)


@pytest.mark.parametrize(("a", "b"), [(1, 1), (2, 5), (0.5, 0.5), (0.05, 3), (40, 0.3), (300, 700)])
def test_a_beta_draw_has_its_moments(a: float, b: float) -> None:
    found = (drawn("beta", a, b, -1, 3) + 1) / 4
    assert found.mean() == pytest.approx(a / (a + b), abs=0.01)
    assert found.var() == pytest.approx(a * b / ((a + b) ** 2 * (a + b + 1)), rel=0.05)
    assert found.min() >= 0
    assert found.max() <= 1


@pytest.mark.parametrize(("a", "b"), [(0.001, 0.001), (1e6, 1e6), (0.001, 1e6), (1e6, 0.001)])
def test_a_beta_draw_is_a_number_at_the_ends_of_its_shapes(a: float, b: float) -> None:
    found = drawn("beta", a, b, 2, 3, count=2000)
    assert np.isfinite(found).all()
    assert found.mean() == pytest.approx(2 + a / (a + b), abs=0.05)


@pytest.mark.parametrize(
    ("mean", "std", "low", "high"), [(0, 1, -1, 2), (5, 2, -10, 1), (0, 1, 3, 4), (0, 1, -math.inf, -6)]
)
def test_a_truncated_normal_draw_has_its_moments(mean: float, std: float, low: float, high: float) -> None:
    low = max(low, -1e6)
    found = drawn("truncated_normal", mean, std, low, high)
    normal = NormalDist(mean, std)
    share = normal.cdf(high) - normal.cdf(low)
    expected = mean + std**2 * (normal.pdf(low) - normal.pdf(high)) / share
    assert found.mean() == pytest.approx(expected, abs=0.02 * std)
    assert low <= found.min()
    assert found.max() <= high
    # Nothing is put on the edges.
    assert ((found == low) | (found == high)).sum() == 0


@pytest.mark.parametrize("far", [36.5, 37.5, 60, 1e4])
def test_the_tail_of_a_truncated_normal_draw_falls_as_fast_as_it_should(far: float) -> None:
    for side in (1, -1):
        found = side * drawn("truncated_normal", 0, 1, *sorted((side * far, side * (far + 1))), count=20_000)
        assert found.min() >= far
        # The distance from the edge is exponential to one part in the square.
        assert (found - far).mean() == pytest.approx(1 / far, rel=0.03)


@pytest.mark.parametrize("kind", sorted(DISTRIBUTIONS))
def test_what_is_drawn_lies_within_the_bounds_that_are_told(kind: str) -> None:
    operands = {"triangular": (1, 2, 4), "beta": (2, 3, 1, 4), "truncated_normal": (9, 2, 1, 4), "normal": (2, 1, 1, 4)}
    node = Drawn(kind, operands.get(kind, (1, 4)), (), KEY)
    bounds, found = BoundsAnalysis({}, 1).bounds(node), drawn(kind, *node.operands, count=4000)
    assert (bounds.low, bounds.high) == (1, 4)
    assert bounds.low <= found.min() <= found.max() <= bounds.high


@pytest.mark.parametrize(
    ("mean", "std", "low", "high", "nearest"),
    [(1e10, 1e-300, 0.1, 1, 1), (5, 1e-310, -1, 1, 1), (1e17, 1, -1, 1, 1), (1e20, 1, 0, 1, 1), (-1e200, 1, 2, 3, 2)],
)
def test_a_mean_far_away_draws_the_nearest_edge(
    mean: float, std: float, low: float, high: float, nearest: float
) -> None:
    found = drawn("truncated_normal", mean, std, low, high, count=200)
    assert np.abs(found - nearest).max() < 1e-6


@pytest.mark.parametrize(("mean", "std"), [(0, 1e17), (5, 1e17), (0, 1e5), (-3, 1e38), (1e38, 1e38)])
def test_a_wide_deviation_draws_evenly(mean: float, std: float) -> None:
    found = drawn("truncated_normal", mean, std, -1, 1)
    assert found.mean() == pytest.approx(0, abs=0.01)
    assert found.var() == pytest.approx(1 / 3, rel=0.02)
    assert len(np.unique(found)) > 0.99 * MANY


def test_the_ways_to_draw_a_truncated_normal_meet() -> None:
    for first, second in ((36.999, 37.001), (-38.001, -37.999)):  # near the edge of the tail
        a, b = (drawn("truncated_normal", 0, 1, low, low + 1, count=500) - low for low in (first, second))
        assert np.abs(a - b).max() < 1e-3
    a, b = (drawn("truncated_normal", 1, 1, 0, width, count=500) / width for width in (0.99e-4, 1.01e-4))
    assert np.abs(a - b).max() < 1e-6


@pytest.mark.parametrize("scale", [1e-170, 1e-300, 1.0, 1e199])
def test_a_triangular_draw_is_as_good_at_any_scale(scale: float) -> None:
    found = drawn("triangular", 0.0, scale, 2 * scale, count=5000) / scale
    assert np.abs(found - drawn("triangular", 0.0, 1.0, 2.0, count=5000)).max() < 1e-12


@pytest.mark.parametrize("kind", sorted(DISTRIBUTIONS))
def test_equal_edges_leave_one_number(kind: str) -> None:
    operands = {"triangular": (2, 2, 2), "beta": (2, 3, 2, 2), "truncated_normal": (9, 2, 2, 2), "normal": (5, 1, 2, 2)}
    node = Drawn(kind, operands.get(kind, (2, 2)), (), KEY)
    assert set(drawn(kind, *node.operands, count=50).tolist()) == {2}


def test_bounds_that_may_break_are_told_before_anything_is_drawn() -> None:
    half = {"draws": {"x": {"uniform": [-1, 2]}}}
    assert codes(scene({"beta": ["${x}", 1], "range": [1, 2]}, **half)) == [("SC515", "entities.ball.mass")]
    assert codes(scene({"beta": ["${x + 0.95}", 1], "range": [1, 2]}, **half)) == [("SC516", "entities.ball.mass")]
    assert codes(scene({"beta": ["${x + 2e6}", 1], "range": [1, 2]}, **half)) == [("SC515", "entities.ball.mass")]
    assert codes(scene({"triangular": [1, "${x + 1.5}", 2]}, **half)) == [("SC515", "entities.ball.mass")]
    assert codes(scene({"truncated_normal": [1, "${x}"], "range": [1, 2]}, **half)) == [("SC515", "entities.ball.mass")]
    assert codes(scene({"triangular": [1, "${1.5}", 2]})) == []


def test_a_parameter_takes_them_within_its_range() -> None:
    asked = scene("${m}", params={"m": {"default": 1, "min": 0.5, "max": 2}})
    assert codes(asked, params={"m": {"beta": [2, 2], "range": [0.5, 2]}}) == []
    assert codes(asked, params={"m": {"triangular": [0.5, 1, 2]}}) == []
    assert [code for code, _ in codes(asked, params={"m": {"beta": [2, 2], "range": [0.1, 2]}})] == ["SC212"]
    assert [code for code, _ in codes(asked, params={"m": {"triangular": [0.5, 1, 3]}})] == ["SC212"]
    assert [code for code, _ in codes(asked, params={"m": {"truncated_normal": [1, 1]}})] == ["SC212"]
    vector = {"v": {"type": "vector", "default": [0, 0, 0]}}
    placed = {"scenecc": 1, "params": vector, "entities": {"ball": {"pose": "${v}", **BALL}}}
    sized = {"beta": [2, 3], "range": [[0, 0, 0], [1, 1, 1]]}
    assert codes(placed, params={"v": sized}) == []
    assert [code for code, _ in codes(placed, params={"v": {"beta": [2, 3], "range": [0, 1]}})] == ["SC211"]


@pytest.mark.parametrize("kind", sorted(DISTRIBUTIONS))
def test_a_plan_holds_its_recipe_and_gives_it_back(kind: str) -> None:
    distribution = DISTRIBUTIONS[kind]
    lists = {"triangular": [1, 2, 4], "beta": [2, 3]}
    form: dict[str, Any] = {kind: lists.get(kind, [1, 4])}
    if distribution.companion:
        form[distribution.companion] = [1, 4]
    velocity = {"linear_velocity": [form, 0, 0]}
    plan = compile_scene({"scenecc": 1, "num_scenes": 3, "entities": {"ball": {**BALL, **velocity}}})
    text = plan_text(plan)
    assert f'"kind": "{kind}"' in text
    assert plan_text(compile_scene(text)) == text


@pytest.mark.parametrize("kind", sorted(DISTRIBUTIONS))
def test_the_schema_and_the_reader_know_it_by_its_class(kind: str) -> None:
    number_form = json_schema()["$defs"]["NumberForm"]
    distribution = DISTRIBUTIONS[kind]
    assert number_form["properties"][kind]["description"] == distribution.description
    assert {"required": [kind]} in number_form["oneOf"]
    assert COMPANIONS.get(kind) == distribution.companion
    if distribution.needs_companion:
        assert number_form["dependentRequired"][kind] == [distribution.companion]
    assert len(distribution.operands) == len(distribution.roles) == len(distribution.members)
    # Words for every operand whose order is judged.
    judged = {i for one in distribution.holding(len(distribution.operands)) for i in (one.greater, one.less)}
    ordered = [one for one in distribution.holding(len(distribution.operands)) if None not in (one.greater, one.less)]
    assert not ordered or {distribution.operands[i] for i in judged if i is not None} <= set(
        written_forms._OPERAND_WORDS
    )
    assert json.dumps(number_form)


def test_what_takes_longer_to_draw_counts_for_more() -> None:
    def told(form: dict[str, Any]) -> list[str]:
        draws = {f"d{i}": form for i in range(200)}
        return [code for code, _ in codes({"scenecc": 1, "num_scenes": 65_536, "draws": draws}) if code == "SC604"]

    assert told({"uniform": [0, 1]}) == []
    assert told({"beta": [2, 2], "range": [0, 1]}) == ["SC604"]


def test_a_condition_of_a_new_distribution_is_read_as_it_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    class Above(Uniform):
        key = "uniform"
        conditions = (OperandRule("too low", 0, limit=2.0), OperandRule("too high", None, 1, limit=5.0, strict=True))

    monkeypatch.setitem(DISTRIBUTIONS, "uniform", Above())
    told = [one.message for one in validate(scene({"uniform": [1, 5]}))]
    assert [text.partition("must be ")[2] for text in told] == ["at least 2", "less than 5"]
    assert codes(scene({"uniform": [2, 4]})) == []
