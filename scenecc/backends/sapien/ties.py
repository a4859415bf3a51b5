"""The constraints of a batch: as a user handles them, at a reset, and as the engine holds them."""

from __future__ import annotations

from contextlib import contextmanager
from math import isinf
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.columns import poses, vectors
from scenecc.backends.sapien.component_batch import ComponentBatch
from scenecc.backends.sapien.constraints import Tie, plain, start_calls, target_call, velocity_call
from scenecc.diagnostics import Location
from scenecc.plan import Drive
from scenecc.variation.errors import DrawError
from scenecc.variation.per_scene_arrays import to_field_rows

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator, Sequence

    from scenecc.backends.sapien.constraints import Call
    from scenecc.backends.sapien.standing import Standing
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan, Value
    from scenecc.variation.evaluation import Batch

Again = list[tuple[Any, str, tuple[Any, ...]]]
"""Components, what is set on them, and the arguments."""

_CODE = "SC802"
_TOLERANCE = 1e-6
"""How far a component of a rotation may be from what was set: PhysX normalises what frames it takes."""


class ConstraintBatch(ComponentBatch):
    """One constraint of the plan, in every scene that has it.

    `objs` are `sapien.physx.PhysxDriveComponent`s of a weld or a drive, `PhysxDistanceJointComponent`s of a connection
    or a distance, and `PhysxGearComponent`s of a gear.
    """

    def in_scene(self, scene_idx: int) -> Any:
        """The component in a scene of the plan; None where there is none. Raises RuntimeError once closed."""
        return self.objs[self._scene_idxs.index(scene_idx)] if scene_idx in self._scene_idxs else None


class Ties:
    """The constraints of a batch.

    Attributes:
        batches: by name, in the order of the plan.
    """

    def __init__(self, plan: ScenePlan, standing: Standing) -> None:
        """Builds them, one after the other in each scene. What they tie together stands there already."""
        self._ties = [tie for each in plan.constraints if (tie := Tie(each, standing.scene_idxs)).scene_idxs]
        self.batches: dict[str, ConstraintBatch] = {
            tie.constraint.name: ConstraintBatch(tie.constraint.name, tie.scene_idxs, tie.build(standing))
            for tie in self._ties
        }

    def audit(self, sink: Sink) -> bool:
        """Compares what the engine holds with what was set, reports differences, and says whether there is none.

        The limits of a distance and the scales of a drive SAPIEN gives nobody.
        """
        good = True
        for tie in self._ties:
            wrong: dict[str, list[int]] = {}
            for number, component in enumerate(self.batches[tie.constraint.name].objs):
                for what in _differences(tie, component, number):
                    wrong.setdefault(what, []).append(tie.scene_idxs[number])
            for what, scene_idxs in wrong.items():
                more = f" (and in {len(scene_idxs) - 1} more)" if len(scene_idxs) > 1 else ""
                message = f"constraint '{tie.constraint.name}' in scene {scene_idxs[0]}{more}: the engine holds {what}"
                sink.report(_CODE, message, tie.constraint.origin or Location(None))
                good = False
        return good

    @property
    def pulls(self) -> bool:
        """Whether any of them is driven somewhere, so that a reset has something to set."""
        return any(isinstance(tie.constraint.joint, Drive) and tie.constraint.joint.drives for tie in self._ties)

    def again(self, batch: Batch) -> Again:
        """The targets of drives at the start; nothing is set yet.

        Args:
            batch: the scenes that are reset.

        Raises:
            ValueError: something that is drawn has no value.
        """
        steps: Again = []
        for tie in self._ties:
            steps += again_of(tie, self.batches[tie.constraint.name].objs, batch)
        return steps

    @contextmanager
    def apart(self, scene_idx: int) -> Generator[None, None, None]:
        """Takes the constraints of a scene out of its simulation for a while, and puts them back in build order.

        PhysX solves constraints in an order that follows from when their bodies came in, and moves on otherwise in the
        last bit in another.
        """
        held = [
            (component.get_entity(), component)
            for each in self.batches.values()
            if (component := each.in_scene(scene_idx)) is not None
        ]
        for entity, component in reversed(held):
            entity.remove_component(component)
        try:
            yield
        finally:
            for entity, component in held:
                entity.add_component(component)

    def close(self) -> None:
        """Lets go of everything."""
        for each in self.batches.values():
            each._close()  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
        self.batches, self._ties = {}, []


def again_of(tie: Tie, objs: Sequence[Any], batch: Batch) -> Iterator[tuple[Any, str, tuple[Any, ...]]]:
    """The targets of one constraint at the start. `objs`: its components in the order of its scenes.

    Raises:
        ValueError: something that is drawn has no value.
    """
    joint = tie.constraint.joint
    number_of = {index: number for number, index in enumerate(tie.scene_idxs)}
    having = [number for number, index in enumerate(batch.scenes.tolist()) if index in number_of]
    if not isinstance(joint, Drive) or not having:
        return
    part = batch if len(having) == len(batch.scenes) else batch.only(np.array(having, dtype=np.intp))
    numbers = [number_of[index] for index in part.scenes.tolist()]
    rows = tie.rows[numbers]
    drawn = [
        None if value is None or value.recipe is None else _drawn(tie, what, value, part)
        for what, value in (
            ("target", joint.target),
            ("velocity_target", joint.linear_velocity_target),
            ("velocity_target", joint.angular_velocity_target),
        )
    ]
    calls = [_anew(call, drawn, len(rows)) for call in start_calls(joint, rows)]
    for place, number in enumerate(numbers):
        for call in calls:
            yield objs[number], call.set, call.arguments(place)


def _anew(call: Call, drawn: list[Any], count: int) -> Call:
    """A call with what is drawn in place of what was built."""
    target, linear, angular = drawn
    if call.set == "set_drive_target":
        return call if target is None else target_call(poses(target))
    if linear is None and angular is None:
        return call
    built = [call.arguments(number) for number in range(count)]
    return velocity_call(
        [one for one, _ in built] if linear is None else vectors(linear),
        [one for _, one in built] if angular is None else vectors(angular),
    )


def _drawn(tie: Tie, what: str, value: Value, batch: Batch) -> Any:
    """(B, 7) or (B, 3) of what a reset draws."""
    assert value.recipe is not None
    try:
        found = np.asarray(to_field_rows(batch.evaluate(value.recipe)), np.float64)
    except DrawError as error:
        message = f"'{tie.constraint.name}' in scene {error.scene}: its {what} has no value: {error.message}"
        raise ValueError(message) from None
    with np.errstate(over="ignore"):
        wrong = np.flatnonzero(~np.isfinite(found.astype(np.float32)).all(axis=1))
    if wrong.size:
        scene = int(batch.scenes[wrong[0]])
        raise ValueError(
            f"'{tie.constraint.name}' in scene {scene}: its {what} is drawn as {found[wrong[0]].tolist()}, and the "
            "engine takes finite numbers in the range of float32 alone"
        )
    return found


def _differences(tie: Tie, component: Any, number: int) -> Iterator[str]:
    frames = (("pose_in_child", tie.in_child), ("pose_in_parent", tie.in_parent))
    for name, column in frames:
        found, wanted = plain(getattr(component, name)), plain(column[number % len(column)])
        if found[:3] != wanted[:3] or not np.allclose(found[3:], wanted[3:], rtol=0, atol=_TOLERANCE):
            yield f"{name} = {found}, and the plan asks for {wanted}"
    if (component.get_parent() is None) != (tie.constraint.parent is None):
        yield "another parent than the plan asks for"
    for call in tie.calls:
        if call.set == "enable_hinges" and not component.is_hinges_enabled:
            yield "no hinges, and the plan asks for them"
        if call.get is None:
            continue
        found, wanted = plain(getattr(component, call.get)()), plain(call.arguments(number))
        if not _alike(found, wanted) and not _is_locked(call, wanted):
            yield f"{call.get.removeprefix('get_')} = {found}, and the plan asks for {wanted}"


def _is_locked(call: Call, wanted: list[Any]) -> bool:
    """Whether an axis is locked or free: then PhysX has no limits of it to give back."""
    return call.set.startswith("set_limit") and (wanted[0] == wanted[1] or all(map(isinf, wanted[:2])))


def _alike(found: list[Any], wanted: list[Any]) -> bool:
    if len(found) != len(wanted):
        return False
    exact = len(found) != 7  # a target is a frame too
    return all(
        one == other or (not exact and not isinstance(one, str) and abs(one - float(other)) <= _TOLERANCE)
        for one, other in zip(found, wanted, strict=True)
    )
