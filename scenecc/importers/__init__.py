"""Imports worlds and robots of other formats as scene files: one reader per format, a writer, and a comparison.

A reader returns a scene document as plain data, and lists content that the document cannot represent.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from scenecc.importers.imported_scene import ImportContext, ImportedScene

    Reader = Callable[[Path, ImportContext], ImportedScene | None]
    """Reads an existing file. After an error, which the sink of the context has, it returns None or only the losses."""


@frozen
class SourceFormat:
    """A format that can be imported.

    Attributes:
        name: name in messages.
        suffixes: in lower case. `.xml` belongs to several formats: the root element decides.
        root: root element of an XML format; "" for other formats.
        reader: "MODULE:FUNCTION", a `Reader`, loaded on first use.
        module: extra package that the reader needs; "" if it needs none or checks for it itself.
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
    SourceFormat("Drake directives", (".dmd.yaml", ".dmd.yml"), "", "scenecc.importers.dmd:import_dmd", "lxml"),
    SourceFormat("EmbodiedGen layout", (".json",), "", "scenecc.importers.layout:import_layout"),
)
"""All formats. If a suffix has several, the root element decides."""


def suffix_of(path: Path) -> str:
    """Returns the suffix of a file, in lower case: the longest one of a format, such as `.dmd.yaml`, else its last."""
    name = path.name.lower()
    known = (suffix for one in FORMATS for suffix in one.suffixes if name.endswith(suffix) and name != suffix)
    return max(known, key=len, default=path.suffix.lower())
