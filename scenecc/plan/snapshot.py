"""State of a plan's bodies in the engine after they are built, for exporters to other formats.

Masses follow from densities, hulls from meshes and link poses from joints: the engine has computed them, and here
they are plain numbers. Visuals, lights and cameras are not measured; the plan has them.
"""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Pose7, Vec3
    from scenecc.plan.articulation import ArticulationStructure, DriveMode, Joint, JointType
    from scenecc.plan.body import BodyStructure, BodyType, CollisionShape
    from scenecc.plan.scene import Entity


@frozen
class MeasuredMesh:
    """A cooked mesh, in the frame of its shape and already scaled. One object for all shapes that have the same.

    Attributes:
        digest: of vertices and triangles; meshes that have the same are the same.
        vertices: (V, 3) float64 [m].
        triangles: (T, 3) int64, counterclockwise from outside.
    """

    digest: str
    vertices: NDArray[np.float64] = field(compare=False)
    triangles: NDArray[np.int64] = field(compare=False)


@frozen
class MeasuredShape:
    """One colliding shape of the engine.

    Attributes:
        kind: of the engine's shape, as the language calls it; parts of a decomposed mesh are `convex_mesh`es.
        sizes: of a solid, see `plan.geometry` [m]; nothing of the others. A plane is the half space below its own
            x = 0.
        pose: in the body's frame.
        shape: the plan's, of which this is all or a part.
        mesh: of a `convex_mesh` or a `triangle_mesh`.
        static_friction, dynamic_friction, restitution, density [kg/m³], contact_offset [m], rest_offset [m]: as held.
        groups: SAPIEN's four integers.
    """

    kind: str
    sizes: tuple[float, ...]
    pose: Pose7
    shape: CollisionShape
    mesh: MeasuredMesh | None
    static_friction: float
    dynamic_friction: float
    restitution: float
    density: float
    contact_offset: float
    rest_offset: float
    groups: tuple[int, int, int, int]


@frozen
class MeasuredMass:
    """Mass properties.

    Attributes:
        mass: [kg].
        com: pose of the centre of mass and of the principal axes in the body's frame.
        inertia: principal moments along these axes [kg·m²].
    """

    mass: float
    com: Pose7
    inertia: Vec3


@frozen
class MeasuredJoint:
    """The joint between a link and its parent. Positions are [m] of a prismatic one and [rad] of others.

    Attributes:
        joint: the plan's.
        type: the plan's. What a fixed joint has not is 0, its limits too.
        name: "" where it has none.
        pose_in_parent, pose_in_child: as in the plan.
        limits: infinite on a side that has none.
        stiffness, damping, force_limit, drive_mode, drive_target, drive_velocity_target: of its drive.
        qpos, qvel: at the start.
    """

    joint: Joint
    type: JointType
    name: str
    pose_in_parent: Pose7
    pose_in_child: Pose7
    limits: tuple[float, float]
    friction: float
    armature: float
    max_velocity: float
    stiffness: float
    damping: float
    force_limit: float
    drive_mode: DriveMode
    drive_target: float
    drive_velocity_target: float
    qpos: float
    qvel: float


@frozen
class MeasuredBody:
    """A body at the start of its scene, or a link of an articulation.

    Attributes:
        name: the entity's, or the link's.
        body_type: the plan's.
        body: the plan's; `body.visuals` is what is seen of it.
        pose: in the world of its scene.
        mass: None: it is static, or of the type none.
        shapes: in the engine's order, which is that of the plan.
        parent: of a link, the number of the one that it hangs on; None: the root, or a body.
        joint: of a link, to its parent; None at the root and of a body.
    """

    name: str
    body_type: BodyType
    body: BodyStructure
    pose: Pose7
    mass: MeasuredMass | None
    shapes: tuple[MeasuredShape, ...]
    parent: int | None = None
    joint: MeasuredJoint | None = None


@frozen
class MeasuredEntity:
    """One entity in one scene.

    Attributes:
        entity: the plan's.
        structure: the one that it has in this scene.
        row: of this scene in the entity's values (`Value.row`).
        bodies: itself, or the links of an articulation in the order of the plan.
    """

    entity: Entity
    structure: BodyStructure | ArticulationStructure
    row: int
    bodies: tuple[MeasuredBody, ...]


@frozen
class MeasuredScene:
    """One scene as built.

    Attributes:
        index: among all scenes of the plan.
        timestep: [s].
        gravity: [m/s²].
        entities: those that are in it, in build order.
    """

    index: int
    timestep: float
    gravity: Vec3
    entities: tuple[MeasuredEntity, ...]


@frozen
class EngineSnapshot:
    """Some scenes of a plan as built, ascending by index; one at least."""

    scenes: tuple[MeasuredScene, ...]
