"""Colours of vertices and faces, which SAPIEN does not render."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_PRIMITIVES = frozenset(("triangles", "polylist", "polygons", "trifans", "tristrips"))


def shows_colors(data: bytes, suffix: str, colors: list[NDArray[np.uint8]]) -> bool:
    """Returns whether a mesh has a part with colours at its vertices or faces, and without a material of its own.

    Args:
        data: content of the file, which was read without an error.
        suffix: of the file, in lower case.
        colors: the colours (n, 4) in it, except of a COLLADA. White does not count, since exporters often add it.
    """
    if suffix == ".dae":
        return _has_colored_primitive(data)
    if all((part[:, :3] == np.iinfo(np.uint8).max).all() for part in colors):
        return False
    if suffix == ".obj":
        return b"usemtl" not in data or b"mtllib" not in data
    return suffix not in {".glb", ".gltf"} or any(map(_is_bare, _primitives_with_colors(data)))


def _has_colored_primitive(data: bytes) -> bool:
    root = ET.fromstring(data)  # noqa: S314 - the scan for names has refused document types
    parts = [
        part for part in root.iter() if part.tag.rpartition("}")[2] in _PRIMITIVES and "material" not in part.attrib
    ]
    return any(child.get("semantic") == "COLOR" for part in parts for child in part)


def _primitives_with_colors(data: bytes) -> list[dict[str, Any]]:
    """Returns the materials of the primitives of a glTF that have colours at their vertices."""
    if data.startswith(b"glTF"):
        data = data[20 : 20 + int.from_bytes(data[12:16], "little")]
    document = json.loads(data)
    primitives = [one for mesh in document.get("meshes", ()) for one in mesh.get("primitives", ())]
    used = [one.get("material") for one in primitives if "COLOR_0" in one.get("attributes", ())]
    return [{} if index is None else document["materials"][index] for index in used]


def _is_bare(material: dict[str, Any]) -> bool:
    """Returns whether a material of a glTF leaves the colour to the vertices: it is white and has no texture."""
    base = material.get("pbrMetallicRoughness", {})
    return "baseColorTexture" not in base and list(base.get("baseColorFactor", (1, 1, 1, 1)))[:3] == [1, 1, 1]
