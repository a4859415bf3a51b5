"""What a caller may choose about how diagnostics are rendered."""

from __future__ import annotations

from pathlib import PurePath

from scenecc.diagnostics.frozen import frozen


@frozen
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
