"""Overrides of links and joints by name patterns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, suggest
from scenecc.lower.poses import lower_limits
from scenecc.spec.references import NamePattern, compile_name_pattern

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.articulations.drafts import ArticulationDraft, Layer
    from scenecc.lower.field_types import FieldType
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.materials import LoweredMaterial, MaterialChoice, MaterialLowerer
    from scenecc.plan import Value

MOST_MATCHING = 1_000_000_000
"""Limit of steps for all patterns of a document, a few seconds. Each pair of a pattern and a name counts once.

An untrusted file could have ten thousand patterns, and a robot with names of any length.
"""

_PAIR_STEPS = 5000
"""Steps that a pair costs besides its matching."""


class PatternMatcher:
    """Matches names with the patterns of a document, each pair once, up to `MOST_MATCHING` steps."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], bool] = {}
        self._patterns: dict[str, NamePattern] = {}
        self._left = MOST_MATCHING

    @property
    def exhausted(self) -> bool:
        """Whether the limit was exceeded. Further pairs do not match."""
        return self._left < 0

    def matches(self, pattern: str, name: str) -> bool:
        """Whether a pattern matches a whole name."""
        found = self._found.get((pattern, name))
        if found is None:
            read = self._patterns.get(pattern)
            if read is None:
                read = self._patterns[pattern] = compile_name_pattern(pattern)
            self._left -= _PAIR_STEPS + read.steps(len(name))
            found = self._found[pattern, name] = self._left >= 0 and read.matches(name)
        return found


class PatternOverrides:
    """The `links`, `joints` and `drives` of an articulation.

    Args:
        entity: the articulation as written.
        origin: of the entity.
        matching: of the document.
        sink: receives the diagnostics.
    """

    def __init__(self, entity: Any, origin: Origin, matching: PatternMatcher, sink: Sink) -> None:
        self._sink = sink
        self._matching = matching
        self._origin = origin
        self._maps: dict[str, list[tuple[str, Layer]]] = {
            section: [
                (pattern, (keys, origin.child(section, pattern))) for pattern, keys in getattr(entity, section).items()
            ]
            for section in ("links", "joints", "drives")
        }

    def layers(self, section: str, name: str) -> tuple[Layer, ...]:
        """The overrides of a link or a joint, in ascending precedence."""
        if self._matching.exhausted:
            return ()
        matches = self._matching.matches
        return tuple(layer for pattern, layer in self._maps[section] if matches(pattern, name))

    def check(self, drafts: Sequence[ArticulationDraft]) -> None:
        """Reports every pattern that matches nothing in any alternative of the entity."""
        links = _distinct(link.name for draft in drafts for link in draft.links)
        joints = [link.joint for draft in drafts for link in draft.links if link.joint is not None]
        moving = _distinct(joint.name for joint in joints if joint.moves)
        fixed = _distinct(joint.name for joint in joints if not joint.moves)
        for section, names in (("links", links), ("joints", moving), ("drives", moving)):
            for pattern, (_, origin) in self._maps[section]:
                if self._matches_any(pattern, names):
                    continue
                what = "link" if section == "links" else "joint that moves"
                still = section != "links" and self._matches_any(pattern, fixed)
                if self._matching.exhausted:
                    self._report_too_many()
                    return
                self._report_unmatched(pattern, what, names, still=still, origin=origin)

    def _matches_any(self, pattern: str, names: Sequence[str]) -> bool:
        return any(self._matching.matches(pattern, name) for name in names)

    def _report_too_many(self) -> None:
        message = f"matching the patterns with the names of links and joints takes more than {MOST_MATCHING} steps"
        self._sink.report("SC323", message, self._origin, at="key", hint="use one pattern for several links or joints")

    def _report_unmatched(self, pattern: str, what: str, names: Sequence[str], *, still: bool, origin: Origin) -> None:
        message = f"`{cut(pattern)}` matches no {what}"
        if still:
            message += ": it matches only fixed joints"
        self._sink.report("SC324", message, origin, at="key", hint=names_hint(names, pattern))


def names_hint(names: Sequence[str], wrong: str) -> str:
    """A hint with the closest existing names."""
    return suggest(wrong, filter(None, names)) or "none of them has a name"


def nearest_override(layers: Sequence[Layer], *keys: str) -> Layer | None:
    """The nearest layer with one of the keys."""
    for layer in reversed(layers):
        if any(getattr(layer[0], key, None) is not None for key in keys):
            return layer
    return None


def _distinct(names: Any) -> list[str]:
    unique: Mapping[str, None] = dict.fromkeys(names)
    return list(unique)


class OverrideValues:
    """The override values of one articulation.

    A pattern's value is drawn once and shared by all matching links or joints.

    Args:
        materials: of the document.
        fields: of the entity.
    """

    def __init__(self, materials: MaterialLowerer, fields: FieldLowerer) -> None:
        self.fields = fields
        self._materials = materials
        self._known: dict[tuple[int, str], Any] = {}

    def value(self, layers: Sequence[Layer], key: str, kind: FieldType, *, reset: bool | None = None) -> Value | None:
        """The value of a key in the nearest layer that has it; None if no layer has it."""
        layer = nearest_override(layers, key)
        return None if layer is None else self.of(layer, key, kind, reset=reset)

    def of(self, layer: Layer, key: str, kind: FieldType, *, reset: bool | None = None) -> Value:
        """The value of a key in a layer that has it."""
        keys, origin = layer
        found = self._known.get((id(keys), key))
        if found is None:
            found = self.fields.value(getattr(keys, key), kind, origin, key, reset=reset)
            self._known[id(keys), key] = found
        return found

    def limits(self, layer: Layer) -> Value | None:
        """The limits of a layer; None if it has none."""
        keys, origin = layer
        found = self._known.get((id(keys), "limits"))
        if found is None:
            found = self._known[id(keys), "limits"] = lower_limits(keys, origin, self.fields)
        return found

    def surface(self, layers: Sequence[Layer]) -> LoweredMaterial | MaterialChoice | None:
        """The material of the nearest layer that has one."""
        layer = nearest_override(layers, "material")
        if layer is None:
            return None
        keys, origin = layer
        found = self._known.get((id(keys), "material"))
        if found is None:
            found = self._known[id(keys), "material"] = self._materials.surface(keys.material, origin, self.fields)
        return found
