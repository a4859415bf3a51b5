"""Materials of a USD stage: friction and restitution, colours and textures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.diagnostics.diagnostic import Location
from scenecc.geometry.rotations import to_vector
from scenecc.importers.usd_mdl import MdlMaterial
from scenecc.robots.description import DescribedMaterial, DescribedTexture
from scenecc.source.paths import ResolvedFile

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Sink
    from scenecc.importers.usd_meshes import UsdMesh
    from scenecc.importers.usd_stage import Prim, UsdStage

_WRAPS: Final[dict[str, Literal["border", "edge", "mirror"]]] = {"clamp": "edge", "mirror": "mirror", "black": "border"}

_PREVIEW: Final = {
    "diffuseColor": "base_color",
    "emissiveColor": "emission",
    "roughness": "roughness",
    "metallic": "metallic",
    "normal": "normal",
}
"""Inputs of `UsdPreviewSurface` → fields of a material."""

_GREY: Final = (0.18, 0.18, 0.18)
"""Default `diffuseColor` of a preview surface."""


class UsdMaterialReader:
    """Materials of a stage, each read once."""

    def __init__(self, stage: UsdStage, sink: Sink) -> None:
        self._stage = stage
        self._sink = sink
        self._physical: dict[str, dict[str, float]] = {}
        self._visual: dict[str, DescribedMaterial | None] = {}

    def look(self, prim: Prim) -> DescribedMaterial | None:
        """Returns the material of a visual shape. `prim`: the geometry, or a subset of its faces."""
        material, _ = self._stage.shade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        path = str(material.GetPath()) if material else ""
        if path and path not in self._visual:
            look = self._read_look(material)
            self._visual[path] = _material_of(self._within_range(look, material.GetPrim()), path) if look else None
        return self._visual.get(path) or self._color(prim if prim.IsA(self._stage.geom.Gprim) else prim.GetParent())

    def _within_range(self, look: dict[str, Any], prim: Prim) -> dict[str, Any]:
        """Returns the fields of a material with numbers in 0..1, as the renderer needs them; emission from 0."""
        found = dict(look)
        for key, value in look.items():
            if key == "normal" or isinstance(value, DescribedTexture):
                continue
            given = np.asarray(value, np.float64)
            within = np.clip(np.nan_to_num(given, posinf=1.0), 0.0, np.inf if key == "emission" else 1.0)
            if not np.array_equal(given, within):
                self._stage.lose("material-looks", f"`{key}` of a material, {value}, which is not in 0..1", prim)
                found[key] = within.tolist()
        return found

    def density(self, parsed: Any) -> float:
        """Returns the density of a collider's material, in the stage's units; 0 if it has none."""
        path = self.physical_path(parsed)
        return float(self._stage.value(self._stage.prim(path), "physics:density", 0.0)) if path else 0.0

    def parts(self, prim: Prim, mesh: UsdMesh) -> Iterator[tuple[Prim, UsdMesh, str]]:
        """Yields the parts of a mesh by material: the prim with the binding, the triangles, and a file name suffix."""
        rest = np.ones(len(mesh.faces), bool)
        for subset in self._stage.shade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
            indices = np.asarray(subset.GetIndicesAttr().Get(self._stage.time), np.int64)
            faces = np.isin(mesh.sources, indices) & rest
            if faces.any():
                rest &= ~faces
                yield subset.GetPrim(), mesh.part(faces), f"_{subset.GetPrim().GetName()}"
        if rest.all():
            yield prim, mesh, ""
        elif rest.any():
            yield prim, mesh.part(rest), ""

    def physical_path(self, parsed: Any) -> str:
        """Returns the path of a collider's material; "" if it has none."""
        paths = [str(path) for path in parsed.materials]
        stage = self._stage
        found = [path for path in paths if path and stage.prim(path).HasAPI(stage.physics.MaterialAPI)]
        if len(set(found)) > 1:
            stage.lose(
                "material-looks",
                "several materials in one collider: the first is used for the whole",
                stage.prim(parsed.primPath),
            )
        return found[0] if found else ""

    def friction(self, path: str) -> dict[str, float]:
        """Returns static friction, dynamic friction and restitution of a material."""
        if path not in self._physical:
            stage, prim = self._stage, self._stage.prim(path)
            static, dynamic, restitution = (
                float(stage.value(prim, f"physics:{name}", 0.0))
                for name in ("staticFriction", "dynamicFriction", "restitution")
            )
            if dynamic > static:
                stage.lose(
                    "frictions",
                    f"a static friction of {static:g} below dynamic friction; it is raised to {dynamic:g}",
                    prim,
                )
                static = dynamic
            row = {
                "static_friction": static,
                "dynamic_friction": dynamic,
                "restitution": min(max(restitution, 0.0), 1.0),
            }
            self._physical[path] = {key: max(each, 0.0) for key, each in row.items()}
        return self._physical[path]

    def _read_look(self, material: Any) -> dict[str, Any]:
        """Returns the fields of a material: of a preview surface for any render context, else of an MDL material."""
        surfaces: list[Any] = []
        for output in material.GetSurfaceOutputs():
            context = str(output.GetBaseName()).rpartition(":")[0]
            surface = material.ComputeSurfaceSource(context)[0]
            if surface:
                surfaces.append((context, surface))
        surfaces.sort(key=lambda each: each[0] not in {"", "mdl"})
        preview = next((each for _, each in surfaces if _shader_id(each) == "UsdPreviewSurface"), None)
        if preview is not None:
            return self._read_preview(preview)
        if not surfaces:
            return {}
        mdl = MdlMaterial(surfaces[0][1], lambda shader, name: self._input(shader, name)[0], self.file)
        look = mdl.look()
        if mdl.unread or not look:
            listed = ", ".join(f"`{name}`" for name in mdl.unread) or "the shader"
            what = f"{listed} of a material of type `{mdl.name or surfaces[0][0]}`"
            self._stage.lose("material-looks", what, material.GetPrim())
        return look

    def _read_preview(self, surface: Any) -> dict[str, Any]:
        look: dict[str, Any] = {"base_color": _GREY, "roughness": 0.5}
        for name, key in _PREVIEW.items():
            value, texture = self._input(surface, name)
            if texture is not None:
                look |= self._texture(key, texture)
            elif value is not None and key != "normal":
                look[key] = value
        opacity, texture = self._input(surface, "opacity")
        if opacity is not None and texture is None and opacity < 1:
            look["base_color"] = (*look["base_color"][:3], opacity)
        if not any(look.get("emission", ())):
            look.pop("emission", None)
        if "base_color_texture" in look:
            look.pop("base_color")
        ior, _ = self._input(surface, "ior")
        if ior is not None and ior >= 0:
            # UsdPreviewSurface derives reflectance at normal incidence from `ior`, SAPIEN from `specular`.
            specular = ((ior - 1) / (ior + 1)) ** 2 / 0.08
            if abs(specular - 0.5) > 1e-4:
                look["specular"] = min(specular, 1.0)
        for name in ("displacement", "occlusion", "clearcoat", "specularColor"):
            value, texture = self._input(surface, name)
            if texture is not None or (
                value is not None and np.any(np.asarray(value) != (1.0 if name == "occlusion" else 0.0))
            ):
                self._stage.lose("material-looks", f"`{name}` of a material", surface.GetPrim())
        return look

    def _input(self, shader: Any, name: str) -> tuple[Any, Any]:
        """Returns the authored value of an input, and the texture connected to it."""
        found = shader.GetInput(name)
        if not found:
            return None, None
        for attribute in self._stage.shade.Utils.GetValueProducingAttributes(found):
            owner = self._stage.shade.Shader(attribute.GetPrim())
            if owner and self._stage.shade.Utils.GetType(attribute.GetName()) == self._stage.shade.AttributeType.Output:
                return None, owner if owner.GetIdAttr().Get() == "UsdUVTexture" else None
            return attribute.Get(self._stage.time), None
        return None, None

    def _texture(self, key: str, texture: Any) -> dict[str, Any]:
        """Returns a texture as fields of a material; empty if its file is missing, which is reported as a loss."""
        file = texture.GetInput("file")
        asset = file.Get(self._stage.time) if file else None
        if asset is None or not asset.path:
            return {}
        found = self.file(file.GetAttr(), asset)
        if found is None:
            return {}
        space = texture.GetInput("sourceColorSpace")
        space = space.Get() if space else None
        if space == ("raw" if key in {"base_color", "emission"} else "sRGB"):
            found = replace(found, srgb=space == "sRGB")
        wraps = {str(texture.GetInput(name).Get()) for name in ("wrapS", "wrapT") if texture.GetInput(name)}
        mode = _WRAPS.get(wraps.pop()) if len(wraps) == 1 else None
        return {f"{key}_texture": replace(found, address_mode=mode)}

    def file(self, attribute: Any, asset: Any) -> DescribedTexture | None:
        """Returns the file that an attribute names, relative to the layer that sets it."""
        stage = self._stage
        layer = attribute.GetPropertyStack(stage.time)[0].layer
        found = stage.layers.resolve(asset.path, Path(layer.realPath).resolve())
        if isinstance(found, ResolvedFile):
            return DescribedTexture(found.uri, found.path)
        prim = attribute.GetPrim()
        if found.code == "SC401":
            stage.lose("missing-files", f"the texture `{asset.path}`, which does not exist", prim)
        else:
            place = Location(str(layer.realPath))
            self._sink.report(found.code, f"{found.message} ({prim.GetPath()})", place, hint=found.hint)
        return None

    def _color(self, prim: Prim) -> DescribedMaterial | None:
        """Returns a material of `displayColor` and `displayOpacity`, averaged over the prim; None without colour."""
        geom = self._stage.geom.Gprim(prim)
        colors = geom.GetDisplayColorAttr().Get(self._stage.time)
        if colors is None or not len(colors):
            return None
        rows = np.asarray(colors, np.float64)
        if len(np.unique(rows, axis=0)) > 1:
            self._stage.lose("material-looks", "colours per point or face; the mean is used", prim)
        opacities = geom.GetDisplayOpacityAttr().Get(self._stage.time)
        opacity = float(opacities[0]) if opacities is not None and len(opacities) else 1.0
        r, g, b = np.clip(rows.mean(axis=0), 0, 1).tolist()
        return DescribedMaterial((r, g, b, min(max(opacity, 0.0), 1.0)))


def _shader_id(shader: Any) -> str:
    return str(shader.GetIdAttr().Get() or "") if shader.GetImplementationSource() == "id" else ""


def _material_of(look: dict[str, Any], path: str) -> DescribedMaterial:
    """Returns the material of fields, whose colours may be values of usd-core."""
    colors: dict[str, Any] = {name: to_vector(look[name][:3]) for name in ("base_color", "emission") if name in look}
    if "base_color" in look:
        colors["base_color"] += (float(look["base_color"][3]) if len(look["base_color"]) > 3 else 1.0,)
    return DescribedMaterial(**{**look, **colors}, name=path.rpartition("/")[2])
