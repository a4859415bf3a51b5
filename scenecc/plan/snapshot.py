"""State of a plan's bodies in the engine after they are built, for exporters to other formats.

Holds the results of the engine's computations as plain numbers: masses from densities, hulls from meshes, link poses
from joints. Visuals, lights and cameras are only in the plan.
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
    """A cooked mesh in the frame of its shape, scaled. Shapes with equal meshes share one object.

    Attributes:
        digest: hash of vertices and triangles; equal for equal meshes.
        vertices: (V, 3) float64 [m].
        triangles: (T, 3) int64, counterclockwise from outside.
    """

    digest: str
    vertices: NDArray[np.float64] = field(compare=False)
    triangles: NDArray[np.int64] = field(compare=False)


@frozen
class MeasuredShape:
    """One collision shape of the engine.

    Attributes:
        kind: type of the engine's shape, as in the language; parts of a decomposed mesh are `convex_mesh`es.
        sizes: of a solid, see `plan.geometry` [m]; otherwise empty. A plane is the half space below its x = 0.
        pose: in the body's frame.
        shape: the plan's shape, of which this is all or a part.
        mesh: of a `convex_mesh` or a `triangle_mesh`.
        static_friction, dynamic_friction, restitution, density [kg/m³], contact_offset [m], rest_offset [m]: of the
            engine's shape.
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
    """The joint between a link and its parent. Positions are in [m] for a prismatic joint, otherwise in [rad].

    Attributes:
        joint: the plan's.
        type: the plan's. Values that do not apply to a fixed joint are 0, including limits.
        name: "" if it has none.
        pose_in_parent, pose_in_child: as in the plan.
        limits: infinite on a side without a limit.
        stiffness, damping, force_limit, drive_mode, drive_target, drive_velocity_target: of its drive.
        qpos, qvel: initial.
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
    """The initial state of a body or of a link.

    Attributes:
        name: the entity's, or the link's.
        body_type: the plan's.
        body: the plan's; `body.visuals` are its visual shapes.
        pose: in the world of its scene.
        mass: None: it is static or of the type "none".
        shapes: in the engine's order, which is that of the plan.
        parent: number of a link's parent; None for a root or a body.
        joint: of a link, to its parent; None for a root or a body.
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
        structure: its structure in this scene.
        row: row of this scene in the entity's values (`Value.row`).
        bodies: the body, or the links of an articulation in plan order.
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
        entities: its entities, in build order.
    """

    index: int
    timestep: float
    gravity: Vec3
    entities: tuple[MeasuredEntity, ...]


@frozen
class EngineSnapshot:
    """One or more scenes of a plan as built, ascending by index."""

    scenes: tuple[MeasuredScene, ...]
