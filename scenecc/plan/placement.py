"""Placement of an entity: allowed positions, orientation, and distances from others."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan.body import Mount
    from scenecc.plan.value import Value


APART, GAP, TRIES = 0.001, 0.001, 2000
"""Defaults: distance from others and from the surface [m], and number of tries."""


@frozen
class Nearness:
    """The distance from an entity.

    Attributes:
        entity: its name in the plan.
        least, most: distance between the collision shapes [m].
    """

    entity: str
    least: float
    most: float


@frozen
class NextTo:
    """A position beside an entity, by the bounding boxes of the collision shapes in the axes of the placement.

    Attributes:
        mount: the entity or link.
        side: front is +x of the axes, left is +y.
        gap: distance between the boxes [m].
        align: which ends, or the centres, of the boxes have the same coordinate along the side.
    """

    mount: Mount
    side: Literal["front", "back", "left", "right"]
    gap: float = GAP
    align: Literal["min", "center", "max"] = "center"


@frozen
class Placement:
    """A placement by trial. Its values are redrawn for every try.

    Positions are in the axes of the target, rotated by its heading only, or in those of `frame`.

    Attributes:
        name: of an entity or an instance.
        scene_idxs: its scenes, ascending; rows of the values follow this order.
        kind: relation to the target.
        target: the entity to place it on, in or above.
        members: the entities that move with it, including itself if it is an entity.
        carriers: the entities that support or contain the target, or that it is relative to.
        at: (·, 2) position of its origin [m].
        low, high: (·, 3) corners of the rectangle for its origin; z is the allowed height of the surface [m].
        center, radius: (·, 2) and (·,), of the disk for its origin [m].
        frame: (·, 7) the axes, in the world.
        rotation: (·, 4) in the same axes; None: it is not rotated.
        facing: the entity whose origin its +x points to, about z only.
        facing_point: (·, 2) a point that its +x points to, about z only [m].
        near: distances from others.
        next_to: position beside an entity; it may touch it.
        apart: least distance from every other body [m].
        gap: between its lowest point and the surface [m].
        height: (·, 2) least and largest height above the target's top [m].
        tries: in each scene.
    """

    name: str
    scene_idxs: tuple[int, ...]
    kind: Literal["on", "inside", "above"]
    target: Mount
    members: tuple[Mount, ...]
    carriers: tuple[Mount, ...] = ()
    at: Value | None = None
    low: Value | None = None
    high: Value | None = None
    center: Value | None = None
    radius: Value | None = None
    frame: Value | None = None
    rotation: Value | None = None
    facing: Mount | None = None
    facing_point: Value | None = None
    near: tuple[Nearness, ...] = ()
    next_to: NextTo | None = None
    apart: float = APART
    gap: float = GAP
    height: Value | None = None
    tries: int = TRIES
    origin: Origin | None = field(default=None, compare=False)

    @property
    def entities(self) -> tuple[str, ...]:
        """The names of its members."""
        return tuple(member.entity for member in self.members)

    @property
    def carrying(self) -> tuple[str, ...]:
        """The names of the entities that support the target."""
        return tuple(carrier.entity for carrier in self.carriers)


TRIED_FIELDS = ("at", "low", "high", "center", "radius", "rotation", "facing_point", "height")
"""Values that are redrawn for every try."""
