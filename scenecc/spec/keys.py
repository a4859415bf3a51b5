"""The keys that are allowed at a place of a document, and their annotations."""

from __future__ import annotations

import types
import typing
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel
from typing_extensions import TypeAliasType

from scenecc.spec.base import NOTE_PREFIX, PATTERN, WHOLE, NameRole
from scenecc.spec.document import SceneFile
from scenecc.spec.nodes import LazyType, LazyUnion, ModelChoice, is_mapping, is_sequence
from scenecc.spec.repetition import Repeat
from scenecc.spec.values import VaryingAnnotation
from scenecc.variation.forms import FORM_KEYS, ONCE

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.diagnostics.diagnostic import Path, PathKey
    from scenecc.spec.base import NameKind

    Change = Callable[[Any, NameKind | None, Path], Any]


@dataclass
class KeyPlace:
    """The values that are allowed at a place of a document.

    Attributes:
        names: kind of object that a string names.
        varies: whether a form is allowed.
        whole: whether an override replaces a mapping instead of merging it.
        pattern: whether a string is a name pattern.
        key: place of the keys of a mapping of names.
        entry, item: place of the values of a mapping of names; of the items of a list.
        choice: model of a mapping of keys, or its choice of models.
    """

    names: NameKind | None = None
    varies: bool = False
    whole: bool = False
    pattern: bool = False
    key: KeyPlace | None = None
    entry: KeyPlace | None = None
    item: KeyPlace | None = None
    choice: type[BaseModel] | ModelChoice | None = None

    def model(self, node: Any) -> type[BaseModel] | None:
        """Returns the model of a mapping of keys, or None."""
        return self.choice.choose(node) if isinstance(self.choice, ModelChoice) else self.choice

    def below(self, node: Any, step: PathKey) -> KeyPlace:
        """Returns the place of a key or item of `node`, a node at this place."""
        if not isinstance(step, str):
            return self.item or NOWHERE
        model = self.model(node)
        if model is None and isinstance(self.choice, LazyUnion):  # without a `type`, any model that has the key
            models = map(self.choice.model, self.choice.types())
            return next((place for one in models if (place := model_places(one).get(step))), NOWHERE)
        if model is None:
            return self.entry or NOWHERE
        return model_places(model).get(step) or (_REPEAT if step == "repeat" else NOWHERE)

    def is_form(self, node: Any) -> bool:
        """Returns whether a mapping is a form of variation."""
        return self.varies and not FORM_KEYS.isdisjoint(node)


NOWHERE = KeyPlace()
"""A place with any value and no references."""


@cache
def section_place(section: str) -> KeyPlace:
    """Returns the place of an entry of a section."""
    return model_places(SceneFile)[section].entry or NOWHERE


@cache
def model_places(model: type[BaseModel]) -> dict[str, KeyPlace]:
    """Returns the places of a model's keys."""
    return {
        field.alias or name: _take(KeyPlace(), field.annotation, field.metadata)
        for name, field in model.model_fields.items()
    }


def _take(place: KeyPlace, annotation: Any, metadata: typing.Iterable[Any] = ()) -> KeyPlace:
    """Adds a type and its annotations to a place."""
    for said in metadata:
        match said:
            case LazyType():
                annotation = said.type
            case ModelChoice():
                place.choice, annotation = said, None
            case NameRole(kind):
                place.names = kind
            case VaryingAnnotation():
                place.varies = True
            case _:
                place.whole |= said is WHOLE
                place.pattern |= said is PATTERN
    _take_type(place, annotation)
    return place


def _take_type(place: KeyPlace, annotation: Any) -> None:
    """Adds a type without annotations to a place."""
    origin, args = typing.get_origin(annotation), typing.get_args(annotation)
    if isinstance(annotation, TypeAliasType):
        _take(place, annotation.__value__)
    elif origin is Annotated:
        _take(place, args[0], args[1:])
    elif origin in (typing.Union, types.UnionType):
        for branch in args:
            _take(place, branch)
    elif origin is dict:
        place.key, place.entry = _take(KeyPlace(), args[0]), _take(KeyPlace(), args[1])
    elif origin in {list, tuple}:
        place.item = _take(KeyPlace(), args[0])
    elif isinstance(annotation, type) and issubclass(annotation, BaseModel):
        place.choice = annotation


_REPEAT = _take(KeyPlace(), Repeat)
"""Place of `repeat` in shapes. Their models lack the key, because expansion removes it."""


def place_at(path: Path, node_at: Callable[[Path], Any]) -> KeyPlace:
    """Returns the place at a path of a document. An alternative in a form has the place of the form.

    Args:
        path: the path.
        node_at: returns the node at a path. It is called where the place depends on the keys of a mapping.
    """
    place, done = KeyPlace(choice=SceneFile), 0
    while done < len(path):
        node = node_at(path[:done]) if place.varies or isinstance(place.choice, ModelChoice) else None
        if is_mapping(node) and place.is_form(node):
            done += 1 if path[done] == ONCE else 2
        else:
            place = place.below(node, path[done])
            done += 1
    return place


def change_leaves(node: Any, place: KeyPlace, change: Change, path: Path = ()) -> Any:
    """Returns a copy of a node with changed scalars and reference keys. Notes are not changed.

    Args:
        node: plain data and templates.
        place: place of the node.
        change: takes a scalar, the kind of object that it refers to, and its path; returns the new scalar.
        path: path of the node.
    """
    if is_sequence(node):
        item = place.item or NOWHERE
        return [change_leaves(one, item, change, (*path, index)) for index, one in enumerate(node)]
    if not is_mapping(node):
        return change(node, place.names, path)
    made: dict[str, Any] = {}
    is_form = place.is_form(node)
    for key, below in node.items():
        at = (*path, key)
        if key.startswith(NOTE_PREFIX):
            made[key] = below
        elif not is_form:
            named = key if place.key is None or place.key.names is None else change(key, place.key.names, at)
            made[named] = change_leaves(below, place.below(node, key), change, at)
        elif is_sequence(below):
            made[key] = [change_leaves(one, place, change, (*at, index)) for index, one in enumerate(below)]
        elif is_mapping(below) and not place.is_form(below):
            made[key] = {scene: change_leaves(one, place, change, (*at, scene)) for scene, one in below.items()}
        else:
            made[key] = change_leaves(below, place, change, at)
    return made
