"""Plain data to the dataclasses of the plan, by the kinds of their fields."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

from scenecc.diagnostics import Origin, Sink
from scenecc.diagnostics import Path as Keys
from scenecc.plan.decode_numbers import Fault, read_number, read_rows
from scenecc.plan.fields import (
    Choice,
    Kind,
    Many,
    Node,
    Numbers,
    OneOf,
    Plain,
    Quantity,
    Selection,
    slots,
)
from scenecc.plan.material import AssetFile
from scenecc.plan.scene import Entity, ScenePlan

BAD: Final = object()
"""What a reader returns for data that it has reported."""

_SLICE = re.compile(r"(\d{1,9}):(\d{1,9})(?::(\d{1,9}))?")
_LONGEST_STRING = 100_000


class Decoder:
    """Reads one plan. A fault is reported and the rest is read on."""

    def __init__(
        self,
        sink: Sink,
        file: str | None,
        scene_limit: int,
        object_limit: int,
        resolve: Callable[[str, Origin], Path | None],
    ) -> None:
        self._sink = sink
        self._file = file
        self._scene_limit = scene_limit
        self._object_limit = object_limit
        self._resolve = resolve
        self._table_sizes: dict[str, int] = {}
        self._num_scenes: int | None = None
        self._row_count: int | None = None
        self._selections: dict[str, tuple[int, ...]] = {}
        self._object_count = 0

    def plan(self, data: dict[str, Any]) -> object:
        """The plan, or `BAD`."""
        for table in ("files", "physical_materials", "visual_materials"):
            items = data.get(table)
            self._table_sizes[table] = len(items) if isinstance(items, list) else 0
        num_scenes = data.get("num_scenes")
        if type(num_scenes) is int and num_scenes > self._scene_limit:
            message = f"`num_scenes` is {num_scenes}, more than {self._scene_limit}"
            return self._fault("SC712", message, ("num_scenes",))
        self._num_scenes = num_scenes if type(num_scenes) is int and num_scenes > 0 else None
        plan = self._node(ScenePlan, data, ())
        names: dict[str, int] = {}
        entities: Any = data.get("entities")
        for index, entity in enumerate(entities if isinstance(entities, list) else ()):
            name = entity.get("name") if isinstance(entity, dict) else None
            if isinstance(name, str) and names.setdefault(name, index) != index:
                message = f"the name {_shown(name)} stands twice: entities {names[name]} and {index}"
                plan = self._fault("SC710", message, ("entities", index, "name"))
        return plan

    def _read(self, kind: Kind, data: Any, path: Keys) -> object:
        match kind:
            case Quantity():
                return self._value(kind, data, path)
            case Plain():
                return self._plain(kind, data, path)
            case Choice():
                if data in kind.options:
                    return data
                words = ", ".join(f'"{option}"' for option in kind.options)
                return self._fault("SC705", f"{_shown(data)} is none of {words}", path)
            case Numbers():
                rows = self._rows(Quantity(shape=(kind.count,), bounds=kind.bounds), [data], path, in_list=False)
                return BAD if rows is BAD else tuple(rows.data[0].tolist())
            case Selection():
                return self._selection(data, path)
            case Many():
                if not isinstance(data, list):
                    return self._fault("SC705", f"a list is wanted here, not {_shown(data)}", path)
                items = [self._read(kind.item, item, (*path, index)) for index, item in enumerate(data)]
                return BAD if any(item is BAD for item in items) else tuple(items)
            case Node():
                return self._node(kind.cls, data, path)
            case OneOf():
                return self._one_of(kind, data, path)

    def _node(self, cls: type, data: Any, path: Keys) -> object:
        if not isinstance(data, dict):
            return self._fault("SC705", f"an object is wanted here, not {_shown(data)}", path)
        if cls is Entity:
            self._row_count = None
        its_slots = slots(cls)
        unknown = data.keys() - {slot.name for slot in its_slots}
        for key in sorted(unknown):
            self._unknown_key(key, [slot.name for slot in its_slots], path)
        read: dict[str, Any] = {}
        # An entity's scenes come first: they say how many rows its values have.
        for slot in sorted(its_slots, key=lambda slot: not isinstance(slot.kind, Selection)):
            if slot.name in data:
                read[slot.name] = self._read(slot.kind, data[slot.name], (*path, slot.name))
            elif slot.required:
                read[slot.name] = self._fault("SC704", f"the key `{slot.name}` is missing", path)
        if unknown or any(item is BAD for item in read.values()):
            return BAD
        return self._made(cls, read, path)

    def _made(self, cls: type, read: dict[str, Any], path: Keys) -> object:
        if cls is AssetFile:
            found = self._resolve(read["uri"], self._origin((*path, "uri")))
            return BAD if found is None else AssetFile(read["uri"], found)
        if cls is Entity and not self._entity_holds(read, path):
            return BAD
        if "origin" in {item.name for item in fields(cls)}:
            read["origin"] = self._origin(path)
        return cls(**read)

    def _entity_holds(self, read: dict[str, Any], path: Keys) -> bool:
        structures, pick = read["structures"], read.get("pick")
        if not structures:
            return self._fault("SC706", "an entity has one structure at least", (*path, "structures")) is not BAD
        if pick is None:
            return True
        if len(pick) != self._row_count:
            message = f"`pick` has {len(pick)} items, and the entity is in {self._row_count} scenes"
            return self._fault("SC706", message, (*path, "pick")) is not BAD
        for index, item in enumerate(pick):
            if item >= len(structures):
                message = f"there is no structure {item}: the entity has {len(structures)}"
                return self._fault("SC708", message, (*path, "pick", index)) is not BAD
        return True

    def _one_of(self, kind: OneOf, data: Any, path: Keys) -> object:
        if not isinstance(data, dict):
            return self._fault("SC705", f"an object is wanted here, not {_shown(data)}", path)
        by_type = dict(kind.by_type)
        if "type" not in data:
            return self._fault("SC704", "the key `type` is missing", path)
        name = data["type"]
        if not isinstance(name, str) or name not in by_type:
            words = ", ".join(f'"{word}"' for word in by_type)
            return self._fault("SC705", f"{_shown(name)} is none of {words}", (*path, "type"))
        return self._node(by_type[name], {key: item for key, item in data.items() if key != "type"}, path)

    def _value(self, kind: Quantity, data: Any, path: Keys) -> object:
        if not isinstance(data, dict):
            return self._rows(kind, [data], path, in_list=False)
        if set(data) != {"per_scene"} or not isinstance(data["per_scene"], list):
            message = 'a quantity is written plainly or as {"per_scene": [...]}'
            return self._fault("SC705", message, path)
        rows = data["per_scene"]
        if self._row_count is not None and len(rows) != self._row_count:
            message = f"`per_scene` has {len(rows)} rows, and the entity is in {self._row_count} scenes"
            return self._fault("SC706", message, (*path, "per_scene"))
        return self._rows(kind, rows, (*path, "per_scene"), in_list=True)

    def _rows(self, kind: Quantity, rows: list[Any], path: Keys, *, in_list: bool) -> Any:
        size = self._table_sizes[kind.table] if kind.table is not None else None
        read = read_rows(kind, rows, size)
        if not isinstance(read, Fault):
            return read
        return self._fault(read.code, read.message, (*path, *(read.keys if in_list else read.keys[1:])))

    def _plain(self, kind: Plain, data: Any, path: Keys) -> object:
        if kind.type is str or kind.type is bool:
            if type(data) is not kind.type:
                word = "a string" if kind.type is str else "true or false"
                return self._fault("SC705", f"{word} is wanted here, not {_shown(data)}", path)
            if kind.type is str and len(data) > _LONGEST_STRING:
                return self._fault("SC712", f"this string has {len(data)} characters", path)
            return data
        size = self._table_sizes[kind.table] if kind.table is not None else None
        read = read_number(kind, data, size)
        return self._fault(read.code, read.message, path) if isinstance(read, Fault) else read

    def _selection(self, data: Any, path: Keys) -> object:
        found = self._selected(data, path)
        self._row_count = len(found) if isinstance(found, tuple) else None
        if isinstance(found, tuple):
            self._object_count += len(found)
            if self._object_count > self._object_limit >= self._object_count - len(found):
                message = f"entities times their scenes are more than {self._object_limit}"
                return self._fault("SC712", message, path)
        return found

    def _selected(self, data: Any, path: Keys) -> object:
        if isinstance(data, str):
            return self._slice(data, path)
        if not isinstance(data, list) or not all(type(item) is int for item in data):
            return self._fault("SC705", 'a list of scene indices or a slice such as "0:8" is wanted here', path)
        limit = self._num_scenes if self._num_scenes is not None else self._scene_limit
        if not data:
            return self._fault("SC709", "the entity is in no scene", path)
        if any(a >= b for a, b in zip(data, data[1:], strict=False)):
            return self._fault("SC709", "scene indices ascend, without repetition", path)
        if data[0] < 0 or data[-1] >= limit:
            outside = data[0] if data[0] < 0 else data[-1]
            return self._fault("SC709", f"there is no scene {_shown(outside)}: there are {limit}", path)
        return tuple(data)

    def _slice(self, text: str, path: Keys) -> object:
        match = _SLICE.fullmatch(text)
        limit = self._num_scenes if self._num_scenes is not None else self._scene_limit
        if match is None:
            return self._fault("SC705", f'{_shown(text)} is no slice such as "0:8" or "0:8:2"', path)
        start, stop, step = int(match[1]), int(match[2]), int(match[3] or 1)
        if not step or not start < stop <= limit:
            return self._fault("SC709", f"{_shown(text)} selects no scenes out of {limit}", path)
        # Entities share the tuple: 10 000 of them in 4096 scenes are 40 million indices.
        return self._selections.setdefault(text, tuple(range(start, stop, step)))

    def _unknown_key(self, key: str, known: list[str], path: Keys) -> None:
        near = difflib.get_close_matches(key[:80], known, n=1)
        hint = f"did you mean `{near[0]}`?" if near else None
        self._sink.report("SC703", f"unknown key {_shown(key)}", self._origin((*path, key[:80])), at="key", hint=hint)

    def _origin(self, path: Keys) -> Origin:
        return Origin(self._file, path)

    def _fault(self, code: str, message: str, path: Keys) -> object:
        self._sink.report(code, message, self._origin(path))
        return BAD


def _shown(item: Any) -> str:
    if isinstance(item, dict):
        return "an object"
    if isinstance(item, list):
        return "a list"
    text = json.dumps(item)
    return text if len(text) <= 60 else text[:60] + "…"
