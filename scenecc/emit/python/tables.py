"""What all parts of a script share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.emit.python.files import Files
    from scenecc.emit.python.held import Held
    from scenecc.emit.python.materials import Materials
    from scenecc.emit.python.names import Names


@dataclass(frozen=True, slots=True)
class Tables:
    """Names, files and materials of a script, and what is held on to in it."""

    names: Names
    files: Files
    materials: Materials
    held: Held
