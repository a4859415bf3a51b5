"""Worlds and robots of other formats as scene files: one reader a format, and what writes and compares the result.

A reader gives the document of a scene file as plain data and lists what the document cannot hold.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from scenecc.importers.imported_scene import ImportContext, ImportedScene

    Reader = Callable[[Path, ImportContext], ImportedScene | None]
    """Reads a file that exists. Returns None after an error, which is reported in the context's sink."""


@frozen
class SourceFormat:
    """One format that can be imported.

    Attributes:
        name: as messages have it.
        suffixes: of its files, in lower case. `.xml` belongs to several formats: the root element decides.
        root: the root element of an XML file; "" where it is no XML.
        reader: "MODULE:FUNCTION", a `Reader`. It is loaded when a file of the format is read.
        module: the package beyond the core that the reader needs; "" where it needs none, or says so itself.
    """

    name: str
    suffixes: tuple[str, ...]
    root: str
    reader: str
    module: str = ""


FORMATS: Final = (
    SourceFormat("SDF", (".sdf", ".world", ".xml"), "sdf", "scenecc.importers.sdf:import_sdf", "lxml"),
    SourceFormat("USD", (".usd", ".usda", ".usdc"), "", "scenecc.importers.usd:import_usd", "pxr"),
    SourceFormat("MJCF", (".mjcf", ".xml"), "mujoco", "scenecc.importers.mjcf:import_mjcf"),
    SourceFormat("URDF", (".urdf", ".xml"), "robot", "scenecc.importers.urdf:import_urdf"),
)
"""Every format; of those that take a suffix, the root element decides."""
