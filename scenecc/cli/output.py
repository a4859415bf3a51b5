"""Where a command writes: standard output, or a file that is written whole or not at all."""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path

import typer

STDOUT = "-"

_MACHINE_AT_FAULT = 3


def print_out(text: str) -> None:
    """Writes to standard output now, so that a full disk is told and not lost at the process's end."""
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        # What is left in the buffer cannot be written either: let the interpreter's last flush go nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        print_err(f"scenecc: standard output cannot be written: {error.strerror}\n")
        raise typer.Exit(_MACHINE_AT_FAULT) from None


def print_err(text: str) -> None:
    """Writes to standard error."""
    sys.stderr.write(text)
    sys.stderr.flush()


def refusal(target: str) -> str | None:
    """Why an output file cannot be written, as far as that can be known before the work; None if it can."""
    if target == STDOUT:
        return None
    path = Path(target)
    try:
        path.lstat()
    except FileNotFoundError:
        pass
    except OSError as error:  # a name too long, a folder that may not be entered
        return f"`{target}` cannot be written: {error.strerror}"
    if path.is_dir():
        return f"`{target}` is a folder"
    if not path.parent.is_dir():
        return f"there is no folder `{path.parent}`"
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        return f"`{target}` may not be written"
    return None


def base_folder(target: str) -> Path | None:
    """The folder from which relative paths in the output start; None for standard output, which is in none."""
    return None if target == STDOUT else Path(target).parent


def write(target: str, text: str) -> str | None:
    """Writes a file, or standard output for `-`. Returns why that failed; None if it did not.

    A file appears whole or stays as it was: the text goes to a file beside it that then takes its place.
    """
    if target == STDOUT:
        print_out(text)
        return None
    path = Path(os.path.realpath(target))  # a link is written through, not replaced
    try:
        if path.exists() and not path.is_file():
            path.write_text(text, encoding="utf-8")  # a device or a pipe
        else:
            _replace(path, text)
    except OSError as error:
        return f"`{target}` cannot be written: {error.strerror}"
    return None


def _replace(path: Path, text: str) -> None:
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("x", encoding="utf-8", newline="") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            part.chmod(stat.S_IMODE(path.stat().st_mode))
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
