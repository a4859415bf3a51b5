"""JSON Patch (RFC 6902) on the text of a scene file: comments and everything that no operation names stay."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np

from scenecc.diagnostics import Sink
from scenecc.diagnostics.messages import cut, suggest
from scenecc.files import unique_keys
from scenecc.scene_file.layout import key_text, value_text
from scenecc.source import read_text
from scenecc.source.edits import EditError, Style, TextEdits
from scenecc.source.events import describe_type

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Path
    from scenecc.source import Limits
    from scenecc.source.edits import Write

_MEMBERS: Final = {
    "add": ("path", "value"),
    "remove": ("path",),
    "replace": ("path", "value"),
    "move": ("from", "path"),
    "copy": ("from", "path"),
    "test": ("path", "value"),
}
"""The members that each operation must have."""

_State = tuple[str, dict[str, Any]]
"""The text and its data."""

_INDEX: Final = re.compile(r"0|[1-9][0-9]{0,17}").fullmatch


class PatchError(Exception):
    """A patch is malformed or cannot be applied; the message names the operation.

    Attributes:
        path: the deepest existing node of the document on the way to where the operation failed.
        hint: how to correct the patch.
    """

    def __init__(self, message: str, path: Path = (), hint: str | None = None) -> None:
        self.path = path
        self.hint = hint
        super().__init__(message)


@dataclass(frozen=True, slots=True)
class Operation:
    """An operation of a patch. `path` and `source` are the tokens of its JSON Pointers; `value` is plain data."""

    op: str
    path: tuple[str, ...]
    source: tuple[str, ...] = ()
    value: Any = None


def parse_patch(text: str) -> list[Any]:
    """Returns the operations in the text of a patch. Raises PatchError if it is not a JSON list."""

    def refuse(word: str) -> None:
        raise PatchError(f"the patch contains {word}, which JSON cannot hold")

    try:
        patch = json.loads(text, parse_constant=refuse, object_pairs_hook=unique_keys)
    except json.JSONDecodeError as error:
        raise PatchError(f"the patch is not JSON: {error.msg}, line {error.lineno} column {error.colno}") from None
    except (ValueError, RecursionError) as error:
        raise PatchError(f"the patch is not JSON: {error}") from None
    if not isinstance(patch, list):
        raise PatchError(f"the patch is {describe_type(patch)}, not a list of operations", hint=_EXAMPLE)
    return cast("list[Any]", patch)


_EXAMPLE: Final = 'for example `[{"op": "replace", "path": "/entities/cube/mass", "value": 0.2}]`'


def patch_text(text: str, operations: Sequence[Any], limits: Limits) -> str:
    """Returns a text with all operations of a patch applied in order.

    After each, the text is read again and must hold what RFC 6902 says. So no edit at an anchor changes two places.

    Args:
        text: a scene file that can be read.
        operations: the patch, as from `json.loads`.
        limits: limits of the text.

    Raises:
        PatchError: an operation is malformed or cannot be applied.
    """
    try:
        return _patched(text, operations, limits)
    except RecursionError:
        raise PatchError("a value of the file or of the patch is deeper than Python's stack allows") from None


def _patched(text: str, operations: Sequence[Any], limits: Limits) -> str:
    parsed = [_parse(one, f"operation {number} of {len(operations)}") for number, one in enumerate(operations, 1)]
    data = _read(text, limits)
    for number, one in enumerate(parsed, 1):
        name = f"operation {number} of {len(parsed)} (`{one.op}` at {cut(pointer(one.path)) or 'the document'})"
        try:
            text, data = _apply(text, data, one, limits)
        except (PatchError, EditError) as error:
            path, hint = (error.path, error.hint) if isinstance(error, PatchError) else ((), None)
            raise PatchError(f"{name}: {error}", path, hint) from None
    return text


def _read(text: str, limits: Limits) -> dict[str, Any]:
    """Returns the data of a text, without shared parts. Raises EditError if it is invalid; the message says why."""
    sink = Sink()
    document = read_text(text, None, sink, limits)
    if document is None:
        raise EditError(f"the file could not be read again: {sink.diagnostics()[0].message}")
    return json.loads(json.dumps(document.data))  # aliases share parts


def _parse(written: Any, name: str) -> Operation:
    """Checks an operation. Raises PatchError."""
    if not isinstance(written, Mapping):
        raise PatchError(f"{name} is {describe_type(written)}, not a mapping", hint=_EXAMPLE)
    given = cast("Mapping[str, Any]", written)
    op = given.get("op")
    if not isinstance(op, str) or op not in _MEMBERS:
        what = "has no `op`" if op is None else f"has the unknown `op` {cut(str(op))}"
        raise PatchError(f"{name} {what}", hint=suggest(str(op), _MEMBERS) if op else f"known: {', '.join(_MEMBERS)}")
    for member in _MEMBERS[op]:
        if member not in given:
            near = suggest(member, [one for one in given if one not in {"op", *_MEMBERS[op]}])
            raise PatchError(f"{name} (`{op}`) has no `{member}`", hint=near)
    path, source = (_tokens(given[one], one, name) if one in _MEMBERS[op] else () for one in ("path", "from"))
    if op == "move" and len(path) > len(source) and path[: len(source)] == source:
        raise PatchError(f"{name} (`move`): {cut(pointer(path))} is inside of {cut(pointer(source))}")
    return Operation(op, path, source, given.get("value"))


def _tokens(text: Any, member: str, name: str) -> tuple[str, ...]:
    if not isinstance(text, str):
        raise PatchError(f"{name}: `{member}` is {describe_type(text)}, not a JSON Pointer such as /entities/cube")
    if text and not text.startswith("/"):
        hint = f"write `/{text.replace('.', '/')}`"
        raise PatchError(f"{name}: `{member}` {cut(text)} must begin with a slash", hint=hint)
    if re.search(r"~(?![01])", text):
        raise PatchError(f"{name}: in `{member}` {cut(text)}, `~` must be written as `~0`")
    return tuple(one.replace("~1", "/").replace("~0", "~") for one in text.split("/")[1:])


def pointer(path: Sequence[str | int]) -> str:
    """Returns a path as a JSON Pointer."""
    return "".join(f"/{str(one).replace('~', '~0').replace('/', '~1')}" for one in path)


def _apply(text: str, data: dict[str, Any], one: Operation, limits: Limits) -> _State:
    """Returns text and data after an operation. Raises PatchError or EditError."""
    if one.op == "test":
        path, found = _look_up(data, one.path)
        if not equal(found, one.value):
            shown = cut(json.dumps(found, ensure_ascii=False))
            raise PatchError(f"the value is {shown}, not {cut(json.dumps(one.value))}", path)
        return text, data
    if not one.path:
        raise PatchError("the whole document cannot be replaced: write the file")
    apply = {"add": _add, "remove": _remove, "replace": _replace, "copy": _copy, "move": _move}[one.op]
    return apply(text, deepcopy(data), one, limits)


def _remove(text: str, data: dict[str, Any], one: Operation, limits: Limits) -> _State:
    return _removed(text, data, _look_up(data, one.path)[0], limits)


def _removed(text: str, data: dict[str, Any], path: Path, limits: Limits) -> _State:
    del _at(data, path[:-1])[path[-1]]
    return _checked([lambda edits: edits.remove(path)], text, data, path, limits)


def _replace(text: str, data: dict[str, Any], one: Operation, limits: Limits) -> _State:
    if _is_new_key(data, one.path):
        above = _look_up(data, one.path[:-1])[0]
        fault = _missing(_at(data, above), one.path[-1], above)
        raise PatchError(f"{fault}; `add` adds a key", above, fault.hint)
    path, _ = _look_up(data, one.path)
    _at(data, path[:-1])[path[-1]] = deepcopy(one.value)
    return _checked([lambda edits: _set(edits, path, one.value)], text, data, path, limits)


def _add(text: str, data: dict[str, Any], one: Operation, limits: Limits) -> _State:
    return _added(text, data, _place(data, one.path), one.value, [], limits)


def _copy(text: str, data: dict[str, Any], one: Operation, limits: Limits) -> _State:
    start, value = _look_up(data, one.source)
    if not start:
        raise PatchError("the whole document cannot be copied into itself")
    return _added(text, data, _place(data, one.path), deepcopy(value), _as_written(text, start), limits)


def _move(text: str, data: dict[str, Any], one: Operation, limits: Limits) -> _State:
    """Moves a value; renames a key in its place if both places are in one mapping."""
    start, value = _look_up(data, one.source)
    if one.source == one.path:
        return text, data
    if one.source[:-1] == one.path[:-1] and _is_new_key(data, one.path):
        path = (*start[:-1], one.path[-1])
        above = _at(data, start[:-1])
        above[one.path[-1]] = above.pop(start[-1])
        return _checked([lambda edits: edits.rename(start, key_text(one.path[-1], path))], text, data, path, limits)
    written = _as_written(text, start)
    text, data = _removed(text, data, start, limits)
    return _added(text, data, _place(data, one.path), value, written, limits)


def _as_written(text: str, path: Path) -> list[Write]:
    try:
        write = TextEdits(text).source(path)
    except EditError:  # it comes from a merge key
        return []
    return [] if write is None else [write]


def _added(text: str, wanted: dict[str, Any], path: Path, value: Any, first: list[Write], limits: Limits) -> _State:
    """Adds a value that is not there, or replaces that of a key. `first`: how to write it, if it reads back so."""
    above = _at(wanted, path[:-1])
    is_there = isinstance(above, dict) and path[-1] in above
    if isinstance(above, list):
        cast("list[Any]", above).insert(int(path[-1]), deepcopy(value))
    else:
        above[path[-1]] = deepcopy(value)

    def edit(edits: TextEdits, write: Write) -> None:
        if is_there:
            _set(edits, path, value, write)
        else:
            edits.insert(path[:-1], path[-1], key_text(str(path[-1]), path), write)

    made = [partial(edit, write=write) for write in (*first, _writer(value, path, TextEdits(text).step))]
    return _checked(made, text, wanted, path, limits)


def _set(edits: TextEdits, path: Path, value: Any, write: Write | None = None) -> None:
    """Replaces a value; adds the key to a mapping that has it from a merge key."""
    write = write or _writer(value, path, edits.step)
    if edits.has(path):
        edits.replace(path, write)
    else:
        edits.insert(path[:-1], path[-1], key_text(str(path[-1]), path), write)


def _writer(value: Any, path: Path, step: int) -> Write:
    def write(column: int, style: Style) -> str | Sequence[str]:
        try:
            return value_text(value, path, column, style, step=step)
        except TypeError:
            raise EditError("a scene file cannot hold the value: is there a null? `remove` removes a key") from None

    return write


def _checked(
    edits: Sequence[Callable[[TextEdits], None]], text: str, wanted: dict[str, Any], path: Path, limits: Limits
) -> _State:
    """Returns the text after the first edit that makes it read as wanted, and that data.

    Raises:
        PatchError: the place is written elsewhere, or the edit would also change another place.
    """
    fault = ""
    for edit in edits:
        made = TextEdits(text)
        try:
            edit(made)
            if equal(_read(made.result(), limits), wanted):
                return made.result(), wanted
            fault = "other places use it through an anchor, and would change with it: edit the text"
        except EditError as error:
            fault = str(error)
    raise PatchError(fault, path)


def _look_up(data: Any, tokens: Sequence[str]) -> tuple[Path, Any]:
    """Returns the path and the value of a pointer. Raises PatchError if there is none."""
    path: list[str | int] = []
    for token in tokens:
        step = _step(data, token, path)
        if step == len(data) and not isinstance(step, str):
            raise _missing(data, token, path)
        path.append(step)
        data = _at(data, (step,))
    return tuple(path), data


def _place(data: Any, tokens: Sequence[str]) -> Path:
    """Returns the path of a new key or item. Raises PatchError if what should hold it does not exist."""
    path, above = _look_up(data, tokens[:-1])
    if isinstance(above, dict):
        return (*path, tokens[-1])
    return (*path, _step(above, tokens[-1], list(path)))


def _step(data: Any, step: str, path: list[str | int]) -> str | int:
    """Returns a token of a pointer as key or index; an index may be one past the end."""
    if isinstance(data, dict):
        if step not in data:
            raise _missing(data, step, path)
        return step
    if not isinstance(data, list):
        raise PatchError(f"{cut(pointer(path))} is {describe_type(data)}, which has no `{cut(step)}`", tuple(path))
    count = len(cast("list[Any]", data))
    if step == "-":
        return count
    if not _INDEX(step) or int(step) > count:
        raise _missing(data, step, path)
    return int(step)


def _missing(data: Any, token: str, path: Sequence[str | int]) -> PatchError:
    where = cut(pointer(path)) or "the document"
    if isinstance(data, dict):
        hint = suggest(token, cast("dict[str, Any]", data))
        return PatchError(f"there is no key `{cut(token)}` in {where}", tuple(path), hint)
    count = len(data)
    return PatchError(f"there is no item `{cut(token)}` in {where}, which has {count} (0 is the first)", tuple(path))


def _at(data: Any, path: Path) -> Any:
    for step in path:
        data = data[step]
    return data


def _is_new_key(data: Any, tokens: Sequence[str]) -> bool:
    above = _look_up(data, tokens[:-1])[1]
    return isinstance(above, dict) and tokens[-1] not in above


def equal(a: Any, b: Any) -> bool:
    """Returns whether two values are equal in JSON. Integers must be the same; other numbers the same float32."""
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        one, other = cast("Mapping[str, Any]", a), cast("Mapping[str, Any]", b)
        return one.keys() == other.keys() and all(equal(one[key], other[key]) for key in one)
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        first, second = cast("Sequence[Any]", a), cast("Sequence[Any]", b)
        return len(first) == len(second) and all(map(equal, first, second))
    if isinstance(a, bool) != isinstance(b, bool):
        return False
    if isinstance(a, int | float) and isinstance(b, int | float) and (isinstance(a, float) or isinstance(b, float)):
        with np.errstate(over="ignore"):
            return a == b or (math.isnan(a) and math.isnan(b)) or (abs(a) < 3e38 and np.float32(a) == np.float32(b))
    return a == b
