"""What the reader gives for plain YAML."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

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
def test_plain_text_is_read(text: str, read: Callable[..., Any]) -> None:
    assert repr(read(text)) == repr(READ[text])


def test_equal_lines_share_no_lists(read: Callable[..., Any]) -> None:
    data = read("a:\n  b: [1]\nc:\n  b: [1]\n")
    assert data["a"]["b"] == data["c"]["b"]
    assert data["a"]["b"] is not data["c"]["b"]
