"""A cache of the findings of `validate` and `check`. An entry is valid until a file that its scene uses changes."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

from scenecc.diagnostics import Diagnostic
from scenecc.diagnostics.diagnostic import Fix, Location, Related
from scenecc.files import State, cache_folder, keep_result, read_result, state_now
from scenecc.simulation.summary import Checked, Simulated
from scenecc.source.paths import PathCache
from scenecc.source.provenance import content_hash
from scenecc.version import VERSION

_KIND: Final = "findings"

_SETTLED: Final = 2_000_000_000
"""[ns] A file that changed more recently than this may change again within one tick of the file system's clock."""

_PACKAGE: Final = Path(__file__).parent.parent


@dataclass(frozen=True)
class FindingsCache:
    """Findings, keyed by the content of all files that they depend on.

    Attributes:
        command: name of the command that made the findings.
        options: everything else that they depend on. Its `repr` must be complete.
    """

    command: str
    options: Any
    _folder: Path = field(default_factory=lambda: cache_folder(_KIND))

    def findings(self, file: str, find: Callable[[PathCache], Checked]) -> Checked:
        """Returns the cached findings of a file, or calls `find` and caches its result. `find` records the files that
        it reads.
        """
        entry = self._entry(file)
        kept = self._read_kept(entry)
        if kept is not None:
            return kept
        started = time.time_ns()
        memory = PathCache()
        found = find(memory)
        self._keep(entry, started, [Path(file).absolute(), *memory.named], memory.missing, found)
        return found

    def files_of(self, file: str) -> frozenset[Path] | None:
        """Returns all files that a scene used when it was last checked; None if unknown."""
        kept = read_result(self._entry(file))
        if kept is None:
            return None
        record = json.loads(kept)
        return frozenset(Path(path) for path, _, _ in record["files"]) | frozenset(map(Path, record["missing"]))

    def _entry(self, file: str) -> Path:
        key = f"{self._basis}{(file, os.path.abspath(file))!r}"  # noqa: PTH100 - keeps links
        return self._folder / sha256(key.encode()).hexdigest()

    @cached_property
    def _basis(self) -> str:
        """Returns a hash of everything else that findings depend on: the options, this and other installed packages."""
        files = (path for path in _PACKAGE.rglob("*") if path.suffix in {".py", ".yaml"})
        own = sorted((str(path), path.stat().st_mtime_ns) for path in files)
        installed = [(path, state_now(path)) for path in sys.path if path.endswith("-packages")]
        return sha256(repr((VERSION, sys.version, own, installed, self.command, self.options)).encode()).hexdigest()

    def _read_kept(self, entry: Path) -> Checked | None:
        kept = read_result(entry)
        if kept is None:
            return None
        record = json.loads(kept)
        if all(_is_same(*file) for file in record["files"]) and not any(map(os.path.lexists, record["missing"])):
            simulated = record["simulated"] and Simulated(**record["simulated"])
            return Checked([_diagnostic(one) for one in record["diagnostics"]], simulated, cached=True)
        return None

    def _keep(self, entry: Path, started: int, files: Iterable[Path], missing: Iterable[Path], found: Checked) -> None:
        record = {
            "files": [[str(path), _settled_state(path, started), content_hash(path)] for path in files],
            "missing": sorted(map(str, missing)),
            **asdict(found),
        }
        keep_result(entry, json.dumps(record).encode())


def _settled_state(path: Path, started: int) -> State | None:
    """Returns the state of a file; None if it cannot show a later change, or the file changed since `started` [ns]."""
    state = state_now(path)
    return state if state is not None and max(state[3:]) < started - _SETTLED else None


def _is_same(path: str, state: list[int] | None, content: str | None) -> bool:
    now = state_now(path)
    if state is not None and now is not None and list(now) == state:
        return True
    return content_hash(path) == content


def _diagnostic(record: dict[str, Any]) -> Diagnostic:
    fix = record["fix"] and Fix(Location(**record["fix"]["location"]), record["fix"]["text"])
    related = tuple(Related(one["message"], Location(**one["location"])) for one in record["related"])
    whole: dict[str, Any] = {**record, "location": Location(**record["location"]), "related": related, "fix": fix}
    return Diagnostic(**whole)
