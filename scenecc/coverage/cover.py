"""`cover_scene`: scenes that meet every pair of what a file draws, or that fill its ranges."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from typing_extensions import Unpack

from scenecc.coverage.factors import conditions, factors_of, named_sources
from scenecc.coverage.filling import latin_quantiles, range_units, sobol_points
from scenecc.coverage.pairs import PairTable, RowMaker
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.drawn_values import DrawnValues, plain_values
from scenecc.errors import SceneError
from scenecc.files import replace_all
from scenecc.options import CompileOptions, Options, check_types, path_argument
from scenecc.pipeline import as_plan, compile_source, read_input
from scenecc.starts.file import StartRecord, StartsFile, starts_files
from scenecc.starts.fingerprint import fingerprint
from scenecc.variation.chosen import DrawFailure, DrawRecord, chosen_units, key_text
from scenecc.variation.nodes import (
    BUILTIN_NAMES,
    NODE_FIELDS,
    Chosen,
    Computed,
    Cycled,
    Drawn,
    Node,
    Placed,
    Rows,
    Shared,
)

if TYPE_CHECKING:
    from os import PathLike

    from scenecc.coverage.factors import Factor
    from scenecc.coverage.pairs import Pair, Row
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.pipeline import CompileResult, Source
    from scenecc.variation.chosen import SceneUnits

_MOST_BUILDS: Final = 300
"""Most compilations of one cover."""

_MOST_LEVELS: Final = 4000
"""Most alternatives of all factors together: their pairs are a table."""

_FILLINGS: Final = 3
"""Ways to fill the ranges of a row that cannot be built, before another row is made."""

_TRIES: Final = 5
"""Rows made for a pair before it counts as not found."""

_MOST_CHECKED: Final = 2000
"""Most open pairs that are looked at one by one to find whether they have a row."""

_RESTARTS: Final = 5
"""Covers of which the smallest is taken, if they are small."""


@dataclass(frozen=True, slots=True)
class MissedPair:
    """Two alternatives that no scene has together.

    Attributes:
        first, second: name and value of each.
        why: "excluded" by the forms or expressions of the file, or "not found" in several tries.
        by: where the file excludes it, such as "scene.yaml:7"; empty if unknown.
    """

    first: tuple[str, Any]
    second: tuple[str, Any]
    why: str
    by: str = ""


@dataclass(frozen=True, slots=True)
class SceneCover:
    """Scenes that cover what a file draws.

    Attributes:
        content: the starts: for each scene the numbers that its draws use.
        factors: name → alternatives.
        ranges: names of the ranges, which are filled evenly.
        rows: for each scene name → alternative; a name is missing where it is not drawn.
        met: number of pairs of alternatives that the scenes meet.
        missed: pairs that cannot occur, or were not found.
        diagnostics: warnings and notes of the scene.
    """

    content: StartsFile
    factors: Mapping[str, tuple[Any, ...]]
    ranges: tuple[str, ...]
    rows: tuple[Mapping[str, Any], ...]
    met: int
    missed: tuple[MissedPair, ...]
    diagnostics: list[Diagnostic]

    def files(self, name: str) -> dict[str, bytes]:
        """Returns the files of the starts by name, as for `write`."""
        return starts_files(self.content, name)

    def write(self, path: str | PathLike[str]) -> None:
        """Writes the scenes as starts: JSON, with the rows in a Parquet table beside it above 1 MB.

        Raises:
            OSError: a file cannot be written.
            ImportError: the table needs pyarrow, which is not installed.
        """
        target = path_argument(SceneCover.write, "path", path)
        replace_all({target.parent / name: data for name, data in self.files(target.name).items()})


def cover_scene(
    source: Source,
    *,
    sobol: int | None = None,
    **options: Unpack[CompileOptions],
) -> SceneCover:
    """Returns few scenes that meet all pairs of alternatives of a file, or scenes that fill its ranges evenly.

    Alternatives are the items of `choice` and `cycle`, and up to 64 `integers`. A pair counts if both alternatives are
    drawn in a scene that can be built. Ranges are filled by a Latin hypercube over the scenes. The same file gives the
    same scenes. `--starts`, `starts=` and the key `starts` build them, with `num_scenes` of the result.

    Args:
        source: as for `validate`, but not a plan.
        sobol: number of scenes, which fill all alternatives and ranges by a Sobol sequence instead of meeting pairs.
        options: fields of `CompileOptions`, without `num_scenes` and `draws`. The starts that the scene names are
            ignored.

    Raises:
        SceneError: the scene has errors, or nothing to cover (SC945).
        ImportError: `sobol` needs scipy, which is not installed.
        TypeError: an argument has the wrong type.
        ValueError: an argument is out of range.
    """
    asked = replace(Options.of_call(cover_scene, options), starts=None, at_starts=False)
    check_types(cover_scene, {"sobol": sobol}, {"sobol": int | None})
    if asked.num_scenes is not None or asked.draws:
        raise ValueError("num_scenes and draws cannot be given: the cover determines them")
    if sobol is not None and sobol < 1:
        raise ValueError(f"sobol must be at least 1, not {sobol}")
    builder = Builder(source, asked)
    if not builder.sources:
        raise builder.error(*NOTHING)
    if sobol is not None:
        return _SobolCover(builder, sobol).run()
    if not builder.factors:
        raise builder.error(ONLY_RANGES, "fill the ranges with --sobol N (`sobol=N`)")
    return PairCover(builder).run()


NOTHING: Final = (
    "the file draws nothing, so that every scene is the same",
    "draw something: `choice`, `integers`, `uniform` and others",
)
"""Message and hint."""

ONLY_RANGES: Final = "the file draws only from ranges, so that there are no pairs of alternatives"


class Builder:
    """Compiles a file with chosen values.

    Args:
        source: the file.
        options: without number of scenes and starts.

    Attributes:
        sources: what the file draws.
        name: of the file.

    Raises:
        SceneError: the file has errors.
    """

    def __init__(self, source: Source, options: Options) -> None:
        sink = Sink()
        found = None if as_plan(source) is not None else read_input(source, options.limits, sink)
        if found is None or found.plan_text is not None:
            if not sink.failed:
                hint = "name the scene file that the plan was compiled from"
                sink.report("SC907", "values are chosen for a scene file, not for a plan", Location(None), hint=hint)
            raise SceneError(sink.diagnostics())
        self.name = found.document.name
        self._source = found.document if hasattr(source, "read") else source
        self._options = options
        result, record, sink = self.compile({}, options.num_scenes)
        if result is None and not record.failures:
            raise SceneError(sink.diagnostics())
        # A scene of this seed that cannot be built may be left out of the cover.
        self.sources = named_sources(record.sources.values())
        self.factors = factors_of(self.sources, record.num_scenes, record.picks)
        if any(one.scenes is not None for one in self.factors):
            # In which of more scenes they are is known only with more scenes.
            _, more, _ = self.compile({}, _MANY_SCENES)
            if len(more.sources) == len(record.sources):
                self.factors = factors_of(named_sources(more.sources.values()), _MANY_SCENES, more.picks)
        self.ranges = [one for one in self.sources if one.kind != "choice"]
        choices = [one.source for one in self.factors]
        self.range_needs = [tuple(conditions(one, choices, record.picks)) for one in self.ranges]

    def error(self, message: str, hint: str | None = None) -> SceneError:
        """Returns the error of a file that cannot be covered."""
        sink = Sink()
        sink.report("SC945", message, Location(self.name), hint=hint)
        return SceneError(sink.diagnostics())

    def compile(
        self, rows: Mapping[int, Mapping[str, SceneUnits]], num_scenes: int | None
    ) -> tuple[CompileResult | None, DrawRecord, Sink]:
        """Compiles scenes in which draws use these numbers. `rows`: scene → key → numbers."""
        sink = Sink()
        record = DrawRecord(chosen_units(rows.items(), num_scenes or 0))
        options = replace(self._options, num_scenes=num_scenes, record=record)
        return compile_source(self._source, options, sink), record, sink

    def row_units(self, row: Row, ranges: Mapping[int, Sequence[float]]) -> dict[str, SceneUnits]:
        """Returns the numbers of a scene. `ranges`: number of a range → quantiles."""
        units: dict[str, SceneUnits] = {}
        for factor, alternative in zip(self.factors, row, strict=True):
            if alternative >= 0 and factor.source.units:
                at = (0, factor.source.word, factor.source.units[alternative])
                units.setdefault(factor.source.key, []).append(at)
        for number, quantiles in ranges.items():
            source = self.ranges[number]
            units.setdefault(source.key, []).extend(range_units(source, quantiles))
        return units

    def draws_range(self, number: int, row: Row) -> bool:
        """Returns whether a scene with these alternatives draws a range."""
        return all(row[factor] in allowed for factor, allowed in self.range_needs[number])

    def filled(self, rows: Sequence[Row], attempts: Sequence[int]) -> list[dict[int, list[float]]]:
        """Returns for each scene the quantiles of the ranges that it draws, which fill them evenly."""
        found: list[dict[int, list[float]]] = [{} for _ in rows]
        for number, source in enumerate(self.ranges):
            scenes = [scene for scene, row in enumerate(rows) if self.draws_range(number, row)]
            for scene, quantiles in latin_quantiles(source, scenes, [attempts[scene] for scene in scenes]).items():
                found[scene][number] = quantiles
        return found

    def failed_scenes(self, record: DrawRecord, sink: Sink, num_scenes: int) -> dict[int, DrawFailure]:
        """Returns the scenes that cannot be built, each with a value that fails. Raises SceneError if none is named."""
        found: dict[int, DrawFailure] = {}
        # Lowering checks values in any order.
        for failure in sorted(record.failures, key=lambda one: (one.scenes, str(getattr(one.node, "origin", "")))):
            found |= {scene: failure for scene in failure.scenes if scene < num_scenes}
        for one in sink.diagnostics():
            named = _NAMED_SCENE.search(one.message) if one.severity == "error" else None
            if named is not None and int(named[1]) < num_scenes:
                found.setdefault(int(named[1]), DrawFailure((int(named[1]),)))
        if not found:
            raise SceneError(sink.diagnostics())
        return found

    def factors_read(self, node: Node | None, draws: Mapping[str, Node]) -> list[int] | None:
        """Returns the factors that determine a value and whether a scene has it; None if something else does too."""
        if node is None:
            return None
        by_place = {(one.source.key, one.source.word): number for number, one in enumerate(self.factors)}
        found = dict.fromkeys(self._enclosing(getattr(node, "origin", None)))
        todo, seen = [node], set[str]()
        while todo:
            item: Any = todo.pop()
            if isinstance(item, tuple):
                todo += item  # pyright: ignore[reportUnknownArgumentType]
                continue
            if item.__class__ not in NODE_FIELDS:
                continue
            if isinstance(item, Cycled | Rows | Placed):
                return None  # it depends on the scene's index, or on a placement
            if isinstance(item, Computed) and not BUILTIN_NAMES.isdisjoint(item.template.names):
                return None
            names = [*item.draws_by_name.values()] if isinstance(item, Computed) else []
            names += [item.name] if isinstance(item, Shared) else []
            todo += [draws[name] for name in names if name in draws and name not in seen]
            seen.update(names)
            key: Any = getattr(item, "key", None)
            if key is not None:
                place = key_text(key.section, key.name, key.path), getattr(item, "word", 0)
                if not isinstance(item, Chosen | Drawn) or place not in by_place:
                    if isinstance(item, Chosen) and len(item.possible) < 2:
                        continue
                    return None
                found[by_place[place]] = None
            todo += [getattr(item, name) for name in NODE_FIELDS[item.__class__] if name != "key"]
        return [*found]

    def _enclosing(self, origin: Origin | None) -> list[int]:
        """Returns the factors that select whether a scene has the value written at a place."""
        above = () if origin is None else [(origin.file, origin.path[:n]) for n in range(len(origin.path))]
        places = [one.source.origin for one in self.factors]
        return [number for number, one in enumerate(places) if (one.file, one.path) in above]

    def cover(
        self, result: CompileResult, sink: Sink, rows: Sequence[Row], units: Mapping[int, Any], **found: Any
    ) -> SceneCover:
        """Returns the result of a cover."""
        plan = result.plan
        drawn = {name: plain_values(values) for name, values in DrawnValues(plan).read(range(plan.num_scenes)).items()}
        records = [
            StartRecord(
                seed=plan.seed,
                scene=scene,
                poses={},
                draws={name: values[scene] for name, values in drawn.items() if values[scene] is not None},
                chosen={key: [list(map(float, one)) for one in several] for key, several in units[scene].items()},
            )
            for scene in range(plan.num_scenes)
        ]
        assert result.document is not None
        made_from = fingerprint(result.document, result.expansion, result.scope, plan)
        content = StartsFile(scene=plan.name, num_scenes=plan.num_scenes, made_from=made_from, rows=records)
        named = [
            {one.source.label: one.source.values[a] for one, a in zip(self.factors, row, strict=True) if a >= 0}
            for row in rows
        ]
        factors = {one.source.label: one.source.values for one in self.factors}
        ranges = tuple(one.label for one in self.ranges)
        return SceneCover(content, factors, ranges, tuple(named), diagnostics=sink.diagnostics(), **found)


_MANY_SCENES: Final = 256

_NAMED_SCENE: Final = re.compile(r"\bin scene (\d+)\b")


@dataclass
class _Scene:
    """A scene of a cover: its row, the pair that it was made for, and how often it could not be built."""

    row: Row
    start: Pair | None
    attempts: int = 0


class PairCover:
    """Makes a cover of all pairs.

    Attributes:
        can_move: whether a row may be in any scene.
        table: the pairs.
        given_up: pairs that no scene has, with why and where.
    """

    def __init__(self, builder: Builder) -> None:
        self._builder = builder
        levels = sum(one.count for one in builder.factors)
        if levels > _MOST_LEVELS:
            message = f"the file draws {levels} alternatives, and pairs of at most {_MOST_LEVELS} can be covered"
            raise builder.error(message, "cover with --sobol N (`sobol=N`)")
        self.table = PairTable(builder.factors)
        self._maker = RowMaker(self.table)
        self._scenes: list[_Scene] = []
        self.given_up: dict[Pair, tuple[str, str]] = {}
        self._tries = Counter["Pair"]()
        self._checked = 0
        self.can_move = not any(one.is_cycle or one.scenes is not None for one in builder.factors)

    @property
    def rows(self) -> list[Row]:
        """The alternatives of each scene."""
        return [one.row for one in self._scenes]

    def run(self) -> SceneCover:
        """Returns the cover, from the smallest of several first ones."""
        firsts: list[list[_Scene]] = []
        for seed in range(_RESTARTS if self.can_move and len(self.table.levels) < _FEW_LEVELS else 1):
            self._maker = RowMaker(self.table, seed)
            firsts.append(self._complete([]))
        self._scenes = min(firsts, key=len)
        for _ in range(_MOST_BUILDS):
            rows = self.rows
            filled = self._builder.filled(rows, [one.attempts for one in self._scenes])
            units = {scene: self._builder.row_units(row, filled[scene]) for scene, row in enumerate(rows)}
            result, record, sink = self._builder.compile(units, len(rows))
            if result is not None:
                return self._cover(result, sink, units)
            self._scenes = self._complete(self._without_failed(record, sink))
        raise self._builder.error(f"no cover was found in {_MOST_BUILDS} builds")

    def _complete(self, given: Sequence[_Scene | None]) -> list[_Scene]:
        """Returns scenes with all open pairs: those given, others in place of None if needed, and more."""
        self.table.reopen([one.row for one in given if one is not None], [*self.given_up])
        found: list[_Scene] = []
        for one in given:
            if one is None and (self.table.open.any() or not self.can_move):
                one = self._next(len(found))  # noqa: PLW2901
            found += [one] if one is not None else []
        last = max(len(found), 1)
        while self.table.open.any() or not found:
            before = self.table.open.sum()
            found.append(self._next(len(found)))
            if self.table.open.sum() < before:
                last = len(found)
            elif len(found) - last > _MANY_SCENES:
                for pair in self.table.open_pairs(0):
                    self._give_up(pair, "not found")
        return found[:last]

    def _next(self, scene: int) -> _Scene:
        """Returns another row of a scene, and meets its pairs. Gives up the pairs that have no row."""
        found, known = self._maker.best(scene), sum(map(len, self._maker.conflicts.values()))
        if self.table.open.any() and (found is None or found[1] is None) and self._checked < known:
            self._checked = known
            for pair in self.table.open_pairs(0)[:_MOST_CHECKED]:
                if not self._maker.is_possible(pair, scene):
                    self._give_up(pair, "excluded", self._maker.reason(pair))
            found = self._maker.best(scene)
        if found is None:
            message = "no scene can be built: expressions of the file exclude all alternatives of what it draws"
            raise self._builder.error(message)
        self.table.meet(found[0])
        return _Scene(*found)

    def _give_up(self, pair: Pair, why: str, by: str = "") -> None:
        self.given_up[pair] = why, by
        (f, a), (g, b) = pair
        self.table.close(self.table.at[f] + a, self.table.at[g] + b)

    def _without_failed(self, record: DrawRecord, sink: Sink) -> list[_Scene | None]:
        """Returns the scenes, None in place of those that fail, and learns which alternatives exclude each other."""
        kept: list[_Scene | None] = [*self._scenes]
        for scene, failure in self._builder.failed_scenes(record, sink, len(kept)).items():
            read, failed = self._builder.factors_read(failure.node, record.draws), self._scenes[scene]
            if read:
                by = _line(getattr(failure.node, "origin", None), sink)
                self._maker.add_conflict({f: failed.row[f] for f in sorted(read) if failed.row[f] >= 0}, by)
                kept[scene] = None
                continue
            failed.attempts += 1
            if not self._builder.ranges or failed.attempts % _FILLINGS == 0:
                kept[scene] = None
                if failed.start is not None:
                    self._tries[failed.start] += 1
                    if self._tries[failed.start] >= _TRIES:
                        self._give_up(failed.start, "not found")
        return kept

    def _cover(self, result: CompileResult, sink: Sink, units: Mapping[int, Any]) -> SceneCover:
        levels = [{*enumerate(row)} for row in self.rows]
        lost = [
            MissedPair(*self.table.named(pair), *why)
            for pair, why in self.given_up.items()
            if pair[0] != pair[1] and not any(levels_of.issuperset(pair) for levels_of in levels)
        ]
        missed = [MissedPair(*self.table.named(pair), "excluded") for pair in self.table.impossible] + lost
        return self._builder.cover(
            result, sink, self.rows, units, met=self.table.total - len(lost), missed=tuple(missed)
        )


_FEW_LEVELS: Final = 150


def _line(origin: Origin | None, sink: Sink) -> str:
    """Returns where a value is written, as FILE:LINE; empty if unknown."""
    if origin is None:
        return ""
    found = sink.locate(sink.trace(origin), "value")
    return f"{found.file}:{found.line}" if found.line is not None else ""


class _SobolCover:
    """Fills alternatives and ranges by a Sobol sequence."""

    def __init__(self, builder: Builder, count: int) -> None:
        self._builder = builder
        self._count = count
        self._words = [1 if not one.is_cycle else 0 for one in builder.factors]
        self._dimensions = sum(self._words) + sum(one.words for one in builder.ranges)

    def run(self) -> SceneCover:
        """Returns the cover. Scenes that cannot be built use later points of the sequence."""
        extra = self._count * _FILLINGS + _MANY_SCENES
        points = iter(sobol_points(self._dimensions, self._count + extra))
        taken, sink = [next(points) for _ in range(self._count)], Sink()
        for _ in range(_MOST_BUILDS):
            rows = [self._row(point, scene) for scene, point in enumerate(taken)]
            units = {scene: self._row_units(row, taken[scene]) for scene, row in enumerate(rows)}
            result, record, sink = self._builder.compile(units, self._count)
            if result is not None:
                met = PairTable(self._builder.factors)
                for row in rows:
                    met.meet(row)
                missed = tuple(MissedPair(*met.named(pair), "not met") for pair in met.open_pairs())
                return self._builder.cover(result, sink, rows, units, met=met.total - met.count, missed=missed)
            for scene in self._builder.failed_scenes(record, sink, self._count):
                point = next(points, None)
                if point is None:
                    raise SceneError(sink.diagnostics())
                taken[scene] = point
        raise SceneError(sink.diagnostics())

    def _row(self, point: Sequence[float], scene: int) -> Row:
        """Returns the alternatives of a scene, from its point."""
        row: list[int] = []
        numbers = iter(point)
        for one in self._builder.factors:
            fixed = one.fixed(scene)
            row.append(min(int(next(numbers) * one.count), one.count - 1) if fixed is None else fixed)
        for number, one in enumerate(self._builder.factors):
            if not one.is_in(scene) or not self._is_drawn(one, row):
                row[number] = -1
        return tuple(row)

    def _is_drawn(self, one: Factor, row: Sequence[int]) -> bool:
        return all(row[f] in allowed and self._is_drawn(self._builder.factors[f], row) for f, allowed in one.needs)

    def _row_units(self, row: Row, point: Sequence[float]) -> dict[str, SceneUnits]:
        at, ranges = sum(self._words), dict[int, Sequence[float]]()
        for number, one in enumerate(self._builder.ranges):
            ranges[number] = point[at : at + one.words]
            at += one.words
        return self._builder.row_units(row, ranges)
