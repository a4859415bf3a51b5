"""The reader of plain YAML: what it reads, and what it leaves to the parser."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from scenecc.source.fast_reader import read_fast

READ: dict[str, Any] = {
    "a: 1": {"a": 1},
    "# about\n\na: 1 # one\n  # two\n": {"a": 1},
    "a:\n  b: true\n  c:   x y, z\nd: .inf": {"a": {"b": True, "c": "x y, z"}, "d": float("inf")},
    "a:\n- 1\n- b: 2\n  c: 3\n- [4]\nd: 5": {"a": [1, {"b": 2, "c": 3}, [4]], "d": 5},
    "a:\n  -  b:\n       - 1\n     c: 2": {"a": [{"b": [1], "c": 2}]},
    "a: [0.5, -1.25,2.0] # p": {"a": [0.5, -1.25, 2.0]},
    "a: [0, 1e3, x:y, 012, 12:30, '#ff0000', \"${i * 2}\"]": {
        "a": [0, 1000.0, "x:y", 12, "12:30", "#ff0000", "${i * 2}"]
    },
    "a: {b: [[1], {}], c: {d: []}}": {"a": {"b": [[1], {}], "c": {"d": []}}},
    "a: ''\nb: \"\"": {"a": "", "b": ""},
    "a: yes\nb: it's": {"a": "yes", "b": "it's"},
    "a: 'ü' # ö": {"a": "ü"},
    "use: scenecc:cube": {"use": "scenecc:cube"},
}


@pytest.mark.parametrize("text", READ)
def test_the_fast_reader_reads_plain_text(text: str) -> None:
    assert repr(read_fast(text, 100)) == repr(READ[text])


@pytest.mark.parametrize(
    "text",
    [
        "",
        "# nothing",
        "a:",
        "a:\nb: 1",
        "a: null",
        "a: [~]",
        "a: [0x1, null]",
        "a: {b: null}",
        "a: 1e999",
        "a: 1\na: 2",
        "a: {b: 1, b: 2}",
        "1: a",
        "true: a",
        "{a: 1}",
        "- 1",
        " a: 1",
        "a: 1\n b: 2",
        "a: 'x\u2028y'",
        "# a\u2029b: 1",
        "a:\n  b: 1\n c: 2",
        "a: 1\n- 2",
        "a:\n  - 1\n - 2",
        "a:\n  - b: 1\n   c: 2",
        "a:\n  - - 1",
        "a:\n  -\n    b: 1",
        "a: 1\n  2",
        "a: &x 1",
        "a: *x",
        "a: !!str 1",
        "<<: {a: 1}",
        "a: |\n  text",
        'a: "\\n"',
        "a: 'it''s'",
        'a: "b" c',
        "a: b: c",
        "a: [1, 2",
        "a: [1,\n  2]",
        "a: [1, ]",
        "a: [b: 1]",
        "a: {b}",
        "a: {b: }",
        "a: {b:1}",
        "a: ${b}",
        "a: [1] 2",
        "a: [1]# x",
        "a:\tb",
        "a: 1\r\n",
        "a: b#c",
        "---\na: 1",
        "%YAML 1.2\n---\na: 1",
        'a: "\ufeff"',
        "a: " + "[" * 9 + "]" * 9,
    ],
)
def test_the_fast_reader_declines_other_text(text: str) -> None:
    assert read_fast(text, 100) is None


def test_the_fast_reader_declines_text_near_the_depth_limit() -> None:
    text = "".join(f"{' ' * level}a:\n" for level in range(11)) + " " * 11 + "a: 1"
    assert read_fast(text, 20) is not None
    assert read_fast(text, 19) is None


def test_the_fast_reader_shares_no_lists(read: Callable[..., Any]) -> None:
    data = read("a:\n  b: [1]\nc:\n  b: [1]\n")
    assert data["a"]["b"] == data["c"]["b"]
    assert data["a"]["b"] is not data["c"]["b"]
