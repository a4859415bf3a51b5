"""What a plan says about bodies and shapes beyond their geometry: one row a field, setter beside getter.

The builder writes by these tables and the audit reads by them, so that no field can be set and not be checked.
"""

from __future__ import annotations

from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenecc.backends.sapien.columns import Column, poses, scalars, taken, vectors
from scenecc.backends.sapien.engine import physx, render
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan.properties import properties_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from scenecc.plan import Value

Step = tuple["Callable[[Any, Any], Any]", Column]
"""A setter of the engine, unbound, and its column of values."""


@dataclass(frozen=True, slots=True)
class Knob:
    """One field of the plan in the engine.

    Attributes:
        set: the engine's setter, unbound.
        get: name of the engine's property.
        convert: rows of the plan's data to a column.
        default: what a fresh object of the engine holds whatever its configuration; None: it depends.
    """

    set: Callable[[Any, Any], Any]
    get: str
    convert: Callable[[NDArray[Any]], Column]
    default: Any = None


class Knobs:
    """A table of knobs by the plan's field names; all fields of a holder are read in one call."""

    def __init__(self, knobs: Mapping[str, Knob]) -> None:
        self.by_field = knobs
        self._rows = tuple(knobs.values())
        self._read = attrgetter(*knobs)

    def said(self, holder: object) -> list[tuple[Knob, Value]]:
        """What the plan says of its fields, in the order of the table; most say nothing."""
        values: tuple[Value | None, ...] = self._read(holder)
        if values.count(None) == len(values):
            return []
        return [(knob, value) for knob, value in zip(self._rows, values, strict=True) if value is not None]

    def steps(self, holder: object, rows: NDArray[np.intp]) -> list[Step]:
        """Setters for what the plan says, without those that would set what is there already."""
        return [step for knob, value in self.said(holder) for step in knob_steps(knob, value, rows)]


def knob_steps(knob: Knob, value: Value, rows: NDArray[np.intp]) -> list[Step]:
    """The setter of one knob; none where it would set what is there already."""
    data = taken(value, rows)
    return [] if is_default(data, knob.default) else [(knob.set, knob.convert(data))]


_Shape = physx.PhysxCollisionShape
_Body = physx.PhysxRigidDynamicComponent

SHAPE_POSE = Knob(_Shape.set_local_pose, "local_pose", poses, IDENTITY_POSE)
VISUAL_POSE = Knob(render.RenderShape.set_local_pose, "local_pose", poses, IDENTITY_POSE)
"""`pose` of a shape, colliding or seen."""

GROUPS = Knob(_Shape.set_collision_groups, "collision_groups", scalars, (1, 1, 0, 0))
"""`BodyStructure.collision_groups`, set on every shape of the body."""


def _knobs(component: Any, part: Literal["body", "shape"]) -> Knobs:
    """Rows of the plan's table; the engine's names are the plan's."""
    return Knobs(
        {
            knob.field: Knob(
                getattr(component, f"set_{knob.field}"),
                knob.field,
                vectors if knob.dtype == "float64" and knob.shape else scalars,
                knob.untouched,
            )
            for knob in properties_of(part)
        }
    )


SHAPE_KNOBS = _knobs(_Shape, "shape")
"""Fields of `CollisionShape`, set before the shape is attached (its density cannot be set later)."""

BODY_KNOBS = _knobs(_Body, "body")
"""Fields of `BodyStructure` that a dynamic or kinematic body has, set once its shapes and mass are there."""

_Articulation = physx.PhysxArticulation

ARTICULATION_KNOBS = Knobs(
    {
        field: Knob(getattr(_Articulation, f"set_{field}"), field, scalars)
        for field in ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")
    }
)
"""Fields of `ArticulationStructure` that are the whole's, set once it is in a scene."""

ROOT_KNOBS = Knobs(
    {
        field: Knob(getattr(_Articulation, f"set_root_{field}"), f"root_{field}", vectors, (0.0, 0.0, 0.0))
        for field in ("linear_velocity", "angular_velocity")
    }
)
"""Fields of `ArticulationStructure` that its root has at the start, set before `qpos` and `qvel`."""

RENDER_KNOBS = Knobs(
    {
        "visibility": Knob(lambda body, value: setattr(body, "visibility", value), "visibility", scalars),
        "shading_mode": Knob(lambda body, value: setattr(body, "shading_mode", value), "shading_mode", scalars),
    }
)
"""Fields of `BodyStructure` that the render body has."""


def is_default(data: NDArray[Any], default: object) -> bool:
    """Whether one row is all there is and the engine would hold it anyway, to the bit."""
    if default is None or len(data) != 1:
        return False
    given = data[0].astype(np.float32) if data.dtype == np.float64 else data[0]
    return given.tobytes() == np.asarray(default, dtype=given.dtype).tobytes()
