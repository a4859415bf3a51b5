"""Describes lights and cameras of a USD stage."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from scenecc.geometry.rotations import Pose7, Vec3, compose, relative_pose, rotate, to_vector
from scenecc.importers.numbers import LOOK
from scenecc.robots.world import DescribedCamera, DescribedLight

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.importers.usd_materials import UsdMaterialReader
    from scenecc.importers.usd_stage import Prim, UsdStage
    from scenecc.robots.description import DescribedTexture, LinkName

_NITS: Final = 1000.0
"""Nits per unit of brightness: USD's lights are in nits, SAPIEN's have no unit."""

_WIDTH: Final = 640

_FORWARD: Final = (0.0, 0.0, -1.0)
"""Direction of a light in its own frame."""


@dataclass(slots=True)
class RenderingReader:
    """Lights, cameras and environment of a stage.

    Args:
        stage: the stage.
        materials: its materials.
        owner: returns name and pose of the link that carries a prim; None: the world.
    """

    stage: UsdStage
    materials: UsdMaterialReader
    owner: Callable[[Prim], tuple[LinkName, Pose7] | None]
    lights: list[DescribedLight] = field(default_factory=list[DescribedLight])
    cameras: list[DescribedCamera] = field(default_factory=list[DescribedCamera])
    ambient: Vec3 | None = None
    environment: DescribedTexture | None = None

    def read(self) -> None:
        """Reads them all."""
        for prim in self.stage.prims():
            if prim.IsA(self.stage.geom.Camera):
                self._add_camera(prim)
            elif prim.HasAPI(self.stage.lux.LightAPI) and self._is_visible(prim):
                if prim.IsA(self.stage.lux.DomeLight):
                    self._read_dome(prim)
                else:
                    self._add_light(prim)

    def _is_visible(self, prim: Prim) -> bool:
        image = self.stage.geom.Imageable(prim)
        return image.ComputeVisibility(self.stage.time) != self.stage.geom.Tokens.invisible

    def _color(self, prim: Prim, factor: float = 1.0) -> Vec3:
        value = self.stage.value
        brightness = value(prim, "inputs:intensity", 1.0) * 2.0 ** value(prim, "inputs:exposure", 0.0) * factor / _NITS
        return to_vector(max(each * brightness, 0.0) for each in value(prim, "inputs:color", (1.0, 1.0, 1.0)))

    def _place(self, prim: Prim, pose: Pose7) -> tuple[LinkName | None, Pose7]:
        """Returns the link that carries a prim, and a pose in the world relative to it."""
        found = self.owner(prim)
        return (None, pose) if found is None else (found[0], relative_pose(found[1], pose))

    def _add_light(self, prim: Prim) -> None:
        stage, lux = self.stage, self.stage.lux
        cone = None
        if prim.IsA(lux.DistantLight):
            kind, color = "directional", self._color(prim)
        elif prim.IsA(lux.SphereLight):
            # From any side, a sphere is a disk: its intensity is its radiance times the area of that disk.
            area = math.pi * (stage.value(prim, "inputs:radius", 0.5) * stage.frames.metres) ** 2
            color = self._color(prim, 1.0 if stage.value(prim, "inputs:normalize") else area)
            angle = stage.authored(prim, "inputs:shaping:cone:angle")
            kind = "point"
            if angle is not None and angle < 90:
                kind, cone = "spot", (math.radians(2 * angle), math.radians(2 * angle))
        else:
            stage.lose("lights", f"a {prim.GetTypeName()}", prim)
            return
        self._lose_unit(prim)
        mount, pose = self._place(prim, stage.frames.pose(prim))
        aim = rotate(pose[3:], _FORWARD)
        light = DescribedLight(prim.GetName(), kind, color, pose[:3], aim, stage.place, cone, mount=mount)
        self.lights.append(light)

    def _lose_unit(self, prim: Prim) -> None:
        self.stage.lose("light-units", "the unit of a light: 1000 nits become a brightness of 1", prim)

    def _read_dome(self, prim: Prim) -> None:
        self._lose_unit(prim)
        self.ambient = to_vector(min(each, 1.0) for each in self._color(prim))
        attribute = prim.GetAttribute("inputs:texture:file")
        asset = attribute.Get(self.stage.time) if attribute else None
        if asset is not None and asset.path:
            self.environment = self.materials.file(attribute, asset) or self.environment

    def _add_camera(self, prim: Prim) -> None:
        value, metres = self.stage.value, self.stage.frames.metres
        mount, pose = self._place(prim, compose(self.stage.frames.pose(prim), LOOK))
        across, up = value(prim, "horizontalAperture"), value(prim, "verticalAperture")
        lens = "fovy", 2 * math.atan(up / (2 * value(prim, "focalLength")))
        if str(value(prim, "projection")) == "orthographic":
            lens = "orthographic", up / 20 * metres  # an aperture is in tenths of the stage's unit
        near, far = self.stage.authored(prim, "clippingRange") or (0.0, 0.0)
        clip = (near * metres, far * metres) if 0 < near < far else None
        if value(prim, "horizontalApertureOffset") or value(prim, "verticalApertureOffset"):
            self.stage.lose("lenses", "the offset of a camera's aperture", prim)
        name, size = str(prim.GetDisplayName() or prim.GetName()), (_WIDTH, max(1, round(_WIDTH * up / across)))
        self.cameras.append(DescribedCamera(name, pose, lens, self.stage.place, size, clip, mount))
