"""Rules about what bodies weigh: what SAPIEN would replace by a milligram, or cannot hold."""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING, Any

from scenecc.plan import Box, Capsule, Cylinder, Sphere

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.diagnostics import Origin, Sink
    from scenecc.plan import BodyStructure

DENSITY = 1000.0
"""SAPIEN's own [kg/m³]."""

LIGHTEST, LARGEST = 1e-6, 3.4028234663852886e38
"""What SAPIEN makes of a smaller mass, and the end of single precision [kg]."""

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


def mass_is_clear(body: BodyStructure, _name: str, origin: Origin, sink: Sink) -> None:
    """A mass is given once."""
    if body.mass is not None and body.inertial is not None and body.body_type == "dynamic":
        sink.report(
            "SC111",
            "`mass` and `inertial` exclude each other",
            origin.child("inertial"),
            at="key",
            related=[("the mass", origin.child("mass"), "key")],
        )


def weight_can_be_held(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """What follows from the densities of a body that moves is a mass that SAPIEN keeps as it is."""
    if body.body_type != "dynamic" or body.inertial is not None or not body.collisions:
        return
    weight, dense = 0.0, False
    for shape in body.collisions:
        density = DENSITY if shape.density is None else max(shape.density.numbers())
        if density:
            dense = True
            measure = _VOLUME.get(type(shape.geometry))
            if measure is None:
                return
            weight += measure(shape.geometry) * density
    if not dense:
        _weightless(body, name, origin, sink)
    elif weight > LARGEST:
        hint = "mend the sizes or the densities: lengths are in metres"
        message = f"`{name}` weighs {weight:.3g} kg by its densities, more than single precision holds"
        sink.report("SC512", message, origin, at="key", hint=hint)
    elif weight < LIGHTEST:
        hint = "mend the sizes or the densities (lengths are in metres), or give `inertial`"
        message = f"`{name}` weighs {weight:.3g} kg by its densities, and SAPIEN would make a milligram of it"
        sink.report("SC511", message, origin, at="key", hint=hint)


def _weightless(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    if body.mass is None:
        message = f"`{name}` has densities of 0 only: it would weigh a milligram"
        sink.report("SC511", message, origin, at="key", hint="give a density, or `inertial`")
        return
    message = f"`{name}` has densities of 0 only, so there is nothing that `mass` could scale"
    hint = "give a density, or `inertial` in place of `mass`"
    sink.report("SC510", message, origin.child("mass"), hint=hint)


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
