"""The USD stage that the exporter fills, and its visual and physics materials."""

from __future__ import annotations

import math
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.emit.xml import AssetFolder, UniqueNames

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from scenecc.diagnostics import Origin
    from scenecc.emit.unsupported import UnsupportedFeatures
    from scenecc.meshes import Image
    from scenecc.meshes.surface import SurfaceMaterial
    from scenecc.plan.snapshot import MeasuredShape


Prim = Any
"""An object of usd-core, which is loaded where it is needed and says nothing of its types."""


class Stage:
    """A stage of usd-core's and its modules by their own names.

    Attributes:
        stage: usd-core's; metres, kilograms, z up.
        root: path of the prim below which all is.
        unsupported: takes what USD has not.
        assets: images.
    """

    def __init__(self, name: str, unsupported: UnsupportedFeatures) -> None:
        """`name`: of the file without its suffix."""
        self.usd: Any = import_module("pxr.Usd")
        self.geom: Any = import_module("pxr.UsdGeom")
        self.physics: Any = import_module("pxr.UsdPhysics")
        self.shade: Any = import_module("pxr.UsdShade")
        self.gf: Any = import_module("pxr.Gf")
        self.sdf: Any = import_module("pxr.Sdf")
        self.tf: Any = import_module("pxr.Tf")
        self.vt: Any = import_module("pxr.Vt")
        self.stage: Any = self.usd.Stage.CreateInMemory()
        self.unsupported = unsupported
        self.assets = AssetFolder(name)
        self.root = "/World"
        self._paths = UniqueNames()
        self.geom.SetStageUpAxis(self.stage, self.geom.Tokens.z)
        self.geom.SetStageMetersPerUnit(self.stage, 1.0)
        self.physics.SetStageKilogramsPerUnit(self.stage, 1.0)
        self.stage.SetDefaultPrim(self.geom.Xform.Define(self.stage, self.root).GetPrim())

    def path(self, above: str, name: str) -> str:
        """A path below another, of a name that nothing else has there: names in USD are identifiers."""
        return self._paths.new(f"{above}/{self.tf.MakeValidIdentifier(name)}")

    def xform(self, above: str, name: str, pose: tuple[float, ...] | None = None) -> Prim:
        """A frame, shown by its name as the scene has it. `pose`: p then q (wxyz); None: the identity."""
        made = self.geom.Xform.Define(self.stage, self.path(above, name))
        made.GetPrim().SetDisplayName(name)
        if pose is not None:
            self.place(made, pose)
        return made

    def place(self, made: Prim, pose: tuple[float, ...], scale: tuple[float, ...] | None = None) -> None:
        """Puts something somewhere: p then q (wxyz), then a scale along its own axes."""
        made.AddTranslateOp(self.geom.XformOp.PrecisionDouble).Set(self.gf.Vec3d(*pose[:3]))
        made.AddOrientOp(self.geom.XformOp.PrecisionDouble).Set(self.gf.Quatd(*pose[3:]))
        if scale is not None:
            made.AddScaleOp(self.geom.XformOp.PrecisionDouble).Set(self.gf.Vec3d(*scale))

    def vec3(self, numbers: tuple[float, ...]) -> Any:
        """Three numbers."""
        return self.gf.Vec3f(*map(float, numbers))

    def quat(self, pose: tuple[float, ...]) -> Any:
        """The rotation of a pose."""
        return self.gf.Quatf(*map(float, pose[3:]))

    def vec3s(self, rows: ArrayLike) -> Any:
        """(n, 3) numbers."""
        return self.vt.Vec3fArray.FromNumpy(np.ascontiguousarray(rows, dtype=np.float32))

    def vec2s(self, rows: ArrayLike) -> Any:
        """(n, 2) numbers."""
        return self.vt.Vec2fArray.FromNumpy(np.ascontiguousarray(rows, dtype=np.float32))

    def ints(self, numbers: ArrayLike) -> Any:
        """(n,) integers."""
        return self.vt.IntArray.FromNumpy(np.ascontiguousarray(numbers, dtype=np.int32).ravel())


_WRAPS: Final = {"repeat": "repeat", "edge": "clamp", "mirror": "mirror", "border": "black"}


class UsdMaterials:
    """The materials of a stage, each written once."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._made: dict[SurfaceMaterial, Prim] = {}
        self._rubbing: dict[tuple[float, float, float], Prim] = {}
        self._scope: str | None = None

    def bind(self, made: Prim, look: SurfaceMaterial, entity: str, place: Origin | None) -> None:
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

    def _material(self, look: SurfaceMaterial) -> Prim:
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

    def _images(self, look: SurfaceMaterial, path: str, shader: Prim) -> None:
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
        file = stage.assets.add(stage.tf.MakeValidIdentifier(image.name), image.suffix, image.data)
        reader = stage.shade.Shader.Define(stage.stage, f"{path}/st")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", types.String).Set("st")
        texture = stage.shade.Shader.Define(stage.stage, f"{path}/{name}")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", types.Asset).Set(stage.sdf.AssetPath(f"./{stage.assets.folder}/{file}"))
        texture.CreateInput("sourceColorSpace", types.Token).Set("sRGB" if image.srgb else "raw")
        for wrap in ("wrapS", "wrapT"):
            texture.CreateInput(wrap, types.Token).Set(_WRAPS[image.address_mode])
        texture.CreateInput("st", types.Float2).ConnectToSource(reader.CreateOutput("result", types.Float2))
        return texture

    def _connect(self, shader: Prim, name: str, kind: Any, texture: Prim, channel: str) -> None:
        types = self._stage.sdf.ValueTypeNames
        output = texture.CreateOutput(channel, types.Float3 if channel == "rgb" else types.Float)
        shader.CreateInput(name, kind).ConnectToSource(output)

    def _tell(self, look: SurfaceMaterial, entity: str, place: Origin | None) -> None:
        images = (look.base_color_image, look.normal_image, look.roughness_image, look.metallic_image)
        images = (*images, look.emission_image)
        if any(image is not None and image.filter_mode == "nearest" for image in images):
            self._stage.unsupported.leave_out(entity, "`filter_mode: nearest` of a texture", place)
        if look.transmission > 0 or look.transmission_image is not None:
            self._stage.unsupported.leave_out(entity, "`transmission` of a material", place)
