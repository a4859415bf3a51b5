"""What commands do with many files: which of them, by how many processes, and what each of them gives."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, NoReturn, TypeVar

import typer

from scenecc.cli.options import Format, at_least
from scenecc.cli.output import counted, end, print_out, progress, usage_error
from scenecc.cli.paths import STDIN, Found
from scenecc.jobs import Died, completed

if TYPE_CHECKING:
    from scenecc.cli.findings_cache import FindingsCache
    from scenecc.diagnostics import Diagnostic

Item = TypeVar("Item")
Result = TypeVar("Result")


def run_each(
    function: Callable[[Item], Result], items: Sequence[Item], jobs: int, label: str
) -> Iterator[Result | Died]:
    """The results of a function for items, in their order, while a bar counts them.

    Args:
        function: what is done with each. Its results can be pickled. It raises nothing.
        items: of any number.
        jobs: how many processes; 0: none but this one, in which nothing may die.
        label: of the bar.
    """
    if jobs == 0:
        yield from map(function, counted(label, items))
        return
    done: dict[int, Result | Died] = {}
    following = 0
    with progress(label, clock=False) as show:
        for number, result in completed(function, items, jobs):
            done[number] = result
            if show is not None:
                show(following + len(done), len(items))
            while following in done:
                yield done.pop(following)
                following += 1


Jobs = Annotated[
    int | None,
    typer.Option("--jobs", metavar="N", parser=at_least(1), help="Number of processes.", show_default="one"),
]

Make = Callable[[str, str], "tuple[list[Diagnostic], str]"]
"""Writes the second path, made of the first; gives what is wrong, and what is said of it on standard output."""

_SMALL: Final = {"scenecc": 1, "entities": {"box": {"shapes": [{"type": "box", "half_size": [1, 1, 1]}]}}}
"""A scene for which everything is loaded and made that every file needs."""


def choose_files(
    found: Found, changed_since: str | None, shard: tuple[int, int] | None, cache: FindingsCache
) -> list[Diagnostic]:
    """Narrows the files to those that are asked for; what is wrong with that.

    Args:
        found: its files are narrowed.
        changed_since: to those that differ from this revision of git.
        shard: to this part of so many.
        cache: knows what scenes use.
    """
    if changed_since is not None:
        changes = _changes_since(changed_since)
        if isinstance(changes, str):
            found.files = []
            return [usage_error("SC918", changes, option="--changed-since")]
        found.narrow([file for file in found.files if _may_differ(file, cache, changes)], "unchanged")
    if shard is not None:
        part, parts = shard
        found.narrow(found.files[part - 1 :: parts], "in other parts")
    return []


def find_in_each(
    files: Sequence[str], jobs: int, label: str, find: Callable[[str], list[Diagnostic]]
) -> Iterator[tuple[str, list[Diagnostic]]]:
    """Each file, in order, with its findings.

    Args:
        files: of any number.
        jobs: processes; 0: this one alone.
        label: of the progress.
        find: the findings of one file.
    """
    if jobs:
        # Before the processes are forked, so that they all have it.
        from scenecc.scene import validate

        validate(_SMALL)
    for file, result in zip(files, run_each(find, files, jobs, label), strict=True):
        yield file, [_death(file, result)] if isinstance(result, Died) else result


def are_many(paths: Sequence[str]) -> bool:
    """Whether paths ask for a folder of outputs: several of them, or a folder."""
    return len(paths) > 1 or (paths[0] != STDIN and Path(paths[0]).is_dir())


def write_each(
    command: str, found: Found, output: str, suffix: str, jobs: int | None, make: Make, form: Format = Format.text
) -> NoReturn:
    """Writes a file for each of many, in processes of their own; says so in their order, and ends with the status.

    Args:
        command: its name.
        found: the files.
        output: the folder for what is written: each by its file's path from the folder that all of these are in.
        suffix: of what is written.
        jobs: number of processes; None: one.
        make: writes one.
        form: of the diagnostics.
    """
    diagnostics = found.faults()
    targets = _targets(found.files, output, suffix, diagnostics)

    def one(file: str) -> tuple[list[Diagnostic], str]:
        return make(file, targets[file])

    files = list(targets)
    for file, result in zip(files, run_each(one, files, jobs or 1, command), strict=True):
        if isinstance(result, Died):
            diagnostics.append(_death(file, result))
        else:
            diagnostics += result[0]
            print_out(result[1])
    end(diagnostics, form)


def _targets(files: Sequence[str], output: str, suffix: str, faults: list[Diagnostic]) -> Mapping[str, str]:
    """Where each file's output goes, in folders that are made; empty, with the reason in `faults`, if it cannot."""
    if output == STDIN or Path(output).suffix.lower() == suffix:
        hint = "name a folder after -o; for one file alone, name a source file in it and not a folder"
        faults.append(usage_error("SC904", f"`{output}` cannot take what is made of many", file=output, hint=hint))
    if STDIN in files:
        faults.append(usage_error("SC901", "standard input is read alone, and not among many files", file=STDIN))
    top = os.path.commonpath([os.path.abspath(Path(file).parent) for file in files]) if files else ""  # noqa: PTH100 - of links, where they lie
    targets = {file: str(Path(output, os.path.relpath(file, top)).with_suffix(suffix)) for file in files}
    first: dict[str, str] = {}
    for file, target in targets.items():
        if first.setdefault(target, file) != file:
            message = f"`{first[target]}` and `{file}` would both be written to `{target}`"
            faults.append(usage_error("SC904", message, file=file))
    if any(fault.code == "SC904" or fault.file == STDIN for fault in faults):
        return {}
    try:
        for folder in {Path(target).parent for target in targets.values()}:
            folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"the folder `{error.filename}` cannot be made: {error.strerror}"
        faults.append(usage_error("SC904", message, file=output))
        return {}
    return targets


def _death(file: str, died: Died) -> Diagnostic:
    how = f"signal {-died.status}" if died.status is not None and died.status < 0 else f"status {died.status}"
    hint = "run the command for this file alone; if it ends the same way, this is a bug in scenecc or in SAPIEN"
    return usage_error("SC822", f"the process that worked on this file ended with {how}", file=file, hint=hint)


@dataclass(frozen=True, slots=True)
class _Changes:
    """What changed in a work tree of git.

    Attributes:
        top: its folder.
        files: that differ from a revision, new ones among them.
    """

    top: Path
    files: frozenset[Path]


def _may_differ(file: str, cache: FindingsCache, changes: _Changes) -> bool:
    """Whether a scene, or a file that it used when it was last looked at, changed; true where that is not known."""
    used = None if file == STDIN else cache.files_of(file)
    if used is None or not Path(file).resolve().is_relative_to(changes.top):
        return True
    return not changes.files.isdisjoint(path.resolve() for path in used)


def _changes_since(revision: str) -> _Changes | str:
    """What differs from a revision; or why that cannot be found."""
    try:
        top = _git("rev-parse", "--show-toplevel").rstrip("\n")
        known = _git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}").strip()
        # `--no-relative`: the user's `diff.relative` would name files by the current folder.
        names = _git("diff", "--name-only", "--no-relative", "--no-renames", "-z", known, "--").split("\0")
        names += _git("ls-files", "--others", "--exclude-standard", "-z", "--full-name", top).split("\0")
    except FileNotFoundError:
        return "git is not installed"
    except subprocess.CalledProcessError as error:
        reason = str(error.stderr).strip().splitlines()
        return reason[-1] if reason else f"there is no revision `{revision}`"
    return _Changes(Path(top).resolve(), frozenset(Path(top, name).resolve() for name in names if name))


def _git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], check=True, capture_output=True, text=True).stdout  # noqa: S603, S607
