"""Commands run as separate processes for the tools: limits of time and output, and the folder they may read."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, Final, TypeAlias

import anyio
from anyio.abc import Process

from scenecc.interrupt import undoing

Document: TypeAlias = dict[str, Any]
"""The JSON that a command prints."""

_MOST_BYTES: Final = 16 << 20
"""Largest output that is read from a command."""

_ERROR_BYTES: Final = 10_000
"""How much of the end of a command's standard error is read."""

_GRACE: Final = 3.0
"""Time for a stopped command to clean up [s]."""


_USAGE: Final = 2
"""Exit status of a command with invalid options."""


class CallRefused(Exception):
    """A tool call has no result. `hint` says what to do."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.hint = hint


@dataclass(frozen=True)
class CommandRunner:
    """Runs commands for the tools.

    Args:
        root: resolved folder of all scene files; paths are relative to it.
        options: options of all commands that compile a scene.
        seconds: time limit of a command [s].
        slots: how many commands run at once.
    """

    root: Path
    options: tuple[str, ...]
    seconds: float
    slots: anyio.Semaphore

    def check_file(self, file: str) -> str:
        """Returns a path as the argument of a command. It may be relative to the root, or absolute.

        Raises:
            CallRefused: there is no such file, or it is outside of the root after links are followed.
        """
        try:
            path = (self.root / file).resolve()
            inside = path.is_relative_to(self.root)
            is_folder, exists = path.is_dir(), path.exists()
        except (OSError, ValueError, RuntimeError):  # too long, a NUL, a loop of links
            raise CallRefused("`file` is not a valid path", "give a path relative to the root folder") from None
        if not inside:
            raise CallRefused(
                f"`file` is outside of the root folder {self.root}",
                "use a file in that folder, or ask the user to start `scenecc mcp --root FOLDER` above it",
            )
        if is_folder:
            raise CallRefused("`file` is a folder", "name one scene file in it")
        if not exists:
            raise CallRefused("there is no such file", f"paths are relative to {self.root}; write the file first")
        return file if file != "-" else "./-"  # `-` is standard input

    async def run(self, command: str, arguments: list[str], text: str) -> tuple[int, Document]:
        """Runs a command with `--format json` in the root folder. Returns its exit status and its document.

        Args:
            command: its name.
            arguments: its arguments.
            text: its standard input.

        Raises:
            CallRefused: it took too long, printed too much, or crashed.
        """
        # As an installed `scenecc`: no module is imported from the root folder.
        start = (
            f"import sys; sys.path[:] = {sys.path!r}; from scenecc.interrupt import exit_with_parent; "
            f"exit_with_parent({os.getpid()}); from scenecc.cli import main; main()"
        )
        argv = [sys.executable, "-I", "-c", start, command, "--format", "json", *arguments]
        async with self.slots:
            with anyio.move_on_after(self.seconds):
                return _document(command, *await _communicate(argv, self.root, text.encode()))
        raise CallRefused(
            f"`{command}` took longer than {self.seconds:g} s and was stopped",
            "ask for fewer scenes, seeds or steps, or ask the user for a longer `scenecc mcp --timeout`",
        )


async def _communicate(argv: list[str], root: Path, data: bytes) -> tuple[int, bytes, bytes]:
    """Runs a process to its end. Returns its exit status, its output, and the end of its standard error. If the call is
    cancelled, or a signal ends the server, it is stopped.
    """
    with undoing() as undo, TemporaryFile() as given, TemporaryFile() as output, TemporaryFile() as errors:
        given.write(data)
        given.seek(0)
        try:
            process = await anyio.open_process(
                argv, cwd=root, stdin=given, stdout=output, stderr=errors, start_new_session=True
            )
        except OSError as error:  # an argument is too long, the root folder was removed, or there is no memory
            hint = "use shorter arguments, and values in the file instead of `params`"
            raise CallRefused(f"the command cannot be started: {error.strerror}", hint) from None
        undo.callback(_stop, process)
        try:
            await process.wait()
        finally:
            with anyio.CancelScope(shield=True):
                await _end(process)
        if (size := output.seek(0, os.SEEK_END)) > _MOST_BYTES:
            raise CallRefused(f"the result has {size >> 20} MiB", "ask for fewer scenes or seeds")
        output.seek(0)
        errors.seek(max(0, errors.seek(0, os.SEEK_END) - _ERROR_BYTES))
        assert process.returncode is not None
        return process.returncode, output.read(), errors.read()


async def _end(process: Process) -> None:
    """Stops a process, unless it has ended."""
    if process.returncode is None:
        _send_signal(process, signal.SIGTERM)
        with anyio.move_on_after(_GRACE):
            await process.wait()
        _send_signal(process, signal.SIGKILL)
        await process.wait()
    await process.aclose()


def _send_signal(process: Process, number: int) -> None:
    """Sends a signal to a process and those that it started, unless it has ended."""
    if process.returncode is None:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, number)


def _stop(process: Process) -> None:
    """Stops a process before a signal ends the server. If it takes long, the kernel ends it with the server."""
    if process.returncode is None:
        _send_signal(process, signal.SIGTERM)
        deadline = time.monotonic() + 1
        with suppress(ChildProcessError):
            while time.monotonic() < deadline:
                if os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT):
                    break
                time.sleep(0.02)


def _document(command: str, status: int, output: bytes, errors: bytes) -> tuple[int, Document]:
    """Returns the exit status and the JSON that a command printed. Raises CallRefused if it printed none."""
    with suppress(ValueError):
        return status, json.loads(output)
    said = errors.decode(errors="replace")
    if status == _USAGE:
        raise CallRefused(said.rpartition("Error: ")[2].strip(), "correct this argument")
    # The client logs it.
    sys.stderr.write(said)
    how = f"signal {-status} ({signal.strsignal(-status)})" if status < 0 else f"status {status}"
    hint = "the log of the client has its last output; try fewer scenes, or another scene"
    raise CallRefused(f"`scenecc {command}` ended without a result: {how}", hint)


_SEVERITIES: Final = ("error", "warning", "note")


def shorten(document: Mapping[str, Any], most: int) -> Document:
    """Returns a document whose JSON has at most about so many characters: its longest lists and texts are cut, and
    `omitted` counts the rest. Findings are sorted by severity before they are cut.

    Raises:
        CallRefused: it is too long even so.
    """
    cut = dict(document)
    omitted: dict[str, int] = {}
    while (length := len(json.dumps(cut))) > most:
        cuttable = [name for name in cut if isinstance(cut[name], list | str) and len(cut[name]) > 1]
        if not cuttable:
            raise CallRefused(f"the result has {length} characters; {most} are allowed", "ask for fewer scenes")
        name = max(cuttable, key=lambda name: len(json.dumps(cut[name])))
        rows = cut[name]
        if name == "diagnostics" and name not in omitted:
            rows = sorted(rows, key=lambda row: _SEVERITIES.index(row["severity"]))
        kept = max(1, min(len(rows) - 1, len(rows) * most // length))
        omitted[name] = omitted.get(name, 0) + len(rows) - kept
        cut |= {name: rows[:kept], "omitted": omitted}
    return cut
