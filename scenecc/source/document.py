"""A document: its data, and where each part of it is written."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import At, Location, Origin
from scenecc.source.positions import Positions

if TYPE_CHECKING:
    from scenecc.source.lines import Lines


class Document:
    """What was read.

    Attributes:
        name: as shown to people: the path as the user gave it, `<stdin>`, None for a dict.
        path: absolute path of the file; None for a stream or a dict.
        data: plain dicts with string keys, lists, strings, integers, floats and booleans. Parts that an
            alias names are the same object wherever they are reached, so nothing may change them.
    """

    def __init__(self, name: str | None, path: FilePath | None, data: dict[str, Any], lines: Lines | None) -> None:
        self.name = name
        self.path = path
        self.data = data
        self._lines = lines

    @property
    def text(self) -> str | None:
        """What was read; None for a dict."""
        return None if self._lines is None else self._lines.text

    def locate(self, origin: Origin, at: At) -> Location:
        """Where an origin in this document is written: a `scenecc.diagnostics.Locator`.

        Aliases and merge keys are followed to the text inside their anchors; of a path that does not
        exist the deepest part that does is shown. The index is made at the first question.
        """
        if self._positions is None:
            return Location(self.name)
        return self._positions.find(origin.path, at)

    @cached_property
    def _positions(self) -> Positions | None:
        return None if self._lines is None else Positions(self._lines)
