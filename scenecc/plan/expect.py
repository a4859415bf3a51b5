"""What must hold in the scenes of a plan. Nothing of it is built: a simulation judges it."""

from __future__ import annotations

import math
from dataclasses import field
from typing import TYPE_CHECKING, Final, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.variation.forms import Template

MAX_SECONDS: Final = 1000
"""How long a simulation may be that an expectation asks for [s]."""


@frozen
class Settled:
    """Dynamic bodies and free articulations stay where they start.

    Attributes:
        name: unique among the expectations of a plan.
        seconds: how long they are simulated [s].
        within: how far each may then be from its start [m].
        angle: how far each may then be turned [rad].
        entities: that are judged; None: all.
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
    """Two bodies: ENTITY, which stands for all its links, or ENTITY/LINK."""

    a: str
    b: str


@frozen
class NoOverlap:
    """How deep bodies may overlap at the start.

    Attributes:
        name: unique among the expectations of a plan.
        deeper_than: [m]; None: as everywhere else.
        entities: of pairs that are judged both are among them; None: all.
        excepted: pairs that may overlap.
    """

    name: str
    deeper_than: float | None = None
    entities: tuple[str, ...] | None = None
    excepted: tuple[BodyPair, ...] = ()
    origin: Origin | None = field(default=None, compare=False)


@frozen
class Reading:
    """What a name in a condition stands for.

    Attributes:
        name: in the expression, such as `position('cube')`.
        kind: what it is.
        of: full names: of the shared draw; of an entity or ENTITY/LINK, or two of them, a joint after it.
    """

    name: str
    kind: Literal["draw", "position", "speed", "tilt", "distance", "touching", "qpos"]
    of: tuple[str, ...]


@frozen
class Condition:
    """What holds at a time of the simulation.

    Attributes:
        name: unique among the expectations of a plan.
        scene_idxs: the scenes in which it must hold, ascending.
        after: when [s].
        that: the expression, which is true.
        because: what it means, in words.
        readings: what its names stand for.
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
    """An expectation in a few words, as `inspect` and `diff` show it."""
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
