"""Expectations about the scenes of a plan. They are not built; a simulation checks them."""

from __future__ import annotations

import math
from dataclasses import field
from typing import TYPE_CHECKING, Final, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.variation.forms import Template

MAX_SECONDS: Final = 1000
"""Longest simulation that an expectation may request [s]."""


@frozen
class Settled:
    """Dynamic bodies and free articulations stay at their initial poses.

    Attributes:
        name: unique among the expectations of a plan.
        seconds: simulated time [s].
        within: largest displacement after that time [m].
        angle: largest rotation after that time [rad].
        entities: entities to check; None: all.
        excepted: entities that may move.
    """

    name: str
    seconds: float
    within: float
    angle: float
    entities: tuple[str, ...] | None = None
    excepted: tuple[str, ...] = ()
    origin: Origin | None = field(default=None, compare=False)


@frozen
class BodyPair:
    """Two bodies: ENTITY (with all its links) or ENTITY/LINK."""

    a: str
    b: str


@frozen
class NoOverlap:
    """How deep bodies may overlap at the start.

    Attributes:
        name: unique among the expectations of a plan.
        deeper_than: [m]; None: the default.
        entities: both bodies of a checked pair are among these; None: all.
        excepted: pairs that may overlap.
    """

    name: str
    deeper_than: float | None = None
    entities: tuple[str, ...] | None = None
    excepted: tuple[BodyPair, ...] = ()
    origin: Origin | None = field(default=None, compare=False)


@frozen
class Reading:
    """The meaning of a name in a condition.

    Attributes:
        name: in the expression, such as `position('cube')`.
        kind: of the quantity.
        of: full names: a shared draw, or one or two of ENTITY or ENTITY/LINK, followed by a joint for joint quantities.
    """

    name: str
    kind: Literal["draw", "position", "speed", "tilt", "distance", "touching", "qpos"]
    of: tuple[str, ...]


@frozen
class Condition:
    """A condition at a time of the simulation.

    Attributes:
        name: unique among the expectations of a plan.
        scene_idxs: the scenes in which it must hold, ascending.
        after: time [s].
        that: the expression that must be true.
        because: the reason, in words.
        readings: meanings of its names.
    """

    name: str
    scene_idxs: tuple[int, ...]
    after: float
    that: Template
    because: str = ""
    readings: tuple[Reading, ...] = ()
    origin: Origin | None = field(default=None, compare=False)


Expectation = Settled | NoOverlap | Condition


def describe_expectation(one: Expectation) -> str:
    """Short text for an expectation, for `inspect` and `diff`."""
    match one:
        case Settled():
            text = f"within {one.within:g} m and {math.degrees(one.angle):.4g}° after {one.seconds:g} s"
            excepted = [*one.excepted]
        case NoOverlap():
            text = "as everywhere" if one.deeper_than is None else f"no deeper than {one.deeper_than:g} m"
            excepted = [f"{pair.a} and {pair.b}" for pair in one.excepted]
        case Condition():
            constants = ", ".join(f"{name} = {value}" for name, value in one.that.constants)
            text = f"after {one.after:g} s: {one.that.text}" + (f" with {constants}" if constants else "")
            text += f", because {one.because}" if one.because else ""
            excepted = []
    return f"{text}, except {', '.join(excepted)}" if excepted else text
