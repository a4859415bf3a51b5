"""COLLADA files without the elements that a mesh does not need."""

from __future__ import annotations

import xml.etree.ElementTree as ET

LAMPS = frozenset({"library_cameras", "library_lights", "instance_camera", "instance_light"})
"""Lamps and cameras: pycollada refuses those that name an element which does not exist."""

LOOKS = frozenset({"library_images", "library_materials", "library_effects", "bind_material"})
"""Materials."""


def without_elements(data: bytes, tags: frozenset[str]) -> bytes:
    """Removes all elements with these names."""
    root = ET.fromstring(data)  # noqa: S314 - the scan for names has refused document types
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag.rpartition("}")[2] in tags:
                parent.remove(child)
    return ET.tostring(root, encoding="utf-8")
