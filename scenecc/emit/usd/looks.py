"""Looks as UsdPreviewSurface, and frictions as physics materials."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.emit.usd.stage import Prim, Stage
    from scenecc.meshes import Image, Look
    from scenecc.plan.snapshot import MeasuredShape

_WRAPS: Final = {"repeat": "repeat", "edge": "clamp", "mirror": "mirror", "border": "black"}


class Looks:
    """The materials of a stage, each written once."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._made: dict[Look, Prim] = {}
        self._rubbing: dict[tuple[float, float, float], Prim] = {}
        self._scope: str | None = None

    def bind(self, made: Prim, look: Look, entity: str, place: Origin | None) -> None:
        """Gives something a look. `entity`, `place`: who is told of what USD has not."""
        stage = self._stage
        if look not in self._made:
            self._made[look] = self._material(look)
            self._tell(look, entity, place)
        stage.shade.MaterialBindingAPI.Apply(made.GetPrim()).Bind(self._made[look])

    def rub(self, made: Prim, shape: MeasuredShape) -> None:
        """Gives a collider its friction and restitution."""
        stage = self._stage
        key = (shape.static_friction, shape.dynamic_friction, shape.restitution)
        if key not in self._rubbing:
            material = stage.shade.Material.Define(stage.stage, stage.path(self._folder(), "friction"))
            physics = stage.physics.MaterialAPI.Apply(material.GetPrim())
            physics.CreateStaticFrictionAttr(shape.static_friction)
            physics.CreateDynamicFrictionAttr(shape.dynamic_friction)
            physics.CreateRestitutionAttr(shape.restitution)
            self._rubbing[key] = material
        binding = stage.shade.MaterialBindingAPI.Apply(made.GetPrim())
        binding.Bind(self._rubbing[key], stage.shade.Tokens.fallbackStrength, "physics")

    def _folder(self) -> str:
        if self._scope is None:
            self._scope = self._stage.path(self._stage.root, "Looks")
            self._stage.geom.Scope.Define(self._stage.stage, self._scope)
        return self._scope

    def _material(self, look: Look) -> Prim:
        stage = self._stage
        path = stage.path(self._folder(), "material")
        material = stage.shade.Material.Define(stage.stage, path)
        shader = stage.shade.Shader.Define(stage.stage, f"{path}/surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        types = stage.sdf.ValueTypeNames
        red, green, blue, alpha = look.tint
        # UsdPreviewSurface reflects by `ior`, SAPIEN by `specular`: the same share of what falls on it from the front.
        root = math.sqrt(0.08 * look.specular)
        inputs: dict[str, tuple[Any, Any]] = {
            "diffuseColor": (types.Color3f, stage.gf.Vec3f(red, green, blue)),
            "opacity": (types.Float, alpha),
            "emissiveColor": (types.Color3f, stage.gf.Vec3f(*look.emission)),
            "roughness": (types.Float, look.roughness),
            "metallic": (types.Float, look.metallic),
            "ior": (types.Float, (1 + root) / (1 - root)),
            "useSpecularWorkflow": (types.Int, 0),
        }
        for name, (kind, value) in inputs.items():
            shader.CreateInput(name, kind).Set(value)
        self._images(look, path, shader)
        output = shader.CreateOutput("surface", types.Token)
        material.CreateSurfaceOutput().ConnectToSource(output)
        return material

    def _images(self, look: Look, path: str, shader: Prim) -> None:
        types = self._stage.sdf.ValueTypeNames
        color = look.base_color_image
        if color is not None:
            found = self._texture(path, "base_color", color)
            self._connect(shader, "diffuseColor", types.Color3f, found, "rgb")
            if color.pixels.mode in {"RGBA", "LA", "PA"}:
                if look.visibility < 1:
                    found.CreateInput("scale", types.Float4).Set(self._stage.gf.Vec4f(1, 1, 1, look.visibility))
                self._connect(shader, "opacity", types.Float, found, "a")
        if look.emission_image is not None:
            found = self._texture(path, "emission", look.emission_image)
            found.CreateInput("scale", types.Float4).Set(self._stage.gf.Vec4f(*look.emission, 1))
            self._connect(shader, "emissiveColor", types.Color3f, found, "rgb")
        if look.normal_image is not None:
            found = self._texture(path, "normal", look.normal_image)
            found.CreateInput("scale", types.Float4).Set(self._stage.gf.Vec4f(2, 2, 2, 1))
            found.CreateInput("bias", types.Float4).Set(self._stage.gf.Vec4f(-1, -1, -1, 0))
            self._connect(shader, "normal", types.Normal3f, found, "rgb")
        for name, image in (("roughness", look.roughness_image), ("metallic", look.metallic_image)):
            if image is not None:
                self._connect(shader, name, types.Float, self._texture(path, name, image), image.channel)

    def _texture(self, path: str, name: str, image: Image) -> Prim:
        stage = self._stage
        types = stage.sdf.ValueTypeNames
        file = f"{stage.name}.assets/{stage.tf.MakeValidIdentifier(image.name)}-{image.digest[:8]}{image.suffix}"
        stage.files[file] = image.data
        reader = stage.shade.Shader.Define(stage.stage, f"{path}/st")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", types.String).Set("st")
        texture = stage.shade.Shader.Define(stage.stage, f"{path}/{name}")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", types.Asset).Set(stage.sdf.AssetPath(f"./{file}"))
        texture.CreateInput("sourceColorSpace", types.Token).Set("sRGB" if image.srgb else "raw")
        for wrap in ("wrapS", "wrapT"):
            texture.CreateInput(wrap, types.Token).Set(_WRAPS[image.address_mode])
        texture.CreateInput("st", types.Float2).ConnectToSource(reader.CreateOutput("result", types.Float2))
        return texture

    def _connect(self, shader: Prim, name: str, kind: Any, texture: Prim, channel: str) -> None:
        types = self._stage.sdf.ValueTypeNames
        output = texture.CreateOutput(channel, types.Float3 if channel == "rgb" else types.Float)
        shader.CreateInput(name, kind).ConnectToSource(output)

    def _tell(self, look: Look, entity: str, place: Origin | None) -> None:
        images = (look.base_color_image, look.normal_image, look.roughness_image, look.metallic_image)
        images = (*images, look.emission_image)
        if any(image is not None and image.filter_mode == "nearest" for image in images):
            self._stage.lost.leave_out(entity, "`filter_mode: nearest` of a texture", place)
        if look.transmission > 0 or look.transmission_image is not None:
            self._stage.lost.leave_out(entity, "`transmission` of a material", place)
