"""The stage that is filled, and what is asked for in every part of it."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from scenecc.emit.xml.lost import Lost

Prim = Any
"""An object of usd-core, which is loaded where it is needed and says nothing of its types."""


class Stage:
    """A stage of usd-core's and its modules by their own names.

    Attributes:
        stage: usd-core's; metres, kilograms, z up.
        root: path of the prim below which all is.
        name: of the file without its suffix; images lie in the folder `NAME.assets`.
        lost: takes what USD has not.
        files: images, by their paths from the file's folder.
    """

    def __init__(self, name: str, lost: Lost) -> None:
        self.usd: Any = import_module("pxr.Usd")
        self.geom: Any = import_module("pxr.UsdGeom")
        self.physics: Any = import_module("pxr.UsdPhysics")
        self.shade: Any = import_module("pxr.UsdShade")
        self.gf: Any = import_module("pxr.Gf")
        self.sdf: Any = import_module("pxr.Sdf")
        self.tf: Any = import_module("pxr.Tf")
        self.vt: Any = import_module("pxr.Vt")
        self.stage: Any = self.usd.Stage.CreateInMemory()
        self.name = name
        self.lost = lost
        self.files: dict[str, bytes] = {}
        self.root = "/World"
        self._taken: set[str] = set()
        self.geom.SetStageUpAxis(self.stage, self.geom.Tokens.z)
        self.geom.SetStageMetersPerUnit(self.stage, 1.0)
        self.physics.SetStageKilogramsPerUnit(self.stage, 1.0)
        self.stage.SetDefaultPrim(self.geom.Xform.Define(self.stage, self.root).GetPrim())

    def path(self, above: str, name: str) -> str:
        """A path below another, of a name that nothing else has there: names in USD are identifiers."""
        word = self.tf.MakeValidIdentifier(name)
        path, count = f"{above}/{word}", 1
        while path in self._taken:
            count += 1
            path = f"{above}/{word}_{count}"
        self._taken.add(path)
        return path

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
