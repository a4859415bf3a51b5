"""Diagnostics as text: one small file a format, loaded when the format is first asked for.

Every renderer is total: it takes any diagnostics, and what it returns can be encoded as UTF-8.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import PurePath
from typing import TYPE_CHECKING

from scenecc.diagnostics.formats.style import Style, wants_color

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Diagnostic

Renderer = Callable[[Sequence["Diagnostic"], Style], str]
"""Diagnostics as one text that ends with a line break, or "" where there is nothing to say."""

FORMATS: dict[str, str] = {
    "text": "scenecc.diagnostics.formats.text",
    "json": "scenecc.diagnostics.formats.json_text",
    "github": "scenecc.diagnostics.formats.github",
    "gitlab": "scenecc.diagnostics.formats.gitlab",
    "junit": "scenecc.diagnostics.formats.junit",
    "sarif": "scenecc.diagnostics.formats.sarif",
}
"""Every format, by the name that `--format` takes: the module whose `render` is its `Renderer`."""


def renderer(format_name: str) -> Renderer:
    """The renderer of a key of `FORMATS`; any other name raises `KeyError`."""
    found: Renderer = import_module(FORMATS[format_name]).render
    return found


def render(
    diagnostics: Sequence[Diagnostic],
    format_name: str = "text",
    *,
    color: bool = False,
    root: PurePath | None = None,
    files: Sequence[str] = (),
    corrections: Sequence[Diagnostic] | None = None,
) -> str:
    """Diagnostics as one text that ends with a line break, or "" where there is nothing to say.

    Args:
        diagnostics: what to show, in this order.
        format_name: a key of `FORMATS`; another raises `KeyError`.
        color: whether `text` uses terminal colours (see `wants_color`).
        root: what file names in the formats of services are relative to; None: the working directory.
        files: that were checked, for `junit`.
        corrections: the findings that were corrected in files, for `json`; None: nothing was to be corrected.
    """
    made = None if corrections is None else tuple(corrections)
    return renderer(format_name)(diagnostics, Style(color=color, root=root, files=tuple(files), corrections=made))


__all__ = ["FORMATS", "Renderer", "Style", "render", "renderer", "wants_color"]
