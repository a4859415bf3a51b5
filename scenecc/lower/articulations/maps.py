"""Which links and joints the patterns of an articulation match."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, nearest
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.name_patterns import name_pattern

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.articulations.draft import Draft, Layer

_SHOWN = 12
"""How many names a hint lists."""

MOST_MATCHING = 5_000_000
"""Patterns times characters of the names that they are matched with, in a whole document; what was matched once is
remembered. Some seconds: a stranger's file could name ten thousand patterns, and a robot with names of any length.
"""


class Matching:
    """Matches names with the patterns of a document, each pair once, and no more than `MOST_MATCHING`."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], bool] = {}
        self._left = MOST_MATCHING

    @property
    def exhausted(self) -> bool:
        """Whether there is more to be matched than is: what is left over matches nothing."""
        return self._left < 0

    def matches(self, pattern: str, name: str) -> bool:
        """Whether a pattern matches a whole name."""
        found = self._found.get((pattern, name))
        if found is None:
            self._left -= len(name) + 1
            found = self._found[pattern, name] = self._left >= 0 and name_pattern(pattern).matches(name)
        return found


class Maps:
    """The `links`, `joints` and `drives` of an articulation.

    Args:
        entity: the articulation as written.
        origin: of it.
        matching: of the document.
        sink: takes the diagnostics.
    """

    def __init__(self, entity: Any, origin: Origin, matching: Matching, sink: Sink) -> None:
        self._sink = sink
        self._matching = matching
        self._origin = origin
        self._maps: dict[str, list[tuple[str, Layer]]] = {
            section: [
                (pattern, (keys, origin.child(section, pattern)))
                for pattern, keys in getattr(entity, section).items()
                if not pattern.startswith(NOTE_PREFIX)
            ]
            for section in ("links", "joints", "drives")
        }

    def layers(self, section: str, name: str) -> tuple[Layer, ...]:
        """What is said of a link or a joint, the later the nearer."""
        matches = self._matching.matches
        return tuple(layer for pattern, layer in self._maps[section] if matches(pattern, name))

    def check(self, drafts: Sequence[Draft]) -> None:
        """Reports every pattern that matches nothing in any of the articulations that the entity may be."""
        links = _distinct(link.name for draft in drafts for link in draft.links)
        joints = [link.joint for draft in drafts for link in draft.links if link.joint is not None]
        moving = _distinct(joint.name for joint in joints if joint.moves)
        fixed = _distinct(joint.name for joint in joints if not joint.moves)
        for section, names in (("links", links), ("joints", moving), ("drives", moving)):
            for pattern, (_, origin) in self._maps[section]:
                if self._any(pattern, names):
                    continue
                what = "link" if section == "links" else "joint that moves"
                still = section != "links" and self._any(pattern, fixed)
                if self._matching.exhausted:
                    self._too_many()
                    return
                self._nothing(pattern, what, names, still=still, origin=origin)

    def _any(self, pattern: str, names: Sequence[str]) -> bool:
        return any(self._matching.matches(pattern, name) for name in names)

    def _too_many(self) -> None:
        message = f"patterns times characters of the names they may match are more than {MOST_MATCHING} here"
        self._sink.report("SC323", message, self._origin, at="key", hint="name several links or joints by one pattern")

    def _nothing(self, pattern: str, what: str, names: Sequence[str], *, still: bool, origin: Origin) -> None:
        message = f"`{cut(pattern)}` matches no {what}"
        if still:
            message += ": what it matches is fixed"
        self._sink.report("SC324", message, origin, at="key", hint=listed(names, pattern))


def listed(names: Sequence[str], wrong: str) -> str:
    """A hint with the names that there are, the one that was probably meant first."""
    known = [name for name in names if name]
    if not known:
        return "there is none that has a name"
    near = nearest(wrong, known)
    shown = ", ".join(f"`{cut(name)}`" for name in known[:_SHOWN])
    rest = f" and {len(known) - _SHOWN} more" if len(known) > _SHOWN else ""
    return (f"did you mean `{near}`? " if near is not None else "") + f"there are {shown}{rest}"


def said(layers: Sequence[Layer], *keys: str) -> Layer | None:
    """The nearest of some layers that has a key, or one of several."""
    for layer in reversed(layers):
        if any(getattr(layer[0], key, None) is not None for key in keys):
            return layer
    return None


def _distinct(names: Any) -> list[str]:
    unique: Mapping[str, None] = dict.fromkeys(names)
    return list(unique)
