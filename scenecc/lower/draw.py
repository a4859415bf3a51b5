"""The draw stage: what only its rows can be judged by is drawn and judged, and resets get their recipes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.lower.pending import report_failure
from scenecc.spec.known import known_as

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.lower.drawing import Drawing
    from scenecc.lower.pending import Pending
    from scenecc.lower.scene import Lowered
    from scenecc.plan import ScenePlan
    from scenecc.plan.fields import Bounds


def draw(lowered: Lowered, sink: Sink) -> ScenePlan | None:
    """The plan with what a reset draws anew; None where a drawn value was reported as an error.

    Args:
        lowered: of which `lower` has reported nothing.
        sink: takes the diagnostics; each names the scene.
    """
    drawing = lowered.drawing
    if not drawing.varies:
        return lowered.plan
    from scenecc.lower.arguments import judge_rows  # noqa: PLC0415 - loaded where something varies
    from scenecc.lower.resets import Recipes  # noqa: PLC0415 - likewise

    for argument in drawing.arguments:
        judge_rows(argument, drawing, sink)
    for pending in drawing.pending:
        judge(pending, drawing, sink)
    if sink.failed:
        return None
    recipes = Recipes(drawing, lowered.places)
    entities = tuple(map(recipes.entity, lowered.plan.entities))
    plan = lowered.plan
    lights = tuple(replace(one, pose=recipes.follower(known_as("lights", one.name), one.pose)) for one in plan.lights)
    cameras = tuple(replace(one, pose=recipes.follower(one.name, one.pose)) for one in plan.cameras)
    constraints = tuple(map(recipes.constraint, plan.constraints))
    return replace(
        plan, entities=entities, constraints=constraints, lights=lights, cameras=cameras, draws=recipes.draws()
    )


def judge(pending: Pending, drawing: Drawing, sink: Sink) -> None:
    """Reports the first scene in which a value is none, or out of its range."""
    from scenecc.variation.errors import DrawError  # noqa: PLC0415 - likewise

    try:
        data = pending.value.data
    except DrawError as error:
        report_failure(error, {**drawing.draw_origins, **pending.origins}, pending.origin, sink)
        return
    bounds = pending.kind.bounds()
    row = _outside(data, bounds)
    if row is not None:
        scene = pending.scenes[row]
        wrong = next(number for number in data[row].ravel().tolist() if not bounds.allow(number))
        each = "each number" if data[row].size > 1 else "it"
        message = f"in scene {scene} this is {_shown(data[row])}: {each} must be {bounds.wanted(wrong)}"
        sink.report("SC513", message, pending.origin)


def _outside(data: NDArray[Any], bounds: Bounds) -> int | None:
    """The first row that is outside of its range."""
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    if data.dtype == np.bool_:
        return None
    inside = (data >= bounds.low) & (data <= bounds.high)
    if bounds.nonzero:
        inside &= data != 0
    rows = np.flatnonzero(~inside.reshape(len(data), -1).all(axis=1))
    return int(rows[0]) if rows.size else None


def _shown(row: Any) -> str:
    numbers = row.ravel().tolist()
    return f"{numbers[0]:g}" if len(numbers) == 1 else "[" + ", ".join(f"{number:g}" for number in numbers) + "]"
