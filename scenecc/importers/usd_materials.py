"""Materials of a USD stage: friction and restitution, colours and textures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.diagnostic import Location
from scenecc.importers.imported_scene import Asset
from scenecc.importers.numbers import Names, plain_number, plain_numbers
from scenecc.importers.usd_mdl import MdlMaterial
from scenecc.source.paths import ResolvedFile

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Sink
    from scenecc.importers.usd_meshes import UsdMesh
    from scenecc.importers.usd_stage import Prim, UsdStage

_WRAPS: Final = {"repeat": "repeat", "clamp": "edge", "mirror": "mirror", "black": "border"}

_PREVIEW: Final = {
    "diffuseColor": "base_color",
    "emissiveColor": "emission",
    "roughness": "roughness",
    "metallic": "metallic",
    "normal": "normal",
}
"""Inputs of `UsdPreviewSurface` → keys of a material."""

_GREY: Final = (0.18, 0.18, 0.18)
"""Default `diffuseColor` of a preview surface."""


class UsdMaterialReader:
    """Materials of a stage, each converted once.

    Attributes:
        named: the section `materials` of the scene file.
    """

    def __init__(self, stage: UsdStage, sink: Sink) -> None:
        self.named: dict[str, dict[str, Any]] = {}
        self._stage = stage
        self._sink = sink
        self._names: dict[tuple[str, str], str] = {}
        self._free = Names()
        self._physical: dict[str, dict[str, Any]] = {}
        self._visual: dict[str, dict[str, Any]] = {}

    def set_both(self, entry: dict[str, Any], prim: Prim, parsed: Any) -> None:
        """Sets material and colour of a shape that collides and is visible. `parsed`: its UsdPhysics descriptor."""
        looks = self._visual_path(prim)
        self._set(entry, self.physical_path(parsed), looks)
        if not looks:
            self._set_color(entry, prim)

    def set_physical(self, entry: dict[str, Any], parsed: Any) -> None:
        """Sets the material of a collision shape."""
        self._set(entry, self.physical_path(parsed), "")

    def set_visual(self, entry: dict[str, Any], prim: Prim) -> None:
        """Sets material or colour of a visual shape. `prim`: the geometry, or a subset of its faces."""
        looks = self._visual_path(prim)
        self._set(entry, "", looks)
        if not looks:
            self._set_color(entry, prim if prim.IsA(self._stage.geom.Gprim) else prim.GetParent())

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

    def _set(self, entry: dict[str, Any], physical: str, visual: str) -> None:
        if (physical, visual) not in self._names:
            content: dict[str, Any] = {}
            if physical and self.friction(physical):
                content["physical"] = self.friction(physical)
            if visual and self._look(visual):
                content["visual"] = self._look(visual)
            parts = dict.fromkeys(path.rpartition("/")[2] for path in (visual, physical) if path)
            wish = "_".join(parts) or "material"
            self._names[physical, visual] = self._name(wish, content) if content else ""
        name = self._names[physical, visual]
        if name:
            entry["material"] = name

    def _name(self, wish: str, content: dict[str, Any]) -> str:
        """Returns the name of an equal material, or of a new one."""
        for name, other in self.named.items():
            if other == content:
                return name
        name = self._free.new(wish)
        self.named[name] = content
        return name

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

    def friction(self, path: str) -> dict[str, Any]:
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
            self._physical[path] = {key: plain_number(max(each, 0.0)) for key, each in row.items()}
        return self._physical[path]

    def _visual_path(self, prim: Prim) -> str:
        """Returns the path of a prim's visual material; "" if it has none with a surface."""
        material, _ = self._stage.shade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        if not material:
            return ""
        path = str(material.GetPath())
        return path if self._look(path) else ""

    def _look(self, path: str) -> dict[str, Any]:
        if path not in self._visual:
            self._visual[path] = self._read_look(self._stage.shade.Material(self._stage.prim(path)))
        return self._visual[path]

    def _read_look(self, material: Any) -> dict[str, Any]:
        """Returns the keys of a material: of a preview surface for any render context, else of an MDL material."""
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
        look: dict[str, Any] = {"base_color": list(_GREY), "roughness": 0.5}
        for name, key in _PREVIEW.items():
            value, texture = self._input(surface, name)
            if texture is not None:
                look |= self._texture(key, texture)
            elif value is not None and key != "normal":
                look[key] = _number(value)
        opacity, texture = self._input(surface, "opacity")
        if opacity is not None and texture is None and opacity < 1:
            look["base_color"] = [*look["base_color"][:3], plain_number(opacity)]
        if not any(look.get("emission", ())):
            look.pop("emission", None)
        if "base_color_texture" in look:
            look.pop("base_color")
        if not look.get("metallic", 1.0):
            look.pop("metallic")
        ior, _ = self._input(surface, "ior")
        if ior is not None and ior >= 0:
            # UsdPreviewSurface derives reflectance at normal incidence from `ior`, SAPIEN from `specular`.
            specular = ((ior - 1) / (ior + 1)) ** 2 / 0.08
            if abs(specular - 0.5) > 1e-4:
                look["specular"] = plain_number(min(specular, 1.0))
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
        """Returns a texture as keys of a material; empty if its file is missing, which is reported as a loss."""
        file = texture.GetInput("file")
        asset = file.Get(self._stage.time) if file else None
        if asset is None or not asset.path:
            return {}
        found = self.file(file.GetAttr(), asset)
        if found is None:
            return {}
        row: dict[str, Any] = {"file": found}
        space = texture.GetInput("sourceColorSpace")
        space = space.Get() if space else None
        if (key in {"base_color", "emission"} and space == "raw") or (
            key not in {"base_color", "emission"} and space == "sRGB"
        ):
            row["srgb"] = space == "sRGB"
        wraps = [texture.GetInput(name).Get() for name in ("wrapS", "wrapT") if texture.GetInput(name)]
        if len(set(wraps)) == 1 and _WRAPS.get(str(wraps[0]), "repeat") != "repeat":
            row["address_mode"] = _WRAPS[str(wraps[0])]
        return {f"{key}_texture": row if len(row) > 1 else found}

    def file(self, attribute: Any, asset: Any) -> Asset | None:
        """Returns the file that an attribute names, relative to the layer that sets it."""
        stage = self._stage
        layer = attribute.GetPropertyStack(stage.time)[0].layer
        found = stage.layers.resolve(asset.path, Path(layer.realPath).resolve())
        if isinstance(found, ResolvedFile):
            return Asset(found.path.name, found.path)
        prim = attribute.GetPrim()
        if found.code == "SC401":
            stage.lose("missing-files", f"the texture `{asset.path}`, which does not exist", prim)
        else:
            place = Location(str(layer.realPath))
            self._sink.report(found.code, f"{found.message} ({prim.GetPath()})", place, hint=found.hint)
        return None

    def _set_color(self, entry: dict[str, Any], prim: Prim) -> None:
        """Sets the colour from `displayColor` and `displayOpacity`, averaged over the prim."""
        geom = self._stage.geom.Gprim(prim)
        colors = geom.GetDisplayColorAttr().Get(self._stage.time)
        if colors is None or not len(colors):
            return
        rows = np.asarray(colors, np.float64)
        if len(np.unique(rows, axis=0)) > 1:
            self._stage.lose("material-looks", "colours per point or face; the mean is used", prim)
        color = plain_numbers(np.clip(rows.mean(axis=0), 0, 1).tolist())
        opacities = geom.GetDisplayOpacityAttr().Get(self._stage.time)
        if opacities is not None and len(opacities) and float(opacities[0]) < 1:
            color.append(plain_number(max(float(opacities[0]), 0.0)))
        entry["color"] = color


def _shader_id(shader: Any) -> str:
    return str(shader.GetIdAttr().Get() or "") if shader.GetImplementationSource() == "id" else ""


def _number(value: Any) -> float | list[float]:
    return plain_number(value) if isinstance(value, float | int) else plain_numbers(value)
