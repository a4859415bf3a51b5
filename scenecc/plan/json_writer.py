"""Writes a plan as canonical JSON: equal plans give equal text to the byte, different plans different text."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.plan.material import rebase_file
from scenecc.plan.schema import (
    ChoiceKind,
    FieldKind,
    ListKind,
    ObjectKind,
    Quantity,
    ScalarKind,
    SceneSelectionKind,
    SharedDrawsKind,
    UnionKind,
    VectorKind,
    plan_fields,
    type_name,
)

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.plan.scene import ScenePlan
    from scenecc.plan.value import Value
    from scenecc.variation.nodes import Node as RecipeNode


PLAN_VERSION = 2
"""The value of a plan's `scenecc_plan` key. In version 1, which is read too, files have no hashes."""

_OMITTED_WHEN_EMPTY = frozenset(("constraints", "lights", "cameras", "draws", "mimics", "hidden", "names"))
"""Lists that are left out where they are empty, and a flag where it is false."""

_WIDTH = 100

_INDENT = "  "

_ESCAPED = re.compile("[\x80-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Half a surrogate pair, which UTF-8 cannot hold, and what breaks, reorders or steers lines where the text is shown."""


def plan_to_json(plan: ScenePlan, *, base: Path | None = None) -> str:
    """Writes a plan as JSON that `plan_from_json` reads back.

    Keys stand in the order of the dataclasses and what is None is left out, as are origins. Floats are the
    shortest decimals that give the same float64. A quantity that is the same in every scene is written plainly,
    another one as `{"per_scene": [...]}`; one that a reset draws anew has its `recipe` beside that, or beside its
    `value` where that is the same in every scene. Equal steps in `scene_idxs` are written as a slice, `"0:4"`.

    Args:
        plan: what to write.
        base: folder that the text will lie in; relative uris are then rewritten against it. None keeps the uris of
            the plan, which gives the canonical text.

    Raises:
        ValueError: if a number of the plan is not finite.
    """
    if base is not None:
        plan = replace(plan, files=tuple(rebase_file(file, base) for file in plan.files))
    members = [("scenecc_plan", str(PLAN_VERSION)), *_format_members(plan, _INDENT)]
    body = f",\n{_INDENT}".join(_join_members(members))
    return _escape(f"{{\n{_INDENT}{body}\n}}\n")


def _escape(text: str) -> str:
    """Also what JSON would allow, but no editor or terminal should be given."""
    return text if text.isascii() else _ESCAPED.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def _format_members(node: object, indent: str) -> list[tuple[str, str]]:
    inner = indent + _INDENT
    return [
        (slot.name, _format_item(slot.kind, item, inner))
        for slot in plan_fields(type(node))
        if (item := getattr(node, slot.name)) is not None and (item or slot.name not in _OMITTED_WHEN_EMPTY)
    ]


def _format_item(kind: FieldKind, item: Any, indent: str) -> str:
    """One item as JSON. `indent`: what its inner lines start with, one step included."""
    match kind:
        case Quantity():
            text = _format_value(item, indent, infinite=kind.infinite)
        case ScalarKind():
            # By the field's type, not the item's: a plan with the integer 1 equals one with 1.0, and -0.0 equals 0.0.
            text = _dumps(item + 0.0 if kind.type is float else int(item) if kind.type is int else item)
        case ChoiceKind():
            text = _dumps(item)
        case VectorKind():
            text = _break_array(_dumps([number + 0.0 for number in item]), indent)
        case SceneSelectionKind():
            text = _format_selection(item, indent)
        case ObjectKind():
            text = _join_parts("{}", _join_members(_format_members(item, indent)), indent)
        case UnionKind():
            named = [] if item.__class__ is kind.untyped else [("type", _dumps(type_name(item.__class__)))]
            text = _join_parts("{}", _join_members([*named, *_format_members(item, indent)]), indent)
        case SharedDrawsKind():
            inner = indent + _INDENT
            text = _join_parts("{}", [f"{_dumps(name)}: {_format_recipe(node, inner)}" for name, node in item], indent)
        case ListKind():
            text = _join_parts("[]", [_format_item(kind.item, one, indent + _INDENT) for one in item], indent)
    return text


def _format_value(value: Value, indent: str, *, infinite: bool) -> str:
    data = value.data.tolist()
    dumps = _dumps_infinite if infinite else _dumps
    if not value.varies and value.recipe is None:
        return _break_array(dumps(data[0]), indent)
    inner = indent + _INDENT
    key, item = ("per_scene", data) if value.varies else ("value", data[0])
    members = [(key, _break_array(dumps(item), inner))]
    if value.recipe is not None:
        members.append(("recipe", _format_recipe(value.recipe, inner)))
    return _join_parts("{}", _join_members(members), indent)


def _format_recipe(node: RecipeNode, indent: str) -> str:
    from scenecc.plan.recipes import recipe_to_data  # noqa: PLC0415 - most plans have no recipes

    return _format_data(recipe_to_data(node), indent)


def _format_data(data: Any, indent: str) -> str:
    """Plain data as JSON; numbers and lists of them an item a line where a line is too short."""
    inner = indent + _INDENT
    if data.__class__ is dict:
        return _join_parts("{}", [f"{_dumps(key)}: {_format_data(item, inner)}" for key, item in data.items()], indent)
    if data.__class__ is list and any(one.__class__ in {dict, list, str} for one in data):
        return _join_parts("[]", [_format_data(one, inner) for one in data], indent)
    return _break_array(_dumps(data), indent)


def _break_array(text: str, indent: str) -> str:
    """Breaks an array of numbers, or of arrays of them, that is too long for a line: an item a line."""
    if len(text) + len(indent) <= _WIDTH or text[0] != "[":
        return text
    outer = indent[: -len(_INDENT)]
    items = text[1:-1].replace("], [", f"],\n{indent}[") if text[1] == "[" else text[1:-1].replace(", ", f",\n{indent}")
    return f"[\n{indent}{items}\n{outer}]"


def _join_parts(brackets: str, parts: list[str], indent: str) -> str:
    line = ", ".join(parts)
    if len(line) + len(indent) <= _WIDTH and "\n" not in line:
        return f"{brackets[0]}{line}{brackets[1]}"
    broken = f",\n{indent}".join(parts)
    return f"{brackets[0]}\n{indent}{broken}\n{indent[: -len(_INDENT)]}{brackets[1]}"


def _format_selection(scene_idxs: tuple[int, ...], indent: str) -> str:
    count, first, last = len(scene_idxs), scene_idxs[0], scene_idxs[-1]
    # Ascending without repetition, as every plan's: this saves walking 4096 scenes for each of 10 000 entities.
    if count > 1 and last - first == count - 1:
        return f'"{first}:{last + 1}"'
    step = scene_idxs[1] - first if count > 2 else 0
    if step and scene_idxs == tuple(range(first, last + 1, step)):
        return f'"{first}:{last + 1}:{step}"'
    return _break_array(_dumps(list(map(int, scene_idxs))), indent)


def _join_members(members: list[tuple[str, str]]) -> list[str]:
    return [f'"{name}": {text}' for name, text in members]


def _dumps_infinite(item: object) -> str:
    """JSON has no word for infinity, and its readers read what is too large for a float64 as one."""
    return json.dumps(item, ensure_ascii=False).replace("Infinity", "1e999")


def _dumps(item: object) -> str:
    return json.dumps(item, ensure_ascii=False, allow_nan=False)
