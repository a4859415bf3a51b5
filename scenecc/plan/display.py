"""Formatting of a plan's fields and values: paths as in a scene file, and short texts for values and pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, cast

from scenecc.colors import color_text
from scenecc.diagnostics.diagnostic import Origin, dotted
from scenecc.plan.articulation import ArticulationStructure, Link, Mimic
from scenecc.plan.body import BodyStructure, CollisionShape, VisualShape
from scenecc.plan.constraint import AxisDrive, AxisLimit
from scenecc.variation.bounds import ValueBounds

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from scenecc.plan.scene import ScenePlan
    from scenecc.variation.nodes import Node

SPEC_FIELD_NAMES: Final = {
    "disable_gravity": "gravity",
    "locked_motion_axes": "locked_axes",
    "collision_groups": "collision_bits",
}
"""Plan fields with another name in a scene file."""

_INLINED_FIELDS: Final = frozenset(
    {
        ("Link", "body"),
        ("Constraint", "joint"),
        ("AxisLimit", "limits"),
        ("Light", "light"),
        ("Camera", "lens"),
    }
)
"""Fields whose own fields are inlined in the scene file, by the dataclass that has them."""

ITEM_KEYS: Final[dict[type, str]] = {Link: "name", Mimic: "joint", AxisLimit: "axis", AxisDrive: "axis"}
"""Field that identifies a list item in a path; other items use their index."""

_SHAPE_LISTS: Final = ("shapes", "collisions", "visuals")


def shape_path(origin: Origin | None, otherwise: str) -> str:
    """The path of a shape below its entity, as in its source file; `otherwise` without an origin."""
    path = () if origin is None else origin.path[2:]
    return dotted(path) if path and path[0] in {*_SHAPE_LISTS, "variants"} else otherwise


def link_shape_path(above: str, origin: Origin | None, otherwise: str) -> str:
    """The path of a shape below its link, as in its source file; `otherwise` without an origin."""
    path = () if origin is None else origin.path
    last = max((place for place, key in enumerate(path) if place > 1 and key in _SHAPE_LISTS), default=None)
    return otherwise if last is None else f"{above.rpartition('.')[0]}.{dotted(path[last:])}"


def field_path(above: str, name: str, holder: type | None = None) -> str:
    """The path of a field. Fields of a geometry are keys of its shape; fields of a lens are keys of its camera.

    Args:
        above: path of the dataclass that has the field.
        name: of the field.
        holder: type of that dataclass.
    """
    if name in {"geometry", "structures"} or (holder is not None and (holder.__name__, name) in _INLINED_FIELDS):
        return above
    name = SPEC_FIELD_NAMES.get(name, name)
    return f"{above}.{name}" if above else name


def name_suffix(name: str) -> str:
    """The path suffix of a list item with a name."""
    return dotted(("", name))[len('[""]') :]


def item_path(above: str, index: int, item: Any, *, count: int) -> str:
    """The path of a list item, `count` being the length of the list. A single structure has the entity's path."""
    if isinstance(item, BodyStructure | ArticulationStructure):
        return "" if count == 1 else f"variants[{index}]"
    if item.__class__ in ITEM_KEYS:
        return above + name_suffix(getattr(item, ITEM_KEYS[item.__class__]))
    place = f"{above}[{index}]"
    if not isinstance(item, CollisionShape | VisualShape):
        return place
    return link_shape_path(above, item.origin, place) if "links" in above else shape_path(item.origin, place)


_MAX_ALTERNATIVES: Final = 4
"""Most alternatives that are listed."""

_MAX_ALTERNATIVES_WIDTH: Final = 60
"""Longest list of alternatives, in characters."""

DIGITS: Final = 5
"""Default number of significant digits."""

_MORE_DIGITS: Final = (DIGITS, 8, 12, 17)


def format_value_bounds(support: ValueBounds) -> str:
    """Formats alternatives (`0.1 | 0.5`) or bounds (`0.1 … 0.5`), as far as they are known."""
    alternatives = support.alternatives
    if alternatives is None:
        return _format_range(support.low, support.high) if support.low is not None else "by an expression"
    return join_alternatives([format_item(item) for item in alternatives]) or (
        f"{len(alternatives)} values, {_format_range(support.low, support.high)}"
        if support.low is not None
        else f"{len(alternatives)} values"
    )


def slice_value_bounds(support: ValueBounds, start: int, end: int) -> ValueBounds:
    """Bounds of some components of a vector."""
    if support.alternatives is not None:
        return ValueBounds.of(item[start:end] for item in support.alternatives)
    return ValueBounds(None, support.low[start:end], support.high[start:end], support.exact)


def is_any_rotation(q: ValueBounds) -> bool:
    """Whether bounds of a quaternion allow any rotation: no component is restricted."""
    return q.alternatives is None and q.low == (-1, -1, -1, -1) and q.high == (1, 1, 1, 1)


def join_alternatives(items: Sequence[str]) -> str | None:
    """Joins alternatives with a separator; None if there are too many or the text is too long."""
    text = " | ".join(items)
    return text if len(items) <= _MAX_ALTERNATIVES and len(text) <= _MAX_ALTERNATIVES_WIDTH else None


def format_item(item: Any, digits: int = DIGITS) -> str:
    """Formats a number to some digits, a truth value, a text or a vector."""
    if isinstance(item, bool):
        return "true" if item else "false"
    if isinstance(item, tuple):
        return f"[{', '.join(format_item(one, digits) for one in cast('tuple[Any, ...]', item))}]"
    return f"{item:.{digits}g}" if isinstance(item, int | float) else str(item)


def format_color(item: tuple[float, ...], digits: int = DIGITS) -> str:
    """Formats a linear colour as in scene files: `#rrggbb[aa]` if that text gives it, otherwise as a list."""
    return color_text(item, 1e-9) or format_item(item, digits)


def format_pair(a: Sequence[Any], b: Sequence[Any], show: Callable[[Any, int], str] = format_item) -> tuple[str, str]:
    """Formats two sequences with enough digits to distinguish them."""
    first, second = _drop_repeats(a), _drop_repeats(b)
    both = ("", "")
    for digits in _MORE_DIGITS:
        both = _format_set(first, digits, show), _format_set(second, digits, show)
        if both[0] != both[1]:
            break
    return both


def _drop_repeats(items: Sequence[Any]) -> list[Any]:
    return list({repr(item): item for item in items}.values())


def _format_set(items: list[Any], digits: int, show: Callable[[Any, int], str]) -> str:
    text = join_alternatives([show(item, digits) for item in items])
    if text is not None or not _are_numbers(items):
        return text or (show(items[0], digits) if len(items) == 1 else f"{len(items)} values")
    if not isinstance(items[0], tuple):
        return _format_range(min(items), max(items), digits)
    columns = list(zip(*items, strict=True))
    return _format_range(tuple(map(min, columns)), tuple(map(max, columns)), digits)


def _are_numbers(items: list[Any]) -> bool:
    """Whether all items are numbers, or number vectors of one length."""
    if not isinstance(items[0], tuple):
        return all(isinstance(item, int | float) and not isinstance(item, bool) for item in items)
    vectors = cast("list[tuple[Any, ...]]", [item for item in items if isinstance(item, tuple)])
    lengths = {len(vector) for vector in vectors}
    return len(vectors) == len(items) and len(lengths) == 1 and all(_are_numbers([*vector]) for vector in vectors)


def _format_range(low: Any, high: Any, digits: int = DIGITS) -> str:
    if not isinstance(low, tuple):
        first = format_item(low, digits)
        return first if low == high else f"{first} … {format_item(high, digits)}"
    parts = [_format_range(a, b, digits) for a, b in zip(cast("tuple[Any, ...]", low), high, strict=True)]
    if len(set(parts)) == 1 and low != high:
        return f"{parts[0]} each"
    return f"[{', '.join(parts)}]"


_MAX_TEXT_WIDTH: Final = 120

_COLOR_FIELDS: Final = frozenset({"base_color", "emission"})


def truncate(text: str) -> str:
    """Truncates a text to one line."""
    return text if len(text) <= _MAX_TEXT_WIDTH else text[: _MAX_TEXT_WIDTH - 1] + "…"


def format_row_pair(path: str, a: list[Any], b: list[Any], scenes: Sequence[int]) -> tuple[str | None, str | None]:
    """Formats two columns that differ in each of the scenes. None in a column or as a column: no value."""
    show = _item_formatter(path)
    words = format_pair(a, b, show)
    if words[0] == words[1] and len(scenes) > 1:
        # Same values in other scenes: show the first scene, where they differ.
        one = format_pair(a[:1], b[:1], show)
        words = (f"{one[0]} in scene {scenes[0]}, …", f"{one[1]} in scene {scenes[0]}, …")
    absent = [all(item is None for item in items) for items in (a, b)]
    return None if absent[0] else words[0], None if absent[1] else words[1]


def _item_formatter(path: str) -> Callable[[Any, int], str]:
    name = path.rpartition(".")[2]
    shown: Callable[[Any, int], str] = format_color if name in _COLOR_FIELDS else format_item

    def show(item: Any, digits: int) -> str:
        if item is None:
            return "unset"
        return format_item(not item) if name == "gravity" and isinstance(item, bool) else shown(item, digits)

    return show


def format_reset_pair(recipes: tuple[Node | None, Node | None], plans: tuple[ScenePlan, ScenePlan]) -> tuple[str, str]:
    """Formats what resets can draw in two plans that are equal as built."""
    first, second = (_format_reset(recipe, plan) for recipe, plan in zip(recipes, plans, strict=True))
    return first, f"{second}, drawn differently" if first == second else second


def _format_reset(recipe: Node | None, plan: ScenePlan) -> str:
    from scenecc.variation.node_bounds import BoundsAnalysis  # noqa: PLC0415 - most plans have no recipes

    if recipe is None:
        return "as built"
    found = BoundsAnalysis(dict(plan.draws), plan.num_scenes).bounds(recipe)
    if is_any_rotation(found):
        return "any rotation at reset"
    about = "" if found.exact or found.alternatives is not None or found.low is None else "about "
    return f"{about}{format_value_bounds(found)} at reset"


def to_tuples(item: Any) -> Any:
    """Converts lists to tuples at every depth."""
    return tuple(map(to_tuples, item)) if isinstance(item, list) else item  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]
