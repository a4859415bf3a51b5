"""Attributes of an MJCF's elements: what stands in them, their classes' values among them, and whether it may."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from scenecc.diagnostics.messages import cut
from scenecc.robots.reading import LARGEST, parse_number

if TYPE_CHECKING:
    from scenecc.diagnostics import Location
    from scenecc.robots.mjcf.report import Report
    from scenecc.robots.xml import Element

_INTEGER = re.compile(r"[+-]?\d{1,9}", re.ASCII)

ORIENTATIONS = ("quat", "euler", "axisangle", "xyaxes", "zaxis")
"""The ways to say how something is turned."""


def single(value: float) -> float:
    """A number as ManiSkill's loader and the engine hold it."""
    return float(np.float32(value))


@dataclass(frozen=True, slots=True)
class Attributes:
    """The attributes of an element.

    Attributes:
        element: whose they are.
        given: name → the element that gives it: itself, or one of its class's.
        report: where faults go.
    """

    element: Element
    given: Mapping[str, Element] = field(repr=False)
    report: Report = field(repr=False)

    def __contains__(self, name: str) -> bool:
        return name in self.given

    def text(self, name: str, default: str = "") -> str:
        """The attribute as it is written."""
        giver = self.given.get(name)
        return default if giver is None else giver.attributes[name]

    def at(self, name: str) -> Location:
        """Where an attribute stands, which may be in a class; the element where it has none."""
        return self.given.get(name, self.element).at(name)

    def word(self, name: str, words: Sequence[str], default: str) -> str:
        """An attribute that is one of a few words; the default, reported, where it is none."""
        text = self.text(name, default)
        if text in words:
            return text
        self.wrong(name, f"is one of {', '.join(words)}, not `{cut(text)}`")
        return default

    def integer(self, name: str, default: int) -> int:
        """An attribute that is a whole number."""
        text = self.text(name).strip()
        if name in self and _INTEGER.fullmatch(text) is None:
            self.wrong(name, f"is a whole number, not `{cut(text)}`")
            return default
        return int(text) if name in self else default

    def number(self, name: str, default: float, low: float = -math.inf, high: float = math.inf) -> float:
        """An attribute that is one number, no less than `low` and no more than `high`; in double precision."""
        values = self.numbers(name, (default,))
        if not low <= values[0] <= high:
            bounds = f"at least {low:g}" if high == math.inf else f"between {low:g} and {high:g}"
            self.wrong(name, f"is {bounds}, not {values[0]:g}")
            return default
        return values[0]

    def numbers(
        self, name: str, default: tuple[float, ...], *, least: int | None = None, infinite: bool = False
    ) -> tuple[float, ...]:
        """An attribute that is some numbers, in double precision; the default, reported, where it is not.

        Args:
            name: of the attribute.
            default: where it is not given or wrong, the same object; it tells how many numbers there are at most.
            least: how many there are at least; None: as many as in the default.
            infinite: whether they may be.
        """
        if name not in self:
            return default
        parts = self.text(name).split()
        count = len(default)
        least = count if least is None else least
        if not least <= len(parts) <= count:
            wanted = f"{count} number{'s' if count > 1 else ''}" if least == count else f"{least} to {count} numbers"
            self.wrong(name, f"is {wanted}, not {len(parts)}")
            return default
        values: list[float] = []
        for part in parts:
            value = parse_number(part)
            if value is None or math.isnan(value) or (math.isinf(value) and not infinite):
                self.wrong(name, f"holds `{cut(part)}`, which is no {'' if value is None else 'finite '}number")
                return default
            if math.isfinite(value) and abs(value) > LARGEST:
                self.wrong(name, f"holds `{cut(part)}`, beyond the engine's single precision")
                return default
            values.append(value)
        return tuple(values)

    def singles(
        self, name: str, default: tuple[float, ...], *, least: int | None = None, infinite: bool = False
    ) -> tuple[float, ...]:
        """As `numbers`, in single precision."""
        return tuple(map(single, self.numbers(name, default, least=least, infinite=infinite)))

    def orientation(self) -> str | None:
        """Which way to say a rotation is used: the element's own before its class's; two at once are an error."""
        own = [name for name in ORIENTATIONS if name in self.element.attributes]
        if len(own) > 1:
            self.wrong(own[1], f"says how it is turned, and so does `{own[0]}`")
        if own:
            return own[0]
        return next((name for name in ORIENTATIONS if name in self), None)

    def wrong(self, name: str, what: str, hint: str | None = None) -> None:
        """Reports an attribute's value."""
        tag = self.given.get(name, self.element).tag
        self.report.error("SC481", f"`{name}` of `<{tag}>` {what}", self.at(name), hint)


def own_attributes(element: Element, report: Report) -> Attributes:
    """The attributes that stand in an element itself."""
    return Attributes(element, dict.fromkeys(element.attributes, element), report)
