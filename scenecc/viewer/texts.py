"""Texts of a page as escaped HTML."""

from __future__ import annotations

import re
from html import escape
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote

from scenecc.drawn_values import plain_values
from scenecc.inspect.facts import rotation_words
from scenecc.plan.display import format_item, to_tuples

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Diagnostic
    from scenecc.geometry.rotations import Pose7
    from scenecc.inspect import Item


_MOST_DRAWS: Final = 200
"""Maximum number of rows of a table."""

_STYLE = "font-size:0.75rem;line-height:1.45;padding:0.2rem 0.6rem;overflow-wrap:anywhere;"

_CODE = "font-family:ui-monospace,monospace;white-space:pre;overflow:auto;max-height:60vh;user-select:text;"


def message(text: str, *, color: str, links: bool = False) -> str:
    """Returns a message, line by line as on a terminal.

    Args:
        text: the message.
        color: colour of the bar beside it.
        links: whether places at the start of lines are links to an editor on this machine.
    """
    bar = f"border-left:3px solid {color};"
    lines = "\n".join(_linked(one, links=links) for one in text.rstrip().split("\n"))
    return f'<div style="{_STYLE}{_CODE}{bar}" class="scenecc-message">{lines}</div>'


_PLACE: Final = re.compile(r"(\S.*?):(\d+):(\d+)(?=: (?:error|warning|note) SC)")


def _linked(text: str, *, links: bool) -> str:
    found = _PLACE.match(text) if links else None
    if found is None:
        return escape(text)
    file, row, column = found.groups()
    return f"{_link(found[0], file, int(row), int(column))}{escape(text[found.end() :])}"


def findings(diagnostics: Sequence[Diagnostic], *, links: bool) -> str:
    """Returns one row per diagnostic. `links`: whether places are links to an editor on this machine."""
    rows = (
        f'<div style="border-left:3px solid {_COLORS[one.severity]};padding-left:0.5rem;margin:0.3rem 0">'
        f"{_place(one, links=links)}<b>{escape(one.code)}</b> {escape(one.message)}"
        f"{_aside(one.hint)}</div>"
        for one in diagnostics
    )
    return f'<div style="{_STYLE}" class="scenecc-findings">{"".join(rows)}</div>'


_COLORS = {"error": "#e03131", "warning": "#f08c00", "note": "#868e96"}


def _place(one: Diagnostic, *, links: bool) -> str:
    if one.file is None or one.line is None:
        return ""
    words = f"{PurePath(one.file).name}:{one.line}"
    return f"{_link(words, one.file, one.line, one.column or 1)} " if links else f"{escape(words)} "


def _link(words: str, file: str, row: int, column: int) -> str:
    target = quote(f"{Path(file).absolute().as_posix()}:{row}:{column}", safe="/:")
    return f'<a href="vscode://file{target}">{escape(words)}</a>'


def _aside(text: str | None) -> str:
    return f'<div style="opacity:0.6">{escape(text)}</div>' if text else ""


def line(text: str) -> str:
    """Returns a short text."""
    return f'<div style="{_STYLE}" class="scenecc-line">{escape(text)}</div>'


def pose(name: str, at: Pose7) -> str:
    """Returns where a body is now."""
    turned = rotation_words([round(number, 4) for number in at[3:]])
    place = format_item(tuple(round(number, 4) + 0.0 for number in at[:3]))
    words = f"{escape(name)}<br>{_label('now at')}{place} m<br>{_label('turned')}{escape(turned)}"
    return f'<div style="{_STYLE}" class="scenecc-pose">{words}</div>'


def draws(title: str, values: Mapping[str, NDArray[Any]]) -> str:
    """Returns a table of the drawn values of one scene, `values`: name → (1, …). Those that it lacks are left out."""
    found = [(name, value) for name, rows in values.items() if (value := plain_values(rows)[0]) is not None]
    rows = (
        f'<tr><td style="vertical-align:top;padding-right:0.5em">{_label(name)}</td>'
        f"<td>{escape(format_item(to_tuples(value)))}</td></tr>"
        for name, value in found[:_MOST_DRAWS]
    )
    more = f"<div>and {len(found) - _MOST_DRAWS} more</div>" if len(found) > _MOST_DRAWS else ""
    table = f'<div style="max-height:16em;overflow:auto"><table>{"".join(rows)}</table>{more}</div>'
    return f'<div style="{_STYLE}" class="scenecc-draws">{escape(title)}{table}</div>'


def facts(item: Item) -> str:
    """Returns the properties of an item and of all its parts."""
    return f'<div style="{_STYLE}" class="scenecc-facts">{"".join(_item(item))}</div>'


def _item(item: Item, group: str = "") -> Iterator[str]:
    name, kind = escape(item.name or group), escape(item.type)
    yield f'<div><b>{name}</b> <span style="opacity:0.6">{kind}</span></div>'
    facts = [f"{_label(fact.label)}{escape(fact.words)}" for fact in item.facts if fact.words]
    if facts:
        yield f"<div>{'<br>'.join(facts)}</div>"
    for word, things in item.groups:
        listed = things if isinstance(things, tuple) else (things,)
        for one in listed:
            inner = "".join(_item(one, word))
            yield f'<div style="margin-left:0.7rem;border-left:1px solid #8884;padding-left:0.5rem">{inner}</div>'


def _label(text: str) -> str:
    return f'<span style="opacity:0.6">{escape(text)}</span> ' if text else ""
