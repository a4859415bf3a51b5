"""Frozen dataclasses behave as those of the standard library."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from dataclasses import dataclass, field
from typing import Any

import pytest

from scenecc.diagnostics.frozen import frozen


@frozen
class Quick:
    """Two fields and one that is not compared."""

    a: int
    b: str = "x"
    c: object = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Plain:
    """The same."""

    a: int
    b: str = "x"
    c: object = field(default=None, compare=False)


@frozen
class Empty:
    """No field."""


@frozen
class Single:
    """One field."""

    a: object


@pytest.mark.parametrize("cls", [Quick, Plain])
def test_frozen_instances_have_eq_hash_and_repr(cls: Any) -> None:
    one = cls(1)
    assert (one.a, one.b, one.c) == (1, "x", None)
    assert one == cls(1, "x", object())
    assert one != cls(2)
    assert one != (1, "x")
    assert hash(one) == hash(cls(1, c=3))
    assert repr(one) == f"{cls.__name__}(a=1, b='x', c=None)"
    assert dataclasses.replace(one, b="y") == cls(1, "y")
    assert [item.name for item in dataclasses.fields(one)] == ["a", "b", "c"]
    assert cls.__match_args__ == ("a", "b", "c")
    assert not hasattr(one, "__dict__")


@pytest.mark.parametrize("cls", [Quick, Plain])
def test_frozen_instances_cannot_be_changed(cls: Any) -> None:
    one = cls(1)
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot assign to field 'a'"):
        one.a = 2
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot delete field 'a'"):
        del one.a
    with pytest.raises(TypeError):
        cls()
    with pytest.raises(TypeError):
        cls(1, d=2)


@pytest.mark.parametrize("item", [Quick(1, "y", (2,)), Empty(), Single(None)])
def test_frozen_instances_can_be_copied_and_pickled(item: Any) -> None:
    assert pickle.loads(pickle.dumps(item)) == item
    assert copy.deepcopy(item) == item
    assert repr(copy.copy(item)) == repr(item)


def test_frozen_classes_may_have_any_number_of_fields() -> None:
    assert Empty() == Empty()
    assert hash(Empty()) == hash(Empty())
    assert Empty() != Single(())
    assert Single((1, 2)) == Single((1, 2)) != Single((2, 1))
