"""Anchors, and how much is reached through aliases to them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, cast

from scenecc.source.faults import Faults, Stopped

if TYPE_CHECKING:
    from scenecc.diagnostics import Path
    from scenecc.source.limits import Limits
    from scenecc.source.parsing import NodeEvent

Container = dict[str, Any] | list[Any]


class Aliases:
    """The anchors of one document.

    Aliases share what they name, so a text of a few lines can unfold to any size: each use counts all the
    nodes below the anchor, and the depth is that of the document unfolded.
    """

    def __init__(self, faults: Faults, limits: Limits) -> None:
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
            stop_at_depth(self._faults, self._limits, event, path)
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
        raise Stopped

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


def stop_at_depth(faults: Faults, limits: Limits, event: NodeEvent, path: Path) -> None:
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
    raise Stopped
