"""Differences between the engine and the plan, as diagnostics."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from scenecc.diagnostics.diagnostic import Location

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import Constraint, Entity
    from scenecc.plan.rendering import Camera, Light

AUDIT_CODE = "SC802"


class AuditDifference(NamedTuple):
    """One difference from the plan in one scene.

    Attributes:
        item: the plan's item that differs. None: the scene as a whole.
        what: the value that differs, by the engine's name.
        expected, found: the plan's value and the engine's, for messages.
        scene_idx: index of the scene in the plan.
        link: name of the link; "" if it is not a link.
        origin: of the node that sets the value. None: that of `item`.
        code: of the diagnostic.
    """

    item: Entity | Light | Camera | Constraint | None
    what: str
    expected: object
    found: object
    scene_idx: int
    link: str = ""
    origin: Origin | None = None
    code: str = AUDIT_CODE

    @property
    def who(self) -> str:
        """Name of its owner, for messages."""
        name = "the scene" if self.item is None else f"'{self.item.name}'"
        return f"link '{self.link}' of {name}" if self.link else name


def report_differences(differences: Iterable[AuditDifference], sink: Sink) -> bool:
    """Reports one diagnostic for each item that differs, for all scenes together. Returns True if nothing differs."""
    found = list(differences)
    # A wrong pose may follow from a mass that is out of range, and is then not reported.
    causes = {id(one.item) for one in found if one.code != AUDIT_CODE}
    groups: dict[tuple[object, ...], list[AuditDifference]] = {}
    for one in found:
        if one.code != AUDIT_CODE or id(one.item) not in causes:
            groups.setdefault((one.who, one.what, one.origin, one.code), []).append(one)
    for group in groups.values():
        first, scenes = group[0], len({one.scene_idx for one in group})
        more = f" (and in {scenes - 1} more)" if scenes > 1 else ""
        values = f"{first.what} = {first.found}, but the plan asks for {first.expected}"
        message = f"{first.who} in scene {first.scene_idx}{more}: the engine holds {values}"
        origin = first.origin or (first.item and first.item.origin)
        sink.report(first.code, message, origin or Location(None))
    return not groups


def format_engine_numbers(numbers: object) -> str:
    """Formats numbers with as many digits as the engine keeps."""
    with np.errstate(over="ignore"):
        array = np.asarray(numbers, np.float32)
    # NumPy writes a float32 with the fewest digits that distinguish it from its neighbours.
    return "[" + ", ".join(map(str, array.ravel())) + "]" if array.ndim else str(array[()])
