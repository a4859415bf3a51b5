"""Converts USD meshes, and solids without a scene equivalent, to OBJ files."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.obj import encode_obj
from scenecc.geometry.surfaces import revolved_surface
from scenecc.importers.meshes import MeshError
from scenecc.meshes.primitives import box

if TYPE_CHECKING:
    from numpy.typing import NDArray

Prim = Any
"""An object of usd-core, which is imported lazily and has no type hints."""

_CAP_STEPS: Final = 8
"""Steps from pole to equator of a round cap."""


@frozen
class UsdMesh:
    """A triangle mesh with separate indices for normals and texture coordinates.

    Attributes:
        points: (P, 3), in the prim's unit.
        faces: (F, 3), counterclockwise from outside.
        normals, uvs: (N, 3) and (U, 2), from an image's bottom left; None: not in the file.
        normal_faces, uv_faces: (F, 3), indices into them.
        sources: (F,), index of each triangle's face in the prim.
    """

    points: NDArray[np.float64]
    faces: NDArray[np.int64]
    sources: NDArray[np.int64]
    normals: NDArray[np.float64] | None = None
    normal_faces: NDArray[np.int64] | None = None
    uvs: NDArray[np.float64] | None = None
    uv_faces: NDArray[np.int64] | None = None

    def part(self, faces: NDArray[np.bool_]) -> UsdMesh:
        """Returns some of the triangles, with all points. `faces`: (F,) mask."""
        return UsdMesh(
            self.points,
            self.faces[faces],
            self.sources[faces],
            self.normals,
            None if self.normal_faces is None else self.normal_faces[faces],
            self.uvs,
            None if self.uv_faces is None else self.uv_faces[faces],
        )

    def moved(self, matrix: NDArray[np.float64]) -> UsdMesh:
        """Returns the mesh transformed by a (3, 3) matrix, which may mirror."""
        flip = slice(None, None, -1) if np.linalg.det(matrix) < 0 else slice(None)
        normals = self.normals
        if normals is not None:
            normals = normals @ np.linalg.inv(matrix)
            normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        return UsdMesh(
            self.points @ matrix.T,
            self.faces[:, flip],
            self.sources,
            normals,
            None if self.normal_faces is None else self.normal_faces[:, flip],
            self.uvs,
            None if self.uv_faces is None else self.uv_faces[:, flip],
        )

    def to_obj(self) -> bytes:
        """Returns an OBJ file, without unused points, normals and coordinates."""
        uvs = None if self.uvs is None or self.uv_faces is None else _select_used(self.uvs, self.uv_faces)
        normals = (
            None if self.normals is None or self.normal_faces is None else _select_used(self.normals, self.normal_faces)
        )
        return encode_obj(*_select_used(self.points, self.faces), uvs, normals)


def _select_used(values: NDArray[Any], indices: NDArray[np.int64]) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Returns the used values, in order and without negative zeros, and their new indices."""
    used, inverse = np.unique(indices, return_inverse=True)
    return values[used].astype(np.float32) + np.float32(0), inverse.reshape(indices.shape)


@dataclass(frozen=True, slots=True)
class UsdMeshReader:
    """Reads meshes of a stage. `geom`, `time`: module and time of usd-core."""

    geom: Any
    time: Any
    _made: dict[Any, UsdMesh] = field(default_factory=dict[Any, UsdMesh])

    def read(self, prim: Prim) -> UsdMesh:
        """Returns the triangles of a `Mesh` prim, in its own frame and unit.

        Raises:
            MeshError: indices or counts do not fit the points.
        """
        key = prim.GetPrimInPrototype().GetPath() if prim.IsInstanceProxy() else prim.GetPath()
        if key not in self._made:
            self._made[key] = self._read(prim)
        return self._made[key]

    def _read(self, prim: Prim) -> UsdMesh:
        mesh = self.geom.Mesh(prim)
        points = _array(mesh.GetPointsAttr().Get(self.time), np.float64).reshape(-1, 3)
        counts = _array(mesh.GetFaceVertexCountsAttr().Get(self.time), np.int64)
        indices = _array(mesh.GetFaceVertexIndicesAttr().Get(self.time), np.int64)
        if not len(points) or not len(counts):
            raise MeshError("it has no faces")
        if counts.min() < 0 or counts.sum() != len(indices):
            raise MeshError("`faceVertexCounts` does not match `faceVertexIndices`")
        if indices.min() < 0 or indices.max() >= len(points):
            raise MeshError("`faceVertexIndices` has an index beyond the points")
        if not np.isfinite(points).all():
            raise MeshError("`points` are not finite")
        holes = _array(mesh.GetHoleIndicesAttr().Get(self.time), np.int64)
        flipped = mesh.GetOrientationAttr().Get() == self.geom.Tokens.leftHanded
        corners, sources = _triangulate(counts, holes, flipped=flipped)
        if not len(corners):
            raise MeshError("it has no faces")
        normals = self._corner_values(mesh, "normals", 3, (indices, corners, sources), len(points))
        uvs = self._corner_values(mesh, "st", 2, (indices, corners, sources), len(points))
        return UsdMesh(points, indices[corners], sources, *normals, *uvs)

    def _corner_values(
        self, mesh: Any, name: str, width: int, faces: tuple[NDArray[np.int64], ...], points: int
    ) -> tuple[NDArray[np.float64] | None, NDArray[np.int64] | None]:
        """Returns values of a primvar and their (F, 3) indices; None, None if it is missing or does not fit."""
        indices, corners, sources = faces
        primvar = self.geom.PrimvarsAPI(mesh).GetPrimvar(name)
        if primvar and primvar.HasValue():
            values, kind = primvar.ComputeFlattened(self.time), str(primvar.GetInterpolation())
        elif name == "normals":
            values, kind = mesh.GetNormalsAttr().Get(self.time), str(mesh.GetNormalsInterpolation())
        else:
            return None, None
        rows = _array(values, np.float64).reshape(-1, width)
        found = {
            "vertex": (points, indices[corners]),
            "varying": (points, indices[corners]),
            "faceVarying": (len(indices), corners),
            "uniform": (int(sources.max()) + 1, np.repeat(sources[:, None], 3, axis=1)),
            "constant": (1, np.zeros_like(corners)),
        }.get(kind)
        if found is None or len(rows) < found[0] or not np.isfinite(rows).all():
            return None, None
        return rows, found[1]


def _array(values: Any, kind: Any) -> NDArray[Any]:
    return np.zeros(0, kind) if values is None else np.asarray(values, kind)


def _triangulate(
    counts: NDArray[np.int64], holes: NDArray[np.int64], *, flipped: bool
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Splits faces into triangle fans: (F, 3) indices of corners, and (F,) the face of each triangle."""
    starts = np.cumsum(counts) - counts
    fans = np.maximum(counts - 2, 0)
    fans[holes[(holes >= 0) & (holes < len(fans))]] = 0
    sources = np.repeat(np.arange(len(counts)), fans)
    step = np.arange(len(sources)) - np.repeat(np.cumsum(fans) - fans, fans)
    first = starts[sources]
    corners = np.stack([first, first + step + 1, first + step + 2], axis=1)
    return (corners[:, ::-1] if flipped else corners), sources


def solid_mesh(kind: str, axis: str, sizes: tuple[float, ...]) -> UsdMesh:
    """Returns the surface of a solid that no primitive can represent: scaled unevenly, sheared or tapered.

    Args:
        kind: "sphere" (radius), "box" (half size); or "tapered", "capsule" (lower radius, upper radius, half height),
            along `axis`.
        axis: "X", "Y" or "Z".
        sizes: sizes of the solid.
    """
    if kind == "box":
        surface = box()
        found = surface.vertices * sizes[0], surface.faces, surface.normals
    else:
        points, faces, normals, _ = revolved_surface(_profile(kind, sizes))
        turn = {"X": 0, "Y": 1, "Z": 2}[axis]
        found = np.roll(points, turn, axis=1), faces, np.roll(normals, turn, axis=1)
    points, faces, normals = found
    return UsdMesh(
        np.asarray(points, np.float64),
        np.asarray(faces, np.int64),
        np.arange(len(faces)),
        np.asarray(normals, np.float64),
        np.asarray(faces, np.int64),
    )


def _profile(kind: str, sizes: tuple[float, ...]) -> tuple[tuple[float, float], ...]:
    """Returns the outline (along, radius) of a solid of revolution about x."""
    if kind == "tapered":
        below, above, half = sizes
        outline = [(-half, 0.0), (-half, below), (half, above), (half, 0.0)]
    else:
        below, above, half = (sizes[0], sizes[0], 0.0) if kind == "sphere" else sizes
        rise = [each * math.pi / 2 / _CAP_STEPS for each in range(_CAP_STEPS + 1)]
        outline = [(-half - below * math.sin(each), below * math.cos(each)) for each in reversed(rise)]
        outline += [(half + above * math.sin(each), above * math.cos(each)) for each in rise]
    return tuple(dict.fromkeys((x, 0.0 if radius < 1e-12 else radius) for x, radius in outline))
