"""Types whose module is loaded, and whose validator is built, when a document first has one of them.

A process that checks three lines needs a tenth of the language's models, and building all took longer than the rest of
its work. Once built, a validator is called without a Python frame, so that a large document pays next to nothing.
"""

from __future__ import annotations

from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pydantic_core import core_schema

from scenecc.spec.unions import TYPE

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema


class Later:
    """An annotation that stands for a model.

    Args:
        module: in which the model is.
        name: of it.
    """

    def __init__(self, module: str, name: str) -> None:
        self._module = module
        self._name = name

    @cached_property
    def model(self) -> type[BaseModel]:
        """The model, built."""
        found: type[BaseModel] = getattr(import_module(self._module), self._name)
        found.model_rebuild()
        return found

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return self.schema()

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return handler(self.model.__pydantic_core_schema__)

    def schema(self) -> CoreSchema:
        """Of a validator that is the model's, from the first value on."""
        return core_schema.no_info_plain_validator_function(self._validator())

    def _validator(self) -> Callable[[Any], Any]:
        def first(_self: object, node: Any) -> Any:
            validate = self.model.__pydantic_validator__.validate_python
            # Looked up on the type at every call, and called without a frame of Python's.
            validator.__call__ = staticmethod(validate)  # pyright: ignore[reportAttributeAccessIssue]
            return validate(node)

        validator = type("_Validator", (), {"__call__": first})
        made: Any = validator()
        return made


class ByType:
    """An annotation that stands for a union of models by their key `type`.

    Args:
        module: in whose submodules the models are.
        names: type → submodule and name of the model.
    """

    def __init__(self, module: str, names: Mapping[str, tuple[str, str]]) -> None:
        self._branches = {type_: Later(f"{module}.{part}", name) for type_, (part, name) in names.items()}

    def types(self) -> tuple[str, ...]:
        """The words that `type` may be."""
        return tuple(self._branches)

    def model(self, type_: str) -> type[BaseModel]:
        """The model of a type."""
        return self._branches[type_].model

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        choices = {type_: branch.schema() for type_, branch in self._branches.items()}
        return core_schema.tagged_union_schema(choices, discriminator=TYPE)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        branches = [handler(branch.model.__pydantic_core_schema__) for branch in self._branches.values()]
        return {"oneOf": branches}
