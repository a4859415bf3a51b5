"""An articulation wherever it is written, before anything is said of its links and joints by patterns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.plan.articulation import level_order

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.lower.shapes import Defaults
    from scenecc.plan import CollisionShape, Inertial, Value, VisualShape
    from scenecc.plan.articulation import JointType

Layer = tuple[Any, "Origin"]
"""A model with keys, and the node that has them."""


@dataclass(frozen=True, slots=True)
class Touch:
    """What is said of all shapes of a link that say nothing themselves.

    Attributes:
        default: surface and density.
        patch_radius, min_patch_radius: (·,) [m] or None.
    """

    default: Defaults
    patch_radius: Value | None = None
    min_patch_radius: Value | None = None


Shaping = Callable[[Touch], "tuple[tuple[CollisionShape, ...], tuple[VisualShape, ...]]"]
"""Makes the shapes of a link."""


@dataclass(frozen=True, slots=True)
class DraftMimic:
    """What a joint follows. `multiplier`, `offset`: (·,)."""

    source: str
    multiplier: Value
    offset: Value
    origin: Origin


@dataclass(frozen=True, slots=True)
class DraftJoint:
    """The joint between a link and its parent, as the plan has it, but for what patterns and the start say.

    Attributes:
        effort: the most that a drive exerts where that says nothing; None: likewise unknown.
        limits_origin: where its limits are written, where that is a place of their own.
    """

    type: JointType
    name: str
    origin: Origin
    pose_in_parent: Value | None = None
    pose_in_child: Value | None = None
    limits: Value | None = None
    limits_origin: Origin | None = None
    friction: Value | None = None
    damping: Value | None = None
    armature: Value | None = None
    max_velocity: Value | None = None
    effort: Value | None = None
    mimic: DraftMimic | None = None

    @property
    def moves(self) -> bool:
        """Whether it has a degree of freedom."""
        return self.type != "fixed"


@dataclass(frozen=True, slots=True)
class DraftLink:
    """A link.

    Attributes:
        parent: number of the link that it hangs on, which stands before it; None: it is the root.
        own: its own keys, which go before what patterns say; None: it has none.
        inertial: what its file says of its mass.
        ignore_bits: as `DescribedLink` has them.
    """

    name: str
    origin: Origin
    shaping: Shaping
    parent: int | None = None
    joint: DraftJoint | None = None
    own: Layer | None = None
    inertial: Inertial | None = None
    ignore_bits: int = 0


@dataclass(frozen=True, slots=True)
class Draft:
    """A whole articulation.

    Attributes:
        links: the root first, each after its parent.
        fixed: whether the root is fixed to the world; None: nothing says it, so that what stands for it is the default.
        file: (·,) index of its file; None: it is the scene's own.
        ignored: for each of the lowest bits of `ignore_bits`, where its file says that two links ignore one another;
            of others there is no such place.
    """

    links: tuple[DraftLink, ...]
    origin: Origin
    fixed: bool | None = None
    file: Value | None = None
    ignored: tuple[Origin, ...] = ()

    def moving(self) -> list[int]:
        """The links whose joints move, in SAPIEN's order of them: by distance from the root, then as they are built."""
        order = level_order(link.parent for link in self.links)
        return [number for number in order if (joint := self.links[number].joint) is not None and joint.moves]
