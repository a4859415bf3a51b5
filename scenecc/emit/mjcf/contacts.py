"""Pairs of bodies that do not collide."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.emit.mjcf.model import Model, Written

_ID = 0xFFFF
"""The bits of the fourth integer that say which bodies the third is about."""


def write_contacts(model: Model) -> None:
    """Excludes links and what they hang on, bodies that a constraint ties, and those that ignore one another by bits.

    MuJoCo leaves out a body and its parent by itself, but not where the parent is held by the world.
    """
    found: dict[tuple[str, str], None] = {}
    for (entity, _), body in model.bodies.items():
        parent = body.measured.parent
        if parent is not None and not body.held:
            above = [each for (name, _), each in model.bodies.items() if name == entity][parent]
            if above.held and above.measured.shapes and body.measured.shapes:
                found[above.name, body.name] = None
    for constraint in model.plan.constraints:
        if constraint.parent is not None and model.scene.index in constraint.scene_idxs:
            a, b = (model.bodies[model.key(mount)].name for mount in (constraint.parent, constraint.child))
            found[a, b] = None
    ignoring = [body for body in model.bodies.values() if body.measured.shapes and body.measured.shapes[0].groups[2]]
    for a, b in combinations(ignoring, 2):
        if _ignore(a, b) and not (a.held and b.held) and not {(a.name, b.name), (b.name, a.name)} & found.keys():
            found[a.name, b.name] = None
    for a, b in found:
        model.sections["contact"].add("exclude", body1=a, body2=b)


def _ignore(a: Written, b: Written) -> bool:
    (_, _, bits_a, id_a), (_, _, bits_b, id_b) = (each.measured.shapes[0].groups for each in (a, b))
    return bool(bits_a & bits_b) and id_a & _ID == id_b & _ID
