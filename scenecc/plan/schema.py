"""The kind of each field of the plan, derived from its dataclasses. The JSON reader and writer and the diff share it.

Tables hold only what type hints cannot express: the content of each `Value` (`scenecc.plan.properties`), and here the
range of each plain number.
"""

from __future__ import annotations

import re
import types
from dataclasses import MISSING, dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any, Literal, NewType, TypeVar, Union, get_args, get_origin, get_type_hints

from scenecc import plan as _plan
from scenecc.diagnostics.diagnostic import Origin
from scenecc.geometry.rotations import Vec3
from scenecc.plan import scene as _physics
from scenecc.plan.expect import MAX_SECONDS
from scenecc.plan.properties import (
    ANY,
    COUNT,
    NON_NEGATIVE,
    POSITION_ITERATIONS,
    POSITIVE,
    QUANTITIES,
    UNIT_INTERVAL,
    VELOCITY_ITERATIONS,
    Bounds,
    Quantity,
)
from scenecc.plan.rendering import LIGHT_CLASSES


@dataclass(frozen=True, slots=True)
class ScalarKind:
    """A flag, number or string that is the same in every scene."""

    type: type[bool | int | float | str]
    bounds: Bounds = ANY


@dataclass(frozen=True, slots=True)
class BytesKind:
    """The content of a file."""


@dataclass(frozen=True, slots=True)
class ChoiceKind:
    """One of several words."""

    options: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class VectorKind:
    """A fixed number of numbers."""

    count: int
    bounds: Bounds = ANY


@dataclass(frozen=True, slots=True)
class SceneSelectionKind:
    """Ascending scene indices."""


@dataclass(frozen=True, slots=True)
class ListKind:
    """Any number of items of one kind."""

    item: FieldKind


@dataclass(frozen=True, slots=True)
class ObjectKind:
    """A dataclass of the plan."""

    cls: type


@dataclass(frozen=True, slots=True)
class UnionKind:
    """One of several dataclasses, distinguished by `type`; `untyped` has no such key."""

    by_type: tuple[tuple[str, type], ...]
    untyped: type | None = None


@dataclass(frozen=True, slots=True)
class SharedDrawsKind:
    """The shared draws, in order."""


@dataclass(frozen=True, slots=True)
class TemplateKind:
    """An expression, with its constants."""


FieldKind = (
    Quantity
    | ScalarKind
    | BytesKind
    | ChoiceKind
    | VectorKind
    | SceneSelectionKind
    | ListKind
    | ObjectKind
    | UnionKind
    | SharedDrawsKind
    | TemplateKind
)


@dataclass(frozen=True, slots=True)
class PlanField:
    """One field of a dataclass.

    Attributes:
        name, kind: its name and kind.
        required: whether it has no default.
        nullable: whether it may be None, which the JSON omits.
        is_omitted_if_empty: whether the JSON omits an empty list or string, or false.
    """

    name: str
    kind: FieldKind
    required: bool
    nullable: bool
    is_omitted_if_empty: bool


PIXEL_BOUNDS = Bounds(1, 16384)

_BOUNDS: dict[str, dict[str, Bounds]] = {
    "ScenePlan": {"num_scenes": Bounds(1), "seed": Bounds(0)},
    "SettledStart": {"seed": Bounds(0)},
    "Physics": {
        **dict.fromkeys(("timestep", "contact_offset", "scene_spacing"), POSITIVE),
        **dict.fromkeys(("bounce_threshold", "sleep_threshold"), NON_NEGATIVE),
        "solver_position_iterations": POSITION_ITERATIONS,
        "solver_velocity_iterations": VELOCITY_ITERATIONS,
        "cpu_workers": Bounds(0, 256),
    },
    "SdfConfig": {"spacing": POSITIVE, "num_threads_for_construction": Bounds(1, 256)},
    "Friction": {"static_friction": NON_NEGATIVE, "dynamic_friction": NON_NEGATIVE, "restitution": UNIT_INTERVAL},
    "Texture": {"mipmap_levels": Bounds(1, 32)},
    "CoacdParams": {"threshold": Bounds(0.01, 1), "max_convex_hull": Bounds(-1, 2**31 - 1)},
    "Camera": {"width": PIXEL_BOUNDS, "height": PIXEL_BOUNDS},
    "Nearness": {"least": NON_NEGATIVE, "most": NON_NEGATIVE},
    "NextTo": {"gap": NON_NEGATIVE},
    "Placement": {"apart": NON_NEGATIVE, "gap": NON_NEGATIVE, "tries": Bounds(1, 10_000)},
    "Settled": {"seconds": Bounds(0, MAX_SECONDS), "within": NON_NEGATIVE, "angle": NON_NEGATIVE},
    "NoOverlap": {"deeper_than": NON_NEGATIVE},
    "Condition": {"after": Bounds(0, MAX_SECONDS)},
}

SCALAR_BOUNDS = {f"{cls}.{field}": bounds for cls, rows in _BOUNDS.items() for field, bounds in rows.items()}
"""Ranges of plain numbers by `Class.field`. Other plain integers are counts (0 to 2³¹ - 1)."""

_Row = TypeVar("_Row")

_WRITTEN_IF_EMPTY = frozenset(
    (
        "ScenePlan.description",
        "ScenePlan.files",
        "ScenePlan.physical_materials",
        "ScenePlan.visual_materials",
        "BodyStructure.collisions",
        "BodyStructure.visuals",
        "Plane.every_scene",
        "TriangleMesh.sdf",
        "ArticulationStructure.fix_root_link",
        "Joint.name",
        "Gear.enable_hinges",
        "Drive.limits",
        "Drive.drives",
    )
)
"""Fields that the JSON always has, although they are empty by default, for compatibility."""

# Stand-ins: a plan without recipes loads neither `variation.nodes` nor `variation.forms`.
_Node, _Template = NewType("_Node", object), NewType("_Template", object)

_KINDS_BY_HINT: dict[Any, FieldKind] = {
    bytes: BytesKind(),
    tuple[int, ...]: SceneSelectionKind(),
    tuple[tuple[str, _Node], ...]: SharedDrawsKind(),
    _Template: TemplateKind(),
}

_TYPE_NAMES = {
    "VisualPlane": "plane",
    "ArticulationStructure": "articulation",
    "AffineClamp": "held",
    **{kind.__name__: kind.__name__.removesuffix("Light").lower() for kind in LIGHT_CLASSES},
}

_CLASSES_WITHOUT_TYPE_KEY: frozenset[type] = frozenset((_plan.BodyStructure,))
"""Classes without a `type` key, for compatibility."""

_TYPE_HINT_NAMES: dict[str, Any] = {
    **{name: getattr(_plan, name) for name in _plan.__all__},
    **vars(_physics),
    "Origin": Origin,
    "Path": Path,
    "State": tuple,
    "Vec3": Vec3,
    "Node": _Node,
    "Template": _Template,
}


@cache
def plan_fields(cls: type) -> tuple[PlanField, ...]:
    """The fields of a plan dataclass that are part of its identity (without origins and file paths)."""
    hints = get_type_hints(cls, localns=_TYPE_HINT_NAMES)
    return tuple(_plan_field(cls, item.name, hints[item.name], item.default) for item in fields(cls) if item.compare)


@cache
def type_name(cls: type) -> str:
    """The name of a geometry, joint or lens in the language: `convex_mesh`."""
    return _TYPE_NAMES.get(cls.__name__) or re.sub(r"(?<=[a-z])(?=[A-Z])", "_", cls.__name__).lower()


def _plan_field(cls: type, name: str, hint: Any, default: Any) -> PlanField:
    members = get_args(hint) if get_origin(hint) in {Union, types.UnionType} else (hint,)
    some = tuple(member for member in members if member is not type(None))
    kind = _union_kind(some) if len(some) > 1 else _field_kind(cls, name, next(iter(some)))
    is_empty = default in ("", ()) or default is False
    return PlanField(
        name,
        kind,
        required=default is MISSING,
        nullable=len(some) < len(members),
        is_omitted_if_empty=is_empty and f"{cls.__name__}.{name}" not in _WRITTEN_IF_EMPTY,
    )


def _union_kind(classes: tuple[type, ...]) -> UnionKind:
    untyped = next((member for member in classes if member in _CLASSES_WITHOUT_TYPE_KEY), None)
    return UnionKind(tuple((type_name(member), member) for member in classes if member is not untyped), untyped)


def _field_kind(cls: type, name: str, hint: Any) -> FieldKind:
    kind: FieldKind
    if hint is _plan.Value:
        kind = _lookup(QUANTITIES, cls, name)
    elif hint in {bool, str, int, float}:
        kind = ScalarKind(hint, _lookup(SCALAR_BOUNDS, cls, name, default=COUNT if hint is int else ANY))
    elif hint in _KINDS_BY_HINT:
        kind = _KINDS_BY_HINT[hint]
    elif get_origin(hint) is Literal:
        kind = ChoiceKind(get_args(hint))
    elif get_origin(hint) is tuple and get_args(hint)[1] is ...:
        kind = ListKind(_field_kind(cls, name, get_args(hint)[0]))
    elif get_origin(hint) is tuple:
        kind = VectorKind(len(get_args(hint)), _lookup(SCALAR_BOUNDS, cls, name, default=ANY))
    elif get_origin(hint) in {Union, types.UnionType}:
        kind = _union_kind(get_args(hint))
    else:
        kind = ObjectKind(hint)
    return kind


def _lookup(table: dict[str, _Row], cls: type, name: str, *, default: _Row | None = None) -> _Row:
    row = table.get(f"{cls.__name__}.{name}", default)
    if row is None:
        raise KeyError(f"{cls.__name__}.{name} is in no table of scenecc.plan.schema")
    return row
