"""Converts lights and cameras of a USD stage."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from scenecc.geometry.rotations import compose, relative_pose, rotate
from scenecc.importers.numbers import LOOK, Names, light_place, plain_number, plain_numbers, plain_pose

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.importers.imported_scene import Asset
    from scenecc.importers.usd_bodies import UsdBody
    from scenecc.importers.usd_materials import UsdMaterialReader
    from scenecc.importers.usd_stage import Prim, UsdStage

_NITS: Final = 1000.0
"""Nits per unit of brightness: USD's lights are in nits, SAPIEN's have no unit."""

_WIDTH: Final = 640


class RenderingReader:
    """Writes the sections `environment`, `lights` and `cameras`."""

    def __init__(
        self,
        stage: UsdStage,
        materials: UsdMaterialReader,
        owner: Callable[[Prim], UsdBody | None],
        where: Mapping[str, str],
    ) -> None:
        """`owner`: returns the body of a prim; `where`: names of bodies in the scene, by path."""
        self._stage = stage
        self._materials = materials
        self._owner = owner
        self._where = where

    def sections(self, name: Callable[[Prim], str]) -> dict[str, dict[str, Any]]:
        """Returns the three sections. `name`: returns the name of a camera."""
        environment: dict[str, Any] = {}
        lights: dict[str, Any] = {}
        cameras: dict[str, Any] = {}
        names = Names()
        for prim in self._stage.prims():
            if prim.IsA(self._stage.geom.Camera):
                cameras[name(prim)] = self._camera(prim)
            elif prim.HasAPI(self._stage.lux.LightAPI) and self._is_visible(prim):
                if prim.IsA(self._stage.lux.DomeLight):
                    environment |= self._dome(prim)
                    continue
                found = self._light(prim)
                if found is not None:
                    lights[names.new(prim.GetName())] = found
        return {"environment": environment, "lights": lights, "cameras": cameras}

    def _is_visible(self, prim: Prim) -> bool:
        image = self._stage.geom.Imageable(prim)
        return image.ComputeVisibility(self._stage.time) != self._stage.geom.Tokens.invisible

    def _color(self, prim: Prim, factor: float = 1.0) -> list[float]:
        value = self._stage.value
        brightness = value(prim, "inputs:intensity", 1.0) * 2.0 ** value(prim, "inputs:exposure", 0.0) * factor / _NITS
        return plain_numbers(max(each * brightness, 0.0) for each in value(prim, "inputs:color", (1.0, 1.0, 1.0)))

    def _light(self, prim: Prim) -> dict[str, Any] | None:
        stage, lux = self._stage, self._stage.lux
        pose = stage.frames.pose(prim)
        body = self._owner(prim)
        mounted = body is not None and str(body.prim.GetPath()) in self._where
        if prim.IsA(lux.DistantLight):
            kind, color = "directional", self._color(prim)
        elif prim.IsA(lux.SphereLight):
            # From any side, a sphere is a disk: its intensity is its radiance times the area of that disk.
            area = math.pi * (stage.value(prim, "inputs:radius", 0.5) * stage.frames.metres) ** 2
            kind, color = "point", self._color(prim, 1.0 if stage.value(prim, "inputs:normalize") else area)
        else:
            stage.lose("lights", f"a {prim.GetTypeName()}", prim)
            return None
        stage.lose("light-units", "the unit of a light: 1000 nits become a brightness of 1", prim)
        cone = stage.authored(prim, "inputs:shaping:cone:angle")
        keys: dict[str, Any] = {"type": kind, "color": color}
        if kind == "point" and cone is not None and cone < 90:
            keys |= {
                "type": "spot",
                "inner_fov": plain_number(math.radians(2 * cone)),
                "outer_fov": plain_number(math.radians(2 * cone)),
            }
        if mounted and body is not None:
            local = relative_pose(body.pose, compose(pose, LOOK))
            return {**keys, "mount": self._where[str(body.prim.GetPath())], "pose": plain_pose(local)}
        return {**keys, **light_place(keys["type"], pose[:3], rotate(pose[3:], (0.0, 0.0, -1.0)))}

    def _dome(self, prim: Prim) -> dict[str, Any]:
        self._stage.lose("light-units", "the unit of a light: 1000 nits become a brightness of 1", prim)
        attribute = prim.GetAttribute("inputs:texture:file")
        asset = attribute.Get(self._stage.time) if attribute else None
        keys: dict[str, Any] = {"ambient_light": [min(each, 1.0) for each in self._color(prim)]}
        if asset is not None and asset.path:
            file: Asset | None = self._materials.file(attribute, asset)
            if file is not None:
                keys["map"] = file
        return keys

    def _camera(self, prim: Prim) -> dict[str, Any]:
        value, metres = self._stage.value, self._stage.frames.metres
        body = self._owner(prim)
        pose = compose(self._stage.frames.pose(prim), LOOK)
        keys: dict[str, Any] = {}
        if body is not None and str(body.prim.GetPath()) in self._where:
            keys["mount"] = self._where[str(body.prim.GetPath())]
            pose = relative_pose(body.pose, pose)
        keys["pose"] = plain_pose(pose)
        across, up = value(prim, "horizontalAperture"), value(prim, "verticalAperture")
        keys |= {"width": _WIDTH, "height": max(1, round(_WIDTH * up / across))}
        if str(value(prim, "projection")) == "orthographic":
            keys["orthographic"] = {
                "top": plain_number(up / 20 * metres)
            }  # an aperture is in tenths of the stage's unit
        else:
            keys["fovy"] = plain_number(2 * math.atan(up / (2 * value(prim, "focalLength"))))
        clipping = self._stage.authored(prim, "clippingRange")
        if clipping is not None and 0 < clipping[0] < clipping[1]:
            keys |= {"near": plain_number(clipping[0] * metres), "far": plain_number(clipping[1] * metres)}
        if value(prim, "horizontalApertureOffset") or value(prim, "verticalApertureOffset"):
            self._stage.lose("lenses", "the offset of a camera's aperture", prim)
        return keys
