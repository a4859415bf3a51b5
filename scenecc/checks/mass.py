"""Rules about what bodies weigh: what SAPIEN would replace by a milligram, or cannot hold."""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING, Any

from scenecc.plan import Box, Capsule, Cylinder, Sphere

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.diagnostics import Origin, Sink
    from scenecc.plan import BodyStructure, CollisionShape

DENSITY = 1000.0
"""SAPIEN's own [kg/m³]."""

LIGHTEST = 1e-6
"""What SAPIEN makes of a smaller mass [kg]."""

_VOLUME: dict[type, Callable[[Any], float]] = {
    Box: lambda shape: 8 * _product(shape.half_size.numbers()[:3]),
    Sphere: lambda shape: 4 / 3 * math.pi * shape.radius.numbers()[0] ** 3,
    Capsule: lambda shape: _round(shape) * (2 * shape.half_length.numbers()[0] + 4 / 3 * shape.radius.numbers()[0]),
    Cylinder: lambda shape: _round(shape) * 2 * shape.half_length.numbers()[0],
}
"""Volumes [m³] in the first scene; those of meshes are known once the engine has read them."""


def _product(sizes: tuple[float, ...]) -> float:
    x, y, z = sizes
    return x * y * z


def _round(shape: Capsule | Cylinder) -> float:
    return math.pi * shape.radius.numbers()[0] ** 2


def mass_is_clear(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """What moves has one mass, and one that is not 0."""
    if body.body_type != "dynamic":
        return
    weightless = body.collisions and all(
        s.density is not None and not any(s.density.numbers()) for s in body.collisions
    )
    if body.mass is None:
        if weightless and body.inertial is None:
            sink.report(
                "SC511",
                f"`{name}` has densities of 0 only: it would weigh a milligram",
                origin,
                at="key",
                hint="give a density, or `inertial`",
            )
    elif body.inertial is not None:
        sink.report(
            "SC111",
            "`mass` and `inertial` exclude each other",
            origin.child("inertial"),
            at="key",
            related=[("the mass", origin.child("mass"), "key")],
        )
    elif weightless:
        sink.report(
            "SC510",
            f"`{name}` has densities of 0 only, so there is nothing that `mass` could scale",
            origin.child("mass"),
            hint="give a density, or `inertial` in place of `mass`",
        )


def weight_can_be_held(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """What follows from the densities is a mass that SAPIEN keeps as it is."""
    if body.body_type != "dynamic" or body.inertial is not None:
        return
    weight = 0.0
    for shape in body.collisions:
        measure = _VOLUME.get(type(shape.geometry))
        if measure is None:
            return
        weight += measure(shape.geometry) * _density(shape)
    if math.isinf(single(weight)):
        sink.report(
            "SC512",
            f"`{name}` weighs {weight:.3g} kg by its densities, more than single precision holds",
            origin,
            at="key",
            hint="mend the sizes or the densities: lengths are in metres",
        )
    elif 0 < weight < LIGHTEST:
        sink.report(
            "SC511",
            f"`{name}` weighs {weight:.3g} kg by its densities, and SAPIEN would make a milligram of it",
            origin,
            at="key",
            hint="mend the sizes or the densities (lengths are in metres), or give `inertial`",
        )


def _density(shape: CollisionShape) -> float:
    return DENSITY if shape.density is None else shape.density.numbers()[0]


def single(number: float) -> float:
    """Rounded to single precision, in which the engine computes."""
    try:
        return struct.unpack("f", struct.pack("f", number))[0]
    except OverflowError:
        return math.copysign(math.inf, number)


def inertia_is_real(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """No principal moment of a real body is above the sum of the other two."""
    if body.inertial is None:
        return
    moments = iter(body.inertial.inertia.numbers())
    if any(2 * max(row) > sum(row) * (1 + 1e-9) for row in zip(moments, moments, moments, strict=True)):
        sink.report(
            "SC506",
            f"no body has the inertia of `{name}`: one moment is above the sum of the others",
            origin.child("inertial", "inertia"),
            hint="each of ixx, iyy, izz is at most the sum of the other two",
        )
