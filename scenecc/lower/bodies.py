"""Bodies as written to structures of the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.lower.poses import lower_local_pose
from scenecc.lower.shapes import BodyDefaults
from scenecc.plan import BodyStructure, Inertial, constant
from scenecc.spec.body import MOTION_AXES, Body
from scenecc.spec.errors import cut, suggest

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.groups import Bits
    from scenecc.lower.materials import Materials
    from scenecc.lower.shapes import Shapes
    from scenecc.plan import Value

Knob = tuple[str, str, "Callable[[Any], Value]"]

KNOBS: tuple[Knob, ...] = (
    ("mass", "mass", constant),
    ("gravity", "disable_gravity", lambda gravity: constant(not gravity, np.bool_)),
    ("locked_axes", "locked_motion_axes", lambda axes: constant([a in axes for a in MOTION_AXES], np.bool_)),
    ("linear_velocity", "linear_velocity", constant),
    ("angular_velocity", "angular_velocity", constant),
    ("linear_damping", "linear_damping", constant),
    ("angular_damping", "angular_damping", constant),
    ("max_linear_velocity", "max_linear_velocity", constant),
    ("max_angular_velocity", "max_angular_velocity", constant),
    ("max_depenetration_velocity", "max_depenetration_velocity", constant),
    ("max_contact_impulse", "max_contact_impulse", constant),
    ("sleep_threshold", "sleep_threshold", constant),
    ("solver_position_iterations", "solver_position_iterations", lambda n: constant(n, np.int64)),
    ("solver_velocity_iterations", "solver_velocity_iterations", lambda n: constant(n, np.int64)),
    ("collision_bits", "collision_groups", lambda bits: constant(bits, np.int64)),
    ("visibility", "visibility", constant),
    ("shading_mode", "shading_mode", lambda mode: constant(mode, np.int64)),
)
"""Key of the language, field of the plan, and how one becomes the other."""


class Bodies:
    """Lowers the bodies of a document."""

    def __init__(self, shapes: Shapes, materials: Materials, groups: dict[str, Bits], sink: Sink) -> None:
        self._shapes = shapes
        self._materials = materials
        self._groups = groups
        self._sink = sink

    def lower(self, body: Body, origin: Origin) -> BodyStructure:
        """A body's structure; shapes that were reported are missing in it."""
        defaults = BodyDefaults(
            self._materials.surface(body.material, origin.child("material")), body.color, body.density
        )
        collisions: list[Any] = []
        visuals: list[Any] = []
        for i, shape in enumerate(body.shapes):
            place = origin.child("shapes", i)
            collisions.append(self._shapes.collision(shape, defaults, place))
            visuals.append(self._shapes.visual(shape, defaults, place))
        for i, shape in enumerate(body.collisions):
            collisions.append(self._shapes.collision(shape, defaults, origin.child("collisions", i)))
        for i, shape in enumerate(body.visuals):
            visuals.append(self._shapes.visual(shape, defaults, origin.child("visuals", i)))
        return BodyStructure(
            body_type=body.body_type,
            collisions=tuple(filter(None, collisions)),
            visuals=tuple(filter(None, visuals)),
            inertial=self._inertial(body, origin),
            origin=origin,
            **self._knobs(body, origin),
        )

    def _knobs(self, body: Body, origin: Origin) -> dict[str, Value]:
        given = body.model_fields_set
        knobs = {field: make(getattr(body, name)) for name, field, make in KNOBS if name in given}
        if body.collision_group is not None:
            if "collision_bits" in given:
                self._both_groups(origin)
            bits = self._groups.get(body.collision_group)
            if bits is None:
                self._unknown_group(body.collision_group, origin)
            else:
                knobs["collision_groups"] = constant(bits, np.int64)
        return knobs

    def _both_groups(self, origin: Origin) -> None:
        self._sink.report(
            "SC111",
            "`collision_group` and `collision_bits` exclude each other",
            origin.child("collision_bits"),
            at="key",
            related=[("the group", origin.child("collision_group"), "key")],
        )

    def _unknown_group(self, name: str, origin: Origin) -> None:
        hint = suggest(name, self._groups) if self._groups else "name it under `collision_groups`"
        self._sink.report("SC302", f"there is no collision group `{cut(name)}`", origin.child("collision_group"), hint=hint)

    def _inertial(self, body: Body, origin: Origin) -> Inertial | None:
        given = body.inertial
        if given is None:
            return None
        com = lower_local_pose(given.com, origin.child("inertial", "com"), "a centre of mass", self._sink)
        return Inertial(constant(given.mass), constant(com), constant(given.inertia))
