"""The editor's texts, the findings of their last checks, and the files on the disk."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Final

from scenecc.expand.documents import PREFAB_FOLDER, SHIPPED_PREFIX, edition_here, shipped_file, shipped_names
from scenecc.files import open_regular, state_now
from scenecc.lsp.analysis import MAX_CHARACTERS, SceneText
from scenecc.lsp.worker import OpenScene
from scenecc.source.paths import AssetScope, ResolvedFile, resolve_path
from scenecc.source.text import is_scene_text

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic
    from scenecc.files import State
    from scenecc.lsp.worker import CheckAnswer, NamedObject
    from scenecc.options import Options

_FIRST_BYTES: Final = 2**16
"""Bytes of a file that are read to find out whether it is a scene."""

_MOST_INCLUDED: Final = 100
"""Maximum number of files searched for a scene's includes."""


@dataclass(frozen=True, slots=True)
class Project:
    """An open scene at its last check.

    Attributes:
        diagnostics: diagnostics of `scenecc validate`.
        files: files that were read, by their names in diagnostics.
        objects: objects of the last check that produced a plan.
        is_current: whether that was the last check.
    """

    diagnostics: tuple[Diagnostic, ...] = ()
    files: Mapping[str, Path] = field(default_factory=dict[str, Path])
    objects: Mapping[str, NamedObject] = field(default_factory=dict[str, "NamedObject"])
    is_current: bool = False

    def after(self, checked: CheckAnswer, diagnostics: list[Diagnostic]) -> Project:
        """Returns the project after another check. `diagnostics`: its wanted diagnostics."""
        is_current = checked.objects is not None
        objects = self.objects if checked.objects is None else checked.objects
        # An incomplete text names no files, so the earlier ones are kept.
        files = checked.files if len(checked.files) > 1 or is_current else self.files
        return Project(tuple(diagnostics), files, objects, is_current)


class Workspace:
    """All open texts.

    Args:
        options: what scenes may use.

    Attributes:
        options: what scenes may use.
        texts: open texts, by file path.
        projects: those that are scenes.
    """

    def __init__(self, options: Options) -> None:
        self.options = options
        self.texts: dict[Path, SceneText] = {}
        self.projects: dict[Path, Project] = {}
        self._disk: dict[Path, tuple[State, SceneText]] = {}

    def put(self, path: Path, text: str) -> None:
        """Stores the editor's text of a file."""
        text = text.removeprefix("\ufeff")
        self.texts[path] = SceneText(path, text)
        if is_scene_text(text):
            self.projects.setdefault(path, Project())
        else:
            self.projects.pop(path, None)

    def drop(self, path: Path) -> None:
        """Drops a closed text."""
        self.texts.pop(path, None)
        self.projects.pop(path, None)

    def view(self) -> WorkspaceView:
        """Returns a snapshot for another thread."""
        return WorkspaceView(self.options, {**self.texts}, {**self.projects}, self._disk)


class WorkspaceView:
    """An immutable snapshot of a workspace.

    Attributes:
        texts, projects: as in `Workspace`.
    """

    def __init__(
        self,
        options: Options,
        texts: Mapping[Path, SceneText],
        projects: Mapping[Path, Project],
        disk: dict[Path, tuple[State, SceneText]],
    ) -> None:
        self.texts = texts
        self.projects = projects
        self._options = options
        self._disk = disk
        self._modules: dict[Path, tuple[SceneText, ...]] = {}
        self._namespaces: dict[Path, tuple[SceneText, ...]] = {}
        self._objects: dict[Path, Mapping[str, NamedObject]] = {}

    def open_scene(self, path: Path, changed: Mapping[Path, str] | None = None) -> OpenScene:
        """Returns a scene with all open texts, for the compile process. `changed`: replacement texts of some files."""
        texts = {each: text.text for each, text in self.texts.items()}
        return OpenScene(path, {**texts, **(changed or {})}, self._options)

    def text(self, path: Path) -> SceneText | None:
        """Returns the text of a file, from the editor or else from the disk; None if it cannot be read."""
        if path in self.texts:
            return self.texts[path]
        state = state_now(path)
        known = self._disk.get(path)
        if state is None or known is None or known[0] != state:
            read = None if state is None else _read(path)
            if read is None or state is None:
                return None
            known = self._disk[path] = state, SceneText(path, read)
        return known[1]

    def is_scene(self, path: Path) -> bool:
        """Returns whether a file begins like a scene."""
        text = self.texts[path].text if path in self.texts else _read(path, _FIRST_BYTES)
        return text is not None and is_scene_text(text)

    def module(self, path: Path) -> tuple[SceneText, ...]:
        """Returns a file and all files that it includes, itself first."""
        if path not in self._modules:
            found = dict[Path, SceneText]()
            todo = [path]
            while todo and len(found) < _MOST_INCLUDED:
                text = self.text(file := todo.pop(0))
                if text is not None and file not in found:
                    found[file] = text
                    references = text.texts(("include",)) if "include" in text.text else ()
                    below = (self.find_file(file, reference) for reference in references)
                    todo += [each for each in islice(below, _MOST_INCLUDED) if each is not None]
            self._modules[path] = tuple(found.values())
        return self._modules[path]

    def namespace(self, path: Path) -> tuple[SceneText, ...]:
        """Returns the files that share names with a file: those it includes, and those included together with it."""
        if path not in self._namespaces:
            found = {each.path: each for each in self.module(path)}
            for user in self.including(path):
                found |= {each.path: each for each in self.module(user) if each.path not in found}
            self._namespaces[path] = tuple(found.values())
        return self._namespaces[path]

    def including(self, path: Path) -> list[Path]:
        """Returns the open scenes that include a file."""
        return [user for user in self.projects if user != path and any(one.path == path for one in self.module(user))]

    def users(self, path: Path) -> list[Path]:
        """Returns the open scenes that read a file, including itself."""
        return [user for user, project in self.projects.items() if user == path or path in project.files.values()]

    def judges(self, path: Path) -> list[Path]:
        """Returns the open scenes that report errors in a file: those that read it, except parts of another one."""
        users = list(dict.fromkeys((*self.including(path), *self.users(path))))
        return [user for user in users if not self.including(user)] or users

    def objects(self, path: Path) -> Mapping[str, NamedObject]:
        """Returns the entities, frames and cameras that are named in a file."""
        if path not in self._objects:
            found: dict[str, NamedObject] = {}
            for user in (*self.including(path), path):
                found |= self.projects[user].objects if user in self.projects else {}
            self._objects[path] = found
        return self._objects[path]

    def scope(self, owner: Path) -> AssetScope:
        """Returns what a file may read."""
        tops = [user.parent for user in self.users(owner) if owner.is_relative_to(user.parent)]
        root = tops[0] if tops else owner.parent
        return AssetScope(root, self._options.asset_roots, self._options.allow_outside_assets)

    def find_file(self, owner: Path, reference: str) -> Path | None:
        """Returns the file that a reference in another means; None if it does not exist or may not be read."""
        scope, folder = self.scope(owner), owner.parent
        if reference.startswith(SHIPPED_PREFIX):
            name = reference.removeprefix(SHIPPED_PREFIX)
            return PREFAB_FOLDER / shipped_file(name, edition_here(name, scope)) if name in shipped_names() else None
        found = resolve_path(reference, base=folder, scope=scope)
        return found.path if isinstance(found, ResolvedFile) else None

    def scene_files(self, path: Path) -> Iterator[SceneText]:
        """Yields all scene files that are open, or were read for the scenes that also read a file."""
        read = (each for user in self.users(path) for each in self.projects[user].files.values())
        for each in dict.fromkeys((*self.texts, *read)):
            text = self.text(each) if each in self.texts or each.suffix in {".yaml", ".yml"} else None
            if text is not None:
                yield text


def _read(path: Path, size: int = 4 * MAX_CHARACTERS) -> str | None:
    try:
        with open_regular(path) as file:
            return file.read(size).decode("utf-8", errors="replace").removeprefix("\ufeff")
    except (OSError, ValueError):
        return None


def editor_path(path: str) -> Path:
    """Returns the path of a file as scenes find it: with links in its folder resolved."""
    given = Path(path)
    return given.parent.resolve() / given.name
