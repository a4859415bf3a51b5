"""What of a repeated node is the same in every copy: made once, and then one object in all of them.

Not only is it made once. The stages that follow know by its identity what they have looked at already.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.expand.contents import has_failed
from scenecc.expand.patterns import Entries, Pattern, Repeated, Scalar, Sequenced

if TYPE_CHECKING:
    from collections.abc import Collection

    from scenecc.expand.run import Run


class Still:
    """A pattern that reads none of a loop's variables, within that loop."""

    __slots__ = ("_made", "_pattern")

    def __init__(self, pattern: Pattern) -> None:
        self._pattern = pattern
        self._made: Any = None

    def make(self, run: Run) -> Any:
        """What it made before. What was reported is made anew, so that it is told of each copy."""
        if self._made is not None:
            return self._made
        made = self._pattern.make(run)
        if not has_failed(made):
            self._made = made
        return made


def stilled(pattern: Pattern, variables: Collection[str]) -> Pattern:
    """The same pattern, for the copies of one loop alone.

    Args:
        pattern: of what is repeated.
        variables: of the loop; all other values stay as they are in it.
    """
    match pattern:
        case Scalar(template):
            return Still(pattern) if template.names.isdisjoint(variables) else pattern
        case Entries(node, patterns):
            inner = tuple((key, stilled(item, variables)) for key, item in patterns)
            return _together(Entries(node, inner))
        case Sequenced(node, patterns):
            parts = tuple((index, stilled(item, variables)) for index, item in patterns)
            return _together(Sequenced(node, parts))
        case Repeated():
            # Each copy notes what the items of its list stand for.
            return pattern
        case _:
            return pattern


def _together(pattern: Entries | Sequenced) -> Pattern:
    return Still(pattern) if all(isinstance(item, Still) for _, item in pattern.patterns) else pattern
