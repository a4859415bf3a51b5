"""Expected masses of bodies: masses by density and volume, with meshes cooked a second time."""

from __future__ import annotations

import math
from itertools import takewhile
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.assets import UNMIRRORED, AxisSigns, collision_file, decompose, mirror_mesh
from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.geometry import make_revolved_parts
from scenecc.backends.sapien.properties import select_rows
from scenecc.plan import ConvexParts, Cylinder, MeshGeometry, Plane, TriangleMesh
from scenecc.plan.geometry import RevolvedSolid, Solid
from scenecc.plan.properties import DEFAULT_DENSITY

if TYPE_CHECKING:
    from collections.abc import Hashable

    from numpy.typing import NDArray

    from scenecc.plan import BodyStructure, CollisionGeometry, ScenePlan, Value

MINIMUM_MASS = 1e-6
"""Mass [kg] that SAPIEN gives a body whose shapes weigh less."""

MASS_TOLERANCE = 1e-4
"""Relative tolerance between masses that the engine adds in float32 and masses in float64."""

MESH_TOLERANCE = 1e-2
"""Relative tolerance between a mesh's volumes by PhysX and by its triangles: hull polygons are not quite planar."""

CYLINDER_AREA_RATIO = 32 / (2 * math.pi) * math.sin(2 * math.pi / 32)
"""Ratio of the area of PhysX's 32-sided prism for a cylinder to that of its circumscribed circle."""

MeshKey = tuple[int, AxisSigns]
"""Index of a file in the plan, and the signs of its scale."""


class Volumes(NamedTuple):
    """Volume of a shape by its triangles, and by the mass that the engine computes [m³]; 0 for an inverted hull."""

    enclosed: float
    weighed: float


class CookedMeshes:
    """The meshes of a plan as cooked by PhysX, unscaled. Each is made and weighed once, as a fresh shape."""

    def __init__(self, plan: ScenePlan) -> None:
        self._plan = plan
        self._material: Any = physx.get_default_material()
        self._known: dict[Hashable, list[Volumes]] = {}

    def parts(self, geometry: MeshGeometry, mesh: MeshKey) -> list[Volumes]:
        """Returns the volumes of a mesh's shapes: several for `ConvexParts`, otherwise one."""
        key = (type(geometry), mesh, getattr(geometry, "coacd", None))
        if key not in self._known:
            self._known[key] = list(map(_weigh, self._load(geometry, *mesh)))
        return self._known[key]

    def revolved_parts(self, geometry: RevolvedSolid, row: int) -> list[Volumes]:
        """Returns the volumes of the convex parts of a solid of revolution, of unit size."""
        profile, _ = geometry.unit_profile(*geometry.sizes(row))
        if profile not in self._known:
            self._known[profile] = list(map(_weigh, make_revolved_parts(profile, UNMIRRORED, self._material)))
        return self._known[profile]

    def _load(self, geometry: MeshGeometry, file: int, signs: AxisSigns) -> list[Any]:
        asset, several = self._plan.files[file], isinstance(geometry, ConvexParts)
        if isinstance(geometry, ConvexParts) and geometry.coacd is not None:
            path = str(decompose(asset, geometry.coacd))
        else:
            path = str(collision_file(asset))
        if isinstance(geometry, TriangleMesh):
            return [physx.PhysxCollisionShapeTriangleMesh(path, UNMIRRORED, self._material, geometry.sdf)]
        hull = physx.PhysxCollisionShapeConvexMesh
        make = hull.load_multiple if several else hull
        made = make(mirror_mesh(path, signs, parts=several), UNMIRRORED, self._material)
        return made if several else [made]


def _weigh(shape: Any) -> Volumes:
    volume = enclosed_volume(shape)
    if not isinstance(shape, physx.PhysxCollisionShapeConvexMesh):
        volume = abs(volume)
    if not volume > 0:
        return Volumes(volume, 0.0)
    # The engine's minimum mass is a milligram. This density gives a kilogram, unless the mesh is wrong.
    shape.set_density(1 / volume)
    body = physx.PhysxRigidDynamicComponent()
    body.attach(shape)
    return Volumes(volume, body.mass * volume)


def enclosed_volume(shape: Any) -> float:
    """Returns the volume inside a closed mesh [m³]: the sum of signed tetrahedra from a vertex to each triangle."""
    vertices: NDArray[np.float64] = shape.vertices.astype(np.float64)
    # Written out, because `np.cross` takes seven times as long.
    x, y, z = (vertices - vertices[0]).T[:, shape.triangles.T]
    twice_areas = (y[1] * z[2] - y[2] * z[1], z[1] * x[2] - z[2] * x[1], x[1] * y[2] - x[2] * y[1])
    return float((x[0] * twice_areas[0] + y[0] * twice_areas[1] + z[0] * twice_areas[2]).sum() / 6)


def mesh_keys(geometry: MeshGeometry, rows: NDArray[np.intp]) -> list[MeshKey]:
    """Returns the mesh of each of these rows, or one for all."""
    files, scales = select_rows(geometry.file, rows), select_rows(geometry.scale, rows)
    count = max(len(files), len(scales))
    signs: list[AxisSigns] = [tuple(row) for row in np.broadcast_to(np.sign(scales), (count, 3)).tolist()]
    return list(zip(np.broadcast_to(files, count).tolist(), signs, strict=True))


def given_mass(structure: BodyStructure, rows: NDArray[np.intp]) -> list[float] | None:
    """Returns the mass [kg] that the plan sets for a body in each row. None: it follows from the shapes."""
    given = structure.mass if structure.inertial is None else structure.inertial.mass
    return None if given is None else _repeat_numbers(_columns(given, rows)[0], len(rows))


def shapes_mass(structure: BodyStructure, rows: NDArray[np.intp], meshes: CookedMeshes) -> list[float]:
    """Returns the mass [kg] of a body's shapes in each row, as SAPIEN computes it."""
    total: Any = 0.0
    # SAPIEN computes the mass again with each shape, which fails in PhysX once a shape is infinite.
    for shape in takewhile(lambda shape: not isinstance(shape.geometry, Plane), structure.collisions):
        density = DEFAULT_DENSITY if shape.density is None else _columns(shape.density, rows)[0]
        total = total + density * _volume(shape.geometry, rows, meshes)
    masses = _repeat_numbers(total, len(rows))
    if structure.body_type == "kinematic":
        # No force moves it, so its mass does not matter.
        return [max(mass, MINIMUM_MASS) for mass in masses]
    return [mass or MINIMUM_MASS for mass in masses]


def _volume(geometry: CollisionGeometry, rows: NDArray[np.intp], meshes: CookedMeshes) -> Any:
    """Returns the volume [m³]. In PhysX it is 0 for planes and for triangle meshes without an SDF."""
    if isinstance(geometry, Solid):
        volume = geometry.volume(*(column for value in geometry.values for column in _columns(value, rows)))
        return volume * CYLINDER_AREA_RATIO if isinstance(geometry, Cylinder) else volume
    if not isinstance(geometry, MeshGeometry) or (isinstance(geometry, TriangleMesh) and not geometry.sdf):
        return 0.0
    keys = mesh_keys(geometry, rows)
    volume_of = {key: sum(part.weighed for part in meshes.parts(geometry, key)) for key in dict.fromkeys(keys)}
    found = np.array([volume_of[mesh] for mesh in keys]) * np.abs(np.prod(select_rows(geometry.scale, rows), axis=1))
    return found if len(found) > 1 else found.item()


def _columns(value: Value, rows: NDArray[np.intp]) -> list[Any]:
    """Returns each component of a value: one number, which is faster than an array of it, or an array with all rows."""
    if not value.varies:
        return list(value.as_drawn())
    data = value.data[rows].astype(np.float64)
    return list(np.atleast_2d(data.T))


def _repeat_numbers(numbers: Any, count: int) -> list[float]:
    return numbers.tolist() if isinstance(numbers, np.ndarray) else [numbers] * count


def part_count(geometry: CollisionGeometry, row: int, meshes: CookedMeshes) -> int:
    """Returns how many engine shapes a shape of the plan becomes, in a row of its entity."""
    match geometry:
        case ConvexParts():
            (mesh,) = mesh_keys(geometry, np.array([row]))
            return len(meshes.parts(geometry, mesh))
        case RevolvedSolid():
            return len(meshes.revolved_parts(geometry, row))
        case _:
            return 1
