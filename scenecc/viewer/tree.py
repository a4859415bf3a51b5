"""The object tree of a page: folders of names, a search, and marks for selected, hidden or locked objects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import viser

from scenecc.diagnostics.frozen import frozen
from scenecc.interrupt import interrupts_wait
from scenecc.viewer.head import TREE
from scenecc.viewer.texts import line

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from scenecc.viewer.nodes import Key

    Objects = Mapping[int, Sequence[tuple[str, tuple[str, ...]]]]
    """Scene → names of entities, each with the names of its links."""

_MOST_ROWS: Final = 200
"""Maximum number of rows: a browser draws a button for each."""

_FEW_ROWS: Final = 30
"""Up to this many rows, folders start expanded."""

_PLAIN, _SELECTED = "gray", "orange"
"""Colours of rows."""


@frozen
class Branch:
    """A row or folder of the tree.

    Attributes:
        label: last step of its name.
        key: its body; None for a folder.
        below: content of a folder.
    """

    label: str
    key: Key | None
    below: tuple[Branch, ...] = ()


@frozen
class SceneRows:
    """A scene in the tree. `count`: number of all its entities, listed or not."""

    index: int
    count: int
    rows: tuple[Branch, ...]

    @property
    def size(self) -> int:
        """The number of rows, including those in folders."""
        return sum(1 if row.key is not None else len(row.below) for row in self.rows)


def object_rows(scenes: Objects, wanted: str = "", most: int = _MOST_ROWS) -> tuple[list[SceneRows], int]:
    """Returns the rows of scenes whose names contain a text, ignoring case, and the number of omitted rows.

    A name with slashes has a folder for each step. An articulation is a folder of its links.
    """
    found: list[SceneRows] = []
    left = 0
    for index, entities in scenes.items():
        top: dict[Any, Any] = {}
        for name, links in entities:
            steps = name.split("/")
            for number, link in enumerate(links or ("",)):
                if wanted.casefold() not in (f"{name}/{link}" if link else name).casefold():
                    continue
                if most <= 0:
                    left += 1
                    continue
                most -= 1
                *above, last = [*steps, link] if link else steps
                folder: dict[Any, Any] = top
                for step in above:
                    folder = folder.setdefault((step, "folder"), {})
                folder[last, number] = (index, name, number)
        if top or not wanted:
            found.append(SceneRows(index, len(entities), _branches(top)))
    return found, left


def _branches(folder: dict[Any, Any]) -> tuple[Branch, ...]:
    return tuple(
        Branch(label, None, _branches(content)) if kind == "folder" else Branch(label, content)
        for (label, kind), content in folder.items()
    )


class ObjectTree:
    """The tree, in a viser container.

    Its rows call `select`, and a new search text calls `search`, both in viser threads. Ctrl-C waits for the end of
    `show` and of `search`.
    """

    def __init__(self, gui: viser.GuiApi, tab: Any, select: Callable[[Key], None], search: Callable[[], None]) -> None:
        self._gui, self._tab, self._select = gui, tab, select
        self._scenes: Objects = {}
        self._is_open = True
        self._made: list[Any] = []
        self._rows: dict[Key, Any] = {}
        self._marks: dict[Key, tuple[str, Any]] = {}
        with tab:
            gui.add_html(TREE)
            self._search = gui.add_text("Search", initial_value="", hint="Part of a name")
            self._search.on_update(lambda _: search())

    @interrupts_wait()
    def show(self, scenes: Objects) -> None:
        """Lists the objects of scenes, replacing the last ones."""
        if scenes != self._scenes:
            self._scenes = scenes
            self.search()

    @interrupts_wait()
    def search(self) -> None:
        """Lists the objects that match the search text."""
        for handle in self._made:
            handle.remove()
        self._made, self._rows, self._marks = [], {}, {}
        found, left = object_rows(self._scenes, self._search.value.strip())
        # Folders expand for a search, or if everything fits on a page.
        self._is_open = bool(self._search.value) or sum(scene.size for scene in found) <= _FEW_ROWS
        with self._tab:
            for scene in found:
                title = f"Scene {scene.index} ({scene.count})"
                folder = self._gui.add_folder(title, expand_by_default=len(found) == 1 or bool(self._search.value))
                self._made.append(folder)
                # The content of a folder is removed with it.
                with folder:
                    self._add(scene.rows)
            if left:
                self._made.append(self._gui.add_html(line(f"and {left} more: search for part of a name")))

    def mark(self, selected: Key | None, hidden: frozenset[str], locked: frozenset[str]) -> None:
        """Marks the selected body, and rows of hidden or locked entities."""
        for key, button in self._rows.items():
            icon = viser.Icon.EYE_OFF if key[1] in hidden else viser.Icon.LOCK if key[1] in locked else None
            mark = (_SELECTED if key == selected else _PLAIN, icon)
            if self._marks.get(key, (_PLAIN, None)) != mark:
                button.color, button.icon = mark
                self._marks[key] = mark

    def _add(self, rows: Sequence[Branch]) -> None:
        for row in rows:
            if row.key is None:
                with self._gui.add_folder(row.label, expand_by_default=self._is_open):
                    self._add(row.below)
            else:
                self._add_button(row.label, row.key)

    def _add_button(self, label: str, key: Key) -> None:
        button = self._rows[key] = self._gui.add_button(label, color=_PLAIN)
        button.on_click(lambda _: self._select(key))
