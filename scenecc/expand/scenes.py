"""The scenes of instances."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import show
from scenecc.expand.ranges import form_of
from scenecc.expand.run import Exhausted
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.spec.selection import select

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Path, Sink

Selection = tuple[int, ...] | None
"""Scene indices, ascending; None for every scene."""


_ITEMS = (int, str)


class Scenes:
    """Selections, each read once.

    Args:
        count: how many scenes there are.
        most: how many may be selected in all, each selection counted once.
        sink: takes the diagnostics.
    """

    def __init__(self, count: int, most: int, sink: Sink) -> None:
        self.count = count
        self._sink = sink
        self._known: dict[str, tuple[int, ...]] = {}
        self._narrowed: dict[tuple[str, int], tuple[tuple[int, ...], tuple[int, ...]]] = {}
        self._most = self._left = most

    def narrowed(self, given: Any, outer: Selection, place: Origin) -> Selection:
        """The scenes of what selects some inside of what is in others. Empty where the selection was reported.

        Raises:
            Exhausted: all that was selected comes to more than may be; that is reported.
        """
        key = repr(given)
        if key not in self._known:
            self._known[key] = self._counted(self._select(given, place) or (), place)
        chosen = self._known[key]
        if outer is None or not chosen:
            return chosen
        # By identity: what is in one instance is narrowed by the same scenes, which are kept.
        found = self._narrowed.get((key, id(outer)))
        if found is None:
            among = frozenset(outer)
            narrowed = self._counted(tuple(scene for scene in chosen if scene in among), place)
            found = self._narrowed[key, id(outer)] = (outer, narrowed)
        return found[1]

    def _counted(self, selection: tuple[int, ...], place: Origin) -> tuple[int, ...]:
        self._left -= len(selection)
        if self._left < 0:
            message = f"what instances select comes to more than {self._most} scenes in all"
            hint = "raise the limit with --limit objects_times_scenes=N or limits={'objects_times_scenes': N}"
            self._sink.report("SC606", message, place, hint=hint)
            raise Exhausted
        return selection

    def _select(self, given: Any, place: Origin) -> Selection:
        # An expression may have given anything.
        if isinstance(given, str) or (is_sequence(given) and all(type(item) in _ITEMS for item in given)):
            return select(given if isinstance(given, str) else list(given), self.count, place, self._sink)
        message = f'`scene_idxs` must be a list of indices, or a slice such as "0:8", not {show(given)}'
        self._sink.report("SC103", message, place)
        return None

    def by_scene(
        self, value: Any, selection: tuple[int, ...], path: Path, turned: dict[Path, tuple[int, ...]]
    ) -> tuple[Any, Path | None]:
        """A value with its `per_scene` lists, one item for each selected scene, as mappings by scene index.

        Args:
            value: plain, or a form.
            selection: the scenes.
            path: of the value.
            turned: takes the scenes of each such list, by its path.

        Returns:
            The value, and where a list of another length is; None where none is.
        """
        form = form_of(value)
        if form is None:
            return value, None
        items = value[form]
        if form == "per_scene" and is_sequence(items) and len(items) != len(selection):
            return value, (*path, form)
        pairs = items.items() if is_mapping(items) else enumerate(items) if is_sequence(items) else ()
        changed: dict[Any, Any] = {}
        for key, item in pairs:
            changed[key], wrong = self.by_scene(item, selection, (*path, form, key), turned)
            if wrong is not None:
                return value, wrong
        if form == "per_scene" and is_sequence(items):
            # The draw exists in every scene, though it is read in the selected ones alone.
            turned[(*path, form)] = selection
            rows = {str(scene): changed[index] for index, scene in enumerate(selection)}
            return {**value, form: {**rows, "default": changed[0]}}, None
        kept: Any = changed if is_mapping(items) else list(changed.values()) if is_sequence(items) else items
        return {**value, form: kept}, None
