"""Classification of nodes before Pydantic validates them: kinds, unions by key, and types whose module is imported
when a document first uses them.
"""

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
"""What a text holds that has an expression in it."""


def is_mapping(node: Any) -> TypeGuard[dict[str, Any]]:
    """Whether a node is a mapping; the reader lets no key through that is not a string."""
    return isinstance(node, dict)


def is_sequence(node: Any) -> TypeGuard[list[Any] | tuple[Any, ...]]:
    """Whether a node is a list. (Pydantic reports some as the tuple that it made of one.)"""
    return isinstance(node, list | tuple)


WRONG_KIND = "#wrong_kind"
"""The error type of a node that fits no branch; its message says what would."""

NOT_MEANT = "#not_meant"
"""The error type of a branch that was not meant: always dropped."""

VALUE, VECTOR, COMPONENTS, OTHERWISE = (
    f"{RESERVED_CHARACTER}{label}" for label in ("value", "vector", "components", "otherwise")
)
"""Labels: a plain value; a list of numbers, alone or among other kinds; and the branch for all that is not plain."""

SHAPE, BODY, COPIES = (f"{RESERVED_CHARACTER}{label}" for label in ("shape", "body", "copies"))
"""Labels: a shape written once, an entity that is a plain body, and one that has copies."""

KEY, TAGGED = f"{RESERVED_CHARACTER}key", f"{RESERVED_CHARACTER}tagged"
"""Labels: of a mapping's key, after pydantic's `[key]`; and before the `type` that pydantic notes of what has one."""

FLAG, NUMBER, WORD, LIST, MAPPING = (
    f"{RESERVED_CHARACTER}{label}" for label in ("flag", "number", "word", "list", "mapping")
)
"""Labels: of the kinds of nodes."""

ENTITY_LABELS: dict[str, str] = {
    key: f"{RESERVED_CHARACTER}{key}" for key in ("use", "variants", "urdf", "mjcf", "root")
}
"""Key of an entity that is no plain body → the entity's label."""

PART_LABELS: dict[str, str] = {key: f"{RESERVED_CHARACTER}{key}_part" for key in ("urdf", "mjcf", "root")}
"""Key of a part that is attached to an articulation → the part's label."""

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
"""Whether the document at hand is expanded: then `${` in a text is literal, and templates stand for what is left to
evaluate. (Pydantic's own context would have to be passed on by every validator that is called from another.)"""


def node_kind(value: object) -> str | None:
    """The label of a node's kind, from its exact type: documents hold plain data."""
    return _NODE_KINDS.get(type(value))


_ALWAYS_MEANT = frozenset((OTHERWISE, TAGGED, COPIES, *ENTITY_LABELS.values(), *PART_LABELS.values()))
"""Labels that only errors have that were meant."""


def is_varying(node: object) -> bool:
    """Whether a node is an expression or a form, and no plain value."""
    if node.__class__ in _PLAIN_TYPES:
        return False
    if isinstance(node, str):
        return EXPRESSION_START in node and not EXPANDED.get()
    if is_mapping(node):
        # This way round it is no slower for a stranger's mapping of many keys.
        return not node.keys().isdisjoint(FORM_KEYS)
    # Documents hold plain data and, once expanded, templates.
    return node_kind(node) is None and node is not None


_PLAIN_TYPES = frozenset((float, int, bool, list, tuple))


def any_varying(node: object) -> bool:
    """The same, or a list with such a component."""
    if is_sequence(node):
        return any(map(any_varying, node))
    return is_varying(node)


def entity_kind(node: object) -> str:
    """What an entity is: `BODY`, or the label of another model."""
    if not is_mapping(node):
        return BODY
    kinds = (label for key, label in ENTITY_LABELS.items() if key in node)
    return next(kinds, BODY if node.keys().isdisjoint(_REPETITION_KEYS) else COPIES)


def is_meant(label: str, node: object) -> bool:
    """Whether the errors of a branch speak of what is written at its place."""
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
    """The branches of a union by kind."""

    choices: list[tuple[CoreSchema, str]]
    expected: str | None


def union_branches(schema: CoreSchema) -> UnionBranches:
    """The branches of a type: those of a union by kind, or itself alone. `expected` is None where it is alone."""
    expected = (schema.get("metadata") or {}).get("expected")
    if schema["type"] != "union" or expected is None:
        return UnionBranches([(schema, VALUE)], None)
    choices: Any = schema["choices"][:-1]
    return UnionBranches(list(choices), expected)


def ordered_union(choices: Iterable[tuple[CoreSchema, str]], otherwise: CoreSchema) -> UnionSchema:
    """A union that tries its branches in order."""
    return core_schema.union_schema([*choices, (otherwise, OTHERWISE)], mode="left_to_right")


def make_refusal(
    choices: Iterable[tuple[CoreSchema, str]], expected: str | None
) -> Callable[[object], PydanticCustomError]:
    """What the last branch says to a node that is for none of the others."""
    labels = {LIST if label == COMPONENTS else label for _, label in choices}

    def refuse(node: object) -> PydanticCustomError:
        if expected is None or node_kind(node) in labels:
            return PydanticCustomError(NOT_MEANT, "another branch applies")
        return PydanticCustomError(WRONG_KIND, "{expected}", {"expected": expected})

    return refuse


def with_label(schema: CoreSchema, label: str) -> UnionSchema:
    """The same schema, whose errors have a label in their `loc`."""
    return core_schema.union_schema([(schema, label)], mode="left_to_right", auto_collapse=False)


class LazyValidator:
    """A validator by itself, built when it is first asked for.

    Args:
        schema: without references to others.
    """

    def __init__(self, schema: CoreSchema) -> None:
        self._schema = schema

    @cached_property
    def validate(self) -> Callable[[Any], Any]:
        """Validates a value, strictly."""
        return SchemaValidator(self._schema, CoreConfig(strict=True)).validate_python


class _UnionByKind:
    """The annotation that `union_by_kind` makes."""

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
    """The JSON Schema of a union's plain branches."""
    union: Any = schema
    choices: list[Any] = union.get("choices", [])
    if union["type"] != "union" or choices[-1][1:] != (OTHERWISE,):
        # One annotation was put upon another, which has taken the last branch off.
        return handler(schema)
    plain = choices[:-1]
    return handler(plain[0][0] if len(plain) == 1 else core_schema.union_schema(plain))


def union_by_kind(expected: str, *, nonzero: bool = False) -> Any:
    """A union whose branches carry the tags of `node_kind`, `COMPONENTS` for a list of numbers that may vary.

    Args:
        expected: what a user may write, as it stands in the message: "[x, y, z] or a mapping".
        nonzero: whether 0 is no value, though a branch takes it.
    """
    return _UnionByKind(expected, nonzero=nonzero)


def child_at(node: Any, segment: PathKey) -> Any:
    """One step down plain data; None where there is nothing."""
    if isinstance(segment, str):
        return node.get(segment) if is_mapping(node) else None
    return node[segment] if is_sequence(node) and 0 <= segment < len(node) else None


def value_at(node: Any, path: Path) -> Any:
    """What stands at a path; None where there is nothing."""
    for segment in path:
        node = child_at(node, segment)
    return node


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


class ModelChoice:
    """An annotation of a mapping whose model follows from its keys."""

    def choose(self, node: Any) -> type[BaseModel] | None:
        """The model of a mapping; None where it has none."""
        raise NotImplementedError


class LazyUnion(ModelChoice):
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

    def choose(self, node: Any) -> type[BaseModel] | None:
        """The model of the mapping's `type`."""
        type_ = node.get(TYPE)
        return self.model(type_) if isinstance(type_, str) and type_ in self._branches else None

    def model(self, type_: str) -> type[BaseModel]:
        """The model of a type."""
        return self._branches[type_].type

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        choices = {type_: branch.schema() for type_, branch in self._branches.items()}
        return with_label(core_schema.tagged_union_schema(choices, discriminator=TYPE), TAGGED)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"oneOf": [branch.json_schema(handler) for branch in self._branches.values()]}


REF_KEY = "x-ref"
"""Stands for `$ref` to one of `DEFINITIONS` until the schema is whole: pydantic's generator knows only its own."""


def varying_json_schema(plain: dict[str, Any], varying: str, component: str) -> dict[str, Any]:
    """The JSON Schema of a value that may vary.

    Args:
        plain: of one that does not.
        varying: the definition of what may stand in its place.
        component: the same for one number of a list.
    """
    branches: list[dict[str, Any]] = plain["anyOf"] if plain.keys() == {"anyOf"} else [plain]
    if varying == "Expression" and any(branch.keys() <= {"type", "minLength"} and branch.get("type") == "string"
                                       for branch in branches):  # fmt: skip
        # Any text, an expression among them.
        return plain
    return {"anyOf": [*(_component_schema(branch, component) for branch in branches), {REF_KEY: varying}]}


def _component_schema(plain: dict[str, Any], component: str) -> dict[str, Any]:
    """A list of numbers, each of which may vary; anything else as it is."""
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
