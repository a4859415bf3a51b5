"""What expressions give to parameters, held to what the parameters take."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, show
from scenecc.spec.param_types import KINDS

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.drawing import Drawing
    from scenecc.spec.param_types import Misfit, ParamType
    from scenecc.variation.bounds import ValueBounds

_NUMBERS = frozenset((int, float))


@frozen
class Argument:
    """What a parameter is given that differs from scene to scene.

    Attributes:
        name: of the draw that stands for it.
        wanted: what the parameter takes.
        scenes: of the instance whose parameter it is; what it would be in others does not matter.
        origin: where it is given, in the expanded data.
    """

    name: str
    wanted: ParamType
    scenes: tuple[int, ...]
    origin: Origin


def judge_argument(argument: Argument, drawing: Drawing) -> None:
    """Reports what is known to be wrong before anything is drawn, and leaves the rest to the draw stage.

    Args:
        argument: to be judged, whose draw is there.
        drawing: of the document.
    """
    if argument.name not in drawing.random and argument.scenes is not drawing.everywhere:
        judge_rows(argument, drawing, drawing.sink)
        return
    found = drawing.reader().shared(argument.name)
    if found.exact and argument.scenes is drawing.everywhere:
        wrong = _misfit(found, argument.wanted)
        if wrong is not None:
            _report(argument, wrong, "which this can give", drawing.sink)
            return
        if found.alternatives is not None:
            return
    drawing.arguments.append(argument)


def judge_rows(argument: Argument, drawing: Drawing, sink: Sink) -> None:
    """Reports the first scene in which a parameter is given what it does not take."""
    from scenecc.variation.errors import DrawError  # noqa: PLC0415 - loaded where something varies

    try:
        rows = drawing.leaves(argument.scenes).batch().shared(argument.name).tolist()
    except DrawError:
        # Whatever reads it tells that it has no value.
        return
    for scene, row in zip(argument.scenes, rows, strict=True):
        wrong = argument.wanted.drawn_misfit(row)
        if wrong is not None:
            _report(argument, wrong, f"which this gives in scene {scene}", sink)
            return


def _report(argument: Argument, wrong: Misfit, when: str, sink: Sink) -> None:
    code, words = wrong
    declared = argument.wanted.declared
    message = f"the parameter `{cut(argument.wanted.name)}` {words}, {when}"
    related = [("the parameter", declared, "key")] if declared is not None else []
    sink.report(code, message, argument.origin, related=related)  # pyright: ignore[reportArgumentType]


def _misfit(found: ValueBounds, wanted: ParamType) -> Misfit | None:
    """What is wrong with the first of the alternatives that is wrong, or with bounds, each of which occurs."""
    if found.alternatives is not None:
        return next((wrong for item in found.alternatives if (wrong := wanted.drawn_misfit(item))), None)
    if found.low is None or wanted.kind == "choice":
        return None
    if wanted.kind == "color":
        wanted = replace(wanted, low=0, high=1)
    if not _has_shape(found.low, wanted):
        return "SC211", f"must be {KINDS[wanted.kind][1]}, not {_like(found.low)}"
    return wanted.outside(found.low, found.high) if wanted.ranged else None


def _has_shape(bound: Any, wanted: ParamType) -> bool:
    """Whether numbers between bounds are what is wanted, as far as their shape tells."""
    if wanted.kind in {"number", "integer"}:
        return type(bound) in _NUMBERS
    if wanted.kind not in {"vector", "color", "list"} or type(bound) in _NUMBERS:
        return False
    if wanted.kind == "list":
        return True
    counts = {3, 4} if wanted.kind == "color" else {wanted.components or len(bound)}
    return len(bound) in counts and _NUMBERS.issuperset(map(type, bound))


def _like(bound: Any) -> str:
    return f"a number such as {show(bound)}" if type(bound) in _NUMBERS else f"a list of {len(bound)}"
