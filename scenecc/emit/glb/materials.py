"""Looks as materials of glTF: trimesh writes their images, and every number is set to the last bit afterwards."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from scenecc.meshes.textures import as_png, in_space

if TYPE_CHECKING:
    from collections.abc import Set as AbstractSet
    from io import BytesIO

    from scenecc.meshes import Image, Look
    from scenecc.meshes.surface import Suffix

_FILTERS: Final = {"nearest": 9728, "linear": 9729}
_WRAPS: Final = {"repeat": 10497, "edge": 33071, "mirror": 33648, "border": 33071}
_SLOTS: Final = {
    "baseColorTexture": "base_color_image",
    "normalTexture": "normal_image",
    "metallicRoughnessTexture": "roughness_image",
    "emissiveTexture": "emission_image",
}
_SAPIEN_SPECULAR: Final = 2.0
"""glTF's reflectance of 0.04 is SAPIEN's at `specular` 0.5."""


class _Encoded:
    """An image that is in the right format already, as trimesh asks for one."""

    def __init__(self, data: bytes, suffix: Suffix) -> None:
        self.format = "JPEG" if suffix == ".jpg" else "PNG"
        self._data = data

    def save(self, file: BytesIO, **options: str) -> None:
        """Writes the image; of `options` the format is known."""
        del options
        file.write(self._data)


def _encoded(image: Image) -> _Encoded:
    return _Encoded(image.data, image.suffix)


class Materials:
    """The materials of a file, in the order in which they are first asked for."""

    def __init__(self) -> None:
        self._names: dict[Look, str] = {}

    @property
    def looks(self) -> AbstractSet[Look]:
        """All looks that were asked for."""
        return self._names.keys()

    def material(self, look: Look) -> Any:
        """Trimesh's material of a look."""
        name = self._names.setdefault(look, f"material {len(self._names)}")
        images = {
            "baseColorTexture": (look.base_color_image, True),
            "normalTexture": (look.normal_image, False),
            "emissiveTexture": (look.emission_image, True),
        }
        given: dict[str, Any] = {
            slot: _encoded(in_space(image, srgb=srgb)) for slot, (image, srgb) in images.items() if image is not None
        }
        packed = _packed(look)
        if packed is not None:
            given["metallicRoughnessTexture"] = packed
        return import_module("trimesh.visual.material").PBRMaterial(name=name, **given)

    def finish(self, tree: dict[str, Any]) -> None:
        """Sets the numbers of all materials in the header of a file, and how their images are sampled."""
        found = {material["name"]: material for material in tree.get("materials", [])}
        samplers: list[dict[str, int]] = []
        used: set[str] = set()
        for look, name in self._names.items():
            material = found[name]
            material.pop("baseColorFactor", None)
            material["pbrMetallicRoughness"] = {**material.get("pbrMetallicRoughness", {}), **_numbers(look)}
            material.update(_glow(look))
            if _see_through(look):
                material["alphaMode"] = "BLEND"
            extensions = _extensions(look)
            material["extensions"] = extensions
            used.update(extensions)
            _sample(look, material, tree, samplers)
        if samplers:
            tree["samplers"] = samplers
        tree["extensionsUsed"] = sorted({*tree.get("extensionsUsed", []), *used})


def _numbers(look: Look) -> dict[str, Any]:
    """An image stands in place of a number in SAPIEN; glTF multiplies them."""
    packed = look.roughness_image is not None or look.metallic_image is not None
    return {
        "baseColorFactor": list(look.tint),
        "roughnessFactor": 1.0 if packed else look.roughness,
        "metallicFactor": 1.0 if packed else look.metallic,
    }


def _glow(look: Look) -> dict[str, Any]:
    """GlTF's factor ends at 1; what is brighter is in the strength of an extension."""
    strength = max(1.0, *look.emission)
    return {"emissiveFactor": [value / strength for value in look.emission]}


def _extensions(look: Look) -> dict[str, Any]:
    bright = _SAPIEN_SPECULAR * look.specular
    specular: dict[str, Any] = {"specularFactor": min(bright, 1.0)}
    if bright > 1:
        specular["specularColorFactor"] = [bright] * 3
    found: dict[str, Any] = {"KHR_materials_specular": specular}
    strength = max(look.emission)
    if strength > 1:
        found["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
    if look.transmission > 0:
        found["KHR_materials_transmission"] = {"transmissionFactor": min(look.transmission, 1.0)}
        found["KHR_materials_ior"] = {"ior": look.ior}
    return found


def _see_through(look: Look) -> bool:
    image = look.base_color_image
    return look.tint[3] < 1 or (image is not None and image.pixels.mode in {"RGBA", "LA", "PA"})


def _sample(look: Look, material: dict[str, Any], tree: dict[str, Any], samplers: list[dict[str, int]]) -> None:
    for slot, field in _SLOTS.items():
        holder = material if slot in material else material["pbrMetallicRoughness"]
        image: Image | None = getattr(look, field)
        if field == "roughness_image":
            image = image or look.metallic_image
        if image is None or slot not in holder:
            continue
        wrap = _WRAPS[image.address_mode]
        sampler = {"magFilter": _FILTERS[image.filter_mode], "wrapS": wrap, "wrapT": wrap}
        if image.filter_mode == "nearest":
            sampler["minFilter"] = _FILTERS["nearest"]
        if sampler not in samplers:
            samplers.append(sampler)
        tree["textures"][holder[slot]["index"]]["sampler"] = samplers.index(sampler)


def _packed(look: Look) -> Any:
    """Roughness in green and metallic in blue, as glTF has both in one image; None where neither has an image."""
    images = look.roughness_image, look.metallic_image
    rough, metal = (None if image is None else in_space(image, srgb=False) for image in images)
    if rough is None and metal is None:
        return None
    if (
        rough is not None
        and metal is not None
        and rough.digest == metal.digest
        and rough.channel + metal.channel == "gb"
    ):
        return _encoded(rough)
    pillow: Any = import_module("PIL.Image")

    sizes = [image.pixels.size for image in (rough, metal) if image is not None]
    size = (max(width for width, _ in sizes), max(height for _, height in sizes))
    green, blue = (
        _plain(number, size) if image is None else _channel(image).resize(size)
        for image, number in ((rough, look.roughness), (metal, look.metallic))
    )
    return _Encoded(as_png(pillow.merge("RGB", (_plain(1.0, size), green, blue))), ".png")


def _plain(number: float, size: tuple[int, int]) -> Any:
    return import_module("PIL.Image").new("L", size, round(min(max(number, 0.0), 1.0) * 255))


def _channel(image: Image) -> Any:
    return image.pixels.convert("RGB").getchannel("RGB"["rgb".index(image.channel)])
