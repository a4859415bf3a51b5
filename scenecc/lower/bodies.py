"""Bodies as written to structures of the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.words import cut, suggest_name
from scenecc.lower.materials import PLAIN
from scenecc.lower.poses import lower_local_pose
from scenecc.plan import BodyStructure, Inertial, literal
from scenecc.spec.body import MOTION_AXES, Body

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.groups import Bits
    from scenecc.lower.materials import Materials
    from scenecc.lower.shapes import Shapes
    from scenecc.plan import CollisionShape, Value, VisualShape

Knob = tuple[str, "Callable[[Any], Value]"]

KNOBS: dict[str, Knob] = {
    "mass": ("mass", literal),
    "gravity": ("disable_gravity", lambda gravity: literal(not gravity, "bool")),
    "locked_axes": ("locked_motion_axes", lambda axes: literal(tuple(a in axes for a in MOTION_AXES), "bool")),
    "linear_velocity": ("linear_velocity", literal),
    "angular_velocity": ("angular_velocity", literal),
    "linear_damping": ("linear_damping", literal),
    "angular_damping": ("angular_damping", literal),
    "max_linear_velocity": ("max_linear_velocity", literal),
    "max_angular_velocity": ("max_angular_velocity", literal),
    "max_depenetration_velocity": ("max_depenetration_velocity", literal),
    "max_contact_impulse": ("max_contact_impulse", literal),
    "sleep_threshold": ("sleep_threshold", literal),
    "solver_position_iterations": ("solver_position_iterations", lambda n: literal(n, "int64")),
    "solver_velocity_iterations": ("solver_velocity_iterations", lambda n: literal(n, "int64")),
    "collision_bits": ("collision_groups", lambda bits: literal(bits, "int64")),
    "visibility": ("visibility", literal),
    "shading_mode": ("shading_mode", lambda mode: literal(mode, "int64")),
}
"""Key of the language → field of the plan, and how one's value becomes the other's."""

_KNOB_NAMES = frozenset(KNOBS)


class Bodies:
    """Lowers the bodies of a document."""

    def __init__(self, shapes: Shapes, materials: Materials, groups: dict[str, Bits], sink: Sink) -> None:
        self._shapes = shapes
        self._materials = materials
        self._groups = groups
        self._sink = sink

    def lower(self, body: Body, origin: Origin) -> BodyStructure:
        """A body's structure; shapes that were reported are missing in it."""
        default = self._materials.surface(body.material, origin) or PLAIN
        if body.color is not None and not (body.shapes or body.visuals):
            self._nothing("color", "visible", origin)
        if body.density is not None and not (body.shapes or body.collisions):
            self._nothing("density", "colliding", origin)
        collisions: list[CollisionShape] = []
        visuals: list[VisualShape] = []
        for i, shape in enumerate(body.shapes):
            collides, seen = self._shapes.both(shape, body, default, origin.child("shapes", i))
            if collides is not None:
                collisions.append(collides)
            if seen is not None:
                visuals.append(seen)
        for i, shape in enumerate(body.collisions):
            if (collides := self._shapes.collision(shape, body, default, origin.child("collisions", i))) is not None:
                collisions.append(collides)
        for i, shape in enumerate(body.visuals):
            if (seen := self._shapes.visual(shape, body, default, origin.child("visuals", i))) is not None:
                visuals.append(seen)
        return BodyStructure(
            body_type=body.body_type,
            collisions=tuple(collisions),
            visuals=tuple(visuals),
            inertial=self._inertial(body, origin),
            origin=origin,
            **self._knobs(body, origin),
        )

    def _knobs(self, body: Body, origin: Origin) -> dict[str, Value]:
        given = body.model_fields_set
        knobs: dict[str, Value] = {}
        for name in _KNOB_NAMES & given:
            field, make = KNOBS[name]
            knobs[field] = make(getattr(body, name))
        if body.collision_group is not None:
            if "collision_bits" in given:
                self._both_groups(origin)
            bits = self._groups.get(body.collision_group)
            if not (body.shapes or body.collisions):
                self._nothing("collision_group", "colliding", origin)
            elif bits is None:
                self._unknown_group(body.collision_group, origin)
            else:
                knobs["collision_groups"] = literal(bits, "int64")
        return knobs

    def _both_groups(self, origin: Origin) -> None:
        self._sink.report(
            "SC111",
            "`collision_group` and `collision_bits` exclude each other",
            origin.child("collision_bits"),
            at="key",
            related=[("the group", origin.child("collision_group"), "key")],
        )

    def _nothing(self, key: str, missing: str, origin: Origin) -> None:
        self._sink.report(
            "SC115",
            f"`{key}` does nothing on a body without a {missing} shape",
            origin.child(key),
            at="key",
            hint=f"leave `{key}` out",
        )

    def _unknown_group(self, name: str, origin: Origin) -> None:
        hint = suggest_name(name, self._groups, self._sink) if self._groups else "name it under `collision_groups`"
        self._sink.report(
            "SC302", f"there is no collision group `{cut(name)}`", origin.child("collision_group"), hint=hint
        )

    def _inertial(self, body: Body, origin: Origin) -> Inertial | None:
        given = body.inertial
        if given is None:
            return None
        com = lower_local_pose(given.com, origin, ("inertial", "com"), "a centre of mass", self._sink)
        return Inertial(literal(given.mass), literal(com), literal(given.inertia))
