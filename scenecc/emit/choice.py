"""What somebody asks of a file for another program."""

from __future__ import annotations

from typing import Literal

from scenecc.diagnostics.frozen import frozen

Show = Literal["visual", "collision"]


@frozen
class Choice:
    """How the measured scenes are to be written.

    Attributes:
        name: of the file without its suffix. Files that lie beside it are in a folder `NAME.assets`.
        show: what bodies look like: as they are seen, or their colliding shapes.
        grid: whether all scenes that were measured are written side by side; otherwise there is one.
        entity: the one to write; None: all.
        folder: whether entities are to be written one by one, each into a file of its own name.
        binary: whether the file is to be in the binary form of its kind.
    """

    name: str
    show: Show = "visual"
    grid: bool = False
    entity: str | None = None
    folder: bool = False
    binary: bool = False
