"""`scene_coverage`: which pairs of what a file draws a set of episodes has met."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from typing import TYPE_CHECKING, Any, Final

from typing_extensions import Unpack

from scenecc.coverage.cover import NOTHING, ONLY_RANGES, Builder, MissedPair, PairCover
from scenecc.coverage.episodes import Cell, Episode, InvalidEpisodesError, flat_columns, read_episodes
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut
from scenecc.drawn_values import DrawnValues, plain_values
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, Options, path_argument

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.coverage.pairs import Row
    from scenecc.pipeline import Source

_SCENES: Final = 48
"""Least number of scenes that show which columns depend on a factor, if the rows of a cover can be repeated."""

_HINT: Final = 'give what `scenecc draws`, a sweep or `info["draws"]` has for this scene file and these parameters'


@dataclass(frozen=True, slots=True)
class SceneCoverage:
    """What a set of episodes has met of what a file draws.

    Attributes:
        episodes: number of episodes.
        factors: name → alternative → number of episodes.
        met: number of pairs of alternatives that an episode met.
        missed: the others that can occur.
        impossible: those that cannot occur, or were not found in any scene. They are not counted.
        hidden: names of factors that no drawn value shows.
        diagnostics: warnings and notes of the scene.
    """

    episodes: int
    factors: Mapping[str, Mapping[Any, int]]
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
    **options: Unpack[CompileOptions],
) -> SceneCoverage:
    """Returns which pairs of alternatives a set of episodes has met.

    Args:
        source: the scene file of the episodes, as for `validate`, but not a plan.
        episodes: what each episode has drawn, as mappings from the names of `scenecc draws` to values, such as
            `info["draws"]`; or a file of them: the output of `scenecc draws` (JSON, CSV, Parquet), the table of a
            sweep, starts, or one JSON object per line.
        options: fields of `CompileOptions`, without `num_scenes` and `draws`.

    Raises:
        SceneError: the scene has errors, or draws nothing from alternatives (SC945); or the draws cannot be read, or
            are not draws of this scene (SC946).
        ImportError: a Parquet table needs pyarrow, which is not installed.
        TypeError: an argument has the wrong type.
        ValueError: an argument is out of range.
    """
    asked = replace(Options.of_call(scene_coverage, options), starts=None, at_starts=False, num_scenes=None)
    if asked.draws:
        raise ValueError("draws cannot be given: they would replace what the file draws")
    builder = Builder(source, asked)
    if not builder.factors:
        raise builder.error(ONLY_RANGES) if builder.sources else builder.error(*NOTHING)
    cover = PairCover(builder)
    made = cover.run()
    readers = _readers(builder, cover)
    file = str(episodes) if isinstance(episodes, str | PathLike) else None
    try:
        levels = Counter(_read(builder, readers, episode) for episode in _episodes(episodes))
        factors = _count(builder, readers, levels)
    except (InvalidEpisodesError, OSError) as error:
        sink, reason = Sink(), f"it cannot be read: {error.strerror}" if isinstance(error, OSError) else str(error)
        sink.report("SC946", reason, Location(file), hint=_HINT)
        raise SceneError(sink.diagnostics()) from None
    table = cover.table
    table.reopen([], [*cover.given_up])
    hidden = [number for number, reader in enumerate(readers) if reader is None]
    for number in hidden:
        table.ignore(number)
    total = table.count
    for row in levels:
        table.meet(row)
    return SceneCoverage(
        levels.total(),
        factors,
        total - table.count,
        tuple(MissedPair(*table.named(pair), "never met") for pair in table.open_pairs()),
        made.missed,
        tuple(builder.factors[number].source.label for number in hidden),
        made.diagnostics,
    )


def _episodes(given: str | PathLike[str] | Iterable[Mapping[str, Any]]) -> Iterable[Episode]:
    if isinstance(given, str | PathLike):
        return read_episodes(path_argument(scene_coverage, "episodes", given))
    return (Episode(f"episode {number}", one) for number, one in enumerate(given, 1))


def _count(builder: Builder, readers: Sequence[_Reader | None], levels: Mapping[Row, int]) -> dict[str, dict[Any, int]]:
    """Returns the number of episodes by alternative, of each factor that has a reader."""
    if not levels:
        raise InvalidEpisodesError("there is no episode")
    factors: dict[str, dict[Any, int]] = {}
    for number, (one, reader) in enumerate(zip(builder.factors, readers, strict=True)):
        if reader is None:
            continue
        counts = Counter[int]()
        for row, times in levels.items():
            counts[row[number]] += times
        if counts.keys() == {-1} and not one.needs and one.scenes is None:
            raise InvalidEpisodesError(f"no episode has `{cut(reader.columns[0])}`")
        factors[one.source.label] = {value: counts[a] for a, value in enumerate(one.source.values)}
    return factors


@dataclass(frozen=True, slots=True)
class _Reader:
    """Reads the alternative of a factor from drawn values.

    Attributes:
        columns: the columns that show it.
        alternatives: their values → alternative.
        ranged: the alternative that is itself a range, so that it has any other value; None: there is none.
    """

    columns: tuple[str, ...]
    alternatives: Mapping[tuple[Cell | None, ...], int]
    ranged: int | None

    def read(self, cells: Mapping[str, Cell]) -> int | None:
        """Returns the alternative of an episode, -1 if a value is missing; None if the file cannot draw it."""
        given = tuple(cells.get(column) for column in self.columns)
        return -1 if None in given else self.alternatives.get(given, self.ranged)


def _readers(builder: Builder, cover: PairCover) -> list[_Reader | None]:
    """Returns a reader for each factor; None for one that no drawn value shows.

    The rows of a cover are compiled, in which the alternatives are known.
    """
    count = max(_SCENES, len(cover.rows)) if cover.can_move else len(cover.rows)
    rows = [cover.rows[scene % len(cover.rows)] for scene in range(count)]
    filled = builder.filled(rows, [0] * count)
    units = {scene: builder.row_units(row, filled[scene]) for scene, row in enumerate(rows)}
    result, _, sink = builder.compile(units, count)
    if result is None:
        raise SceneError(sink.diagnostics())
    drawn = {name: plain_values(values) for name, values in DrawnValues(result.plan).read(range(count)).items()}
    table = [flat_columns({name: values[scene] for name, values in drawn.items()}) for scene in range(count)]
    return [
        _reader(one.source.label, [row[number] for row in rows], table) for number, one in enumerate(builder.factors)
    ]


def _reader(label: str, levels: Sequence[int], table: Sequence[Mapping[str, Cell]]) -> _Reader | None:
    """Returns the reader of a factor: by the column of its name, or by others of the same object that depend on it."""
    base = own = re.sub(r"\.variants\[\d+\]|(?<=\.pose)\.p\b", "", label)
    there = [(level, cells) for level, cells in zip(levels, table, strict=True) if level >= 0]
    names = [name for name in there[0][1] if all(name in cells for _, cells in there)] if there else []
    while True:
        columns = tuple(name for name in names if not base or name == base or name.startswith((f"{base}.", f"{base}[")))
        if base != own:
            # Those that have one value for each alternative, whatever the other factors and the ranges are.
            columns = tuple(
                name for name in columns if len({(a, row[name]) for a, row in there}) == len({a for a, _ in there})
            )
        found = {(a, tuple(row[name] for name in columns)) for a, row in there}
        times = Counter(a for a, _ in found)
        ranged = [a for a, number in times.items() if number > 1]
        is_apart = len({cells for _, cells in found}) == len(found)
        if columns and is_apart and (not ranged or (len(ranged) == 1 and len(columns) == 1)):
            return _Reader(columns, {cells: a for a, cells in found if a not in ranged}, next(iter(ranged), None))
        if not base:
            return None
        base = re.sub(r"(^|\.)[^.]*$", "", base) if not base.endswith("]") else base.rpartition("[")[0]


def _read(builder: Builder, readers: Sequence[_Reader | None], episode: Episode) -> Row:
    """Returns the alternatives of an episode.

    Raises:
        InvalidEpisodesError: the file does not draw a value of the episode.
    """
    cells = flat_columns(episode.values)
    found = [-1 if reader is None else reader.read(cells) for reader in readers]
    row: list[int] = []
    for level, factor, reader in zip(found, builder.factors, readers, strict=True):
        # Otherwise the values are those of another variant or item.
        is_drawn = all(found[above] in allowed for above, allowed in factor.needs if readers[above] is not None)
        if is_drawn and level is None and reader is not None:
            values = ", ".join(f"{cut(column, 80)} = {cells[column]}" for column in reader.columns)
            known = cut(" | ".join(map(str, factor.source.values)), 100)
            raise InvalidEpisodesError(f"{episode.where}: {values}, which this file does not draw: {known}")
        row.append(level if is_drawn and level is not None else -1)
    return tuple(row)
