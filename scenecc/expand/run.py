"""The state of expanding one document in one place: values, and whom to tell what is wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

from scenecc.expand.expansion import Mark

if TYPE_CHECKING:
    from collections.abc import Iterable
    from collections.abc import Set as AbstractSet

    from scenecc.diagnostics import Location, Origin, Path, Sink
    from scenecc.diagnostics.diagnostic import RelatedPlace
    from scenecc.diagnostics.origin import At
    from scenecc.expand.expansion import Items
    from scenecc.expand.loops import Loop
    from scenecc.values.failure import ExpressionError

_MOST_SHOWN = 10**18

_PER_ARGUMENT = 8
"""How many values of an argument count as an object: each is looked through in every use."""


class Failed(str):
    """Stands for a scalar whose value was reported, or reads something that was; nothing more is said about it."""

    __slots__ = ()


class Exhausted(Exception):
    """A limit was reached and reported: nothing more is expanded."""


class Budget:
    """How many of something may still be made.

    Args:
        code: of the report when there are more.
        what: they are.
        name: of the limit.
        most: the limit.
    """

    def __init__(self, code: str, what: str, name: str, most: int) -> None:
        self._code, self._what, self._name = code, what, name
        self._most = self._left = most

    def take(self, count: int, run: Run, path: Path) -> None:
        """Takes so many away.

        Raises:
            Exhausted: there are not so many; that is reported.
        """
        self._left -= count
        if self._left < 0:
            self._exhaust(run.sink, run.origin(path))

    def take_for(self, values: int, place: Origin | Location, sink: Sink) -> None:
        """Takes as many away as so many values of an argument count for.

        Raises:
            Exhausted: there are not so many; that is reported.
        """
        self._left -= values // _PER_ARGUMENT
        if self._left < 0:
            self._exhaust(sink, place)

    @property
    def most_values(self) -> int:
        """How many values an argument may still hold, and one more object."""
        return (self._left + 1) * _PER_ARGUMENT

    def _exhaust(self, sink: Sink, place: Origin | Location) -> NoReturn:
        needed = self._most - self._left
        shown = f"at least {needed}" if needed <= _MOST_SHOWN else "more than 10¹⁸"
        hint = f"raise it with --limit {self._name}=N or limits={{'{self._name}': N}}"
        message = f"{shown} {self._what} are more than the limit of {self._most}"
        sink.report(self._code, message, place, hint=hint)
        raise Exhausted


class Run:
    """One document as it is expanded in one place: for one use of it, and for one copy of what is repeated in it.

    Attributes:
        file: the document's name.
        parent: what brought it in; None for the top document.
        values: name → value of parameters, loop variables and the like. Changes from copy to copy.
        failed: names without a value, which was reported.
        objects: how many may still be made.
        sink: takes the diagnostics.
        copies: the loops around, with the number of the copy in each.
        lists: of the lists with repeated items met so far, what their items stand for.
    """

    __slots__ = ("copies", "failed", "file", "lists", "objects", "parent", "sink", "values")

    def __init__(
        self,
        file: str | None,
        parent: Origin | None,
        values: dict[str, Any],
        objects: Budget,
        sink: Sink,
        failed: AbstractSet[str] = frozenset(),
    ) -> None:
        self.file = file
        self.parent = parent
        self.values = values
        self.failed = failed
        self.objects = objects
        self.sink = sink
        self.copies: list[tuple[Loop, int]] = []
        self.lists: dict[Path, tuple[Items, ...]] = {}

    def mark(self, path: Path) -> Mark:
        """The place of a node of the document, in the copy at hand."""
        return Mark(self.file, path, self.parent, tuple(self.copies))

    def origin(self, path: Path) -> Origin:
        """The same, as it is told."""
        return self.mark(path).origin

    def report(
        self,
        code: str,
        message: str,
        path: Path,
        *,
        at: At = "value",
        hint: str | None = None,
        related: Iterable[RelatedPlace] = (),
    ) -> None:
        """Reports something about a node of the document."""
        self.sink.report(code, message, self.origin(path), at=at, hint=hint, related=related)

    def fail(self, error: ExpressionError, path: Path, code: str = "SC202") -> None:
        """Reports an expression, at its place within the scalar at `path`."""
        self.sink.report(code, error.message, self.origin(path), hint=error.hint, span=(error.start, error.end))
