"""Collects the features that a file format cannot hold and reports each kind once."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Final

from scenecc.diagnostics import Location
from scenecc.plan.display import SPEC_FIELD_NAMES
from scenecc.plan.scene import Physics

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.diagnostics import Origin, Sink


def unsupported_fields(part: type, *supported: str) -> tuple[str, ...]:
    """What may be said of a part of a plan, less what a format holds of it. `part`: a dataclass of the plan."""
    return tuple(
        item.name for item in fields(part) if item.compare and item.default is None and item.name not in supported
    )


PHYSX_SETTINGS: Final = unsupported_fields(Physics, "timestep", "gravity", "default_material")
"""Fields of `Physics` that are PhysX's own, or for scenes side by side: no other program has them."""


class UnsupportedFeatures:
    """Gathers what is left out or said otherwise, and tells it in the end: one warning for all that are alike."""

    def __init__(self, sink: Sink, *, left_out: str, otherwise: str) -> None:
        """Codes of the two warnings."""
        self._sink = sink
        self._left_out = left_out
        self._otherwise = otherwise
        self._found: dict[tuple[str, str, str], tuple[Origin | None, int]] = {}

    def leave_out(self, name: str, what: str, place: Origin | None) -> None:
        """Something of `name` is not in the file. `what`: the thing, as in "`damping` of a joint"."""
        self._take(self._left_out, name, f"left out: {what}", place)

    def change(self, name: str, what: str, place: Origin | None) -> None:
        """Something of `name` is in the file as something else. `what`: the sentence that says so."""
        self._take(self._otherwise, name, what, place)

    def fields(self, name: str, thing: object, fields: Iterable[str], place: Origin | None, of: str = "") -> None:
        """Leaves out those fields of a plan's `thing` that it says something of. `of`: as in " of a joint"."""
        said = [f"`{SPEC_FIELD_NAMES.get(field, field)}`" for field in fields if getattr(thing, field) is not None]
        if said:
            self.leave_out(name, f"{', '.join(said)}{of}", place)

    def report(self) -> None:
        """Reports all of it."""
        for (code, name, what), (place, count) in self._found.items():
            times = f" ({count} times)" if count > 1 else ""
            self._sink.report(code, f"`{name}`: {what}{times}", place or Location(None))
        self._found.clear()

    def _take(self, code: str, name: str, what: str, place: Origin | None) -> None:
        key = (code, name, what)
        first, count = self._found.get(key, (place, 0))
        self._found[key] = (first, count + 1)
