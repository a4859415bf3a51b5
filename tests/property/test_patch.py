"""JSON Patch on texts: the data of a plain implementation, and every comment outside what an operation names."""

from __future__ import annotations

import json
import re
from copy import deepcopy
from typing import Any

import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plugins.nightly import examples

from scenecc.diagnostics import Sink
from scenecc.scene_file.json_patch import patch_text
from scenecc.source import Limits, read_text

SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]
KEYS = st.sampled_from(["a", "b", "pose", "shapes", "x y", "k.1", "on", "1", "a/b", "m~n", "é"])
WORDS = st.sampled_from(
    ["box", "a b", "${x + 1}", "it's", 'say "so"', "true", "12", "# no", "a: b", "- c", "é", "", "&a"]
)
NUMBERS = st.one_of(st.integers(-1000, 1000), st.sampled_from([0.5, -0.25, 1.5, 1e-5, 0.2, 3.25e10, 1 / 3]))
SCALARS = st.one_of(NUMBERS, st.booleans(), WORDS)


def nested(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.one_of(st.lists(inner, max_size=4), st.dictionaries(KEYS, inner, max_size=4))


VALUES = st.recursive(SCALARS, nested, max_leaves=8)
DOCUMENTS = st.dictionaries(KEYS, VALUES, min_size=1, max_size=4)


class Written:
    """Data as text in random notation. `comments`: number of each comment line → path of what it is in."""

    def __init__(self, draw: Any, data: dict[str, Any]) -> None:
        self._draw = draw
        self._step = draw(st.sampled_from([2, 4]))
        self._lists = draw(st.sampled_from([0, 2]))
        self.comments: dict[int, tuple[Any, ...]] = {}
        end = draw(st.sampled_from(["\n", "\r\n"]))
        self.text = end.join(self._block(data, (), 0)) + end * draw(st.booleans())

    def _comment(self, path: tuple[Any, ...], column: int) -> list[str]:
        if self._draw(st.integers(0, 3)):
            return []
        self.comments[len(self.comments)] = path
        blank = [""] * self._draw(st.booleans())
        return [*blank, f'{" " * column}# comment {len(self.comments) - 1}, [it\'s] {{a: "b"}}']

    def _scalar(self, value: Any, *, key: bool = False) -> str:
        if not isinstance(value, str):
            return json.dumps(value)
        plain = value.isalpha() and value.isascii() and value not in {"true", "on"}
        style = self._draw(st.sampled_from(["plain", "single", "double"]))
        if style == "plain" and plain:
            return value
        return "'" + value.replace("'", "''") + "'" if style == "single" else json.dumps(value, ensure_ascii=key)

    def _flow(self, value: Any) -> str:
        if isinstance(value, dict):
            return "{" + ", ".join(f"{self._scalar(k, key=True)}: {self._flow(v)}" for k, v in value.items()) + "}"
        if isinstance(value, list):
            gap, last = self._draw(st.sampled_from([(", ", ""), (",  ", " "), (" , ", ",")]))
            return "[" + gap.join(map(self._flow, value)) + last * bool(value) + "]"
        return self._scalar(value)

    def _block(self, value: Any, path: tuple[Any, ...], column: int) -> list[str]:
        lines: list[str] = []
        is_list = isinstance(value, list)
        for key, one in enumerate(value) if is_list else value.items():
            if lines or not is_list:
                lines += self._comment(path, column)
            head = f"{' ' * column}-" if is_list else f"{' ' * column}{self._scalar(key, key=True)}:"
            lines += self._entry(head, one, (*path, key), column, is_list=is_list)
        return lines

    def _entry(self, head: str, one: Any, path: tuple[Any, ...], column: int, *, is_list: bool) -> list[str]:
        beside = self._draw(st.sampled_from(["", "  # beside"]))
        if not isinstance(one, dict | list) or not one or self._draw(st.booleans()):
            return [f"{head} {self._flow(one)}{beside}"]
        if not is_list:
            return [
                head + beside,
                *self._block(one, path, column + (self._lists if isinstance(one, list) else self._step)),
            ]
        below = self._block(one, path, column + 2)
        if below[0].strip().startswith("#") or not below[0]:
            return [head, *below]
        return [f"{head} {below[0].lstrip()}", *below[1:]]


@st.composite
def written(draw: Any) -> tuple[dict[str, Any], Written]:
    data = draw(DOCUMENTS)
    return data, Written(draw, data)


def paths(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(found for key, one in items for found in paths(one, (*path, key)))]


def at(data: Any, path: tuple[Any, ...]) -> Any:
    for step in path:
        data = data[step]
    return data


def pointer(path: tuple[Any, ...]) -> str:
    return "".join("/" + str(one).replace("~", "~0").replace("/", "~1") for one in path)


@st.composite
def operation(draw: Any, data: dict[str, Any]) -> tuple[dict[str, Any], list[tuple[Any, ...]]]:
    """A valid operation, and the paths that it removes or overwrites."""
    every = paths(data)[1:]
    op = draw(st.sampled_from(["add", "remove", "replace", "move", "copy", "test"]))
    if not every or (op == "remove" and every == [every[0]] and len(data) == 1):
        op = "add"
    source: tuple[Any, ...] = draw(st.sampled_from(every)) if every else ()
    if op == "test":
        return {"op": "test", "path": pointer(source), "value": at(data, source)}, []
    if op in {"remove", "replace"}:
        if op == "remove" and len(source) == 1 and len(data) == 1:
            op = "replace"
        made = {"op": op, "path": pointer(source), "value": draw(VALUES)}
        return made, [source]
    if op == "move" and len(source) == 1 and len(data) == 1:
        op = "copy"
    rest = deepcopy(data)
    if op == "move":
        del at(rest, source[:-1])[source[-1]]
    where = [one for one in paths(rest) if isinstance(at(rest, one), dict | list)]
    above = draw(st.sampled_from(where))
    if op == "move" and above[: len(source)] == source:
        above = ()
    held = at(rest, above)
    step = draw(st.integers(0, len(held))) if isinstance(held, list) else draw(KEYS)
    path = (*above, step)
    if op == "move" and (path[: len(source)] == source and len(path) > len(source)):
        path = source
    last = "-" if isinstance(held, list) and step == len(held) and draw(st.booleans()) else None
    made = {"op": op, "path": pointer((*path[:-1], last)) if last else pointer(path)}
    made |= {"value": draw(VALUES)} if op == "add" else {"from": pointer(source)}
    return made, ([path] if isinstance(held, dict) else []) + ([source] if op == "move" else [])


def applied(data: dict[str, Any], one: dict[str, Any]) -> dict[str, Any]:
    """A plain implementation of RFC 6902."""
    data = deepcopy(data)

    def find(text: str) -> tuple[Any, Any]:
        above: Any = data
        steps = [step.replace("~1", "/").replace("~0", "~") for step in text.split("/")[1:]]
        for step in steps[:-1]:
            above = above[int(step) if isinstance(above, list) else step]
        last = steps[-1]
        return above, last if isinstance(above, dict) else len(above) if last == "-" else int(last)

    def put(text: str, value: Any) -> None:
        above, step = find(text)
        if isinstance(above, list):
            above.insert(step, value)
        else:
            above[step] = value

    match one["op"]:
        case "add":
            put(one["path"], deepcopy(one["value"]))
        case "remove":
            above, step = find(one["path"])
            del above[step]
        case "replace":
            above, step = find(one["path"])
            above[step] = deepcopy(one["value"])
        case "copy":
            above, step = find(one["from"])
            put(one["path"], deepcopy(above[step]))
        case "move":
            above, step = find(one["from"])
            put(one["path"], above.pop(step))
        case _:
            pass
    return data


class _Loader(yaml.SafeLoader):
    """YAML 1.2's booleans and numbers, which scene files have."""


_Loader.yaml_implicit_resolvers = {}
for tag, pattern, first in (
    ("tag:yaml.org,2002:bool", r"true|false", "tf"),
    ("tag:yaml.org,2002:int", r"[-+]?[0-9]+", "-+0123456789"),
    (
        "tag:yaml.org,2002:float",
        r"[-+]?[0-9]*\.?[0-9]+(?:e[-+]?[0-9]+)?|[-+]?[0-9]+\.(?:e[-+]?[0-9]+)?",
        "-+.0123456789",
    ),
):
    _Loader.add_implicit_resolver(tag, re.compile(f"^(?:{pattern})$"), list(first))


def load(text: str) -> Any:
    return yaml.load(text, Loader=_Loader)


@settings(max_examples=examples(400), deadline=None, suppress_health_check=SLOW)
@given(st.data())
def test_an_operation_gives_its_data_and_keeps_comments(draws: st.DataObject) -> None:
    data, file = draws.draw(written())
    assert load(file.text) == data
    made, gone = draws.draw(operation(data))
    after = patch_text(file.text, [made], Limits())
    assert load(after) == applied(data, made)
    for number, path in file.comments.items():
        if not any(path[: len(one)] == one for one in gone):
            assert f"# comment {number}, [it's]" in after
    assert "\n" not in after.replace("\r\n", "") if "\r\n" in file.text else "\r" not in after


@settings(max_examples=examples(80), deadline=None, suppress_health_check=SLOW)
@given(st.data())
def test_operations_apply_in_order(draws: st.DataObject) -> None:
    data, file = draws.draw(written())
    patch: list[dict[str, Any]] = []
    for _ in range(draws.draw(st.integers(1, 5))):
        made, _ = draws.draw(operation(data))
        patch.append(made)
        data = applied(data, made)
    after = patch_text(file.text, patch, Limits())
    assert load(after) == data
    document = read_text(after, None, Sink())
    assert document is not None
    assert document.data == data


@settings(max_examples=examples(80), deadline=None, suppress_health_check=SLOW)
@given(st.data())
def test_replaced_numbers_are_replaced_back_to_the_byte(draws: st.DataObject) -> None:
    data, file = draws.draw(written())
    numbers = [one for one in paths(data) if isinstance(at(data, one), int) and not isinstance(at(data, one), bool)]
    if not numbers:
        return
    where = draws.draw(st.lists(st.sampled_from(numbers), unique=True))
    there = [{"op": "replace", "path": pointer(one), "value": draws.draw(NUMBERS)} for one in where]
    back = [{"op": "replace", "path": pointer(one), "value": at(data, one)} for one in where]
    assert patch_text(patch_text(file.text, there, Limits()), back, Limits()) == file.text
