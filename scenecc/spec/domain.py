"""What a varying value may be, as far as the forms that draw numbers are concerned."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from pydantic_core import core_schema

from scenecc.spec.scalars import LARGEST
from scenecc.spec.unions import COMPONENTS, Validator, branches

if TYPE_CHECKING:
    from collections.abc import Callable

    from pydantic_core import CoreSchema


@dataclass(frozen=True)
class Domain:
    """The numbers that a value may consist of.

    Attributes:
        number: the schema of one number; None where a single number is no value.
        item: of a list's components; None where a list is no value.
        least, most: how many components.
        nonzero: whether 0 is outside.
    """

    number: CoreSchema | None = None
    item: Domain | None = None
    least: int = 0
    most: int = 0
    nonzero: bool = False

    @property
    def of_numbers(self) -> bool:
        """Whether numbers can be drawn for it."""
        return self.number is not None or (self.item is not None and self.item.number is not None)

    @property
    def scalar(self) -> Domain:
        """The domain of one number, or of one component of a list."""
        return self if self.number is not None or self.item is None else self.item

    @property
    def whole(self) -> bool:
        """Whether its numbers are integers."""
        schema = self.scalar.number
        return schema is not None and schema["type"] == "int"

    @property
    def bounded(self) -> bool:
        """Whether a number may be out of its range (other than beyond single precision)."""
        schema: Any = self.scalar.number or {}
        bounds = [schema.get(name) for name in ("gt", "ge", "lt", "le")]
        return self.nonzero or any(bound is not None and abs(bound) != LARGEST for bound in bounds)

    @cached_property
    def means(self) -> Domain:
        """The same shapes, of any numbers."""
        return _of(self, core_schema.float_schema(ge=-LARGEST, le=LARGEST, allow_inf_nan=False))

    @cached_property
    def deviations(self) -> Domain:
        """The same shapes, of numbers that are not negative."""
        return _of(self, core_schema.float_schema(ge=0, le=LARGEST, allow_inf_nan=False))

    @cached_property
    def validate_number(self) -> Callable[..., Any]:
        """Validates a single number."""
        assert self.number is not None
        return Validator(self.number).validate

    @cached_property
    def validate_numbers(self) -> Callable[..., list[Any]]:
        """Validates a list of single numbers."""
        assert self.item is not None
        assert self.item.number is not None
        schema = core_schema.list_schema(self.item.number, min_length=self.least, max_length=self.most)
        return Validator(schema).validate


def _of(domain: Domain, schema: CoreSchema) -> Domain:
    """The same shapes, of other numbers."""
    number = None if domain.number is None else schema
    return replace(domain, number=number, item=domain.item and _of(domain.item, schema), nonzero=False)


def domain_of(schema: CoreSchema, resolve: Callable[[CoreSchema], CoreSchema]) -> Domain:
    """The domain of a type; an empty one where it holds no numbers of its own.

    Args:
        schema: of the type.
        resolve: finds what a reference refers to.
    """
    schema = resolve(schema)
    nonzero = bool((schema.get("metadata") or {}).get("nonzero"))
    found = Domain()
    for choice, label in branches(schema).choices:
        branch: Any = resolve(choice)
        if branch["type"] == "function-wrap":  # numbers all the same
            branch = resolve(branch["schema"])
        match branch["type"]:
            case "float" | "int":
                found = Domain(branch, found.item, found.least, found.most, nonzero)
            case "tuple":
                items = branch["items_schema"]
                found = Domain(found.number, domain_of(items[0], resolve), len(items), len(items), nonzero)
            case "list" if label == COMPONENTS:
                item = domain_of(branch["items_schema"], resolve)
                found = Domain(found.number, item, branch["min_length"], branch["max_length"], nonzero)
            case _:
                pass
    return found
