"""Types whose module is imported, and whose validator is built, when a document first uses them.

A small scene needs a tenth of the models. A validator that is built once is then called without a Python frame.
"""

from __future__ import annotations

from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict
from pydantic_core import core_schema

from scenecc.spec.nodes import TAGGED, TYPE, with_label

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

    Validate = Callable[[Any], Any]


class LazyType:
    """An annotation that stands for a type.

    Args:
        module: in which the type is.
        name: of it: a model, or an alias.
    """

    def __init__(self, module: str, name: str) -> None:
        self._module = module
        self._name = name

    @cached_property
    def type(self) -> Any:
        """The type."""
        return getattr(import_module(self._module), self._name)

    @cached_property
    def _built(self) -> tuple[CoreSchema, Validate]:
        if isinstance(self.type, type(BaseModel)):
            self.type.model_rebuild()
            return self.type.__pydantic_core_schema__, self.type.__pydantic_validator__.validate_python
        from pydantic import TypeAdapter

        adapter: TypeAdapter[Any] = TypeAdapter(self.type, config=ConfigDict(strict=True))
        return adapter.core_schema, adapter.validator.validate_python

    @property
    def core_schema(self) -> CoreSchema:
        """Pydantic's schema of the type."""
        return self._built[0]

    @property
    def validate(self) -> Validate:
        """Validates a value."""
        return self._built[1]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return self.schema()

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return self.json_schema(handler)

    def json_schema(self, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """The JSON Schema of the type."""
        # A handler alone would write the type out at every use of it; what it is handed inside of definitions has its
        # own one.
        return handler(core_schema.definitions_schema(self.core_schema, []))

    def schema(self) -> CoreSchema:
        """Of a validator that is the model's, from the first value on."""
        return core_schema.no_info_plain_validator_function(self._validator())

    def _validator(self) -> Validate:
        def first(_self: object, node: Any) -> Any:
            validate = self.validate
            # Looked up on the type at every call, and called without a frame of Python's.
            validator.__call__ = staticmethod(validate)  # pyright: ignore[reportAttributeAccessIssue]
            return validate(node)

        validator = type("_Validator", (), {"__call__": first})
        made: Any = validator()
        return made


class LazyUnion:
    """An annotation that stands for a union of models by their key `type`, such as those of shapes.

    Args:
        role: what the names of the models end with: type `convex_mesh` is `ConvexMeshShape`.
        modules: of `scenecc.spec`, and the words of `type` of which each has the models.
    """

    def __init__(self, role: str, modules: Mapping[str, tuple[str, ...]]) -> None:
        self._branches = {
            type_: LazyType(f"scenecc.spec.{module}", "".join(map(str.capitalize, type_.split("_"))) + role)
            for module, types in modules.items()
            for type_ in types
        }

    def types(self) -> tuple[str, ...]:
        """The words that `type` may be."""
        return tuple(self._branches)

    def model(self, type_: str) -> type[BaseModel]:
        """The model of a type."""
        return self._branches[type_].type

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        choices = {type_: branch.schema() for type_, branch in self._branches.items()}
        return with_label(core_schema.tagged_union_schema(choices, discriminator=TYPE), TAGGED)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"oneOf": [branch.json_schema(handler) for branch in self._branches.values()]}
