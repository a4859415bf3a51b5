"""The names that objects of a live scene have in its scene file: valid, and each once."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any, Final

from scenecc.decompiler.values import language_name

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from scenecc.names import UniqueNames


class SceneNames:
    """Names of entities, articulations, links and joints of one scene, by the objects.

    Attributes:
        rename: gives a name without what a simulator puts before it.
        problems: names that are replaced, one sentence for all objects of a name.
    """

    def __init__(self, rename: Callable[[str], str]) -> None:
        self.rename = rename
        self.problems: list[str] = []
        # The objects are kept, so that no other has the identity of one.
        self._names: dict[int, tuple[Any, str]] = {}

    def of(self, thing: Any) -> str:
        """The name of an object in the file; the object's own, made valid, where it was given none."""
        found = self._names.get(id(thing))
        return language_name(self.rename(thing.name)) if found is None else found[1]

    def keep(self, things: Sequence[Any]) -> None:
        """Gives objects their own names: a robot's file has them, whatever characters they are of."""
        for thing in things:
            self._names[id(thing)] = (thing, self.rename(thing.name))

    def replace(
        self, kind: str, things: Sequence[Any], otherwise: Sequence[str], within: UniqueNames, *, of: str = ""
    ) -> None:
        """Gives objects valid names, each once. Objects of one name are numbered from 0, as `repeat` numbers them.

        Args:
            kind: what the objects are: "entity", "link" or "joint".
            things: the objects.
            otherwise: the names of those that have none.
            within: names that are taken; the new ones are added.
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
"""New names in one sentence."""

_PLURALS: Final = {"entity": "entities", "link": "links", "joint": "joints"}


def _sentence(kind: str, given: str, names: Sequence[str], of: str) -> str:
    what = f"{len(names)} {_PLURALS[kind]}" if len(names) > 1 else f"{'an' if kind == 'entity' else 'a'} {kind}"
    what = f"{what} of `{of}`" if of else what
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    shown = ", ".join(f"`{name}`" for name in names[:_SHOWN]) + more
    what = f"the name {given!r} of {what}" if given else f"{what} without a name"
    return f"{what}; {'they are' if len(names) > 1 else 'it is'} called {shown}"
