"""Values that may differ between scenes, and values that may not: `Leaf[T]` and `Fixed[T]`.

Both accept expressions in an unexpanded document. In an expanded document a leaf may still be a template or a form;
a fixed value is plain. `Domain` describes the numbers in a leaf.
"""

from __future__ import annotations

from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic_core import core_schema

from scenecc.plan.properties import FLOAT32_MAX
from scenecc.spec.base import ErrorCollector
from scenecc.spec.nodes import (
    COMPONENTS,
    VALUE,
    VECTOR,
    LazyValidator,
    any_varying,
    is_varying,
    make_refusal,
    ordered_union,
    plain_json_schema,
    union_branches,
    varying_json_schema,
)
from scenecc.variation.distributions import SHAPE_BOUNDS

if TYPE_CHECKING:
    from collections.abc import Callable

    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema, PydanticCustomError

    from scenecc.variation.distributions import Role
    from scenecc.variation.forms import Varying

    Refuse = Callable[[object], PydanticCustomError]


MAX_DRAW_COMPONENTS = 10_000
"""Most components of a drawn vector."""

_ROLE_BOUNDS: dict[str, dict[str, Any]] = {
    "mean": {"ge": -FLOAT32_MAX, "le": FLOAT32_MAX, "allow_inf_nan": False},
    "deviation": {"ge": 0, "le": FLOAT32_MAX, "allow_inf_nan": False},
    "positive": {"gt": 0, "le": FLOAT32_MAX, "allow_inf_nan": False},
    "shape": {"ge": SHAPE_BOUNDS[0], "le": SHAPE_BOUNDS[1], "allow_inf_nan": False},
}
"""Role of a distribution's operand → its range."""


@dataclass(frozen=True)
class Domain:
    """The numbers that a value may consist of.

    Attributes:
        number: schema of a single number; None if a number is not valid.
        item: domain of a list's components; None if a list is not valid.
        least, most: number of components.
        nonzero: whether 0 is invalid.
    """

    number: CoreSchema | None = None
    item: Domain | None = None
    least: int = 0
    most: int = 0
    nonzero: bool = False

    @property
    def of_numbers(self) -> bool:
        """Whether distributions can draw the value."""
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
        """Whether its range is smaller than that of float32."""
        schema: Any = self.scalar.number or {}
        bounds = [schema.get(name) for name in ("gt", "ge", "lt", "le")]
        return self.nonzero or any(bound is not None and abs(bound) != FLOAT32_MAX for bound in bounds)

    def of_role(self, role: Role) -> Domain:
        """Returns the domain of a distribution's operand, with the same shapes."""
        if role == "value":
            return self
        if role not in self._of_roles:
            self._of_roles[role] = _replace_numbers(self, core_schema.float_schema(**_ROLE_BOUNDS[role]))
        return self._of_roles[role]

    @cached_property
    def _of_roles(self) -> dict[str, Domain]:
        return {}

    @cached_property
    def validate_number(self) -> Callable[..., Any]:
        """Validates a single number."""
        assert self.number is not None
        return LazyValidator(self.number).validate

    @cached_property
    def validate_numbers(self) -> Callable[..., list[Any]]:
        """Validates a list of single numbers."""
        assert self.item is not None
        assert self.item.number is not None
        schema = core_schema.list_schema(self.item.number, min_length=self.least, max_length=self.most)
        return LazyValidator(schema).validate


def _replace_numbers(domain: Domain, schema: CoreSchema) -> Domain:
    """Returns a domain with the same shapes and another schema of numbers."""
    number = None if domain.number is None else schema
    return replace(domain, number=number, item=domain.item and _replace_numbers(domain.item, schema), nonzero=False)


def domain_of(schema: CoreSchema, resolve: Callable[[CoreSchema], CoreSchema]) -> Domain:
    """Returns the domain of a type; empty if the type has no numbers. `resolve` resolves references to definitions."""
    schema = resolve(schema)
    nonzero = bool((schema.get("metadata") or {}).get("nonzero"))
    found = Domain()
    for choice, label in union_branches(schema).choices:
        branch: Any = resolve(choice)
        if branch["type"] == "function-wrap":  # a wrapped number
            branch = resolve(branch["schema"])
        match branch["type"]:
            case "float" | "int":
                found = Domain(branch, found.item, found.least, found.most, nonzero)
            case "tuple":
                items = branch["items_schema"]
                found = Domain(found.number, domain_of(items[0], resolve), len(items), len(items), nonzero)
            case "list" if label == COMPONENTS or "max_length" in branch:
                item = domain_of(branch["items_schema"], resolve)
                found = Domain(found.number, item, branch["min_length"], branch["max_length"], nonzero)
            case _:
                pass
    return found


T = TypeVar("T")

READ_VALUES: ContextVar[dict[tuple[int, int], tuple[Any, Any]] | None] = ContextVar("SEEN", default=None)
"""Cache of varying values in an expanded document, since copies share nodes. The key holds the ids of the node and of
the leaf's type; the entry keeps the node alive."""

ROTATION_HINT = "a rotation varies through `rpy`, `axis_angle` or `q: uniform`, or with its whole pose"


class VaryingAnnotation:
    """Annotation of a leaf.

    Args:
        refused: hint if forms are not allowed here, only expressions; None if forms are allowed.
    """

    def __init__(self, refused: str | None = None) -> None:
        self.refused = refused

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        choices, expected = union_branches(schema)
        domain = domain_of(schema, handler.resolve_ref_schema)
        if expected is None:
            choices = [(schema, VECTOR if domain.item else VALUE)]
        refuse = make_refusal(choices, expected)
        plain = schema
        if expected is not None:
            plain = ordered_union(choices, core_schema.no_info_plain_validator_function(_make_refuser(refuse)))
        read = _make_reader(domain, LazyValidator(plain), refuse, self.refused)
        union = ordered_union(choices, core_schema.no_info_plain_validator_function(read))
        union["metadata"] = {"expected": expected, "varying": self._choose_definition(domain)}
        return union

    def _choose_definition(self, domain: Domain) -> str:
        """Returns the JSON Schema definition of the forms and expressions that may replace the value."""
        if self.refused is not None:
            return "Expression"
        return "VaryingInteger" if domain.whole else "VaryingNumber" if domain.of_numbers else "VaryingValue"

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        varying: str = schema["metadata"]["varying"]  # pyright: ignore[reportTypedDictNotRequiredAccess]
        component = "Expression" if varying == "Expression" else "VaryingNumber"
        return varying_json_schema(plain_json_schema(schema, handler), varying, component)


def _make_refuser(refuse: Refuse) -> Callable[[Any], Any]:
    """Returns the last branch of a union that accepts only plain values: it raises the error."""

    def otherwise(node: Any) -> Any:
        raise refuse(node)

    return otherwise


def _make_reader(domain: Domain, plain: LazyValidator, refuse: Refuse, refused: str | None) -> Callable[[Any], Any]:
    """Returns the last branch of a leaf's union, which reads forms and expressions. It reads a shared node once."""
    varies = any_varying if domain.item is not None else is_varying

    def read(node: Any) -> Any:
        """Reads a varying node, or raises an error for Pydantic."""
        seen = READ_VALUES.get()
        known = None if seen is None else seen.get((id(node), id(refuse)))
        if known is not None:
            return known[1]
        if not varies(node):
            raise refuse(node)
        from scenecc.spec.forms import FormReader

        mistakes = ErrorCollector()
        value = FormReader(mistakes, refused).leaf(node, domain, plain.validate, ())
        mistakes.stop()
        if seen is not None:
            seen[id(node), id(refuse)] = node, value
        return value

    return read


class _FixedAnnotation:
    """Annotation of a value that cannot differ between scenes."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        choices, expected = union_branches(schema)
        refuse = make_refusal(choices, expected)

        def read(node: Any) -> Any:
            if not is_varying(node):
                raise refuse(node)
            from scenecc.spec.forms import read_fixed_expression

            return read_fixed_expression(node)

        union = ordered_union(choices, core_schema.no_info_plain_validator_function(read))
        union["metadata"] = {"expected": expected}
        return union

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return varying_json_schema(plain_json_schema(schema, handler), "Expression", "Expression")


if TYPE_CHECKING:
    Leaf = T | Varying
    ExpressionOnly = T | Varying
    Fixed = T | T
else:
    Leaf = Annotated[T, VaryingAnnotation()]
    ExpressionOnly = Annotated[T, VaryingAnnotation(ROTATION_HINT)]
    Fixed = Annotated[T, _FixedAnnotation()]
