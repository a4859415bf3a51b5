"""`check_scene`: runs `validate`, checks for doubtful values, and builds and simulates all scenes."""

from __future__ import annotations

import math
from dataclasses import replace
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

from typing_extensions import Unpack

from scenecc.checks.effects import check_declared_names, check_effects
from scenecc.checks.house_rules import run_rules
from scenecc.checks.layout import check_layout
from scenecc.checks.mesh_quality import check_meshes
from scenecc.checks.physics import physics_origin
from scenecc.checks.plausibility import check_values
from scenecc.checks.views import check_views
from scenecc.checks.written_values import check_written_values
from scenecc.diagnostics import Sink
from scenecc.diagnostics.codes import is_of_check
from scenecc.diagnostics.diagnostic import Silencings, dotted, report_unused
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, Options, check_types
from scenecc.pipeline import CHECK_TYPES, build_batch, compile_source, read_for_runs, run_seeds, select_scenes
from scenecc.simulation.bodies import moving_bodies
from scenecc.simulation.bounds import scenes_in_doubt
from scenecc.simulation.energy import EnergyWatch
from scenecc.simulation.expect import (
    ExpectationChecker,
    expectation_origins,
    overlap_rules,
    report_unused_exceptions,
    seconds_needed,
)
from scenecc.simulation.findings import origin_of, report_findings, view_command
from scenecc.simulation.loads import joint_positions, jumps, long_steps, mass_ratios, uneven_scenes, weak_drives
from scenecc.simulation.permute import permuted_findings
from scenecc.simulation.robots import RobotWatch, joint_origins
from scenecc.simulation.settle import simulate
from scenecc.simulation.start import (
    OVERLAP,
    SPACING,
    crowded_scenes,
    overlaps,
    unsupported_bodies,
    violated_constraints,
)
from scenecc.simulation.summary import Checked, Simulated

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from scenecc.backends.sapien import SceneBatch
    from scenecc.checks.house_rules import Rule
    from scenecc.diagnostics import Diagnostic
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.pipeline import CompileResult, Source
    from scenecc.plan import ScenePlan
    from scenecc.simulation.expect import Excuse
    from scenecc.simulation.findings import Finding
    from scenecc.source.paths import PathCache

SCENES_AT_ONCE = 64
"""Scenes that are built and simulated together. More scenes use more memory without a gain in speed."""


def check_scene(
    source: Source,
    *,
    settle: float = 1.0,
    seeds: Sequence[int] | None = None,
    scenes: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    rules: Mapping[str, Rule] | None = None,
    permute: bool = False,
    **options: Unpack[CompileOptions],
) -> list[Diagnostic]:
    """Returns the diagnostics of `validate` and of a build and simulation of all scenes. Errors are returned, not
    raised.

    Args:
        source: as for `validate`.
        settle: simulated time [s]; longer if `expect` needs it. 0: only the time that `expect` needs.
        seeds: seeds to check; default: the file's own, or `seed` of the options. A stream allows only one.
        scenes: scenes to build, as for `build_scene`; default: all.
        progress: called with (scenes done, total scenes).
        rules: as for `validate`.
        permute: also build the scenes in another order and in smaller batches, simulate a second, and report each scene
            that differs from itself in a bit (SC867). It takes as long as checking two more seconds.
        options: fields of `CompileOptions`.

    Raises:
        ValueError: an argument is out of range.
        TypeError: as for `validate`.
    """
    asked = Options.of_call(check_scene, options)
    given: dict[str, Any] = {
        "settle": settle,
        "seeds": seeds,
        "scenes": scenes,
        "progress": progress,
        "permute": permute,
    }
    check_types(check_scene, {**given, "rules": rules}, CHECK_TYPES)
    return check_source(source, asked, rules=rules or {}, **given).diagnostics


def check_source(
    source: Source,
    options: Options,
    settle: float,
    seeds: Sequence[int] | None,
    scenes: str | None = None,
    *,
    rules: Mapping[str, Rule],
    progress: Callable[[int, int], None] | None = None,
    memory: PathCache | None = None,
    permute: bool = False,
) -> Checked:
    """Returns the diagnostics of `check_scene`, and what was simulated. `memory`: records what is looked up."""
    if not 0 <= settle < math.inf:
        raise ValueError(f"settle must be 0 or more and finite, not {settle!r}")
    runs = run_seeds(options, seeds)
    sink = Sink()
    readable = read_for_runs(source, len(runs), options.limits, sink)
    if readable is None:
        return Checked(sink.diagnostics())
    check = _Check(settle, len(runs), scenes, rules, progress, permute=permute)
    for number, run in enumerate(runs):
        if not check.run(number, readable, run, memory):
            break
    return Checked(check.diagnostics(), check.simulated())


class _Check:
    """Checks a scene seed by seed. A fault found with several seeds is reported once.

    Args:
        settle: simulated time [s].
        seeds: number of seeds.
        scenes: scenes to build; None: all.
        rules: house rules, by id.
        progress: called with (scenes done, total scenes).
        permute: also check that scenes do not depend on their neighbours.
    """

    def __init__(
        self,
        settle: float,
        seeds: int,
        scenes: str | None,
        rules: Mapping[str, Rule],
        progress: Callable[[int, int], None] | None,
        *,
        permute: bool = False,
    ) -> None:
        self._permute = permute
        self._settle = settle
        self._seeds = seeds
        self._scenes = scenes
        self._rules = rules
        self._progress = progress
        self._diagnostics: dict[Diagnostic, None] = {}
        self._findings: list[Finding] = []
        self._excused: set[Excuse] = set()
        self._simulated: dict[int, int] = {}
        self._seconds = settle
        self._complete = True
        self._silencings = Silencings()
        self._first: tuple[CompileResult, Sink, Options] | None = None
        self._file: str | None = None

    def run(self, number: int, source: Source, options: Options, memory: PathCache | None) -> bool:
        """Checks the scene with the seed of the options; returns false if it cannot be compiled. `number`: index of the
        seed.
        """
        sink = Sink()
        sink.silencings = self._silencings
        if isinstance(source, str | PathLike):
            self._file = fspath(source)  # for a pack, the document's name continues inside it
        result = compile_source(source, options, sink, memory=memory)
        if self._rules and result is not None:
            run_rules(result.plan, self._rules, result.document and result.document.name, sink)
        self._collect(sink)
        if result is None:
            self._complete = False
            return False
        doubts, later = sink.another(), sink.another()
        doubts.at_use = later.at_use = True
        self._first = self._first or (result, later, options)
        check_plan(result, doubts)
        self._collect(doubts)
        self._simulate(number, result.plan, sink)
        return True

    def simulated(self) -> Simulated | None:
        """Returns what was simulated without an error; None: nothing."""
        if not self._simulated:
            return None
        return Simulated(max(self._simulated.values()), tuple(sorted(self._simulated)), self._seconds, self._permute)

    def diagnostics(self) -> list[Diagnostic]:
        """Returns all diagnostics, in file order."""
        if self._first is not None:
            (result, sink, options), document = self._first, self._first[0].document
            command = None
            if document is not None and document.path is not None and document.name is not None:
                command = view_command(self._file or document.name, options)
            origins = origins_of(result.plan)
            findings = _without_consequences(self._findings, origins, self._diagnostics)
            report_findings(findings, origins, command, sink, several_seeds=self._seeds > 1)
            if self._complete:
                report_unused_exceptions(result.plan, self._excused, sink)
            self._collect(sink)
            if self._silencings and self._settle and document is not None:
                report_unused(sink, document.name, is_of_check)
                self._collect(sink)
        return sorted(self._diagnostics, key=lambda d: (d.file or "", d.line or 0, d.column or 0))

    def _collect(self, sink: Sink) -> None:
        self._diagnostics |= dict.fromkeys(sink.diagnostics())

    def _simulate(self, number: int, plan: ScenePlan, sink: Sink) -> None:
        """Builds and simulates the scenes of a plan in groups."""
        self._seconds = max(self._settle, seconds_needed(plan))
        chosen = self._choose_scenes(plan, sink)
        if number == 0:
            self._count(0, 0, len(chosen))
        for first in range(0, len(chosen), SCENES_AT_ONCE):
            scene_idxs, built = chosen[first : first + SCENES_AT_ONCE], sink.another()
            try:
                with build_batch(plan, built, scene_idxs=scene_idxs, render=False, audit=True) as batch:
                    self._collect(built)
                    found = batch_findings(batch, self._settle, self._excused)
                    self._findings += (replace(finding, seed=plan.seed) for finding in found)
                if self._permute:
                    found = permuted_findings(plan, scene_idxs, built.another())
                    self._findings += (replace(finding, seed=plan.seed) for finding in found)
            except SceneError as error:
                self._complete = False
                self._diagnostics |= dict.fromkeys(error.diagnostics)
            else:
                self._simulated[plan.seed] = self._simulated.get(plan.seed, 0) + len(scene_idxs)
            self._count(number, first + len(scene_idxs), len(chosen))

    def _choose_scenes(self, plan: ScenePlan, sink: Sink) -> Sequence[int]:
        """Returns the scenes to build; none after an error."""
        if self._scenes is None:
            return range(plan.num_scenes)
        chosen = select_scenes(self._scenes, plan.num_scenes, sink) or ()
        self._collect(sink)
        self._complete = self._complete and len(chosen) == plan.num_scenes
        return chosen

    def _count(self, number: int, done: int, scenes: int) -> None:
        """Shows the progress. `number`: index of the seed; `scenes`: number of scenes with each seed."""
        if self._progress is not None and scenes:
            self._progress(number * scenes + done, self._seeds * scenes)


def _without_consequences(
    findings: list[Finding], origins: Mapping[str, Origin | None], diagnostics: Iterable[Diagnostic]
) -> list[Finding]:
    """Returns the findings without those that follow from others: restless joints (SC858) of articulations with a
    reported drive (SC537), and constraints that do not hold (SC584) beside a chain that is too long (SC582) or a body
    that is thrown (SC856).
    """
    if any(one.code in {"SC582", "SC856"} for one in (*diagnostics, *findings)):
        findings = [one for one in findings if one.code != "SC584"]
    told = {one.path.partition(".drives.")[0] for one in diagnostics if one.code == "SC537"}
    places = (origin_of(one.names[0], origins) if told and one.code == "SC858" else None for one in findings)
    return [one for one, place in zip(findings, places, strict=True) if not place or dotted(place.path[:2]) not in told]


def check_plan(result: CompileResult, sink: Sink) -> None:
    """Reports implausible values, objects without an effect, and doubtful meshes."""
    check_values(result.plan, result.material_origins or {}, sink)
    check_effects(result.plan, sink)
    check_layout(result.plan, sink)
    if result.document is not None:
        check_declared_names(result.document, sink)
        check_written_values(result.document, result.plan.num_scenes, sink)
    check_views(result.plan, sink)
    check_meshes(result.plan, sink)


def batch_findings(batch: SceneBatch, settle: float, excused: set[Excuse]) -> Iterator[Finding]:
    """Yields findings in live scenes at the start, and while they are simulated for `settle` [s].

    `excused` collects the used exceptions of expectations.

    Raises:
        SceneError: a state is not finite (SC820).
    """
    moving = moving_bodies(batch)
    rules = overlap_rules(batch.plan, excused, OVERLAP)
    checker = ExpectationChecker(batch, moving, excused) if batch.plan.expectations else None
    yield from unsupported_bodies(batch, moving)
    yield from crowded_scenes(batch)
    torn = list(violated_constraints(batch))
    yield from torn
    yield from weak_drives(batch)
    yield from long_steps(batch, moving)
    positions = joint_positions(batch)
    watches = EnergyWatch(batch), RobotWatch(batch)
    doubted = {*scenes_in_doubt(batch, rules.least), *uneven_scenes(moving)}
    batch.step(1)
    contacts = batch.contacts(scene_idxs=doubted)
    yield from jumps(positions, batch.timestep)
    yield from overlaps(contacts, batch.plan, rules)
    yield from mass_ratios(batch, moving, contacts)
    if settle:
        started_apart = {one.names for one in torn}
        found = simulate(batch, moving, watches, settle, rules, checker)
        yield from (one for one in found if one.code != "SC584" or one.names not in started_apart)
    elif checker:
        yield from checker.run()


def origins_of(plan: ScenePlan) -> dict[str, Origin | None]:
    """Returns the origins of everything that findings name."""
    constraints = {f"constraints/{constraint.name}": constraint.origin for constraint in plan.constraints}
    entities = {entity.name: entity.origin for entity in plan.entities}
    return (
        entities
        | joint_origins(plan)
        | constraints
        | expectation_origins(plan)
        | {SPACING: physics_origin(plan).child("scene_spacing")}
    )
