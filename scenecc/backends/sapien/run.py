"""From a plan to live scenes, readable top to bottom: the machine, the settings, the build, the audit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

from scenecc.backends.sapien.audit.defaults import present_defaults
from scenecc.backends.sapien.audit.report import audit as audit_batch
from scenecc.backends.sapien.audit.seen import audit_seen
from scenecc.backends.sapien.build import build_scenes, report, unchanged
from scenecc.backends.sapien.cuda import refusal
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.backends.sapien.machine import new_render_system, render_problem
from scenecc.backends.sapien.seen.dress import Dress
from scenecc.backends.sapien.settings import engine_settings
from scenecc.backends.sapien.standing import Standing
from scenecc.backends.sapien.ties import Ties
from scenecc.diagnostics.collector import collector_paused

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.backends.sapien.batch import SceneBatch
    from scenecc.backends.sapien.turn import AnyTurn
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan

DRIVERS: Final = (
    "with a GPU, install its Vulkan driver (in a container of NVIDIA's, ask for the capability `graphics`);\n"
    "without one, Mesa's lavapipe, 24.3 or later, renders on the CPU: `apt-get install mesa-vulkan-drivers libvulkan1`"
)
"""How to get a render device, in two lines."""


def run(
    plan: ScenePlan,
    sink: Sink,
    scene_idxs: tuple[int, ...],
    *,
    device: Literal["cpu", "cuda"],
    render: bool | None,
    audit: Literal["full", "fast", "off"],
    progress: Callable[[int, int], None] | None,
) -> SceneBatch | None:
    """`scenecc.backends.sapien.instantiate` once the engine is known to be there."""
    try:
        if device == "cuda":
            raise refusal()
        rendered = _rendered(render=render)
    except EngineFailure as failure:
        report(failure, sink, plan.origin)
        return None
    # Without a system that holds it, SAPIEN's renderer is started and ended again for every single material.
    renderer = new_render_system() if rendered else None
    present = present_defaults(rendered=rendered)
    with engine_settings(plan.physics), collector_paused():
        built = build_scenes(plan, scene_idxs, sink, rendered=rendered, progress=progress)
        if built is None:
            return None
        del renderer
        batch, turns = built
        good = False
        try:
            # Before anything else is built: the audit of bodies finds nothing but them in the scenes.
            good = (
                (audit == "off" or audit_batch(batch, turns, present, sink, audit))
                and _complete(batch, turns, sink, audited=audit != "off")
                and unchanged(plan, sink)
            )
        finally:
            # Also after an error of ours and after Ctrl-C.
            if not good:
                batch.close()
        return batch if good else None


def _complete(batch: SceneBatch, turns: list[AnyTurn], sink: Sink, *, audited: bool) -> bool:
    """Builds constraints, lights and cameras; whether they are there, and as the plan asks where it is audited."""
    plan, standing = batch.plan, Standing(batch.scene_idxs, batch.scenes, turns)
    try:
        if plan.constraints:
            ties = Ties(plan, standing)
            batch.tie(ties)
            if audited and not ties.audit(sink):
                return False
        dress = Dress(plan, standing, rendered=batch.render)
    except EngineFailure as failure:
        report(failure, sink, plan.origin)
        return False
    batch.dress(dress)
    return not (audited and batch.render) or audit_seen(plan, dress, standing, sink)


def _rendered(*, render: bool | None) -> bool:
    if render is False:
        return False
    problem = render_problem()
    if render is None or problem is None:
        return problem is None
    raise EngineFailure(
        "SC803",
        f"visuals were asked for, and there is no render device: {problem}",
        hint=DRIVERS,
    )
