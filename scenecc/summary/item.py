"""What is said of a scene, as a tree: one form for people and for programs."""

from __future__ import annotations

from typing import Any, Final

from scenecc.diagnostics.frozen import frozen

_LABELS: Final = {
    "num_scenes": "scenes",
    "description": "",
    "scene_idxs": "scenes",
    "pose.p": "at",
    "pose.q": "turned",
    "link_count": "links",
    "roles": "",
    "number": "",
    "defaults": "",
    "bytes": "",
}
"""How facts are introduced to people, where not by their names."""


@frozen
class Fact:
    """One thing that is said.

    Attributes:
        name: as scene files have it, where they have it.
        value: plain data, in SI units; infinite numbers are the texts "inf" and "-inf". Of what scenes differ in and no
            scene was asked for, a mapping: `alternatives`, or `low` and `high`, and `at_reset` where a reset draws it.
        words: for people, with the unit; "" is for programs alone.
    """

    name: str
    value: Any
    words: str

    @property
    def label(self) -> str:
        """What introduces it to people; "" where its words do so themselves."""
        return _LABELS.get(self.name, self.name)


@frozen
class Item:
    """One thing of which something is said.

    Attributes:
        name: "" where it has none.
        type: what it is; "" where its group says so.
        facts: in order, each name once.
        groups: what it is made of, by the kind of these things, in order: one item, or any number.
        hidden: how many items were left out below it, in all.
        under: of an item that hangs on another of its group, as links do: that one's number, less than its own.
    """

    name: str
    type: str
    facts: tuple[Fact, ...] = ()
    groups: tuple[tuple[str, Item | tuple[Item, ...]], ...] = ()
    hidden: int = 0
    under: int | None = None

    def data(self) -> dict[str, Any]:
        """The same as plain data, for programs."""
        found: dict[str, Any] = {}
        if self.name:
            found["name"] = self.name
        if self.type:
            found["type"] = self.type
        found |= {fact.name: fact.value for fact in self.facts}
        for name, group in self.groups:
            found[name] = group.data() if isinstance(group, Item) else [item.data() for item in group]
        if self.hidden:
            found["hidden"] = self.hidden
        return found

    def cut(self, depth: int) -> Item:
        """The same with nothing further than so many items below it."""
        if depth > 0:
            groups = tuple((name, _cut(group, depth - 1)) for name, group in self.groups)
            return Item(self.name, self.type, self.facts, groups, under=self.under)
        return Item(self.name, self.type, self.facts, hidden=self.count(), under=self.under)

    def count(self) -> int:
        """How many items are below it."""
        items = [item for _, group in self.groups for item in ((group,) if isinstance(group, Item) else group)]
        return len(items) + sum(item.count() for item in items)


def _cut(group: Item | tuple[Item, ...], depth: int) -> Item | tuple[Item, ...]:
    return group.cut(depth) if isinstance(group, Item) else tuple(item.cut(depth) for item in group)


def some_words(names: tuple[str, ...], most: int = 3) -> str:
    """Some of many names."""
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")
