"""One field of a plan in the engine: its value in the plan, and the calls of SAPIEN that a person writes for it.

Nothing here uses the backend's tables of setters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from fidelity.compare import assert_same_scene, assert_same_trajectory, scene_facts
from fidelity.hand import built

from scenecc.backends.sapien import SceneBatch
from scenecc.plan import ScenePlan, constant
from scenecc.plan.properties import Quantity
from scenecc.plan.schema import plan_fields
from scenecc.plan.value import recalled
from scenecc.variation.nodes import Const

RowKey = tuple[type, str] | tuple[type, str, str]
"""A dataclass of the plan and its field; of a drive or a limit of one axis also the axis."""


@dataclass(frozen=True)
class Row:
    """A field of the plan.

    Attributes:
        value: an unusual one.
        by_hand: sets a value on the object of the engine.
        other: a value before a reset draws `value`; None: no reset draws the field.
        dtype: of the field; None: it holds a plain word, number or flag.
        state: whether `SceneState.drawn` has it.
    """

    value: Any
    by_hand: Callable[..., object]
    other: Any = None
    dtype: Any = np.float64
    state: bool = True

    def built(self) -> Any:
        """The value in a plan, the same in every scene."""
        return self.value if self.dtype is None else constant(self.value, self.dtype)

    def drawn_at_reset(self) -> Any:
        """`other` where it is built, and `value` after every reset."""
        value = tuple(self.value) if isinstance(self.value, list) else self.value
        return recalled(np.array([self.other], self.dtype), Const(value))


Changes = Mapping[type, Mapping[str, Any]]
"""Fields of some dataclasses of a plan that are replaced."""

Hooks = Mapping[type, Callable[[Any], object]]
"""By dataclass of a plan: what a person does to the object of the engine that it becomes."""


@dataclass(frozen=True)
class Setting:
    """A scene in which rows are tested.

    Attributes:
        plan: its plan.
        by_hand: the same as a `sapien.Scene`.
        find: the object of a dataclass in a live scene.
        rows: the fields that are tested in it.
        rendered: whether it needs a device to render with.
    """

    plan: Callable[[Changes], ScenePlan]
    by_hand: Callable[[Hooks], Any]
    find: Callable[[Any, type], Any]
    rows: Mapping[RowKey, Row]
    rendered: bool = False

    def batch(self, key: RowKey, value: Any) -> SceneBatch:
        """The scene that is built with a value of a row."""
        return built(self.plan({key[0]: {key[1]: value, **_axis(key)}}), render=self.rendered)

    def hand(self, key: RowKey, value: Any) -> Any:
        """The scene by hand."""
        return self.by_hand({key[0]: lambda obj: self.rows[key].by_hand(obj, value, *_axis(key).values())})

    def assert_built(self, key: RowKey) -> None:
        """Builds a field with its value: everything that the engine gives back, and 30 steps, are those of the scene by
        hand, and not those of the scene without it.
        """
        row = self.rows[key]
        with self.batch(key, row.built()) as batch:
            hand = self.hand(key, row.value)
            assert_same_scene(batch.scenes[0], hand)
            assert_same_trajectory(batch.scenes, [hand], 30)
        plain, unusual = self.by_hand({key[0]: lambda _: None}), self.hand(key, row.value)
        assert scene_facts(plain) != scene_facts(unusual) or _end(plain) != _end(unusual), "the value has no effect"

    def assert_reset(self, key: RowKey) -> None:
        """Resets a field to its value. What a person sets afterwards is in the saved state."""
        row = self.rows[key]
        with self.batch(key, row.drawn_at_reset()) as batch:
            assert_same_scene(batch.scenes[0], self.hand(key, row.other))
            batch.reset()
            assert_same_scene(batch.scenes[0], self.hand(key, row.value))
            if not row.state:
                return
            (name,) = batch.state().drawn
            assert name.endswith(key[1])
            self.rows[key].by_hand(self.find(batch.scenes[0], key[0]), row.other, *_axis(key).values())
            numbers = batch.state().drawn[name].numbers.ravel()[: np.size(row.other)]
            assert np.allclose(numbers, np.ravel(row.other), rtol=1e-6)


def _axis(key: RowKey) -> dict[str, str]:
    return {} if len(key) == 2 else {"axis": key[2]}


def _end(scene: Any) -> bytes:
    for _ in range(30):
        scene.step()
    return scene.pack_poses()


def value_fields(*classes: type) -> set[tuple[type, str]]:
    """Every field that holds a `Value`."""
    return {(cls, slot.name) for cls in classes for slot in plan_fields(cls) if isinstance(slot.kind, Quantity)}
