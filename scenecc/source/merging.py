"""Merge keys (`<<`) of a text that is read by its events."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

from scenecc.source.tags import kind

if TYPE_CHECKING:
    from scenecc.diagnostics import Path
    from scenecc.source.faults import Faults
    from scenecc.source.parsing import NodeEvent


@dataclass(slots=True)
class _Merge:
    """A merge key that was read: where, and the keys it brought that no explicit key has replaced."""

    event: NodeEvent
    keys: set[str] = field(default_factory=set[str])


class Merges:
    """The merge keys of the mappings of one text, which stay alive as long as this does."""

    def __init__(self, faults: Faults) -> None:
        self._faults = faults
        self._merges: dict[int, _Merge] = {}
        """id of a mapping → its merge key."""

    def merge(self, value: object, event: NodeEvent, node: dict[str, Any], path: Path) -> None:
        """Takes the value of a merge key: its entries come to stand in a mapping that has none of their keys.

        Args:
            value: as it was read.
            event: of the key.
            node: the mapping that has the key.
            path: of the key.
        """
        first = self._merges.get(id(node))
        if first is not None:
            place = self._faults.span(first.event.start_mark, first.event.end_mark)
            hint = "merge several mappings with a list: `<<: [*a, *b]`"
            related = (("first written here", place),)
            self._faults.at("SC004", "the key `<<` is written twice", event, path=path, hint=hint, related=related)
            return
        merge = self._merges[id(node)] = _Merge(event)
        for source in cast("list[object]", value) if isinstance(value, list) else [value]:
            if not isinstance(source, dict):
                self._refuse(source, event, path)
                continue
            for key, item in cast("dict[str, Any]", source).items():
                if key not in node:
                    node[key] = item
                    merge.keys.add(key)

    def brought(self, key: str, node: dict[str, Any]) -> bool:
        """Whether a mapping has a key by merging alone, so that it may still be written."""
        merge = self._merges.get(id(node))
        return merge is not None and key in merge.keys

    def replace(self, key: str, node: dict[str, Any]) -> None:
        """Notes that a key is written in a mapping."""
        merge = self._merges.get(id(node))
        if merge is not None:
            merge.keys.discard(key)

    def _refuse(self, source: object, event: NodeEvent, path: Path) -> None:
        if source is not None:  # else it was reported where it stands
            hint = "write `<<: *anchor` or `<<: [*one, *other]`, anchors of mappings; to use `<<` as a key quote it"
            self._faults.at("SC011", f"`<<` merges mappings, not {kind(source)}", event, path=path, hint=hint)
