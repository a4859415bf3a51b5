"""Checks of a scene's expectations: bodies that stay, allowed overlaps, and conditions at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.diagnostics.messages import show
from scenecc.placing.bodies import UnsupportedShapeError
from scenecc.plan.expect import Condition, NoOverlap, Settled
from scenecc.plan.starts import StartTable
from scenecc.simulation.bodies import poses
from scenecc.simulation.findings import Finding, length_text
from scenecc.simulation.observe import Observer
from scenecc.variation.evaluation import Batch
from scenecc.variation.nodes import BUILTIN_NAMES
from scenecc.variation.operations import DrawError, ExpressionError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.backends.sapien import SceneBatch
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin, Path
    from scenecc.plan import ScenePlan
    from scenecc.plan.expect import Reading
    from scenecc.simulation.bodies import MovingBody

Excuse = tuple[str, int]
"""The name of an expectation, and the index of one of its exceptions."""


def expectation_key(name: str) -> str:
    """Returns the name of an expectation in findings. Entity names have no colon."""
    return f"expect:{name}"


def expectation_origins(plan: ScenePlan) -> dict[str, Origin | None]:
    """Returns the origin of each expectation by its key; for a condition, that of its expression."""
    return {
        expectation_key(one.name): one.origin.child("that") if one.origin and isinstance(one, Condition) else one.origin
        for one in plan.expectations
    }


def seconds_needed(plan: ScenePlan) -> float:
    """Returns how long the expectations of a plan must be simulated [s]; 0 if at most one step."""
    settled = (one.seconds for one in plan.expectations if isinstance(one, Settled))
    conditions = (one.after for one in plan.expectations if isinstance(one, Condition))
    return max(*settled, *conditions, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class OverlapRules:
    """How deep bodies may overlap, by the expectations of a plan.

    Attributes:
        rules: the overlap expectations.
        used: collects the used exceptions.
        otherwise: allowed depth of bodies that no rule names [m].
    """

    rules: tuple[NoOverlap, ...]
    used: set[Excuse]
    otherwise: float

    @property
    def least(self) -> float:
        """The smallest allowed depth for any bodies [m]."""
        said = [rule.deeper_than for rule in self.rules if rule.deeper_than is not None]
        return min([self.otherwise, *said])

    def allowed(self, a: str, b: str) -> float:
        """Returns how deep bodies of two entities may overlap [m]: the smallest depth of the rules for them."""
        inside = [rule for rule in self.rules if rule.entities is None or {a, b} <= {*rule.entities}]
        said = [rule.deeper_than for rule in inside if rule.deeper_than is not None]
        return min(said, default=self.otherwise)

    def excuses(self, a: tuple[str, str], b: tuple[str, str]) -> bool:
        """Returns whether two bodies, each given with its entity, may overlap as deep as they do."""
        found = [
            (rule.name, number)
            for rule in self.rules
            for number, pair in enumerate(rule.excepted)
            if (pair.a in a and pair.b in b) or (pair.a in b and pair.b in a)
        ]
        self.used.update(found)
        return bool(found)


def overlap_rules(plan: ScenePlan, used: set[Excuse], otherwise: float) -> OverlapRules:
    """Returns the overlap rules of a plan. Arguments are the attributes of `OverlapRules`."""
    return OverlapRules(tuple(one for one in plan.expectations if isinstance(one, NoOverlap)), used, otherwise)


def report_unused_exceptions(plan: ScenePlan, used: set[Excuse], sink: Sink) -> None:
    """Reports unused exceptions; for a prefab, those unused by all instances. `used`: the used ones, in any scene."""
    unused: dict[tuple[str | None, Path], tuple[str, Origin]] = {}
    needed: set[tuple[str | None, Path]] = set()
    for one in plan.expectations:
        for number, _ in enumerate(() if isinstance(one, Condition) else one.excepted):
            if one.origin is None:
                continue
            place = one.origin.child("except", number)
            written = place if sink.trace is None else sink.trace(place)
            if (one.name, number) in used:
                needed.add((written.file, written.path))
            else:
                why = "no such body moves that far" if isinstance(one, Settled) else "they do not overlap"
                unused[written.file, written.path] = f"this exception is unused: {why}", place
    for written, (message, place) in unused.items():
        if written not in needed:
            sink.report("SC863", message, place, hint="remove it")


class ExpectationChecker:
    """Checks the expectations of a batch during its simulation.

    Args:
        batch: a batch that was not stepped yet.
        moving: its moving bodies.
        used: collects the used exceptions of `settled`.
        observer: its start is that of `tilt`; None: the batch's state now.
    """

    def __init__(
        self, batch: SceneBatch, moving: list[MovingBody], used: set[Excuse], observer: Observer | None = None
    ) -> None:
        self._batch = batch
        self._used = used
        self._observer = observer or Observer(batch)
        self._due: dict[int, list[Settled | Condition]] = {}
        for one in batch.plan.expectations:
            if isinstance(one, Settled):
                self._due.setdefault(max(round(one.seconds / batch.timestep), 1), []).append(one)
            elif isinstance(one, Condition):
                self._due.setdefault(round(one.after / batch.timestep), []).append(one)
        self._moving = moving
        self._start = poses(moving)
        self._values: dict[Reading, Mapping[int, Any]] = {}
        self._faults: dict[str, str] = {}
        self._observe(0)

    @property
    def steps(self) -> list[int]:
        """The step counts after which something is checked, ascending."""
        return sorted(self._due)

    def run(self) -> Iterator[Finding]:
        """Simulates the batch after its first step until everything was checked, and yields unmet expectations."""
        done = 1
        for end in self.steps:
            self._batch.step(max(end - done, 0), check=True)
            done = max(end, done)
            yield from self.check(end)

    def check(self, step: int) -> Iterator[Finding]:
        """Yields unmet expectations after `step` steps. Conditions at the start are checked after the first step."""
        if step:
            self._values = {}
            self._observe(step)
        for one in self._due.get(step, ()):
            if isinstance(one, Settled):
                yield from self._find_unsettled(one)
            else:
                yield from self._check_condition(one, self._observe_contacts(one) | self._values)

    def _observe(self, step: int) -> None:
        for one in self._due.get(step, ()):
            for reading in one.readings if isinstance(one, Condition) else ():
                if reading.kind not in {"draw", "touching"} and reading not in self._values:
                    try:
                        self._values[reading] = self._observer.values(reading)
                    except (UnsupportedShapeError, AssetError) as error:
                        self._values[reading] = {}
                        self._faults[reading.name] = f"distances from {error} cannot be measured"

    def _observe_contacts(self, condition: Condition) -> dict[Reading, Mapping[int, Any]]:
        touching = [reading for reading in condition.readings if reading.kind == "touching"]
        return {reading: self._observer.touching(*reading.of) for reading in touching}

    def _find_unsettled(self, settled: Settled) -> Iterator[Finding]:
        end = poses(self._moving)
        away = np.linalg.norm(end[:, :3] - self._start[:, :3], axis=1)
        cosine = np.abs(np.einsum("ij,ij->i", end[:, 3:], self._start[:, 3:]))
        turn = 2 * np.arccos(np.clip(cosine, 0.0, 1.0))
        for number, body in enumerate(self._moving):
            name, moved, turned = body.entity, float(away[number]), float(turn[number])
            if settled.entities is not None and name not in settled.entities:
                continue
            if moved <= settled.within and turned <= settled.angle:
                continue
            if name in settled.excepted:
                self._used.add((settled.name, settled.excepted.index(name)))
                continue
            yield Finding(
                "SC860",
                (expectation_key(settled.name), name),
                body.scene,
                max(moved / max(settled.within, 1e-9), turned / max(settled.angle, 1e-9)),
                f"`{name}` does not stay in place: after {settled.seconds:g} s it is {length_text(moved)} away "
                f"and turned by {np.degrees(turned):.3g}°",
            )

    def _check_condition(
        self, condition: Condition, observed: Mapping[Reading, Mapping[int, Any]]
    ) -> Iterator[Finding]:
        chosen = set(condition.scene_idxs)
        scenes = [scene for scene in self._batch.scene_idxs if scene in chosen]
        if not scenes:
            return
        try:
            draws = self._draws(condition, scenes)
        except DrawError as error:
            yield _failure(condition, error.scene, f"a draw that this condition reads has no value: {error.message}")
            return
        for row, scene in enumerate(scenes):
            values = {name: values[row] for name, values in draws.items()}
            # Instances of one prefab use the same names for different bodies.
            own = ((reading.name, observed.get(reading, {})) for reading in condition.readings)
            values |= {name: found[scene] for name, found in own if scene in found}
            known = _SceneValues(values, condition, self._faults)
            try:
                result = condition.that.run(known)
            except ExpressionError as error:
                yield _failure(condition, scene, f"this has no value: {error.message}", (error.start, error.end))
                continue
            if type(result) is not bool:
                yield _failure(condition, scene, f"this gives {show(result)}, but must be true or false")
            elif not result:
                when = f"after {condition.after:g} s" if condition.after else "at the start"
                because = f" ({condition.because})" if condition.because else ""
                # Rounded to four digits, a number that misses `== 0.15` would be shown as 0.15.
                digits = 9 if "==" in condition.that.text else 4
                shown = "; ".join(f"`{name}` is {_format_value(known[name], digits)}" for name in list(known.read))
                message = f"{when} this does not hold{because}" + (f": {shown}" if shown else "")
                yield Finding("SC861", (expectation_key(condition.name),), scene, 0.0, message)

    def _draws(self, condition: Condition, scenes: list[int]) -> dict[str, list[Any]]:
        """Returns the values that do not depend on the simulation: draws, the scene and constants, a row per scene."""
        plan, count = self._batch.plan, len(scenes)
        seed = tuple(StartTable(plan).seeds(scenes, [plan.seed] * count)) if plan.starts else plan.seed
        drawn = Batch(np.array(scenes, np.int64), seed, plan.num_scenes, dict(plan.draws), {})
        found: dict[str, list[Any]] = {
            reading.name: drawn.shared(reading.of[0]).tolist()
            for reading in condition.readings
            if reading.kind == "draw"
        }
        constants = {"num_scenes": plan.num_scenes, **dict(condition.that.constants)}
        return found | {"scene": scenes} | {name: [value] * count for name, value in constants.items()}


class _SceneValues(dict[str, Any]):
    """The values that a condition may read in one scene. Reading a value that the scene lacks is an error.

    Attributes:
        read: names of the simulated or drawn values, in the order in which they were read.
    """

    def __init__(self, values: Mapping[str, Any], condition: Condition, faults: Mapping[str, str]) -> None:
        super().__init__(values)
        self.read: dict[str, None] = {}
        self._condition = condition
        self._faults = faults
        self._reading_names = {reading.name for reading in condition.readings} | BUILTIN_NAMES

    def __getitem__(self, name: str) -> Any:
        if name in self._reading_names:
            self.read[name] = None
        return super().__getitem__(name)

    def __missing__(self, name: str) -> Any:
        of = next((list(reading.of) for reading in self._condition.readings if reading.name == name), [name])
        missing = f"not all of {', '.join(of)} are" if len(of) > 1 else f"`{of[0]}` is not"
        message = self._faults.get(name, f"{missing} in this scene; restrict it with `scene_idxs`")
        raise ExpressionError(message, *self._condition.that.place(name))


def _failure(condition: Condition, scene: int, message: str, span: tuple[int, int] | None = None) -> Finding:
    return Finding("SC862", (expectation_key(condition.name),), scene, 0.0, message, span=span)


def _format_value(value: Any, digits: int) -> str:
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, list):
        return f"[{', '.join(_format_value(item, digits) for item in value)}]"  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]
    return show(value)
