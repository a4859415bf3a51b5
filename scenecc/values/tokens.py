"""The characters of an expression, looked at before Python's parser sees them.

Python's own reader takes more than an expression may hold, warns about what it dislikes, and can run out of
memory or stack on hostile text. What passes here is short, shallow and made of known tokens alone.
"""

from __future__ import annotations

import keyword
import re

from scenecc.diagnostics.messages import cut
from scenecc.values.failure import ExpressionError

LONGEST = 1000
"""How long an expression may be [characters]."""

DEEPEST_BRACKETS = 30
"""How many brackets may stand within one another."""

_TOKEN = re.compile(
    r"""(?P<space>[ \t\r\n]+)
    |(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)
    |(?P<name>[A-Za-z_][A-Za-z0-9_]*)
    |(?P<string>'(?:[^'\\\r\n\ud800-\udfff]|\\[\\'"nt])*'|"(?:[^"\\\r\n\ud800-\udfff]|\\[\\'"nt])*")
    |(?P<operator>\*\*|//|<=|>=|==|!=|[-+*/%<>,])
    |(?P<open>[(\[])
    |(?P<close>[)\]])
    |(?P<end>\})""",
    re.VERBOSE,
)
_WORDS = frozenset(("and", "or", "not", "if", "else", "True", "False"))
_REFUSED = frozenset(keyword.kwlist) - _WORDS
_PAIRS = {"(": ")", "[": "]"}
_HINTS = {
    "?": "a choice is written `a if condition else b`",
    "^": "a power is written `a ** b`",
    "&": "write `and`",
    "|": "write `or`",
    "!": "write `not`, or `!=` between two values",
    "$": "names are written without `$`",
}
_REASONS = {
    ".": "attributes are not allowed in an expression",
    ":": "neither slices nor `:=` are allowed in an expression",
    "=": "a comparison is written `==`",
    "{": "braces are not allowed in an expression",
    "#": "comments are not allowed in an expression",
    "\\": "a backslash may only stand in a string, as \\\\, \\', \\\", \\n or \\t",
}


def closing(text: str, start: int) -> int:
    """Where the `}` stands that ends the expression whose first character is at `start`.

    Raises:
        ExpressionError: there is none, or something that no expression holds comes before it.
    """
    limit = min(len(text), start + LONGEST + 1)
    opened: list[tuple[str, int]] = []
    before, at = "space", start
    while at < limit:
        found = _TOKEN.match(text, at, limit)
        if found is None:
            raise _unreadable(text, start, at, limit)
        kind, token = str(found.lastgroup), found.group()
        match kind:
            case "number" | "string":
                _check_literal(kind, token, before, at)
            case "name" if token in _REFUSED or before == "number":
                what = f"`{token}` is not allowed in an expression" if before != "number" else "this is no number"
                raise ExpressionError(what, at, found.end())
            case "open":
                opened.append((_PAIRS[token], at))
                if len(opened) > DEEPEST_BRACKETS:
                    raise ExpressionError(f"more than {DEEPEST_BRACKETS} brackets within one another", at, at + 1)
            case "close":
                if not opened or opened.pop()[0] != token:
                    raise ExpressionError(f"`{token}` closes nothing", at, at + 1)
            case "end":
                if opened:
                    raise ExpressionError("this bracket is never closed", opened[-1][1], opened[-1][1] + 1)
                return at
            case _:
                pass
        # Two strings with a space between them are still side by side.
        before = before if kind == "space" and before == "string" else kind
        at = found.end()
    raise _endless(text, start, limit)


def _check_literal(kind: str, token: str, before: str, at: int) -> None:
    end = at + len(token)
    if kind == "number":
        if before in {"number", "name"}:
            raise ExpressionError("this is no number", at, end)
        if token.isdecimal() and token[0] == "0" and token.strip("0"):
            raise ExpressionError("a number is written without leading zeros", at, end)
    elif before == "name":
        raise ExpressionError("strings take no prefix", at, end)
    elif before == "string":
        raise ExpressionError("two strings side by side", at, end, "a comma or `+` is missing")


def _unreadable(text: str, start: int, at: int, limit: int) -> ExpressionError:
    found = text[at]
    if found in "'\"":
        if limit == start + LONGEST + 1:
            return _endless(text, start, limit)
        hint = r"a string ends on its own line, and a backslash in it is followed by \, ', " + '", n or t'
        return ExpressionError("this string cannot be read", at, at + 1, hint)
    shown = found if found.isprintable() else ascii(found)[1:-1]
    message = _REASONS.get(found, f"`{cut(shown)}` has no place in an expression")
    return ExpressionError(message, at, at + 1, _HINTS.get(found))


def _endless(text: str, start: int, limit: int) -> ExpressionError:
    if limit < len(text) or limit > start + LONGEST:
        return ExpressionError(f"an expression has at most {LONGEST} characters", start, limit)
    return ExpressionError("`${` is never closed", start - 2, start, "write `$${` for the characters themselves")
