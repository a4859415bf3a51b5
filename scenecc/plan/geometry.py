"""Geometry of shapes: one dataclass per type, with its volume and extent. Lengths in metres.

Round shapes lie along their own x axis and a plane's normal is its own +x, as in SAPIEN:
the language's `axis`, `normal` and `offset` are part of a shape's pose by now.
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
    """A shape that its fields alone make, as no file does."""

    __slots__: ClassVar[tuple[str, ...]] = ()

    @property
    def values(self) -> tuple[Value, ...]:
        """The fields in their order."""
        return tuple(getattr(self, name) for name in self.__slots__)

    def sizes(self, row: int) -> tuple[float, ...]:
        """The numbers of all fields in a row of its entity."""
        return tuple(number for value in self.values for number in value.row(row).ravel().tolist())

    @classmethod
    def extent(cls, rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        """How far it reaches from its centre along the axes of a frame, (3,) [m]. `rotation`: (3, 3), in that frame."""
        raise NotImplementedError

    @classmethod
    def bounds(cls, rotation: NDArray[Any], *sizes: float) -> tuple[NDArray[Any], NDArray[Any]]:
        """The lowest and the highest corner, seen from its centre, of the box around it in a frame, each (3,) [m]."""
        extent = cls.extent(rotation, *sizes)
        return -extent, extent


class Solid(Primitive):
    """A primitive that collides.

    `HOLES`: names of the sizes with which its volume falls.
    """

    __slots__ = ()

    HOLES: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def volume(cls, *sizes: Any) -> Any:
        """[m³], of numbers or of arrays with a number a scene."""
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
"""By what the language, SAPIEN and the formats of other programs call them."""

SIDES: Final = 32
"""Corners of a circle in `geometry.surfaces`, as of SAPIEN's cylinders. There it is a plain number, since exported
scripts contain those functions as they are written."""


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
        """The profile of a length and a radius of 1 around the origin, and the scale that gives it its size.

        The engine cooks small meshes badly, and scales them well.
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
    """`radius` of the base and `half_length`: (·,) [m]. The tip is at +x, the origin halfway up."""

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
"""By what the language calls them; no other format has them."""

SOLID_SIZES: Final = frozenset(name for solid in (SOLIDS | REVOLVED_SOLIDS).values() for name in solid.__slots__)
"""Names of the sizes of all solids, which are lengths."""

LYING_SOLIDS: Final = ("capsule", "cylinder")
"""Those along their own x; in most other formats they stand along z."""


@frozen
class Plane:
    """An endless colliding half space below the plane x = 0.

    `every_scene`: where scenes share one GPU simulation, build it in each although it is the same.
    """

    every_scene: bool = False


@frozen
class VisualPlane(Primitive):
    """What is seen of a plane. `half_size`: (·, 2), along its own y and z [m]."""

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
    """Arguments of CoACD; those left out are the defaults of `sapien.wrapper.coacd.do_coacd`."""

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
    """Several convex meshes of one file, SAPIEN's "multiple convex meshes".

    `coacd`: None takes the file's own connected parts; otherwise CoACD cuts the mesh first.
    """

    file: Value
    scale: Value
    coacd: CoacdParams | None = None


@frozen
class TriangleMesh:
    """A non-convex mesh. `sdf`: cook a signed distance field, which a dynamic body needs."""

    file: Value
    scale: Value
    sdf: bool = False


@frozen
class Mesh:
    """What a file shows. `file`: (·,) index into `ScenePlan.files`; `scale`: (·, 3), mirrored if negative."""

    file: Value
    scale: Value


Heights = tuple[tuple[float, ...], ...]
"""Rows of numbers."""


@frozen
class Heightfield:
    """Terrain of triangles, which does not move. Heights from a file are stored as numbers, too.

    `size`: (·, 3), extents along x and y, and how high a 1 is [m]; `heights`: rows from +y to -y, each from -x to +x.
    """

    size: Value
    heights: Heights

    @property
    def values(self) -> tuple[Value, ...]:
        """What may differ from scene to scene."""
        return (self.size,)

    def surface(self, row: int) -> tuple[NDArray[Any], ...]:
        """Vertices, triangles, normals and texture coordinates in a row of its entity: see `heightfield_surface`."""
        from scenecc.geometry.surfaces import heightfield_surface  # noqa: PLC0415 - loaded where there is one

        return heightfield_surface(self.size.row(row), self.heights)


@frozen
class TiledPlane(Primitive):
    """A flat quad facing its own +z with a repeated texture: ManiSkill's tiled plane.

    `half_size`: (·, 2), along its own x and y [m]; `texture_repeat`: (·, 2), times along x and y.
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
"""Those that a file has: each has a `file` and a `scale`."""


MAX_HEIGHTS: Final = 262_144
"""Of a heightfield: 512 × 512."""

MAX_TOTAL_HEIGHTS: Final = 16 * MAX_HEIGHTS
"""Of all heightfields of a document, each counted as often as it is used."""


def heights_fault(heights: Heights) -> str | None:
    """Why rows of heights are no grid; None where they are one."""
    if len(heights) < 2 or len(heights[0]) < 2:
        return "a grid has two rows and two columns at least"
    odd = next((number for number, row in enumerate(heights) if len(row) != len(heights[0])), None)
    return None if odd is None else f"row 0 has {len(heights[0])} heights, and row {odd} has {len(heights[odd])}"
