"""Recipes for Hypothesis: nodes that give numbers of a wanted shape, every type of node among them."""

from __future__ import annotations

import string
from typing import Any

from hypothesis import strategies as st

from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.forms import Template
from scenecc.variation.nodes import (
    AffineClamp,
    Chosen,
    Composed,
    Computed,
    Const,
    Converted,
    Cycled,
    Drawn,
    FromAxisAngle,
    FromMatrix,
    FromRpy,
    Key,
    Looking,
    Node,
    Normalized,
    Pointing,
    Posed,
    Radians,
    RandomRotated,
    Rows,
    Shared,
    Stacked,
)

Shape = tuple[int, ...]
Draws = dict[str, Shape]

_NUMBERS = st.floats(-10, 10, allow_nan=False) | st.integers(-10, 10)
_KEYS = st.builds(
    Key,
    st.sampled_from(["entities", "draws", "frames", "materials"]),
    st.text(string.ascii_letters + 'é"/.', min_size=1, max_size=6),
    st.sampled_from(["pose.p", "linear_velocity", "pose.rpy.choice[1]"]),
)
_WORDS = st.integers(0, 7)
_KINDS = st.sampled_from(sorted(DISTRIBUTIONS))


def plain(shape: Shape) -> st.SearchStrategy[Any]:
    """Numbers, or tuples of them to the depth of the shape."""
    strategy: st.SearchStrategy[Any] = _NUMBERS
    for size in reversed(shape):
        strategy = st.tuples(*[strategy] * size)
    return strategy


def items(shape: Shape, draws: Draws, depth: int) -> st.SearchStrategy[Any]:
    """Plain values, or nodes where the depth allows."""
    return plain(shape) if depth <= 0 else plain(shape) | nodes(shape, draws, depth)


def nodes(shape: Shape, draws: Draws, depth: int = 2) -> st.SearchStrategy[Node]:
    """Nodes of a shape: (), (n,) or (4, 4)."""
    inner = items(shape, draws, depth - 1)
    some: list[st.SearchStrategy[Any]] = [
        st.builds(Const, plain(shape)),
        _rows(shape, draws, depth),
        st.builds(Cycled, st.lists(inner, min_size=1, max_size=3).map(tuple)),
        _chosen(inner),
        *[st.just(Shared(name)) for name, its in draws.items() if its == shape],
    ]
    if len(shape) < 2:
        some.append(_drawn(shape, draws, depth))
        some.append(_computed(shape, draws))
        some.append(st.builds(Radians, inner))
    if shape in {(3,), (4,)}:
        # Of lists only: whatever else it takes stands in a file's expressions.
        some.append(st.builds(Converted, inner, st.just("color" if shape == (4,) else "scale")))
    if not shape:
        bounds = st.tuples(*[items((), draws, depth - 1)] * 4)
        number = st.tuples(items((), draws, depth - 1), st.just(-1))
        listed = st.tuples(items((3,), draws, depth - 1), st.integers(0, 2))
        some.append(st.tuples(number | listed, bounds).map(lambda made: AffineClamp(*made[0], *made[1])))
    if shape:
        part = items(shape[1:], draws, depth - 1)
        some.append(st.builds(Stacked, st.tuples(*[part] * shape[0])))
    return st.one_of(*some, *_placing(shape, lambda wanted: items(wanted, draws, depth - 1)))


def _placing(shape: Shape, of: Any) -> list[st.SearchStrategy[Any]]:
    if shape == (4,):
        return [
            st.builds(RandomRotated, _KEYS),
            st.builds(Normalized, of((4,))),
            st.builds(FromRpy, of((3,))),
            st.builds(FromAxisAngle, of((3,)), of(())),
            st.builds(Looking, of((3,)), of((3,))),
            st.builds(Pointing, of((3,))),
        ]
    if shape == (7,):
        poses = st.builds(Posed, of((3,)), of((4,)))
        return [poses, st.builds(FromMatrix, of((4, 4))), st.builds(Composed, of((7,)), of((7,)))]
    return []


@st.composite
def _rows(draw: st.DrawFn, shape: Shape, draws: Draws, depth: int) -> Rows:
    idxs = tuple(sorted(draw(st.sets(st.integers(0, 9), min_size=1, max_size=3))))
    return Rows(idxs, tuple(draw(items(shape, draws, depth - 1)) for _ in idxs))


@st.composite
def _chosen(draw: st.DrawFn, inner: st.SearchStrategy[Any]) -> Chosen:
    found = tuple(draw(st.lists(inner, min_size=1, max_size=3)))
    weights = draw(st.none() | st.tuples(*[st.floats(0.1, 5)] * len(found)))
    return Chosen(found, weights, draw(_KEYS), draw(_WORDS))


@st.composite
def _drawn(draw: st.DrawFn, shape: Shape, draws: Draws, depth: int) -> Drawn:
    bound = items((), draws, depth - 1) | items(shape, draws, depth - 1)
    drawn = DISTRIBUTIONS[draw(_KINDS)]
    count = len(drawn.operands) + (2 if drawn.companion and draw(st.booleans()) else 0)
    return Drawn(drawn.key, tuple(draw(bound) for _ in range(count)), shape, draw(_KEYS), draw(_WORDS))


@st.composite
def _computed(draw: st.DrawFn, shape: Shape, draws: Draws) -> Computed:
    name = draw(st.sampled_from([*draws, "scene", "num_scenes"]))
    constants: dict[str, Any] = draw(
        st.dictionaries(st.sampled_from(["a", "b"]), _NUMBERS | st.lists(_NUMBERS), max_size=2)
    )
    word = "it" if name in draws else name
    text = f"${{{word}}}" + "".join(f" ${{{constant}}}" for constant in constants)
    return Computed(Template(text, constants), shape, ((("it", name),) if name in draws else ()))
