"""The fields of an object that differ between its scenes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

from scenecc.plan.display import (
    format_color,
    format_item,
    format_value_bounds,
    is_any_rotation,
    join_alternatives,
    slice_value_bounds,
)
from scenecc.plan.properties import Quantity
from scenecc.plan.walk import walk_fields
from scenecc.variation.bounds import ValueBounds, union_bounds
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from scenecc.plan import Constraint, Entity, ScenePlan, Value
    from scenecc.plan.body import AssetFile
    from scenecc.plan.rendering import Camera, Environment, Light


@dataclass(frozen=True, slots=True)
class VaryingField:
    """A field whose value is not the same in all scenes of an object.

    Attributes:
        field: as in the scene file: `pose.p`, `shapes[0].half_size`.
        values: its possible values as text: `0.1 | 0.5`, `0.1 … 0.5`.
        at_reset: whether a reset redraws it.
    """

    field: str
    values: str
    at_reset: bool


@dataclass(frozen=True, slots=True)
class Fields:
    """The fields of an object.

    Attributes:
        count: number of fields with a value; a pose counts as two.
        varying: those that differ, in the order of the plan.
    """

    count: int
    varying: tuple[VaryingField, ...]


@dataclass(frozen=True, slots=True)
class _Found:
    """A value of the plan under its name in scene files."""

    label: str
    bounds: ValueBounds
    varies: bool
    at_reset: bool = False


def _shown_bounds(value: Value) -> ValueBounds:
    """Returns the bounds to show for a value: those of its samples, or of its drawn rows, if it has no finite ones."""
    found = value.bounds
    if found.alternatives is not None or not value.may_vary or _is_finite(found.low, found.high):
        return found
    try:
        return ValueBounds.of_samples(value.samples)
    except DrawError:  # the pose of a placed entity, which has no samples
        return ValueBounds.of_samples(value.data)


def varying_words(name: str, value: Value, files: Sequence[AssetFile], unit: str = "") -> str:
    """Returns the possible values of a field as text. `name`: of the field in scene files."""
    support = _shown_bounds(value)
    words = _words(name, support, files)
    each = " each" if words.endswith(" each") else ""
    return f"{_bounds_prefix(support)}{words.removesuffix(each)} {unit}".rstrip() + each


def pose_words(value: Value) -> tuple[str, str]:
    """Returns the possible positions [m] and rotations (wxyz) of a pose as text."""
    support = _shown_bounds(value)
    if support.low is None:
        return ("by an expression", "by an expression")
    about = _bounds_prefix(support)
    p, q = slice_value_bounds(support, 0, 3), slice_value_bounds(support, 3, 7)
    return f"{about}{format_value_bounds(p)} m", _rotation(q, about)


def _is_finite(*bounds: Any) -> bool:
    return all(
        _is_finite(*bound) if isinstance(bound, tuple) else bound is not None and math.isfinite(bound)
        for bound in bounds
    )


COLOR_FIELDS: Final = frozenset({"base_color", "emission"})
_FILES: Final = frozenset({"file", "px", "nx", "py", "ny", "pz", "nz"})


def entity_fields(entity: Entity, plan: ScenePlan) -> Fields:
    """Returns the fields of an entity, and which of them vary. Equal fields of its structures count once."""
    return _fields((replace(entity, structures=()), *entity.structures), plan)


def object_fields(one: Constraint | Light | Camera | Environment, plan: ScenePlan) -> Fields:
    """Returns the fields of another object, and which of them vary."""
    return _fields((one,), plan)


def _fields(nodes: Iterable[Any], plan: ScenePlan) -> Fields:
    found: dict[str, list[_Found]] = {}
    for item in chain.from_iterable(_values(node, plan) for node in nodes):
        found.setdefault(item.label, []).append(item)
    varying: list[VaryingField] = []
    for label, items in found.items():
        if any(item.varies for item in items):
            varying += _list_differing(label, items, plan)
    return Fields(sum(2 if is_pose(label) else 1 for label in found), tuple(varying))


def is_file(name: str) -> bool:
    """Returns whether a field is an index of a file."""
    return name in _FILES or name.endswith("texture")


def is_pose(label: str) -> bool:
    """Returns whether a field is shown as position and rotation."""
    last = label.rsplit(".", 1)[-1]
    return last in {"pose", "pose_in_parent", "pose_in_child", "target"} or label.endswith("inertial.com")


def _values(node: Any, plan: ScenePlan) -> Iterator[_Found]:
    for path, kind, value in walk_fields(node):
        if not isinstance(kind, Quantity):
            continue
        if kind.table is None or kind.table == "files":
            yield _Found(_label(path), _shown_bounds(value), value.may_vary, value.recipe is not None)
        else:
            table: Sequence[Any] = getattr(plan, kind.table)
            yield from _material(path, [table[int(index)] for index in value.bounds.alternatives or ()])


def _label(path: str) -> str:
    """Returns the label of a field; a texture gets that of its file, since nothing else of it can differ."""
    return path.removesuffix(".file") if path.endswith("texture.file") else path


def _material(where: str, materials: list[Any]) -> Iterator[_Found]:
    """Yields each field of the materials that a shape may have, over all of them."""
    rows = [
        {_label(path): value for path, kind, value in walk_fields(material, where) if isinstance(kind, Quantity)}
        for material in materials
    ]
    for label in dict.fromkeys(chain.from_iterable(rows)):
        given = [row[label] for row in rows if label in row]
        support = union_bounds(map(_shown_bounds, given))
        one = support.alternatives is not None and len(support.alternatives) == 1
        yield _Found(
            label,
            support,
            varies=len(given) < len(rows) or not one,
            at_reset=any(value.recipe is not None for value in given),
        )


def _list_differing(label: str, items: list[_Found], plan: ScenePlan) -> Iterator[VaryingField]:
    support = union_bounds(item.bounds for item in items)
    at_reset = any(item.at_reset for item in items)
    about = _bounds_prefix(support)
    if is_pose(label) and support.low is not None:
        p, q = slice_value_bounds(support, 0, 3), slice_value_bounds(support, 3, 7)
        if p.low != p.high:
            yield VaryingField(f"{label}.p", about + format_value_bounds(p), at_reset)
        if q.low != q.high:
            yield VaryingField(f"{label}.q", _rotation(q, about), at_reset)
        return
    name = label.rsplit(".", 1)[-1]
    yield VaryingField(label, about + _words(name, support, plan.files), at_reset)


def _bounds_prefix(support: ValueBounds) -> str:
    """Returns the word before the bounds of samples."""
    return "" if support.exact or support.alternatives is not None else "about "


def _rotation(q: ValueBounds, about: str) -> str:
    return "any rotation" if is_any_rotation(q) else about + format_value_bounds(q)


def _words(name: str, support: ValueBounds, files: Sequence[AssetFile]) -> str:
    show: Callable[[Any], str] | None = None
    if is_file(name):
        show = lambda index: files[int(index)].uri  # noqa: E731
    elif name == "gravity":
        show = lambda disabled: format_item(not disabled)  # noqa: E731
    elif name in COLOR_FIELDS:
        show = format_color
    if show is None or support.alternatives is None:
        return format_value_bounds(support)
    return join_alternatives([show(item) for item in support.alternatives]) or f"{len(support.alternatives)} values"
