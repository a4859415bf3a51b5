"""Rules for masses: SAPIEN replaces some by a milligram, and cannot represent others."""

from __future__ import annotations

from itertools import chain, islice
from typing import TYPE_CHECKING, NamedTuple

from scenecc.checks.value_queries import (
    Row,
    RuleFault,
    find_fault,
    find_single_fault,
    highest,
    list_alternatives,
    lowest,
    report_fault,
)
from scenecc.plan import literal
from scenecc.plan.geometry import Solid
from scenecc.plan.properties import DEFAULT_DENSITY, FLOAT32_MAX, FLOAT32_MIN, MAX_BODY_OFFSET

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import At, Origin
    from scenecc.plan import BodyStructure, Value


MIN_MASS = 1e-6
"""SAPIEN's minimum mass [kg]."""

DYNAMIC_TYPES = frozenset(("dynamic", "link"))
"""Bodies that PhysX moves by forces."""

_TYPES_WITH_MASS = DYNAMIC_TYPES | {"kinematic"}
"""Bodies that the engine computes a mass for."""

_DEFAULT_DENSITY_VALUE = literal(DEFAULT_DENSITY)


def check_density_mass(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Checks that SAPIEN keeps the mass computed from densities or, for a kinematic body, can represent it."""
    if body.body_type not in _TYPES_WITH_MASS or body.inertial is not None or not body.collisions:
        return
    values = [_DEFAULT_DENSITY_VALUE if shape.density is None else shape.density for shape in body.collisions]
    holes: set[int] = set()
    for shape in body.collisions:
        if isinstance(shape.geometry, Solid):
            holes.update(len(values) + shape.geometry.__slots__.index(size) for size in shape.geometry.HOLES)
            values += shape.geometry.values

    def rule(*row: Row) -> _MassFault | None:
        # A size that an expression makes negative is reported at the expression.
        return None if min(chain.from_iterable(row)) < 0 else _density_mass_fault(body, name, row, origin)

    _report(find_fault(values, rule, corners=lambda: _corners(values, holes)), sink)


def _corners(values: Sequence[Value], holes: Collection[int] = ()) -> list[tuple[Row, ...]]:
    """Returns the values for the minimum and maximum mass: all values at their extreme, but sizes of holes at the
    opposite.

    `holes`: indices of the values that are sizes of holes.
    """
    light = tuple((highest if number in holes else lowest)(value) for number, value in enumerate(values))
    heavy = tuple((lowest if number in holes else highest)(value) for number, value in enumerate(values))
    return [light, heavy]


class _MassFault(NamedTuple):
    code: str
    message: str
    place: Origin
    hint: str
    at: At = "key"


def _density_mass_fault(body: BodyStructure, name: str, row: tuple[Row, ...], origin: Origin) -> _MassFault | None:
    """Returns why one row of densities and sizes gives a mass that SAPIEN cannot represent; None if it can."""
    sizes = iter(row[len(body.collisions) :])
    weight, dense, complete = 0.0, False, True
    for shape, (density,) in zip(body.collisions, row, strict=False):
        # The mass of a mesh is known only after the engine has read it, but the other shapes may already be too heavy.
        solid = shape.geometry if isinstance(shape.geometry, Solid) else None
        volume = 0 if solid is None else solid.volume(*chain.from_iterable(islice(sizes, len(solid.__slots__))))
        if solid is not None and solid.HOLES and volume <= 0:
            return None  # a hole as wide as its body, which is reported separately
        if density:
            dense = True
            complete = complete and solid is not None
            weight += volume * density
    light = complete and body.body_type in DYNAMIC_TYPES
    if not dense:
        return _zero_density_fault(body, name, origin) if light else None
    hint = "correct the sizes or the densities: lengths are in metres"
    if weight > FLOAT32_MAX:
        message = f"`{name}` weighs {weight:.3g} kg by its densities, which float32 cannot represent"
        return _MassFault("SC512", message, origin, hint)
    if weight * max(chain(*row[len(body.collisions) :]), default=0) ** 2 > FLOAT32_MAX:
        message = f"`{name}` is so large that float32 cannot represent its inertia"
        return _MassFault("SC512", message, origin, hint)
    if light and weight < MIN_MASS:
        hint = "correct the sizes or the densities (lengths are in metres), or give `inertial`"
        message = f"`{name}` weighs {weight:.3g} kg by its densities, which SAPIEN would replace by a milligram"
        return _MassFault("SC511", message, origin, hint)
    return None


def _zero_density_fault(body: BodyStructure, name: str, origin: Origin) -> _MassFault:
    if body.mass is None:
        message = f"`{name}` has only densities of 0: it would weigh a milligram"
        return _MassFault("SC511", message, origin, "give a density, or `inertial`")
    message = f"`{name}` has only densities of 0, which `mass` cannot scale"
    hint = "give a density, or `inertial` instead of `mass`"
    return _MassFault("SC510", message, origin.child("mass"), hint, "value")


def check_explicit_mass(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Checks that float32 can represent a given mass, and the positions of shapes and centre of mass."""
    if body.body_type == "kinematic":
        _check_kinematic_shapes(body, name, origin, sink)
    if body.body_type not in DYNAMIC_TYPES:
        return
    places = [shape.pose for shape in body.collisions if shape.pose is not None]
    given: list[Value] = [] if body.mass is None else [body.mass]
    if body.com is not None:
        places.append(body.com)
    if body.inertial is not None:
        places.append(body.inertial.com)
        given += [body.inertial.mass, body.inertial.inertia]
    if not (places or given):
        return

    def find_place_fault(place: Row) -> _MassFault | None:
        far = max(map(abs, place[:3]))
        if far <= MAX_BODY_OFFSET:
            return None
        message = (
            f"a shape or the centre of mass of `{name}` is {far:.3g} m from its origin; "
            f"beyond {MAX_BODY_OFFSET:g} m, float32 cannot represent its inertia"
        )
        return _MassFault("SC512", message, origin, "fix the coordinates: they are in metres")

    def find_number_fault(numbers: Row) -> _MassFault | None:
        # The engine stores the inverse, and uses 1 if that is not a normal number.
        wrong = next((number for number in numbers if not FLOAT32_MIN <= number <= 1 / FLOAT32_MIN), None)
        if wrong is None:
            return None
        message = f"the mass or a moment of inertia of `{name}` is {wrong:.3g}, whose inverse float32 cannot represent"
        return _MassFault("SC512", message, origin, "fix the mass or the inertia: they are in kg and kg·m²")

    for values, rule in ((places, find_place_fault), (given, find_number_fault)):
        found = (find_single_fault(value, rule) for value in values)
        _report(next((fault for fault in found if fault is not None), None), sink)


def _check_kinematic_shapes(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Checks shape positions of a kinematic body: the engine squares them to compute an inertia."""
    places = [shape.pose for shape in body.collisions if shape.pose is not None]

    def rule(place: Row) -> _MassFault | None:
        far = max(map(abs, place[:3]))
        if far**2 <= FLOAT32_MAX:
            return None
        message = f"a shape of `{name}` is {far:.3g} m from its origin, which float32 cannot represent"
        return _MassFault("SC512", message, origin, "fix the coordinates: they are in metres")

    found = (find_single_fault(place, rule) for place in places)
    _report(next((fault for fault in found if fault is not None), None), sink)


def _report(fault: RuleFault | None, sink: Sink) -> None:
    """Reports a `_MassFault` that was found."""
    if fault is not None:
        found: _MassFault = fault.found
        report_fault(sink, found.code, found.message, found.place, found.hint, fault.sample, at=found.at)


def check_inertia(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Checks that no principal moment exceeds the sum of the other two."""
    if body.inertial is None:
        return
    inertia = body.inertial.inertia

    def rule(moments: Row) -> Row | None:
        return moments if 2 * max(moments) > sum(moments) * (1 + 1e-9) else None

    def corners() -> Iterable[tuple[Row, ...]]:
        found = list_alternatives(inertia)
        return [(row,) for row in (_extreme_moments(inertia) if found is None else found)]

    found = find_fault([inertia], rule, corners=corners)
    if found is not None:
        message = f"the inertia of `{name}` is impossible: one moment exceeds the sum of the others"
        hint = "each of ixx, iyy, izz must be at most the sum of the other two"
        report_fault(sink, "SC506", message, origin.child("inertial", "inertia"), hint, found.sample)


def _extreme_moments(inertia: Value) -> list[Row]:
    """Returns one row per moment, with that moment at its maximum and the others at their minimum."""
    least, most = lowest(inertia), highest(inertia)
    return [tuple(most[j] if j == i else least[j] for j in range(3)) for i in range(3)]
