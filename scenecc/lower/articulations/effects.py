"""What is written for an articulation and does nothing to any of the robots that it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut
from scenecc.plan.articulation import ArticulationStructure

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.articulations.draft import Draft
    from scenecc.plan import BodyStructure
    from scenecc.robots.description import DescribedRobot

_OF_SEEN = ("visibility",)
_OF_COLLIDING = ("density", "patch_radius", "min_patch_radius", "collision_group", "disable_self_collisions")
_OF_LINKS = ("fix_root_link", "qpos", "qvel", "beyond_limits", "disable_self_collisions")
"""What a body alone has not."""

_OF_MOVING = (
    "linear_velocity",
    "angular_velocity",
    "gravity",
    "solver_position_iterations",
    "solver_velocity_iterations",
    "sleep_threshold",
)
"""What a body has not that stands still."""

_OF_FREE = ("linear_velocity", "angular_velocity")
_FIXED = "a root that is fixed"
_BODY = "a body: its file has no joints"
_HINTS = {
    (_BODY, "fix_root_link"): "say `fix_root_link: false`; a constraint of `type: weld` fastens the body to the world"
}
_OTHERWISE = {_FIXED: ", or set fix_root_link: false"}


def report_idle(
    entity: Any, structures: Sequence[BodyStructure | ArticulationStructure], origin: Origin, sink: Sink
) -> None:
    """Reports what does something to none of some structures.

    Args:
        entity: as written.
        structures: all that it makes.
        origin: of the entity.
        sink: takes the diagnostics.
    """
    bodies = [body for structure in structures for body in structure.bodies]
    if not any(body.visuals for body in bodies):
        _report(entity, _OF_SEEN, "an articulation without a visible shape", origin, sink)
    untouched = not any(body.collisions for body in bodies)
    if untouched:
        _report(entity, _OF_COLLIDING, "an articulation without a colliding shape", origin, sink)
    if untouched and not any(body.visuals for body in bodies):
        _report(entity, ("material",), "an articulation without a shape", origin, sink)
    linked = [structure for structure in structures if isinstance(structure, ArticulationStructure)]
    if linked and len(linked) == len(structures) and all(structure.fix_root_link for structure in linked):
        _report(entity, _OF_FREE, _FIXED, origin, sink)
    if linked:
        if entity.qpos is None and not any(
            getattr(drive, "target", None) is not None for drive in entity.drives.values()
        ):
            what = "an articulation without `qpos` and targets of drives"
            _report(entity, ("beyond_limits",), what, origin, sink)
        return
    alone = [key for key in _OF_LINKS if not (untouched and key in _OF_COLLIDING)]
    if entity.fix_root_link is False and any(body.body_type == "dynamic" for body in bodies):
        alone.remove("fix_root_link")
    _report(entity, alone, _BODY, origin, sink)
    if not any(body.body_type == "dynamic" for body in bodies):
        _report(entity, _OF_MOVING, "a body that stands still", origin, sink)


def report_free(firsts: Iterable[tuple[DescribedRobot, Draft]], sink: Sink) -> None:
    """Warns of files whose first robot is a body that moves freely, where nothing says whether its root is fixed."""
    for robot, draft in firsts:
        if robot.body_type == "dynamic" and robot.fixed is None:
            message = (
                f"`{cut(draft.links[0].name)}` has no joint: it is a body that moves freely, and no root that is fixed"
            )
            hint = "say `fix_root_link: false` of it; a constraint of `type: weld` fastens it to the world"
            sink.report("SC525", message, draft.origin, hint=hint)


def _report(entity: Any, keys: Iterable[str], what: str, origin: Origin, sink: Sink) -> None:
    for key in keys:
        if getattr(entity, key) is not None:
            hint = _HINTS.get((what, key)) or f"leave `{key}` out" + _OTHERWISE.get(what, "")
            sink.report("SC115", f"`{key}` does nothing on {what}", origin.child(key), at="key", hint=hint)
