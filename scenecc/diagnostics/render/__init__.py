"""Diagnostics as text: one small file a format, each loaded when it is first asked for.

All are total: they take any diagnostics, and what they return can be encoded as UTF-8.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import TYPE_CHECKING

from scenecc.diagnostics.render.terminal import wants_color

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Diagnostic


@dataclass(frozen=True, slots=True)
class Style:
    """How diagnostics are rendered.

    Attributes:
        color: whether the text format uses terminal colours; the others never do.
        root: directory that the file names of `github` and `sarif` are relative to; None: the
            working directory.
        width: terminal cells of a source line before the text format cuts it around the caret.
    """

    color: bool = False
    root: PurePath | None = None
    width: int = 110


Renderer = Callable[[Sequence["Diagnostic"], Style], str]


def _text(diagnostics: Sequence[Diagnostic], style: Style) -> str:
    from scenecc.diagnostics.render.text import render_text

    return render_text(diagnostics, color=style.color, width=style.width)


def _json(diagnostics: Sequence[Diagnostic], style: Style) -> str:
    from scenecc.diagnostics.render.json_text import render_json

    del style
    return render_json(diagnostics)


def _github(diagnostics: Sequence[Diagnostic], style: Style) -> str:
    from scenecc.diagnostics.render.github import render_github

    return render_github(diagnostics, root=style.root)


def _sarif(diagnostics: Sequence[Diagnostic], style: Style) -> str:
    from scenecc.diagnostics.render.sarif import render_sarif

    return render_sarif(diagnostics, root=style.root)


FORMATS: dict[str, Renderer] = {"text": _text, "json": _json, "github": _github, "sarif": _sarif}
"""Every format, by the name that `--format` takes."""


def render(
    diagnostics: Sequence[Diagnostic],
    format: str = "text",  # noqa: A002 - the option's own name
    *,
    color: bool = False,
    root: PurePath | None = None,
) -> str:
    """Diagnostics as one text that ends with a line break, or "" where there is nothing to say.

    Args:
        diagnostics: what to show, in this order.
        format: a key of `FORMATS`; another raises `KeyError`.
        color: whether `text` uses terminal colours (see `wants_color`).
        root: what file names in `github` and `sarif` are relative to; None: the working directory.
    """
    return FORMATS[format](diagnostics, Style(color=color, root=root))


__all__ = ["FORMATS", "Renderer", "Style", "render", "wants_color"]
