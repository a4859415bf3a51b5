"""Plain data to the dataclasses of the plan, by the kinds of their fields."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics import Origin, Sink
from scenecc.diagnostics import Path as Keys
from scenecc.plan.articulation import ArticulationStructure, Joint, Link, Mimic
from scenecc.plan.body import BodyStructure, CollisionShape, VisualShape
from scenecc.plan.camera import Camera
from scenecc.plan.constraint import Constraint, Drive
from scenecc.plan.decode_links import articulation_faults, axis_faults, joint_faults, link_faults, structure_faults
from scenecc.plan.decode_mounts import mount_faults, name_faults
from scenecc.plan.decode_numbers import Fault, is_list, is_object, read_number, read_rows, shown
from scenecc.plan.decode_scenes import check_materials, check_pick, object_count, read_selection
from scenecc.plan.fields import (
    Choice,
    Draws,
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
from scenecc.plan.light import Environment, Light
from scenecc.plan.material import AssetFile
from scenecc.plan.physics import Physics
from scenecc.plan.scene import Entity, ScenePlan
from scenecc.plan.value import Value, recalled

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.plan.recipe_shape import Shape
    from scenecc.variation.nodes import Node as RecipeNode

BAD: Final = object()
"""What a reader returns for data that it has reported."""

_WITH_ORIGIN = {
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
}
_IN_SCENES = {Entity, Constraint, Light, Camera}
"""What says in which scenes it is; an environment has a row for every scene."""

_RULES: Final[dict[type, Callable[[dict[str, Any]], Iterator[Fault]]]] = {
    Entity: structure_faults,
    ArticulationStructure: articulation_faults,
    Link: link_faults,
    Joint: joint_faults,
    Drive: axis_faults,
}
"""Rules over several fields of one object, once each of them is read."""

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
        self._draws: list[tuple[str, RecipeNode]] = []
        self._draw_shapes: dict[str, Shape] = {}
        self._draws_hold = True
        self._entity: dict[str, Any] = {}
        """What is being read; its scenes are counted before its shapes are read."""

    def plan(self, data: dict[str, Any]) -> object:
        """The plan, or `BAD`."""
        for table in ("files", "physical_materials", "visual_materials"):
            items = data.get(table)
            self._table_sizes[table] = len(items) if is_list(items) else 0
        num_scenes = data.get("num_scenes")
        if type(num_scenes) is int and num_scenes > self._scene_limit:
            message = f"`num_scenes` is {num_scenes}, more than {self._scene_limit}"
            return self._fault("SC712", message, ("num_scenes",))
        self._num_scenes = num_scenes if type(num_scenes) is int and num_scenes > 0 else None
        self._read_draws(data.get("draws", {}))
        plan = self._node(ScenePlan, data, ())
        if self._told(name_faults(data), ()) or not isinstance(plan, ScenePlan) or self._told(mount_faults(plan), ()):
            return BAD
        wrong = check_materials(plan)
        return plan if wrong is None else self._fault(wrong[0].code, wrong[0].message, wrong[1])

    def _told(self, faults: Iterator[Fault], path: Keys) -> bool:
        """Whether there are any."""
        return bool([self._fault(fault.code, fault.message, (*path, *fault.keys)) for fault in faults])

    def _read_draws(self, data: object) -> None:
        """Ahead of all else, since recipes name them; each may read those before it."""
        for name, item in data.items() if is_object(data) else ():
            read = _recipe(item, self._draw_shapes)
            if isinstance(read, Fault):
                self._draws_hold = False
                self._fault(read.code, read.message, ("draws", name[:80], *read.keys))
                # What reads it is not told to be wrong, too.
                self._draw_shapes[name] = None
            else:
                node, self._draw_shapes[name] = read
                self._draws.append((name, node))

    def _read(self, kind: Kind, data: object, path: Keys) -> object:
        read: object
        match kind:
            case Quantity():
                read = self._value(kind, data, path)
            case Plain():
                read = self._plain(kind, data, path)
            case Choice():
                read = self._choice(kind, data, path)
            case Numbers():
                rows = self._rows(Quantity(shape=(kind.count,), bounds=kind.bounds), [data], path, in_list=False)
                read = tuple(rows.data[0].tolist()) if isinstance(rows, Value) else rows
            case Selection():
                read = self._selection(data, path)
            case Draws() if is_object(data):
                read = tuple(self._draws) if self._draws_hold else BAD
            case Draws():
                read = self._fault("SC705", f"an object is wanted here, not {shown(data)}", path)
            case Many():
                read = self._many(kind, data, path)
            case Node():
                read = self._node(kind.cls, data, path)
            case OneOf():
                read = self._one_of(kind, data, path)
        return read

    def _choice(self, kind: Choice, data: object, path: Keys) -> object:
        if data in kind.options:
            return data
        words = ", ".join(f'"{option}"' for option in kind.options)
        return self._fault("SC705", f"{shown(data)} is none of {words}", path)

    def _many(self, kind: Many, data: object, path: Keys) -> object:
        if not is_list(data):
            return self._fault("SC705", f"a list is wanted here, not {shown(data)}", path)
        items = [self._read(kind.item, item, (*path, index)) for index, item in enumerate(data)]
        return BAD if any(item is BAD for item in items) else tuple(items)

    def _node(self, cls: type, data: object, path: Keys) -> object:
        if not is_object(data):
            return self._fault("SC705", f"an object is wanted here, not {shown(data)}", path)
        if cls in _IN_SCENES:
            self._entity = data
        elif cls is Environment:
            self._row_count = self._num_scenes
        its_slots = slots(cls)
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
        if cls in _IN_SCENES or cls is Environment:
            self._row_count = None
        if unknown or any(item is BAD for item in read.values()):
            return BAD
        return self._made(cls, read, path)

    def _made(self, cls: type, read: dict[str, Any], path: Keys) -> object:
        if cls is AssetFile:
            found = self._resolve(read["uri"], self._origin((*path, "uri")))
            return BAD if found is None else AssetFile(path=found, **read)
        if cls in _RULES and self._told(_RULES[cls](read), path):
            return BAD
        if cls is Entity and not self._pick_holds(read, path):
            return BAD
        if cls in _WITH_ORIGIN:
            read["origin"] = self._origin(path)
        return cls(**read)

    def _pick_holds(self, read: dict[str, Any], path: Keys) -> bool:
        pick = read.get("pick")
        fault = None if pick is None else check_pick(pick, len(read["structures"]))
        if pick is None or fault is None:
            return True
        where = ("per_scene", *fault.keys) if pick.varies else ()
        return self._fault(fault.code, fault.message, (*path, "pick", *where)) is not BAD

    def _one_of(self, kind: OneOf, data: object, path: Keys) -> object:
        if not is_object(data):
            return self._fault("SC705", f"an object is wanted here, not {shown(data)}", path)
        by_type = dict(kind.by_type)
        if "type" not in data and kind.untyped is not None:
            return self._node(kind.untyped, data, path)
        if "type" not in data:
            return self._fault("SC704", "the key `type` is missing", path)
        name = data["type"]
        if not isinstance(name, str) or name not in by_type:
            words = ", ".join(f'"{word}"' for word in by_type)
            return self._fault("SC705", f"{shown(name)} is none of {words}", (*path, "type"))
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
        read = _recipe(recipe, self._draw_shapes, kind.shape)
        if isinstance(read, Fault):
            return self._fault(read.code, read.message, (*path, *read.keys))
        return recalled(value.data, read[0]) if isinstance(value, Value) else BAD

    def _rows(self, kind: Quantity, rows: list[Any], path: Keys, *, in_list: bool) -> object:
        size = self._table_sizes[kind.table] if kind.table is not None else None
        read = read_rows(kind, rows, size)
        if not isinstance(read, Fault):
            return read
        return self._fault(read.code, read.message, (*path, *(read.keys if in_list else read.keys[1:])))

    def _plain(self, kind: Plain, data: object, path: Keys) -> object:
        if kind.type is str or kind.type is bool:
            if type(data) is not kind.type:
                word = "a string" if kind.type is str else "true or false"
                return self._fault("SC705", f"{word} is wanted here, not {shown(data)}", path)
            if isinstance(data, str) and len(data) > _LONGEST_STRING:
                return self._fault("SC712", f"this string has {len(data)} characters", path)
            return data
        read = read_number(kind, data)
        return self._fault(read.code, read.message, path) if isinstance(read, Fault) else read

    def _selection(self, data: object, path: Keys) -> object:
        found = read_selection(data, self._num_scenes if self._num_scenes is not None else self._scene_limit)
        if isinstance(found, Fault):
            return self._fault(found.code, found.message, path)
        self._row_count = len(found)
        before = self._object_count
        self._object_count += object_count(self._entity, len(found))
        if self._object_count > self._object_limit:
            # What comes after is counted, and no tuple made of it.
            if before <= self._object_limit:
                message = f"objects summed over their scenes are more than {self._object_limit}"
                self._fault("SC712", message, path)
            return BAD
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
        near = difflib.get_close_matches(key[:80], known, n=1)
        hint = f"did you mean `{near[0]}`?" if near else None
        self._sink.report("SC703", f"unknown key {shown(key)}", self._origin((*path, key[:80])), at="key", hint=hint)

    def _origin(self, path: Keys) -> Origin:
        return Origin(self._file, path)

    def _fault(self, code: str, message: str, path: Keys) -> object:
        self._sink.report(code, message, self._origin(path))
        return BAD


def _recipe(data: object, draws: dict[str, Shape], shape: Shape = None) -> tuple[RecipeNode, Shape] | Fault:
    from scenecc.plan.decode_recipe import read_recipe  # noqa: PLC0415 - most plans have no recipes

    return read_recipe(data, draws, shape)
