"""`sweep`: runs all seeds and scenes of files on many processes or machines, and writes one table."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast, get_args

from typing_extensions import TypedDict, Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.errors import SceneError
from scenecc.extras import install_hint
from scenecc.interrupt import undoing
from scenecc.options import Options, check_types, integer, path_argument
from scenecc.pipeline import compile_source
from scenecc.source.paths import PathCache
from scenecc.source.provenance import content_hash
from scenecc.sweeps.executors import ATTEMPTS, on_processes, on_ray
from scenecc.sweeps.folder import SweepFolder, fail
from scenecc.sweeps.units import Do, Entry, FindingSettings, Outcome, Work, do_unit, table_row

if TYPE_CHECKING:
    from collections import Counter
    from collections.abc import Generator

    from scenecc.pipeline import CompileResult
    from scenecc.sweeps.executors import Done
    from scenecc.sweeps.units import Unit


class SweepOptions(TypedDict, total=False):
    """The compile options of a sweep.

    Attributes:
        num_scenes: number of scenes, overriding each file.
        asset_roots, allow_outside_assets, limits: as in `CompileOptions`.
    """

    num_scenes: int | None
    asset_roots: Iterable[str | PathLike[str]]
    allow_outside_assets: bool
    limits: Mapping[str, int] | None


@dataclass(frozen=True, slots=True)
class Sweep:
    """A sweep, or the finished part of it.

    Attributes:
        table: the Parquet file; None while a part is missing.
        units, done: the numbers of all units and of finished ones.
        counts: number of findings by code and severity; for a part, only of that part.
    """

    table: Path | None
    units: int
    done: int
    counts: Counter[tuple[str, str]]


_TYPES: Final[dict[str, Any]] = {
    "do": Iterable[str],
    "settle": float,
    "seeds": Iterable[int] | None,
    "ray": bool,
    "ray_address": str | None,
    "shard": tuple[int, int] | None,
    "camera": str | None,
    "size": tuple[int, int] | None,
    "progress": Callable[[int, int], None] | None,
    "settings": Callable[[str], FindingSettings] | None,
}

_MOST: Final = 2**64
"""Seeds in the table are below this."""


def sweep(
    files: str | PathLike[str] | Iterable[str | PathLike[str]],
    *,
    output: str | PathLike[str],
    seeds: Iterable[int] | None = None,
    do: Iterable[Do] = ("check", "state"),
    params: Mapping[str, Any] | Iterable[Mapping[str, Any]] | None = None,
    settle: float = 1.0,
    camera: str | None = None,
    size: tuple[int, int] | None = None,
    jobs: int = 1,
    ray: bool = False,
    ray_address: str | None = None,
    shard: tuple[int, int] | None = None,
    progress: Callable[[int, int], None] | None = None,
    settings: Callable[[str], FindingSettings] | None = None,
    **options: Unpack[SweepOptions],
) -> Sweep:
    """Processes all scenes of files with all seeds, and writes a table with one row per scene.

    To resume an interrupted sweep, call it again with the same arguments. The table is the same bit for bit, whoever
    computed it. See `docs/how-to/sweeps.md`. Processes are forked, so call this before an engine runs in your process.

    Args:
        files: scene files.
        output: folder for the table, the pictures and the log.
        seeds: each file is built with each seed; default: its own.
        do: "check" gives the findings of `check_scene`, "state" the initial poses, "render" a picture.
        params: values of the files' parameters, or several such mappings, which are all swept.
        settle: simulated time of "check" [s].
        camera: camera of the pictures, as for `render_scene`.
        size: size of the pictures [px], as for `render_scene`; default: 640 × 480 without a camera.
        jobs: processes, or CPUs of the local Ray cluster.
        ray: use Ray (extra `ray`): a local cluster, or the one that this process is connected to.
        ray_address: HOST:PORT of a running cluster, instead of `ray`. Its nodes must have the files at the same paths.
        shard: (I, N) does only part I of N. Whatever finishes last, or runs without `shard`, writes the table.
        progress: called with (units done, total units).
        settings: returns the settings of findings and house rules for a file; `scenecc sweep` takes them from
            `[tool.scenecc]`. Default: all findings.
        options: fields of `SweepOptions`.

    Raises:
        SceneError: a file does not compile, the folder contains another sweep, a package is missing, or a machine of
            the cluster lacks something that this one has.
        ValueError: an argument is out of range.
        TypeError: an argument has the wrong type.
    """
    given = {"do": do, "seeds": seeds, "settle": settle, "ray": ray, "ray_address": ray_address, "shard": shard}
    given |= {"camera": camera, "size": size, "progress": progress, "settings": settings}
    check_types(sweep, given, _TYPES)
    work = _plan_work(files, _choose_seeds(seeds), _choose_actions(do), params, settle, camera, size, options, settings)
    units = work.units()
    mine = _select_part(units, shard)
    jobs = integer(jobs, "jobs", 1)
    start = partial(on_ray, address=ray_address) if ray or ray_address is not None else on_processes
    with undoing() as undo:
        folder = SweepFolder(path_argument(sweep, "output", output), work, shard, undo)
        _run_units(work, folder, mine, lambda left: start(do_unit, work, left, jobs), progress)
        return _write_result(folder, units, mine)


def _select_part(units: Sequence[Unit], shard: tuple[int, int] | None) -> Sequence[Unit]:
    """Returns the units of a part (I, N); all units without a part."""
    part, parts = shard or (1, 1)
    if not 1 <= part <= parts:
        raise ValueError(f"shard must be (I, N) with I from 1 to N, not {shard!r}")
    return units[part - 1 :: parts]


def _choose_actions(do: Iterable[str]) -> tuple[Do, ...]:
    asked, known = {*do}, get_args(Do)
    if not asked or not asked <= {*known}:
        raise ValueError(f"do must be any of {', '.join(known)}, not {sorted(asked)}")
    return tuple(one for one in known if one in asked)


def _choose_seeds(seeds: Iterable[int] | None) -> Sequence[int] | None:
    if seeds is None:
        return None
    found = seeds if isinstance(seeds, range) and seeds.step == 1 else sorted({integer(s, "seeds", 0) for s in seeds})
    if not found or found[0] < 0 or found[-1] >= _MOST:
        raise ValueError("seeds must be one or more integers from 0 to 2⁶⁴ - 1")
    return found


def _plan_work(
    files: str | PathLike[str] | Iterable[str | PathLike[str]],
    seeds: Sequence[int] | None,
    do: tuple[Do, ...],
    params: Mapping[str, Any] | Iterable[Mapping[str, Any]] | None,
    settle: float,
    camera: str | None,
    size: tuple[int, int] | None,
    options: SweepOptions,
    settings: Callable[[str], FindingSettings] | None,
) -> Work:
    """Compiles each file with each set of parameters, to find its scenes and all files that it uses."""
    if find_spec("pyarrow") is None:
        fail("SC828", "the table of a sweep needs pyarrow, not installed here", None, install_hint("sweep"))
    if not 0 <= settle < float("inf"):
        raise ValueError(f"settle must be 0 or more and finite, not {settle!r}")
    paths = [files] if isinstance(files, str | PathLike) else [*files]
    asked = Options.of_call(sweep, options, SweepOptions)
    alone = params is None or isinstance(params, Mapping)
    every_params = cast("Iterable[Mapping[str, Any]]", [params or {}] if alone else params)
    entries: dict[tuple[str, str], Entry] = {}
    faults: dict[Diagnostic, None] = {}
    for path in dict.fromkeys(fspath(path_argument(sweep, "files", path)) for path in paths):
        for chosen in every_params:
            sink = Sink()
            entry = _make_entry(path, replace(asked, params=dict(chosen)), seeds, sink)
            faults |= dict.fromkeys(sink.diagnostics() if entry is None else ())
            if entry is not None:
                entries[path, entry.parameters] = entry
    if faults:
        raise SceneError(faults)
    if not entries:
        raise ValueError("a sweep needs files and parameters")
    ordered = [entries[key] for key in sorted(entries)]
    if settings is not None:
        ordered = [replace(entry, settings=settings(entry.file)) for entry in ordered]
    return Work(tuple(ordered), do, float(settle), camera, size, os.getcwd())  # noqa: PTH109 - only compared, as text


def _make_entry(file: str, options: Options, seeds: Sequence[int] | None, sink: Sink) -> Entry | None:
    """Returns the entry; None if the file has errors, which are reported."""
    memory = PathCache()
    result = _compile_any_seed(file, options, seeds, sink, memory)
    if result is None:
        return None
    own = result.plan.seed
    if own >= _MOST:
        sink.report("SC940", f"the seed {own} does not fit in the table", Location(file), hint="give --seeds")
        return None
    named = {os.path.abspath(file): file}  # noqa: PTH100 - keeps links
    named |= {str(path): reference.uri for path, reference in memory.named.items()}
    used = {path: content_hash(path) or "" for path in named}
    return Entry(file, options, result.plan.num_scenes, seeds or [own], used, named)


_SEEDS_TRIED = 8
"""Seeds with errors after which a file is refused. One seed with an error is a row of the table."""


_BANDS_OF_TEXT = ("SC0", "SC1")
"""Beginnings of codes of errors of the text and its keys, which no seed changes."""


def _compile_any_seed(
    file: str, options: Options, seeds: Sequence[int] | None, sink: Sink, memory: PathCache
) -> CompileResult | None:
    """Returns the file compiled with the first seed without errors; None, with the last errors, if there is none."""
    found = Sink()
    for seed in [options.seed] if seeds is None else seeds[:_SEEDS_TRIED]:
        asked, found = replace(options, seed=seed), Sink()
        result = compile_source(file, asked, found, placed=False, memory=memory)
        if result is not None:
            return result
        if any(one.severity == "error" and one.code.startswith(_BANDS_OF_TEXT) for one in found.diagnostics()):
            break  # it is the same with every seed
    sink.take_over(found)
    return None


def _run_units(
    work: Work,
    folder: SweepFolder,
    units: Sequence[Unit],
    start: Callable[[Sequence[Unit]], Generator[Done]],
    progress: Callable[[int, int], None] | None,
) -> None:
    """Runs the units without a result, and stores their outcomes."""
    left = [unit for unit in units if unit not in folder]
    if not left:
        return
    count = len(units) - len(left)
    deaths: dict[Unit, int] = {}
    with closing(start(left)) as done:
        for unit, found in done:
            with folder.writing():
                outcome = found
                if isinstance(outcome, str):
                    deaths[unit] = deaths.get(unit, 0) + 1
                    folder.log(unit, died=outcome, attempt=deaths[unit])
                    if deaths[unit] < ATTEMPTS:
                        continue
                    outcome = _record_death(work, unit)
                elif outcome.fault is not None:
                    host = outcome.worker.rpartition(":")[0]
                    hint = "do not change the files during a sweep, and keep them at the same path on each machine"
                    fail("SC829", f"on {host}, {outcome.fault}", work.entries[unit.entry].file, hint)
                else:
                    attempt = deaths.get(unit, 0) + 1
                    folder.log(unit, seconds=round(outcome.seconds, 4), attempt=attempt, worker=outcome.worker)
                folder.keep(unit, outcome)
            count += 1
            if progress is not None:
                progress(count, len(units))


def _write_result(folder: SweepFolder, units: Sequence[Unit], mine: Sequence[Unit]) -> Sweep:
    """Writes the table if all units have a result. `mine`: the units of this part."""
    finished = sum(unit in folder for unit in units)
    if finished < len(units):
        return Sweep(None, len(units), finished, folder.count(mine))
    with folder.writing():
        table, counts = folder.write_table(units)
    return Sweep(table, len(units), finished, counts)


def _record_death(work: Work, unit: Unit) -> Outcome:
    """Returns the outcome of a unit whose process crashed: a finding at its file."""
    entry, sink = work.entries[unit.entry], Sink()
    scenes = f"scenes {unit.first} to {unit.end - 1}" if unit.end - unit.first > 1 else f"scene {unit.first}"
    message = f"the process that worked on {scenes} with seed {unit.seed} ended without a result, {ATTEMPTS} times"
    command = f"scenecc check {entry.file} --seed {unit.seed}"
    hint = f"run `{command}`; if it ends the same way, this is a bug in scenecc or in SAPIEN"
    sink.report("SC822", message, Location(entry.file), hint=hint)
    return Outcome([table_row(entry, unit, None, sink.diagnostics())], {}, 0.0, "")
