"""Rules for chains of constraints, such as ropes, which PhysX solves one constraint after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.plan import BodyStructure, Connection, Drive, Weld

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Sink
    from scenecc.plan import Constraint, Entity, ScenePlan

_ITERATIONS = 10
"""SAPIEN's default of position iterations."""

_BODIES_PER_ITERATION = 2
"""A hanging chain of this many bodies for each iteration stretches by almost 1 % and swings; with one, by 0.3 %."""

_Graph = dict[str, list[tuple[str, "Constraint"]]]
"""Dynamic bodies: their neighbours and the constraints to them."""


def check_chains(plan: ScenePlan, sink: Sink) -> None:
    """Reports bodies with several connections (SC583), and chains that are too long for the solver (SC582)."""
    dynamic = {entity.name: entity for entity in plan.entities if _is_dynamic(entity)}
    _check_connections(plan, dynamic, sink)
    graph: _Graph = {}
    for constraint in plan.constraints:
        child = constraint.child.entity
        parent = child if constraint.parent is None else constraint.parent.entity
        if parent != child and child in dynamic and parent in dynamic and _holds_position(constraint):
            graph.setdefault(child, []).append((parent, constraint))
            graph.setdefault(parent, []).append((child, constraint))
    seen: set[str] = set()
    for name in graph:
        if name not in seen:
            near = _path_from(name, graph)
            seen.update(near)
            path = _path_from(list(near)[-1], graph)
            _check_length(path, [dynamic[one] for one in near], plan, sink)


def _is_dynamic(entity: Entity) -> bool:
    return all(isinstance(one, BodyStructure) and one.body_type == "dynamic" for one in entity.structures)


def _holds_position(constraint: Constraint) -> bool:
    """Whether a constraint locks all translations in every scene."""
    joint = constraint.joint
    if isinstance(joint, Drive):
        locked = {limit.axis for limit in joint.limits if not limit.limits.data.any()}
        return locked >= {"x", "y", "z"}
    return isinstance(joint, Weld)


def _check_connections(plan: ScenePlan, dynamic: Mapping[str, Entity], sink: Sink) -> None:
    first: dict[str, Constraint] = {}
    for constraint in plan.constraints:
        if not isinstance(constraint.joint, Connection):
            continue
        for mount in (constraint.child, constraint.parent):
            if mount is None or mount.entity not in dynamic:
                continue
            other = first.setdefault(mount.entity, constraint)
            if other is not constraint and constraint.origin is not None:
                names = f"`{cut(other.name)}` and `{cut(constraint.name)}`"
                message = f"{names} are connections of `{cut(mount.entity)}`, which gain energy together and throw it"
                sink.report("SC583", message, constraint.origin, at="key", hint="write `type: ball`")
                return


def _path_from(start: str, graph: _Graph) -> dict[str, Constraint | None]:
    """Bodies that can be reached, breadth first, each with the constraint that leads to it."""
    found: dict[str, Constraint | None] = {start: None}
    order = [start]
    for name in order:
        for other, constraint in graph[name]:
            if other not in found:
                found[other] = constraint
                order.append(other)
    return found


def _check_length(path: Mapping[str, Constraint | None], bodies: list[Entity], plan: ScenePlan, sink: Sink) -> None:
    """Compares the longest chain with the iterations. `path`: reached from one of its ends."""
    *_, last = path
    length, name = 1, last
    constraint = path[name]
    while constraint is not None:
        assert constraint.parent is not None
        length += 1
        name = constraint.parent.entity if name == constraint.child.entity else constraint.child.entity
        constraint = path[name]
    iterations = max(_iterations(body, plan) for body in bodies)
    end = path[last]
    if end is not None and end.origin is not None and length > _BODIES_PER_ITERATION * iterations:
        message = f"a chain of {length} bodies stretches and swings: PhysX solves it in only {iterations} iterations"
        hint = f"write `solver_position_iterations: {min(length, 255)}` on its bodies, or use `scenecc:rope`"
        sink.report("SC582", message, end.origin, at="key", hint=hint)


def _iterations(entity: Entity, plan: ScenePlan) -> int:
    """The position iterations of a body, the least of its scenes."""
    given = [one.solver_position_iterations for one in entity.structures if isinstance(one, BodyStructure)]
    default = plan.physics.solver_position_iterations or _ITERATIONS
    return min(default if value is None else int(value.data.min()) for value in given)
