"""URDFs as scenes: the file stays, and an entity names it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.importers.imported_scene import Asset, ImportedScene

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.importers.imported_scene import ImportContext


def read_urdf(path: Path, context: ImportContext) -> ImportedScene | None:
    """A scene with one robot, by its file."""
    del context
    robot = {"urdf": Asset(path.name, path.absolute())}
    return ImportedScene({"scenecc": 1, "name": path.stem, "entities": {"robot": robot}})
