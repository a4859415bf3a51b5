"""Copies Python data to plain data as a text would give it, and rejects JSON objects that repeat a key."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, NoReturn, cast

from scenecc.diagnostics import Origin, Path, Sink
from scenecc.diagnostics.frozen import frozen
from scenecc.source.events import MAX_INTEGER_CHARS, RESERVED_CHARACTER, RESERVED_IN_KEY_MESSAGE, SCENE_KEYED_FIELD

if TYPE_CHECKING:
    from scenecc.source.limits import Limits


_MAX_INTEGER = 10**MAX_INTEGER_CHARS


@frozen
class _CopiedValue:
    """A container that was copied: the copy, and its nodes and height with shared parts unfolded."""

    value: Any
    nodes: int
    height: int


_INVALID = _CopiedValue(None, 1, 0)
"""The copy of what was reported."""


class _LimitReached(Exception):
    """A limit was reached."""


def copy_mapping(data: Mapping[str, Any], sink: Sink, limits: Limits) -> dict[str, Any] | None:
    """A copy of a mapping as plain dicts, lists and scalars; None, reported, if no scene can hold it.

    A part that the input shares is one object in the copy too, copied once.
    """
    copier = _Copier(sink, limits)
    try:
        copy = copier.copy(data, ())
    except _LimitReached:
        return None
    except RecursionError:
        sink.report("SC602", "the dict is deeper than Python's stack allows", Origin(None))
        return None
    return None if copier.failed else copy.value


class _Copier:
    def __init__(self, sink: Sink, limits: Limits) -> None:
        self._sink = sink
        self._limits = limits
        self.failed = False
        self._open: set[int] = set()
        # id → copy, and the original, which must live as long as its id means it.
        self._copies: dict[int, tuple[_CopiedValue, object]] = {}

    def copy(self, value: Any, path: Path) -> _CopiedValue:
        """The copy of any value; None, reported, of what no scene can hold."""
        if isinstance(value, (Mapping, list, tuple)):
            return self._shared(value, path)
        numpy = sys.modules.get("numpy")
        if numpy is not None and isinstance(value, (numpy.ndarray, numpy.generic)):
            return self._array(value, path)
        return _CopiedValue(self._scalar(value, path), 1, 0)

    def _array(self, array: Any, path: Path) -> _CopiedValue:
        if array.dtype.kind not in "biufU":
            self._refuse(f"a numpy value of dtype {array.dtype}", path)
            return _INVALID
        value = array.tolist()
        if isinstance(value, list):
            return self._container(value, path)
        return _CopiedValue(self._scalar(value, path), 1, 0)

    def _shared(self, value: Any, path: Path) -> _CopiedValue:
        known = self._copies.get(id(value))
        if known is not None:
            copy = known[0]
        elif id(value) in self._open:
            self._report("SC010", "this dict or list contains itself", path)
            return _INVALID
        else:
            self._open.add(id(value))
            copy = self._container(value, path)
            self._open.discard(id(value))
            self._copies[id(value)] = copy, value
        if len(path) + copy.height > self._limits.depth:
            self._too_deep(path)
        return copy

    def _container(self, value: Any, path: Path) -> _CopiedValue:
        if len(path) >= self._limits.depth:
            self._too_deep(path)
        if isinstance(value, Mapping):
            copies = dict(self._entries(cast("Mapping[Any, Any]", value), path))
            result: Any = {key: copy.value for key, copy in copies.items()}
            children = list(copies.values())
        else:
            children = [self.copy(item, (*path, index)) for index, item in enumerate(value)]
            result = [child.value for child in children]
        nodes = 1 + sum(child.nodes for child in children)
        if nodes > self._limits.text_bytes:
            self._too_long(path)
        return _CopiedValue(result, nodes, 1 + max((child.height for child in children), default=0))

    def _entries(self, mapping: Mapping[Any, Any], path: Path) -> Iterable[tuple[str, _CopiedValue]]:
        for key, value in mapping.items():
            name = _text_key(key, path)
            if name is None:
                self._report("SC005", f"the key {_format_key(key)} is not a string", path, hint="keys are strings")
                continue
            if RESERVED_CHARACTER in name:
                self._report("SC017", RESERVED_IN_KEY_MESSAGE, (*path, name))
                continue
            below = (*path, name)
            self._check_text(name, below)
            yield name, self.copy(value, below)

    def _scalar(self, value: Any, path: Path) -> Any:
        match value:
            case bool():
                return value
            # The base class's own conversion, so that enumerations and other subclasses leave no trace.
            case int():
                return self._in_range(int.__int__(value), path)
            case float():
                return float.__float__(value)
            case str():
                return self._check_text(str.__str__(value), path)
            case PurePath():
                return self._check_text(str(value), path)
            case None:
                hint = "give it a value, or remove the key to get its default"
                self._report("SC006", "None is not a value of any key", path, hint=hint)
            case _:
                self._refuse(_with_article(type(value).__qualname__), path)
        return None

    def _in_range(self, value: int, path: Path) -> int:
        if abs(value) >= _MAX_INTEGER:
            self._report("SC014", f"an integer of more than {MAX_INTEGER_CHARS} digits", path)
        return value

    def _check_text(self, text: str, path: Path) -> str:
        if not text.isascii():
            try:
                text.encode()
            except UnicodeEncodeError:
                message = f"a string contains a lone surrogate: {text!a:.60}"
                self._report("SC002", message, path)
        return text

    def _report(self, code: str, message: str, path: Path, *, hint: str | None = None) -> None:
        self.failed = True
        self._sink.report(code, message, Origin(None, path), hint=hint)

    def _refuse(self, what: str, path: Path) -> None:
        hint = "a scene contains dicts with string keys, lists, strings, numbers, booleans, numpy arrays and paths"
        self._report("SC015", f"{what} is not supported in a scene", path, hint=hint)

    def _too_deep(self, path: Path) -> NoReturn:
        message = f"more than {self._limits.depth} dicts and lists inside one another (limit depth)"
        hint = "`limits={'depth': N}` raises the limit"
        self._report("SC602", message, path[:8], hint=hint)
        raise _LimitReached

    def _too_long(self, path: Path) -> NoReturn:
        message = f"more than {self._limits.text_bytes} values, shared ones counted each time (limit text_bytes)"
        hint = "`limits={'text_bytes': N}` raises the limit"
        self._report("SC601", message, path, hint=hint)
        raise _LimitReached


def _text_key(key: object, path: Path) -> str | None:
    """A key as a text would give it; None if it is no string."""
    if isinstance(key, int) and not isinstance(key, bool) and path[-1:] == (SCENE_KEYED_FIELD,):
        return str(int.__int__(key))
    return str.__str__(key) if isinstance(key, str) else None


def _with_article(name: str) -> str:
    return f"{'an' if name[:1].lower() in tuple('aeiou') else 'a'} {name}"


def _format_key(key: object) -> str:
    """A key as Python writes it, if that is short and harmless."""
    return repr(key)[:40] if isinstance(key, (int, float, bytes, type(None))) else _with_article(type(key).__qualname__)
