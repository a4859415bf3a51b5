"""From pydantic's `loc` to a path in the document, and to the keys that are known there.

Pydantic says where an error is and what it found, not which keys would have been right.
"""

from __future__ import annotations

import types
import typing
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, Tag
from typing_extensions import TypeAliasType

from scenecc.spec.copies import Repeat
from scenecc.spec.entities import entity_model
from scenecc.spec.features import VARIATION_FORMS
from scenecc.spec.later import ByType, Later
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.spec.unions import BODY, OTHERWISE, SHAPE, VALUE, VECTOR, is_meant

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Path, PathKey

KEY_MARK = "[key]"
"""What pydantic appends to the place of a mapping's key."""


def document_path(loc: tuple[PathKey, ...], data: Any) -> Path | None:
    """Pydantic's `loc` as a path into the document; None where it leads through a branch that was not meant.

    Labels of ours start with `#`; the tag of a shape or a light is its `type`, and follows a list's index or the name
    in a section of such things.
    """
    path: list[PathKey] = []
    node = data
    before_tag = False
    for segment in loc:
        if segment == KEY_MARK:
            # What follows is the label of a key's own branch.
            break
        if isinstance(segment, str) and segment.startswith("#"):
            if not is_meant(segment, node):
                return None
            continue
        if before_tag and is_mapping(node) and node.get("type") == segment:
            before_tag = False
            continue
        path.append(segment)
        before_tag = isinstance(segment, int) or (len(path) == 2 and path[0] in _BY_TYPE)
        node = step(node, segment)
    return tuple(path)


_BY_TYPE = frozenset(("constraints", "lights"))
"""Sections whose entries are told apart by `type`."""

_SAME = frozenset((VALUE, VECTOR, OTHERWISE, SHAPE, BODY))
_ENTITIES = frozenset(("#use", "#variants", "#copies", "#urdf", "#mjcf", "#root"))


def step(node: Any, segment: PathKey) -> Any:
    """One step down plain data; None where there is nothing."""
    if isinstance(segment, str):
        return node.get(segment) if is_mapping(node) else None
    return node[segment] if is_sequence(node) and 0 <= segment < len(node) else None


def follow(node: Any, path: Path) -> Any:
    """What stands at a path; None where there is nothing."""
    for segment in path:
        node = step(node, segment)
    return node


def model_at(root: type[BaseModel], loc: tuple[PathKey, ...]) -> type[BaseModel] | None:
    """The model whose mapping holds the last segment of `loc`; None where any key may stand."""
    annotation: Any = root
    for segment in _without_forms(loc[:-1]):
        annotation = _below(_bare(annotation), segment)
    bare = _bare(annotation)
    return bare if isinstance(bare, type) and issubclass(bare, BaseModel) else None


def _without_forms(loc: tuple[PathKey, ...]) -> Iterator[PathKey]:
    """The same without the keys of forms and the places in them: an alternative is of the type of the whole."""
    rest = iter(loc)
    in_form = False
    for segment in rest:
        if in_form and segment in VARIATION_FORMS:
            next(rest, None)
        else:
            in_form = segment == OTHERWISE
            yield segment


def _bare(annotation: Any) -> Any:
    """Without aliases, `Annotated` and the None of a key that may be left out."""
    while True:
        if isinstance(annotation, TypeAliasType):
            annotation = annotation.__value__
        elif typing.get_origin(annotation) is Annotated:
            annotation, *said = typing.get_args(annotation)
            for item in said:
                if isinstance(item, ByType):
                    return item
                annotation = item.type if isinstance(item, Later) else annotation
        elif _is_union(annotation) and len(_branches(annotation)) == 1:
            annotation = _branches(annotation)[0]
        else:
            return annotation


def _is_union(annotation: Any) -> bool:
    return typing.get_origin(annotation) in (typing.Union, types.UnionType)


def _branches(union: Any) -> list[Any]:
    return [arg for arg in typing.get_args(union) if arg is not type(None)]


def _below(annotation: Any, segment: PathKey) -> Any:
    """One segment of `loc` down: a field, an item, a mapping's value or a branch of a union."""
    if segment in _SAME:
        return annotation
    if segment in _ENTITIES:
        return entity_model(str(segment))
    if isinstance(annotation, ByType):
        return Repeat if segment == "repeat" else annotation.model(str(segment))
    if _is_union(annotation):
        return next((branch for branch in _branches(annotation) if _tag(branch) == segment), Any)
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        field = annotation.model_fields.get(str(segment))
        return field.annotation if field else Any
    args = typing.get_args(annotation)
    # Of a mapping the values, of a list or tuple the items.
    return args[-1 if typing.get_origin(annotation) is dict else 0] if args else Any


def _tag(branch: Any) -> str | None:
    if typing.get_origin(branch) is Annotated:
        for item in typing.get_args(branch)[1:]:
            if isinstance(item, Tag):
                return item.tag
    return None
