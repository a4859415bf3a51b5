"""The fields of an object that differ between its scenes."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, is_dataclass
from typing import TYPE_CHECKING, Any, Final, cast

from scenecc.plan import ArticulationStructure, AxisDrive, AxisLimit, Value
from scenecc.plan.body import AssetFile, PhysicalMaterial, Texture, VisualMaterial
from scenecc.plan.display import (
    SPEC_FIELD_NAMES,
    field_path,
    format_color,
    format_item,
    format_value_bounds,
    is_any_rotation,
    join_alternatives,
    link_shape_path,
    name_suffix,
    shape_path,
    slice_value_bounds,
)
from scenecc.variation.bounds import ValueBounds, union_bounds

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from scenecc.plan import BodyStructure, Constraint, Entity, ScenePlan
    from scenecc.plan.rendering import Camera, Environment, Light


@dataclass(frozen=True, slots=True)
class VaryingField:
    """A field whose value is not the same in all scenes of an object.

    Attributes:
        field: as in the scene file: `pose.p`, `shapes[0].half_size`.
        values: its possible values in words: `0.1 | 0.5`, `0.1 … 0.5`.
        at_reset: whether a reset draws it again.
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
    """A value of the plan under the name that a scene file has for it.

    `drawn`: what it is in the scenes at hand, where less is known of all that it can be.
    """

    label: str
    bounds: ValueBounds
    varies: bool
    at_reset: bool = False
    drawn: bool = False


def _found(label: str, value: Value) -> _Found:
    support, drawn = _shown_bounds(value)
    return _Found(label, support, value.may_vary, value.recipe is not None, drawn)


def _shown_bounds(value: Value) -> tuple[ValueBounds, bool]:
    """The bounds to show for a value, and whether they are those of its drawn data: if nothing else bounds it."""
    support = value.bounds
    if support.alternatives is not None or not value.may_vary or _is_finite(support.low, support.high):
        return support, False
    return ValueBounds.of_rows(value.data), True


def varying_words(name: str, value: Value, files: Sequence[AssetFile], unit: str = "") -> str:
    """The possible values of a field, for people. `name`: of the field in scene files."""
    support, drawn = _shown_bounds(value)
    start, end = ("", ", as drawn") if drawn else _around(support)
    words = _words(name, support, files)
    each = " each" if words.endswith(" each") else ""
    return f"{start}{words.removesuffix(each)} {unit}".rstrip() + each + end


def pose_words(value: Value) -> tuple[str, str]:
    """The possible positions [m] and rotations (wxyz) of a pose, likewise."""
    support, drawn = _shown_bounds(value)
    if support.low is None:
        return ("by an expression", "by an expression")
    start, end = ("", ", as drawn") if drawn else _around(support)
    p, q = slice_value_bounds(support, 0, 3), slice_value_bounds(support, 3, 7)
    return f"{start}{format_value_bounds(p)} m{end}", _rotation(q, start, end)


def _is_finite(*bounds: Any) -> bool:
    return all(
        _is_finite(*bound) if isinstance(bound, tuple) else bound is not None and math.isfinite(bound)
        for bound in bounds
    )


COLOR_FIELDS: Final = frozenset({"base_color", "emission"})
_FILES: Final = frozenset({"file", "px", "nx", "py", "ny", "pz", "nz"})


def entity_fields(entity: Entity, plan: ScenePlan) -> Fields:
    """The fields of an entity, and which of them vary."""
    return _fields(_values(entity, plan), plan)


def object_fields(one: Constraint | Light | Camera | Environment, plan: ScenePlan) -> Fields:
    """The fields of another object, likewise."""
    return _fields(_plain_values(one, ""), plan)


def _fields(values: Iterable[_Found], plan: ScenePlan) -> Fields:
    found: dict[str, list[_Found]] = {}
    for item in values:
        found.setdefault(item.label, []).append(item)
    varying: list[VaryingField] = []
    for label, items in found.items():
        if any(item.varies for item in items):
            varying += _differing(label, items, plan)
    return Fields(sum(2 if is_pose(label) else 1 for label in found), tuple(varying))


def is_file(name: str) -> bool:
    """Whether a field is an index of a file."""
    return name in _FILES or name.endswith("texture")


def is_pose(label: str) -> bool:
    """Whether a field is shown as position and rotation."""
    return label.rsplit(".", 1)[-1] in {"pose", "com", "pose_in_parent", "pose_in_child", "target"}


def _values(entity: Entity, plan: ScenePlan) -> Iterator[_Found]:
    yield _found("pose", entity.pose)
    if entity.pick is not None:
        yield _found("pick", entity.pick)
    for structure in entity.structures:
        if isinstance(structure, ArticulationStructure):
            yield from _articulation(structure, plan)
        else:
            yield from _body(structure, plan)


def _articulation(structure: ArticulationStructure, plan: ScenePlan) -> Iterator[_Found]:
    for name, value in _given(structure):
        if isinstance(value, Value):
            yield _found(name, value)
    for link in structure.links:
        place = f"links{name_suffix(link.name)}"
        if link.joint is not None:
            yield from _plain_values(link.joint, f"{place}.joint")
        yield from _body(link.body, plan, f"{place}.")
    for mimic in structure.mimics:
        yield from _plain_values(mimic, f"mimics{name_suffix(mimic.joint)}")


def _plain_values(node: Any, place: str) -> Iterator[_Found]:
    """The values of a dataclass and of those nested in it."""
    for name, item in _given(node):
        where = field_path(place, name, node.__class__)
        if isinstance(item, Value):
            yield _found(where, item)
        elif isinstance(item, Texture):
            yield _found(where, item.file)
        elif isinstance(item, tuple):
            for one in cast("tuple[Any, ...]", item):
                if isinstance(one, AxisLimit | AxisDrive):
                    yield from _plain_values(one, where + name_suffix(one.axis))
        elif is_dataclass(item):
            yield from _plain_values(item, where)


def _body(structure: BodyStructure, plan: ScenePlan, above: str = "") -> Iterator[_Found]:
    """The values of a body or a link. `above`: prefix of its fields' names."""
    for name, value in _given(structure):
        if isinstance(value, Value):
            yield _found(above + SPEC_FIELD_NAMES.get(name, name), value)
    for name, value in _given(structure.inertial):
        yield _found(f"{above}inertial.{name}", value)
    for kind, shapes in (("collisions", structure.collisions), ("visuals", structure.visuals)):
        for index, shape in enumerate(shapes):
            place = f"{above}{kind}[{index}]"
            origin = shape.origin
            where = link_shape_path(above + kind, origin, place) if above else shape_path(origin, place)
            table = plan.physical_materials if kind == "collisions" else plan.visual_materials
            for name, value in (*_given(shape.geometry), *_given(shape)):
                if name == "material":
                    yield from _material(where, value.bounds.alternatives or (), table)
                elif isinstance(value, Value):
                    yield _found(f"{where}.{name}", value)


def _given(node: Any) -> list[tuple[str, Any]]:
    """The fields of a dataclass that have a value; none if it is None."""
    if node is None:
        return []
    pairs = [(item.name, getattr(node, item.name)) for item in fields(node) if item.compare]
    return [(name, value) for name, value in pairs if value is not None]


def _material(
    where: str, indices: Sequence[Any], table: Sequence[PhysicalMaterial] | Sequence[VisualMaterial]
) -> Iterator[_Found]:
    """Each field of the materials that a shape may have, over all of them."""
    rows = [table[int(index)] for index in indices]
    names = dict.fromkeys(name for row in rows for name, _ in _given(row))
    for name in names:
        values = [_value(getattr(row, name)) for row in rows]
        given = [value for value in values if value is not None]
        shown = [_shown_bounds(value) for value in given]
        support = union_bounds(part for part, _ in shown)
        one = support.alternatives is not None and len(support.alternatives) == 1
        yield _Found(
            f"{where}.material.{name}",
            support,
            varies=len(given) < len(rows) or not one,
            at_reset=any(value.recipe is not None for value in given),
            drawn=any(drawn for _, drawn in shown),
        )


def _value(item: Any) -> Value | None:
    return item.file if isinstance(item, Texture) else item


def _differing(label: str, items: list[_Found], plan: ScenePlan) -> Iterator[VaryingField]:
    support = union_bounds(item.bounds for item in items)
    at_reset = any(item.at_reset for item in items)
    start, end = ("", ", as drawn") if any(item.drawn for item in items) else _around(support)
    if is_pose(label) and support.low is not None:
        p, q = slice_value_bounds(support, 0, 3), slice_value_bounds(support, 3, 7)
        if p.low != p.high:
            yield VaryingField(f"{label}.p", start + format_value_bounds(p) + end, at_reset)
        if q.low != q.high:
            yield VaryingField(f"{label}.q", _rotation(q, start, end), at_reset)
        return
    name = label.rsplit(".", 1)[-1]
    yield VaryingField(label, start + _words(name, support, plan.files) + end, at_reset)


def _around(support: ValueBounds) -> tuple[str, str]:
    """Words around bounds: those of an expression may be wider than its values."""
    return ("", "") if support.exact or support.alternatives is not None else ("within ", "")


def _rotation(q: ValueBounds, start: str, end: str) -> str:
    return "any rotation" if is_any_rotation(q) else start + format_value_bounds(q) + end


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
