"""Scene files as an editor holds them, without an editor: a folder, texts, and the place of a cursor in one."""

from __future__ import annotations

from pathlib import Path

from scenecc.lsp import worker
from scenecc.lsp.completion import completions
from scenecc.lsp.hover import HoverText, hover_at
from scenecc.lsp.names import definition_of, mention_at, mention_span, uses_of
from scenecc.lsp.workspace import Workspace, WorkspaceView
from scenecc.options import Options

CURSOR = "¦"

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="hand"/>
  <joint name="wrist" type="revolute">
    <parent link="base"/><child link="hand"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>
"""


class Editor:
    """Texts that are open.

    Args:
        folder: of the files.
        texts: by their names in it. One of them may hold the cursor, `¦`, which is taken out.
        closed: texts that are on the disk alone.
    """

    def __init__(self, folder: Path, texts: dict[str, str], closed: dict[str, str] | None = None) -> None:
        self.folder = folder
        self.workspace = Workspace(Options())
        self._cursor: tuple[Path, int, int] | None = None
        for name, text in {**(closed or {}), **texts}.items():
            path = folder / name
            path.parent.mkdir(exist_ok=True, parents=True)
            shown = self._without_cursor(path, text)
            path.write_text(shown, "utf-8")
            if name in texts:
                self.workspace.put(path, shown)
        self.check()

    def _without_cursor(self, path: Path, text: str) -> str:
        before, mark, after = text.partition(CURSOR)
        if mark:
            self._cursor = path, before.count("\n"), len(before.rpartition("\n")[2])
        return before + after

    @property
    def cursor(self) -> tuple[Path, int, int]:
        """File, 0-based line and column."""
        assert self._cursor is not None
        return self._cursor

    @property
    def view(self) -> WorkspaceView:
        return self.workspace.view()

    def check(self) -> None:
        """What the server does when nobody types."""
        for path, project in self.workspace.projects.items():
            checked = worker.answer(worker.CheckRequest(self.view.open_scene(path)))
            assert isinstance(checked, worker.CheckAnswer)
            self.workspace.projects[path] = project.after(checked, checked.diagnostics)

    def type(self, name: str, text: str) -> None:
        """Changes a text, and checks nothing."""
        path = self.folder / name
        self.workspace.put(path, self._without_cursor(path, text))

    def offers(self) -> list:
        return completions(self.view, *self.cursor)

    def labels(self) -> list[str]:
        return [offer.label or offer.text for offer in self.offers()]

    def hover(self) -> HoverText:
        found = hover_at(self.view, *self.cursor)
        assert found is not None
        return found

    def definition(self) -> tuple[str, int, str] | None:
        """The file, the 0-based line and the text at which what the cursor is on is defined."""
        view = self.view
        found = mention_at(view, *self.cursor)
        defined = None if found is None else definition_of(view, *found)
        if defined is None:
            return None
        line, start, end = defined.span
        text = view.text(defined.file)
        return defined.file.name, line, "" if text is None else text.line(line)[start:end]

    def uses(self) -> list[tuple[str, int, str]]:
        """The same for every mention of it: the part that is its name."""
        view = self.view
        found = mention_at(view, *self.cursor)
        assert found is not None
        defined = definition_of(view, *found)
        assert defined is not None
        places = []
        for use in uses_of(view, defined):
            line, start, end = mention_span(use.text, use.leaf, use.definition.start, use.definition.end)
            places.append((use.text.path.name, line, use.text.line(line)[start:end]))
        return places
