"""MDL materials of a USD stage: the inputs of Omniverse's `OmniPBR` as fields of a visual material."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.robots.description import DescribedTexture

_NITS: Final = 1000.0
"""Nits of an emission of 1, as of USD's lights."""

_COLORS: Final = {
    "diffuse_color_constant": (0.2, 0.2, 0.2),
    "diffuse_tint": (1.0, 1.0, 1.0),
    "emissive_color": (1.0, 0.1, 0.1),
}
_NUMBERS: Final = {
    "reflection_roughness_constant": 0.5,
    "metallic_constant": 0.0,
    "specular_level": 0.5,
    "opacity_constant": 1.0,
    "emissive_intensity": 40.0,
    "reflection_roughness_texture_influence": 0.0,
    "metallic_texture_influence": 0.0,
    "bump_factor": 1.0,
}
_TEXTURES: Final = ("diffuse_texture", "normalmap_texture", "reflectionroughness_texture", "metallic_texture")
"""Inputs of `OmniPBR` that are read, with their defaults. Switches (`enable_…`) are off by default."""

_NEUTRAL: Final[dict[str, tuple[float, ...]]] = {
    "albedo_add": (0,),
    "albedo_brightness": (1,),
    "albedo_desaturation": (0,),
    "ao_to_diffuse": (0,),
    "texture_scale": (1, 1),
    "texture_translate": (0, 0),
    "texture_rotate": (0,),
    "project_uvw": (0,),
    "uv_space_index": (0,),
    "opacity_threshold": (0,),
    "enable_clearcoat": (0,),
    "clearcoat_weight": (0,),
}
"""Values of other inputs at which they have no effect."""

_IDLE: Final = {
    "world_or_object": "project_uvw",
    "ao_texture": "ao_to_diffuse",
    "detail_bump_factor": "detail_normalmap_texture",
    "detail_texture_scale": "detail_normalmap_texture",
    "detail_texture_translate": "detail_normalmap_texture",
    "detail_texture_rotate": "detail_normalmap_texture",
}
"""Inputs without effect unless another one, which is reported, has one."""


class MdlMaterial:
    """The inputs of one MDL shader.

    Args:
        shader: a `UsdShade.Shader`.
        value: returns the authored value of an input; None if it is not authored, or connected to something else.
        file: returns the file that an attribute names; None if it is missing, which is then reported.
    """

    def __init__(
        self, shader: Any, value: Callable[[Any, str], Any], file: Callable[[Any, Any], DescribedTexture | None]
    ) -> None:
        self._shader = shader
        self._file = file
        found = {str(each.GetBaseName()): each for each in shader.GetInputs()}
        self._values = {name: value(shader, name) for name in found}
        self._unread = dict.fromkeys(name for name, each in found.items() if each.GetAttr().HasAuthoredValue())
        self._unread |= dict.fromkeys(name for name, each in found.items() if each.HasConnectedSource())

    @property
    def name(self) -> str:
        """Name of the MDL material: `OmniPBR`."""
        named = self._shader.GetSourceAssetSubIdentifier("mdl")
        asset = self._shader.GetSourceAsset("mdl")
        return str(named or (PurePosixPath(asset.path).stem if asset else "") or self._shader.GetIdAttr().Get() or "")

    @property
    def unread(self) -> list[str]:
        """Names of the authored inputs that `look` does not express, in the order of the shader."""
        return [*self._unread]

    def look(self) -> dict[str, Any]:
        """Returns the fields of a material. Inputs that are left out have the defaults of `OmniPBR`, if it is one."""
        is_omni = self.name.startswith("OmniPBR")
        if not (is_omni or {*_COLORS, *_NUMBERS, *_TEXTURES} & self._unread.keys()):
            return {}
        look = self._base_color(is_omni=is_omni)
        for key, name, texture in (
            ("roughness", "reflection_roughness", "reflectionroughness_texture"),
            ("metallic", "metallic", "metallic_texture"),
        ):
            value = self._number(f"{name}_constant")
            if is_omni or f"{name}_constant" in self._values:
                look[key] = value
            influence = self._number(f"{name}_texture_influence")
            if influence == 0:
                self._unread.pop(texture, None)
            elif influence == 1 and (file := self._texture(texture)) is not None:
                look[f"{key}_texture"] = file
                look.pop(key, None)
        specular = self._number("specular_level")
        if specular != _NUMBERS["specular_level"]:
            look["specular"] = min(max(specular, 0.0), 1.0)
        if (file := self._texture("normalmap_texture")) is not None:
            look["normal_texture"] = file
        look |= self._emission()
        self._forget_idle()
        return look

    def _base_color(self, *, is_omni: bool) -> dict[str, Any]:
        file, has_color = self._texture("diffuse_texture"), "diffuse_color_constant" in self._values
        color, tint = self._color("diffuse_color_constant"), self._color("diffuse_tint")
        opacity = self._number("opacity_constant") if self._switch("enable_opacity") else 1.0
        if file is not None:
            if tint != [1.0, 1.0, 1.0]:
                self._unread["diffuse_tint"] = None
            if opacity < 1:
                self._unread["opacity_constant"] = None
            return {"base_color_texture": file}
        if not (is_omni or has_color or "diffuse_tint" in self._values or opacity < 1):
            return {}
        tinted = [min(max(a * b, 0.0), 1.0) for a, b in zip(color, tint, strict=True)]
        return {"base_color": [*tinted, max(opacity, 0.0)] if opacity < 1 else tinted}

    def _emission(self) -> dict[str, Any]:
        is_on = self._switch("enable_emission")
        strength = self._number("emissive_intensity") / _NITS
        emitted = [max(each * strength, 0.0) for each in self._color("emissive_color")]
        return {"emission": emitted} if is_on and any(emitted) else {}

    def _forget_idle(self) -> None:
        """Drops the inputs without effect from those that are not read."""
        for name in list(self._unread):
            value, neutral = self._values.get(name), _NEUTRAL.get(name)
            off = (
                (name.startswith("opacity") and not self._values.get("enable_opacity"))
                or (name.startswith("emissive") and not self._values.get("enable_emission"))
                or (name == "ORM_texture" and not self._values.get("enable_ORM_texture"))
                or getattr(value, "path", None) == ""
                or (neutral is not None and value is not None and _numbers(value) == list(neutral))
            )
            if off:
                del self._unread[name]
        for name, other in _IDLE.items():
            if other not in self._unread:
                self._unread.pop(name, None)
        if self._values.get("enable_ORM_texture") and "ORM_texture" not in self._unread:
            self._unread.pop("enable_ORM_texture", None)

    def _number(self, name: str) -> float:
        found = _numbers(self._values.get(name))
        if len(found) != 1:
            return _NUMBERS[name]
        self._unread.pop(name, None)
        return found[0]

    def _color(self, name: str) -> list[float]:
        found = _numbers(self._values.get(name))
        if len(found) != len(_COLORS[name]):
            return [*_COLORS[name]]
        self._unread.pop(name, None)
        return found

    def _switch(self, name: str) -> bool:
        found = _numbers(self._values.get(name))
        if len(found) == 1:
            self._unread.pop(name, None)
        return found == [1.0]

    def _texture(self, name: str) -> DescribedTexture | None:
        value = self._values.get(name)
        path = getattr(value, "path", "")
        if not path:
            return None
        self._unread.pop(name, None)
        return self._file(self._shader.GetInput(name).GetAttr(), value)


def _numbers(value: Any) -> list[float]:
    """Returns a number, boolean or vector as numbers; empty for anything else."""
    if isinstance(value, bool | int | float):
        return [float(value)]
    try:
        return [float(each) for each in value]
    except (TypeError, ValueError):
        return []
