"""The folder of a sweep: its manifest, the results so far, a log, pictures, and finally the table.

Each result is one line with a checksum, appended to the file of this process's part. Incomplete lines of crashed
processes or machines are ignored. A second file of lines is the log.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import zlib
from collections import Counter
from contextlib import contextmanager
from functools import cached_property
from importlib import import_module
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.errors import SceneError
from scenecc.files import replace_all
from scenecc.interrupt import undoing
from scenecc.sweeps.units import Unit
from scenecc.version import VERSION

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable, Iterator, Sequence
    from contextlib import ExitStack
    from typing import BinaryIO, NoReturn

    from scenecc.sweeps.units import Outcome, Work

_MANIFEST: Final = "sweep.json"
_PARTS: Final = "parts"
_TABLE: Final = "table.parquet"

_ROWS_OF_A_GROUP: Final = 4096
"""Rows per row group of the table, for any number of processes."""

_LEVEL: Final = 3
"""Compression level of zstd."""

Counts = Counter[tuple[str, str]]
"""Number of findings by code and severity."""


def fail(code: str, message: str, file: str | None, hint: str | None = None) -> NoReturn:
    """Raises SceneError with one diagnostic. `file`: None: no file caused it."""
    sink = Sink()
    sink.report(code, message, Location(file), hint=hint)
    raise SceneError(sink.diagnostics())


def _fail_to_write(folder: Path, error: OSError) -> NoReturn:
    is_full = error.errno in {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO}
    hint = "free some space, and run the same command again: it continues" if is_full else None
    message = f"`{error.filename or folder}` cannot be written: {error.strerror}"
    fail("SC818" if is_full else "SC904", message, str(folder), hint)


def table_schema() -> Any:
    """Returns the columns of the table."""
    pa: Any = import_module("pyarrow")
    text, place = pa.string(), pa.int32()
    finding = [("code", text), ("severity", text), ("message", text), ("file", text)]
    finding += [("line", place), ("column", place), ("path", text), ("hint", text)]
    return pa.schema([
        ("file", text),
        ("parameters", text),
        ("seed", pa.uint64()),
        ("scene", place),
        ("draws", text),
        ("findings", pa.list_(pa.struct(finding))),
        ("poses", pa.list_(pa.struct([("name", text), ("pose", pa.list_(pa.float32(), 7))]))),
        ("picture", text),
    ])  # fmt: skip


class SweepFolder:
    """The folder of a sweep, used by one process for one part of it.

    Args:
        folder: created if it does not exist.
        work: the work of the sweep.
        shard: which part of how many this process does; None: everything that is left.
        undo: closes the files.

    Raises:
        SceneError: it contains another sweep, another process does the same part, or it cannot be written.
    """

    def __init__(self, folder: Path, work: Work, shard: tuple[int, int] | None, undo: ExitStack) -> None:
        self._folder = folder
        self._work = work
        self._suffix = "" if shard is None else "-{}-of-{}".format(*shard)
        try:
            self._begin()
            (folder / _PARTS).mkdir(exist_ok=True)
            self._results = undo.enter_context((folder / _PARTS / f"results{self._suffix}.txt").open("a+b"))
            self._log = undo.enter_context((folder / f"log{self._suffix}.jsonl").open("ab"))
        except OSError as error:
            _fail_to_write(folder, error)
        try:
            fcntl.flock(self._results, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            fail("SC940", "another process does the same part of this sweep", str(folder), "wait for it, or stop it")
        # Closing does not release the lock, because a process that was forked meanwhile has the file open too.
        undo.callback(fcntl.flock, self._results, fcntl.LOCK_UN)
        self._found: dict[Unit, tuple[BinaryIO, int, int]] = {}
        for path in sorted((folder / _PARTS).glob("results*.txt")):
            own = path.samefile(self._results.name)
            self._read(self._results if own else undo.enter_context(path.open("rb")), own=own)

    def _begin(self) -> None:
        """Creates the folder, or checks that it belongs to this sweep."""
        manifest = self._folder / _MANIFEST
        if not manifest.exists():
            if self._folder.exists() and any(self._folder.iterdir()):
                fail("SC940", "the folder contains other files, but no sweep", str(self._folder), "name another folder")
            self._folder.mkdir(exist_ok=True)
            replace_all({manifest: (json.dumps(self._manifest, indent=1, ensure_ascii=False) + "\n").encode()})
            return
        try:
            before = json.loads(manifest.read_bytes())
        except ValueError:
            before = None
        if before != self._manifest:
            why = _difference(before, self._manifest)
            fail("SC940", f"the folder contains another sweep: {why}", str(self._folder), "name another folder")

    @cached_property
    def _manifest(self) -> dict[str, Any]:
        """Returns everything that determines the table; it is the same on every machine."""
        work = self._work
        return {
            "scenecc": VERSION,
            "sapien": version("sapien"),
            "do": list(work.do),
            "settle": work.settle,
            "camera": work.camera,
            "size": work.size and list(work.size),
            "entries": [
                {
                    "file": entry.file,
                    "parameters": entry.parameters,
                    "num_scenes": entry.num_scenes,
                    "seeds": _seeds_text(entry.seeds),
                    "settings": entry.settings and [repr(entry.settings), *sorted(entry.settings.rules or ())],
                    "files": {entry.named[path]: digest for path, digest in sorted(entry.used.items())},
                }
                for entry in work.entries
            ],
        }

    def _read(self, file: BinaryIO, *, own: bool) -> None:
        """Reads the results of a file; in the own file, incomplete lines are cut off."""
        file.seek(0)
        end = 0
        while line := file.readline():
            head, _, rest = line.partition(b" ")
            if not line.endswith(b"\n") or head != b"%08x" % zlib.crc32(rest[:-1]):
                break
            unit, payload = rest[:-1].split(b"\t", 1)
            start = end + len(line) - len(payload) - 1
            self._found.setdefault(Unit(*map(int, unit.split())), (file, start, len(payload)))
            end += len(line)
        if own:
            file.truncate(end)
            file.seek(end)

    def __contains__(self, unit: Unit) -> bool:
        return unit in self._found

    @contextmanager
    def writing(self) -> Generator[None]:
        """Context for calls of `keep`, `log` or `write_table`.

        Raises:
            SceneError: something could not be written.
        """
        try:
            yield
        except OSError as error:
            _fail_to_write(self._folder, error)

    def keep(self, unit: Unit, outcome: Outcome) -> None:
        """Writes the pictures of a unit, then its rows."""
        pictures = {self._folder / "pictures" / name: data for name, data in outcome.pictures.items()}
        for folder in {path.parent for path in pictures}:
            folder.mkdir(parents=True, exist_ok=True)
        if pictures:
            replace_all(pictures)
        payload = json.dumps(outcome.rows, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "surrogatepass")
        line = b"%d %d %d %d\t%s" % (*unit, payload)
        end = _append(self._results, b"%08x %s\n" % (zlib.crc32(line), line))
        self._found[unit] = (self._results, end - len(payload) - 1, len(payload))

    def log(self, unit: Unit, **told: Any) -> None:
        """Adds a line to the log."""
        entry = self._work.entries[unit.entry]
        place = {"file": entry.file, "parameters": entry.parameters, "seed": unit.seed}
        line = {**place, "scenes": f"{unit.first}:{unit.end}", **told}
        _append(self._log, json.dumps(line, ensure_ascii=False).encode() + b"\n")

    def _rows(self, units: Sequence[Unit]) -> Iterator[dict[str, Any]]:
        for unit in units:
            file, start, size = self._found[unit]
            yield from json.loads(os.pread(file.fileno(), size, start))

    def count(self, units: Sequence[Unit]) -> Counts:
        """Counts the findings of finished units by code and severity."""
        return Counter(_codes(self._rows(units)))

    def write_table(self, units: Sequence[Unit]) -> tuple[Path, Counts]:
        """Writes the table of all units, which must be finished. The same rows give the same bytes."""
        pa: Any = import_module("pyarrow")
        pq: Any = import_module("pyarrow.parquet")
        schema, counts = table_schema(), Counts()
        path, part = self._folder / _TABLE, self._folder / f".{_TABLE}.{os.getpid()}.part"
        rows = self._rows(units)
        with undoing() as undo:
            undo.callback(part.unlink, missing_ok=True)
            with (
                part.open("wb") as file,
                pq.ParquetWriter(file, schema, version="2.6", compression="zstd", compression_level=_LEVEL) as writer,
            ):
                while some := list(islice(rows, _ROWS_OF_A_GROUP)):
                    counts.update(_codes(some))
                    writer.write_table(pa.Table.from_pylist(some, schema), row_group_size=_ROWS_OF_A_GROUP)
                file.flush()
                os.fsync(file.fileno())
            part.replace(path)
        return path, counts


def _append(file: BinaryIO, data: bytes) -> int:
    """Appends to a file without its buffer, which would retry data that a full disk rejected. Returns the new size."""
    while data:
        data = data[os.write(file.fileno(), data) :]
    return os.lseek(file.fileno(), 0, os.SEEK_END)


def _codes(rows: Iterable[dict[str, Any]]) -> Iterator[tuple[str, str]]:
    for row in rows:
        for finding in row["findings"]:
            yield finding["code"], finding["severity"]


def _seeds_text(seeds: Sequence[int]) -> str:
    """Returns `0:10000`, or a list of the seeds if some are left out."""
    first, end = seeds[0], seeds[-1] + 1
    return f"{first}:{end}" if len(seeds) == end - first else ",".join(map(str, seeds))


def _difference(before: Any, now: dict[str, Any]) -> str:
    """Returns the first difference of two manifests, in words."""
    if not isinstance(before, dict):
        return f"its {_MANIFEST} cannot be read"
    known = cast("dict[str, Any]", before)
    entries: list[dict[str, Any]] = known.get("entries", [])
    for old, new in [(known, now), *zip(entries, now["entries"], strict=False)]:
        for name, value in new.items():
            if name == "files":
                changed = [file for file, digest in value.items() if old.get(name, {}).get(file) != digest]
                if changed:
                    return f"`{changed[0]}` has changed since it began"
            elif name != "entries" and old.get(name) != value:
                shown = [json.dumps(one, ensure_ascii=False) for one in (old.get(name), value)]
                return f"it began with {name} {shown[0]}, not {shown[1]}"
    return "it has other files or parameters"
