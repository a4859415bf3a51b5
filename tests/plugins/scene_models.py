"""The models of the language, looked at from outside: their keys, and what a key may hold."""

from __future__ import annotations

import types
import typing
from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import BaseModel, Tag
from pydantic.fields import FieldInfo
from typing_extensions import TypeAliasType

from scenecc.spec.articulation import Mjcf, Tree, TreeLink, Urdf
from scenecc.spec.attachments import PART_TYPES, PartAnnotation, PartKeys
from scenecc.spec.body import BodySpec
from scenecc.spec.entities import entity_model
from scenecc.spec.nodes import (
    BODY,
    COMPONENTS,
    LIST,
    PART_LABELS,
    LazyType,
    LazyUnion,
    any_varying,
    entity_kind,
    node_kind,
)
from scenecc.spec.values import VaryingAnnotation

Key = tuple[type[BaseModel], str]
"""A key of a model: the name of its field."""

ARTICULATIONS: tuple[type[BaseModel], ...] = (Tree, Urdf, Mjcf)
"""Models of entities that no annotation leads to, for they are found by a key that the entity has."""

PARTS: tuple[type[BaseModel], ...] = tuple(later.type for later in PART_TYPES.values())
"""Models of what is attached to an articulation, likewise; `PartKeys` stands for any of them."""


def parts(annotation: Any) -> tuple[Any, list[Any]]:
    """A type without aliases and `Annotated`, and all that was said about it."""
    said: list[Any] = []
    while True:
        if isinstance(annotation, TypeAliasType):
            annotation = annotation.__value__
        elif typing.get_origin(annotation) is Annotated:
            annotation, *more = typing.get_args(annotation)
            for item in more:
                if isinstance(item, LazyType):
                    annotation = item.type
                elif isinstance(item, LazyUnion):
                    annotation = item
                elif isinstance(item, PartAnnotation):
                    annotation = PartKeys
                said += item.metadata if isinstance(item, FieldInfo) else [item]
        else:
            return annotation, said


def branches(annotation: Any) -> list[Any]:
    """The branches of a union, without the None of a key that may be left out; empty for anything else."""
    annotation, _ = parts(annotation)
    if isinstance(annotation, LazyUnion):
        return [annotation.model(type_) for type_ in annotation.types()]
    if typing.get_origin(annotation) not in (typing.Union, types.UnionType):
        return []
    return [branch for branch in typing.get_args(annotation) if branch is not type(None)]


def is_model(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def annotation_of(model: type[BaseModel], name: str) -> Any:
    """The annotation of a field; pydantic keeps a type that stands for another one beside it."""
    field = model.model_fields[name]
    later = next((item for item in field.metadata if isinstance(item, LazyType)), None)
    return field.annotation if later is None else later.type


def field_of(model: type[BaseModel], key: str) -> str:
    """The name of the field that a key fills."""
    return next(name for name, field in model.model_fields.items() if key == (field.alias or name))


NEVER_VALID: frozenset[Key] = frozenset(((TreeLink, "joint"),))
"""Keys that are known only to be refused: the root of a tree hangs on nothing."""


def all_keys(*annotations: Any) -> set[Key]:
    """Every key that can be written below some types."""
    found: set[Key] = set()
    todo = list(annotations)
    while todo:
        bare, _ = parts(todo.pop())
        if bare is PartKeys:
            todo += PARTS if (PARTS[0], "to") not in found else ()
        elif is_model(bare):
            fields = bare.model_fields
            new = {(bare, name) for name in fields} - found - NEVER_VALID
            found |= new
            todo += [annotation_of(bare, name) for _, name in new]
        elif isinstance(bare, LazyUnion):
            todo += branches(bare)
        else:
            todo += [arg for arg in typing.get_args(bare) if typing.get_origin(bare) is not typing.Literal]
    return found


def choices(*annotations: Any) -> set[tuple[Key, Any]]:
    """Every word of every key below some types that takes one of a few."""
    found: set[tuple[Key, Any]] = set()
    for model, name in all_keys(*annotations):
        todo = [annotation_of(model, name)]
        while todo:
            bare, _ = parts(todo.pop())
            if typing.get_origin(bare) is typing.Literal:
                found |= {((model, name), word) for word in typing.get_args(bare)}
            elif not is_model(bare) and not isinstance(bare, LazyUnion):
                todo += typing.get_args(bare)
    return found


def written(annotation: Any, node: Any) -> Iterator[tuple[Key, Any]]:
    """The keys that a document writes, each with its value."""
    bare, _ = parts(annotation)
    if options := branches(bare):
        if not _is_form(node):
            yield from written(_branch(options, node), node)
    elif is_model(bare):
        bare = _meant(bare, node)
        for key, value in node.items():
            name = field_of(bare, key)
            yield (bare, name), value
            yield from written(annotation_of(bare, name), value)
    elif not typing.get_args(bare):
        return
    elif isinstance(node, (list, tuple)):
        items = [arg for arg in typing.get_args(bare) if arg is not Ellipsis]
        for i, item in enumerate(node):
            yield from written(items[i if len(items) == len(node) else 0], item)
    elif isinstance(node, dict):
        for item in node.values():
            yield from written(typing.get_args(bare)[1], item)


def leaves(annotation: Any, node: Any) -> Iterator[tuple[Any, Any, bool]]:
    """The values of a document that may vary: what they stand in, their key there, and whether they are numbers."""
    bare, _ = parts(annotation)
    if options := branches(bare):
        if not _is_form(node):
            yield from leaves(_branch(options, node), node)
    elif is_model(bare):
        bare = _meant(bare, node)
        for name, value in node.items():
            field = bare.model_fields[field_of(bare, name)]
            option = branches(field.annotation)
            inner, said = parts(option[0] if len(option) == 1 else field.annotation)
            if any(isinstance(item, VaryingAnnotation) and item.refused is None for item in [*said, *field.metadata]):
                yield node, name, inner is float or {parts(arg)[0] for arg in typing.get_args(inner)} == {float}
            else:
                yield from leaves(field.annotation, value)
    elif isinstance(node, list | dict) and (args := typing.get_args(bare)):
        for item in node.values() if isinstance(node, dict) else node:
            yield from leaves(args[-1], item)


def _meant(model: type[BaseModel], node: Any) -> type[BaseModel]:
    """The model that a node is read by: an entity is what its keys make of it."""
    if model is PartKeys:
        return next(PART_TYPES[label].type for key, label in PART_LABELS.items() if key in node)
    label = entity_kind(node) if model is BodySpec else BODY
    return model if label == BODY else entity_model(label)


def _is_form(node: Any) -> bool:
    """Whether a node is read by none of the branches; a plane's `normal` is no form."""
    return any_varying(node) and not (isinstance(node, dict) and "type" in node)


def _branch(options: list[Any], node: Any) -> Any:
    """The branch that a node is read by: that of its `type`, else that of its kind of node."""
    if len(options) == 1:
        return options[0]
    for option in options:
        bare, said = parts(option)
        tags = [item.tag for item in said if isinstance(item, Tag)]
        if tags and tags[0].replace(COMPONENTS, LIST) == node_kind(node):
            return option
        if (
            not tags
            and isinstance(node, dict)
            and typing.get_args(bare.model_fields["type"].annotation) == (node.get("type"),)
        ):
            return option
    raise AssertionError(f"no branch for {node!r}")
