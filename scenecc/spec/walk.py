"""From pydantic's `loc` to a path in the document, and to the keys that are known there.

Pydantic says where an error is and what it found, not which keys would have been right.
"""

from __future__ import annotations

import types
import typing
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, Tag
from typing_extensions import TypeAliasType

from scenecc.source.scalars import RESERVED_CHARACTER
from scenecc.spec.copies import Repeat
from scenecc.spec.entities import MODELS, entity_model
from scenecc.spec.later import ByType, Later
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.spec.unions import BODY, KEY, OTHERWISE, SHAPE, TAGGED, VALUE, VECTOR, is_meant
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Path, PathKey


def document_path(loc: tuple[PathKey, ...], data: Any) -> Path | None:
    """Pydantic's `loc` as a path into the document; None where it leads through a branch that was not meant."""
    if KEY in loc:
        # Of a mapping's key; pydantic's own `[key]` stands between the two.
        loc = loc[: loc.index(KEY) - 1]
    path: list[PathKey] = []
    node = data
    segments = iter(loc)
    for segment in segments:
        if isinstance(segment, int) or not segment.startswith(RESERVED_CHARACTER):
            path.append(segment)
            node = step(node, segment)
        elif not is_meant(segment, node):
            return None
        elif segment == TAGGED:
            next(segments, None)
    return tuple(path)


_SAME = frozenset((VALUE, VECTOR, OTHERWISE, SHAPE, BODY, TAGGED))


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
        if in_form and segment in FORM_KEYS:
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
    if segment in MODELS:
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
