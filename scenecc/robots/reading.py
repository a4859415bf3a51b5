"""Numbers and names in the attributes of XML."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

import numpy as np

from scenecc.diagnostics.messages import cut

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.diagnostics import Location
    from scenecc.robots.description import Vector3
    from scenecc.robots.findings import Findings
    from scenecc.robots.xml import Element

LARGEST, SMALLEST = float(np.finfo(np.float32).max), float(np.finfo(np.float32).tiny)
"""Of the numbers that the engine's single precision has, and of those above 0 that are no 0 there."""

MOST_TURNED, MOST_DEGREES = 4 * math.pi * (1 + 1e-6), 720.0
"""Two turns in radians and in degrees. Between the two, degrees are meant; beyond, as many files have it, no limit."""

_NUMBER = re.compile(r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf(?:inity)?|nan)", re.IGNORECASE)
_LONGEST = 400


def parse_number(text: str) -> float | None:
    """A number as both XML schema and Python write it; None: it is none."""
    text = text.strip()
    return float(text) if len(text) <= _LONGEST and _NUMBER.fullmatch(text) else None


def word(element: Element, attribute: str, findings: Findings) -> str | None:
    """The value of an attribute that must be there and not be blank (SC455)."""
    value = element.attributes.get(attribute, "").strip()
    if value:
        return element.attributes[attribute]
    missing = attribute not in element.attributes
    message = f"<{element.tag}> has no `{attribute}`" if missing else f"the `{attribute}` of <{element.tag}> is empty"
    findings.report("SC455", message, element.at(attribute))
    return None


def number(element: Element, attribute: str, findings: Findings, *, infinite: bool = False) -> float | None:
    """The number of an attribute that must be there (SC455), finite unless `infinite`, and none too large (SC456)."""
    if word(element, attribute, findings) is None:
        return None
    found = _checked(element, attribute, element.attributes[attribute].split() or [""], 1, findings, infinite=infinite)
    return None if found is None else found[0]


def optional_number(
    element: Element, attribute: str, findings: Findings, *, infinite: bool = False
) -> tuple[float | None, bool]:
    """The number of an attribute, None where it is not there, and whether all is well."""
    if attribute not in element.attributes:
        return None, True
    found = number(element, attribute, findings, infinite=infinite)
    return found, found is not None


def three(element: Element, attribute: str, findings: Findings) -> Vector3 | None:
    """Three numbers of an attribute that must be there."""
    found = several(element, attribute, 3, findings)
    return None if found is None else (found[0], found[1], found[2])


def several(element: Element, attribute: str, count: int, findings: Findings) -> tuple[float, ...] | None:
    """So many numbers, parted by blanks, of an attribute that must be there (SC455, SC456)."""
    if word(element, attribute, findings) is None:
        return None
    return _checked(element, attribute, element.attributes[attribute].split(), count, findings, infinite=False)


def doubt_degrees(angles: Iterable[float], what: str, location: Location, findings: Findings) -> None:
    """Warns, once for what they are, of angles [rad] that were probably meant in degrees."""
    angle = max((size for size in map(abs, angles) if MOST_TURNED < size <= MOST_DEGREES), default=None)
    if angle is not None:
        message = f"{what} of {angle:g} radians: that is {angle / math.tau:.3g} turns"
        findings.report_once(
            "SC526", what, message, location, "angles are radians here; there may be more in this file"
        )


def _checked(
    element: Element, attribute: str, words: list[str], count: int, findings: Findings, *, infinite: bool
) -> tuple[float, ...] | None:
    where = f"the `{attribute}` of <{element.tag}>"
    if len(words) != count:
        wanted = "one number" if count == 1 else f"{count} numbers"
        findings.report(
            "SC456", f"{where} wants {wanted}, parted by blanks, and has {len(words)}", element.at(attribute)
        )
        return None
    values: list[float] = []
    for text in words:
        value = parse_number(text)
        if value is None:
            findings.report("SC456", f"{where} holds `{cut(text)}`, which is no number", element.at(attribute))
            return None
        if math.isnan(value) or (math.isinf(value) and not infinite):
            findings.report("SC456", f"{where} holds `{text}`, which is no finite number", element.at(attribute))
            return None
        if math.isfinite(value) and abs(value) > LARGEST:
            findings.report(
                "SC456", f"{where} holds `{cut(text)}`, beyond the engine's single precision", element.at(attribute)
            )
            return None
        values.append(value)
    return tuple(values)
