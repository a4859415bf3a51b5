"""A composed USD stage for the readers: prims, values, frames in metres, and the list of losses."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut
from scenecc.files import open_regular
from scenecc.geometry.rotations import IDENTITY, Pose7, Quat, Vec3, compose, from_matrix, rotate, to_pose
from scenecc.importers.imported_scene import ImportContext, Loss
from scenecc.importers.usd_meshes import Prim, UsdMeshReader
from scenecc.source.paths import Refusal, ResolvedFile, resolve_asset_reference, shorten_uri

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from numpy.typing import NDArray

_MAGIC: Final = (b"PXR-USDC", b"#usda 1.")

_MAX_LAYERS: Final = 1000

_PARSE_ERROR: Final = re.compile(r":(\d+):(\d+): ([^\n]*)")
"""Line, column and message in usd-core's parse errors."""

_OPENED_LIMIT: Final = 4
"""Maximum size of all layers together, as a multiple of the limit for one asset."""


class UsdLayers:
    """Opens the layers of a stage, after checking each one.

    Attributes:
        uris: URI of each checked layer, by resolved path, as in `ResolvedFile`.
        error: exception that usd-core raises for unreadable content, possibly long after opening a file.
    """

    def __init__(self, context: ImportContext) -> None:
        self.uris: dict[Path, str] = {}
        self._context = context
        self._bytes = 0
        self._sdf: Any = import_module("pxr.Sdf")
        self.error: type[Exception] = import_module("pxr.Tf").ErrorException

    def open(self, path: Path) -> Prim | None:
        """Returns the composed stage of a file; None after an error, which is reported."""
        if not self._check(path):
            return None
        usd: Any = import_module("pxr.Usd")
        try:
            stage = usd.Stage.Open(str(path.resolve()), usd.Stage.LoadAll)
        except self.error as error:
            self.report_unreadable(path, error)
            return None
        if not self.composes(stage, path):
            return None
        # The layers' references were followed above; this checks that usd-core opened nothing else.
        for layer in stage.GetUsedLayers():
            if not layer.anonymous and Path(layer.realPath).resolve() not in self.uris:
                message = f"the stage opens `{shorten_uri(layer.identifier)}`, which no layer refers to"
                self._context.sink.report("SC430", message, Location(str(path)))
                return None
        return stage

    def composes(self, stage: Prim, path: Path) -> bool:
        """Returns whether a stage has no composition error; the first one is reported."""
        for fault in stage.GetCompositionErrors()[:1]:
            message = cut(" ".join(str(fault).split()))
            self._context.sink.report("SC430", f"the stage does not compose: {message}", Location(str(path)))
            return False
        return True

    def resolve(self, name: str, owner: Path) -> ResolvedFile | Refusal:
        """Returns the file that a layer refers to, if it may be read. `owner`: resolved path of the layer."""
        return resolve_asset_reference(name, owner=owner, owner_uri=self.uris[owner], scope=self._context.scope)

    def _check(self, path: Path) -> bool:
        """Returns whether a layer and all files that it refers to, in any variant, may be read."""
        todo: list[tuple[Path, str]] = [(path.resolve(), path.name)]
        ok = True
        while todo:
            file, uri = todo.pop()
            if file in self.uris:
                continue
            self.uris[file] = uri
            layer = self._open_layer(file)
            if layer is None:
                return False
            for name in sorted({*layer.GetCompositionAssetDependencies(), *layer.GetExternalAssetDependencies()}):
                found = self.resolve(name, file) if name else None
                if isinstance(found, ResolvedFile):
                    todo.append((found.path.resolve(), found.uri))
                elif found is not None:
                    ok = False
                    place = Location(str(file), _line_of(file, name))
                    self._context.sink.report(found.code, found.message, place, hint=found.hint)
        return ok

    def _open_layer(self, file: Path) -> Any | None:
        sink, limit = self._context.sink, self._context.limits.asset_bytes
        place = Location(str(file))
        try:
            with open_regular(file) as stream:
                head = stream.read(8)
            size = file.stat().st_size
        except OSError as error:
            sink.report("SC430", f"the file cannot be read: {error.strerror or error}", place)
            return None
        self._bytes += size
        if head not in _MAGIC:
            sink.report("SC430", "the content does not match the suffix: neither USD text nor USD crate", place)
        elif size > limit or self._bytes > _OPENED_LIMIT * limit:
            message = f"the file has {size} bytes; the limit `asset_bytes` is {limit}"
            sink.report("SC430", message, place, hint="raise the limit with --limit asset_bytes=N")
        elif len(self.uris) > _MAX_LAYERS:
            sink.report("SC430", f"the stage has more than {_MAX_LAYERS} layers", place)
        else:
            try:
                layer = self._sdf.Layer.FindOrOpen(str(file))
            except self.error as error:
                self.report_unreadable(file, error)
                return None
            if layer is not None:
                return layer
            sink.report("SC430", "usd-core cannot read the file", place)
        return None

    def report_unreadable(self, file: Path, error: Exception) -> None:
        """Reports an exception that usd-core raised while reading a file."""
        try:
            text = str(error)
        except UnicodeDecodeError:  # usd-core quotes bytes of the file
            text = "it contains text that is not UTF-8"
        found = _PARSE_ERROR.search(text)
        words = (int(found[1]), int(found[2]), found[3]) if found else (None, None, text.rpartition(" : ")[2])
        place, message = Location(str(file), *words[:2]), cut(words[2].strip("' \n"))
        self._context.sink.report("SC430", f"usd-core cannot read the file: {message}", place)


def _line_of(file: Path, name: str) -> int | None:
    """Returns the first line of a text layer that names an asset."""
    text = file.read_bytes()
    at = text.find(f"@{name}@".encode()) if text.startswith(b"#usda") else -1
    return None if at < 0 else text.count(b"\n", 0, at) + 1


UNITS: Final[dict[str, Vec3]] = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
"""Axis, as UsdGeom and UsdPhysics name it → unit vector."""

UP_ROTATIONS: Final = {
    "X": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
    "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "Z": np.eye(3),
}

SHEAR_TOLERANCE: Final = 1e-5
"""Largest deviation of a matrix from a rotation and a scale, relative to its largest scale."""


def split_matrix(matrix: NDArray[np.float64]) -> tuple[Pose7, NDArray[np.float64]]:
    """Splits an affine matrix into a rigid part and a stretch.

    Args:
        matrix: (4, 4), for column vectors.

    Returns:
        The pose, and a symmetric (3, 3) `stretch` with matrix[:3, :3] = rotation · stretch. The stretch is diagonal
            without shear, and negative if the matrix mirrors.
    """
    left, _, right = np.linalg.svd(matrix[:3, :3])
    rotation = left @ right
    if np.linalg.det(rotation) < 0:
        rotation = -rotation
    pose = to_pose([*matrix[:3, 3], *from_matrix(rotation.tolist())])
    return pose, rotation.T @ matrix[:3, :3]


def scale_of(stretch: NDArray[np.float64]) -> Vec3 | None:
    """Returns the scale along x, y and z of a `stretch`; None if it shears."""
    scale = np.diag(stretch)
    if np.abs(stretch - np.diag(scale)).max() > SHEAR_TOLERANCE * np.abs(scale).max():
        return None
    x, y, z = scale.tolist()
    return x, y, z


class UsdFrames:
    """Frames of a stage.

    Attributes:
        metres: the stage's unit of length [m].
        kilograms: the stage's unit of mass [kg].
        up_axis: as authored: a key of `UP_ROTATIONS`, or an invalid value.
    """

    def __init__(self, stage: Prim, geom: Any, physics: Any, time: Any) -> None:
        """`geom`, `physics`: modules of usd-core. `time`: time of the transforms."""
        self.metres = float(geom.GetStageMetersPerUnit(stage))
        self.kilograms = float(physics.GetStageKilogramsPerUnit(stage))
        self.up_axis = str(geom.GetStageUpAxis(stage))
        self._turn = UP_ROTATIONS.get(self.up_axis, np.eye(3))
        self._cache = geom.XformCache(time)
        self._worlds: dict[Any, NDArray[np.float64]] = {}

    def world(self, prim: Prim) -> NDArray[np.float64]:
        """Returns the (4, 4) matrix from a prim's frame, in the stage's unit, to the world [m]."""
        path = prim.GetPath()
        found = self._worlds.get(path)
        if found is None:
            local = np.array(self._cache.GetLocalToWorldTransform(prim), np.float64).T
            found = self._worlds[path] = self.base() @ local
        return found

    def base(self) -> NDArray[np.float64]:
        """Returns the (4, 4) matrix from the stage's frame to the world."""
        matrix = np.eye(4)
        matrix[:3, :3] = self._turn * self.metres
        return matrix

    def pose(self, prim: Prim) -> Pose7:
        """Returns the world pose of a prim's frame, without its scale."""
        return split_matrix(self.world(prim))[0]

    def direction(self, vector: Iterable[float]) -> Vec3:
        """Rotates a direction from the stage to the world, without scaling."""
        x, y, z = (self._turn @ np.array(list(vector), np.float64)).tolist()
        return x, y, z

    def turned(self, pose: Pose7 | None, vector: Iterable[float]) -> Vec3:
        """Rotates a vector from a prim's frame to the world, without scaling. `pose`: of the frame; None: the stage."""
        if pose is None:
            return self.direction(vector)
        x, y, z = vector
        return rotate(pose[3:], (x, y, z))

    def frame_in(self, prim: Prim | None, position: Iterable[float], rotation: Any) -> Pose7:
        """Returns the world pose of a frame given relative to a prim.

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
    """Returns a usd-core quaternion as a unit [w, x, y, z]."""
    numbers = np.array([rotation.GetReal(), *rotation.GetImaginary()], np.float64)
    length = float(np.linalg.norm(numbers))
    w, x, y, z = (numbers / length).tolist() if length > 0 else IDENTITY
    return w, x, y, z


class UsdStage:
    """A stage.

    Attributes:
        stage: the usd-core stage.
        path: its file.
        place: the file, as the location of its content.
        layers: its checked layers.
        usd, geom, physics, shade, lux: modules of usd-core.
        time: time at which values are read: the earliest.
        frames: frames of its prims.
        meshes: reads its meshes.
        losses: content that the scene does not have.
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
        self.place = Location(str(path))
        self.losses: list[Loss] = []

    def prims(self) -> Iterator[Prim]:
        """Iterates over all active, loaded and defined prims, including those of instances, parents first."""
        return iter(self.usd.PrimRange.Stage(self.stage, self.usd.TraverseInstanceProxies()))

    def prim(self, path: Any) -> Prim:
        """Returns the prim at a path; invalid if there is none."""
        return self.stage.GetPrimAtPath(path)

    def value(self, prim: Prim, name: str, default: Any = None) -> Any:
        """Returns the value of an attribute; `default` if it has none."""
        attribute = prim.GetAttribute(name)
        found = attribute.Get(self.time) if attribute else None
        return default if found is None else found

    def authored(self, prim: Prim, name: str) -> Any:
        """Returns an authored value; None if the attribute has only the schema's default."""
        attribute = prim.GetAttribute(name)
        return attribute.Get(self.time) if attribute and attribute.HasAuthoredValue() else None

    def lose(self, kind: str, message: str, prim: Prim) -> None:
        """Adds a loss. `kind`, `message`: see `Loss`."""
        path = str(prim.GetPath())
        self.losses.append(Loss(kind, f"{message} ({path})", self.place, path))
