"""Classifies nodes for validation: kinds of nodes, unions by kind or key, and types that are imported on first use."""

from __future__ import annotations

from contextvars import ContextVar
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple, TypeGuard

from pydantic import BaseModel, ConfigDict
from pydantic_core import CoreConfig, PydanticCustomError, SchemaValidator, core_schema

from scenecc.source.events import RESERVED_CHARACTER
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema
    from pydantic_core.core_schema import UnionSchema

    from scenecc.diagnostics.diagnostic import Path, PathKey

    Validate = Callable[[Any], Any]

EXPRESSION_START = "${"
"""The start of an expression in a string."""


def is_mapping(node: Any) -> TypeGuard[dict[str, Any]]:
    """Returns whether a node is a mapping. The reader guarantees string keys."""
    return isinstance(node, dict)


def is_sequence(node: Any) -> TypeGuard[list[Any] | tuple[Any, ...]]:
    """Returns whether a node is a list, or a tuple that Pydantic made of one."""
    return isinstance(node, list | tuple)


WRONG_KIND = "#wrong_kind"
"""Error type of a node that fits no branch. The message names the expected kinds."""

NOT_MEANT = "#not_meant"
"""Error type of a branch that does not apply. These errors are always dropped."""

VALUE, VECTOR, COMPONENTS, OTHERWISE = (
    f"{RESERVED_CHARACTER}{label}" for label in ("value", "vector", "components", "otherwise")
)
"""Labels: a plain value; a list of numbers, as the only kind or one of several; the branch for all other nodes."""

SHAPE, BODY, COPIES = (f"{RESERVED_CHARACTER}{label}" for label in ("shape", "body", "copies"))
"""Labels: a shape without `repeat`, a plain body, and a body with `repeat`, `if` or `name`."""

KEY, TAGGED = f"{RESERVED_CHARACTER}key", f"{RESERVED_CHARACTER}tagged"
"""Labels: a mapping's key, after Pydantic's `[key]`; a union by `type`, before Pydantic's tag."""

FLAG, NUMBER, WORD, LIST, MAPPING = (
    f"{RESERVED_CHARACTER}{label}" for label in ("flag", "number", "word", "list", "mapping")
)
"""Labels of the kinds of nodes."""

ENTITY_LABELS: dict[str, str] = {
    key: f"{RESERVED_CHARACTER}{key}" for key in ("use", "variants", "urdf", "mjcf", "root")
}
"""Key that makes an entity something other than a plain body → the entity's label."""

PART_LABELS: dict[str, str] = {key: f"{RESERVED_CHARACTER}{key}_part" for key in ("urdf", "mjcf", "root")}
"""Key of a part in `attach` → the part's label."""

_REPETITION_KEYS = frozenset(("repeat", "if", "name"))

_NODE_KINDS: dict[type, str] = {
    bool: FLAG,
    int: NUMBER,
    float: NUMBER,
    str: WORD,
    list: LIST,
    tuple: LIST,
    dict: MAPPING,
}

TYPE = "type"
"""The key that distinguishes the shapes."""

EXPANDED: ContextVar[bool] = ContextVar("EXPANDED", default=False)
"""Whether the current document is expanded. `${` in a string is then literal, and expressions are templates.
(Every nested validator would have to pass on Pydantic's own context.)"""


def node_kind(value: object) -> str | None:
    """Returns the label of a node's kind by its exact type, since documents hold plain data."""
    return _NODE_KINDS.get(type(value))


_ALWAYS_MEANT = frozenset((OTHERWISE, TAGGED, COPIES, *ENTITY_LABELS.values(), *PART_LABELS.values()))
"""Labels of branches whose errors are always reported."""


def is_varying(node: object) -> bool:
    """Returns whether a node is an expression or a form."""
    if node.__class__ in _PLAIN_TYPES:
        return False
    if isinstance(node, str):
        return EXPRESSION_START in node and not EXPANDED.get()
    if is_mapping(node):
        # In this order the cost does not depend on the size of the mapping.
        return not node.keys().isdisjoint(FORM_KEYS)
    # In an expanded document the only other nodes are templates.
    return node_kind(node) is None and node is not None


_PLAIN_TYPES = frozenset((float, int, bool, list, tuple))


def any_varying(node: object) -> bool:
    """Returns whether a node is an expression or a form, or a list that contains one."""
    if is_sequence(node):
        return any(map(any_varying, node))
    return is_varying(node)


def entity_kind(node: object) -> str:
    """Returns the label of an entity's model."""
    if not is_mapping(node):
        return BODY
    kinds = (label for key, label in ENTITY_LABELS.items() if key in node)
    return next(kinds, BODY if node.keys().isdisjoint(_REPETITION_KEYS) else COPIES)


def is_meant(label: str, node: object) -> bool:
    """Returns whether the branch with a label applies to a node, so that its errors are reported."""
    if label in _ALWAYS_MEANT:
        return True
    if label == BODY:
        return entity_kind(node) == BODY
    if label == SHAPE:
        return EXPANDED.get() or not (is_mapping(node) and ("repeat" in node or is_varying(node.get(TYPE))))
    if label in {VECTOR, COMPONENTS}:
        return not any_varying(node) and (label == VECTOR or node_kind(node) == LIST)
    return not is_varying(node) and label in {VALUE, node_kind(node)}


class UnionBranches(NamedTuple):
    """The branches of a union by kind, and the expected kinds for messages."""

    choices: list[tuple[CoreSchema, str]]
    expected: str | None


def union_branches(schema: CoreSchema) -> UnionBranches:
    """Returns the branches of a union by kind. Any other type is its own branch, and `expected` is None."""
    expected = (schema.get("metadata") or {}).get("expected")
    if schema["type"] != "union" or expected is None:
        return UnionBranches([(schema, VALUE)], None)
    choices: Any = schema["choices"][:-1]
    return UnionBranches(list(choices), expected)


def ordered_union(choices: Iterable[tuple[CoreSchema, str]], otherwise: CoreSchema) -> UnionSchema:
    """Returns a union that tries its branches in order."""
    return core_schema.union_schema([*choices, (otherwise, OTHERWISE)], mode="left_to_right")


def make_refusal(
    choices: Iterable[tuple[CoreSchema, str]], expected: str | None
) -> Callable[[object], PydanticCustomError]:
    """Returns a function that makes the error for a node that no branch accepts."""
    labels = {LIST if label == COMPONENTS else label for _, label in choices}

    def refuse(node: object) -> PydanticCustomError:
        if expected is None or node_kind(node) in labels:
            return PydanticCustomError(NOT_MEANT, "another branch applies")
        return PydanticCustomError(WRONG_KIND, "{expected}", {"expected": expected})

    return refuse


def with_label(schema: CoreSchema, label: str) -> UnionSchema:
    """Returns a schema whose errors have a label in their `loc`."""
    return core_schema.union_schema([(schema, label)], mode="left_to_right", auto_collapse=False)


class LazyValidator:
    """A standalone validator that is built on first use.

    Args:
        schema: a schema without references to definitions.
    """

    def __init__(self, schema: CoreSchema) -> None:
        self._schema = schema

    @cached_property
    def validate(self) -> Callable[[Any], Any]:
        """Validates a value in strict mode."""
        return SchemaValidator(self._schema, CoreConfig(strict=True)).validate_python


class _UnionByKind:
    """The annotation that `union_by_kind` returns."""

    def __init__(self, expected: str, *, nonzero: bool) -> None:
        self._expected = expected
        self._nonzero = nonzero

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        union: Any = handler(source)
        choices: list[tuple[CoreSchema, str]] = union["choices"]
        refuse = make_refusal(choices, self._expected)

        def otherwise(node: object) -> Any:
            raise refuse(node)

        schema = ordered_union(choices, core_schema.no_info_plain_validator_function(otherwise))
        schema["metadata"] = {"expected": self._expected, "nonzero": self._nonzero}
        return schema

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return plain_json_schema(schema, handler)


def plain_json_schema(schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
    """Returns the JSON Schema of a union without its last branch, which reads other nodes."""
    union: Any = schema
    choices: list[Any] = union.get("choices", [])
    if union["type"] != "union" or choices[-1][1:] != (OTHERWISE,):
        # A nested annotation has removed the last branch already.
        return handler(schema)
    plain = choices[:-1]
    return handler(plain[0][0] if len(plain) == 1 else core_schema.union_schema(plain))


def union_by_kind(expected: str, *, nonzero: bool = False) -> Any:
    """Annotates a union whose branches have the labels of `node_kind` as tags; a list of numbers has `COMPONENTS`.

    Args:
        expected: the accepted values for messages: "[x, y, z] or a mapping".
        nonzero: whether 0 is invalid although a branch accepts it.
    """
    return _UnionByKind(expected, nonzero=nonzero)


def child_at(node: Any, segment: PathKey) -> Any:
    """Returns the child of a node, or None."""
    if isinstance(segment, str):
        return node.get(segment) if is_mapping(node) else None
    return node[segment] if is_sequence(node) and 0 <= segment < len(node) else None


def value_at(node: Any, path: Path) -> Any:
    """Returns the node at a path, or None."""
    for segment in path:
        node = child_at(node, segment)
    return node


class LazyType:
    """Annotation for a type whose module is imported on first use.

    Args:
        module: module of the type.
        name: name of the model or alias.
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
        """Returns the JSON Schema of the type."""
        # Without the wrapper, the handler would inline the type at every use instead of defining it once.
        return handler(core_schema.definitions_schema(self.core_schema, []))

    def schema(self) -> CoreSchema:
        """Returns a schema whose validator is replaced by the type's own at the first value."""
        return core_schema.no_info_plain_validator_function(self._validator())

    def _validator(self) -> Validate:
        def first(_self: object, node: Any) -> Any:
            validate = self.validate
            # `__call__` is looked up on the type, so later calls need no Python frame.
            validator.__call__ = staticmethod(validate)  # pyright: ignore[reportAttributeAccessIssue]
            return validate(node)

        validator = type("_Validator", (), {"__call__": first})
        made: Any = validator()
        return made


class ModelChoice:
    """Annotation of a mapping whose keys determine its model."""

    def choose(self, node: Any) -> type[BaseModel] | None:
        """Returns the model of a mapping, or None."""
        raise NotImplementedError


class LazyUnion(ModelChoice):
    """Annotation for a union of models by their key `type`, for example of shapes.

    Args:
        role: suffix of the models' names: type `convex_mesh` is `ConvexMeshShape`.
        modules: module of `scenecc.spec` → the types whose models it has.
    """

    def __init__(self, role: str, modules: Mapping[str, tuple[str, ...]]) -> None:
        self._branches = {
            type_: LazyType(f"scenecc.spec.{module}", "".join(map(str.capitalize, type_.split("_"))) + role)
            for module, types in modules.items()
            for type_ in types
        }

    def types(self) -> tuple[str, ...]:
        """Returns the values that `type` may have."""
        return tuple(self._branches)

    def choose(self, node: Any) -> type[BaseModel] | None:
        """Returns the model of a mapping by its `type`, or None."""
        type_ = node.get(TYPE)
        return self.model(type_) if isinstance(type_, str) and type_ in self._branches else None

    def model(self, type_: str) -> type[BaseModel]:
        """Returns the model of a type."""
        return self._branches[type_].type

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        choices = {type_: branch.schema() for type_, branch in self._branches.items()}
        return with_label(core_schema.tagged_union_schema(choices, discriminator=TYPE), TAGGED)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"oneOf": [branch.json_schema(handler) for branch in self._branches.values()]}


REF_KEY = "x-ref"
"""Placeholder for a `$ref` to `DEFINITIONS`, which Pydantic's generator does not know. It is replaced at the end."""


def varying_json_schema(plain: dict[str, Any], varying: str, component: str) -> dict[str, Any]:
    """Returns the JSON Schema of a value that may vary.

    Args:
        plain: schema of a plain value.
        varying: definition of the forms and expressions that may replace it.
        component: definition of those that may replace one number of a list.
    """
    branches: list[dict[str, Any]] = plain["anyOf"] if plain.keys() == {"anyOf"} else [plain]
    if varying == "Expression" and any(branch.keys() <= {"type", "minLength"} and branch.get("type") == "string"
                                       for branch in branches):  # fmt: skip
        # Any string is valid, so expressions are too.
        return plain
    return {"anyOf": [*(_component_schema(branch, component) for branch in branches), {REF_KEY: varying}]}


def _component_schema(plain: dict[str, Any], component: str) -> dict[str, Any]:
    """Returns the schema with components that may vary, if it is a list of numbers."""
    items: list[Any] = plain.get("prefixItems", [plain.get("items")])
    if plain.get("type") != "array" or not is_mapping(items[0]) or any(item != items[0] for item in items):
        return plain
    if items[0].get("type") == "array":
        each = _component_schema(items[0], component)
    elif items[0].get("type") in {"number", "integer"}:
        each = {"anyOf": [items[0], {REF_KEY: component}]}
    else:
        return plain
    rest = {key: value for key, value in plain.items() if key != "prefixItems"}
    return {**rest, "items": each}
