"""The files that commands take, and checks of paths before any work is done."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Final

from scenecc.cli.output import STDOUT, end, folder_refusal, refusal, usage_error
from scenecc.files import ARCHIVE, PACK_SUFFIX, NotAFileError, open_regular

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic


STDIN: Final = "-"

_SEARCHED_BYTES: Final = 16 * 1024 * 1024


def _is_scene(file: str) -> bool:
    from scenecc.source.text import is_scene_text

    try:
        with open_regular(file) as stream:
            data = stream.read(_SEARCHED_BYTES)
    except (NotAFileError, IsADirectoryError):
        return False
    if data.startswith(ARCHIVE):
        return file.lower().endswith(PACK_SUFFIX)
    encoding = "utf-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
    return is_scene_text(data.decode(encoding, errors="replace"))


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of file to search for in folders.

    Attributes:
        name: its name in messages.
        suffixes: its suffixes, in lower case.
        holds: whether a file with such a suffix is of this kind.
        hint: how to recognise one.
    """

    name: str
    suffixes: tuple[str, ...]
    holds: Callable[[str], bool]
    hint: str


SCENES: Final = Kind("scene", (".yaml", ".yml", PACK_SUFFIX), _is_scene, "a scene has the key `scenecc`")


@dataclass(slots=True)
class Found:
    """The requested files.

    Attributes:
        files: files to check, without duplicates: those named, and the scenes in folders, sorted per folder.
        skipped: files that are not scenes.
        missing: paths that do not exist.
        empty: folders without a scene.
        unreadable: folders and files without read access.
        kind: kind of file to search for in folders.
        left_out: what options exclude: numbers with reasons, such as `12 unchanged`.
    """

    files: list[str] = field(default_factory=list[str])
    skipped: list[str] = field(default_factory=list[str])
    missing: list[str] = field(default_factory=list[str])
    empty: list[str] = field(default_factory=list[str])
    unreadable: list[tuple[str, OSError]] = field(default_factory=list[tuple[str, OSError]])
    kind: Kind = SCENES
    left_out: list[str] = field(default_factory=list[str])

    def narrow(self, files: list[str], why: str) -> None:
        """Keeps only some of the files. `why`: why the others are left out."""
        if len(files) < len(self.files):
            self.left_out.append(f"{len(self.files) - len(files)} {why}")
        self.files = files

    def faults(self) -> list[Diagnostic]:
        """Returns diagnostics about the requested paths."""
        return [
            *(
                usage_error("SC901", f"file or folder `{path}` not found", file=path, hint=_nearest_file(path))
                for path in self.missing
            ),
            *(
                usage_error("SC902", f"no {self.kind.name} in the folder `{path}`", file=path, hint=self.kind.hint)
                for path in self.empty
            ),
            *(
                usage_error("SC903", f"`{path}` cannot be read: {error.strerror}", file=path)
                for path, error in self.unreadable
            ),
        ]

    def counts(self) -> str:
        """Returns the numbers of files checked and not checked, as text."""
        skipped = len(self.skipped)
        others = [f"{_files(skipped, 'other file')} skipped"] if skipped else []
        return ", ".join([f"{_files(len(self.files), 'file')} checked", *self.left_out, *others])


def find_files(paths: list[str], *, scenes_only: bool = False, kind: Kind | None = None) -> Found:
    """Finds files. A file is taken as it is; a folder is searched for files of one kind, scenes by default.

    Names that start with a dot are skipped, and links to folders are not followed. `scenes_only`: also skip named files
    that are not scenes.
    """
    found = Found(kind=kind or SCENES)
    for path in paths:
        if path != STDIN and Path(path).is_dir():
            _search(path, found)
        elif path != STDIN and not os.path.lexists(path):
            found.missing.append(path)
        elif path != STDIN and scenes_only:
            _sort_out(path, found)
        else:
            found.files.append(path)
    found.files = list(dict.fromkeys(found.files))
    return found


def _search(folder: str, found: Found) -> None:
    before = len(found.files)
    for file in sorted(_files_below(folder, found)):
        _sort_out(file, found)
    if len(found.files) == before:
        found.empty.append(folder)


def _sort_out(file: str, found: Found) -> None:
    try:
        is_wanted = found.kind.holds(file)
    except OSError as error:
        found.unreadable.append((file, error))
    else:
        (found.files if is_wanted else found.skipped).append(file)


def _files_below(folder: str, found: Found) -> Iterator[str]:
    def refused(error: OSError) -> None:
        found.unreadable.append((str(error.filename), error))

    for parent, folders, files in os.walk(folder, onerror=refused):
        folders[:] = [name for name in folders if not name.startswith(".")]
        for name in files:
            if name.lower().endswith(found.kind.suffixes) and not name.startswith("."):
                yield str(Path(parent, name))


def source_of(scene: str) -> str | BinaryIO:
    """Returns what the API takes as the scene's path."""
    return sys.stdin.buffer if scene == STDIN else scene


def checked_source(
    scene: str, output: str | None = None, form: str = "text", *, folder: bool = False
) -> str | BinaryIO:
    """Returns the source of a scene, or ends the command if `path_faults` finds something. Same arguments."""
    if faults := path_faults(scene, output, form, folder=folder):
        end(faults, form)
    return source_of(scene)


def path_faults(
    scene: str, output: str | None, form: str = "text", *, folder: bool = False, source: str = "scene"
) -> list[Diagnostic]:
    """Returns diagnostics about the paths of the scene and the output.

    Args:
        scene: the input file.
        output: the output; None: nothing is written.
        form: format of the diagnostics.
        folder: whether the output is a folder.
        source: name of the input in messages.
    """
    faults: list[Diagnostic] = []
    if scene != STDIN and not os.path.lexists(scene):
        faults.append(usage_error("SC901", f"there is no file `{scene}`", file=scene, hint=_nearest_file(scene)))
    elif scene != STDIN and Path(scene).is_dir():
        message = f"`{scene}` is a folder, not a file"
        faults.append(usage_error("SC901", message, file=scene, hint=f"name a {source} file in it"))
    if output is None:
        return faults
    if output == STDOUT and form != "text":
        message = f"standard output cannot hold both the result (`-o -`) and its diagnostics as {form}"
        faults.append(usage_error("SC906", message, file=output, hint="name a file after -o"))
    elif scene != STDIN and _is_same_file(scene, output):
        message = f"`{output}` is the {source} itself and would be overwritten"
        faults.append(usage_error("SC904", message, file=output, hint="name another file after -o"))
    elif (reason := folder_refusal(output) if folder else refusal(output)) is not None:
        faults.append(usage_error("SC904", reason, file=output))
    return faults


def _nearest_file(path: str) -> str | None:
    """Returns a hint with the file beside a missing one that has the most similar name; None if there is none."""
    from scenecc.diagnostics.messages import nearest

    folder, name = os.path.split(path)
    try:
        near = nearest(name, os.listdir(folder or "."), cutoff=0.75)  # noqa: PTH208
    except (OSError, ValueError):
        return None
    return near and f"did you mean `{os.path.join(folder, near)}`?"  # noqa: PTH118


def _is_same_file(scene: str, output: str) -> bool:
    try:
        return Path(scene).samefile(output)
    except OSError:  # one does not exist, or is inaccessible
        return False


def _files(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
