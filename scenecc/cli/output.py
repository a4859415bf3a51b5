"""Output of commands: diagnostics, the exit status, results, files, and a progress bar."""

from __future__ import annotations

import errno
import json
import os
import re
import signal
import sys
import time
from collections.abc import Callable, Collection, Container, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn, TypeVar

import typer

from scenecc.files import replace_all, replace_set
from scenecc.interrupt import undoing

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic
    from scenecc.export import Emitted


STDOUT = "-"

_MACHINE_AT_FAULT = 3

_OF_THE_MACHINE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EMFILE, errno.ENFILE, errno.ENOMEM}
"""Errors that no other file name would avoid: a disk is full or broken."""

_MOST_NEEDS: Final = 8

Unwritten = tuple[str, str]
"""Why a file was not written: the code of a diagnostic, and its message."""


def print_out(content: str | bytes) -> None:
    """Writes to standard output without buffering, so that a full disk is reported at once."""
    try:
        if isinstance(content, bytes):
            sys.stdout.flush()
            sys.stdout.buffer.write(content)
        else:
            sys.stdout.write(content)
        sys.stdout.flush()
    except OSError as error:
        # The rest of the buffer cannot be written either, so the interpreter's last flush must go nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        print_err(f"scenecc: standard output cannot be written: {error.strerror}\n")
        raise typer.Exit(_MACHINE_AT_FAULT) from None


def outlive_pipes() -> None:
    """Makes a closed pipe or connection raise an error in the writer instead of ending the process.

    For commands that also talk to other processes. By default (see `main`) a closed pipe ends the process.
    """
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)


def print_err(text: str) -> None:
    """Writes to standard error. A failure is ignored; the exit status still reports the result."""
    with suppress(OSError):
        sys.stderr.write(text)
        sys.stderr.flush()


_quiet = False
"""Whether only results and diagnostics are printed."""


def set_quiet(on: bool) -> None:
    """Sets the option `--quiet` of this process."""
    global _quiet  # noqa: PLW0603 - an option of the process
    _quiet = on


def print_note(text: str) -> None:
    """Writes a count, a time or another note to standard error, unless `--quiet` is given."""
    if not _quiet:
        print_err(text)


def refusal(target: str) -> str | None:
    """Returns why an output file cannot be written, as far as known before the work; None if it can."""
    if target == STDOUT:
        return None
    path = Path(target)
    try:
        path.lstat()
    except FileNotFoundError:
        pass
    except OSError as error:  # the name is too long, or a folder has no access
        return f"`{target}` cannot be written: {error.strerror}"
    if path.is_dir():
        return f"`{target}` is a folder"
    return _refused_in(path, target)


def folder_refusal(target: str, hidden: Iterable[str] | None = None) -> str | None:
    """Returns why a folder cannot be made and filled; None if it can.

    Args:
        target: the folder, which must be new or empty.
        hidden: files to write, if hidden names may exist in the folder, such as `.git` and `.venv`.
    """
    if not target:
        return "the name of the folder is empty"
    path = Path(target)
    try:
        if not path.is_dir():
            return f"`{target}` is a file" if os.path.lexists(path) else _refused_in(path, target)
        if any(hidden is None or not one.name.startswith(".") for one in path.iterdir()):
            return f"the folder `{target}` is not empty"
        if exists := [name for name in hidden or () if os.path.lexists(path / name)]:
            return f"the folder `{target}` already has `{exists[0]}`"
    except OSError as error:  # the name is too long, or a folder cannot be listed
        return f"`{target}` cannot be written: {error.strerror}"
    return None if os.access(path, os.W_OK) else f"`{target}` is not writable"


def _refused_in(path: Path, target: str) -> str | None:
    if not path.parent.is_dir():
        return f"there is no folder `{path.parent}`"
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        return f"`{target}` is not writable"
    return None


def base_folder(target: str) -> Path | None:
    """Returns the folder to which paths in the output are relative, which is that of the file if `target` is a link to
    it; None for standard output, a device or a pipe.
    """
    path = Path(os.path.realpath(target))
    return None if target == STDOUT or (path.exists() and not path.is_file()) else path.parent


def write_output(target: str, content: str | bytes) -> Unwritten | None:
    """Writes a file, or standard output for `-`. Returns why that failed; None on success.

    The content first goes to a file beside the target, which then replaces it, so no half-written file appears.
    """
    if target == STDOUT:
        print_out(content)
        return None
    path = Path(os.path.realpath(target))  # write through a link, do not replace it
    data = content.encode() if isinstance(content, str) else content
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(data)  # a device or a pipe
        else:
            replace_all({path: data})
    except OSError as error:
        return unwritten(target, error)
    return None


def write_files(target: str, files: Mapping[str, bytes], *, folder: bool) -> Unwritten | None:
    """Writes a file and those beside it, all or none; standard output for `-`. Returns why that failed.

    Args:
        target: path of the first of `files`, whatever its name there; or the folder for all of them.
        files: content by path relative to the folder of the file.
        folder: whether `target` is a folder.
    """
    names = list(files)
    if len(names) == 1 and not folder:
        return write_output(target, files[names[0]])
    if target == STDOUT:
        return "SC904", f"standard output can hold only one file, but there are {len(names)}"
    try:
        replace_set(Path(target), files, folder=folder)
    except OSError as error:
        return unwritten(error.filename or target, error)
    return None


def print_needs(target: str, made: Emitted) -> None:
    """Prints on standard error what a written script or plan needs beside it."""
    _, *copies = made.files
    needs = [f"`{Path(copies[0]).parts[0]}/` ({len(copies)} file{'s' * (len(copies) != 1)} copied)"] if copies else []
    needs += made.needs[:_MOST_NEEDS]
    needs += [f"{len(made.needs) - _MOST_NEEDS} more"] if len(made.needs) > _MOST_NEEDS else []
    if needs:
        print_note(f"{'the output' if target == STDOUT else target} needs {', '.join(needs)}\n")


def unwritten(name: str, error: OSError) -> Unwritten:
    """Returns why a file was not written: its name was wrong, or the disk is full or broken."""
    # If no folder is writable, `tempfile` finds none, and the error names no file.
    of_the_machine = error.errno in _OF_THE_MACHINE or error.filename is None
    return "SC818" if of_the_machine else "SC904", f"`{name}` cannot be written: {error.strerror}"


class Status(IntEnum):
    """Exit statuses. If several apply, the highest counts: its cause must be fixed first."""

    fine = 0
    scene = 1
    usage = 2
    machine = 3


_PARAMS = "params"
"""The file that the API names for a value of `params=`."""

_SET = "--set"
"""The file that the command line names for it. The error is then one of usage."""


def status(diagnostics: Iterable[Diagnostic], *, strict: bool = False) -> Status:
    """Returns the exit status. `strict`: warnings count as errors."""
    counted = ("error", "warning") if strict else ("error",)
    return max((_status_of(d) for d in diagnostics if d.severity in counted), default=Status.fine)


def _status_of(diagnostic: Diagnostic) -> Status:
    from scenecc.diagnostics.codes import CODES

    if diagnostic.file is None and diagnostic.path.startswith(_SET):
        return Status.usage
    # House rules are not in the table.
    return Status[CODES[diagnostic.code].at_fault] if diagnostic.code in CODES else Status.scene


_OPTIONS: Final = {"target": "--to", "scenes": "--scene"}
"""Options whose names differ from the API's arguments."""


def of_settings(diagnostics: Iterable[Diagnostic], settings: Container[str]) -> list[Diagnostic]:
    """Rewrites diagnostics about the API's arguments as diagnostics about options.

    Args:
        diagnostics: those of the API.
        settings: names of the parameters that `--set` sets.
    """
    from dataclasses import replace

    from scenecc.diagnostics.codes import CODES
    from scenecc.diagnostics.diagnostic import Location

    found: list[Diagnostic] = []
    for one in diagnostics:
        option = ""
        if one.file == _PARAMS and one.line is None:
            option = f"{_SET} {one.path}" if one.path in settings else _SET
        elif one.file is None and one.path and one.code in CODES and CODES[one.code].at_fault == "usage":
            option = _option(one.path)
        hint = _ARGUMENT.sub(lambda match: f"`{_option(match[1])}`", one.hint) if one.hint else None
        found.append(replace(one, location=Location(None), path=option, hint=hint) if option else one)
    return found


def _option(argument: str) -> str:
    return _OPTIONS.get(argument, f"--{argument.replace('_', '-')}")


_ARGUMENT: Final = re.compile("`(entity|scenes?|target|camera|focus|size|samples)`")
"""An argument of the API in a hint about wrong usage."""


def print_json(data: Mapping[str, Any], diagnostics: Sequence[Diagnostic] = ()) -> None:
    """Prints a result and the diagnostics beside it as one JSON document, in ASCII: no escape sequence of a scene gets
    into it.
    """
    from scenecc.diagnostics.formats.json_text import records

    print_out(json.dumps({**data, "diagnostics": records(diagnostics)}, indent=2) + "\n")


def print_findings(
    diagnostics: Sequence[Diagnostic],
    form: str,
    *,
    files: Sequence[str] = (),
    corrections: Sequence[Diagnostic] | None = None,
    simulated: Mapping[str, Mapping[str, object] | None] | None = None,
    strict: Collection[str] = (),
) -> None:
    """Prints diagnostics that are the result of the command, on standard output.

    Args:
        diagnostics: diagnostics to print.
        form: format of the output.
        files: files that were checked.
        corrections: as in `render`.
        simulated: as in `render`.
        strict: as in `render`.
    """
    if form == "text" and not diagnostics:
        return  # nothing to print, so load nothing
    from scenecc.diagnostics.formats import render, wants_color

    color = wants_color(sys.stdout)
    made = render(
        diagnostics, form, color=color, files=files, corrections=corrections, simulated=simulated, strict=strict
    )
    print_out(made)


def print_asides(diagnostics: Sequence[Diagnostic]) -> None:
    """Prints diagnostics beside another result, on standard error."""
    if diagnostics:
        from scenecc.diagnostics.formats import render, wants_color

        print_err(render(diagnostics, color=wants_color(sys.stderr)))


def end(
    diagnostics: Sequence[Diagnostic],
    form: str = "text",
    *,
    data: Callable[[], Mapping[str, Any]] = dict,
    text: Callable[[], str] = str,
    beside: bool = False,
    least: Status = Status.fine,
) -> NoReturn:
    """Ends the command: prints its result and its diagnostics in the same format, and exits with their status.

    As text, the result is on standard output and the diagnostics are on standard error. As JSON, both are one document.
    The formats of CI services have only diagnostics.

    Args:
        diagnostics: diagnostics to print.
        form: the value of `--format`.
        data: returns the result for programs.
        text: returns the result for people.
        beside: whether standard output holds a file, so that the text is printed on standard error.
        least: lowest exit status.
    """
    if form == "text":
        (print_err if beside else print_out)(text())
        print_asides(diagnostics)
    elif form == "json":
        print_json(data(), diagnostics)
    else:
        print_findings(diagnostics, form)
    raise typer.Exit(max(status(diagnostics), least))


@contextmanager
def scene_errors(options: Mapping[str, Any], form: str = "text", *, least: Status = Status.fine) -> Generator[None]:
    """Ends the command with the diagnostics of a `SceneError` raised inside. `options`: the compile options."""
    import scenecc

    try:
        yield
    except scenecc.SceneError as error:
        end(of_settings(error.diagnostics, options.get("params", ())), form, least=least)


def usage_error(
    code: str, message: str, *, file: str | None = None, option: str = "", hint: str | None = None
) -> Diagnostic:
    """Returns a diagnostic about a file or option on the command line."""
    from scenecc.diagnostics import Diagnostic
    from scenecc.diagnostics.diagnostic import Location

    return Diagnostic(code, "error", message, Location(file), option, hint=hint)


_PATIENCE: Final = 0.5
"""Seconds before a progress bar appears."""

_EVERY: Final = 0.1
_WIDTH: Final = 40
_LONGEST: Final = 80
"""Maximum length of the description behind the time."""

_CLEAR: Final = "\r\x1b[K"

Show = Callable[[int, int], None]
"""Called with (done, total)."""

Item = TypeVar("Item")


class _Bar:
    """A progress line at the bottom of the terminal: the count, or the elapsed time if nothing is counted."""

    def __init__(self, label: str) -> None:
        self.doing = ""
        self._label = label
        self._started = self._drawn_at = time.monotonic()
        self._counts: tuple[int, int] | None = None
        self._shown = ""

    def count(self, done: int, total: int) -> None:
        """Stores the count for the next `draw`."""
        self._counts = done, total

    def count_and_draw(self, done: int, total: int) -> None:
        """Stores the count, and draws it from time to time."""
        self._counts = done, total
        if time.monotonic() - self._drawn_at >= _EVERY:
            self.draw()

    def draw(self) -> None:
        """Draws what has changed, once the work has taken long enough."""
        self._drawn_at = now = time.monotonic()
        if now - self._started < _PATIENCE:
            return
        line = f"{self._label} {self._bar() or f'{now - self._started:.0f} s'}"
        if not self._counts and self.doing:
            line = f"{line}: {self.doing}"
        if line != self._shown:
            self._shown = line
            os.write(sys.stderr.fileno(), f"{_CLEAR}{line}".encode(errors="replace"))

    def _bar(self) -> str:
        if self._counts is None:
            return ""
        done, total = self._counts
        return f"[{'#' * (_WIDTH * done // total):-<{_WIDTH}}] {done}/{total}"


def print_above(line: str) -> None:
    """Writes a note to standard error in place of a progress bar, which is drawn again below it."""
    print_note(f"{_CLEAR if sys.stderr.isatty() else ''}{line}\n")


@contextmanager
def progress(label: str, *, where: bool = True, clock: bool = True) -> Generator[Show | None, None, None]:
    """Shows a progress bar. Until something is counted, it shows the time and what the work waits for, such as CoACD.

    Yields None if nobody would see the bar, or if `where` is false because another bar is shown. `clock`: draw from a
    thread; must be false if the work forks.
    """
    if _quiet or not where or not sys.stderr.isatty():
        yield None
        return
    bar = _Bar(label)
    with undoing() as undo:
        undo.callback(os.write, sys.stderr.fileno(), _CLEAR.encode())
        if clock:
            with _clock(bar):
                yield bar.count
        else:
            yield bar.count_and_draw


@contextmanager
def _clock(bar: _Bar) -> Generator[None]:
    """Draws a bar from time to time, with what scenecc logs meanwhile."""
    import logging
    from threading import Event, Thread

    from scenecc.diagnostics.formats.style import visible

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            bar.doing = visible(record.getMessage())[:_LONGEST]

    ended = Event()

    def tick() -> None:
        while not ended.wait(_EVERY):
            bar.draw()

    logger, handler, thread = logging.getLogger("scenecc"), Handler(), Thread(target=tick, daemon=True)
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        logger.removeHandler(handler)


def counted(label: str, items: Sequence[Item]) -> Iterator[Item]:
    """Yields the items while a progress bar counts them."""
    with progress(label, clock=False) as show:
        for done, item in enumerate(items):
            if show is not None:
                show(done, len(items))
            yield item
