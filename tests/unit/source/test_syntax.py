"""What is said of bad YAML: the place, and a hint that names the likely cause."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from scenecc.diagnostics import Diagnostic

CASES = {
    "a: [${x}, 1]": (1, 1, 13, "expression", 'write `a: ["${x}", 1]`'),
    "a:\n  - {b: ${x / 2}}": (2, 3, 18, "expression", 'write `- {b: "${x / 2}"}`'),
    "a: {${x}: 1}": (1, 1, 13, "expression", '"${x}"'),
    "a: [1, -${x}]": (1, 10, 11, "comma", "quote strings"),
    "a:\n\tb: 1": (2, 1, 2, "tab", "spaces"),
    "a:\n  \tb: 1": (2, 3, 4, "tab", "spaces"),
    "a: b: c": (1, 5, 6, "second `: `", "quote"),
    "a: http://x: 1": (1, 12, 13, "second `: `", "quote"),
    "x: 0\na:1\nb: 2": (2, 1, 4, "the space is missing after a colon", "write `a: 1`"),
    "a: 1\nb:2\nc: 3": (2, 1, 4, "the space is missing after a colon", "write `b: 2`"),
    "a: 1\n  b: 2": (2, 3, 7, "bad indentation", "remove the blanks before it"),
    "a: 1\n# c\n\n  b: 2": (4, 3, 7, "bad indentation", "remove the blanks before it"),
    "a:\n  b: 1\n c: 2": (3, 2, 6, "bad indentation", "indent it by 2 spaces"),
    "a: 1\nfoo\nb: 2": (2, 1, 4, "not a key and a value", "key: value"),
    "a: [1, 2\nb: 3": (1, 1, 9, "this `[` is never closed: `]` is missing", "write `a: [1, 2]`"),
    "a: {x: 1, y: 2\nb: 3": (1, 1, 15, "this `{` is never closed: `}` is missing", "write `a: {x: 1, y: 2}`"),
    "a: {x: 1, y: [2}, z: 3}": (
        1,
        1,
        24,
        "`]` is missing: this `}` does not close `[`",
        "write `a: {x: 1, y: [2], z: 3}`",
    ),
    "a: [1, 2\n\n": (1, 1, 9, "this `[` is never closed: `]` is missing", "write `a: [1, 2]`"),
    "a: {b: [1]\n \n": (1, 1, 11, "this `{` is never closed: `}` is missing", "write `a: {b: [1]}`"),
    "a: 'x\nb: 1": (1, 1, 6, "this quote is never closed", "write `a: 'x'`"),
    "a: [1, , 2]": (1, 8, 9, "a value is missing before this comma", "comma"),
    "a: ]": (1, 1, 5, "this `]` closes nothing: `[` is missing", "write `a: []`"),
    "n: \nd: {c,": (2, 7, 8, "expected a value, not the end", "bracket"),
    "n: \nd: [1,\n": (3, 1, 2, "expected a value, not the end", "bracket"),
    "a: [1]]\nb: 1": (1, 1, 8, "this `]` closes nothing", "write `a: [1]`"),
    'a: "x" y': (1, 8, 9, "after a complete value", "quote the whole"),
    "a: @x": (1, 4, 5, "cannot start with `@`", "quote"),
    "a: %x": (1, 4, 5, "cannot start with `%`", "quote"),
    "a: *": (1, 4, 5, "cannot start with `*`", "quote"),
    "a: & b": (1, 4, 7, "cannot start with `&`", "quote"),
    'a: "\\q"': (1, 5, 6, "escape", "backslash"),
    "a: - 1": (1, 4, 5, "list item cannot start here", "line of its own"),
    "a:\n- 1\nb: 2\n- 3": (4, 1, 2, "list item among keys", "not both"),
    "a:\n  - b\n  c: 1": (3, 3, 7, "bad indentation", "remove the blanks before it"),
    "a: 1\n...\nb": (3, 1, 2, "after the end", None),
    "a:\n  b 1\n  c: 2": (2, 3, 6, "the colon is missing after `b`", "write `b: 1`"),
    "a:\n  b = [1, 2]\n  c: 2": (2, 3, 13, "the colon is missing after `b`", "write `b: [1, 2]`"),
    "a:\n  b: 1\n   c: 2\n  d: 3": (3, 4, 8, "the lines around it have 2 spaces, not 3", "indent it by 2 spaces"),
    "a:\n  b: 1\n  - c: 2\n  d: 3": (3, 3, 9, "a list item among keys", "write `c: 2`"),
    "a:\n  -{b: 1}\n  - {b: 2}": (2, 3, 10, "the space is missing after the `-`", "write `- {b: 1}`"),
    "a: {b: [1, 2], c: 3 d: 4}": (1, 1, 26, "a comma is missing", "write `a: {b: [1, 2], c: 3, d: 4}`"),
    "a: {b: '#ff0000, c: 3}": (1, 1, 23, "this quote is never closed", "write `a: {b: '#ff0000', c: 3}`"),
    "a: |x\n  b": (1, 5, 6, "comment or line break", None),
    "a: [1] // b": (1, 1, 12, "`//` does not start a comment", "write `a: [1] # b`"),
    "a: {use: scenecc: cube}": (1, 1, 24, "a space is not allowed", "write `a: {use: scenecc:cube}`"),
    "a:\n  use: scenecc: cube": (2, 3, 21, "a space is not allowed", "write `use: scenecc:cube`"),
    "x: 1\n" + "k" * 2000 + ": 1": (2, 1, None, "not a key", "key: value"),
}


@pytest.mark.parametrize("text", CASES)
def test_each_syntax_error_has_its_message_and_hint(text: str, faults: Callable[..., list[Diagnostic]]) -> None:
    found = next(one for one in faults(text) if one.code == "SC003")
    line, column, end_column, message, hint = CASES[text]
    print(found, found.hint)
    assert (found.line, found.column) == (line, column)
    assert end_column in (None, found.location.end_column)
    assert message in found.message
    assert hint is None or hint in (found.hint or "")


def test_an_unclosed_bracket_is_reported_with_its_start(faults: Callable[..., list[Diagnostic]]) -> None:
    (found,) = faults("a:\n  b: [1,\n    2\nc: 3")
    (related,) = found.related
    assert (related.location.line, related.location.column) == (2, 6)


@pytest.mark.parametrize("text", ["a: {b:1}", "a: {b:1, c: 2}"])
def test_a_missing_space_after_a_colon_in_braces_is_reported(
    text: str, faults: Callable[..., list[Diagnostic]]
) -> None:
    (found,) = faults(text)
    assert (found.code, found.column) == ("SC006", 5)
    assert "key: value" in (found.hint or "")
