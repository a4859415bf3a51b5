"""Converts USD geometry prims to collision and visual shapes."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotation_arrays import pose_matrix
from scenecc.geometry.rotations import IDENTITY, Pose7, compose
from scenecc.importers.meshes import MeshError
from scenecc.importers.numbers import along_x
from scenecc.importers.usd_meshes import UsdMesh, solid_mesh
from scenecc.importers.usd_stage import UNITS, Prim, UsdStage, scale_of, split_matrix
from scenecc.robots.description import Geometry, MeshCollision, MeshGeometry, PlaneGeometry, SolidGeometry
from scenecc.robots.solids import EXACT_SOLIDS, SolidMass, exact_mass

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Vec3

SOLID_TYPES: Final = ("Cube", "Sphere", "Capsule", "Cylinder", "Cone", "Capsule_1", "Cylinder_1", "Plane", "Mesh")
"""Prims with a surface that a scene can represent."""

_SIZES: Final = ("size", "radius", "radiusBottom", "width", "length")
"""Sizes that must be above 0. A capsule may have height 0, a tapered cylinder top radius 0."""

_NO_VOLUME: Final = 1e-30
"""Below this determinant a scale makes a solid flat."""

_EVEN: Final = 1e-4
"""Relative difference up to which two scales count as equal."""

_EQUAL: Final = 1e-7
"""Rounding error of the scale of a mesh."""

_AXES: Final = {"X": 0, "Y": 1, "Z": 2}

_APPROXIMATIONS: Final[dict[str, MeshCollision]] = {
    "convexDecomposition": "coacd",
    "sdf": "sdf",
    "convexHull": "hull",
}
"""UsdPhysics's approximation → how a mesh collides. Others are triangles on a body that cannot move."""


@frozen
class UsdShape:
    """A prim as a shape.

    Attributes:
        geometry: its geometry.
        pose: in the body's frame.
        mass: exact mass properties with density 1; None: no volume.
        exact: whether the engine computes the same volume as `mass`.
    """

    geometry: Geometry
    pose: Pose7
    mass: SolidMass | None = None
    exact: bool = True


class UsdShapeReader:
    """Converts prims to shapes.

    Args:
        stage: the stage.
    """

    def __init__(self, stage: UsdStage) -> None:
        self._stage = stage

    def collider(self, prim: Prim, body: Pose7, *, moves: bool, approximation: str) -> list[UsdShape]:
        """Returns the shapes of a collider; empty if it cannot be built, which is reported as a loss.

        Args:
            prim: a prim with `CollisionAPI`.
            body: pose of its body in the world.
            moves: whether the body is dynamic.
            approximation: UsdPhysics's approximation of a mesh.
        """
        kind = str(prim.GetTypeName())
        if kind == "Mesh":
            found = self._mesh_collider(prim, body, moves=moves, approximation=approximation)
            return [] if found is None else [found]
        if kind == "Points":
            return self._points(prim, body)
        found = self.solid(prim, body)
        return [] if found is None else [found]

    def read_mesh(self, prim: Prim) -> UsdMesh | None:
        """Returns the triangles of a mesh; None if its data is invalid, which is reported as a loss."""
        try:
            return self._stage.meshes.read(prim)
        except MeshError as fault:
            self._stage.lose("visuals", f"a mesh: {fault}", prim)
            return None

    def mesh_shape(
        self, prim: Prim, mesh: UsdMesh, body: Pose7, collision: MeshCollision | None = None, suffix: str = ""
    ) -> UsdShape:
        """Returns a mesh as a shape with a file. `suffix`: of the file's name."""
        pose, scale, mesh = self._place(mesh, prim, body)
        return UsdShape(self._geometry(prim, mesh, scale, collision, suffix), pose)

    def _place(self, mesh: UsdMesh, prim: Prim, body: Pose7) -> tuple[Pose7, tuple[float, float, float], UsdMesh]:
        """Returns pose and scale of a mesh in its body. Shear and mirroring are applied to the points."""
        pose, stretch = self._local(prim, body)
        scale = scale_of(stretch)
        if scale is not None and min(scale) > 0:
            is_even = max(scale) - min(scale) <= _EQUAL * max(scale)
            x, y, z = (scale[0] if is_even else each for each in scale)
            return pose, ((1.0, 1.0, 1.0) if is_even and abs(x - 1) <= _EQUAL else (x, y, z)), mesh
        return pose, (1.0, 1.0, 1.0), mesh.moved(stretch)

    def _geometry(
        self, prim: Prim, mesh: UsdMesh, scale: Vec3, collision: MeshCollision | None, suffix: str = ""
    ) -> MeshGeometry:
        name = prim.GetParent().GetName() if prim.GetName().lower() in {"mesh", "geometry", "geom"} else prim.GetName()
        return MeshGeometry(f"{name}{suffix}.obj", self._stage.path, scale, collision, data=mesh.to_obj())

    def _local(self, prim: Prim, body: Pose7) -> tuple[Pose7, NDArray[np.float64]]:
        """Returns the pose of a prim in its body and its `stretch`, see `split_matrix`."""
        return split_matrix(np.linalg.inv(pose_matrix(body)) @ self._stage.frames.world(prim))

    def solid(self, prim: Prim, body: Pose7) -> UsdShape | None:
        """Returns the shape of a prim that is not a mesh; None if it cannot be built, which is reported as a loss."""
        kind = str(prim.GetTypeName())
        pose, stretch = self._local(prim, body)
        value = self._stage.value
        sizes = [value(prim, name) for name in _SIZES if prim.HasAttribute(name)]
        if abs(np.linalg.det(stretch)) < _NO_VOLUME or not all(0 < each < math.inf for each in sizes):
            self._stage.lose("colliders", "a solid with a size or scale that is not above 0", prim)
            kind = ""
        match kind:
            case "Plane":
                return self._plane(prim, pose, scale_of(stretch) or (1.0, 1.0, 1.0))
            case "Cube":
                return self._box(prim, pose, stretch)
            case "Sphere":
                return self._sphere(prim, pose, stretch)
            case "Capsule" | "Cylinder" | "Cone":
                return self._round(prim, kind.lower(), pose, stretch, value(prim, "radius"))
            case "Capsule_1" | "Cylinder_1":
                sizes = (value(prim, "radiusBottom"), value(prim, "radiusTop"), value(prim, "height") / 2)
                even = sizes[0] == sizes[1]
                solid = kind[:-2].lower() if even or kind == "Capsule_1" else "tapered"
                return (
                    self._round(prim, solid, pose, stretch, sizes[0])
                    if even
                    else self._as_mesh(prim, solid, sizes, pose, stretch)
                )
            case _:
                pass
        return None

    def _box(self, prim: Prim, pose: Pose7, stretch: NDArray[np.float64]) -> UsdShape:
        half, scale = self._stage.value(prim, "size") / 2, scale_of(stretch)
        if scale is None:
            return self._as_mesh(prim, "box", (half,), pose, stretch)
        x, y, z = scale
        return _solid("box", (abs(half * x), abs(half * y), abs(half * z)), pose)

    def _sphere(self, prim: Prim, pose: Pose7, stretch: NDArray[np.float64]) -> UsdShape:
        radius, scale = self._stage.value(prim, "radius"), scale_of(stretch)
        if scale is None or not _is_even(scale):
            return self._as_mesh(prim, "sphere", (radius,), pose, stretch)
        return _solid("sphere", (radius * abs(scale[0]),), pose)

    def _round(self, prim: Prim, kind: str, pose: Pose7, stretch: NDArray[np.float64], radius: float) -> UsdShape:
        half, axis = self._stage.value(prim, "height") / 2, str(self._stage.value(prim, "axis"))
        scale = scale_of(stretch)
        across: tuple[float, ...] = tuple(each for k, each in enumerate(scale or ()) if k != _AXES[axis])
        if scale is None or not _is_even(across) or (kind == "cone" and scale[_AXES[axis]] < 0):
            above = 0.0 if kind == "cone" else radius
            return self._as_mesh(
                prim, "capsule" if kind == "capsule" else "tapered", (radius, above, half), pose, stretch
            )
        along, radius, half = abs(scale[_AXES[axis]]), radius * abs(across[0]), half * abs(scale[_AXES[axis]])
        if kind == "capsule" and not _is_even((along, *across)):
            self._stage.lose("hulls", "the caps of a stretched capsule, which stay round", prim)
        return _solid(kind, (radius, half), compose(pose, along_x(UNITS[axis])))

    def _plane(self, prim: Prim, pose: Pose7, scale: tuple[float, float, float]) -> UsdShape:
        """Returns a plane. Its normal is its axis; its visible size is along the plane's y and z."""
        axis = str(self._stage.value(prim, "axis"))
        width, length = (self._stage.value(prim, name) / 2 * abs(scale[0]) for name in ("width", "length"))
        sides = (width, length) if axis == "Y" else (length, width)
        return UsdShape(PlaneGeometry(sides), compose(pose, along_x(UNITS[axis])))

    def _points(self, prim: Prim, body: Pose7) -> list[UsdShape]:
        pose, stretch = self._local(prim, body)
        geom = self._stage.geom.Points(prim)
        points = np.asarray(geom.GetPointsAttr().Get(self._stage.time), np.float64).reshape(-1, 3)
        widths = np.asarray(geom.GetWidthsAttr().Get(self._stage.time), np.float64)
        scale = scale_of(stretch)
        if scale is None or not _is_even(scale) or len(widths) not in {1, len(points)}:
            self._stage.lose("colliders", "points with uneven scale or without width", prim)
            return []
        found: list[UsdShape] = []
        for point, width in zip(points, np.broadcast_to(widths, len(points)), strict=True):
            x, y, z = (stretch @ point).tolist()
            radius = float(width) / 2 * abs(scale[0])
            at = compose(pose, (x, y, z, *IDENTITY))
            found.append(_solid("sphere", (radius,), at))
        return found

    def _as_mesh(
        self, prim: Prim, kind: str, sizes: tuple[float, ...], pose: Pose7, stretch: NDArray[np.float64]
    ) -> UsdShape:
        """Returns a solid with a scale that no primitive can have, as a convex mesh."""
        axis = "X" if kind in {"box", "sphere"} else str(self._stage.value(prim, "axis"))
        mesh = solid_mesh(kind, axis, sizes).moved(stretch)
        self._stage.lose(
            "hulls", f"a {prim.GetTypeName()} that is scaled unevenly or tapered; it becomes a convex mesh", prim
        )
        geometry = self._geometry(prim, mesh, (1.0, 1.0, 1.0), "hull")
        return UsdShape(geometry, pose, mesh_mass(mesh, pose, np.eye(3)), exact=kind == "box")

    def _mesh_collider(self, prim: Prim, body: Pose7, *, moves: bool, approximation: str) -> UsdShape | None:
        mesh = self.read_mesh(prim)
        if mesh is None:
            self._stage.lose("colliders", "a collider whose mesh cannot be read", prim)
            return None
        if approximation in {"boundingCube", "boundingSphere"}:
            return self._bounds(prim, mesh, body, approximation)
        if approximation == "meshSimplification":
            self._stage.lose("mesh-simplification", "the simplification of a collider; the whole mesh is used", prim)
        kind = _APPROXIMATIONS.get(approximation, "hull" if moves else "triangles")
        if kind == "hull" and approximation != "convexHull":
            self._stage.lose("hulls", "a triangle mesh on a moving body; it collides as its hull", prim)
        shape = self.mesh_shape(prim, mesh, body, kind)
        if kind == "triangles":
            return shape
        mass = mesh_mass(mesh, *self._local(prim, body), hull=kind == "hull")
        return replace(shape, mass=mass, exact=kind != "sdf")

    def _bounds(self, prim: Prim, mesh: UsdMesh, body: Pose7, approximation: str) -> UsdShape:
        """Returns the bounding box of a mesh in its own frame, or the bounding sphere."""
        pose, stretch = self._local(prim, body)
        points = mesh.points[np.unique(mesh.faces)] @ stretch.T
        low, high = points.min(axis=0), points.max(axis=0)
        x, y, z = ((low + high) / 2).tolist()
        at = compose(pose, (x, y, z, *IDENTITY))
        if approximation == "boundingSphere":
            return _solid("sphere", (float(np.linalg.norm(points - (low + high) / 2, axis=1).max()),), at)
        return _solid("box", tuple(((high - low) / 2).tolist()), at)


def _solid(kind: str, sizes: tuple[float, ...], pose: Pose7) -> UsdShape:
    geometry = SolidGeometry(kind, sizes)
    return UsdShape(geometry, pose, exact_mass(geometry, pose), exact=kind in EXACT_SOLIDS)


def _is_even(scale: tuple[float, ...]) -> bool:
    sizes = [abs(each) for each in scale]
    return max(sizes) - min(sizes) <= _EVEN * max(sizes)


def mesh_mass(mesh: UsdMesh, pose: Pose7, stretch: NDArray[np.float64], *, hull: bool = False) -> SolidMass | None:
    """Returns the mass of a mesh or of its hull, after a `stretch` and a pose; None without volume."""
    from importlib import import_module  # noqa: PLC0415

    used, faces = np.unique(mesh.faces, return_inverse=True)
    points, faces = mesh.points[used] @ stretch.T, faces.reshape(-1, 3)
    if hull:
        try:
            found = import_module("trimesh.convex").convex_hull(points)
        except (ImportError, ValueError, RuntimeError):  # QhullError is one: a flat mesh has no hull
            return None
        points, faces = np.asarray(found.vertices), np.asarray(found.faces)
    elif np.linalg.det(stretch) < 0:
        faces = faces[:, ::-1]
    moved = points @ pose_matrix(pose)[:3, :3].T + np.array(pose[:3])
    found = import_module("trimesh.triangles").mass_properties(moved[faces])
    volume = float(found["volume"])
    if not volume > 0:
        return None
    return SolidMass(volume, np.array(found["center_mass"]), np.array(found["inertia"]))
