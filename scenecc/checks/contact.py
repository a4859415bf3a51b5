"""Rules about how surfaces touch: friction, bounce, and the distances at which contacts are made."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.checks.judged import above, alternatives, highest, lowest, rows, waits
from scenecc.checks.mass import single
from scenecc.plan import PhysicalMaterial, literal

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.plan import BodyStructure, Physics, Value

CONTACT_OFFSET, REST_OFFSET = 0.01, 0.0
"""SAPIEN's own (`sapien.physx.get_shape_config()`)."""


def surface_is_real(material: PhysicalMaterial, origin: Origin, sink: Sink, *, drawn: bool) -> None:
    """Sliding rubs no more than sticking, and nothing bounces back faster than it came.

    Args:
        material: whatever may differ from scene to scene in it.
        origin: of the material.
        sink: takes the diagnostics.
        drawn: judge what waits for its rows, and nothing else.
    """
    frictions = (material.dynamic_friction, material.static_friction)
    slides_harder = None if waits(frictions, drawn=drawn) else above(*frictions)
    if slides_harder is not None:
        dynamic, static = slides_harder
        sink.report(
            "SC504",
            f"dynamic friction {dynamic:g} is above static friction {static:g}",
            origin,
            hint="what is left out is the default material's; sliding never rubs more than sticking",
        )
    if not waits([material.restitution], drawn=drawn):
        bouncy = [number for number in _numbers(material.restitution) if not 0 <= number <= 1]
        if bouncy:
            sink.report("SC505", f"restitution {bouncy[0]:g} is not in 0..1", origin)


def _numbers(value: Value) -> list[float]:
    found = alternatives(value)
    return [*lowest(value), *highest(value)] if found is None else [number for row in found for number in row]


def default_contacts(physics: Physics, origin: Origin, sink: Sink) -> None:
    """The same of what shapes have that name nothing.

    Args:
        physics: settings of the document.
        origin: of `physics`.
        sink: takes the diagnostics.
    """
    default = physics.default_material
    if default is not None:
        given = (default.static_friction, default.dynamic_friction, default.restitution)
        surface_is_real(PhysicalMaterial(*map(literal, given)), origin.child("default_material"), sink, drawn=False)
    contact, rest = _defaults(physics)
    if single(contact) <= single(rest):
        key = "rest_offset" if physics.rest_offset is not None else "contact_offset"
        _offset(contact, rest, origin.child(key), sink)


def offsets_of(body: BodyStructure, physics: Physics, origin: Origin, sink: Sink, *, drawn: bool) -> None:
    """Contacts are made before shapes rest on each other.

    Args:
        body: whose shapes are judged.
        physics: settings of the document.
        origin: of the body.
        sink: takes the diagnostics.
        drawn: judge what waits for its rows, and nothing else.
    """
    for shape in body.collisions:
        if shape.contact_offset is None and shape.rest_offset is None:
            continue
        contact, rest = _defaults(physics)
        offsets = (
            literal(contact) if shape.contact_offset is None else shape.contact_offset,
            literal(rest) if shape.rest_offset is None else shape.rest_offset,
        )
        if waits(offsets, drawn=drawn):
            continue
        found = rows(offsets)
        pairs = [(lowest(offsets[0]), highest(offsets[1]))] if found is None else found
        for contacts, rests in pairs:
            if single(contacts[0]) <= single(rests[0]):
                key = "rest_offset" if shape.rest_offset is not None else "contact_offset"
                _offset(contacts[0], rests[0], (shape.origin or origin).child(key), sink)
                break


def _defaults(physics: Physics) -> tuple[float, float]:
    contact = CONTACT_OFFSET if physics.contact_offset is None else physics.contact_offset
    return contact, REST_OFFSET if physics.rest_offset is None else physics.rest_offset


def _offset(contact: float, rest: float, origin: Origin, sink: Sink) -> None:
    sink.report(
        "SC507",
        f"contact_offset {contact:g} is not above rest_offset {rest:g}",
        origin,
        hint="contacts must begin before shapes rest: raise contact_offset or lower rest_offset",
    )
