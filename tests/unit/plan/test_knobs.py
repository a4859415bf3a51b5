"""The table of what can be said of bodies and shapes covers them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, make_dataclass

import pytest

from scenecc.plan import BodyStructure, CollisionShape, Joint, Value
from scenecc.plan.properties import (
    ANY,
    COUNT,
    JOINT_PROPERTIES,
    POSITIVE,
    PROPERTIES,
    Property,
    Quantity,
    property_fields,
)
from scenecc.plan.schema import ScalarKind, plan_fields


@pytest.mark.parametrize(
    ("cls", "parts", "others"),
    [
        (BodyStructure, ("mass", "body", "groups", "look"), set[str]()),
        (CollisionShape, ("shape",), {"pose", "material", "collision_groups"}),
        (Joint, ("joint", "drive", "joint_state"), {"pose_in_parent", "pose_in_child", "limits"}),
    ],
)
def test_each_value_of_a_body_a_shape_and_a_joint_is_a_row(cls: type, parts: tuple[str, ...], others: set[str]) -> None:
    values = {slot.name for slot in plan_fields(cls) if isinstance(slot.kind, Quantity)}
    assert values == set(property_fields(*parts)) | others  # pyright: ignore[reportArgumentType]


@dataclass
class Shelf:
    height: int
    apart: float
    color: Value | None = None


def test_a_field_takes_no_range_of_one_with_the_same_name() -> None:
    with pytest.raises(KeyError, match=r"Shelf\.color"):
        plan_fields(Shelf)
    plain = make_dataclass("Shelf", [("height", int), ("apart", float)])
    assert [slot.kind for slot in plan_fields(plain)] == [ScalarKind(int, COUNT), ScalarKind(float, ANY)]


def test_a_number_that_must_be_positive_is_above_0() -> None:
    assert str(POSITIVE) == "above 0 and at most 3.40282e+38"


@pytest.mark.parametrize("knob", [*PROPERTIES, *JOINT_PROPERTIES], ids=lambda knob: knob.field)
def test_what_is_untouched_is_a_row_of_its_kind(knob: Property) -> None:
    kind = next(
        slot.kind
        for cls in (BodyStructure, CollisionShape, Joint)
        for slot in plan_fields(cls)
        if slot.name == knob.field
    )
    assert isinstance(kind, Quantity)
    assert (kind.shape, kind.bounds, kind.reset) == (knob.shape, knob.bounds, knob.reset)
    if knob.untouched is not None:
        row = knob.untouched if knob.shape else (knob.untouched,)
        assert len(row) == (knob.shape[0] if knob.shape else 1)
        assert all(knob.bounds.low <= number <= knob.bounds.high for number in row)


def test_fields_are_told_once() -> None:
    assert len({knob.field for knob in PROPERTIES}) == len({knob.key for knob in PROPERTIES}) == len(PROPERTIES)
    assert {field.name for field in dataclasses.fields(CollisionShape)} >= set(property_fields("shape"))
