"""`scene_coverage`: which pairs of what a file draws a set of episodes has met."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from typing_extensions import Unpack

from scenecc.coverage.calibration import TENTHS, Calibration
from scenecc.coverage.cover import Builder, MissedPair, PairCover, report_nothing
from scenecc.coverage.episodes import Episode, InvalidEpisodesError, cell_of, read_episodes
from scenecc.coverage.pairs import PairTable
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, Options, check_types, path_argument

if TYPE_CHECKING:
    from scenecc.coverage.pairs import Pair, Row
    from scenecc.pipeline import Source

_MOST_FAULTS: Final = 5
"""Most episodes with wrong values that are reported."""

_CHUNK: Final = 4096
"""Rows that are counted at once."""


@dataclass(frozen=True, slots=True)
class RangeCoverage:
    """How far a range was drawn.

    Attributes:
        low, high: its ends; of a `normal`, the least and greatest tenth begin and end far outside.
        tenths: number of episodes in each tenth of its probability, which are equally likely.
    """

    low: float
    high: float
    tenths: tuple[int, ...]

    @property
    def empty(self) -> tuple[int, ...]:
        """The tenths without an episode, from 0."""
        return tuple(number for number, count in enumerate(self.tenths) if not count)


@dataclass(frozen=True, slots=True)
class SceneCoverage:
    """What a set of episodes has met of what a file draws.

    Attributes:
        episodes: number of episodes.
        factors: name → alternative → number of episodes.
        ranges: by name.
        met: number of pairs of alternatives that an episode met.
        missed: the others that can occur.
        impossible: those that cannot occur, or were not found in any scene. They are not counted.
        hidden: names of factors and ranges that no drawn value shows.
        diagnostics: warnings and notes of the scene.
    """

    episodes: int
    factors: Mapping[str, Mapping[Any, int]]
    ranges: Mapping[str, RangeCoverage]
    met: int
    missed: tuple[MissedPair, ...]
    impossible: tuple[MissedPair, ...]
    hidden: tuple[str, ...]
    diagnostics: list[Diagnostic]

    @property
    def share(self) -> float:
        """The met share of the pairs; 1 if there are none."""
        total = self.met + len(self.missed)
        return self.met / total if total else 1.0


def scene_coverage(
    source: Source,
    episodes: str | PathLike[str] | Iterable[Mapping[str, Any]],
    *,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[CompileOptions],
) -> SceneCoverage:
    """Returns which pairs of alternatives a set of episodes has met, and how far it has drawn the ranges.

    Args:
        source: the scene file of the episodes, as for `validate`, but not a plan.
        episodes: what each episode has drawn, as mappings from the names of `scenecc draws` to values, such as
            `info["draws"]`; or a file of them: the output of `scenecc draws` (JSON, CSV, Parquet), the table of a
            sweep, starts, or one JSON object per line.
        progress: called with (pairs met, total pairs) while the scenes for comparison are made.
        options: fields of `CompileOptions`, without `num_scenes` and `draws`.

    Raises:
        SceneError: the scene has errors, or draws nothing (SC945); or the draws cannot be read, or are not draws of
            this scene (SC946).
        TypeError: an argument has the wrong type.
        ValueError: an argument is out of range.
    """
    asked = replace(Options.of_call(scene_coverage, options), starts=None, at_starts=False, num_scenes=None)
    check_types(scene_coverage, {"progress": progress}, {"progress": Callable[[int, int], None] | None})
    if asked.draws:
        raise ValueError("draws cannot be given: they would replace what the file draws")
    file, found = _read(episodes)
    builder = Builder(source, asked)
    if not builder.sources:
        report_nothing(builder)
    return _Counting(builder, file, progress).run(found)


def _read(episodes: str | PathLike[str] | Iterable[Mapping[str, Any]]) -> tuple[str, Iterable[Episode]]:
    """Returns the name of the file, or "", and the episodes."""
    if not isinstance(episodes, str | PathLike):
        return "", (Episode(f"episode {number + 1}", _plain(one)) for number, one in enumerate(episodes))
    path, sink = path_argument(scene_coverage, "episodes", episodes), Sink()
    try:
        return str(path), read_episodes(path)
    except InvalidEpisodesError as error:
        sink.report("SC946", _unreadable(path, error), Location(str(path)), hint=_HINT)
    except OSError as error:
        sink.report("SC946", f"`{cut(str(path), 200)}` cannot be read: {error.strerror}", Location(str(path)))
    raise SceneError(sink.diagnostics())


def _unreadable(file: object, error: InvalidEpisodesError) -> str:
    return f"`{cut(str(file), 200)}` has no drawn values: {error}"


_HINT: Final = 'give what `scenecc draws`, a sweep or `info["draws"]` has for this scene file and these parameters'


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """Returns values without numpy."""
    return {name: value.tolist() if hasattr(value, "tolist") else value for name, value in values.items()}


class _Counting:
    """Counts what episodes have met. Arguments are those of `scene_coverage`."""

    def __init__(self, builder: Builder, file: str, progress: Callable[[int, int], None] | None) -> None:
        self._builder = builder
        self._file = file
        rows: list[Row] = [()]
        can_move = True
        self._impossible: tuple[MissedPair, ...] = ()
        self._diagnostics: list[Diagnostic] = []
        if builder.factors:
            pairs = PairCover(builder, progress)
            cover = pairs.run()
            rows, can_move = pairs.rows, pairs.can_move
            self._impossible, self._diagnostics = cover.missed, cover.diagnostics
        self._calibration = Calibration(builder, rows, can_move=can_move)
        self._counts = [[0] * TENTHS for _ in builder.ranges]
        self._faults: list[str] = []

    def run(self, episodes: Iterable[Episode]) -> SceneCoverage:
        """Returns the coverage."""
        levels, count = self._levels(episodes)
        table = self._pairs_met(levels)
        readers = zip(self._builder.factors, self._calibration.factors, strict=True)
        hidden = [one.source.label for one, reader in readers if reader is None]
        ranges: dict[str, RangeCoverage] = {}
        for source, reader, tenths in zip(self._builder.ranges, self._calibration.ranges, self._counts, strict=True):
            if reader is None:
                hidden.append(source.label)
            else:
                low, *_, high = sorted(reader.edges)
                found = tenths if reader.edges[0] < reader.edges[-1] else tenths[::-1]
                ranges[source.label] = RangeCoverage(low, high, tuple(found))
        missed = tuple(self._missed(pair) for pair in table.open_pairs())
        return SceneCoverage(
            count,
            self._by_alternative(levels),
            ranges,
            table.total - table.count,
            missed,
            self._impossible,
            tuple(hidden),
            self._diagnostics,
        )

    def _levels(self, episodes: Iterable[Episode]) -> tuple[dict[Row, int], int]:
        """Returns how many episodes have each combination of alternatives, and the number of episodes."""
        wanted = self._calibration.in_all_scenes()
        levels, seen, count = dict["Row", int](), set[str](), 0
        try:
            for count, episode in enumerate(episodes, 1):  # noqa: B007
                row = self._read(episode)
                levels[row] = levels.get(row, 0) + 1
                if len(seen) < len(wanted):
                    seen.update(column for column in wanted if cell_of(episode.values, column) is not None)
        except InvalidEpisodesError as error:
            self._faults = [_unreadable(self._file, error)]
        absent = [column for column in wanted if column not in seen]
        if not count and not self._faults:
            self._faults = ["there is no episode"]
        elif absent and not self._faults:
            self._faults = [f"no episode has `{cut(absent[0])}`"]
        if self._faults:
            sink, more = Sink(), len(self._faults) - _MOST_FAULTS
            for fault in [*self._faults[:_MOST_FAULTS], *([f"{more} more values cannot be drawn"] if more > 0 else [])]:
                sink.report("SC946", fault, Location(self._file or None), hint=_HINT)
            raise SceneError(sink.diagnostics())
        return levels, count

    def _read(self, episode: Episode) -> Row:
        """Returns the alternatives of an episode, and counts the tenths of its ranges."""
        row: list[int] = []
        for factor, reader in zip(self._builder.factors, self._calibration.factors, strict=True):
            level = -1 if reader is None else reader.read(episode.values)
            if level is None and reader is not None:
                cells = [cell_of(episode.values, column) for column in reader.columns]
                self._fault(episode, ", ".join(reader.columns), cells, factor.source.values)
            row.append(-1 if level is None else level)
        for number, reader in enumerate(self._calibration.ranges):
            if reader is None:
                continue
            tenth = reader.read(episode.values, tuple(row))
            if tenth is None:
                ends = f"{min(reader.edges):g} … {max(reader.edges):g}"
                self._fault(episode, reader.column, [cell_of(episode.values, reader.column)], (ends,))
            elif tenth >= 0:
                self._counts[number][tenth] += 1
        return tuple(row)

    def _fault(self, episode: Episode, column: str, cells: list[Any], known: tuple[Any, ...]) -> None:
        values = ", ".join(f"{cell:g}" if isinstance(cell, float) else str(cell) for cell in cells)
        able = cut(" | ".join(map(str, known)), 100)
        what = f"{episode.where}: `{cut(column, 80)}` is {cut(values, 80)}, which this file does not draw: {able}"
        self._faults.append(what)

    def _pairs_met(self, levels: Mapping[Row, int]) -> PairTable:
        """Returns the pairs with those open that no episode has met. Impossible and hidden ones do not count."""
        factors = self._builder.factors
        table = PairTable(factors)
        label_of = {one.source.label: number for number, one in enumerate(factors)}
        for one in self._impossible:
            v, w = (
                table.at[label_of[name]] + factors[label_of[name]].source.values.index(value)
                for name, value in (one.first, one.second)
            )
            table.close(v, w)
        for number, reader in enumerate(self._calibration.factors):
            if reader is None:
                table.open[table.at[number] : table.at[number + 1]] = False
                table.open[:, table.at[number] : table.at[number + 1]] = False
        table.total = table.count
        rows = [*levels]
        for first in range(0, len(rows), _CHUNK):
            given = np.array(rows[first : first + _CHUNK], np.int64).reshape(-1, len(factors))
            hot = np.zeros((len(given), len(table.levels)), np.float32)
            at, there = np.array(table.at[:-1], np.int64), given >= 0
            hot[np.nonzero(there)[0], (given + at)[there]] = 1
            table.open &= (hot.T @ hot) == 0
        return table

    def _by_alternative(self, levels: Mapping[Row, int]) -> dict[str, dict[Any, int]]:
        found: dict[str, dict[Any, int]] = {}
        for number, one in enumerate(self._builder.factors):
            if self._calibration.factors[number] is None:
                continue
            counts = [0] * one.count
            for row, times in levels.items():
                if row[number] >= 0:
                    counts[row[number]] += times
            found[one.source.label] = dict(zip(one.source.values, counts, strict=True))
        return found

    def _missed(self, pair: Pair) -> MissedPair:
        sources = [(self._builder.factors[f].source, a) for f, a in pair]
        first, second = ((source.label, source.values[a]) for source, a in sources)
        return MissedPair(first, second, "never met")
