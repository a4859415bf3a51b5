"""`settle_scene`: simulates scenes until they rest, and keeps where they rest as starts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from typing_extensions import Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut
from scenecc.errors import SceneError
from scenecc.files import replace_all
from scenecc.options import CompileOptions, Options, check_types, integer, path_argument
from scenecc.pipeline import as_plan, build_batch, compile_or_raise, read_input
from scenecc.plan.expect import Condition, NoOverlap
from scenecc.plan.starts import start_parts
from scenecc.simulation.bodies import moving_bodies, velocities
from scenecc.simulation.check import SCENES_AT_ONCE, origins_of
from scenecc.simulation.energy import EnergyWatch
from scenecc.simulation.expect import ExpectationChecker, expectation_key, overlap_rules
from scenecc.simulation.observe import Observer
from scenecc.simulation.robots import RobotWatch
from scenecc.simulation.settle import SUNK, simulate
from scenecc.simulation.start import overlaps
from scenecc.starts.file import StartRecord, StartsFile, short_floats, starts_files
from scenecc.starts.fingerprint import fingerprint

if TYPE_CHECKING:
    from os import PathLike

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch, SceneState
    from scenecc.pipeline import CompileResult, Source
    from scenecc.plan import ScenePlan
    from scenecc.simulation.bodies import MovingBody
    from scenecc.simulation.findings import Finding

STILL_SPEED: Final = 0.002
"""[m/s] A body or a sliding joint that is slower is still."""

STILL_TURN: Final = 0.02
"""[rad/s] A body or a turning joint that is slower is still. A ball that spins on its spot is still at any rate."""

STILL_TIME: Final = 0.2
"""[s] How long everything in a scene must be still. A pendulum is still for a moment at each end of its swing."""

_STRIDE: Final = 5
"""Steps between two readings of the velocities."""

_PLURALS: Final = {
    "never rests": "never rest",
    "breaks `expect`": "break `expect`",
    "cannot be built": "cannot be built",
}

FREEZE_TYPES: Final[dict[str, Any]] = {
    "seeds": Iterable[int] | None,
    "seconds": float,
    "progress": Callable[[int, int], None] | None,
}


@dataclass(frozen=True, slots=True)
class Drop:
    """A scene without a start.

    Attributes:
        seed, scene: the scene, and its seed.
        why: "never rests", "breaks `expect`" or "cannot be built".
        what: the body that moves, the condition, or the error.
        file, line: of the condition; None if unknown.
    """

    seed: int
    scene: int
    why: str
    what: str
    file: str | None = None
    line: int | None = None


@dataclass(frozen=True, slots=True)
class SettledScenes:
    """The starts of a scene, and the scenes without one.

    Attributes:
        content: the starts.
        dropped: the scenes without a start.
        diagnostics: warnings and notes of the scene.
    """

    content: StartsFile
    dropped: tuple[Drop, ...]
    diagnostics: list[Diagnostic]

    @property
    def kept(self) -> int:
        """Number of starts."""
        return len(self.content.rows)

    def files(self, name: str) -> dict[str, bytes]:
        """Returns the files of the starts by name, as for `write`."""
        return starts_files(self.content, name)

    def write(self, path: str | PathLike[str]) -> None:
        """Writes the starts as JSON, with the poses in a Parquet table beside it above 1 MB.

        Raises:
            OSError: a file cannot be written.
            ImportError: the table needs pyarrow, which is not installed.
        """
        target = path_argument(SettledScenes.write, "path", path)
        replace_all({target.parent / name: data for name, data in self.files(target.name).items()})

    def summary(self) -> str:
        """Returns a line with the numbers of kept and dropped scenes, and the reasons."""
        line = f"kept {self.kept} of {self.kept + len(self.dropped)}"
        alike: dict[tuple[str, str | None, int | None], list[Drop]] = {}
        for one in self.dropped:
            alike.setdefault((one.why, one.file, one.line), []).append(one)
        told: list[str] = []
        for (why, file, number), (first, *others) in alike.items():
            where = f"seed {first.seed} scene {first.scene}{', …' if others else ''}"
            place = f" {file}:{number}" if number is not None else ""
            words = _PLURALS[why] if others else why
            told.append(f"{1 + len(others)} {words}{place} ({where}: {first.what})")
        return f"{line}; dropped: {', '.join(told)}" if told else line


def settle_scene(
    source: Source,
    *,
    seeds: Iterable[int] | None = None,
    seconds: float = 10.0,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[CompileOptions],
) -> SettledScenes:
    """Simulates scenes until all is still, and returns where, as starts for `starts:` or `load_scene(starts=…)`.

    A scene is still if all its bodies and joints are slower than 2 mm/s and 0.02 rad/s for 0.2 s. Scenes that move for
    longer than `seconds`, or break `expect` when they begin at their start, are dropped.

    Args:
        source: as for `validate`, but not a plan.
        seeds: seeds of the starts; default: the file's own, or `seed` of the options.
        seconds: maximum simulated time [s].
        progress: called with (scenes done, total scenes).
        options: fields of `CompileOptions`. The starts that the scene names are ignored.

    Raises:
        SceneError: the scene has errors, or the engine or machine failed.
        TypeError: an argument has the wrong type.
        ValueError: an argument is out of range.
    """
    asked = replace(Options.of_call(settle_scene, options), starts=None, at_starts=False)
    check_types(settle_scene, {"seeds": seeds, "seconds": seconds, "progress": progress}, FREEZE_TYPES)
    if not 0 < seconds < math.inf:
        raise ValueError(f"seconds must be positive and finite, not {seconds!r}")
    chosen = [None] if seeds is None else list(dict.fromkeys(integer(seed, "seeds", 0) for seed in seeds))
    if not chosen:
        raise ValueError("seeds must not be empty")
    return _Settling(_document(source, asked), asked, seconds, progress).run(chosen)


def _document(source: Source, options: Options) -> Source:
    """Returns a source that can be compiled repeatedly. Raises SceneError for a plan, whose seed is final."""
    sink = Sink()
    found = None if as_plan(source) is not None else read_input(source, options.limits, sink)
    if found is None or found.plan_text is not None:
        if not sink.failed:
            hint = "name the scene file that the plan was compiled from"
            sink.report("SC907", "starts are made from a scene file, not from a plan", Location(None), hint=hint)
        raise SceneError(sink.diagnostics())
    return found.document if hasattr(source, "read") else source


class _Settling:
    """Settles a scene seed by seed. Arguments are those of `settle_scene`."""

    def __init__(
        self, source: Source, options: Options, seconds: float, progress: Callable[[int, int], None] | None
    ) -> None:
        self._source = source
        self._options = options
        self._seconds = seconds
        self._progress = progress
        self._rows: list[StartRecord] = []
        self._dropped: list[Drop] = []
        self._diagnostics: dict[Diagnostic, None] = {}

    def run(self, seeds: Sequence[int | None]) -> SettledScenes:
        """Returns the starts with these seeds. None: the seed of the options or the file."""
        first: CompileResult | None = None
        failures: list[tuple[int, SceneError]] = []
        for number, seed in enumerate(seeds):
            sink = Sink()
            try:
                options = self._options if seed is None else replace(self._options, seed=seed)
                result = compile_or_raise(self._source, options, sink)
            except SceneError as error:
                if seed is None or len(failures) + 1 == len(seeds):
                    raise
                failures.append((seed, error))
                continue
            first = first or result
            self._diagnostics |= dict.fromkeys(sink.diagnostics())
            self._settle(result, sink, number, len(seeds))
        assert first is not None
        assert first.document is not None
        for seed, error in failures:
            fault = error.diagnostics[0]
            self._dropped += [
                Drop(seed, scene, "cannot be built", fault.message, fault.file, fault.line)
                for scene in range(first.plan.num_scenes)
            ]
        made_from = fingerprint(first.document, first.expansion, first.scope, first.plan)
        content = StartsFile(
            scene=first.plan.name, num_scenes=first.plan.num_scenes, made_from=made_from, rows=self._rows
        )
        return SettledScenes(content, tuple(self._dropped), list(self._diagnostics))

    def _settle(self, result: CompileResult, sink: Sink, number: int, count: int) -> None:
        plan = result.plan
        for first in range(0, plan.num_scenes, SCENES_AT_ONCE):
            if self._progress is not None:
                self._progress(number * plan.num_scenes + first, count * plan.num_scenes)
            scene_idxs, built = range(first, min(first + SCENES_AT_ONCE, plan.num_scenes)), sink.another()
            with build_batch(plan, built, scene_idxs=scene_idxs, render=False, audit=True) as batch:
                self._diagnostics |= dict.fromkeys(built.diagnostics())
                moving, observer = moving_bodies(batch), Observer(batch)
                resting, restless = _rest(batch, moving, self._seconds)
                self._dropped += [
                    Drop(plan.seed, scene, "never rests", name) for scene, name in sorted(restless.items())
                ]
                if not resting:
                    continue
                _begin(batch, resting)
                if plan.expectations:
                    broken = _broken_expectations(batch, moving, observer)
                    self._drop_broken([one for one in broken if one.scene in resting], plan, sink)
                    for one in broken:
                        resting.pop(one.scene, None)
                    _begin(batch, resting)
                self._rows += [_record(batch, scene) for scene in sorted(resting)]

    def _drop_broken(self, broken: list[Finding], plan: ScenePlan, sink: Sink) -> None:
        """Records scenes that break an expectation, each with the first that it breaks."""
        conditions = {
            expectation_key(one.name): one.that.text for one in plan.expectations if isinstance(one, Condition)
        }
        for scene in sorted({one.scene for one in broken}):
            finding = next(one for one in broken if one.scene == scene)
            own, origin = sink.another(), origins_of(plan).get(finding.names[0])
            if origin is not None:
                own.report(finding.code, finding.message, origin)
            found = next(iter(own.diagnostics()), None)
            what = conditions.get(finding.names[0], finding.message)
            place = (None, None) if found is None else (found.file, found.line)
            self._dropped.append(Drop(plan.seed, scene, "breaks `expect`", cut(what, 100), *place))


def _rest(batch: SceneBatch, moving: list[MovingBody], seconds: float) -> tuple[dict[int, SceneState], dict[int, str]]:
    """Simulates a batch until its scenes rest. Returns their states, and of the others what moves most."""
    resting: dict[int, SceneState] = {}
    needed = max(math.ceil(STILL_TIME / batch.timestep / _STRIDE), 1)
    still = dict.fromkeys(batch.scene_idxs, 0)
    fastest: dict[int, tuple[float, str]] = {}
    for _ in range(max(math.ceil(seconds / batch.timestep / _STRIDE), needed)):
        batch.step(_STRIDE)
        fastest = _fastest(batch, moving)
        for scene in still:
            still[scene] = still[scene] + 1 if fastest[scene][0] < 1 else 0
            if still[scene] >= needed and scene not in resting:
                resting[scene] = batch.state([scene])
        if len(resting) == len(batch):
            break
    return resting, {scene: name for scene, (_, name) in fastest.items() if scene not in resting}


def _fastest(batch: SceneBatch, moving: list[MovingBody]) -> dict[int, tuple[float, str]]:
    """Returns for each scene the greatest speed as a multiple of the limit, and the name of the body or joint."""
    found: dict[int, tuple[float, str]] = dict.fromkeys(batch.scene_idxs, (0.0, ""))

    def note(scene: int, speed: float, name: str) -> None:
        speed = speed if math.isfinite(speed) else math.inf
        if speed > found[scene][0]:
            found[scene] = speed, name

    numbers = velocities(moving)
    for body, linear, angular in zip(moving, numbers[:, :3], numbers[:, 3:], strict=True):
        is_ball = body.axis is not None and not body.axis.any()
        turn = 0.0 if is_ball else float(np.linalg.norm(angular)) / STILL_TURN
        note(body.scene, max(float(np.linalg.norm(linear)) / STILL_SPEED, turn), body.entity)
    for name, articulation in batch.articulations.items():
        qvel: NDArray[np.float64] = np.abs(np.asarray(articulation.qvel, np.float64))
        for scene, speeds, obj in zip(articulation.scene_idxs, qvel, articulation.objs, strict=True):
            for joint, speed in zip(obj.get_active_joints(), speeds.tolist(), strict=False):
                slides = joint.get_type() == "prismatic"
                note(scene, speed / (STILL_SPEED if slides else STILL_TURN), f"{name}/{joint.get_name()}")
    return found


def _begin(batch: SceneBatch, resting: dict[int, SceneState]) -> None:
    """Sets the scenes to their states, at rest and awake, without a history in the engine."""
    from scenecc.backends.sapien import ArticulationState  # noqa: PLC0415 - loads the engine

    for scene, state in resting.items():
        for one in state.all.values():
            one.linear_velocity[:] = one.angular_velocity[:] = 0
            one.asleep[:] = False
            if isinstance(one, ArticulationState):
                one.qvel[:] = one.qvel * 0  # missing joints stay NaN
        batch.set_state(state, [scene], exact=True)


def _broken_expectations(batch: SceneBatch, moving: list[MovingBody], observer: Observer) -> list[Finding]:
    """Simulates a batch from its starts, and returns what breaks an expectation. `tilt` refers to the build."""
    checker = ExpectationChecker(batch, moving, set(), observer)
    rules = overlap_rules(batch.plan, set(), SUNK)
    watches = EnergyWatch(batch), RobotWatch(batch)
    batch.step(1)
    found: list[Finding] = []
    if any(isinstance(one, NoOverlap) for one in batch.plan.expectations):
        found += overlaps(batch.contacts(), batch.plan, rules)
    return [*found, *simulate(batch, moving, watches, 0.0, rules, checker)]


def _record(batch: SceneBatch, scene: int) -> StartRecord:
    """Returns the start of a scene: the state of the batch."""
    states = batch.state([scene])
    poses: dict[str, list[float]] = {}
    joints: dict[str, dict[str, float]] = {}
    for entity, _, active in start_parts(batch.plan, scene):
        poses[entity.name] = short_floats(states.all[entity.name].pose[0])
        if active:
            articulation = batch.articulations[entity.name]
            row = articulation.scene_idxs.index(scene)
            known = dict(
                zip(
                    (one.get_name() for one in articulation.objs[row].get_active_joints()),
                    short_floats(states.articulations[entity.name].qpos[0]),
                    strict=False,
                )
            )
            joints[entity.name] = {joint.name: known[joint.name] for joint in active}
    # The inertia that follows from a drawn mass is not drawn.
    drawn = {
        name: one.numbers[0].tolist() if not name.endswith(".mass") else float(one.numbers[0].flat[0])
        for name, one in states.drawn.items()
        if one.scene_idxs and not one.seen
    }
    return StartRecord(seed=batch.plan.seed, scene=scene, poses=poses, joints=joints, draws=drawn)
