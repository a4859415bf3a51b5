"""What a shape looks like: one dataclass a type, which knows its volume and how far it reaches. Lengths in metres.

Capsules and cylinders lie along their own x axis and a plane's normal is its own +x, as in SAPIEN:
the language's `axis`, `normal` and `offset` are part of a shape's pose by now.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

from typing_extensions import override

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from numpy.typing import NDArray

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

    @staticmethod
    def extent(rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        """How far it reaches from its centre along the axes of a frame, (3,) [m]. `rotation`: (3, 3), in that frame."""
        raise NotImplementedError


class Solid(Primitive):
    """A primitive that collides."""

    __slots__ = ()

    @staticmethod
    def volume(*sizes: Any) -> Any:
        """[m³], of numbers or of arrays with a number a scene."""
        raise NotImplementedError


@frozen
class Box(Solid):
    """`half_size`: (·, 3), along x, y and z [m]."""

    half_size: Value

    @staticmethod
    @override
    def volume(*sizes: Any) -> Any:
        x, y, z = sizes
        return 8 * (x * y * z)

    @staticmethod
    @override
    def extent(rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        return abs(rotation) @ sizes


@frozen
class Sphere(Solid):
    """`radius`: (·,) [m]."""

    radius: Value

    @staticmethod
    @override
    def volume(*sizes: Any) -> Any:
        (radius,) = sizes
        return 4 / 3 * math.pi * radius**3

    @staticmethod
    @override
    def extent(rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        return abs(rotation[:, 0]) * 0 + sizes[0]


@frozen
class Capsule(Solid):
    """`radius` and `half_length` (without the caps): (·,) [m]."""

    radius: Value
    half_length: Value

    @staticmethod
    @override
    def volume(*sizes: Any) -> Any:
        radius, half_length = sizes
        return math.pi * radius**2 * (2 * half_length + 4 / 3 * radius)

    @staticmethod
    @override
    def extent(rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        radius, half_length = sizes
        return abs(rotation[:, 0]) * half_length + radius


@frozen
class Cylinder(Solid):
    """`radius` and `half_length`: (·,) [m]."""

    radius: Value
    half_length: Value

    @staticmethod
    @override
    def volume(*sizes: Any) -> Any:
        radius, half_length = sizes
        return math.pi * radius**2 * 2 * half_length

    @staticmethod
    @override
    def extent(rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        radius, half_length = sizes
        along = abs(rotation[:, 0])
        return along * half_length + radius * (1 - along**2).clip(0) ** 0.5


SOLIDS: Final[dict[str, type[Solid]]] = {"box": Box, "sphere": Sphere, "capsule": Capsule, "cylinder": Cylinder}
"""By what the language calls them."""

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

    @staticmethod
    @override
    def extent(rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
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


@frozen
class TiledPlane(Primitive):
    """A flat quad facing its own +z with a repeated texture: ManiSkill's tiled plane.

    `half_size`: (·, 2), along its own x and y [m]; `texture_repeat`: (·, 2), times along x and y.
    """

    half_size: Value
    texture_repeat: Value

    @staticmethod
    @override
    def extent(rotation: NDArray[Any], *sizes: float) -> NDArray[Any]:
        return Box.extent(rotation, *sizes[:2], 0.0)


CollisionGeometry = Box | Sphere | Capsule | Cylinder | Plane | ConvexMesh | ConvexParts | TriangleMesh
VisualGeometry = Box | Sphere | Capsule | Cylinder | VisualPlane | Mesh | TiledPlane
MeshGeometry = ConvexMesh | ConvexParts | TriangleMesh | Mesh
"""Those that a file has: each has a `file` and a `scale`."""
