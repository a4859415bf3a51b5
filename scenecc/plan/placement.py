"""How an entity is placed: where it may stand, how it is turned, and what it keeps away from."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan.body import Mount
    from scenecc.plan.value import Value


APART, GAP, TRIES = 0.001, 0.001, 2000
"""Defaults: distance from others and from the surface [m], and how often a place is tried."""


@frozen
class Nearness:
    """How far something stands from an entity.

    Attributes:
        entity: its name in the plan.
        least, most: distance between the colliding shapes [m].
    """

    entity: str
    least: float
    most: float


@frozen
class Placement:
    """Where something is put, by trial. Its values are drawn anew for every try.

    Positions are in the axes of the target, turned by its heading alone, or in those of `frame`.

    Attributes:
        name: of an entity, or of an instance.
        scene_idxs: the scenes it is in, ascending; rows of the values follow this order.
        kind: how it stands to the target.
        target: what it stands on, in or above.
        members: the entities that go with it, itself among them where it is one.
        carriers: the entities that the target stands on or in, or is relative to.
        at: (·, 2) where its origin is [m].
        low, high: (·, 3) corners of the rectangle that its origin is in; along z, of the heights that the surface may
            have [m].
        center, radius: (·, 2) and (·,), of the disk that its origin is in [m].
        frame: (·, 7) the axes, in the world.
        rotation: (·, 4) in the same axes; None: it is not turned.
        facing: the entity whose origin its +x points to, about z alone.
        facing_point: (·, 2) likewise a point [m].
        near: distances from others.
        apart: least distance from every other body [m].
        gap: between its lowest point and the surface [m].
        height: (·, 2) the least and the most above the target's top [m].
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
        """The names of the entities that carry the target."""
        return tuple(carrier.entity for carrier in self.carriers)


TRIED_FIELDS = ("at", "low", "high", "center", "radius", "rotation", "facing_point", "height")
"""Values that are drawn anew for every try."""
