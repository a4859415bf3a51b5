"""Leaves that name things (files, materials): every name that may be meant is looked up, whatever is drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from scenecc.diagnostics.messages import show
from scenecc.lower.doubts import is_by_index
from scenecc.lower.forms import SELECTORS, VARYING, Place, Reading, Step
from scenecc.lower.kinds import Kind
from scenecc.lower.pending import report_failure
from scenecc.lower.picked import picked
from scenecc.plan import Value, literal, varying
from scenecc.variation.nodes import NODES, Computed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Origin
    from scenecc.lower.leaves import Leaves
    from scenecc.variation.nodes import Node

Found = TypeVar("Found")

_INDEX = Kind(dtype="int64", fallback=0)


@dataclass(slots=True)
class Named(Generic[Found]):
    """What a leaf may name, and which of it each scene has.

    Attributes:
        found: by the number that `node` gives; None where it was reported.
        value: (·,) the number in each scene.
    """

    found: list[Found | None]
    value: Value

    def indices(self, leaves: Leaves) -> Value:
        """Where what is named has an index of its own, that index in each scene."""
        values = [literal(index, "int64") for index in self.found]  # pyright: ignore[reportArgumentType]
        return picked(values, self.value, len(leaves.scenes))


@dataclass(slots=True)
class _Lookup(Generic[Found]):
    """The names that were met, each with a number, and what they mean."""

    leaves: Leaves
    find: Callable[[Any, Origin], Found | None]
    numbers: dict[Any, int] = field(default_factory=dict[Any, int])
    found: list[Any] = field(default_factory=list[Any])

    def number(self, name: Any, origin: Origin) -> int:
        # What is written inline is its own; a name is the same thing wherever it stands.
        key = name if isinstance(name, str) else id(name)
        number = self.numbers.get(key)
        if number is None:
            number = self.numbers[key] = len(self.found)
            self.found.append(self.find(name, origin))
        return number


Unwrap = Callable[[Any, Place], tuple[Any, Place]]


def as_it_is(given: Any, place: Place) -> tuple[Any, Place]:
    """What is itself a name."""
    return given, place


def read_names(
    given: Any,
    place: Place,
    leaves: Leaves,
    find: Callable[[Any, Origin], Found | None],
    unwrap: Unwrap = as_it_is,
) -> Named[Found]:
    """A leaf that names something.

    Args:
        given: as the models have it: a name, a mapping that stands for one, a form of these, or an expression.
        place: of the leaf.
        leaves: of its object.
        find: what a name means; None where it reports it.
        unwrap: what names it in an alternative that is a mapping.
    """
    lookup = _Lookup(leaves, find)
    written = given
    if given.__class__ not in SELECTORS:
        given, place = unwrap(given, place)
    if given.__class__ not in VARYING:
        lookup.number(given, place.origin)
        return Named(lookup.found, literal(0, "int64"))
    reading = Reading(leaves, place.origin)
    computed: list[tuple[Computed, Origin]] = []

    def bare(one: Any, around: Place, step: Step) -> Any:
        inside = around.inside(step) if step else around
        if one.__class__ not in VARYING:
            return lookup.number(one, inside.origin)
        node = reading.item(one, _TEXT, inside)
        if isinstance(node, Computed):
            computed.append((node, inside.origin))
        return node

    def leaf(one: Any, around: Place, step: Step) -> Any:
        return reading.select(*unwrap(one, around.inside(step) if step else around), bare)

    node = reading.select(given, place, leaf if given is written else bare)
    for one, origin in computed:
        _every_name(one, origin, lookup)
    leaves.fix(reading)
    if reading.broken or None in lookup.found or node.__class__ not in NODES:
        return Named(lookup.found, literal(0, "int64"))
    return Named(lookup.found, _numbers(node, reading, lookup, place, leaves))


_TEXT = Kind(convert=str, fallback="")


def _every_name(node: Computed, origin: Origin, lookup: _Lookup[Any]) -> None:
    """Looks up every text that an expression can give."""
    names = every_outcome(node, origin, lookup.leaves, _UNTOLD, "or write the names in a `choice`")
    if names is None:
        lookup.found.append(None)
        return
    sink = lookup.leaves.sink
    with sink.alike():
        for name in names:
            if isinstance(name, str):
                lookup.number(name, origin)
            else:
                sink.report("SC317", f"this expression gives {show(name)}, and a name is wanted", origin)
                lookup.found.append(None)
                return


_UNTOLD = "it cannot be told which names this expression gives"


def every_outcome(node: Node, origin: Origin, leaves: Leaves, untold: str, instead: str) -> Iterable[Any] | None:
    """All that a node can give, each once; None where that was reported.

    Args:
        node: an expression, or what draws.
        origin: of it.
        leaves: of its object.
        untold: is said where that cannot be told.
        instead: what can be written then.
    """
    from scenecc.variation.compute_limit import ComputeLimitError  # noqa: PLC0415 - likewise
    from scenecc.variation.enumeration import MAX_OUTCOMES  # noqa: PLC0415 - loaded where something varies
    from scenecc.variation.errors import DrawError  # noqa: PLC0415 - likewise

    try:
        every = leaves.drawing.reader().outcomes(node, leaves.scenes)
    except DrawError as error:
        if isinstance(error, ComputeLimitError) or is_by_index(node, leaves.drawing):
            report_failure(error, {}, origin, leaves.sink)
            return None
        every = None
    if every is not None:
        return {(one.__class__, repr(one)): one for one in every}.values()
    bounded = leaves.bounds(node).alternatives
    if bounded is None:
        few = f"of at most {MAX_OUTCOMES} combinations in all"
        hint = f"it may read draws by `choice`, `cycle` or `integers`, {few}; {instead}"
        leaves.sink.report("SC317", untold, origin, hint=hint)
    return bounded


def _number(name: Any, lookup: _Lookup[Any]) -> int | None:
    return lookup.numbers.get(name) if isinstance(name, str) else None


def _numbers(node: Any, reading: Reading, lookup: _Lookup[Any], place: Place, leaves: Leaves) -> Value:
    """Which of the things each scene has."""
    if not reading.computed:
        return leaves.finish(node, reading, _INDEX, place.origin)
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.variation.bounds import ValueBounds  # noqa: PLC0415 - likewise
    from scenecc.variation.errors import DrawError  # noqa: PLC0415 - likewise

    def draw() -> NDArray[Any]:
        rows = leaves.evaluate(node).tolist()
        numbers = [row if isinstance(row, int) else _number(row, lookup) for row in rows]
        if None in numbers:
            at = numbers.index(None)
            message = f"this gives {show(rows[at])}, which was not among what it was found to give"
            raise DrawError(message, leaves.scenes[at], node)
        return np.array(numbers, dtype=np.int64)

    support = ValueBounds.of(range(len(lookup.found)), exact=False)
    value = varying(draw, bounds=support, rows=len(leaves.scenes))
    leaves.pend(value, _INDEX, place.origin, reading)
    return value
