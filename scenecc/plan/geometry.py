"""What a shape looks like: one dataclass a type. Lengths in metres.

Capsules and cylinders lie along their own x axis and a plane's normal is its own +x, as in SAPIEN:
the language's `axis`, `normal` and `offset` are part of a shape's pose by now.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.plan.value import Value


@frozen
class Box:
    """`half_size`: (·, 3), along x, y and z [m]."""

    half_size: Value


@frozen
class Sphere:
    """`radius`: (·,) [m]."""

    radius: Value


@frozen
class Capsule:
    """`radius` and `half_length` (without the caps): (·,) [m]."""

    radius: Value
    half_length: Value


@frozen
class Cylinder:
    """`radius` and `half_length`: (·,) [m]."""

    radius: Value
    half_length: Value


@frozen
class Plane:
    """An endless colliding half space below the plane x = 0.

    `every_scene`: where scenes share one GPU simulation, build it in each although it is the same.
    """

    every_scene: bool = False


@frozen
class VisualPlane:
    """What is seen of a plane. `half_size`: (·, 2), along its own y and z [m]."""

    half_size: Value


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
class TiledPlane:
    """A flat quad facing its own +z with a repeated texture: ManiSkill's tiled plane.

    `half_size`: (·, 2), along its own x and y [m]; `texture_repeat`: (·, 2), times along x and y.
    """

    half_size: Value
    texture_repeat: Value


CollisionGeometry = Box | Sphere | Capsule | Cylinder | Plane | ConvexMesh | ConvexParts | TriangleMesh
VisualGeometry = Box | Sphere | Capsule | Cylinder | VisualPlane | Mesh | TiledPlane
MeshGeometry = ConvexMesh | ConvexParts | TriangleMesh | Mesh
"""Those that a file has: each has a `file` and a `scale`."""
