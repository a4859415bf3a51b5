"""Rules for masses: SAPIEN replaces some by a milligram, and cannot represent others."""

from __future__ import annotations

from itertools import chain, islice
from typing import TYPE_CHECKING, NamedTuple

from scenecc.checks.value_queries import (
    Row,
    alternatives,
    alternatives_or_extremes,
    highest,
    is_bounded,
    is_deferred,
    lowest,
    report_fault,
    rows,
)
from scenecc.plan import literal
from scenecc.plan.geometry import Solid
from scenecc.plan.properties import DEFAULT_DENSITY, FLOAT32_MAX, FLOAT32_MIN, MAX_BODY_OFFSET

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

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


def check_mass_unique(body: BodyStructure, _name: str, origin: Origin, sink: Sink) -> None:
    """Checks that a mass is given only once."""
    if body.mass is not None and body.inertial is not None and body.body_type in DYNAMIC_TYPES:
        sink.report(
            "SC111",
            "`mass` and `inertial` exclude each other",
            origin.child("inertial"),
            at="key",
            related=[("the mass", origin.child("mass"), "key")],
        )


def check_density_mass(body: BodyStructure, name: str, origin: Origin, sink: Sink, *, drawn: bool) -> None:
    """Checks that SAPIEN keeps the mass computed from densities or, for a kinematic body, can represent it."""
    if body.body_type not in _TYPES_WITH_MASS or body.inertial is not None or not body.collisions:
        return
    values = [_DEFAULT_DENSITY_VALUE if shape.density is None else shape.density for shape in body.collisions]
    holes: set[int] = set()
    for shape in body.collisions:
        if isinstance(shape.geometry, Solid):
            holes.update(len(values) + shape.geometry.__slots__.index(size) for size in shape.geometry.HOLES)
            values += shape.geometry.values
    if is_deferred(values, drawn=drawn):
        if not drawn:
            _warn_mass_may_fail(body, name, _corners(values, holes), origin, sink)
        return
    found = rows(values)
    for row in _corners(values, holes) if found is None else found:
        fault = _density_mass_fault(body, name, row, origin)
        if fault is not None:
            _report(fault, sink)
            return


def _corners(values: Sequence[Value], holes: Collection[int] = ()) -> list[tuple[Row, ...]]:
    """Returns the values for the minimum and maximum mass: all values at their extreme, but sizes of holes at the
    opposite.

    `holes`: indices of the values that are sizes of holes.
    """
    light = tuple((highest if number in holes else lowest)(value) for number, value in enumerate(values))
    heavy = tuple((lowest if number in holes else highest)(value) for number, value in enumerate(values))
    return [light, heavy]


def _warn_mass_may_fail(
    body: BodyStructure, name: str, corners: list[tuple[Row, ...]], origin: Origin, sink: Sink
) -> None:
    """Warns of a mass from expressions that may be invalid. Rows are checked once they are drawn."""
    if not all(map(is_bounded, chain.from_iterable(corners))) or min(chain.from_iterable(corners[0])) < 0:
        return  # an expression may give an invalid size, which is reported there
    light, heavy = (_density_mass_fault(body, name, row, origin) for row in corners)
    fault = light or heavy
    if fault is None:
        return
    _report(fault, sink, possible=not (light and heavy and light.code == heavy.code))


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


def check_explicit_mass(body: BodyStructure, name: str, origin: Origin, sink: Sink, *, drawn: bool) -> None:
    """Checks that float32 can represent a given mass, and the positions of shapes and centre of mass."""
    if body.body_type == "kinematic":
        _check_kinematic_shapes(body, name, origin, sink, drawn=drawn)
    if body.body_type not in DYNAMIC_TYPES:
        return
    places = [shape.pose for shape in body.collisions if shape.pose is not None]
    given: list[Value] = [] if body.mass is None else [body.mass]
    if body.inertial is not None:
        places.append(body.inertial.com)
        given += [body.inertial.mass, body.inertial.inertia]
    if not (places or given):
        return
    by_rows = not drawn and is_deferred([*places, *given], drawn=False)
    if drawn and is_deferred([*places, *given], drawn=True):
        return
    ends = _finite_extremes if by_rows else alternatives_or_extremes
    far = max((abs(number) for place in places for row in ends(place) for number in row[:3]), default=0)
    if far > MAX_BODY_OFFSET:
        message = (
            f"a shape or the centre of mass of `{name}` is {far:.3g} m from its origin; "
            f"beyond {MAX_BODY_OFFSET:g} m, float32 loses its inertia"
        )
        hint = "fix the coordinates: they are in metres"
        _report(_MassFault("SC512", message, origin, hint), sink, possible=by_rows)
    # The engine stores the inverse, and uses 1 if that is not a normal number.
    wrong = [
        number for item in given for row in ends(item) for number in row if not FLOAT32_MIN <= number <= 1 / FLOAT32_MIN
    ]
    if wrong:
        message = (
            f"the mass or a moment of inertia of `{name}` is {wrong[0]:.3g}, whose inverse float32 cannot represent"
        )
        hint = "fix the mass or the inertia: they are in kg and kg·m²"
        _report(_MassFault("SC512", message, origin, hint), sink, possible=by_rows)


def _check_kinematic_shapes(body: BodyStructure, name: str, origin: Origin, sink: Sink, *, drawn: bool) -> None:
    """Checks shape positions of a kinematic body: the engine squares them to compute an inertia."""
    places = [shape.pose for shape in body.collisions if shape.pose is not None]
    places = [place for place in places if not is_deferred([place], drawn=drawn)]
    rows_of = chain.from_iterable(map(alternatives_or_extremes, places))
    far = max((abs(number) for row in rows_of for number in row[:3]), default=0)
    if far**2 > FLOAT32_MAX:
        message = f"a shape of `{name}` is {far:.3g} m from its origin, which float32 cannot represent"
        _report(_MassFault("SC512", message, origin, "fix the coordinates: they are in metres"), sink)


def _report(fault: _MassFault, sink: Sink, *, possible: bool = False) -> None:
    report_fault(sink, fault.code, fault.message, fault.place, fault.hint, possible=possible, at=fault.at)


def _finite_extremes(value: Value) -> list[Row]:
    """Returns the minimum and maximum of each number; empty if an expression is unbounded."""
    found = [lowest(value), highest(value)]
    return found if all(map(is_bounded, found)) else []


def check_inertia(body: BodyStructure, name: str, origin: Origin, sink: Sink, *, drawn: bool) -> None:
    """Checks that no principal moment exceeds the sum of the other two."""
    if body.inertial is None:
        return
    inertia = body.inertial.inertia
    if is_deferred([inertia], drawn=drawn):
        return
    found = alternatives(inertia)
    if any(map(_is_impossible, found if found is not None else _extreme_moments(inertia))):
        sink.report(
            "SC506",
            f"the inertia of `{name}` is impossible: one moment exceeds the sum of the others",
            origin.child("inertial", "inertia"),
            hint="each of ixx, iyy, izz must be at most the sum of the other two",
        )


def _is_impossible(moments: Row) -> bool:
    return 2 * max(moments) > sum(moments) * (1 + 1e-9)


def _extreme_moments(inertia: Value) -> list[Row]:
    """Returns one row per moment, with that moment at its maximum and the others at their minimum."""
    least, most = lowest(inertia), highest(inertia)
    return [tuple(most[j] if j == i else least[j] for j in range(3)) for i in range(3)]
