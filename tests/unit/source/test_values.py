"""Scenes given as Python data."""

from __future__ import annotations

import copy
import enum
import time
from collections import OrderedDict
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from plugins.diagnostics import TakingSink
from plugins.nightly import assert_took

from scenecc.diagnostics import Sink
from scenecc.source import Limits, read_dict


class Colour(str, enum.Enum):
    RED = "red"


class Number(enum.IntEnum):
    TWO = 2


TAKEN: list[tuple[Any, Any]] = [
    ((1, 2.5), [1, 2.5]),
    ([(1,), [2]], [[1], [2]]),
    (np.float32(0.1), float(np.float32(0.1))),
    (np.float64(0.1), 0.1),
    (np.int8(3), 3),
    (np.bool_(True), True),
    (np.str_("x"), "x"),
    (np.array([1.5, 2.0]), [1.5, 2.0]),
    (np.array([[1, 2], [3, 4]], dtype=np.uint8), [[1, 2], [3, 4]]),
    (np.array(7), 7),
    (np.array([], dtype=float), []),
    (np.array(["a", "b"]), ["a", "b"]),
    (np.array([True]), [True]),
    (Path("a") / "b.obj", "a/b.obj"),
    (PurePosixPath("/c"), "/c"),
    (OrderedDict(a=1), {"a": 1}),
    (MappingProxyType({"a": (1,)}), {"a": [1]}),
    (Colour.RED, "red"),
    (Number.TWO, 2),
    ({np.str_("k"): {Colour.RED: 1}}, {"k": {"red": 1}}),
    ({"per_scene": {0: 1, np.str_("default"): 2}}, {"per_scene": {"0": 1, "default": 2}}),
    (float("inf"), float("inf")),
    ("", ""),
    ({}, {}),
]


def _is_plain(value: Any) -> bool:
    if type(value) is dict:
        return all(type(key) is str and _is_plain(item) for key, item in value.items())
    if type(value) is list:
        return all(map(_is_plain, value))
    return type(value) in (str, int, float, bool)


@pytest.mark.parametrize(("value", "plain"), TAKEN, ids=lambda value: repr(value).partition(" at 0x")[0][:30])
def test_python_values_are_converted_to_plain_data(value: Any, plain: Any, sink: TakingSink) -> None:
    document = read_dict({"x": [value]}, sink)
    assert document is not None
    assert document.data == {"x": [plain]}
    assert _is_plain(document.data)
    assert (document.name, document.path) == (None, None)


REFUSED: list[tuple[Any, str, str]] = [
    ({"a": None}, "SC006", "a"),
    ({"a": [1, None]}, "SC006", "a[1]"),
    ({"a": {1, 2}}, "SC015", "a"),
    ({"a": {"b": b"x"}}, "SC015", "a.b"),
    ({"a": object()}, "SC015", "a"),
    ({"a": 1j}, "SC015", "a"),
    ({"a": range(3)}, "SC015", "a"),
    ({"a": (i for i in range(3))}, "SC015", "a"),
    ({"a": np.array([object()])}, "SC015", "a"),
    ({"a": np.array([1j])}, "SC015", "a"),
    ({"a": np.datetime64("2001-01-01")}, "SC015", "a"),
    ({"a": np.array([b"x"])}, "SC015", "a"),
    ({1: 2}, "SC005", ""),
    ({"per_scene": {True: 2}}, "SC005", "per_scene"),
    ({"a": {None: 2}}, "SC005", "a"),
    ({"a": {("x",): 2}}, "SC005", "a"),
    ({"a": {b"x": 2}}, "SC005", "a"),
    ({"a": 10**100}, "SC014", "a"),
    ({"a": -(10**100)}, "SC014", "a"),
    ({"a": "\ud800"}, "SC002", "a"),
    ({"a": {"\ud800": 1}}, "SC002", "a.\ud800"),
]


@pytest.mark.parametrize(("data", "code", "path"), REFUSED, ids=lambda value: repr(value).partition(" at 0x")[0][:30])
def test_unsupported_python_values_are_refused(data: Any, code: str, path: str) -> None:
    sink = Sink()
    assert read_dict(data, sink) is None
    (found,) = sink.diagnostics()
    assert (found.code, found.path, found.line) == (code, path, None)


def test_all_errors_of_a_dict_are_reported_at_once(sink: TakingSink) -> None:
    assert read_dict({"a": None, "b": [b"", {"c": {1}}], "d": {1: 2}}, sink) is None
    sink.take("SC006", path="a")
    sink.take("SC015", path="b[0]")
    sink.take("SC015", path="b[1].c")
    sink.take("SC005", path="d")


def test_the_input_dict_is_copied_and_unchanged(sink: TakingSink) -> None:
    array = np.array([1.0, 2.0])
    inner: dict[str, Any] = {"p": (1, 2), "array": array}
    data = {"a": inner, "b": [inner]}
    before = copy.deepcopy(data)
    document = read_dict(data, sink)
    assert document is not None
    document.data["a"]["p"].append(3)
    document.data["b"].append(4)
    assert inner["p"] == before["a"]["p"] == (1, 2)
    assert inner["array"] is array
    assert data["b"] == [inner]


def test_a_dict_that_contains_itself_is_refused() -> None:
    loop: dict[str, Any] = {"x": 1}
    loop["y"] = [loop]
    sink = Sink()
    assert read_dict(loop, sink) is None
    assert [(found.code, found.path) for found in sink.diagnostics()] == [("SC010", "y[0]")]


def test_shared_parts_of_a_dict_are_allowed(sink: TakingSink) -> None:
    box = {"type": "box", "half_size": (1, 2, 3)}
    document = read_dict({"a": [box] * 50_000}, sink)
    assert document is not None
    assert len(document.data["a"]) == 50_000


def test_a_dict_that_unfolds_to_a_huge_size_is_refused() -> None:
    bomb: Any = [1] * 10
    for _ in range(30):
        bomb = [bomb] * 10
    sink = Sink()
    start = time.process_time()
    assert read_dict({"a": bomb}, sink) is None
    assert_took(time.process_time() - start, most=1.0)
    assert [found.code for found in sink.diagnostics()] == ["SC601"]


@pytest.mark.parametrize("levels", [101, 5000])
def test_a_dict_that_is_too_deep_is_refused(levels: int) -> None:
    data: Any = 1
    for _ in range(levels):
        data = {"a": data}
    sink = Sink()
    assert read_dict(data, sink) is None
    assert [found.code for found in sink.diagnostics()] == ["SC602"]
    assert read_dict(data, Sink(), Limits(depth=100_000)) is None or levels == 101


def test_depth_counts_through_shared_parts() -> None:
    data: Any = [1]
    for _ in range(60):
        data = [data]
    shared = data
    for _ in range(60):
        data = [data]
    sink = Sink()
    assert read_dict({"first": shared, "second": data}, sink) is None
    assert [found.code for found in sink.diagnostics()] == ["SC602"]


def test_reading_a_dict_does_not_load_numpy() -> None:
    import subprocess
    import sys

    script = (
        "import sys; from scenecc.source import read_dict; from scenecc.diagnostics import Sink;"
        "print(read_dict({'a': (1,)}, Sink()).data, 'numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "{'a': [1]} False\n"
