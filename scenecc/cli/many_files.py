"""What `validate` and `check` do with many files: which of them, by how many processes, and what was found before."""

from __future__ import annotations

import subprocess
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Final

from scenecc.cli.jobs import Died, run_each
from scenecc.cli.output import usage_error
from scenecc.cli.paths import STDIN

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from scenecc.cli.findings_cache import FindingsCache
    from scenecc.cli.paths import Found
    from scenecc.diagnostics import Diagnostic


_STAGES: Final = ("scenecc.pipeline", "scenecc.expand.expand", "scenecc.lower", "scenecc.checks.physics")
"""Modules that every file needs."""


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
        changed = _changed_files(changed_since)
        if isinstance(changed, str):
            found.files = []
            return [usage_error("SC918", changed, file="--changed-since")]
        found.files = [file for file in found.files if _may_differ(file, cache, changed)]
    if shard is not None:
        part, parts = shard
        found.files = found.files[part - 1 :: parts]
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
        for module in _STAGES:
            import_module(module)
    for file, result in zip(files, run_each(find, files, jobs, label), strict=True):
        yield file, [_death(file, result)] if isinstance(result, Died) else result


def _death(file: str, died: Died) -> Diagnostic:
    how = f"signal {-died.status}" if died.status is not None and died.status < 0 else f"status {died.status}"
    hint = "run the command for this file alone; if it ends the same way, this is a bug in scenecc or in SAPIEN"
    return usage_error("SC822", f"the process that worked on this file ended with {how}", file=file, hint=hint)


def _may_differ(file: str, cache: FindingsCache, changed: frozenset[Path]) -> bool:
    """Whether a scene, or a file that it used when it was last looked at, changed; true where that is not known."""
    used = None if file == STDIN else cache.files_of(file)
    return used is None or not changed.isdisjoint(path.resolve() for path in used)


def _changed_files(revision: str) -> frozenset[Path] | str:
    """The files that differ from a revision, new ones among them; or why that cannot be told."""
    try:
        top = _git("rev-parse", "--show-toplevel").rstrip("\n")
        known = _git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}").strip()
        names = _git("diff", "--name-only", "--no-renames", "-z", known, "--").split("\0")
        names += _git("ls-files", "--others", "--exclude-standard", "-z", "--full-name", top).split("\0")
    except FileNotFoundError:
        return "git is not installed"
    except subprocess.CalledProcessError as error:
        reason = str(error.stderr).strip().splitlines()
        return reason[-1] if reason else f"there is no revision `{revision}`"
    return frozenset(Path(top, name).resolve() for name in names if name)


def _git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], check=True, capture_output=True, text=True).stdout  # noqa: S603, S607
