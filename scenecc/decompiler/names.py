"""Assigns valid, unique names to objects of a live scene."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any, Final

from scenecc.decompiler.values import language_name

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from scenecc.names import UniqueNames


class SceneNames:
    """Names of entities, articulations, links and joints of one scene.

    Attributes:
        rename: removes a simulator's prefix from a name.
        problems: replaced names, one sentence per original name.
    """

    def __init__(self, rename: Callable[[str], str]) -> None:
        self.rename = rename
        self.problems: list[str] = []
        # The objects are kept alive, so that ids stay unique.
        self._names: dict[int, tuple[Any, str]] = {}

    def of(self, thing: Any) -> str:
        """Returns the assigned name of an object; else its own, made valid."""
        found = self._names.get(id(thing))
        return language_name(self.rename(thing.name)) if found is None else found[1]

    def keep(self, things: Sequence[Any]) -> None:
        """Keeps the objects' own names, which come from a robot's file and may have any characters."""
        for thing in things:
            self._names[id(thing)] = (thing, self.rename(thing.name))

    def replace(
        self, kind: str, things: Sequence[Any], otherwise: Sequence[str], within: UniqueNames, *, of: str = ""
    ) -> None:
        """Assigns valid, unique names. Objects with the same name are numbered from 0, as `repeat` does.

        Args:
            kind: "entity", "link" or "joint".
            things: the objects.
            otherwise: names for objects without one.
            within: names in use; new ones are added.
            of: the articulation of links and joints.
        """
        given = [self.rename(thing.name) for thing in things]
        wishes = [language_name(name, local=bool(of)) or other for name, other in zip(given, otherwise, strict=True)]
        counts, uses = Counter(wishes), Counter(given)
        own = [wish == name and uses[name] == 1 for wish, name in zip(wishes, given, strict=True)]
        counts.subtract(wish for wish, stays in zip(wishes, own, strict=True) if stays)
        names = {index: within.new(wishes[index]) for index, stays in enumerate(own) if stays}
        numbers = Counter[str]()
        for index, wish in enumerate(wishes):
            if not own[index]:
                names[index] = within.new(f"{wish}_{numbers[wish]}" if counts[wish] > 1 else wish)
                numbers[wish] += 1
        replaced: dict[str, list[str]] = {}
        for index, thing in enumerate(things):
            self._names[id(thing)] = (thing, names[index])
            if names[index] != given[index]:
                replaced.setdefault(given[index], []).append(names[index])
        self.problems += [_sentence(kind, name, found, of) for name, found in replaced.items()]


_SHOWN: Final = 3
"""Maximum number of new names in one sentence."""

_PLURALS: Final = {"entity": "entities", "link": "links", "joint": "joints"}


def _sentence(kind: str, given: str, names: Sequence[str], of: str) -> str:
    what = f"{len(names)} {_PLURALS[kind]}" if len(names) > 1 else f"{'an' if kind == 'entity' else 'a'} {kind}"
    what = f"{what} of `{of}`" if of else what
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    shown = ", ".join(f"`{name}`" for name in names[:_SHOWN]) + more
    what = f"the name {given!r} of {what}" if given else f"{what} without a name"
    return f"{what}; {'they are' if len(names) > 1 else 'it is'} named {shown}"
