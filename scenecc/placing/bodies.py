"""The collision shapes of a plan's entities as convex parts, over the scenes of a batch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.assets.measures import hull_parts, weld
from scenecc.assets.meshes import checked_content, read_triangles
from scenecc.geometry import rotation_arrays
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.geometry.surfaces import revolved_parts
from scenecc.geometry.triangles import join_parts
from scenecc.placing.distances import Cores
from scenecc.plan import BodyStructure
from scenecc.plan.body import DEFAULT_COLLISION_GROUPS
from scenecc.plan.geometry import (
    REVOLVED_SOLIDS,
    Box,
    Capsule,
    ConvexMesh,
    ConvexParts,
    Cylinder,
    Heightfield,
    Plane,
    RevolvedSolid,
    Sphere,
    TriangleMesh,
)
from scenecc.plan.link_poses import link_poses

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotation_arrays import Floats, Indices
    from scenecc.plan import AssetFile, CollisionGeometry, Entity, Value
    from scenecc.plan.articulation import ArticulationStructure
    from scenecc.variation.evaluation import Batch


_CHUNK: Final = 500_000
"""Number of body-triangle pairs that are processed together."""


class UnsupportedShapeError(Exception):
    """A collision shape that placement does not support."""


@dataclass(slots=True)
class Part:
    """A convex part of an entity over the scenes of a batch (B rows), in the entity's own frame.

    Attributes:
        there: whether it exists in each scene (B,).
        half, disk, margin, scale: as in `Cores`.
        points: points of the hull (k, 3) [m]; None if it has none.
        turn, p: rotations (B, 3, 3) and origins (B, 3) [m].
        reach: maximum distance from its own origin (B,) [m].
        groups: SAPIEN's four collision group integers (B, 4).
        is_plane: whether it is the half-space below its own x = 0.
        triangles: for a non-convex mesh, indices into `points` (t, 3); None: it is convex.
        link: link of an articulation; None for a body.
    """

    there: NDArray[np.bool_]
    half: Floats
    disk: Floats
    margin: Floats
    scale: Floats
    points: Floats | None
    turn: Floats
    p: Floats
    reach: Floats
    groups: NDArray[np.int64]
    is_plane: bool = False
    link: str | None = None
    triangles: Indices | None = None

    def moved(self, turn: Floats, p: Floats) -> Part:
        """Returns the part in a parent frame with the given rotations (B, 3, 3) and origins (B, 3)."""
        placed = np.matmul(turn, self.p[:, :, None])[:, :, 0] + p
        return Part(
            self.there, self.half, self.disk, self.margin, self.scale, self.points,
            np.matmul(turn, self.turn), placed, self.reach, self.groups, self.is_plane, self.link,
            self.triangles,
        )  # fmt: skip

    def taken(self, rows: Indices) -> Part:
        """Returns some of its rows, in any order."""
        return Part(
            self.there[rows], self.half[rows], self.disk[rows], self.margin[rows], self.scale[rows], self.points,
            self.turn[rows], self.p[rows], self.reach[rows], self.groups[rows], self.is_plane, self.link,
            self.triangles,
        )  # fmt: skip

    def cores(self, rows: Indices) -> Cores:
        """Returns some of its rows as cores."""
        cloud = np.full(len(rows), -1 if self.points is None else 0)
        clouds = () if self.points is None else (self.points,)
        return Cores(
            self.half[rows], self.disk[rows], self.margin[rows], self.turn[rows], self.p[rows],
            cloud, self.scale[rows], clouds,
        )  # fmt: skip

    def triangle_cores(self, rows: Indices, number: Indices) -> Cores:
        """Returns some of its triangles, in some rows (n,), as cores."""
        assert self.points is not None
        assert self.triangles is not None
        corners = self.points[self.triangles[number]] * self.scale[rows][:, None]
        zero = np.zeros(len(rows))
        return Cores(
            np.zeros((len(rows), 3)), zero, zero, self.turn[rows], self.p[rows],
            np.full(len(rows), -1), self.scale[rows], (), corners,
        )  # fmt: skip

    def triangles_near(self, rows: Indices, p: Floats, reach: Floats) -> tuple[Indices, Indices]:
        """Returns pairs of rows (as indices into `rows`) and triangles that may be within `reach` (n,) of points (n,
        3), by the boxes around the triangles.
        """
        assert self.points is not None
        assert self.triangles is not None
        found: list[tuple[Indices, Indices]] = []
        chunk = max(1, _CHUNK // len(self.triangles))
        corners = self.points[self.triangles]
        least, most = corners.min(axis=1), corners.max(axis=1)
        for start in range(0, len(rows), chunk):
            some = rows[start : start + chunk]
            local = np.matmul((p[start : start + chunk] - self.p[some])[:, None], self.turn[some])[:, 0]
            scale = self.scale[some][:, None]
            ends = least * scale, most * scale
            low, high = np.minimum(*ends), np.maximum(*ends)
            away = np.maximum(np.maximum(low - local[:, None], local[:, None] - high), 0.0)
            far = reach[start : start + chunk]
            row, triangle = np.nonzero(np.einsum("ijk,ijk->ij", away, away) <= (far * far)[:, None])
            found.append((row + start, triangle))
        return np.concatenate([one for one, _ in found]), np.concatenate([one for _, one in found])

    def extent(self, direction: Floats) -> Floats:
        """Returns its extent in unit directions (B, 3), as a coordinate along them (B,) [m]."""
        local = np.matmul(direction[:, None, :], self.turn)[:, 0]
        if self.points is None:
            reach = np.einsum("ij,ij->i", np.abs(local), self.half) + self.margin
            reach = reach + self.disk * np.hypot(local[:, 1], local[:, 2])
        else:
            reach = ((local * self.scale) @ self.points.T).max(axis=1)
        return reach + np.einsum("ij,ij->i", direction, self.p)


def point_part(there: NDArray[np.bool_]) -> Part:
    """Returns a point at the origin in some scenes (B,), which collides with nothing."""
    count = len(there)
    zero, zeros = np.zeros(count), np.zeros((count, 3))
    turn = np.broadcast_to(np.eye(3), (count, 3, 3))
    return Part(there, zeros, zero, zero, np.ones((count, 3)), None, turn, zeros, zero, np.zeros((count, 4), np.int64))


def matrices(q: Floats) -> Floats:
    """Returns the rotation matrices (B, 3, 3) of quaternions (B, 4) of about unit length."""
    turned = rotation_arrays.rotation_matrix(rotation_arrays.normalized(q).T)
    return np.ascontiguousarray(np.moveaxis(turned, -1, 0))


def rows_of(value: Value, rows: Indices) -> NDArray[Any]:
    """Returns a value in some rows of its entity."""
    data = value.data
    return data[rows] if len(data) > 1 else np.broadcast_to(data[0], (len(rows), *data.shape[1:]))


def rows_in(scene_idxs: tuple[int, ...], scenes: NDArray[np.int64]) -> tuple[Indices, NDArray[np.bool_]]:
    """Returns the rows (B,) of an object in the scenes of a batch, and in which of these it exists."""
    known = np.array(scene_idxs, dtype=np.int64)
    rows = np.minimum(np.searchsorted(known, scenes), len(known) - 1)
    return rows, known[rows] == scenes


def entity_parts(entity: Entity, files: Sequence[AssetFile], batch: Batch) -> list[Part]:
    """Returns the collision parts of an entity in its own frame.

    Args:
        entity: an entity of a plan.
        files: files of the plan.
        batch: the scenes; evaluates the joint positions that a reset draws.

    Raises:
        UnsupportedShapeError: a shape is not supported.
        AssetError: a file cannot be read.
    """
    found: list[Part] = []
    for structure, rows, mine in _structures(entity, batch.scenes):
        if isinstance(structure, BodyStructure):
            if structure.body_type != "none":
                found += _body_parts(structure, files, rows, mine)
            continue
        for link, pose in zip(structure.links, _link_poses(structure, rows, mine, batch), strict=True):
            for part in _body_parts(link.body, files, rows, mine):
                moved = part.moved(matrices(pose[:, 3:]), pose[:, :3])
                moved.link = link.name
                found.append(moved)
    return found


def body_parts(entity: Entity, files: Sequence[AssetFile], scenes: NDArray[np.int64]) -> list[Part]:
    """Returns the collision parts, each in the frame of its own body or link. `scenes`: indices (B,)."""
    found: list[Part] = []
    for structure, rows, mine in _structures(entity, scenes):
        if isinstance(structure, BodyStructure):
            found += _body_parts(structure, files, rows, mine) if structure.body_type != "none" else ()
            continue
        for link in structure.links:
            for part in _body_parts(link.body, files, rows, mine):
                part.link = link.name
                found.append(part)
    return found


def _structures(
    entity: Entity, scenes: NDArray[np.int64]
) -> Iterator[tuple[BodyStructure | ArticulationStructure, Indices, NDArray[np.bool_]]]:
    """Yields the structures of an entity in some scenes (B,), its rows (B,), and which of them have the structure."""
    rows, there = rows_in(entity.scene_idxs, scenes)
    pick = None if entity.pick is None else rows_of(entity.pick, rows)
    for number, structure in enumerate(entity.structures):
        mine = there if pick is None else there & (pick == number)
        if mine.any():
            yield structure, rows, mine


def link_pose(entity: Entity, link: str, batch: Batch) -> Floats:
    """Returns the pose (B, 7) of a link in the frame of its articulation's root, at the initial joint positions."""
    rows, there = rows_in(entity.scene_idxs, batch.scenes)
    pick = np.zeros(len(rows)) if entity.pick is None else rows_of(entity.pick, rows)
    found = np.tile(np.array(IDENTITY_POSE), (len(rows), 1))
    for number, structure in enumerate(entity.structures):
        mine = there & (pick == number)
        if mine.any() and not isinstance(structure, BodyStructure):
            index = [one.name for one in structure.links].index(link)
            found[mine] = _link_poses(structure, rows, mine, batch)[index][mine]
    return found


def _link_poses(
    structure: ArticulationStructure, rows: Indices, there: NDArray[np.bool_], batch: Batch
) -> list[Floats]:
    """Returns the poses (B, 7) of links in the frame of the root, at the initial joint positions."""

    def data_of(value: Value) -> NDArray[Any]:
        if value.recipe is None:
            return rows_of(value, rows)
        data = np.zeros(len(rows))
        data[there] = batch.only(np.flatnonzero(there)).evaluate(value.recipe)
        return data

    return link_poses(structure, np.tile(np.array(IDENTITY_POSE), (len(rows), 1)), data_of)


def _body_parts(
    body: BodyStructure, files: Sequence[AssetFile], rows: Indices, there: NDArray[np.bool_]
) -> Iterator[Part]:
    count = len(rows)
    for shape, groups in zip(body.collisions, body.shape_groups(), strict=True):
        turn, p = np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3))
        if shape.pose is not None:
            pose = rows_of(shape.pose, rows)
            turn, p = matrices(pose[:, 3:]), np.asarray(pose[:, :3], np.float64)
        bits = np.tile(DEFAULT_COLLISION_GROUPS, (count, 1)) if groups is None else rows_of(groups, rows)
        for core in _cores_of(shape.geometry, files, rows):
            mine = there if core.there is None else there & core.there
            if not mine.any():
                continue
            zero = np.zeros(count)
            half = np.zeros((count, 3)) if core.half is None else core.half
            disk, margin = (zero if one is None else one for one in (core.disk, core.margin))
            scale = np.ones((count, 3)) if core.scale is None else core.scale
            reach = np.sqrt(half[:, 0] ** 2 + np.maximum(np.hypot(half[:, 1], half[:, 2]), disk) ** 2) + margin
            if core.points is not None:
                reach = np.abs(scale).max(axis=1) * np.sqrt((core.points**2).sum(axis=1).max())
            plane = isinstance(shape.geometry, Plane)
            yield Part(mine, half, disk, margin, scale, core.points, turn, p, reach, bits, plane, None, core.triangles)


@dataclass(slots=True)
class _Core:
    """A part in its shape's frame. None means 0, 1 or absent, as in `Part`."""

    half: Floats | None = None
    disk: Floats | None = None
    margin: Floats | None = None
    points: Floats | None = None
    scale: Floats | None = None
    triangles: Indices | None = None
    there: NDArray[np.bool_] | None = None


def _cores_of(geometry: CollisionGeometry, files: Sequence[AssetFile], rows: Indices) -> list[_Core]:
    """Returns the parts of a shape over the scenes of a batch."""
    found: list[_Core]
    match geometry:
        case Plane():
            found = [_Core()]
        case Box(half_size):
            found = [_Core(half=np.asarray(rows_of(half_size, rows), np.float64))]
        case Sphere(radius):
            found = [_Core(margin=rows_of(radius, rows))]
        case Capsule(radius, half_length):
            found = [_Core(half=_along_x(rows_of(half_length, rows)), margin=rows_of(radius, rows))]
        case Cylinder(radius, half_length):
            found = [_Core(half=_along_x(rows_of(half_length, rows)), disk=rows_of(radius, rows))]
        case RevolvedSolid() as solid if all(len(value.data) == 1 for value in solid.values):
            found = [_Core(points=points) for points in revolved_parts(solid.profile(*solid.sizes(0)))]
        case Heightfield() if len(geometry.size.data) == 1:
            vertices, triangles, *_ = geometry.surface(0)
            found = [_Core(points=np.asarray(vertices, np.float64), triangles=triangles)]
        case ConvexMesh() | TriangleMesh() | ConvexParts(coacd=None):
            found = list(_mesh_cores(geometry, files, rows))
        case _:
            raise UnsupportedShapeError(_UNSUPPORTED[type(geometry)])
    return found


_UNSUPPORTED: dict[type, str] = {
    ConvexParts: "convex parts from CoACD",
    Heightfield: "terrain whose size differs between scenes",
    **{solid: f"a {kind} whose size differs between scenes" for kind, solid in REVOLVED_SOLIDS.items()},
}


def _mesh_cores(
    geometry: ConvexMesh | ConvexParts | TriangleMesh, files: Sequence[AssetFile], rows: Indices
) -> Iterator[_Core]:
    which: Any = rows_of(geometry.file, rows)
    scale = np.asarray(rows_of(geometry.scale, rows), np.float64)
    numbers: list[int] = np.unique(which).tolist()
    for number in numbers:
        file, there = files[number], which == number
        if isinstance(geometry, ConvexParts):
            for points in connected_hulls(file):
                yield _Core(points=points, scale=scale, there=there)
            continue
        points, triangles = mesh_of(file)
        yield _Core(
            points=points, scale=scale, there=there,
            triangles=triangles if isinstance(geometry, TriangleMesh) else None,
        )  # fmt: skip


def _along_x(half_length: Floats) -> Floats:
    return np.stack([half_length, np.zeros(len(half_length)), np.zeros(len(half_length))], axis=1)


Mesh = tuple[Any, Any]
"""Vertices (V, 3) [m] and triangles (T, 3)."""


@lru_cache(maxsize=256)
def mesh_of(file: AssetFile) -> Mesh:
    """Returns a whole file as one mesh with merged vertices.

    Raises:
        AssetError: it cannot be read.
    """
    vertices, faces = join_parts([weld(*part) for part in read_triangles(checked_content(file))])
    points, index = np.unique(vertices.astype(np.float32).astype(np.float64), axis=0, return_inverse=True)
    return points, index.reshape(-1)[faces]


@lru_cache(maxsize=256)
def connected_hulls(file: AssetFile) -> tuple[Floats, ...]:
    """Returns the vertices of each convex part that SAPIEN makes of a file [m]."""
    parts = hull_parts(read_triangles(checked_content(file)), file.path.suffix.lower())
    return tuple(np.unique(vertices.astype(np.float32), axis=0).astype(np.float64) for vertices, _ in parts)
