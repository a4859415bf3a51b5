"""Values: what they hold, when they draw, when two are equal."""

from __future__ import annotations

import pickle
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from scenecc.plan import Value, constant, literal, per_scene, varying

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray


class _Bounds:
    """A support that is known by its bounds."""

    def __init__(self, *numbers: float) -> None:
        self._numbers = numbers

    def numbers(self) -> tuple[float, ...]:
        return self._numbers


def _drawn(rows: Any, recipe: Any = None, log: list[int] | None = None) -> Value:
    data = np.array(rows)

    def draw() -> NDArray[Any]:
        if log is not None:
            log.append(1)
        return data

    support: Any = _Bounds(0.0, 9.0)
    return varying(draw, draw, range(len(data)), bounds=lambda: support, recipe=recipe)


def _never() -> NDArray[Any]:
    raise AssertionError("drawn")


def test_asking_what_a_value_can_be_draws_nothing() -> None:
    support: Any = _Bounds(1.0, 2.0)
    value = varying(_never, _never, range(4), bounds=lambda: support)
    assert value.numbers() == (1.0, 2.0)
    assert value.bounds is support
    assert value.may_vary
    assert value.recipe is None
    assert "rows=4" in repr(value)
    with pytest.raises(AssertionError, match="drawn"):
        _ = value.data


def test_is_drawn_once_and_is_read_only_then() -> None:
    log: list[int] = []
    value = _drawn([1.0, 2.0, 3.0], log=log)
    assert value.data.tolist() == value.data.tolist() == [1.0, 2.0, 3.0]
    assert value.row(1) == 2.0
    assert value.varies
    assert log == [1]
    with pytest.raises(ValueError, match="read-only"):
        value.data[0] = 5.0


def test_rows_drawn_alike_are_one_row_and_numbers_stay_those_of_the_support() -> None:
    value = _drawn([2.0, 2.0])
    assert value.data.tolist() == [2.0]
    assert not value.varies
    assert value.may_vary
    assert value.numbers() == (0.0, 9.0)
    assert value == literal(2.0)


def test_a_draw_of_another_count_is_refused() -> None:
    support: Any = _Bounds()
    value = varying(lambda: np.zeros(3), _never, range(4), bounds=lambda: support)
    with pytest.raises(ValueError, match="3 rows were drawn for 4 scenes"):
        _ = value.data


def test_recipes_are_part_of_what_is_equal() -> None:
    assert _drawn([1.0, 2.0], ("a", 1)) == _drawn([1.0, 2.0], ("a", 1))
    assert _drawn([1.0, 2.0], ("a", 1)) != _drawn([1.0, 2.0], ("a", 1.0))
    assert _drawn([1.0, 2.0], ("a", 0.0)) != _drawn([1.0, 2.0], ("a", -0.0))
    assert _drawn([1.0, 2.0], ("a", 1)) != _drawn([1.0, 2.0])
    assert _drawn([1.0, 2.0]) == per_scene([1.0, 2.0])
    assert hash(_drawn([1.0, 2.0], ("a",))) == hash(per_scene([1.0, 2.0]))


@pytest.mark.parametrize(
    "make", [lambda: literal((1.0, 2.0)), lambda: constant(3, "int64"), lambda: _drawn([1.0, 2.0], ("a",))]
)
def test_pickles(make: Callable[[], Value]) -> None:
    value = make()
    again: Value = pickle.loads(pickle.dumps(value))
    assert again == value
    assert again.recipe == value.recipe
    assert again.numbers() == value.numbers()
    assert not again.data.flags.writeable


def test_nothing_of_a_value_can_be_changed() -> None:
    value: Any = _drawn([1.0, 2.0])
    with pytest.raises(AttributeError, match="read-only"):
        value.data = np.zeros(1)
    with pytest.raises(AttributeError, match="read-only"):
        del value.data
    with pytest.raises(AttributeError, match="no attribute 'rows'"):
        _ = value.rows
