"""The language allows the numbers that the plan holds."""

from __future__ import annotations

import math
from importlib import import_module
from typing import TYPE_CHECKING, Any

import pytest
from pydantic import ValidationError

from scenecc.plan.properties import Property, properties_of
from scenecc.spec.articulation import DriveKeys, JointKeys, LinkKeys
from scenecc.spec.shapes import CollisionKeys

if TYPE_CHECKING:
    from scenecc.spec.base import SpecModel

MODELS: dict[str, type[SpecModel]] = {"joint": JointKeys, "drive": DriveKeys, "shape": CollisionKeys}


def model_of(row: Property) -> type[SpecModel]:
    """The model of the language that has a row's key."""
    if row.key in {"target", "velocity_target"}:
        return DriveKeys
    if row.part in MODELS:
        return MODELS[row.part]
    return LinkKeys if row.key in LinkKeys.model_fields else import_module("scenecc.spec.body").BodyKeys


ROWS = [
    row
    for row in properties_of("mass", "body", "look", "shape", "joint", "drive", "joint_state")
    if row.dtype != "bool" and not row.shape and row.key not in {"qpos", "qvel"}
]


def accepts(model: type[SpecModel], key: str, number: Any) -> bool:
    try:
        model.model_validate({key: number})
    except ValidationError as error:
        return all(key not in problem["loc"] for problem in error.errors())
    return True


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.part} {row.key}")
def test_a_property_has_the_same_range_in_the_language_and_in_the_plan(row: Property) -> None:
    model, (low, high, _) = model_of(row), row.bounds
    below, above = (
        (low - 1, high + 1) if row.dtype == "int64" else (math.nextafter(low, -1e39), math.nextafter(high, 1e39))
    )
    assert accepts(model, row.key, low if row.dtype == "int64" else float(low))
    assert accepts(model, row.key, high if row.dtype == "int64" else float(high))
    assert not accepts(model, row.key, below)
    assert not accepts(model, row.key, above)
