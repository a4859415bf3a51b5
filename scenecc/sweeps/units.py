"""Units of work of a sweep, and how a process runs one."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, Protocol

from scenecc.checks.house_rules import run_rules
from scenecc.diagnostics.formats.json_text import records
from scenecc.diagnostics.formats.style import encodable
from scenecc.drawn_values import DrawnValues, plain_values
from scenecc.errors import SceneError
from scenecc.files import state_now
from scenecc.pipeline import CompiledSource, build_batch
from scenecc.render import render_scene
from scenecc.simulation.check import SCENES_AT_ONCE, batch_findings, check_plan, origins_of
from scenecc.simulation.findings import report_findings, view_command
from scenecc.source.provenance import content_hash
from scenecc.version import VERSION

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from scenecc.backends.sapien import SceneBatch
    from scenecc.checks.house_rules import Rule
    from scenecc.diagnostics import Diagnostic
    from scenecc.files import State
    from scenecc.options import Options
    from scenecc.pipeline import CompileResult

Do = Literal["check", "render", "state"]

SCENES_OF_A_UNIT: Final = 4 * SCENES_AT_ONCE

PICTURE_SIZE: Final = (640, 480)
"""Size for the default camera, which frames the scene [px]."""


class Unit(NamedTuple):
    """Some scenes of one file with one seed. `entry`: index of the entry in the work; `end`: index after the last
    scene.
    """

    entry: int
    seed: int
    first: int
    end: int


class FindingSettings(Protocol):
    """Which findings of a file are wanted. It can be pickled, and its `repr` contains everything but the rules."""

    @property
    def rules(self) -> Mapping[str, Rule] | None:
        """House rules, by id."""
        ...

    def apply(self, diagnostics: list[Diagnostic], scene: str) -> list[Diagnostic]:
        """Returns the wanted diagnostics of a scene with the set severities."""
        ...


@dataclass(frozen=True, slots=True)
class Entry:
    """A file with one set of parameters.

    Attributes:
        file: path as given.
        options: compile options, with the parameters.
        num_scenes: number of scenes per seed.
        seeds: seeds, ascending.
        used: all files that the scene uses: absolute path → SHA-256.
        named: the same files by their names in messages.
        settings: which findings are wanted; None: all.
    """

    file: str
    options: Options
    num_scenes: int
    seeds: Sequence[int]
    used: Mapping[str, str]
    named: Mapping[str, str]
    settings: FindingSettings | None = None

    @property
    def parameters(self) -> str:
        """The parameters as JSON."""
        return as_json(self.options.params)


@dataclass(frozen=True, slots=True)
class Work:
    """Everything that a process needs to run any unit. It can be pickled.

    Attributes:
        entries: entries, sorted by file and parameters.
        do: what is done with each scene.
        settle: simulated time of `check` [s].
        camera, size: camera and size of the pictures, as for `render_scene`.
        folder: folder to which relative paths refer.
        version: version of scenecc.
    """

    entries: tuple[Entry, ...]
    do: tuple[Do, ...]
    settle: float
    camera: str | None
    size: tuple[int, int] | None
    folder: str
    version: str = VERSION

    def units(self) -> list[Unit]:
        """Returns all units, in the order of the table."""
        return [
            Unit(number, seed, first, min(first + SCENES_OF_A_UNIT, entry.num_scenes))
            for number, entry in enumerate(self.entries)
            for seed in entry.seeds
            for first in range(0, entry.num_scenes, SCENES_OF_A_UNIT)
        ]


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a unit.

    Attributes:
        rows: rows of the table.
        pictures: PNG content by path below the folder of pictures.
        seconds: duration.
        worker: host and process.
        fault: why nothing was done: this process differs from the one that began the sweep.
    """

    rows: list[dict[str, Any]]
    pictures: dict[str, bytes]
    seconds: float
    worker: str
    fault: str | None = None


def as_json(data: Any) -> str:
    """Returns plain data, also from numpy, as JSON on one line."""
    return json.dumps(data, ensure_ascii=False, sort_keys=True, default=lambda one: one.tolist())


_known: dict[tuple[str, str], State | None] = {}
"""Files with expected content that this process has checked, and their state at that time."""


def _fault(work: Work, entry: Entry) -> str | None:
    """Returns how this process differs from the one that began the sweep; None if it does not."""
    if work.version != VERSION:
        return f"the version of scenecc is {VERSION}, not {work.version}"
    for path, digest in entry.used.items():
        state = state_now(path)
        if state is not None and _known.get((path, digest)) == state:
            continue
        if (found := content_hash(path)) != digest:
            return f"`{path}` does not exist" if found is None else f"`{path}` has different content"
        _known[path, digest] = state
    return None


def do_unit(work: Work, unit: Unit) -> Outcome:
    """Runs a unit. Errors of a scene are not raised."""
    started, worker = time.perf_counter(), f"{platform.node()}:{os.getpid()}"
    try:
        if os.getcwd() != work.folder:  # noqa: PTH109 - a process of a cluster starts in another folder
            os.chdir(work.folder)
    except OSError:
        return Outcome([], {}, 0.0, worker, f"there is no folder `{work.folder}`")
    if (fault := _fault(work, work.entries[unit.entry])) is not None:
        return Outcome([], {}, 0.0, worker, fault)
    doing = _Doing(work, unit)
    rows = doing.rows()
    return Outcome(rows, doing.pictures, time.perf_counter() - started, worker)


def table_row(entry: Entry, unit: Unit, scene: int | None, findings: Iterable[Diagnostic]) -> dict[str, Any]:
    """Returns a row of the table without the results of a build. `scene`: None for all scenes of the unit."""
    keys = ("code", "severity", "message", "file", "line", "column", "path", "hint")
    if entry.settings is not None:
        findings = entry.settings.apply([*findings], entry.file)
    return {
        "file": encodable(entry.file),
        "parameters": entry.parameters,
        "seed": unit.seed,
        "scene": scene,
        "draws": None,
        "findings": [{key: record[key] for key in keys} for record in records(findings)],
        "poses": None,
        "picture": None,
    }


class _Doing:
    """The run of a unit."""

    def __init__(self, work: Work, unit: Unit) -> None:
        self._work = work
        self._unit = unit
        self._entry = work.entries[unit.entry]
        self._source = CompiledSource(self._entry.file, replace(self._entry.options, seed=unit.seed))
        self.pictures: dict[str, bytes] = {}

    def rows(self) -> list[dict[str, Any]]:
        """Returns one row per scene; only one if the scene file has errors."""
        result, common = self._source.result, self._source.sink.diagnostics()
        if result is None:
            return [table_row(self._entry, self._unit, None, common)]
        if "check" in self._work.do:
            doubts = self._source.sink.another()
            if self._entry.settings is not None and self._entry.settings.rules:
                run_rules(result.plan, self._entry.settings.rules, self._entry.file, doubts)
            check_plan(result, doubts)
            common += doubts.diagnostics()
        scenes = range(self._unit.first, self._unit.end)
        drawn = {name: plain_values(values) for name, values in DrawnValues(result.plan).read(scenes).items()}
        rows: list[dict[str, Any]] = []
        for first in range(scenes.start, scenes.stop, SCENES_AT_ONCE):
            some = scenes[first - scenes.start :][:SCENES_AT_ONCE]
            for index, (findings, poses) in self._built(result, some).items():
                picture, faults = self._picture(index)
                told = dict.fromkeys((*common, *findings, *faults))
                row = table_row(self._entry, self._unit, index, told)
                values = {name: several[index - scenes.start] for name, several in drawn.items()}
                draws = {name: value for name, value in values.items() if value is not None}
                rows.append({**row, "draws": as_json(draws), "poses": poses, "picture": picture})
        return rows

    def _built(self, result: CompileResult, scenes: Sequence[int]) -> dict[int, tuple[list[Diagnostic], Any]]:
        """Returns the findings of each scene, and the initial poses. Failed scenes do not affect others."""
        found: dict[int, list[Diagnostic]] = {index: [] for index in scenes}
        poses: dict[int, Any] = dict.fromkeys(scenes)
        sink = self._source.sink.another()
        if {"check", "state"}.isdisjoint(self._work.do):
            return {index: ([], None) for index in scenes}
        try:
            with build_batch(result.plan, sink, scene_idxs=scenes, render=False, audit=True) as batch:
                if "state" in self._work.do:
                    poses = _poses(batch)
                if "check" in self._work.do:
                    self._find(result, batch, found)
        except SceneError as error:
            if len(scenes) > 1:
                return {index: self._built(result, [index])[index] for index in scenes}
            found[scenes[0]] += error.diagnostics
        return {index: (found[index], poses[index]) for index in scenes}

    def _find(self, result: CompileResult, batch: SceneBatch, found: dict[int, list[Diagnostic]]) -> None:
        """Adds the findings of the simulation, scene by scene."""
        findings = [replace(one, seed=result.plan.seed) for one in batch_findings(batch, self._work.settle, set())]
        origins, command = origins_of(result.plan), view_command(self._entry.file, self._entry.options)
        for index in {one.scene: None for one in findings}:
            sink = self._source.sink.another()
            here = [one for one in findings if one.scene == index]
            report_findings(here, origins, command, sink, several_seeds=False)
            found[index] += sink.diagnostics()

    def _picture(self, scene: int) -> tuple[str | None, list[Diagnostic]]:
        """Returns the path of the scene's picture, as rendered by `scenecc render`, or diagnostics."""
        if "render" not in self._work.do:
            return None, []
        size = self._work.size or (None if self._work.camera else PICTURE_SIZE)
        try:
            rendering = render_scene(self._source, camera=self._work.camera, scenes=str(scene), size=size)
        except SceneError as error:
            return None, error.diagnostics
        name = f"{self._unit.entry:04}/seed_{self._unit.seed}_scene_{scene}.png"
        self.pictures[name] = rendering.png()
        return f"pictures/{name}", []


def _poses(batch: SceneBatch) -> dict[int, list[dict[str, Any]]]:
    """Returns for each scene the poses (7,) of its bodies and links in the world of the scene, p [m] then q (wxyz)."""
    found: dict[int, list[dict[str, Any]]] = {index: [] for index in batch.scene_idxs}
    for name, body in batch.entities.items():
        for index, pose in zip(body.scene_idxs, body.pose.tolist(), strict=True):
            found[index].append({"name": name, "pose": pose})
    for name, articulation in batch.articulations.items():
        for link, components in articulation.links.items():
            for index, one in zip(articulation.scene_idxs, components, strict=True):
                if one is not None:
                    pose = one.get_entity().get_pose().__getstate__()
                    found[index].append({"name": f"{name}/{link}", "pose": [float(number) for number in pose]})
    return found
