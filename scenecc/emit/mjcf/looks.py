"""Materials and textures of what is seen."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from scenecc.emit.mjcf.model import Model
    from scenecc.meshes import Image, Look, Shape

_IMAGES: Final = ("normal_image", "roughness_image", "metallic_image", "emission_image", "transmission_image")


def write_look(model: Model, look: Look, shape: Shape, name: str) -> str:
    """The material of a look, its name; looks that are the same share one. `name`: of what has it first."""
    if look not in model.looks:
        _tell(model, look, shape, name)
        emission = _emission(model, look, shape, name)
        image = look.base_color_image
        model.looks[look] = model.name("material", f"{name}_material")
        model.sections["asset"].add(
            "material",
            name=model.looks[look],
            texture=None if image is None else _texture(model, image),
            rgba=look.tint,
            emission=emission or None,
            specular=look.specular,
            shininess=1 - look.roughness,
            metallic=look.metallic,
            roughness=look.roughness,
        )
    return model.looks[look]


def _emission(model: Model, look: Look, shape: Shape, name: str) -> float:
    """What multiplies the colour of a material that shines: MuJoCo has one number."""
    strongest, brightest = max(look.emission), max(look.tint[:3])
    if strongest == 0:
        return 0.0
    if brightest == 0:
        model.lost.leave_out(name, "`emission` of a black material", shape.origin)
        return 0.0
    strength = strongest / brightest
    if any(abs(strength * own - shines) > 1e-6 for own, shines in zip(look.tint, look.emission, strict=False)):
        model.lost.change(name, "`emission` has the colour of the material, as in MuJoCo", shape.origin)
    return strength


def _tell(model: Model, look: Look, shape: Shape, name: str) -> None:
    for field in _IMAGES:
        if getattr(look, field) is not None:
            model.lost.leave_out(name, f"`{field.replace('_image', '_texture')}`", shape.origin)
    if look.transmission:
        model.lost.leave_out(name, "`transmission`", shape.origin)


def _texture(model: Model, image: Image) -> str:
    """The texture of an image, its name: a PNG, which is what MuJoCo reads."""
    if image.digest not in model.textures:
        data = image.data
        if image.suffix != ".png":
            buffer = BytesIO()
            image.pixels.save(buffer, "png")
            data = buffer.getvalue()
        file = model.beside.add(image.name or "texture", ".png", data)
        name = model.textures[image.digest] = model.name("texture", file.removesuffix(".png"))
        model.sections["asset"].add("texture", name=name, type="2d", file=file)
    return model.textures[image.digest]
