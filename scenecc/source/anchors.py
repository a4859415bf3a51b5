"""Anchors, aliases and merge keys (`<<`) of a text, with the limit on the nodes that aliases reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

from scenecc.source.events import describe_type
from scenecc.source.syntax_errors import ReadAborted, SourceReporter

if TYPE_CHECKING:
    from scenecc.diagnostics import Path
    from scenecc.source.events import NodeEvent
    from scenecc.source.limits import Limits


Container = dict[str, Any] | list[Any]


class AnchorTable:
    """The anchors of one document.

    Aliases share what they name, so a text of a few lines can unfold to any size: each use counts all the
    nodes below the anchor, and the depth is that of the document unfolded.
    """

    def __init__(self, faults: SourceReporter, limits: Limits) -> None:
        self._faults = faults
        self._limits = limits
        self._anchors: dict[str, Any] = {}
        # id of a container below an anchor → its nodes and its height, aliases unfolded.
        self._sizes: dict[int, tuple[int, int]] = {}
        self._reached = 0

    def define(self, name: str, value: Any) -> None:
        """Gives a name to a value; the latest definition of a name is the one that counts."""
        self._anchors[name] = value

    def follow(self, event: NodeEvent, ancestors: Sequence[Container], path: Path) -> Any:
        """What an alias names; None, reported, where it names nothing that can stand there."""
        name = event.anchor or ""
        if name not in self._anchors:
            self._faults.at(
                "SC009",
                f"no anchor `&{name}` stands before this alias",
                event,
                path=path,
                hint="a string that starts with `*` must be quoted",
            )
            return None
        value = self._anchors[name]
        if any(value is ancestor for ancestor in ancestors):
            self._faults.at("SC010", f"the alias `*{name}` stands inside the node it names", event, path=path)
            return None
        nodes, height = self._measure(value)
        self._reached += nodes
        if self._reached > self._limits.alias_nodes:
            self._stop(event, path)
        if len(ancestors) + height > self._limits.depth:
            abort_at_depth(self._faults, self._limits, event, path)
        return value

    def _stop(self, event: NodeEvent, path: Path) -> None:
        self._faults.at(
            "SC603",
            f"more than {self._limits.alias_nodes} nodes are reached through aliases (limit alias_nodes)",
            event,
            path=path,
            hint="`repeat` writes many copies without aliases; `--limit alias_nodes=N` or "
            "`limits={'alias_nodes': N}` raises the limit",
        )
        raise ReadAborted

    def _measure(self, value: Any) -> tuple[int, int]:
        """Nodes and height of a closed node: 1 and 0 for a scalar."""
        if not isinstance(value, (dict, list)):
            return 1, 0
        node = cast("Container", value)
        known = self._sizes.get(id(node))
        if known is None:
            children = node.values() if isinstance(node, dict) else node
            sizes = [self._measure(child) for child in children]
            known = 1 + sum(nodes for nodes, _ in sizes), 1 + max((height for _, height in sizes), default=0)
            self._sizes[id(node)] = known
        return known


def abort_at_depth(faults: SourceReporter, limits: Limits, event: NodeEvent, path: Path) -> None:
    """Reports that the document is too deep at an event.

    Raises:
        Stopped: always.
    """
    faults.at(
        "SC602",
        f"more than {limits.depth} mappings and lists inside one another (limit depth)",
        event,
        path=path[:8],
        hint="`--limit depth=N` or `limits={'depth': N}` raises the limit",
    )
    raise ReadAborted


@dataclass(slots=True)
class _MergeKey:
    """A merge key that was read: where, and the keys it brought that no explicit key has replaced."""

    event: NodeEvent
    keys: set[str] = field(default_factory=set[str])


class MergeKeys:
    """The merge keys of the mappings of one text, which stay alive as long as this does."""

    def __init__(self, faults: SourceReporter) -> None:
        self._faults = faults
        self._merges: dict[int, _MergeKey] = {}
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
        merge = self._merges[id(node)] = _MergeKey(event)
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
            self._faults.at("SC011", f"`<<` merges mappings, not {describe_type(source)}", event, path=path, hint=hint)
