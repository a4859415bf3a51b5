"""Meshes as the engine has them for a file: read once a file, for volumes, counts and vertices."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.geometry import COLLISION_SIZES
from scenecc.backends.sapien.decomposition import decompose
from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.mirrored import AS_IT_IS, Signs, mirrored, signs_of
from scenecc.plan import ConvexMesh, ConvexParts, TriangleMesh

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from numpy.typing import NDArray

    from scenecc.plan import CoacdParams, CollisionGeometry, ScenePlan

_UNIT = (1.0, 1.0, 1.0)


class Meshes:
    """Fresh shapes of the files that a plan uses, unscaled.

    Vertices and volumes are read from shapes made here and not by the builder, so that what the
    builder made can be held against them.
    """

    def __init__(self, plan: ScenePlan, material: Any) -> None:
        self._plan = plan
        self._material = material
        self._known: dict[Hashable, Any] = {}

    def hull(self, file: int, signs: Signs = AS_IT_IS) -> Any:
        """The convex hull of a file, as `signs` mirror it."""
        path = self._hull_path(file, signs)
        make = physx.PhysxCollisionShapeConvexMesh
        return self._once(("hull", path), lambda: make(path, _UNIT, self._material))

    def parts(self, file: int, params: CoacdParams | None, signs: Signs = AS_IT_IS) -> list[Any]:
        """The convex parts of a file, as `signs` mirror them."""
        path = self._parts_path(file, params, signs)
        load = physx.PhysxCollisionShapeConvexMesh.load_multiple
        return self._once(("parts", path), lambda: load(path, _UNIT, self._material))

    def triangles(self, file: int, *, sdf: bool) -> Any:
        """The triangles of a file. `sdf` as the plan has it: what PhysX has cooked of the file is found again."""
        make = physx.PhysxCollisionShapeTriangleMesh
        key = ("triangles", file, sdf)
        return self._once(key, lambda: make(self._path(file), _UNIT, self._material, sdf))

    def fresh(self, geometry: CollisionGeometry, row: int) -> list[Any]:
        """New shapes of an entity's row, of the engine's own density and without a pose."""
        kind, sizes = COLLISION_SIZES[type(geometry)]
        given: dict[str, Any] = {**sizes(geometry, row), "material": self._material}
        match geometry:
            case ConvexMesh(file=file, scale=scale):
                given["filename"] = self._hull_path(int(file.row(row)), signs_of(scale, row))
            case TriangleMesh(file=file, sdf=sdf):
                given |= {"filename": self._path(int(file.row(row))), "sdf": sdf}
            case ConvexParts(file=file, scale=scale, coacd=coacd):
                path = self._parts_path(int(file.row(row)), coacd, signs_of(scale, row))
                return kind.load_multiple(filename=path, **given)
            case _:
                pass
        return [kind(**given)]

    def hull_volume(self, file: int) -> float:
        """[m³] of the hull of a file, unscaled."""
        return self._once(("hull volume", file), lambda: enclosed(self.hull(file)))

    def parts_volume(self, file: int, params: CoacdParams | None) -> float:
        """[m³] of all convex parts of a file, unscaled."""
        return self._once(("parts volume", file, params), lambda: sum(map(enclosed, self.parts(file, params))))

    def triangle_volume(self, file: int) -> float:
        """[m³] that the triangles of a file, cooked with a field, enclose unscaled, whichever way they face."""
        return self._once(("triangle volume", file), lambda: abs(enclosed(self.triangles(file, sdf=True))))

    def _path(self, file: int) -> str:
        return str(self._plan.files[file].path)

    def _hull_path(self, file: int, signs: Signs) -> str:
        return self._once(("hull path", file, signs), lambda: mirrored(self._path(file), signs, parts=False))

    def _parts_path(self, file: int, params: CoacdParams | None, signs: Signs) -> str:
        def path() -> str:
            whole = self._plan.files[file]
            return mirrored(str(whole.path if params is None else decompose(whole, params)), signs, parts=True)

        return self._once(("path", file, params, signs), path)

    def _once(self, key: Hashable, make: Callable[[], Any]) -> Any:
        if key not in self._known:
            self._known[key] = make()
        return self._known[key]


def enclosed(shape: Any) -> float:
    """[m³] inside a closed mesh: the sum of signed tetrahedra from the origin to each triangle."""
    vertices: NDArray[np.float64] = shape.vertices.astype(np.float64)
    a, b, c = (vertices[shape.triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)
