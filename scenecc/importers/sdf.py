"""SDF worlds and models as scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.importers.imported_scene import ImportedScene, Loss
from scenecc.importers.sdf_xml import read_file

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.importers.imported_scene import ImportContext


def read_sdf(path: Path, context: ImportContext) -> ImportedScene | None:
    """The scene of an SDF file; None after an error."""
    losses: list[Loss] = []
    found = read_file(path, context, losses)
    if found is None:
        return None
    file, root = found
    entities: dict[str, Any] = {}
    bodies: dict[str, str] = {}
    for world in root.all("world"):
        for model in world.all("model"):
            name = model.attributes.get("name", "model")
            pose = file.pose(model)
            for link in model.all("link"):
                shapes: list[Any] = []
                for visual in link.all("visual"):
                    geometry = visual.find("geometry")
                    box = None if geometry is None else geometry.find("box")
                    if box is not None:
                        size = file.vector(box, "size", default=(1, 1, 1))
                        shapes.append({"type": "box", "half_size": [each / 2 for each in size]})
                entities[name] = {"pose": {"p": [*pose[:3]], "q": [*pose[3:]]}, "shapes": shapes}
                bodies[name] = f"{name}::{link.attributes.get('name', '')}"
    return ImportedScene({"scenecc": 1, "name": path.stem, "entities": entities}, tuple(losses), bodies)
