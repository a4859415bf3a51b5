"""A composed USD stage as the readers of its parts take it: prims, values, frames in metres, and what is lost."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.diagnostic import Location
from scenecc.geometry.rotations import IDENTITY, compose, from_matrix, rotate, to_pose
from scenecc.importers.imported_scene import Loss
from scenecc.importers.usd_meshes import UsdMeshReader

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Pose7, Quat, Vec3
    from scenecc.importers.usd_layers import UsdLayers


Prim = Any
"""An object of usd-core, which is loaded lazily and has no type hints."""

_UP_ROTATIONS: Final = {
    "X": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
    "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "Z": np.eye(3),
}

SHEAR_TOLERANCE: Final = 1e-5
"""How far from a rotation and a scale a matrix may be, as a part of its largest scale."""


def split_matrix(matrix: NDArray[np.float64]) -> tuple[Pose7, NDArray[np.float64]]:
    """The rigid part of an affine matrix and what stands before it.

    Args:
        matrix: (4, 4), which stands before a column.

    Returns:
        The pose, and a symmetric (3, 3) `stretch` with matrix[:3, :3] = rotation · stretch. The stretch is diagonal
        where nothing is sheared, and negative where the matrix mirrors.
    """
    left, _, right = np.linalg.svd(matrix[:3, :3])
    rotation = left @ right
    if np.linalg.det(rotation) < 0:
        rotation = -rotation
    pose = to_pose([*matrix[:3, 3], *from_matrix(rotation.tolist())])
    return pose, rotation.T @ matrix[:3, :3]


def scale_of(stretch: NDArray[np.float64]) -> Vec3 | None:
    """The scale along x, y and z of a `stretch`; None where it shears."""
    scale = np.diag(stretch)
    if np.abs(stretch - np.diag(scale)).max() > SHEAR_TOLERANCE * np.abs(scale).max():
        return None
    x, y, z = scale.tolist()
    return x, y, z


class UsdFrames:
    """Frames of a stage.

    Attributes:
        metres: length of the stage's unit [m].
        kilograms: of its unit of mass [kg].
    """

    def __init__(self, stage: Prim, geom: Any, physics: Any, time: Any) -> None:
        """`geom`, `physics`: modules of usd-core. `time`: whose transforms count."""
        self.metres = float(geom.GetStageMetersPerUnit(stage))
        self.kilograms = float(physics.GetStageKilogramsPerUnit(stage))
        self._turn = _UP_ROTATIONS[str(geom.GetStageUpAxis(stage))]
        self._cache = geom.XformCache(time)
        self._worlds: dict[Any, NDArray[np.float64]] = {}

    def world(self, prim: Prim) -> NDArray[np.float64]:
        """(4, 4) from a prim's frame, in the stage's unit, to the world [m]."""
        path = prim.GetPath()
        found = self._worlds.get(path)
        if found is None:
            local = np.array(self._cache.GetLocalToWorldTransform(prim), np.float64).T
            found = self._worlds[path] = self.base() @ local
        return found

    def base(self) -> NDArray[np.float64]:
        """(4, 4) from the stage's own frame to the world."""
        matrix = np.eye(4)
        matrix[:3, :3] = self._turn * self.metres
        return matrix

    def pose(self, prim: Prim) -> Pose7:
        """Where a prim's frame is in the world, without its scale."""
        return split_matrix(self.world(prim))[0]

    def direction(self, vector: Iterable[float]) -> Vec3:
        """A direction of the stage in the world, without its unit."""
        x, y, z = (self._turn @ np.array(list(vector), np.float64)).tolist()
        return x, y, z

    def turned(self, pose: Pose7 | None, vector: Iterable[float]) -> Vec3:
        """A vector of a prim's frame in the world, without its unit and scale. `pose`: the frame's; None: the stage."""
        if pose is None:
            return self.direction(vector)
        x, y, z = vector
        return rotate(pose[3:], (x, y, z))

    def frame_in(self, prim: Prim | None, position: Iterable[float], rotation: Any) -> Pose7:
        """A frame that is given in a prim's own frame, in the world.

        Args:
            prim: None: the stage.
            position: in the prim's unit and scale.
            rotation: a quaternion of usd-core.
        """
        matrix = self.base() if prim is None else self.world(prim)
        pose = split_matrix(matrix)[0]
        point = matrix @ np.array([*position, 1.0])
        return compose((*point[:3].tolist(), *pose[3:]), (0.0, 0.0, 0.0, *quat_of(rotation)))


def quat_of(rotation: Any) -> Quat:
    """A quaternion of usd-core as [w, x, y, z], of unit length."""
    numbers = np.array([rotation.GetReal(), *rotation.GetImaginary()], np.float64)
    length = float(np.linalg.norm(numbers))
    w, x, y, z = (numbers / length).tolist() if length > 0 else IDENTITY
    return w, x, y, z


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
