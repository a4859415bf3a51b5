"""Formats of diagnostics: one file per format, loaded at its first use.

A renderer never fails: it accepts any diagnostics, and its result can be encoded as UTF-8.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from importlib import import_module
from pathlib import PurePath
from typing import TYPE_CHECKING

from scenecc.diagnostics.formats.style import Style, wants_color

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Diagnostic

Renderer = Callable[[Sequence["Diagnostic"], Style], str]
"""Returns diagnostics as one text that ends with a line break; "" if there are none."""

FORMATS: dict[str, str] = {
    "text": "scenecc.diagnostics.formats.text",
    "json": "scenecc.diagnostics.formats.json_text",
    "github": "scenecc.diagnostics.formats.github",
    "gitlab": "scenecc.diagnostics.formats.gitlab",
    "junit": "scenecc.diagnostics.formats.junit",
    "sarif": "scenecc.diagnostics.formats.sarif",
}
"""Name of a format in `--format` → the module whose `render` is its `Renderer`."""


def renderer(format_name: str) -> Renderer:
    """Returns the renderer of a key of `FORMATS`; any other name raises `KeyError`."""
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
    simulated: Mapping[str, Mapping[str, object] | None] | None = None,
    strict: Collection[str] = (),
) -> str:
    """Returns diagnostics as one text that ends with a line break; "" if there are none.

    Args:
        diagnostics: what to show, in this order.
        format_name: a key of `FORMATS`; another raises `KeyError`.
        color: whether `text` uses terminal colours (see `wants_color`).
        root: folder to which file names in the formats of services are relative; None: the working directory.
        files: checked files, for `junit`.
        corrections: corrected findings, for `json`; None: no correction was requested.
        simulated: what was simulated of each file, for `json`; None: the command does not simulate.
        strict: checked files whose warnings count as errors, for `junit`.
    """
    made = None if corrections is None else tuple(corrections)
    style = Style(color, root, files=tuple(files), corrections=made, simulated=simulated, strict=frozenset(strict))
    return renderer(format_name)(diagnostics, style)


__all__ = ["FORMATS", "Renderer", "Style", "render", "renderer", "wants_color"]
