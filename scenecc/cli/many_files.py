"""Commands on many files: selecting the files, running them in several processes, and collecting the results."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, NoReturn, TypeVar

import typer

from scenecc.cli.options import at_least, quote_text
from scenecc.cli.output import counted, end, print_note, print_out, progress, usage_error
from scenecc.cli.paths import STDIN, Found
from scenecc.jobs import Died, completed
from scenecc.simulation.summary import Checked

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic
    from scenecc.options import Options

Item = TypeVar("Item")
Result = TypeVar("Result")


def run_each(
    function: Callable[[Item], Result], items: Sequence[Item], jobs: int, label: str
) -> Iterator[Result | Died]:
    """Yields a function's result for each item, in order, while a progress bar counts them.

    Args:
        function: applied to each item. Its results can be pickled. It raises nothing.
        items: the items.
        jobs: number of processes; 0: only this one, in which no item may crash.
        label: label of the bar.
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
    typer.Option("--jobs", "-j", metavar="N", parser=at_least(1), help="Number of processes.", show_default="1"),
]

_SHARD: Final = re.compile(r"([0-9]{1,6})/([0-9]{1,6})")


def parse_shard(text: str | tuple[int, int]) -> tuple[int, int]:
    """Parses `2/5` into (2, 5): the second of five parts."""
    found = _SHARD.fullmatch(str(text))
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise typer.BadParameter(f"{quote_text(str(text))} must be I/N with I from 1 to N, as in 2/5")
    return int(found[1]), int(found[2])


Shard = Annotated[
    Any, typer.Option("--shard", metavar="I/N", parser=parse_shard, help="Take only part I of N of the files.")
]
ChangedSince = Annotated[
    str | None,
    typer.Option("--changed-since", metavar="REV", help="Take only scenes that changed since a git revision."),
]

Written = tuple["list[Diagnostic]", str, "list[dict[str, Any]]"]
"""Diagnostics, a text for people, and the written files for programs."""

_SMALL: Final = {"scenecc": 1, "entities": {"box": {"shapes": [{"type": "box", "half_size": [1, 1, 1]}]}}}
"""A scene that loads and creates everything that all files need."""


def choose_files(
    found: Found,
    changed_since: str | None,
    shard: tuple[int, int] | None,
    files_of: Callable[[str], frozenset[Path] | None],
) -> list[Diagnostic]:
    """Narrows the files to the requested ones. Returns diagnostics.

    Args:
        found: the files, which are narrowed.
        changed_since: keep files that differ from this git revision.
        shard: keep this part; (index from 1, number of parts).
        files_of: returns all files that a scene uses; None if unknown.
    """
    if changed_since is not None:
        changes = _changes_since(changed_since)
        if isinstance(changes, str):
            found.files = []
            return [usage_error("SC918", changes, option="--changed-since")]
        found.narrow([file for file in found.files if _may_differ(file, files_of, changes)], "unchanged")
    if shard is not None:
        part, parts = shard
        found.narrow(found.files[part - 1 :: parts], "in other parts")
    return []


def find_in_each(
    files: Sequence[str], jobs: int, label: str, find: Callable[[str], Checked]
) -> Iterator[tuple[str, Checked]]:
    """Yields each file, in order, with its result.

    Args:
        files: the files.
        jobs: number of processes; 0: only this one.
        label: label of the progress bar.
        find: checks one file.
    """
    if jobs:
        # Before the processes fork, so that they share it.
        from scenecc.scene import validate

        validate(_SMALL)
    for file, result in zip(files, run_each(find, files, jobs, label), strict=True):
        yield file, Checked([_death(file, result)]) if isinstance(result, Died) else result


def are_many(paths: Sequence[str], shard: tuple[int, int] | None, changed_since: str | None = None) -> bool:
    """Returns whether the output is a folder: for several paths, or a folder.

    Raises:
        typer.BadParameter: it is one file, of which options would take a part.
    """
    many = len(paths) > 1 or (paths[0] != STDIN and Path(paths[0]).is_dir())
    for option, value in (("--shard", shard), ("--changed-since", changed_since)):
        if value is not None and not many:
            raise typer.BadParameter("it needs several files, or a folder", param_hint=f"'{option}'")
    return many


def write_each(
    command: str,
    found: Found,
    output: str,
    suffix: str,
    jobs: int | None,
    make: Callable[[str, str], Written],
    form: str = "text",
    choose: Callable[[Found], list[Diagnostic]] | None = None,
) -> NoReturn:
    """Writes one output per file, in separate processes, prints the results in order, and exits with the status.

    Args:
        command: name of the command.
        found: the files.
        output: folder for the outputs. The folder tree of the files is kept.
        suffix: suffix of the outputs.
        jobs: number of processes; None: one.
        make: writes the second path from the first.
        form: format of the diagnostics.
        choose: narrows the files, as `choose_files` does. Each output has the same name as without it.
    """
    diagnostics = found.faults()
    targets = _targets(found.files, output, suffix, diagnostics)
    if choose is not None and targets:
        diagnostics += choose(found)

    def one(file: str) -> Written:
        return make(file, targets[file])

    files = [file for file in targets if file in found.files]
    if found.left_out and form == "text":
        print_note(f"{len(files)} of {len(targets)} files: {', '.join(found.left_out)}\n")
    made: list[dict[str, Any]] = []
    for file, result in zip(files, run_each(one, files, jobs or 1, command), strict=True):
        if isinstance(result, Died):
            diagnostics.append(_death(file, result))
            continue
        diagnostics += result[0]
        made += result[2]
        if form == "text":
            print_out(result[1])
    end(diagnostics, form, data=lambda: {"files": made})


def _targets(files: Sequence[str], output: str, suffix: str, faults: list[Diagnostic]) -> Mapping[str, str]:
    """Returns the output path of each file, and makes the folders. On failure the result is empty and `faults` has the
    reason.
    """
    if output == STDIN or Path(output).suffix.lower() == suffix:
        hint = "name a folder after -o; for a single file, name the source file and not its folder"
        faults.append(
            usage_error("SC904", f"`{output}` cannot hold the output of several files", file=output, hint=hint)
        )
    if STDIN in files:
        faults.append(usage_error("SC901", "standard input cannot be combined with other files", file=STDIN))
    top = os.path.commonpath([os.path.abspath(Path(file).parent) for file in files]) if files else ""  # noqa: PTH100 - keeps links
    plain = {file: re.sub(r"\.dmd(?=\.ya?ml$)", "", os.path.relpath(file, top), flags=re.IGNORECASE) for file in files}
    targets = {file: str(Path(output, name).with_suffix(suffix)) for file, name in plain.items()}
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
        message = f"the folder `{error.filename}` cannot be created: {error.strerror}"
        faults.append(usage_error("SC904", message, file=output))
        return {}
    return targets


def _death(file: str, died: Died) -> Diagnostic:
    how = f"signal {-died.status}" if died.status is not None and died.status < 0 else f"status {died.status}"
    hint = "run the command for only this file; if it ends the same way, this is a bug in scenecc or in SAPIEN"
    return usage_error("SC822", f"the process that worked on this file ended with {how}", file=file, hint=hint)


@dataclass(frozen=True, slots=True)
class _Changes:
    """What changed in a git work tree.

    Attributes:
        top: folder of the work tree.
        files: files that differ from a revision, new ones included.
    """

    top: Path
    files: frozenset[Path]


def files_used(file: str, options: Options) -> frozenset[Path]:
    """Returns all files that a scene uses or looks for, by checking it."""
    from scenecc.scene import validate_source
    from scenecc.source.paths import PathCache

    memory = PathCache()
    validate_source(file, options, {}, memory)
    return frozenset({Path(file).absolute(), *memory.named, *memory.missing})


def _may_differ(file: str, files_of: Callable[[str], frozenset[Path] | None], changes: _Changes) -> bool:
    """Returns whether a scene, or a file that it uses, changed; true if unknown."""
    used = None if file == STDIN else files_of(file)
    if used is None or not Path(file).resolve().is_relative_to(changes.top):
        return True
    return not changes.files.isdisjoint(path.resolve() for path in used)


def _changes_since(revision: str) -> _Changes | str:
    """Returns what differs from a revision, or why that is unknown."""
    try:
        top = _git("rev-parse", "--show-toplevel").rstrip("\n")
        known = _git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}").strip()
        # Without `--no-relative`, the user's `diff.relative` would make paths relative to the current folder.
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
