"""The forms of variation as they are written, to those of `scenecc.variation.forms`."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from scenecc.diagnostics.messages import cut, show
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.drawn import read_drawn
from scenecc.spec.expressions import written
from scenecc.spec.mistakes import THIS, Mistakes, told
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.spec.unions import EXPANDED, any_varying, is_varying
from scenecc.variation import forms
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.forms import FORM_KEYS
from scenecc.variation.template import Template

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.diagnostics import PathKey
    from scenecc.spec.domain import Domain

    Loc = tuple[PathKey, ...]
    Validate = Callable[[Any], Any]

COMPANIONS = {"choice": "weights", **{key: one.companion for key, one in DISTRIBUTIONS.items() if one.companion}}
"""Form → the key that may stand beside it."""

DEFAULT = "default"

_OF_POSES = frozenset(("p", "q", "rpy", "rpy_deg", "axis_angle", "look_at", "relative_to"))
_INDEX = re.compile(r"0|[1-9][0-9]{0,17}")


class FormReader:
    """Reads what varies of one value.

    Args:
        mistakes: takes what is wrong.
        refused: why no form may stand here, though an expression may; None: forms may.
    """

    def __init__(self, mistakes: Mistakes, refused: str | None = None) -> None:
        self._mistakes = mistakes
        self._refused = refused

    def mistake(self, code: str, message: str, found: Any, loc: Loc, hint: str | None = None) -> None:
        """Adds a mistake."""
        self._mistakes.add(told(code, message, hint=hint), found, *loc)

    def leaf(self, node: Any, domain: Domain, plain: Validate, loc: Loc) -> Any:
        """A value that may vary; None where that was a mistake.

        Args:
            node: as written.
            domain: the numbers that it may consist of.
            plain: validates one that does not vary.
            loc: where it is in the value that is validated.
        """
        if is_varying(node):
            return self._form(node, domain, plain, loc) if is_mapping(node) else self._template(node, loc)
        if is_sequence(node) and domain.item is not None and any_varying(node):
            return self.vector(node, domain, loc)
        return self.plain(node, plain, loc)

    def plain(self, node: Any, plain: Validate, loc: Loc) -> Any:
        """A value that does not vary; None where it is a mistake."""
        try:
            return plain(node)
        except ValidationError as problem:
            self._mistakes.take(problem, *loc)
            return None

    def _template(self, node: Any, loc: Loc) -> Template | None:
        if isinstance(node, Template):
            return node
        try:
            return written(node)
        except PydanticCustomError as mistake:
            self._mistakes.add(mistake, node, *loc)
            return None

    def varies(self, node: Any, domain: Domain) -> bool:
        """Whether a value, or a component of it, is an expression or a form."""
        if domain.item is None:
            return is_varying(node)
        return any_varying(node)

    def vector(self, node: Any, domain: Domain, loc: Loc) -> Any:
        """A list of numbers, some of which may vary."""
        item = domain.item
        assert item is not None
        if not domain.least <= len(node) <= domain.most:
            self._mistakes.add(wrong_length(domain, len(node)), node, *loc)
            return None
        parts = self.components(node, item, loc)
        return forms.Vector(parts) if any(self.varies(part, item) for part in node) else parts

    def components(self, node: Any, item: Domain, loc: Loc) -> tuple[Any, ...]:
        """The components of a list, each of which may vary."""
        return tuple(self.leaf(part, item, self._component(item, loc, i), (*loc, i)) for i, part in enumerate(node))

    def _component(self, item: Domain, loc: Loc, i: int) -> Validate:
        """Validates a component that does not vary: a number, or a list of components."""
        if item.number is not None:
            return item.validate_number

        def row(node: Any) -> Any:
            if not is_sequence(node):
                self._mistakes.add(told("SC103", f"{THIS} must be a list of numbers"), node, *loc, i)
                return None
            return self.vector(node, item, (*loc, i))

        return row

    def _form(self, node: dict[str, Any], domain: Domain, plain: Validate, loc: Loc) -> Any:
        key, *others = (key for key in node if key in FORM_KEYS)
        if self._refused is not None:
            return self.mistake("SC116", f"`{key}` has no place here", node, (*loc, key), self._refused)
        for other in others:
            message = f"`{key}` and `{other}` exclude each other: one form gives the value"
            self._mistakes.add(told("SC111", message, at="key"), node, *loc, other)
        for other in node:
            if other not in FORM_KEYS and other != COMPANIONS.get(key) and not other.startswith(NOTE_PREFIX):
                self._mistakes.add(_beside(other, key), node, *loc, other)
        if others:
            return None
        if key in DISTRIBUTIONS and not self._is_expression(node[key]):
            return read_drawn(self, key, node, domain, plain, loc)
        return self._listed(key, node, domain, plain, loc)

    def _listed(self, key: str, node: dict[str, Any], domain: Domain, plain: Validate, loc: Loc) -> Any:
        """A form whose values are listed, or any whose list is an expression."""
        given, at = node[key], (*loc, key)
        if self._is_expression(given):
            return self._list(given, at)
        if key == "per_scene":
            return self._per_scene(given, domain, plain, at)
        items = self._items(given, domain, plain, at)
        if key == "cycle":
            return forms.Cycle(items)
        return forms.Choice(items, self._weights(node, len(items), loc))

    def _is_expression(self, node: Any) -> bool:
        return is_varying(node) and not is_mapping(node)

    def _list(self, node: Any, loc: Loc) -> Any:
        """An expression in place of a form's list or of a weight: judged once it has its value."""
        if EXPANDED.get() or is_mapping(node):
            return self.mistake("SC116", f"{THIS} cannot differ from scene to scene", node, loc)
        return self._template(node, loc)

    def _items(self, node: Any, domain: Domain, plain: Validate, loc: Loc) -> tuple[Any, ...]:
        if not is_sequence(node):
            self._mistakes.add(told("SC103", f"{THIS} must be a list of values"), node, *loc)
            return ()
        if not node:
            self._mistakes.add(told("SC106", f"{THIS} must have at least 1 value, not 0"), node, *loc)
        return tuple(self.leaf(item, domain, plain, (*loc, i)) for i, item in enumerate(node))

    def _per_scene(self, node: Any, domain: Domain, plain: Validate, loc: Loc) -> Any:
        if not is_mapping(node):
            return forms.PerScene(self._items(node, domain, plain, loc))
        items: list[tuple[int, Any]] = []
        default: Any = forms.MISSING
        for key, item in node.items():
            if key.startswith(NOTE_PREFIX):
                continue
            value = self.leaf(item, domain, plain, (*loc, key))
            if key == DEFAULT:
                default = value
            elif _INDEX.fullmatch(key):
                items.append((int(key), value))
            else:
                message = f"`{cut(key)}` is no scene"
                hint = "a scene's index (0, 1, …) or `default`"
                self._mistakes.add(told("SC117", message, at="key", hint=hint), item, *loc, key)
        if not node:
            self._mistakes.add(told("SC106", f"{THIS} must have at least 1 value, not 0"), node, *loc)
        return forms.SceneMap(tuple(items), default)

    def _weights(self, node: dict[str, Any], count: int, loc: Loc) -> Any:
        if "weights" not in node:
            return None
        weights, at = node["weights"], (*loc, "weights")
        if is_varying(weights):
            return self._list(weights, at)
        if not is_sequence(weights):
            self._mistakes.add(told("SC103", f"{THIS} must be a list of numbers"), weights, *at)
            return None
        found = [self._weight(weight, (*at, i)) for i, weight in enumerate(weights)]
        if len(weights) != count:
            self._mistakes.add(told("SC106", f"{THIS} must have {count} values, one a choice"), weights, *at)
        elif found == [0.0] * count:
            self._mistakes.add(told("SC104", f"{THIS} must not all be 0"), weights, *at)
        return tuple(found)

    def _weight(self, node: Any, loc: Loc) -> Any:
        if is_varying(node):
            return self._list(node, loc)
        if isinstance(node, bool) or not isinstance(node, int | float):
            self._mistakes.add(told("SC103", f"{THIS} must be a number, not {show(node)}"), node, *loc)
            return None
        if not (math.isfinite(node) and node >= 0):
            message = f"{THIS} must be finite and at least 0, not {show(node)}"
            self._mistakes.add(told("SC104", message), node, *loc)
        return float(node)


def wrong_length(domain: Domain, count: int) -> PydanticCustomError:
    """A list of a wrong length."""
    most = str(domain.most) if domain.least == domain.most else f"{domain.least} to {domain.most}"
    return told("SC106", f"{THIS} must have {most} values, not {count}")


def _beside(other: str, key: str) -> PydanticCustomError:
    """A key that has no place beside a form's."""
    for form, companion in COMPANIONS.items():
        if other == companion:
            return told("SC117", f"`{other}` stands beside `{form}` only", at="key")
    hint = f"a pose that has more than a position is a mapping: `p: {{{key}: …}}`" if other in _OF_POSES else None
    return told("SC117", f"`{cut(other)}` has no place beside `{key}`", at="key", hint=hint)
