"""Contacts of USD materials that PhysX computes differently from SAPIEN, which takes the mean of both numbers."""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from scenecc.importers.usd_bodies import UsdBody
    from scenecc.importers.usd_materials import UsdMaterialReader
    from scenecc.importers.usd_stage import Prim, UsdStage

_MODES: Final = ("average", "min", "multiply", "max")
"""Combine modes of PhysX. Of two materials, the later mode in this order applies."""

_DEFAULT: Final = {"static_friction": 0.3, "dynamic_friction": 0.3, "restitution": 0.0}
"""SAPIEN's material, of colliders without one."""

_SAME: Final = 1e-6


@frozen
class _Contact:
    """How a material makes contacts.

    Attributes:
        path: of its prim; "": none.
        numbers: frictions and restitution.
        friction, restitution: combine modes, as indices of `_MODES`.
    """

    path: str
    numbers: Mapping[str, float]
    friction: int = 0
    restitution: int = 0

    def mode(self, key: str) -> int:
        """Returns the mode that applies to a number."""
        return self.restitution if key == "restitution" else self.friction


def report_contacts(
    stage: UsdStage,
    materials: UsdMaterialReader,
    bodies: Mapping[str, UsdBody],
    apart: Collection[frozenset[str]],
) -> None:
    """Reports combine modes where two bodies touch otherwise than by the mean, and compliant contacts.

    Args:
        stage: the stage.
        materials: its materials.
        bodies: by prim path.
        apart: pairs of paths of bodies that never collide.
    """
    users: dict[str, list[str]] = {}
    for path, body in bodies.items():
        for material in {materials.physical_path(parsed) for _, parsed in body.colliders if parsed.collisionEnabled}:
            users.setdefault(material, []).append(path)
    contacts = {path: _contact(stage, materials, path) for path in users}
    seen: set[str] = set()
    for path in users:
        if path and (stiffness := stage.authored(stage.prim(path), "physxMaterial:compliantContactStiffness")):
            what = f"the compliant contacts of stiffness {_text(stiffness)}; SAPIEN's are hard"
            stage.lose("contact-materials", what, stage.prim(path))
    for one, other in combinations_with_replacement(contacts.values(), 2):
        changed = _changed(one, other)
        if changed is None or not _meet(users[one.path], users[other.path], bodies, apart):
            continue
        key, mode, value, mean = changed
        owner = max(one, other, key=lambda each: (each.mode(key), bool(each.path)))
        if owner.path in seen:
            continue
        seen.add(owner.path)
        partner = other if owner is one else one
        names = "another body's" if partner is owner else f"`{partner.path.rpartition('/')[2] or 'no material'}`"
        word = key.replace("_", " ")
        what = f"the combine mode `{mode}`: a {word} of {value:g} with {names}, where SAPIEN's mean is {mean:g}"
        stage.lose("contact-materials", what, stage.prim(owner.path))


def _contact(stage: UsdStage, materials: UsdMaterialReader, path: str) -> _Contact:
    if not path:
        return _Contact("", _DEFAULT)
    prim = stage.prim(path)
    modes = [_mode(stage, prim, name) for name in ("friction", "restitution")]
    return _Contact(path, materials.friction(path), *modes)


def _mode(stage: UsdStage, prim: Prim, name: str) -> int:
    found = str(stage.authored(prim, f"physxMaterial:{name}CombineMode") or "average")
    return _MODES.index(found) if found in _MODES else 0


def _changed(one: _Contact, other: _Contact) -> tuple[str, str, float, float] | None:
    """Returns the first number that differs from the mean, with its mode, PhysX's value and the mean."""
    for key in ("static_friction", "dynamic_friction", "restitution"):
        a, b = one.numbers[key], other.numbers[key]
        mode = max(one.mode(key), other.mode(key))
        value = ((a + b) / 2, min(a, b), a * b, max(a, b))[mode]
        if abs(value - (a + b) / 2) > _SAME:
            return key, _MODES[mode], value, (a + b) / 2
    return None


def _meet(ones: list[str], others: list[str], bodies: Mapping[str, UsdBody], apart: Collection[frozenset[str]]) -> bool:
    """Returns whether a body of the first list can touch one of the second: one of the two moves."""
    return any(
        one != other
        and "dynamic" in (bodies[one].body_type, bodies[other].body_type)
        and frozenset((one, other)) not in apart
        for one in ones
        for other in others
    )


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float | int) else str(value)
