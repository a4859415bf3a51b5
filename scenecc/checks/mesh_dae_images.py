"""The images of a COLLADA, which SAPIEN opens for the textures of its effects."""

from __future__ import annotations

import re
from urllib.parse import unquote

from scenecc.checks.mesh_data import AssetError, Reference
from scenecc.checks.mesh_xml import Node, by_id

_NO_NAME = re.compile(r"[\x00-\x1f\x7f]|%(?![0-9A-Fa-f]{2}.)|^\s|\s$")
"""What SAPIEN's reader keeps or decodes otherwise: controls, blanks at the ends, an escape with nothing behind it."""


def dae_images(root: Node) -> tuple[Reference, ...]:
    """The files of all images, percent escapes decoded as SAPIEN's reader decodes those of a COLLADA.

    Raises:
        AssetError: an image is in the COLLADA itself.
        ValueError: a texture leads to no image: SAPIEN would open a file of the texture's own name.
    """
    newer = root.get("version").startswith("1.5")
    images = by_id(root, "library_images", "image")
    for effect in root.all("library_effects", "effect"):
        leads = {node.get("sid"): _lead(node, newer=newer) for node in effect.all("profile_COMMON", "newparam")}
        for texture in (node for node in effect.walk() if node.tag == "texture"):
            target, steps = texture.get("texture"), 0
            while target in leads and steps <= len(leads):
                target, steps = leads[target], steps + 1
            if target not in images or steps > len(leads):
                raise ValueError(f"the texture `{texture.get('texture')[:60]}` leads to no image")
    listed = list(root.all("library_images", "image"))
    if sum(node.tag == "image" for node in root.walk()) != len(listed):
        raise ValueError("an image stands elsewhere than in the library of images")
    names = (_file(image, newer=newer) for image in listed)
    return tuple(Reference(name, "image") for name in dict.fromkeys(names))


def _lead(parameter: Node, *, newer: bool) -> str:
    """What a parameter of an effect stands for: another one, or an image."""
    if newer:
        return next((one.get("url").removeprefix("#") for one in parameter.all("sampler2D", "instance_image")), "")
    leads = (*parameter.all("surface", "init_from"), *parameter.all("sampler2D", "source"))
    return leads[0].text if leads else ""


def _file(image: Node, *, newer: bool) -> str:
    named = [node for node in image.walk() if node.tag == ("ref" if newer else "init_from")]
    found = next(image.all("init_from", "ref") if newer else image.all("init_from"), None)
    if len(named) > 1:
        raise ValueError(f"the image `{image.get('id')[:60]}` names several files")
    if found is None or not found.text:
        raise AssetError(
            "SC410", "an image of the COLLADA stands in no file of its own", "save it as PNG, and name that"
        )
    written = "".join(found.characters)
    name = unquote(written)
    if _NO_NAME.search(written) or _NO_NAME.search(name.replace("%", "")):
        raise ValueError(f"`{found.text[:60]!a}` is no name of a file")
    return name
