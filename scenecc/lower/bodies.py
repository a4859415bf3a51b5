"""Bodies as written to structures of the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.words import cut, suggest_name
from scenecc.lower.kinds import COLOR, Kind, number, opposite, vector
from scenecc.lower.materials import DENSITY
from scenecc.lower.names import qualified
from scenecc.lower.shape_poses import local_pose
from scenecc.lower.shapes import Defaults
from scenecc.plan import BodyStructure, Inertial, literal
from scenecc.spec.body import MOTION_AXES

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.groups import Bits
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.materials import Materials
    from scenecc.lower.shapes import Shapes
    from scenecc.plan import CollisionShape, Value, VisualShape

Layer = tuple[Any, "Origin"]
"""Keys of a body and the node that has them. Of several layers the last one that has a key counts."""


def _locked(axes: list[str]) -> tuple[bool, ...]:
    return tuple(axis in axes for axis in MOTION_AXES)


KNOBS: dict[str, tuple[str, Kind]] = {
    "mass": ("mass", number("mass")),
    "gravity": ("disable_gravity", Kind(dtype="bool", convert=opposite, fallback=False)),
    "locked_axes": ("locked_motion_axes", Kind((6,), "bool", convert=_locked)),
    "linear_velocity": ("linear_velocity", vector(3, "linear_velocity")),
    "angular_velocity": ("angular_velocity", vector(3, "angular_velocity")),
    "linear_damping": ("linear_damping", number("linear_damping")),
    "angular_damping": ("angular_damping", number("angular_damping")),
    "max_linear_velocity": ("max_linear_velocity", number("max_linear_velocity")),
    "max_angular_velocity": ("max_angular_velocity", number("max_angular_velocity")),
    "max_depenetration_velocity": ("max_depenetration_velocity", number("max_depenetration_velocity")),
    "max_contact_impulse": ("max_contact_impulse", number("max_contact_impulse")),
    "sleep_threshold": ("sleep_threshold", number("sleep_threshold")),
    "solver_position_iterations": (
        "solver_position_iterations",
        number("solver_position_iterations", "int64"),
    ),
    "solver_velocity_iterations": (
        "solver_velocity_iterations",
        number("solver_velocity_iterations", "int64"),
    ),
    "collision_bits": ("collision_groups", vector(4, "collision_groups", "int64")),
    "visibility": ("visibility", number("visibility")),
    "shading_mode": ("shading_mode", number("shading_mode", "int64")),
}
"""Key of the language → field of the plan, and what a row of it holds."""

_KNOB_NAMES = frozenset(KNOBS)

VELOCITIES = frozenset(("linear_velocity", "angular_velocity"))
"""Knobs that a reset draws anew."""

_NO_DEFAULTS = Defaults()
_INERTIA = vector(3, "inertia")


class Bodies:
    """Lowers the bodies of a document."""

    def __init__(self, shapes: Shapes, materials: Materials, groups: dict[str, Bits], sink: Sink) -> None:
        self._shapes = shapes
        self._materials = materials
        self._groups = groups
        self._sink = sink

    def lower(self, body: Any, origin: Origin, leaves: Leaves) -> BodyStructure:
        """A body's structure; shapes that were reported are missing in it."""
        self._does_something(body, body, origin)
        return self._structure(body.body_type, ((body, origin),), leaves)

    def variant(self, common: Layer, own: Layer, leaves: Leaves) -> BodyStructure:
        """The structure of one variant: lists of shapes go on where the common ones end, other keys replace them."""
        self._does_something(own[0], common[0], own[1])
        typed = next((body for body, _ in (own, common) if "body_type" in body.model_fields_set), common[0])
        return self._structure(typed.body_type, (common, own), leaves)

    def _structure(self, body_type: Any, layers: tuple[Layer, ...], leaves: Leaves) -> BodyStructure:
        default = self._defaults(layers, leaves)
        collisions: list[CollisionShape] = []
        visuals: list[VisualShape] = []
        for body, origin in layers:
            for i, shape in enumerate(body.shapes):
                collides, seen = self._shapes.both(shape, default, leaves, origin.child("shapes", i))
                if collides is not None:
                    collisions.append(collides)
                if seen is not None:
                    visuals.append(seen)
        for body, origin in layers:
            for i, shape in enumerate(body.collisions):
                collides = self._shapes.collision(shape, default, leaves, origin.child("collisions", i))
                if collides is not None:
                    collisions.append(collides)
        for body, origin in layers:
            for i, shape in enumerate(body.visuals):
                seen = self._shapes.visual(shape, default, leaves, origin.child("visuals", i))
                if seen is not None:
                    visuals.append(seen)
        knobs: dict[str, Value] = {}
        for body, origin in layers:
            self._knobs(body, origin, leaves, knobs)
        return BodyStructure(
            body_type=body_type,
            collisions=tuple(collisions),
            visuals=tuple(visuals),
            inertial=self._inertial(layers, leaves),
            origin=layers[-1][1],
            **knobs,
        )

    def _does_something(self, body: Any, common: Any, origin: Origin) -> None:
        if body.color is not None and not (body.shapes or body.visuals or common.shapes or common.visuals):
            self._nothing("color", "visible", origin)
        if body.density is not None and not (body.shapes or body.collisions or common.shapes or common.collisions):
            self._nothing("density", "colliding", origin)
        if body.collision_group is not None and not (
            body.shapes or body.collisions or common.shapes or common.collisions
        ):
            self._nothing("collision_group", "colliding", origin)

    def _defaults(self, layers: tuple[Layer, ...], leaves: Leaves) -> Defaults:
        found = _NO_DEFAULTS
        for body, origin in layers:
            if body.material is None and body.color is None and body.density is None:
                continue
            surface = self._materials.surface(body.material, origin, leaves)
            color = leaves.given(body.color, COLOR, origin, "color")
            density = leaves.given(body.density, DENSITY, origin, "density")
            found = Defaults(
                found.surface if surface is None else surface,
                found.color if color is None else color,
                found.density if density is None else density,
            )
        return found

    def _knobs(self, body: Any, origin: Origin, leaves: Leaves, knobs: dict[str, Value]) -> None:
        given = body.model_fields_set
        for name in _KNOB_NAMES & given:
            field, kind = KNOBS[name]
            knobs[field] = leaves.value(getattr(body, name), kind, origin, name, reset=name in VELOCITIES)
        if body.collision_group is None:
            return
        if "collision_bits" in given:
            self._both_groups(origin)
        bits = self._groups.get(qualified(body.collision_group, leaves.scope))
        if bits is None:
            self._unknown_group(body.collision_group, origin, leaves)
        else:
            knobs["collision_groups"] = literal(bits, "int64")

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

    def _unknown_group(self, name: str, origin: Origin, leaves: Leaves) -> None:
        prefix = qualified("", leaves.scope)
        known = [group[len(prefix) :] for group in self._groups if group.startswith(prefix)]
        hint = suggest_name(name, known, self._sink) if known else "name it under `collision_groups`"
        self._sink.report(
            "SC302", f"there is no collision group `{cut(name)}`", origin.child("collision_group"), hint=hint
        )

    def _inertial(self, layers: tuple[Layer, ...], leaves: Leaves) -> Inertial | None:
        for body, origin in reversed(layers):
            given = body.inertial
            if given is None:
                continue
            place = origin.child("inertial")
            return Inertial(
                leaves.value(given.mass, KNOBS["mass"][1], place, "mass"),
                local_pose(given.com, origin, ("inertial", "com"), "a centre of mass", leaves),
                leaves.value(given.inertia, _INERTIA, place, "inertia"),
            )
        return None
