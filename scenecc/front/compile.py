"""The stages between a source and a checked plan, top to bottom."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.diagnostics import Location, Origin, Sink
from scenecc.diagnostics.collector import collector_paused
from scenecc.front.files import named_resolver, resolver
from scenecc.front.inputs import Input, as_plan, read_input
from scenecc.source.paths import AssetScope

if TYPE_CHECKING:
    from scenecc.front.inputs import Source
    from scenecc.front.options import Options
    from scenecc.plan import ScenePlan
    from scenecc.source import Document, Limits

Origins = tuple[Mapping[int, Origin], Mapping[int, Origin]]
"""Where the files and the physical materials of a plan are written, by index."""


@dataclass(frozen=True, slots=True)
class Compiled:
    """A plan, and the seconds of each stage that led to it."""

    plan: ScenePlan
    timings: dict[str, float]


class _Clock:
    """The seconds of each stage."""

    def __init__(self) -> None:
        self.timings: dict[str, float] = {}
        self._since = time.perf_counter()

    def lap(self, stage: str) -> None:
        now = time.perf_counter()
        self.timings[stage] = now - self._since
        self._since = now


@collector_paused()  # a stage makes containers by the hundred thousand, and all of them stay
def compile_source(source: Source, options: Options, sink: Sink) -> Compiled | None:
    """The plan of a source; None where an error was reported.

    Raises:
        TypeError: the source is nothing that can hold a scene.
    """
    clock = _Clock()
    for what, given in (("parameters", options.params), ("shared draws", options.draws)):
        if given:
            sink.report("SC109", f"{what} are not supported yet", Location(None))
    plan = as_plan(source)
    # A plan that comes as an object has found its files already.
    scope = AssetScope(None, options.asset_roots, allow_outside=True)
    origins: Origins = ({}, {})
    if plan is None:
        found = read_input(source, options.limits, sink)
        clock.lap("read")
        if found is None or sink.failed:
            return None
        sink.locate = found.document.locate
        root = found.document.path.parent if found.document.path else None
        scope = AssetScope(root, options.asset_roots, options.allow_outside_assets)
        if found.plan_text is None:
            lowered = _lowered(found.document, options, scope, sink, clock)
            plan, origins = lowered or (None, origins)
        else:
            plan = _decoded(found, scope, options.limits, sink)
            clock.lap("decode")
    if plan is None or not _as_asked(plan, options, sink) or not _checked(plan, origins, scope, options.limits, sink):
        return None
    clock.lap("check")
    return Compiled(plan, clock.timings)


def _lowered(
    document: Document, options: Options, scope: AssetScope, sink: Sink, clock: _Clock
) -> tuple[ScenePlan, Origins] | None:
    """A document through the models of the language to a plan."""
    from scenecc.lower import Bounds, lower
    from scenecc.spec.parse import parse

    origin = Origin(document.name)
    scene = parse(document.data, origin, sink)
    clock.lap("validate")
    if scene is None or sink.failed:
        return None
    limits = options.limits
    lowered = lower(
        scene,
        name=document.path.stem if document.path else "scene",
        num_scenes=scene.num_scenes if options.num_scenes is None else options.num_scenes,
        seed=scene.seed if options.seed is None else options.seed,
        origin=origin,
        resolve=resolver(scope, sink),
        bounds=Bounds(limits.scenes, limits.objects, limits.objects_times_scenes),
        sink=sink,
    )
    clock.lap("lower")
    return lowered and (lowered.plan, (lowered.file_origins, lowered.material_origins))


def _decoded(found: Input, scope: AssetScope, limits: Limits, sink: Sink) -> ScenePlan | None:
    """A plan from its JSON. Its relative paths start at the JSON's own folder."""
    from scenecc.plan.from_json import PlanLimits, plan_from_json

    find = resolver(scope, sink)

    def path_of(uri: str, origin: Origin) -> Path | None:
        file = find(uri, origin)
        return file and file.path

    return plan_from_json(
        found.plan_text or "",
        base=scope.root or Path.cwd(),
        sink=sink,
        resolve=path_of,
        file=found.document.name,
        limits=PlanLimits(limits.text_bytes, limits.scenes, limits.objects_times_scenes),
    )


def _as_asked(plan: ScenePlan, options: Options, sink: Sink) -> bool:
    """A plan is final: nothing about it can be overridden any more."""
    for name in ("num_scenes", "seed"):
        asked = getattr(options, name)
        if asked is not None and asked != getattr(plan, name):
            sink.report(
                "SC907",
                f"a plan has its own {name}, {getattr(plan, name)}: it cannot become {asked}",
                plan.origin or Location(None),
                hint="compile the scene file again",
            )
            return False
    return True


def _checked(plan: ScenePlan, origins: Origins, scope: AssetScope, limits: Limits, sink: Sink) -> bool:
    """Every rule over the plan and its files."""
    from scenecc.checks.physics import check_physics

    file_origins, material_origins = origins
    check_physics(plan, material_origins, sink)
    if plan.files and not sink.failed:
        from scenecc.checks.assets import check_assets

        check_assets(
            plan,
            sink,
            resolve_named=named_resolver(scope),
            max_asset_bytes=limits.asset_bytes,
            file_origins=file_origins,
        )
    return not sink.failed
