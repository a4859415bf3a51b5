"""Bodies, their shapes and collision bits, and mounts on bodies. None means that the file gives no value: a backend
then calls no setter.
"""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.diagnostics import Origin
    from scenecc.plan.geometry import CollisionGeometry, VisualGeometry
    from scenecc.plan.value import Value


BodyType = Literal["dynamic", "kinematic", "static", "none", "link"]
"""A "link" is part of an articulation, never an entity of its own."""


@frozen
class CollisionShape:
    """A shape that collides.

    Attributes:
        geometry: type and sizes.
        pose: (·, 7) in the body's frame, p [m] then q (wxyz); None: the identity.
        material: (·,) index into `ScenePlan.physical_materials`; None: the default material.
        density: (·,) [kg/m³]; None: SAPIEN's (1000, a plane's 0).
        contact_offset, rest_offset, patch_radius, min_patch_radius: (·,) [m].
    """

    geometry: CollisionGeometry
    pose: Value | None = None
    material: Value | None = None
    density: Value | None = None
    contact_offset: Value | None = None
    rest_offset: Value | None = None
    patch_radius: Value | None = None
    min_patch_radius: Value | None = None
    origin: Origin | None = field(default=None, compare=False)


@frozen
class VisualShape:
    """A shape that is seen.

    Attributes:
        geometry: type and sizes.
        pose: (·, 7) in the body's frame, p [m] then q (wxyz); None: the identity.
        material: (·,) index into `ScenePlan.visual_materials`; None: a fresh `RenderMaterial`, and
            for a mesh the materials of its file.
        name: the render shape's name; None: "".
        front_face: None: SAPIEN's (clockwise for a mirrored mesh, else counterclockwise).
    """

    geometry: VisualGeometry
    pose: Value | None = None
    material: Value | None = None
    name: str | None = None
    front_face: Literal["counterclockwise", "clockwise"] | None = None
    origin: Origin | None = field(default=None, compare=False)


@frozen
class Inertial:
    """Mass properties that are given instead of computed.

    Attributes:
        mass: (·,) [kg].
        com: (·, 7) centre of mass and principal axes in the body's frame.
        inertia: (·, 3) principal moments along the axes of `com` [kg·m²].
    """

    mass: Value
    com: Value
    inertia: Value


@frozen
class BodyStructure:
    """Everything about a body that `ActorBuilder` is told before it builds, and its knobs.

    Attributes:
        mass: (·,) [kg]; scales the mass and inertia that follow from the densities.
        disable_gravity: (·,) bool.
        locked_motion_axes: (·, 6) bool, x y z rx ry rz; true cannot move.
        linear_velocity, angular_velocity: (·, 3) at the start, world frame [m/s, rad/s].
        linear_damping, angular_damping: (·,) [1/s].
        max_linear_velocity [m/s], max_angular_velocity [rad/s], max_depenetration_velocity [m/s],
        max_contact_impulse [N·s], sleep_threshold [m²/s²]: (·,).
        solver_position_iterations, solver_velocity_iterations: (·,) integers.
        collision_groups: (·, 4) SAPIEN's four integers, for every shape of the body.
        visibility: (·,) in 0..1; shading_mode: (·,) integer; of the render body.
    """

    body_type: BodyType
    collisions: tuple[CollisionShape, ...] = ()
    visuals: tuple[VisualShape, ...] = ()
    mass: Value | None = None
    inertial: Inertial | None = None
    disable_gravity: Value | None = None
    locked_motion_axes: Value | None = None
    linear_velocity: Value | None = None
    angular_velocity: Value | None = None
    linear_damping: Value | None = None
    angular_damping: Value | None = None
    max_linear_velocity: Value | None = None
    max_angular_velocity: Value | None = None
    max_depenetration_velocity: Value | None = None
    max_contact_impulse: Value | None = None
    sleep_threshold: Value | None = None
    solver_position_iterations: Value | None = None
    solver_velocity_iterations: Value | None = None
    collision_groups: Value | None = None
    visibility: Value | None = None
    shading_mode: Value | None = None
    origin: Origin | None = field(default=None, compare=False)

    @property
    def bodies(self) -> tuple[BodyStructure, ...]:
        """Itself, as an articulation's are its links."""
        return (self,)


@frozen
class Mount:
    """A body that something is fastened to.

    Attributes:
        entity: its name in the plan.
        link: of an articulation; None: the entity is a body.
    """

    entity: str
    link: str | None = None

    def __str__(self) -> str:
        """As a scene file names it: `ENTITY` or `ENTITY/LINK`."""
        return self.entity if self.link is None else f"{self.entity}/{self.link}"


COLLISION_ID_BITS = 0xFFFF
"""The bits of the fourth integer within which those of the third count."""


def groups_collide(a: Sequence[int], b: Sequence[int]) -> bool:
    """SAPIEN's rule over the four integers of two shapes (`PhysxCollisionShape.set_collision_groups`)."""
    ignored = bool(a[2] & b[2]) and (a[3] & COLLISION_ID_BITS) == (b[3] & COLLISION_ID_BITS)
    return bool((a[0] & b[1]) or (a[1] & b[0])) and not ignored
