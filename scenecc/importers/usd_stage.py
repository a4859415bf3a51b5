"""A composed USD stage as the readers of its parts take it: prims, values, and what is lost."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import Location
from scenecc.importers.imported_scene import Loss
from scenecc.importers.usd_frames import UsdFrames
from scenecc.importers.usd_meshes import UsdMeshReader

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from scenecc.importers.usd_frames import Prim
    from scenecc.importers.usd_layers import UsdLayers


class UsdStage:
    """A stage.

    Attributes:
        stage: of usd-core.
        path: its file.
        layers: its checked layers.
        usd, geom, physics, shade, lux: modules of usd-core.
        time: whose values count: the first, where values change over time.
        frames: of its prims.
        meshes: reads its meshes.
        losses: what the scene does not hold.
    """

    def __init__(self, stage: Prim, path: Path, layers: UsdLayers) -> None:
        self.stage = stage
        self.path = path
        self.layers = layers
        self.usd: Any = import_module("pxr.Usd")
        self.geom: Any = import_module("pxr.UsdGeom")
        self.physics: Any = import_module("pxr.UsdPhysics")
        self.shade: Any = import_module("pxr.UsdShade")
        self.lux: Any = import_module("pxr.UsdLux")
        self.time = self.usd.TimeCode.EarliestTime()
        self.frames = UsdFrames(stage, self.geom, self.physics, self.time)
        self.meshes = UsdMeshReader(self.geom, self.time)
        self.losses: list[Loss] = []

    def prims(self) -> Iterator[Prim]:
        """Every prim that is active, loaded and defined, those of instances too, parents first."""
        return iter(self.usd.PrimRange.Stage(self.stage, self.usd.TraverseInstanceProxies()))

    def prim(self, path: Any) -> Prim:
        """The prim at a path; invalid where there is none."""
        return self.stage.GetPrimAtPath(path)

    def value(self, prim: Prim, name: str, default: Any = None) -> Any:
        """The value of an attribute; `default` where it has none."""
        attribute = prim.GetAttribute(name)
        found = attribute.Get(self.time) if attribute else None
        return default if found is None else found

    def authored(self, prim: Prim, name: str) -> Any:
        """The value of an attribute that the file says; None where it is the schema's own."""
        attribute = prim.GetAttribute(name)
        return attribute.Get(self.time) if attribute and attribute.HasAuthoredValue() else None

    def lose(self, kind: str, message: str, prim: Prim) -> None:
        """Adds a loss. `kind`, `message`: see `Loss`."""
        path = str(prim.GetPath())
        self.losses.append(Loss(kind, f"{message} ({path})", Location(str(self.path)), path))
