"""Keys of articulations that have no effect (SC115)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from scenecc.lower.field_types import report_unused_key
from scenecc.plan.articulation import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import BodyStructure

_VISIBLE_KEYS = ("visibility",)
_COLLIDING_KEYS = ("density", "patch_radius", "min_patch_radius", "collision_group", "disable_self_collisions")
_LINKED_KEYS = ("fix_root_link", "qpos", "qvel", "beyond_limits", "disable_self_collisions")
"""Keys that a single body does not have."""

_FREE_ROOT_KEYS = ("linear_velocity", "angular_velocity")
_FIXED = "a root that is fixed"
_BODY = "a body: its file has no joints"
_HINTS = {
    (_BODY, "fix_root_link"): "write `fix_root_link: false`; a constraint of `type: weld` fastens the body to the world"
}
_HINT_ENDS = {_FIXED: ", or set `fix_root_link: false`"}

_MOVING_KEYS = (
    "linear_velocity",
    "angular_velocity",
    "gravity",
    "solver_position_iterations",
    "solver_velocity_iterations",
    "sleep_threshold",
)
"""Keys that a static body does not have."""

_JOINTED = "its joints never move"
_STILL = "no force moves it"
_UNUSED: dict[str, str] = {
    **dict.fromkeys(("qvel", "drives"), _JOINTED),
    **dict.fromkeys(("fix_root_link", *_MOVING_KEYS), _STILL),
    **dict.fromkeys(
        ("disable_self_collisions", "sapien_bits"), "it is one body, whose shapes never collide with one another"
    ),
    "attach": "it is one body, but parts are links of an articulation",
}
"""Keys of an articulation → why they have no effect if it is one body."""

_USED_LINK_KEYS = frozenset(
    ("material", "density", "patch_radius", "min_patch_radius", "collision_group", "collision_bits", "visibility")
)
_USED_JOINT_KEYS = frozenset(("limits", "limits_deg"))
"""Keys of links and joints by pattern that have an effect: joint limits bound `qpos`."""


def report_unused_keys(
    entity: Any, structures: Sequence[BodyStructure | ArticulationStructure], origin: Origin, sink: Sink
) -> None:
    """Reports keys that have no effect on any of the structures.

    Args:
        entity: as written.
        structures: of the entity.
        origin: of the entity.
        sink: receives the diagnostics.
    """
    if entity.body_type is not None:
        _report_unused_of_body(entity, origin, sink)
    bodies = [body for structure in structures for body in structure.bodies]
    if not any(body.visuals for body in bodies):
        _report_unused(entity, _VISIBLE_KEYS, "an articulation without a visible shape", origin, sink)
    untouched = not any(body.collisions for body in bodies)
    if untouched:
        _report_unused(entity, _COLLIDING_KEYS, "an articulation without a collision shape", origin, sink)
    if untouched and not any(body.visuals for body in bodies):
        _report_unused(entity, ("material",), "an articulation without a shape", origin, sink)
    if entity.body_type is not None:
        return
    linked = [structure for structure in structures if isinstance(structure, ArticulationStructure)]
    if linked and len(linked) == len(structures) and all(structure.fix_root_link for structure in linked):
        _report_unused(entity, _FREE_ROOT_KEYS, _FIXED, origin, sink)
    if linked:
        if entity.qpos is None and not any(
            getattr(drive, "target", None) is not None for drive in entity.drives.values()
        ):
            what = "an articulation without `qpos` and targets of drives"
            _report_unused(entity, ("beyond_limits",), what, origin, sink)
        return
    alone = [key for key in _LINKED_KEYS if not (untouched and key in _COLLIDING_KEYS)]
    if entity.fix_root_link is False and any(body.body_type == "dynamic" for body in bodies):
        alone.remove("fix_root_link")
    _report_unused(entity, alone, _BODY, origin, sink)
    if not any(body.body_type == "dynamic" for body in bodies):
        _report_unused(entity, _MOVING_KEYS, "a body that cannot move", origin, sink)


def _report_unused(entity: Any, keys: Iterable[str], what: str, origin: Origin, sink: Sink) -> None:
    for key in keys:
        if getattr(entity, key) is not None:
            hint = _HINTS.get((what, key)) or f"leave `{key}` out" + _HINT_ENDS.get(what, "")
            report_unused_key(key, f"on {what}", origin, sink, hint=hint)


def _report_unused_of_body(entity: Any, origin: Origin, sink: Sink) -> None:
    """Reports keys that have no effect on an articulation with `body_type` (SC115)."""
    for key, what in _UNUSED.items():
        value = getattr(entity, key)
        if value is not None and value != {}:
            _report_of_body(key, entity.body_type, what, origin, sink)
    for section, used in (("links", _USED_LINK_KEYS), ("joints", _USED_JOINT_KEYS)):
        what = _STILL if section == "links" else _JOINTED
        for pattern, keys in getattr(entity, section).items():
            for key in sorted(keys.model_fields_set - used):
                _report_of_body(key, entity.body_type, what, origin.child(section, pattern), sink)


def _report_of_body(key: str, body_type: str, what: str, origin: Origin, sink: Sink) -> None:
    message = f"`{key}` has no effect with `body_type: {body_type}`: {what}"
    hint = f"remove `{key}`, or remove `body_type` for an articulation that moves"
    sink.report("SC115", message, origin.child(key), at="key", hint=hint)
