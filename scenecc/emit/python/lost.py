"""What of a plan no script can say, since nothing in SAPIEN would hold it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics import Location
from scenecc.emit.python.articulations import ROOT_KNOBS
from scenecc.emit.python.knobs import BODY_KNOBS, LOOK_KNOBS, given
from scenecc.plan import ArticulationStructure
from scenecc.plan.articulation import MAX_LINKS, NON_LINK_FIELDS
from scenecc.plan.tendons import tendon_links

if TYPE_CHECKING:
    from collections.abc import Container, Iterator

    from scenecc.diagnostics import Origin, Sink
    from scenecc.plan import BodyStructure, Mimic, ScenePlan


def expressible(plan: ScenePlan, sink: Sink, sections: Container[str]) -> bool:
    """Whether a script can say all of a plan; `sink` is told what not. `sections`: those that have a writer."""
    found = True
    for section in ("constraints", "environment", "lights", "cameras"):
        if getattr(plan, section) and section not in sections:
            sink.report("SC720", f"no script is written of `{section}`", Location(None))
            found = False
    for entity in plan.entities:
        for structure in entity.structures:
            for place, words in _lost_of(structure):
                sink.report("SC720", f"`{entity.name}`: {words}", place or entity.origin or Location(None))
                found = False
    return found


def _lost_of(structure: BodyStructure | ArticulationStructure) -> Iterator[tuple[Origin | None, str]]:
    """What nothing in SAPIEN would hold: where it is, and what it is."""
    for body in structure.bodies:
        for name in _lost(body):
            yield (
                body.origin or structure.origin,
                f"a body of type {body.body_type} without visible shapes has no `{name}`",
            )
    if isinstance(structure, ArticulationStructure):
        if len(structure.links) > MAX_LINKS:
            yield (
                structure.origin,
                f"an articulation of {len(structure.links)} links; PhysX on the CPU counts {MAX_LINKS}",
            )
        if structure.fix_root_link:
            for name in given(structure, ROOT_KNOBS):
                yield structure.origin, f"a root that is fixed has no `{name}`"
        for mimic in structure.mimics:
            words = _impossible(structure, mimic)
            if words is not None:
                yield mimic.origin or structure.origin, words


def _impossible(structure: ArticulationStructure, mimic: Mimic) -> str | None:
    try:
        tendon_links(structure, mimic)
    except ValueError as error:
        return str(error)
    return None


def _lost(structure: BodyStructure) -> list[str]:
    """Fields that nothing in SAPIEN would hold."""
    lost: list[str] = []
    if structure.body_type in {"static", "none"}:
        lost += given(structure, (*BODY_KNOBS, "mass", "inertial"))
    if structure.body_type == "link":
        lost += given(structure, NON_LINK_FIELDS)
    if structure.body_type == "none":
        lost += given(structure, ("collision_groups",)) + (["collisions"] if structure.collisions else [])
    return lost if structure.visuals else lost + given(structure, LOOK_KNOBS)
