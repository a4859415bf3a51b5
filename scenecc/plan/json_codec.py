"""Writer and reader of a plan's JSON. Both dispatch on the kind of each field (`plan.schema`)."""

from __future__ import annotations

import json
import math
import re
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields, replace
from functools import cache
from hashlib import sha256
from itertools import chain, pairwise
from json.encoder import encode_basestring
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.diagnostic import Location, Origin, dotted
from scenecc.diagnostics.diagnostic import Path as Keys
from scenecc.files import keep_file
from scenecc.geometry.rotations import UNIT_TOLERANCE
from scenecc.plan.body import AssetFile, rebase_file
from scenecc.plan.consistency import FAULTS, PlanFormatError
from scenecc.plan.geometry import Heightfield, Heights
from scenecc.plan.properties import FLOAT32_MAX, Quantity
from scenecc.plan.rendering import Environment
from scenecc.plan.scene import ScenePlan
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
    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.plan.recipes import Shape
    from scenecc.variation.forms import Template
    from scenecc.variation.nodes import Node

PLAN_VERSION = 2
"""The value of a plan's `scenecc_plan` key. Version 1, without file hashes, can still be read."""

_MAX_INLINE_HEIGHTS = 10_000

_WIDTH = 100

_INDENT = "  "

_ESCAPED = re.compile("[\x80-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Lone surrogates, which UTF-8 cannot encode, and characters that break, reorder or control terminal lines."""


def plan_to_json(plan: ScenePlan, *, base: Path | None = None) -> str:
    """Writes a plan as JSON that `plan_from_json` reads back.

    Keys are in the order of the dataclasses. Fields that are None and origins are omitted. Floats are the shortest
    decimals that give the same float64. A quantity that is equal in every scene is a plain value, otherwise
    `{"per_scene": [...]}`. If a reset redraws it, its `recipe` is beside `per_scene` or `value`.
    Scene indices in equal steps are a slice, `"0:4"`. Terrain with more than 10 000 heights refers to a table at the
    end.

    Args:
        plan: the plan.
        base: folder of the JSON file. Relative URIs are rewritten to start there. None keeps the URIs and gives the
            canonical text.

    Raises:
        ValueError: a number in the plan is not finite.
    """
    if base is not None:
        plan = replace(plan, files=tuple(rebase_file(file, base) for file in plan.files))
    data = {"scenecc_plan": PLAN_VERSION, **_object_data(plan)}
    shapes = chain.from_iterable(
        (*body.collisions, *body.visuals) for entity in plan.entities for body in entity.bodies
    )
    terrain = [shape.geometry.heights for shape in shapes if isinstance(shape.geometry, Heightfield)]
    if tables := {_heights_name(heights): _rows_data(heights) for heights in terrain if _are_shared(heights)}:
        data["heights"] = tables
    members = [f"{encode_basestring(key)}: {_text(item, 2 * _INDENT)}" for key, item in data.items()]
    text = "{\n" + _INDENT + f",\n{_INDENT}".join(members) + "\n}\n"
    return text if text.isascii() else _ESCAPED.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def _object_data(node: object) -> dict[str, Any]:
    data: dict[str, Any] = {}
    for slot in plan_fields(node.__class__):
        item = getattr(node, slot.name)
        if item is not None and (item or not slot.is_omitted_if_empty):
            data[slot.name] = _WRITERS[slot.kind.__class__](slot.kind, item)
    return data


def _scalar_data(kind: ScalarKind, item: Any) -> Any:
    # The field's type decides: a plan with the integer 1 equals one with 1.0, and -0.0 equals 0.0.
    return _check_finite(item + 0.0) if kind.type is float else int(item) if kind.type is int else item


def _union_data(kind: UnionKind, item: Any) -> dict[str, Any]:
    named = {} if item.__class__ is kind.untyped else {"type": type_name(item.__class__)}
    return named | _object_data(item)


def _list_data(kind: ListKind, item: Any) -> Any:
    if isinstance(kind.item, ListKind):
        return _heights_name(item) if _are_shared(item) else _rows_data(item)
    return [_WRITERS[kind.item.__class__](kind.item, one) for one in item]


def _value_data(kind: Quantity, value: Value) -> Any:
    data = value.data.tolist()
    if not kind.infinite and not math.isfinite(value.data.sum()) and not np.isfinite(value.data).all():
        _check_finite(math.nan)
    if not value.varies and value.recipe is None:
        return data[0]
    written = {"per_scene": data} if value.varies else {"value": data[0]}
    return written if value.recipe is None else {**written, "recipe": _recipe_data(value.recipe)}


def _recipe_data(node: Node) -> dict[str, Any]:
    from scenecc.plan.recipes import recipe_to_data  # noqa: PLC0415 - most plans have no recipes

    return recipe_to_data(node)


def _template_data(_: TemplateKind, template: Template) -> dict[str, Any]:
    from scenecc.plan.recipes import template_to_data  # noqa: PLC0415 - few plans have any

    return template_to_data(template)


def _check_finite(number: float) -> float:
    if not math.isfinite(number):
        raise ValueError("a number of the plan is not finite, and not JSON compliant")
    return number


def _are_shared(heights: Heights) -> bool:
    """Whether heights are stored in a shared table of the JSON."""
    return sum(map(len, heights)) > _MAX_INLINE_HEIGHTS


def _heights_name(heights: Heights) -> str:
    return sha256((np.array(heights, np.float64) + 0.0).tobytes()).hexdigest()


def _rows_data(heights: Heights) -> list[list[float]]:
    return [[_check_finite(number + 0.0) for number in row] for row in heights]


def _selection_data(_: SceneSelectionKind, scene_idxs: tuple[int, ...]) -> str | list[int]:
    count, first, last = len(scene_idxs), scene_idxs[0], scene_idxs[-1]
    # Indices ascend without repetition. Comparing the ends avoids a range of 4096 scenes for each of 10 000 entities.
    if count > 1 and last - first == count - 1:
        return f"{first}:{last + 1}"
    step = scene_idxs[1] - first if count > 2 else 0
    if step and scene_idxs == tuple(range(first, last + 1, step)):
        return f"{first}:{last + 1}:{step}"
    return list(map(int, scene_idxs))


_WRITERS: Final[dict[type, Callable[[Any, Any], Any]]] = {
    Quantity: _value_data,
    ScalarKind: _scalar_data,
    ChoiceKind: lambda _, item: item,
    BytesKind: lambda _, item: b64encode(item).decode("ascii"),
    VectorKind: lambda _, item: [_check_finite(number + 0.0) for number in item],
    SceneSelectionKind: _selection_data,
    ListKind: _list_data,
    ObjectKind: lambda _, item: _object_data(item),
    UnionKind: _union_data,
    SharedDrawsKind: lambda _, item: {name: _recipe_data(node) for name, node in item},
    TemplateKind: _template_data,
}


def _text(data: Any, indent: str) -> str:
    """Formats plain data as JSON at an indent: on one line if it fits, otherwise one item per line."""
    inner = indent + _INDENT
    if data.__class__ is dict:
        parts = [f"{encode_basestring(key)}: {_text(item, inner)}" for key, item in data.items()]
        return _join("{}", parts, indent)
    if data.__class__ is str:
        return encode_basestring(data)
    if data.__class__ is not list:
        return _dumps(data)
    if _are_numbers(data):
        return _break_array(_dumps(data), ", ", indent)
    if {*map(type, data)} == {list} and _are_numbers(chain.from_iterable(data)):
        return _break_array(_dumps(data), "], [", indent)
    return _join("[]", [_text(one, inner) for one in data], indent)


def _are_numbers(items: Iterable[Any]) -> bool:
    return {dict, list, str}.isdisjoint(map(type, items))


def _break_array(text: str, between: str, indent: str) -> str:
    if len(text) + len(indent) <= _WIDTH:
        return text
    items = text[1:-1].replace(between, between.replace(" ", f"\n{indent}"))
    return f"[\n{indent}{items}\n{indent[: -len(_INDENT)]}]"


def _join(brackets: str, parts: list[str], indent: str) -> str:
    line = ", ".join(parts)
    if len(line) + len(indent) <= _WIDTH and "\n" not in line:
        return f"{brackets[0]}{line}{brackets[1]}"
    broken = f",\n{indent}".join(parts)
    return f"{brackets[0]}\n{indent}{broken}\n{indent[: -len(_INDENT)]}{brackets[1]}"


def _dumps(data: Any) -> str:
    # JSON has no infinity, but readers parse a number too large for a float64 as infinity.
    return _encode(data).replace("Infinity", "1e999")


_encode: Final = json.JSONEncoder().encode


class _Decoder:
    """Reads one plan. Raises `PlanFormatError` at the first missing or invalid value."""

    def __init__(self, file: str | None, limits: Limits, resolve: Resolver) -> None:
        self._file = file
        self._limits = limits
        self._resolve = resolve
        self._table_sizes: dict[str, int] = {}
        self._num_scenes = 0
        self._row_count = 0
        """Number of scenes of the object being read; 0 if it has no scenes of its own, such as a material."""
        self._selections: dict[str, tuple[int, ...]] = {}
        self._scene_count = 0
        self._heights: dict[str, Heights] = {}
        self._draws: dict[str, Node] = {}
        self._draw_shapes: dict[str, Shape] = {}
        self._readers: dict[type, Callable[[Any, Any, Keys], Any]] = {
            Quantity: self._value,
            ScalarKind: self._scalar,
            ChoiceKind: self._choice,
            BytesKind: self._bytes,
            VectorKind: self._vector,
            SceneSelectionKind: self._selection,
            ListKind: self._list,
            ObjectKind: lambda kind, data, path: self._object(kind.cls, data, path),
            UnionKind: self._union,
            SharedDrawsKind: lambda _kind, _data, _path: tuple(self._draws.items()),
            TemplateKind: self._template,
        }

    def plan(self, data: dict[str, Any]) -> ScenePlan:
        """Reads a plan. Tables that other objects refer to are read first."""
        self._num_scenes = self._scalar(ScalarKind(int), data.get("num_scenes"), ("num_scenes",))
        if self._num_scenes > self._limits.scenes:
            raise _StopError(
                "SC712", f"`num_scenes` is {self._num_scenes}, more than {self._limits.scenes}", Location(self._file)
            )
        for table in ("files", "physical_materials", "visual_materials"):
            self._table_sizes[table] = len(_check_type(data.get(table, []), list, (table,)))
        for name, item in _check_type(data.get("draws", {}), dict, ("draws",)).items():
            path: Keys = ("draws", name)
            self._draws[name], self._draw_shapes[name] = _read_recipe(item, self._draw_shapes, path)
        for name, rows in _check_type(data.pop("heights", {}), dict, ("heights",)).items():
            self._heights[name] = _read_heights(rows, ("heights", name))
        return self._object(ScenePlan, data, ())

    def _read(self, kind: FieldKind, data: Any, path: Keys) -> Any:
        return self._readers[kind.__class__](kind, data, path)

    def _object(self, cls: type, data: Any, path: Keys) -> Any:
        _check_type(data, dict, path)
        rows_around, values = self._row_count, dict[str, Any]()
        if cls is Environment:
            self._row_count = self._num_scenes
        # In the order of the dataclass: `scene_idxs` comes before the values and gives their row count.
        for slot in plan_fields(cls):
            if slot.name in data:
                values[slot.name] = self._read(slot.kind, data[slot.name], (*path, slot.name))
            elif slot.required:
                raise PlanFormatError((*path, slot.name))
        self._row_count = rows_around
        if len(values) < len(data):
            raise PlanFormatError((*path, next(key for key in data if key not in values)))
        if _has_origin(cls):
            values["origin"] = Origin(self._file, path)
        made = cls(**values, path=self._file_path(values, path)) if cls is AssetFile else cls(**values)
        if cls in FAULTS:
            for keys in FAULTS[cls](made):
                raise PlanFormatError((*path, *keys))
        return made

    def _file_path(self, values: dict[str, Any], path: Keys) -> Path:
        """The path of a file. A file whose content is in the plan is written to the user's cache."""
        uri, data, origin = values["uri"], values.get("data"), Origin(self._file, (*path, "uri"))
        if data is None:
            found = self._resolve(uri, origin)
            if found is None:
                raise _StopError
            return found
        if not _DATA_URI.fullmatch(uri):
            raise PlanFormatError((*path, "uri"))
        try:
            return keep_file("meshes", data, ".ply")
        except OSError as error:
            raise _StopError("SC711", f"'{uri}' cannot be kept in the cache folder: {error}", origin) from error

    def _union(self, kind: UnionKind, data: Any, path: Keys) -> Any:
        name = _check_type(data, dict, path).get("type")
        if "type" not in data and kind.untyped is not None:
            return self._object(kind.untyped, data, path)
        for word, cls in kind.by_type:
            if word == name:
                return self._object(cls, {key: item for key, item in data.items() if key != "type"}, path)
        raise PlanFormatError((*path, "type"))

    def _list(self, kind: ListKind, data: Any, path: Keys) -> tuple[Any, ...]:
        if isinstance(kind.item, ListKind):
            return self._heights[data] if isinstance(data, str) and data in self._heights else _read_heights(data, path)
        return tuple([self._read(kind.item, one, (*path, i)) for i, one in enumerate(_check_type(data, list, path))])

    def _scalar(self, kind: ScalarKind, data: Any, path: Keys) -> Any:
        if kind.type is float and data.__class__ is int and abs(data) <= FLOAT32_MAX:
            data = float(data)
        _check_type(data, kind.type, path)
        if data.__class__ in {int, float} and not (math.isfinite(data) and kind.bounds.allow(data)):
            raise PlanFormatError(path)
        return data

    def _choice(self, kind: ChoiceKind, data: Any, path: Keys) -> str:
        if data not in kind.options:
            raise PlanFormatError(path)
        return data

    def _bytes(self, _kind: BytesKind, data: Any, path: Keys) -> bytes:
        try:
            return b64decode(_check_type(data, str, path), validate=True)
        except ValueError:  # not base64
            raise PlanFormatError(path) from None

    def _vector(self, kind: VectorKind, data: Any, path: Keys) -> tuple[float, ...]:
        if len(_check_type(data, list, path)) != kind.count:
            raise PlanFormatError(path)
        return tuple([self._scalar(ScalarKind(float, kind.bounds), one, (*path, i)) for i, one in enumerate(data)])

    def _template(self, _kind: TemplateKind, data: Any, path: Keys) -> Any:
        from scenecc.plan.recipes import RecipeReader  # noqa: PLC0415 - few plans have any

        return RecipeReader(()).template(data, path, 0)

    def _selection(self, _kind: SceneSelectionKind, data: Any, path: Keys) -> tuple[int, ...]:
        found = self._selections.get(data) if isinstance(data, str) else None
        idxs = _read_selection(data, path) if found is None else found
        if not (idxs and idxs[0] >= 0 and idxs[-1] < self._num_scenes):
            raise PlanFormatError(path)
        self._row_count = len(idxs)
        self._scene_count += len(idxs)
        if self._scene_count > self._limits.objects_in_all_scenes:
            raise _StopError(
                "SC712",
                f"objects summed over their scenes are more than {self._limits.objects_in_all_scenes}",
                Location(self._file),
            )
        # Entities share the tuple of a slice: 10 000 entities in 4096 scenes have 40 million indices.
        return self._selections.setdefault(data, tuple(idxs)) if isinstance(data, str) else tuple(idxs)

    def _value(self, kind: Quantity, data: Any, path: Keys) -> Value:
        if data.__class__ is not dict:
            return Value(self._rows(kind, [data], path))
        recipe: Any = data.get("recipe")
        if data.keys() - {"recipe"} == {"per_scene"}:
            rows = _check_type(data["per_scene"], list, path)
            if len(rows) != (self._row_count or len(rows)):
                raise PlanFormatError((*path, "per_scene"))
        elif data.keys() == {"value", "recipe"}:
            rows = [data["value"]]
        else:
            raise PlanFormatError(path)
        read = self._rows(kind, rows, path)
        if "recipe" not in data:
            return Value(read)
        path = (*path, "recipe")
        node, shape = _read_recipe(recipe, self._draw_shapes, path)
        if not kind.reset or shape not in (None, kind.shape):
            raise PlanFormatError(path)
        return recalled(read, node)

    def _rows(self, kind: Quantity, rows: list[Any], path: Keys) -> NDArray[Any]:
        try:
            types = set(map(type, chain.from_iterable(rows) if kind.shape else rows))
            data = np.array(rows, dtype=kind.dtype) if types <= _JSON_TYPES[kind.dtype] else None
        except (TypeError, ValueError, OverflowError):  # not lists, lists of unequal length, more than 64 bits
            data = None
        size = None if kind.table is None else self._table_sizes[kind.table]
        if not rows or data is None or data.shape[1:] != kind.shape or not _is_in_range(kind, data, size):
            raise PlanFormatError(path)
        data.flags.writeable = False
        return data


_DATA_URI = re.compile(r"mesh://[A-Za-z0-9_.-]{0,80}\.ply")

_SLICE = re.compile(r"(\d{1,9}):(\d{1,9})(?::([1-9]\d{0,8}))?")

_JSON_TYPES: Final = {"float64": {float, int}, "int64": {int}, "bool": {bool}}


class _StopError(Exception):
    """A file is missing or a limit is exceeded. Arguments are those of `Sink.report`; empty if already reported."""


def _check_type(data: Any, cls: type, path: Keys) -> Any:
    """Returns the data if they have exactly this type."""
    if data.__class__ is not cls:
        raise PlanFormatError(path)
    return data


@cache
def _has_origin(cls: type[Any]) -> bool:
    return any(item.name == "origin" for item in fields(cls))


def _read_heights(data: Any, path: Keys) -> Heights:
    rows = [_check_type(row, list, path) for row in _check_type(data, list, path)]
    for row in rows:
        if not {*map(type, row)} <= {int, float} or not all(-FLOAT32_MAX <= number <= FLOAT32_MAX for number in row):
            raise PlanFormatError(path)
    return tuple(tuple(map(float, row)) for row in rows)


def _read_selection(data: Any, path: Keys) -> Sequence[int]:
    """Reads ascending scene indices."""
    if isinstance(data, str):
        match = _SLICE.fullmatch(data)
        if match is None:
            raise PlanFormatError(path)
        return range(int(match[1]), int(match[2]), int(match[3] or 1))
    if not {*map(type, _check_type(data, list, path))} <= {int} or any(a >= b for a, b in pairwise(data)):
        raise PlanFormatError(path)
    return data


def _is_in_range(kind: Quantity, data: NDArray[Any], table_size: int | None) -> bool:
    if kind.dtype == "bool":
        return True
    if table_size is not None:
        return bool(((data >= 0) & (data < table_size)).all())
    low, high, nonzero = kind.bounds
    if not ((data >= low) & (data <= high)).all() or (nonzero and not data.all()):
        return False
    if kind.infinite:
        first, last = data[:, 0], data[:, 1]
        finite = data[np.isfinite(data)]
        return bool((first <= last).all() and (first < np.inf).all() and (last > -np.inf).all()) and bool(
            (np.abs(finite) <= FLOAT32_MAX).all()
        )
    if not kind.pose:
        return True
    # The rotation is a product of several, so rounding errors add up.
    with np.errstate(over="ignore"):
        lengths = np.sqrt((data[:, 3:] ** 2).sum(axis=1))
    return bool((np.abs(lengths - 1) <= UNIT_TOLERANCE).all())


def _read_recipe(data: Any, draws: dict[str, Shape], path: Keys) -> tuple[Node, Shape]:
    from scenecc.plan.recipes import read_recipe  # noqa: PLC0415 - most plans have no recipes

    return read_recipe(data, draws, path)


Resolver = Callable[[str, Origin], Path | None]
"""Finds the file of a URI. Reports an error and returns None if there is no file."""

_HINT: Final = "make the plan again from its scene: `scenecc emit SCENE --to json -o PLAN.json`"


def plan_from_json(
    text: str,
    *,
    base: Path,
    sink: Sink,
    resolve: Resolver | None = None,
    file: str | None = None,
    limits: Limits | None = None,
) -> ScenePlan | None:
    """Reads the output of `plan_to_json`. Returns None after an error, which is in `sink`.

    A text that is not a plan of this version gives the error SC701. Physics rules (friction order, triangle inequality
    of an inertia) are checked later, on the plan. Only `resolve` checks whether files exist.

    Args:
        text: the JSON.
        base: folder where relative URIs start.
        sink: receives the error.
        resolve: called for the URI of each file. None joins relative URIs to `base` and rejects all others.
        file: name of the document, for diagnostics and origins.
        limits: None uses the defaults.
    """
    try:
        return _read_plan(text, file, limits or Limits(), resolve or _make_resolver(base, sink))
    except PlanFormatError as error:
        keys = tuple(key[:80] if isinstance(key, str) else key for key in error.keys)
        message = f"this is not a plan of this version of scenecc: {_describe_fault(keys)}"
        sink.report("SC701", message, Origin(file, keys), hint=_HINT)
    except _StopError as error:
        if error.args:
            sink.report(*error.args)
    return None


def _read_plan(text: str, file: str | None, limits: Limits, resolve: Resolver) -> ScenePlan:
    if len(text) > limits.text_bytes:
        raise _StopError("SC712", f"the plan has {len(text)} characters, more than {limits.text_bytes}", Location(file))
    data = _check_type(_parse_json(text), dict, ())
    version: Keys = ("scenecc_plan",)
    if _check_type(data.pop("scenecc_plan", None), int, version) not in (1, PLAN_VERSION):
        raise PlanFormatError(version)
    return _Decoder(file, limits, resolve).plan(data)


def _parse_json(text: str) -> Any:
    """Parses JSON. Returns None if the text is invalid, nested too deeply or has an integer of thousands of digits."""
    try:
        return json.loads(text.removeprefix("\ufeff"))
    except (ValueError, RecursionError):
        return None


def _describe_fault(keys: Keys) -> str:
    if keys == ("scenecc_plan",):
        return f"`scenecc_plan` is not 1 or {PLAN_VERSION}"
    return f"`{dotted(keys)}` is missing or invalid" if keys else "it is not an object of valid JSON"


def _make_resolver(base: Path, sink: Sink) -> Resolver:
    def resolve(uri: str, origin: Origin) -> Path | None:
        if "://" not in uri and "\0" not in uri:
            return base.absolute() / uri
        sink.report("SC711", f"nothing here can find `{uri[:200]}`", origin)
        return None

    return resolve
