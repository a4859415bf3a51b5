"""Writer and reader of a plan's JSON, both from the schema of the plan."""

from __future__ import annotations

import difflib
import json
import re
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeGuard

from scenecc.diagnostics.diagnostic import Location, Origin
from scenecc.diagnostics.diagnostic import Path as Keys
from scenecc.files import keep_file
from scenecc.plan.articulation import ArticulationStructure, Joint, Link, Mimic
from scenecc.plan.body import AssetFile, BodyStructure, CollisionShape, VisualShape, rebase_file
from scenecc.plan.constraint import Constraint, Drive
from scenecc.plan.expect import Condition, NoOverlap, Settled
from scenecc.plan.geometry import MAX_HEIGHTS, MAX_TOTAL_HEIGHTS, Heightfield, Heights
from scenecc.plan.json_values import (
    JsonProblem,
    RepeatedKeyError,
    check_articulation,
    check_axes,
    check_expectations,
    check_heights,
    check_joint,
    check_link,
    check_materials,
    check_mounts,
    check_names,
    check_pick,
    check_placements,
    check_structures,
    count_objects,
    describe_json,
    is_list,
    is_object,
    read_number,
    read_rows,
    read_selection,
    reject_repeated_keys,
)
from scenecc.plan.placement import Placement
from scenecc.plan.properties import Quantity
from scenecc.plan.rendering import Camera, Environment, Light
from scenecc.plan.scene import Entity, Physics, ScenePlan
from scenecc.plan.schema import (
    BytesKind,
    ChoiceKind,
    FieldKind,
    ListKind,
    ObjectKind,
    ScalarKind,
    SceneSelectionKind,
    SharedDrawsKind,
    TemplateKind,
    UnionKind,
    VectorKind,
    plan_fields,
    type_name,
)
from scenecc.plan.value import Value, recalled
from scenecc.source.limits import Limits

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.plan.recipes import Shape
    from scenecc.variation.forms import Template
    from scenecc.variation.nodes import Node as RecipeNode

PLAN_VERSION = 2
"""The value of a plan's `scenecc_plan` key. In version 1, which is read too, files have no hashes."""

_OMITTED_WHEN_EMPTY = frozenset(
    (
        "constraints",
        "lights",
        "cameras",
        "draws",
        "mimics",
        "hidden",
        "names",
        "optional_names",
        "placements",
        "carriers",
        "near",
        "expectations",
        "excepted",
        "readings",
        "because",
    )
)
"""Lists that are left out where they are empty, and a flag where it is false."""

_DATA_URI = re.compile(r"mesh://[A-Za-z0-9_.-]{0,80}\.ply")

_HEIGHTS = ListKind(ListKind(ScalarKind(float)))

_MAX_INLINE_HEIGHTS = 10_000

_WIDTH = 100

_INDENT = "  "

_ESCAPED = re.compile("[\x80-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Half a surrogate pair, which UTF-8 cannot hold, and what breaks, reorders or steers lines where the text is shown."""


def plan_to_json(plan: ScenePlan, *, base: Path | None = None) -> str:
    """Writes a plan as JSON that `plan_from_json` reads back.

    Keys stand in the order of the dataclasses and what is None is left out, as are origins. Floats are the
    shortest decimals that give the same float64. A quantity that is the same in every scene is written plainly,
    another one as `{"per_scene": [...]}`; one that a reset draws anew has its `recipe` beside that, or beside its
    `value` where that is the same in every scene. Equal steps in `scene_idxs` are written as a slice, `"0:4"`. Terrain
    of more than 10 000 heights names them, and they stand once, at the end.

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
    bodies = [body for entity in plan.entities for body in entity.bodies]
    shared = {
        _heights_name(heights): heights
        for shape in chain.from_iterable((*body.collisions, *body.visuals) for body in bodies)
        if isinstance(shape.geometry, Heightfield) and _are_shared(heights := shape.geometry.heights)
    }
    if shared:
        tables = {name: [[number + 0.0 for number in row] for row in heights] for name, heights in shared.items()}
        texts = [(name, _break_array(_dumps(table), 3 * _INDENT)) for name, table in tables.items()]
        members.append(("heights", _join_parts("{}", _join_members(texts), 2 * _INDENT)))
    body = f",\n{_INDENT}".join(_join_members(members))
    return _escape(f"{{\n{_INDENT}{body}\n}}\n")


def _are_shared(heights: Heights) -> bool:
    """Whether heights stand in a table of the JSON, and their name where they are used."""
    return sum(map(len, heights)) > _MAX_INLINE_HEIGHTS


def _heights_name(heights: Heights) -> str:
    from hashlib import sha256  # noqa: PLC0415 - most plans have no terrain

    import numpy as np  # noqa: PLC0415 - likewise

    return sha256((np.array(heights, np.float64) + 0.0).tobytes()).hexdigest()


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
        case ChoiceKind() | TemplateKind():
            text = _dumps(item) if isinstance(kind, ChoiceKind) else _format_template(item, indent)
        case BytesKind():
            text = _dumps(b64encode(item).decode("ascii"))
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
        case ListKind() if isinstance(kind.item, ListKind) and _are_shared(item):
            text = _dumps(_heights_name(item))
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


def _format_template(template: Template, indent: str) -> str:
    from scenecc.plan.recipes import template_to_data  # noqa: PLC0415 - few plans have any

    return _format_data(template_to_data(template), indent)


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


INVALID: Final = object()
"""What a reader returns for data that it has reported."""

_CLASSES_WITH_ORIGIN = {
    ScenePlan,
    Physics,
    Entity,
    BodyStructure,
    CollisionShape,
    VisualShape,
    ArticulationStructure,
    Joint,
    Mimic,
    Constraint,
    Light,
    Environment,
    Camera,
    Placement,
    Settled,
    NoOverlap,
    Condition,
}

_CLASSES_WITH_SCENES = {Entity, Constraint, Light, Camera, Placement, Condition}
"""What says in which scenes it is; an environment has a row for every scene."""

_RULES: Final[dict[type, Callable[[dict[str, Any]], Iterator[JsonProblem]]]] = {
    Entity: check_structures,
    ArticulationStructure: check_articulation,
    Link: check_link,
    Joint: check_joint,
    Drive: check_axes,
    Heightfield: check_heights,
}
"""Rules over several fields of one object, once each of them is read."""

_MAX_STRING_LENGTH = 100_000


class PlanDecoder:
    """Reads one plan. A fault is reported and the rest is read on."""

    def __init__(
        self,
        sink: Sink,
        file: str | None,
        limits: Limits,
        resolve: Callable[[str, Origin], Path | None],
    ) -> None:
        self._sink = sink
        self._file = file
        self._scene_limit, self._object_limit = limits.scenes, limits.objects_in_all_scenes
        self._resolve = resolve
        self._table_sizes: dict[str, int] = {}
        self._num_scenes: int | None = None
        self._row_count: int | None = None
        self._selections: dict[str, tuple[int, ...]] = {}
        self._object_count = 0
        self._heights: dict[str, object] = {}
        self._height_count = 0
        self._draws: list[tuple[str, RecipeNode]] = []
        self._draw_shapes: dict[str, Shape] = {}
        self._draws_hold = True
        self._entity: dict[str, Any] = {}
        """What is being read; its scenes are counted before its shapes are read."""

    def plan(self, data: dict[str, Any]) -> object:
        """The plan, or `INVALID`."""
        for table in ("files", "physical_materials", "visual_materials"):
            items = data.get(table)
            self._table_sizes[table] = len(items) if is_list(items) else 0
        num_scenes = data.get("num_scenes")
        if type(num_scenes) is int and num_scenes > self._scene_limit:
            message = f"`num_scenes` is {num_scenes}, more than {self._scene_limit}"
            return self._fault("SC712", message, ("num_scenes",))
        self._num_scenes = num_scenes if type(num_scenes) is int and num_scenes > 0 else None
        self._read_draws(data.get("draws", {}))
        heights: object = data.pop("heights", {})
        if not is_object(heights):
            return self._fault("SC705", f"an object is wanted here, not {describe_json(heights)}", ("heights",))
        for name, rows in heights.items():
            self._heights[name] = self._many(_HEIGHTS, rows, ("heights", name[:80]))
        if INVALID in self._heights.values():
            return INVALID
        plan = self._node(ScenePlan, data, ())
        if (
            self._report(check_names(data), ())
            or not isinstance(plan, ScenePlan)
            or self._report(check_mounts(plan), ())
        ):
            return INVALID
        if self._report(check_placements(plan), ()) or self._report(check_expectations(plan), ()):
            return INVALID
        wrong = check_materials(plan)
        return plan if wrong is None else self._fault(wrong[0].code, wrong[0].message, wrong[1])

    def _report(self, faults: Iterator[JsonProblem], path: Keys) -> bool:
        """Reports faults, and returns whether there are any."""
        return bool([self._fault(fault.code, fault.message, (*path, *fault.keys)) for fault in faults])

    def _read_draws(self, data: object) -> None:
        """Ahead of all else, since recipes name them; each may read those before it."""
        for name, item in data.items() if is_object(data) else ():
            read = _read_recipe(item, self._draw_shapes)
            if isinstance(read, JsonProblem):
                self._draws_hold = False
                self._fault(read.code, read.message, ("draws", name[:80], *read.keys))
                # What reads it is not told to be wrong, too.
                self._draw_shapes[name] = None
            else:
                node, self._draw_shapes[name] = read
                self._draws.append((name, node))

    def _read(self, kind: FieldKind, data: object, path: Keys) -> object:
        read: object
        match kind:
            case Quantity():
                read = self._value(kind, data, path)
            case ScalarKind():
                read = self._plain(kind, data, path)
            case ChoiceKind() | TemplateKind():
                read = self._choice(kind, data, path) if isinstance(kind, ChoiceKind) else self._template(data, path)
            case BytesKind():
                read = self._bytes(data, path)
            case VectorKind():
                rows = self._rows(Quantity(shape=(kind.count,), bounds=kind.bounds), [data], path, in_list=False)
                read = tuple(rows.data[0].tolist()) if isinstance(rows, Value) else rows
            case SceneSelectionKind():
                read = self._selection(data, path)
            case SharedDrawsKind() if is_object(data):
                read = tuple(self._draws) if self._draws_hold else INVALID
            case SharedDrawsKind():
                read = self._fault("SC705", f"an object is wanted here, not {describe_json(data)}", path)
            case ListKind():
                read = self._many(kind, data, path)
            case ObjectKind():
                read = self._node(kind.cls, data, path)
            case UnionKind():
                read = self._one_of(kind, data, path)
        return read

    def _template(self, data: object, path: Keys) -> object:
        from scenecc.plan.recipes import read_template  # noqa: PLC0415 - few plans have any

        read = read_template(data)
        return self._fault(read.code, read.message, (*path, *read.keys)) if isinstance(read, JsonProblem) else read

    def _choice(self, kind: ChoiceKind, data: object, path: Keys) -> object:
        if data in kind.options:
            return data
        words = ", ".join(f'"{option}"' for option in kind.options)
        return self._fault("SC705", f"{describe_json(data)} is none of {words}", path)

    def _bytes(self, data: object, path: Keys) -> object:
        try:
            if isinstance(data, str):
                return b64decode(data, validate=True)
        except ValueError:  # letters that base64 has not
            pass
        return self._fault("SC705", f"base64 is wanted here, not {describe_json(data)}", path)

    def _many(self, kind: ListKind, data: object, path: Keys) -> object:
        if isinstance(kind.item, ListKind) and isinstance(data, str):
            if data in self._heights:
                return self._heights[data]
            return self._fault("SC708", f"there is no entry {describe_json(data)} in `heights`", path)
        if not is_list(data):
            return self._fault("SC705", f"a list is wanted here, not {describe_json(data)}", path)
        items = [self._read(kind.item, item, (*path, index)) for index, item in enumerate(data)]
        return INVALID if any(item is INVALID for item in items) else tuple(items)

    def _node(self, cls: type, data: object, path: Keys) -> object:
        if not is_object(data):
            return self._fault("SC705", f"an object is wanted here, not {describe_json(data)}", path)
        if cls in _CLASSES_WITH_SCENES:
            self._entity = data
        elif cls is Environment:
            self._row_count = self._num_scenes
        its_slots = plan_fields(cls)
        unknown = data.keys() - {slot.name for slot in its_slots}
        for key in sorted(unknown):
            self._unknown_key(key, [slot.name for slot in its_slots], path)
        read: dict[str, Any] = {}
        # In the order of the dataclass: an entity's scenes come before its values and say how many rows they have.
        for slot in its_slots:
            if slot.name in data:
                read[slot.name] = self._read(slot.kind, data[slot.name], (*path, slot.name))
            elif slot.required:
                read[slot.name] = self._fault("SC704", f"the key `{slot.name}` is missing", path)
        if cls in _CLASSES_WITH_SCENES or cls is Environment:
            self._row_count = None
        if unknown or any(item is INVALID for item in read.values()):
            return INVALID
        return self._made(cls, read, path)

    def _made(self, cls: type, read: dict[str, Any], path: Keys) -> object:
        if cls is AssetFile:
            found = self._file_path(read["uri"], read.get("data"), (*path, "uri"))
            return INVALID if found is None else AssetFile(path=found, origin=self._origin(path), **read)
        if cls in _RULES and self._report(_RULES[cls](read), path):
            return INVALID
        if cls is Entity and not self._pick_holds(read, path):
            return INVALID
        if cls is Heightfield and not self._counted(read["heights"], path):
            return INVALID
        if cls in _CLASSES_WITH_ORIGIN:
            read["origin"] = self._origin(path)
        return cls(**read)

    def _file_path(self, uri: str, data: bytes | None, path: Keys) -> Path | None:
        if data is None:
            return self._resolve(uri, self._origin(path))
        if not _DATA_URI.fullmatch(uri):
            self._fault("SC711", f"a file with `data` is called mesh://NAME.ply, not {describe_json(uri)}", path)
            return None
        try:
            return keep_file("meshes", data, ".ply")
        except OSError as error:
            self._fault("SC711", f"'{uri}' cannot be kept in the cache folder: {error}", path)
            return None

    def _counted(self, heights: Heights, path: Keys) -> bool:
        """Whether terrain is within the limits of a scene's."""
        count = len(heights) * len(heights[0])
        self._height_count += count
        if count <= MAX_HEIGHTS and self._height_count <= MAX_TOTAL_HEIGHTS:
            return True
        message = f"terrain has {count} heights, more than {MAX_HEIGHTS}, or all of it more than {MAX_TOTAL_HEIGHTS}"
        return self._fault("SC712", message, (*path, "heights")) is not INVALID

    def _pick_holds(self, read: dict[str, Any], path: Keys) -> bool:
        pick = read.get("pick")
        fault = None if pick is None else check_pick(pick, len(read["structures"]))
        if pick is None or fault is None:
            return True
        where = ("per_scene", *fault.keys) if pick.varies else ()
        return self._fault(fault.code, fault.message, (*path, "pick", *where)) is not INVALID

    def _one_of(self, kind: UnionKind, data: object, path: Keys) -> object:
        if not is_object(data):
            return self._fault("SC705", f"an object is wanted here, not {describe_json(data)}", path)
        by_type = dict(kind.by_type)
        if "type" not in data and kind.untyped is not None:
            return self._node(kind.untyped, data, path)
        if "type" not in data:
            return self._fault("SC704", "the key `type` is missing", path)
        name = data["type"]
        if not isinstance(name, str) or name not in by_type:
            words = ", ".join(f'"{word}"' for word in by_type)
            return self._fault("SC705", f"{describe_json(name)} is none of {words}", (*path, "type"))
        return self._node(by_type[name], {key: item for key, item in data.items() if key != "type"}, path)

    def _value(self, kind: Quantity, data: object, path: Keys) -> object:
        if not is_object(data):
            return self._rows(kind, [data], path, in_list=False)
        recipe = data.get("recipe")
        if recipe is not None and not kind.reset:
            return self._fault("SC703", "only what a reset may change has a recipe", (*path, "recipe"))
        if recipe is not None and data.keys() == {"value", "recipe"}:
            read = self._rows(kind, [data["value"]], (*path, "value"), in_list=False)
        elif data.keys() - {"recipe"} == {"per_scene"} and is_list(rows := data["per_scene"]):
            if self._row_count is not None and len(rows) != self._row_count:
                message = f"`per_scene` has {len(rows)} rows, and the entity is in {self._row_count} scenes"
                return self._fault("SC706", message, (*path, "per_scene"))
            read = self._rows(kind, rows, (*path, "per_scene"), in_list=True)
        else:
            message = 'a quantity is written plainly or as {"per_scene": [...]}'
            return self._fault("SC705", message, path)
        return read if recipe is None else self._with_recipe(read, recipe, kind, (*path, "recipe"))

    def _with_recipe(self, value: object, recipe: object, kind: Quantity, path: Keys) -> object:
        read = _read_recipe(recipe, self._draw_shapes, kind.shape)
        if isinstance(read, JsonProblem):
            return self._fault(read.code, read.message, (*path, *read.keys))
        return recalled(value.data, read[0]) if isinstance(value, Value) else INVALID

    def _rows(self, kind: Quantity, rows: list[Any], path: Keys, *, in_list: bool) -> object:
        size = self._table_sizes[kind.table] if kind.table is not None else None
        read = read_rows(kind, rows, size)
        if not isinstance(read, JsonProblem):
            return read
        return self._fault(read.code, read.message, (*path, *(read.keys if in_list else read.keys[1:])))

    def _plain(self, kind: ScalarKind, data: object, path: Keys) -> object:
        if kind.type is str or kind.type is bool:
            if type(data) is not kind.type:
                word = "a string" if kind.type is str else "true or false"
                return self._fault("SC705", f"{word} is wanted here, not {describe_json(data)}", path)
            if isinstance(data, str) and len(data) > _MAX_STRING_LENGTH:
                return self._fault("SC712", f"this string has {len(data)} characters", path)
            return data
        read = read_number(kind, data)
        return self._fault(read.code, read.message, path) if isinstance(read, JsonProblem) else read

    def _selection(self, data: object, path: Keys) -> object:
        found = read_selection(data, self._num_scenes if self._num_scenes is not None else self._scene_limit)
        if isinstance(found, JsonProblem):
            return self._fault(found.code, found.message, path)
        self._row_count = len(found)
        before = self._object_count
        self._object_count += count_objects(self._entity, len(found))
        if self._object_count > self._object_limit:
            # What comes after is counted, and no tuple made of it.
            if before <= self._object_limit:
                message = f"objects summed over their scenes are more than {self._object_limit}"
                self._fault("SC712", message, path)
            return INVALID
        return self._shared(data, found)

    def _shared(self, data: object, found: Sequence[int]) -> tuple[int, ...]:
        """Entities share the tuple of a slice: 10 000 of them in 4096 scenes are 40 million indices."""
        if not isinstance(data, str):
            return tuple(found)
        shared = self._selections.get(data)
        if shared is None:
            shared = self._selections[data] = tuple(found)
        return shared

    def _unknown_key(self, key: str, known: list[str], path: Keys) -> None:
        if self._sink.full:  # the nearest of the known keys takes long to find for a million others
            return
        near = difflib.get_close_matches(key[:80], known, n=1)
        hint = f"did you mean `{near[0]}`?" if near else None
        self._sink.report(
            "SC703", f"unknown key {describe_json(key)}", self._origin((*path, key[:80])), at="key", hint=hint
        )

    def _origin(self, path: Keys) -> Origin:
        return Origin(self._file, path)

    def _fault(self, code: str, message: str, path: Keys) -> object:
        self._sink.report(code, message, self._origin(path))
        return INVALID


def _read_recipe(data: object, draws: dict[str, Shape], shape: Shape = None) -> tuple[RecipeNode, Shape] | JsonProblem:
    from scenecc.plan.recipes import read_recipe  # noqa: PLC0415 - most plans have no recipes

    return read_recipe(data, draws, shape)


Resolver = Callable[[str, Origin], Path | None]
"""Finds the file that a uri names; where it cannot, it reports why and returns None."""


def plan_from_json(
    text: str,
    *,
    base: Path,
    sink: Sink,
    resolve: Resolver | None = None,
    file: str | None = None,
    limits: Limits | None = None,
) -> ScenePlan | None:
    """Reads the output of `plan_to_json`; None after an error, which is in `sink`.

    Ranges of single values are checked here. Rules over several values (friction order, the inertia's triangle) are
    checks on the plan, and so is whether files exist unless `resolve` asks for it.

    Args:
        text: the JSON.
        base: folder that relative uris start from.
        sink: takes diagnostics of band 7 and those of `resolve`.
        resolve: asked for every uri of the table of files; without it relative uris are joined to `base` and
            `pkg://` and `asset://` are errors.
        file: name of the document for diagnostics, and for the origins in the plan.
        limits: None takes the defaults.
    """
    limits = limits or Limits()
    if len(text) > limits.text_bytes:
        message = f"the plan has {len(text)} characters, more than {limits.text_bytes}"
        sink.report("SC712", message, Location(file))
        return None
    data = _parse_json(text, sink, file)
    if data is _UNPARSED or not _is_plan(data, sink, Origin(file)):
        return None
    del data["scenecc_plan"]
    plan = PlanDecoder(sink, file, limits, resolve or _RelativeFileResolver(base, sink).resolve).plan(data)
    return plan if isinstance(plan, ScenePlan) else None


_UNPARSED: Final = object()


def _parse_json(text: str, sink: Sink, file: str | None) -> object:
    try:
        return json.loads(text.removeprefix("\ufeff"), object_pairs_hook=reject_repeated_keys)
    except json.JSONDecodeError as error:
        lines = text.splitlines()
        line = lines[error.lineno - 1] if error.lineno <= len(lines) else None
        place = Location(file, error.lineno, error.colno, error.colno + 1, line)
        sink.report("SC701", f"this is not JSON: {error.msg}", place)
    except RepeatedKeyError as error:
        sink.report("SC713", f"the key {error} stands twice in one object", Location(file))
    except RecursionError:
        sink.report("SC712", "the plan is nested too deeply", Location(file))
    except ValueError:  # an integer of more digits than Python reads
        sink.report("SC701", "the plan holds a number with thousands of digits", Location(file))
    return _UNPARSED


def _is_plan(data: object, sink: Sink, origin: Origin) -> TypeGuard[dict[str, Any]]:
    if not is_object(data) or "scenecc_plan" not in data:
        sink.report("SC702", "this is not a plan: it has no key `scenecc_plan`", origin)
        return False
    version: object = data["scenecc_plan"]
    if type(version) is int and version in (1, PLAN_VERSION):
        return True
    message = f"this plan has version {_format_version(version)}; versions 1 and {PLAN_VERSION} are read here"
    sink.report("SC702", message, origin.child("scenecc_plan"))
    return False


def _format_version(item: object) -> str:
    text = json.dumps(item)
    return text if len(text) <= 40 else text[:40] + "…"


@dataclass(frozen=True, slots=True)
class _RelativeFileResolver:
    """Finds relative uris only."""

    base: Path
    sink: Sink

    def resolve(self, uri: str, origin: Origin) -> Path | None:
        if "://" not in uri and "\0" not in uri:
            return self.base.absolute() / uri
        self.sink.report("SC711", f"nothing here can find `{uri[:200]}`", origin)
        return None
