"""Geometry of shapes: one dataclass per type, with volume and extent. Lengths in metres.

As in SAPIEN, round shapes have their axis along x and a plane's normal is +x. The language's `axis`, `normal` and
`offset` have become part of the shape's pose.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

from typing_extensions import override

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Vec3
    from scenecc.geometry.surfaces import Profile
    from scenecc.plan.value import Value


class Primitive:
    """A shape that is defined by its fields, without a file."""

    __slots__: ClassVar[tuple[str, ...]] = ()

    @property
    def values(self) -> tuple[Value, ...]:
        """The field values in order."""
        return tuple(getattr(self, name) for name in self.__slots__)

    def sizes(self, row: int) -> tuple[float, ...]:
        """All sizes as numbers, in a row of the entity."""
        return tuple(number for value in self.values for number in value.row(row).ravel().tolist())

    @classmethod
    def extent(cls, rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        """Half extents along the axes of a frame, (3,) [m]. `rotation`: (3, 3), the shape's in that frame."""
        raise NotImplementedError

    @classmethod
    def bounds(cls, rotation: NDArray[Any], *sizes: float) -> tuple[NDArray[Any], NDArray[Any]]:
        """Lower and upper corner of the bounding box in a frame, relative to the shape's origin, each (3,) [m]."""
        extent = cls.extent(rotation, *sizes)
        return -extent, extent


class Solid(Primitive):
    """A primitive that collides.

    `HOLES`: names of the sizes that reduce the volume.
    """

    __slots__ = ()

    HOLES: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def volume(cls, *sizes: Any) -> Any:
        """Volume [m³], for numbers or for arrays with one number per scene."""
        raise NotImplementedError


@frozen
class Box(Solid):
    """`half_size`: (·, 3), along x, y and z [m]."""

    half_size: Value

    @classmethod
    @override
    def volume(cls, *sizes: Any) -> Any:
        x, y, z = sizes
        return 8 * (x * y * z)

    @classmethod
    @override
    def extent(cls, rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        return abs(rotation) @ sizes


@frozen
class Sphere(Solid):
    """`radius`: (·,) [m]."""

    radius: Value

    @classmethod
    @override
    def volume(cls, *sizes: Any) -> Any:
        (radius,) = sizes
        return 4 / 3 * math.pi * radius**3

    @classmethod
    @override
    def extent(cls, rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        return abs(rotation[:, 0]) * 0 + sizes[0]


@frozen
class Capsule(Solid):
    """`radius` and `half_length` (without the caps): (·,) [m]."""

    radius: Value
    half_length: Value

    @classmethod
    @override
    def volume(cls, *sizes: Any) -> Any:
        radius, half_length = sizes
        return math.pi * radius**2 * (2 * half_length + 4 / 3 * radius)

    @classmethod
    @override
    def extent(cls, rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        radius, half_length = sizes
        return abs(rotation[:, 0]) * half_length + radius


@frozen
class Cylinder(Solid):
    """`radius` and `half_length`: (·,) [m]."""

    radius: Value
    half_length: Value

    @classmethod
    @override
    def volume(cls, *sizes: Any) -> Any:
        radius, half_length = sizes
        return math.pi * radius**2 * 2 * half_length

    @classmethod
    @override
    def extent(cls, rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        radius, half_length = sizes
        along = abs(rotation[:, 0])
        return along * half_length + radius * (1 - along**2).clip(0) ** 0.5


SOLIDS: Final[dict[str, type[Solid]]] = {"box": Box, "sphere": Sphere, "capsule": Capsule, "cylinder": Cylinder}
"""Solids by their name in the language, in SAPIEN and in other formats."""

SIDES: Final = 32
"""Segments of a circle in `geometry.surfaces`, as in SAPIEN's cylinders. That module repeats the number, since exported
scripts contain its functions verbatim.
"""


class RevolvedSolid(Solid):
    """A solid of revolution about its own x, for which SAPIEN has no shape: it collides as convex meshes of 32 sides.

    Its volume is that of these meshes.
    """

    __slots__ = ()

    @classmethod
    def profile(cls, *sizes: Any) -> tuple[tuple[Any, Any], ...]:
        """The convex polygon (x, radius) [m] that is turned about x; its outer side runs along +x."""
        raise NotImplementedError

    def surface(self, row: int) -> tuple[NDArray[Any], ...]:
        """Vertices, triangles, normals and texture coordinates in a row of its entity: see `revolved_surface`."""
        from scenecc.geometry.surfaces import revolved_surface  # noqa: PLC0415 - loaded where there is one

        return revolved_surface(self.profile(*self.sizes(row)))

    @classmethod
    def unit_profile(cls, *sizes: float) -> tuple[Profile, Vec3]:
        """The profile at length and radius 1 around the origin, and the scale to the actual size.

        The engine cooks small meshes badly, but scales them well.
        """
        profile = cls.profile(*sizes)
        half_length, radius = max(x for x, _ in profile), max(radius for _, radius in profile)
        return tuple((x / half_length, y / radius) for x, y in profile), (half_length, radius, radius)

    @classmethod
    @override
    def volume(cls, *sizes: Any) -> Any:
        profile = cls.profile(*sizes)
        edges = zip(profile, (*profile[1:], profile[0]), strict=True)
        area = SIDES / 2 * math.sin(2 * math.pi / SIDES)
        return abs(area / 3 * sum((b - a) * (r * r + r * s + s * s) for (a, r), (b, s) in edges))

    @classmethod
    @override
    def extent(cls, rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        low, high = cls.bounds(rotation, *sizes)
        return abs(low).clip(abs(high))

    @classmethod
    @override
    def bounds(cls, rotation: NDArray[Any], *sizes: float) -> tuple[NDArray[Any], NDArray[Any]]:
        from scenecc.geometry.surfaces import revolved_points  # noqa: PLC0415 - loaded where there is one

        points = revolved_points(cls.profile(*sizes)).reshape(-1, 3) @ rotation.T
        return points.min(axis=0), points.max(axis=0)


@frozen
class Cone(RevolvedSolid):
    """`radius` of the base and `half_length`: (·,) [m]. The tip is at +x, the origin halfway along the axis."""

    radius: Value
    half_length: Value

    @classmethod
    @override
    def profile(cls, *sizes: Any) -> tuple[tuple[Any, Any], ...]:
        radius, half_length = sizes
        return (-half_length, 0 * radius), (-half_length, radius), (half_length, 0 * radius)


@frozen
class Ring(RevolvedSolid):
    """`inner_radius` of the hole, `outer_radius` and `half_length`: (·,) [m]."""

    HOLES: ClassVar[tuple[str, ...]] = ("inner_radius",)

    inner_radius: Value
    outer_radius: Value
    half_length: Value

    @classmethod
    @override
    def profile(cls, *sizes: Any) -> tuple[tuple[Any, Any], ...]:
        inner, outer, half_length = sizes
        return (-half_length, inner), (-half_length, outer), (half_length, outer), (half_length, inner)


REVOLVED_SOLIDS: Final = {"cone": Cone, "ring": Ring}
"""Solids that only the language has, by name."""

SOLID_SIZES: Final = frozenset(name for solid in (SOLIDS | REVOLVED_SOLIDS).values() for name in solid.__slots__)
"""Names of the sizes of all solids. All are lengths."""

LYING_SOLIDS: Final = ("capsule", "cylinder")
"""Solids with their axis along x. Most other formats use z."""


@frozen
class Plane:
    """An infinite colliding half space below the plane x = 0.

    `every_scene`: build one per scene in a shared GPU simulation, even if all are equal.
    """

    every_scene: bool = False


@frozen
class VisualPlane(Primitive):
    """The visual of a plane. `half_size`: (·, 2), along y and z [m]."""

    half_size: Value

    @classmethod
    @override
    def extent(cls, rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        return Box.extent(rotation, 0.0, *sizes)


@frozen
class ConvexMesh:
    """The convex hull of a file. `file`: (·,) index into `ScenePlan.files`; `scale`: (·, 3), mirrored if negative."""

    file: Value
    scale: Value


@frozen
class CoacdParams:
    """Arguments of CoACD. Defaults are those of `sapien.wrapper.coacd.do_coacd`."""

    threshold: float | None = None
    max_convex_hull: int | None = None
    preprocess_mode: Literal["auto", "on", "off"] | None = None
    preprocess_resolution: int | None = None
    resolution: int | None = None
    mcts_nodes: int | None = None
    mcts_iterations: int | None = None
    mcts_max_depth: int | None = None
    pca: bool | None = None
    merge: bool | None = None
    seed: int | None = None


@frozen
class ConvexParts:
    """Several convex meshes from one file, SAPIEN's "multiple convex meshes".

    `coacd`: None uses the file's connected components; otherwise CoACD decomposes the mesh.
    """

    file: Value
    scale: Value
    coacd: CoacdParams | None = None


@frozen
class TriangleMesh:
    """A non-convex mesh. `sdf`: cook a signed distance field, required for a dynamic body."""

    file: Value
    scale: Value
    sdf: bool = False


@frozen
class Mesh:
    """A visual mesh. `file`: (·,) index into `ScenePlan.files`; `scale`: (·, 3), mirrored if negative."""

    file: Value
    scale: Value


Heights = tuple[tuple[float, ...], ...]
"""Rows of numbers."""


@frozen
class Heightfield:
    """A static terrain of triangles. Heights from a file are stored as numbers.

    `size`: (·, 3), extents along x and y, and the z of a height of 1 [m]; `heights`: rows from +y to -y, each from -x
    to +x.
    """

    size: Value
    heights: Heights

    @property
    def values(self) -> tuple[Value, ...]:
        """The fields that may vary by scene."""
        return (self.size,)

    def surface(self, row: int) -> tuple[NDArray[Any], ...]:
        """Vertices, triangles, normals and texture coordinates in a row of its entity: see `heightfield_surface`."""
        from scenecc.geometry.surfaces import heightfield_surface  # noqa: PLC0415 - loaded where there is one

        return heightfield_surface(self.size.row(row), self.heights)


@frozen
class TiledPlane(Primitive):
    """A flat quad facing +z with a repeated texture: ManiSkill's tiled plane.

    `half_size`: (·, 2), along x and y [m]; `texture_repeat`: (·, 2), repetitions along x and y.
    """

    half_size: Value
    texture_repeat: Value

    @classmethod
    @override
    def extent(cls, rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        return Box.extent(rotation, *sizes[:2], 0.0)


CollisionGeometry = (
    Box | Sphere | Capsule | Cylinder | Cone | Ring | Plane | ConvexMesh | ConvexParts | TriangleMesh | Heightfield
)
VisualGeometry = Box | Sphere | Capsule | Cylinder | Cone | Ring | VisualPlane | Mesh | TiledPlane | Heightfield
MeshGeometry = ConvexMesh | ConvexParts | TriangleMesh | Mesh
"""Geometries from a file, with a `file` and a `scale`."""


MAX_HEIGHTS: Final = 262_144
"""Maximum for a heightfield: 512 × 512."""

MAX_TOTAL_HEIGHTS: Final = 16 * MAX_HEIGHTS
"""Maximum for all heightfields of a document, counted once per use."""


def heights_fault(heights: Heights) -> str | None:
    """Why the rows do not form a grid of heights, or None."""
    if len(heights) < 2 or len(heights[0]) < 2:
        return "a grid has two rows and two columns at least"
    odd = next((number for number, row in enumerate(heights) if len(row) != len(heights[0])), None)
    return None if odd is None else f"row 0 has {len(heights[0])} heights, and row {odd} has {len(heights[odd])}"
