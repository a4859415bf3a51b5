"""`check_scene`: all that `validate` finds, doubtful values, and what a build and a simulation of all scenes show."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from typing_extensions import Unpack

from scenecc.checks.effects import check_effects
from scenecc.checks.plausibility import check_values
from scenecc.checks.views import check_views
from scenecc.diagnostics import Sink
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, Options
from scenecc.pipeline import as_plan, build_batch, compile_source, read_input
from scenecc.simulation.bodies import moving_bodies
from scenecc.simulation.findings import report_findings
from scenecc.simulation.loads import long_steps, mass_ratios, weak_drives
from scenecc.simulation.settle import simulate
from scenecc.simulation.start import overlaps, unsupported
from scenecc.simulation.torn_constraints import torn_constraints

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from scenecc.backends.sapien import SceneBatch
    from scenecc.diagnostics import Diagnostic
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.pipeline import Source
    from scenecc.plan import ScenePlan
    from scenecc.simulation.findings import Finding

SCENES_AT_ONCE = 64
"""Scenes that are built and simulated together: with more the memory grows and nothing becomes faster."""


def check_scene(
    source: Source,
    *,
    settle: float = 1.0,
    seeds: Sequence[int] | None = None,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[CompileOptions],
) -> list[Diagnostic]:
    """Everything that `validate` finds, and what shows when all scenes are built and simulated; no mistake raises.

    Args:
        source: as for `validate`.
        settle: how long it is simulated [s]; 0: the start alone is looked at.
        seeds: each is checked; the file's own (or `seed` of the options) by default. A stream has one.
        progress: called with (scenes done, scenes in all).
        options: those of `CompileOptions`.

    Raises:
        ValueError: an argument is out of its range.
        TypeError: as of `validate`.
    """
    asked = Options.of_call(check_scene, options)
    if not 0 <= settle < math.inf:
        raise ValueError(f"settle must be 0 or more and finite, not {settle!r}")
    if seeds is not None and asked.seed is not None:
        raise ValueError("seed is not taken with seeds")
    if seeds is None:
        return _check([asked], source, settle, progress)
    return _check([Options.of_call(check_scene, {**options, "seed": seed}) for seed in seeds], source, settle, progress)


def _check(
    runs: Sequence[Options], source: Source, settle: float, progress: Callable[[int, int], None] | None
) -> list[Diagnostic]:
    """Checks a source once for each of some options, which differ in the seed. Of findings the worst is reported."""
    told: dict[Diagnostic, None] = {}
    findings: list[Finding] = []
    sink, plan, shown = Sink(), None, None
    for number, options in enumerate(runs):
        here = Sink()
        if number == 0 and len(runs) > 1 and hasattr(source, "read") and as_plan(source) is None:
            # A stream can be read only once.
            found = read_input(source, options.limits, here)
            if found is None or here.failed:
                return here.diagnostics()
            source = found.plan_text or found.document
        result = compile_source(source, options, here)
        told |= dict.fromkeys(here.diagnostics())
        if result is None:
            break
        if plan is None:
            sink, plan = here.another(), result.plan
            shown = result.document.name if result.document is not None and result.document.path is not None else None

        def tell(done: int, plan: ScenePlan = result.plan, number: int = number) -> None:
            if progress is not None:
                progress(number * plan.num_scenes + done, len(runs) * plan.num_scenes)

        doubts = here.another()
        check_values(result.plan, result.material_origins or {}, doubts)
        check_effects(result.plan, doubts)
        check_views(result.plan, doubts)
        if result.plan.files:
            from scenecc.checks.mesh_quality import check_meshes  # noqa: PLC0415 - loaded where there is a mesh

            check_meshes(result.plan, doubts)
        told |= dict.fromkeys(doubts.diagnostics())
        told |= dict.fromkeys(_check_plan(result.plan, settle, tell, findings, here.another()))
    if plan is not None:
        report_findings(findings, _origins(plan), shown, sink, several_seeds=len(runs) > 1)
    return sorted([*told, *sink.diagnostics()], key=lambda d: (d.file or "", d.line or 0, d.column or 0))


def _check_plan(
    plan: ScenePlan, settle: float, tell: Callable[[int], None], findings: list[Finding], sink: Sink
) -> list[Diagnostic]:
    """Builds and simulates the scenes of a plan, some at a time, and returns what the engine refuses."""
    refused: list[Diagnostic] = []
    for first in range(0, plan.num_scenes, SCENES_AT_ONCE):
        tell(first)
        scene_idxs = range(first, min(first + SCENES_AT_ONCE, plan.num_scenes))
        try:
            with build_batch(
                plan, sink.another(), backend="cpu", scene_idxs=scene_idxs, render=False, audit="fast"
            ) as batch:
                findings += (replace(finding, seed=plan.seed) for finding in _findings(batch, settle))
        except SceneError as error:
            refused += error.diagnostics
    return refused


def _findings(batch: SceneBatch, settle: float) -> Iterator[Finding]:
    moving = moving_bodies(batch)
    yield from unsupported(batch, moving)
    yield from torn_constraints(batch)
    yield from weak_drives(batch)
    yield from long_steps(batch, moving)
    batch.step(1)
    yield from overlaps(batch.contacts(), batch.plan)
    yield from mass_ratios(batch, moving, batch.contacts())
    if settle:
        yield from simulate(batch, settle)


def _origins(plan: ScenePlan) -> dict[str, Origin | None]:
    """Where what findings name is written."""
    constraints = {f"constraints/{constraint.name}": constraint.origin for constraint in plan.constraints}
    return {entity.name: entity.origin for entity in plan.entities} | constraints
