"""Every table has a row for each node and form, and long chains of draws work."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from scenecc.plan import recipes
from scenecc.spec.json_schema import json_schema
from scenecc.spec.params import Draw
from scenecc.variation import evaluation, forms, node_bounds
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.evaluation import Batch
from scenecc.variation.forms import FORM_KEYS, Template
from scenecc.variation.node_bounds import BoundsAnalysis
from scenecc.variation.nodes import (
    NODES,
    Chosen,
    Computed,
    Const,
    Cycled,
    Drawn,
    Key,
    Node,
    Rows,
    Shared,
    draws_read_by,
    evaluation_order,
)
from scenecc.variation.operations import DrawError


@pytest.mark.parametrize(
    "table",
    [evaluation.EVALUATORS, node_bounds.NODE_BOUNDS, recipes._NODE_SHAPES],
    ids=["evaluate", "support_rules", "recipe_shape"],
)
def test_every_node_has_a_row(table: Any) -> None:
    assert set(table) == set(NODES)


def test_every_form_has_a_key() -> None:
    # A map by scene has the key of the list, and the others have none.
    keyless = {forms.SceneMap, forms.RandomRotation, forms.Vector}
    assert {*forms.LIST_FORMS.values(), forms.DrawForm, forms.Once} | keyless == set(forms.Form.__args__)
    assert {*forms.LIST_FORMS, *DISTRIBUTIONS, forms.ONCE} == FORM_KEYS


@pytest.mark.parametrize("key", sorted(FORM_KEYS))
def test_every_form_is_read_and_published(key: str) -> None:
    form: dict[str, Any] = {key: {"choice": [1, 2]} if key == forms.ONCE else [1, 2]}
    if key in DISTRIBUTIONS:
        form[key] = [1, 2, 3][: len(DISTRIBUTIONS[key].operands)]
        if DISTRIBUTIONS[key].needs_companion:
            form[str(DISTRIBUTIONS[key].companion)] = [1, 2]
    read = TypeAdapter(Draw).validate_python(form)
    assert type(read) is {**forms.LIST_FORMS, forms.ONCE: forms.Once}.get(key, forms.DrawForm)
    assert f'"{key}"' in json.dumps(json_schema())


LONG = 10_000
SCENES = np.arange(4)
UNIT = Drawn("uniform", (0.0, 1.0), (), Key("draws", "d0", ""))


def plus_one(number: int) -> Node:
    return Computed(Template(f"${{d{number} + 1}}"), None)


def chain(first: Node, length: int = LONG) -> dict[str, Node]:
    return {"d0": first, **{f"d{i}": plus_one(i - 1) for i in range(1, length)}}


@pytest.mark.parametrize("first", [UNIT, Cycled((1, 2)), Const(1)])
def test_a_long_chain_is_as_good_as_a_short_one(first: Node) -> None:
    draws = chain(first)
    node = Shared(f"d{LONG - 1}")
    rows = Batch(SCENES, 0, 4, draws, {}).evaluate(node)
    start = Batch(SCENES, 0, 4, draws, {}).evaluate(Shared("d0"))
    assert np.allclose(rows, start + LONG - 1)
    found = BoundsAnalysis(draws, 4).bounds(node)
    assert found.low <= rows.min() <= rows.max() <= found.high <= LONG + 1


def test_a_long_chain_of_alternatives_reads_what_the_one_before_gives() -> None:
    # Each is evaluated for a part of the scenes, and reads the one before in these.
    draws: dict[str, Node] = {"d0": Cycled((1, 2))}
    for i in range(1, 1000):
        draws[f"d{i}"] = Cycled((Shared(f"d{i - 1}"), 5, plus_one(i - 1)))
    rows = Batch(np.arange(6), 0, 6, draws, {}).evaluate(Shared("d999"))
    assert rows.tolist() == [1, 5, 1000, 2, 5, 1001]


def test_a_draw_without_a_value_is_missed_only_where_it_is_read() -> None:
    draws: dict[str, Node] = {"only": Rows((1,), (7.0,)), "next": Computed(Template("${only + 1}"), None)}
    batch = Batch(np.arange(2), 0, 2, draws, {})
    assert batch.evaluate(Cycled((0.0, Shared("next")))).tolist() == [0.0, 8.0]
    for _ in range(2):
        with pytest.raises(DrawError, match="no value is given") as caught:
            batch.evaluate(Shared("next"))
        assert caught.value.scene == 0


def test_a_given_draw_asks_for_none_of_those_it_would_read() -> None:
    draws: dict[str, Node] = {"a": Rows((), ()), "b": Computed(Template("${a}"), None)}
    given = {"b": np.array([3.0, 4.0])}
    assert Batch(np.arange(2), 0, 2, draws, given).evaluate(Shared("b")).tolist() == [3.0, 4.0]


def test_alternatives_deep_within_one_another_and_a_chain_of_such() -> None:
    draws: dict[str, Node] = {"d0": Const(0)}
    for i in range(1, 16):
        node: Node = plus_one(i - 1)
        for depth in range(40):
            node = Chosen((node,), None, Key("draws", f"d{i}", f"[{depth}]"))
        draws[f"d{i}"] = node
    assert BoundsAnalysis(draws, 1).bounds(Computed(Template("${d10}"), ())).alternatives == (10,)


def test_what_is_read_comes_first() -> None:
    draws: dict[str, Node] = {
        "a": Const(1),
        "b": Computed(Template("${x + num_scenes + scene}"), None, (("x", "a"),)),
        "c": Chosen((Shared("b"), Cycled((1, Shared("a")))), None, Key("draws", "c", "")),
    }
    assert draws_read_by(draws["b"]) == ["a"]
    assert sorted(draws_read_by(draws["c"])) == ["a", "b"]
    assert evaluation_order("c", draws, lambda _name: False) == ["a", "b", "c"]
    assert evaluation_order("c", draws, {"a"}.__contains__) == ["b", "c"]
