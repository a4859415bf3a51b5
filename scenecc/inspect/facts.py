"""A tree of items with facts that describes a scene, for people and programs."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, Final, cast

from scenecc.diagnostics.frozen import frozen
from scenecc.inspect.varying import COLOR_FIELDS, is_file, is_pose, pose_words, varying_words
from scenecc.plan import Value
from scenecc.plan.body import Mount, Texture
from scenecc.plan.display import field_path, format_color, format_item, name_suffix, slice_value_bounds
from scenecc.plan.geometry import SOLID_SIZES
from scenecc.plan.properties import PROPERTIES

if TYPE_CHECKING:
    from scenecc.plan import AxisDrive, AxisLimit, ScenePlan
    from scenecc.variation.bounds import ValueBounds

_LABELS: Final = {
    "num_scenes": "scenes",
    "description": "",
    "scene_idxs": "scenes",
    "pose.p": "at",
    "pose.q": "turned",
    "link_count": "links",
    "roles": "",
    "number": "",
    "defaults": "",
    "bytes": "",
}
"""Displayed labels of facts, if they differ from the names."""


@frozen
class Fact:
    """One property of an item.

    Attributes:
        name: as in scene files, if they have it.
        value: plain data, in SI units; infinite numbers are "inf" and "-inf". If scenes differ and no scene was
            requested, a mapping: `alternatives`, or `low` and `high`, and `at_reset` if a reset draws it.
        words: displayed text, with the unit. "": not displayed.
    """

    name: str
    value: Any
    words: str

    @property
    def label(self) -> str:
        """Its displayed label; "" if the words suffice."""
        return _LABELS.get(self.name, self.name)


@frozen
class Item:
    """One object of the tree.

    Attributes:
        name: "" if it has none.
        type: "" if its group implies it.
        facts: in order, with unique names.
        groups: its parts, by kind: one item, or any number.
        hidden: total number of omitted items below it.
        under: index of its parent in the same group, smaller than its own; for links.
    """

    name: str
    type: str
    facts: tuple[Fact, ...] = ()
    groups: tuple[tuple[str, Item | tuple[Item, ...]], ...] = ()
    hidden: int = 0
    under: int | None = None

    def data(self) -> dict[str, Any]:
        """Returns the item as plain data, for programs."""
        found: dict[str, Any] = {}
        if self.name:
            found["name"] = self.name
        if self.type:
            found["type"] = self.type
        found |= {fact.name: fact.value for fact in self.facts}
        for name, group in self.groups:
            found[name] = group.data() if isinstance(group, Item) else [item.data() for item in group]
        if self.hidden:
            found["hidden"] = self.hidden
        return found

    def cut(self, depth: int) -> Item:
        """Returns the item with at most `depth` levels below it."""
        if depth > 0:
            groups = tuple((name, _cut(group, depth - 1)) for name, group in self.groups)
            return Item(self.name, self.type, self.facts, groups, under=self.under)
        return Item(self.name, self.type, self.facts, hidden=self.count(), under=self.under)

    def count(self) -> int:
        """Number of items below it."""
        items = [item for _, group in self.groups for item in ((group,) if isinstance(group, Item) else group)]
        return len(items) + sum(item.count() for item in items)


def _cut(group: Item | tuple[Item, ...], depth: int) -> Item | tuple[Item, ...]:
    return group.cut(depth) if isinstance(group, Item) else tuple(item.cut(depth) for item in group)


def some_words(names: tuple[str, ...], most: int = 3) -> str:
    """Returns the first of many names, and the number of the others."""
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")


UNITS: Final = {
    **{row.field: row.unit for row in PROPERTIES if row.unit},
    **dict.fromkeys(SOLID_SIZES, "m"),
    "size": "m",
    "p": "m",
    "inertia": "kg·m²",
    "linear_velocity_target": "m/s",
    "angular_velocity_target": "rad/s",
    "bounce_threshold": "m/s",
    "timestep": "s",
    "gravity": "m/s²",
    **dict.fromkeys(("scene_spacing", "spacing", "near", "far", "top", "half_width", "half_height"), "m"),
    **dict.fromkeys(("fovx", "fovy", "inner_fov", "outer_fov"), "rad"),
    **dict.fromkeys(("width", "height", "map_size", "fx", "fy", "cx", "cy"), "px"),
}
"""Units of numbers, by the last part of a field's name."""

_IDENTITY: Final = (1.0, 0.0, 0.0, 0.0)
_NO_UNITS: Final[Mapping[str, str]] = {}
_MOST_LISTED: Final = 64
"""Largest number of alternatives in plain data. Beyond it, bounds are given."""


class FactReader:
    """Reads the fields of a plan's dataclasses.

    Args:
        plan: has the tables that indices refer to.
        row: of the scene to describe, in the values. None: the range over all rows.
        units: units of numbers; they override `UNITS`.
    """

    def __init__(self, plan: ScenePlan, row: int | None, units: Mapping[str, str] = _NO_UNITS) -> None:
        self.plan = plan
        self.row = row
        self.units = units

    def of(self, node: Any, place: str = "", *, without: Container[str] = ()) -> Iterator[Fact]:
        """Yields facts of all fields of a dataclass and of those nested in it. `place`: prefix of the names."""
        if node is None:
            return
        for item in fields(node):
            value = getattr(node, item.name)
            if item.compare and value is not None and item.name not in without:
                label = field_path(place, item.name, node.__class__)
                if value == item.default:
                    yield Fact(label, plain_data(value), "")
                else:
                    yield from self._field(value, label)

    def value(self, name: str, value: Value) -> Iterator[Fact]:
        """Yields the facts of a value. For a pose, the position, and the rotation unless it is the identity."""
        if self.row is None and not value.is_constant:
            yield from self._pose(name, value) if is_pose(name) else (self._make_varying_fact(name, value),)
            return
        found: Any = value.row(self.row or 0).tolist()
        last = name.rsplit(".", 1)[-1]
        if is_pose(name):
            # A shape at its body's origin needs no text, but an entity at the world's origin does.
            here = name != "pose" and found[:3] == [0, 0, 0]
            yield Fact(f"{name}.p", found[:3], "") if here else fact(f"{name}.p", found[:3])
            if tuple(found[3:]) != _IDENTITY:
                yield Fact(f"{name}.q", found[3:], rotation_words(found[3:]))
        elif is_file(last):
            uri = self.plan.files[int(found)].uri
            yield Fact(name, uri, uri)
        elif last == "gravity":
            yield fact(name, not found)
        elif last in COLOR_FIELDS:
            yield Fact(name, found, format_color(tuple(found)))
        else:
            yield fact(name, found, self._unit(name))

    def _field(self, value: Any, name: str) -> Iterator[Fact]:
        if isinstance(value, Value):
            yield from self.value(name, value)
        elif isinstance(value, Texture):
            yield from self.value(name, value.file)
            yield from self.of(value, name, without=("file",))
        elif isinstance(value, Mount):
            words = mount_words(value)
            yield Fact(name, words, words)
        elif name in {"limits", "drives"}:
            for one in cast("tuple[AxisLimit | AxisDrive, ...]", value):
                yield from self.of(one, name + name_suffix(one.axis), without=("axis",))
        elif name.endswith("heights"):
            rows = cast("tuple[tuple[float, ...], ...]", value)
            low, high = min(map(min, rows)), max(map(max, rows))
            yield Fact(name, plain_data(rows), f"{len(rows)} × {len(rows[0])} from {low:g} to {high:g}")
        elif is_dataclass(value):
            yield from self.of(value, name)
        else:
            yield fact(name, value)

    def _unit(self, name: str) -> str:
        return self.units.get(name.rsplit(".", 1)[-1]) or unit_of(name)

    def _pose(self, name: str, value: Value) -> Iterator[Fact]:
        support = value.bounds
        words = pose_words(value)
        for part, start, end, shown in (("p", 0, 3, words[0]), ("q", 3, 7, words[1])):
            of = support if support.low is None else slice_value_bounds(support, start, end)
            one = of.low if of.low == of.high else None
            if one is None:
                yield Fact(f"{name}.{part}", self._range(part, of, value), shown)
            elif part == "p":
                yield fact(f"{name}.p", list(one))
            elif one != _IDENTITY:
                yield Fact(f"{name}.q", list(one), rotation_words(list(one)))

    def _make_varying_fact(self, name: str, value: Value) -> Fact:
        last = name.rsplit(".", 1)[-1]
        unit = self._unit(name) if _is_number(value.bounds.low) else ""
        return Fact(name, self._range(last, value.bounds, value), varying_words(last, value, self.plan.files, unit))

    def _range(self, name: str, support: ValueBounds, value: Value) -> dict[str, Any]:
        data: dict[str, Any] = {}
        if support.alternatives is not None and len(support.alternatives) <= _MOST_LISTED:
            data["alternatives"] = [self._plain_item(name, item) for item in support.alternatives]
        elif support.low is not None:
            data |= {"low": plain_data(support.low), "high": plain_data(support.high)}
        return data | ({"at_reset": True} if value.recipe is not None else {})

    def _plain_item(self, name: str, item: Any) -> Any:
        if is_file(name):
            return self.plan.files[int(item)].uri
        return not item if name == "gravity" else plain_data(item)


def fact(name: str, value: Any, unit: str | None = None) -> Fact:
    """Returns a number, flag, text or vector with its unit, by default that of its name."""
    unit = unit_of(name) if unit is None else unit
    item = tuple(cast("list[Any]", value)) if isinstance(value, list) else value
    words = _words(item)
    return Fact(name, plain_data(value), f"{words} {unit}" if unit and _is_number(item) else words)


def unit_of(name: str) -> str:
    """Returns the unit of a field's numbers; "" if they have none, or if it depends on the owner of the field."""
    above, _, last = name.rpartition(".")
    if above == "limits":
        return "rad" if last == "twist" else "m"
    return UNITS.get(last, "")


def _words(item: Any) -> str:
    """Formats like `format_item`, but integers (counts, bits, seeds) with all digits."""
    if isinstance(item, tuple):
        return f"[{', '.join(map(_words, cast('tuple[Any, ...]', item)))}]"
    return str(item) if type(item) is int else format_item(item)


def _is_number(item: Any) -> bool:
    if isinstance(item, tuple):
        return all(map(_is_number, cast("tuple[Any, ...]", item)))
    return isinstance(item, int | float) and not isinstance(item, bool)


def plain_data(item: Any) -> Any:
    """Returns numbers, texts, flags, and lists of these for JSON. Infinite numbers become texts."""
    if isinstance(item, tuple | list):
        return [plain_data(one) for one in cast("tuple[Any, ...]", item)]
    return str(item) if isinstance(item, float) and not math.isfinite(item) else item


def mount_words(mount: Mount | None) -> str:
    """Returns a mount as in a scene file; "world" for None."""
    return "world" if mount is None else str(mount)


TINY = 1e-300
"""Smallest length that may be a divisor."""


def rotation_words(q: list[float]) -> str:
    """Formats a rotation [w, x, y, z] as an angle from 0° to 180° and an axis."""
    w, *v = q if q[0] >= 0 else [-component for component in q]
    length = math.hypot(*v)
    if length < TINY:
        return "0°"
    angle = math.degrees(2 * math.atan2(length, w))
    return f"{angle:.4g}° about {axis_words([component / length for component in v])}"


def axis_words(axis: list[float]) -> str:
    """Formats a unit vector: `z`, `-x` or `[0.6, 0, 0.8]`."""
    rounded = [round(component, 6) + 0.0 for component in axis]
    for index, name in enumerate("xyz"):
        if abs(rounded[index]) == 1:
            return f"-{name}" if rounded[index] < 0 else name
    return format_item(tuple(rounded))
