"""Properties of engine objects, one row per field: setter, getter, conversion, and the value of a fresh object.

The builders write by these tables, and `tests/fidelity/test_setters.py` compares each row with SAPIEN. Values of the
plan become columns: lists with one item, or one item per row that is built. Vectors become float32 arrays, which SAPIEN
reads faster than lists.
"""

from __future__ import annotations

from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np

from scenecc.backends.sapien.engine import physx, render, sapien
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan.properties import properties_of, property_fields

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.plan import Entity, Value


Column = list[Any]

Item = TypeVar("Item")


def row_item(column: Sequence[Item], row: int) -> Item:
    """Returns the item of a row."""
    return column[row if len(column) != 1 else 0]


def rows_in_scenes(entity: Entity, scene_idxs: tuple[int, ...]) -> tuple[tuple[int, ...], NDArray[np.intp]]:
    """Returns the scenes that have the entity, and their rows in the plan's values."""
    if entity.scene_idxs == scene_idxs:
        return scene_idxs, np.arange(len(scene_idxs))
    row_of = {index: row for row, index in enumerate(entity.scene_idxs)}
    present = tuple(index for index in scene_idxs if index in row_of)
    return present, np.array([row_of[index] for index in present], dtype=np.intp)


def select_rows(value: Value, rows: NDArray[np.intp]) -> NDArray[Any]:
    """Returns the given rows of a value, or one row if it is the same in every scene."""
    return value.data if value.data.shape[0] == 1 else value.data[rows]


def to_scalars(data: NDArray[Any]) -> Column:
    """Converts to Python floats, integers or booleans, or lists of them."""
    return data.tolist()


def to_vectors(data: NDArray[Any]) -> Column:
    """Converts to float32 arrays."""
    return list(data.astype(np.float32))


def to_poses(data: NDArray[Any]) -> Column:
    """Converts to `sapien.Pose` objects. Quaternions stay as they are: normalising them again would change bits."""
    return list(map(sapien.Pose, *split_poses(data)))


def split_poses(data: NDArray[Any]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Splits poses (B, 7) into contiguous (B, 3) and (B, 4), whose rows SAPIEN reads faster than slices."""
    rows = data.astype(np.float32, copy=False)
    return np.ascontiguousarray(rows[:, :3]), np.ascontiguousarray(rows[:, 3:])


def size_column(value: Value, rows: NDArray[np.intp]) -> Column:
    """Returns Python numbers or vectors for each row. A single row gives the plan's own value, which is faster."""
    if value.varies:
        data = value.data[rows]
        return to_vectors(data) if data.ndim > 1 else to_scalars(data)
    first, *others = numbers = value.as_drawn()
    if not others:
        return [first]
    return [numbers] if len(rows) == 1 else to_vectors(value.data)


def zip_columns(columns: Sequence[Column]) -> list[tuple[Any, ...]]:
    """Returns the argument tuples of a call: one for each row, or one for all if no column varies."""
    length = max([len(column) for column in columns])
    if length == 1:
        return [tuple([column[0] for column in columns])]
    return list(zip(*[column if len(column) == length else column * length for column in columns], strict=True))


def bind_columns(function: Callable[..., Any], columns: Sequence[Column]) -> Callable[[int], Any]:
    """Returns `function` with its arguments bound, to be called with a row."""
    arguments = zip_columns(columns)
    if len(arguments) == 1:
        only = arguments[0]
        return lambda _: function(*only)
    return lambda row: function(*arguments[row])


SetterColumn = tuple["Callable[[Any, Any], Any]", Column]
"""An unbound setter of the engine, and its column of values."""


@dataclass(frozen=True, slots=True)
class EngineProperty:
    """One field of the plan in the engine.

    Attributes:
        set: the engine's setter, unbound.
        get: name of the engine's property, from which saved states and measurements read it.
        convert: converts rows of the plan's data to a column.
        default: value of any fresh engine object. None: it depends on the configuration.
    """

    set: Callable[[Any, Any], Any]
    get: str
    convert: Callable[[NDArray[Any]], Column]
    default: Any = None

    def column(self, value: Value | None, rows: NDArray[np.intp]) -> Column:
        """Returns the values of some rows, or the default if the plan sets none."""
        return self.convert(np.array([self.default], np.float64) if value is None else select_rows(value, rows))


class PropertyTable:
    """Properties by the plan's field names. All fields of a holder are read in one call."""

    def __init__(self, properties: Mapping[str, EngineProperty]) -> None:
        self.by_field = properties
        self._rows = tuple(properties.values())
        self._read = attrgetter(*properties)

    def list_specified(self, holder: object) -> list[tuple[EngineProperty, Value]]:
        """Returns the fields that the plan sets, in the order of the table."""
        values: tuple[Value | None, ...] = self._read(holder)
        if values.count(None) == len(values):
            return []
        return [(prop, value) for prop, value in zip(self._rows, values, strict=True) if value is not None]

    def steps(self, holder: object, rows: NDArray[np.intp]) -> list[SetterColumn]:
        """Returns setters for what the plan sets, except values that the engine's object already has."""
        return [step for prop, value in self.list_specified(holder) for step in property_setters(prop, value, rows)]


def property_setters(prop: EngineProperty, value: Value, rows: NDArray[np.intp]) -> list[SetterColumn]:
    """Returns the setter of a property and its values; empty if the engine's object already has this value."""
    data = select_rows(value, rows)
    return [] if is_default(data, prop.default) else [(prop.set, prop.convert(data))]


_CollisionShapeClass = physx.PhysxCollisionShape

_BodyClass = physx.PhysxRigidDynamicComponent

SHAPE_POSE = EngineProperty(_CollisionShapeClass.set_local_pose, "local_pose", to_poses, IDENTITY_POSE)

VISUAL_POSE = EngineProperty(render.RenderShape.set_local_pose, "local_pose", to_poses, IDENTITY_POSE)
"""`pose` of a collision or visual shape."""

COLLISION_GROUPS = EngineProperty(
    _CollisionShapeClass.set_collision_groups, "collision_groups", to_scalars, (1, 1, 0, 0)
)
"""`collision_groups` of a shape or of its body."""


def _plan_properties(component: Any, part: Literal["body", "shape"]) -> PropertyTable:
    """Makes a table from rows of the plan's table. The engine uses the same names."""
    return PropertyTable(
        {
            prop.field: EngineProperty(
                getattr(component, f"set_{prop.field}"),
                prop.field,
                to_vectors if prop.dtype == "float64" and prop.shape else to_scalars,
                prop.untouched,
            )
            for prop in properties_of(part)
        }
    )


def set_center_of_mass(body: Any, position: Any) -> None:
    """Moves the centre of mass of a rigid body. Mass, principal moments and their axes stay."""
    body.set_cmass_local_pose(sapien.Pose(position, body.get_cmass_local_pose().q))


SHAPE_PROPERTIES = _plan_properties(_CollisionShapeClass, "shape")
"""Fields of `CollisionShape`. Set before the shape is attached, because its density cannot be set later."""

BODY_PROPERTIES = _plan_properties(_BodyClass, "body")
"""Fields of `BodyStructure` for a dynamic or kinematic body. Set once it has its shapes and mass."""

_ArticulationClass = physx.PhysxArticulation

ARTICULATION_PROPERTIES = PropertyTable(
    {
        field: EngineProperty(getattr(_ArticulationClass, f"set_{field}"), field, to_scalars)
        for field in ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")
    }
)
"""Fields of `ArticulationStructure` for the whole articulation. Set once it is in a scene."""

ROOT_PROPERTIES = PropertyTable(
    {
        field: EngineProperty(
            getattr(_ArticulationClass, f"set_root_{field}"), f"root_{field}", to_vectors, (0.0, 0.0, 0.0)
        )
        for field in ("linear_velocity", "angular_velocity")
    }
)
"""Fields of `ArticulationStructure` for the initial state of its root. Set before `qpos` and `qvel`."""

RENDER_PROPERTIES = PropertyTable(
    {
        "visibility": EngineProperty(lambda body, value: setattr(body, "visibility", value), "visibility", to_scalars),
        "shading_mode": EngineProperty(
            lambda body, value: setattr(body, "shading_mode", value), "shading_mode", to_scalars
        ),
    }
)
"""Fields of `BodyStructure` for the render body."""


def is_default(data: NDArray[Any], default: object) -> bool:
    """Returns whether the data is one row that is bit-identical to the engine's default."""
    if default is None or len(data) != 1:
        return False
    given = data[0].astype(np.float32) if data.dtype == np.float64 else data[0]
    return given.tobytes() == np.asarray(default, dtype=given.dtype).tobytes()


_JointClass = physx.PhysxArticulationJoint

DRIVE_DEFAULTS = {row.field: row.untouched for row in properties_of("drive")}
"""Fields of `Joint` that one setter takes, in its order before the mode, with their defaults."""


def _to_axis_arrays(data: NDArray[Any]) -> Column:
    """Converts to float32 arrays (1,) or (1, 2), SAPIEN's format for values of a joint's degrees of freedom."""
    return list(data.astype(np.float32)[:, None])


JOINT_FRAMES = {
    "pose_in_child": EngineProperty(_JointClass.set_pose_in_child, "pose_in_child", to_poses, IDENTITY_POSE),
    "pose_in_parent": EngineProperty(_JointClass.set_pose_in_parent, "pose_in_parent", to_poses, IDENTITY_POSE),
}
"""Frames of `Joint`, in the order in which SAPIEN's builder sets them. Always set."""

JOINT_LIMITS = EngineProperty(_JointClass.set_limits, "limits", _to_axis_arrays, (-np.inf, np.inf))
"""Set on every active joint: SAPIEN's builder sets these defaults, and a fresh joint cannot move."""

JOINT_PROPERTIES = PropertyTable(
    {
        field: EngineProperty(
            getattr(_JointClass, f"set_{field}"), field, _to_axis_arrays if field == "armature" else to_scalars
        )
        for field in (*property_fields("joint"), "drive_target", "drive_velocity_target")
    }
)
"""Fields of `Joint` that a user sets after SAPIEN's builder, in the order in which they are set."""

LINK_CLASS = physx.PhysxArticulationLinkComponent

LINK_FIELDS = tuple(field for field in BODY_PROPERTIES.by_field if hasattr(LINK_CLASS, f"set_{field}"))
"""Fields of `BodyStructure` that SAPIEN's links share with dynamic bodies. Links lack the others."""

FixedSetters = tuple[tuple["Callable[[Any, Any], Any]", Any], ...]

PreparedSetters = tuple[FixedSetters, tuple[SetterColumn, ...]]
"""Setters with one value for all rows, and setters with a value for each row."""


def apply_setters(prepared: PreparedSetters, obj: Any, row: int) -> None:
    """Calls the setters on an engine object with the values of a row."""
    fixed, varying = prepared
    for setter, value in fixed:
        setter(obj, value)
    for setter, values in varying:
        setter(obj, values[row])


def split_setters(found: Sequence[SetterColumn]) -> PreparedSetters:
    """Splits setters into those with one value for all rows and those with a value for each row."""
    if not found:
        return (), ()
    fixed = tuple((setter, column[0]) for setter, column in found if len(column) == 1)
    return fixed, tuple((setter, column) for setter, column in found if len(column) != 1)
