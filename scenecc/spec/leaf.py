"""Values that may differ from scene to scene, and those that may not: `Leaf[T]` and `Fixed[T]`.

Both take an expression where the file is as it was written. In an expanded document a leaf may still be a template or
a form, which are then among `scenecc.variation.forms`; what is fixed is a plain value.
"""

from __future__ import annotations

from contextvars import ContextVar
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic_core import core_schema

from scenecc.spec.domain import Domain, domain_of
from scenecc.spec.mistakes import Mistakes
from scenecc.spec.unions import (
    VALUE,
    VECTOR,
    Validator,
    any_varying,
    branches,
    in_order,
    is_varying,
    plain_json,
    refusal,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema, PydanticCustomError

    from scenecc.variation.forms import Varying

    Refuse = Callable[[object], PydanticCustomError]

T = TypeVar("T")

SEEN: ContextVar[dict[tuple[int, int], tuple[Any, Any]] | None] = ContextVar("SEEN", default=None)
"""What varies in an expanded document, as it was read: copies share what is the same in all of them. By the identities
of the node, which is kept, and of the leaf's type."""

ROTATION = "a rotation varies through `rpy`, `axis_angle` or `q: uniform`, or with its whole pose"


class Varies:
    """The annotation of a leaf.

    Args:
        refused: why no form may stand here, though an expression may; None: forms may.
    """

    def __init__(self, refused: str | None = None) -> None:
        self.refused = refused

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        choices, expected = branches(schema)
        domain = domain_of(schema, handler.resolve_ref_schema)
        if expected is None:
            choices = [(schema, VECTOR if domain.item else VALUE)]
        refuse = refusal(choices, expected)
        plain = schema
        if expected is not None:
            plain = in_order(choices, core_schema.no_info_plain_validator_function(_refusing(refuse)))
        read = _leaf(domain, Validator(plain), refuse, self.refused)
        union = in_order(choices, core_schema.no_info_plain_validator_function(read))
        union["metadata"] = {"expected": expected, "varying": self._varying(domain)}
        return union

    def _varying(self, domain: Domain) -> str:
        """The definition of what may stand in the value's place, in the JSON Schema."""
        if self.refused is not None:
            return "Expression"
        return "VaryingInteger" if domain.whole else "VaryingNumber" if domain.of_numbers else "VaryingValue"

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        from scenecc.spec.json_forms import varying_json

        varying: str = schema["metadata"]["varying"]  # pyright: ignore[reportTypedDictNotRequiredAccess]
        component = "Expression" if varying == "Expression" else "VaryingNumber"
        return varying_json(plain_json(schema, handler), varying, component)


def _refusing(refuse: Refuse) -> Callable[[Any], Any]:
    """The last choice where nothing but plain values is taken: what came so far is refused."""

    def otherwise(node: Any) -> Any:
        raise refuse(node)

    return otherwise


def _leaf(domain: Domain, plain: Validator, refuse: Refuse, refused: str | None) -> Callable[[Any], Any]:
    """What reads a field's forms and expressions: the last choice, after the plain values.

    A node that copies share is read once.
    """
    varies = any_varying if domain.item is not None else is_varying

    def read(node: Any) -> Any:
        """The value of a node that varies, as it was read before if it was; raises what pydantic takes for an error."""
        seen = SEEN.get()
        known = None if seen is None else seen.get((id(node), id(refuse)))
        if known is not None:
            return known[1]
        if not varies(node):
            raise refuse(node)
        from scenecc.spec.forms import FormReader

        mistakes = Mistakes()
        value = FormReader(mistakes, refused).leaf(node, domain, plain.validate, ())
        mistakes.stop()
        if seen is not None:
            seen[id(node), id(refuse)] = node, value
        return value

    return read


class _Fixed:
    """The annotation of a value that cannot differ from scene to scene."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        choices, expected = branches(schema)
        refuse = refusal(choices, expected)

        def read(node: Any) -> Any:
            if not is_varying(node):
                raise refuse(node)
            from scenecc.spec.expressions import read_fixed

            return read_fixed(node)

        union = in_order(choices, core_schema.no_info_plain_validator_function(read))
        union["metadata"] = {"expected": expected}
        return union

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        from scenecc.spec.json_forms import varying_json

        return varying_json(plain_json(schema, handler), "Expression", "Expression")


if TYPE_CHECKING:
    Leaf = T | Varying
    Computed = T | Varying
    Fixed = T | T
else:
    Leaf = Annotated[T, Varies()]
    Computed = Annotated[T, Varies(ROTATION)]
    Fixed = Annotated[T, _Fixed()]
