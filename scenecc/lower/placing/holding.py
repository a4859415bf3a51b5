"""Where lights and cameras stand: in the world, relative to something, or in the frame of what they are mounted on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.lower.forms import Place, Reading, place_of
from scenecc.lower.kinds import POSITION, Kind
from scenecc.lower.placing.pose_nodes import POSE, pose_item
from scenecc.lower.placing.rotations import IDENTITY, shortest_from_x
from scenecc.plan import Value, literal
from scenecc.spec.pose import PoseMapping
from scenecc.variation.nodes import Pointing, Posed

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.lower.leaves import Leaves

_AHEAD = (1.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Stand:
    """A pose as it was read.

    Attributes:
        item: seven numbers, or a node.
        reading: of it.
        relative_to: as written.
    """

    item: Any
    reading: Reading
    relative_to: str | None = None


def posed(pose: Any, origin: Origin, leaves: Leaves) -> Stand:
    """A pose as written; None: the identity. `origin`: of the node that has the key `pose`."""
    place = place_of(origin.child("pose"))
    reading = Reading(leaves, place.origin)
    relative_to = pose.relative_to if isinstance(pose, PoseMapping) else None
    return Stand(pose_item(pose, place, reading, leaves.sink), reading, relative_to)


def pointed(position: Any, direction: Any, origin: Origin, leaves: Leaves) -> Stand:
    """A position [m] and a direction that +x turns to by the shortest rotation; either may be None."""
    reading = Reading(leaves, origin)
    p: Any = (0.0, 0.0, 0.0) if position is None else position
    p = reading.item(p, POSITION, place_of(origin.child("position")))
    q = IDENTITY if direction is None else _turn(direction, place_of(origin.child("direction")), reading, leaves)
    if p.__class__ is tuple and q.__class__ is tuple:
        return Stand((*p, *q), reading)
    return Stand(Posed(p, q), reading)


def _turn(direction: Any, place: Place, reading: Reading, leaves: Leaves) -> Any:
    def convert(one: Any) -> Any:
        return tuple(one) if any(one) else None

    def complain(_one: Any, origin: Origin, _sink: Any) -> None:
        leaves.sink.report("SC114", "a direction of length 0 points nowhere", origin)

    item = reading.item(direction, Kind((3,), convert=convert, complain=complain, fallback=_AHEAD), place)
    if item.__class__ is tuple:
        return shortest_from_x(item)
    return reading.risk(Pointing(item), place.origin)


def mounted(stand: Stand, what: str, origin: Origin, leaves: Leaves) -> Value:
    """The pose of what is mounted, in the frame of the body.

    Args:
        stand: as read.
        what: it is, for a message.
        origin: of the node that has the key `pose`.
        leaves: of the object.
    """
    if stand.relative_to is not None:
        leaves.sink.report(
            "SC115",
            f"`relative_to` does nothing here: {what} that is mounted stands in the frame of its body",
            origin.child("pose", "relative_to"),
            at="key",
            hint="leave `relative_to` out, or `mount`",
        )
    if stand.item.__class__ is tuple:
        return literal(stand.item)
    return leaves.finish(stand.item, stand.reading, POSE, origin.child("pose"))
