"""Texts of a page as HTML. A scene may come from a stranger: all that it says is escaped."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.summary import Item

_STYLE = "font-size:0.75rem;line-height:1.45;padding:0.2rem 0.6rem;overflow-wrap:anywhere;"
_CODE = "font-family:ui-monospace,monospace;white-space:pre;overflow:auto;max-height:60vh;user-select:text;"


def message(text: str, *, color: str) -> str:
    """What was said of a scene, line by line as on a terminal. `color`: of the bar beside it."""
    bar = f"border-left:3px solid {color};"
    return f'<div style="{_STYLE}{_CODE}{bar}" class="scenecc-message">{escape(text.rstrip())}</div>'


def line(text: str) -> str:
    """A short text."""
    return f'<div style="{_STYLE}" class="scenecc-line">{escape(text)}</div>'


def facts(item: Item) -> str:
    """What is said of a thing and of all that it is made of."""
    return f'<div style="{_STYLE}" class="scenecc-facts">{"".join(_item(item))}</div>'


def _item(item: Item, group: str = "") -> Iterator[str]:
    name, kind = escape(item.name or group), escape(item.type)
    yield f'<div><b>{name}</b> <span style="opacity:0.6">{kind}</span></div>'
    told = [f"{_label(fact.label)}{escape(fact.words)}" for fact in item.facts if fact.words]
    if told:
        yield f"<div>{'<br>'.join(told)}</div>"
    for word, things in item.groups:
        listed = things if isinstance(things, tuple) else (things,)
        for one in listed:
            inner = "".join(_item(one, word))
            yield f'<div style="margin-left:0.7rem;border-left:1px solid #8884;padding-left:0.5rem">{inner}</div>'


def _label(text: str) -> str:
    return f'<span style="opacity:0.6">{escape(text)}</span> ' if text else ""
