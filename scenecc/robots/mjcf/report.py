"""What is told of an MJCF: faults, what is left out, and where ManiSkill's loader reads something else."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.robots.mjcf.unread import ELEMENT_HINTS, attribute_hint

if TYPE_CHECKING:
    from scenecc.diagnostics import Location
    from scenecc.robots.findings import Findings
    from scenecc.robots.xml import Element


@dataclass(slots=True)
class Report:
    """Gathers what is told, so that a kind of thing that is left out is told once, with all that is of that kind.

    Attributes:
        findings: where it goes.
        included: the findings of each file that is included, by its name as shown to people.
    """

    findings: Findings
    included: dict[str, Findings] = field(default_factory=dict[str, "Findings"])
    _unbuilt: dict[str, tuple[str, Location, str | None]] = field(
        default_factory=dict[str, "tuple[str, Location, str | None]"]
    )
    _elements: dict[str, list[Element]] = field(default_factory=dict[str, "list[Element]"])
    _attributes: dict[str, dict[str, Element]] = field(default_factory=dict[str, "dict[str, Element]"])

    @property
    def failed(self) -> bool:
        """Whether an error was told."""
        return bool(self.findings.errors) or any(findings.errors for findings in self.included.values())

    def error(self, code: str, message: str, location: Location, hint: str | None = None) -> None:
        """Something that makes the file unfit."""
        self.of(location).report(code, message, location, hint=hint)

    def of(self, location: Location) -> Findings:
        """The findings of the file in which a place is, which know what led to it."""
        return self.included.get(location.file or "", self.findings)

    def left_out(self, kind: str, message: str, location: Location, hint: str | None = None) -> None:
        """Something that is not built, once a kind."""
        self.of(location).report_once("SC484", kind, message, location, hint)

    def not_built(self, kind: str, message: str, location: Location, hint: str | None = None) -> None:
        """A body or a geom that is left out, told by `tell_unread`: it may be why nothing at all is built."""
        self._unbuilt.setdefault(kind, (message, location, hint))

    def nothing(self, root: Element) -> None:
        """An error for a file of which nothing is built, at what was left out first where anything was."""
        message, location, hint = "it has no body and no geom that is", root.location, None
        if self._unbuilt:
            message, location, hint = self._unbuilt.pop(next(iter(self._unbuilt)))
        self.error("SC480", f"nothing in the file is built: {message}", location, hint)

    def differs(self, kind: str, message: str, location: Location) -> None:
        """Something that ManiSkill's loader reads as something else, once a kind."""
        self.of(location).report_once("SC485", kind, message, location)

    def unread_element(self, element: Element) -> None:
        """An element that nothing is made of."""
        self._elements.setdefault(element.tag, []).append(element)

    def unread_attributes(self, element: Element, read: frozenset[str]) -> None:
        """The attributes of an element but for those that are read."""
        told = self._attributes.setdefault(element.tag, {})
        for name in element.attributes:
            if name not in read:
                told[name] = _first(told.get(name, element), element)

    def tell_unread(self) -> None:
        """Tells what was gathered: a warning a kind of element, and one for the attributes of each kind."""
        for kind, (message, location, hint) in self._unbuilt.items():
            self.left_out(kind, message, location, hint)
        for tag, elements in self._elements.items():
            count = f" (there are {len(elements)})" if len(elements) > 1 else ""
            place = reduce(_first, elements).location
            self.left_out(f"<{tag}>", f"`<{cut(tag)}>` is not read{count}", place, ELEMENT_HINTS.get(tag))
        for tag, names in self._attributes.items():
            if not names:
                continue
            # Of one element's they stand as written already.
            ordered = sorted(names, key=lambda name: (names[name].line, names[name].column))
            shown = ", ".join(f"`{cut(name)}`" for name in ordered[:20])
            more = f" and {len(ordered) - 20} more" if len(ordered) > 20 else ""
            verb = "are" if len(ordered) > 1 else "is"
            self.left_out(
                f"{tag}@",
                f"of `<{cut(tag)}>`, {shown}{more} {verb} not read",
                names[ordered[0]].at(ordered[0]),
                attribute_hint(tag, ordered),
            )


def _first(one: Element, other: Element) -> Element:
    """Which of two elements stands first in their file; of two files the one that was met first."""
    is_before = (other.line, other.column) < (one.line, one.column)
    return other if is_before and other.location.file == one.location.file else one
