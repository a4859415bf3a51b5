"""Overrides: what the file that uses a prefab says of the objects inside it."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, show, suggest_name
from scenecc.expand.arguments import ABSOLUTE_PREFIX, map_alternatives
from scenecc.expand.documents import FailedValue, SceneDocument, count_objects
from scenecc.expand.expansion import ExpansionFrame, ExpansionWriter, OverridePlace, TraceRecord, scoped_name
from scenecc.expand.patterns import refuse_structure
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.nodes import TYPE, is_mapping, is_sequence
from scenecc.spec.references import SHARED_NAMESPACE, WORLD, qualified_name
from scenecc.variation.forms import FORM_KEYS, Template

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin, Path, RelatedPlace
    from scenecc.expand.module_compiler import NodeTemplate

REMOVE = "remove"
"""What stands in place of keys where the object is left out."""

OVERRIDE_SECTIONS = ("lights", "cameras", "constraints", "frames", "materials")
"""Sections whose names have the section's before them; what is in no section is among the entities."""

INSTANCE_KEYS = frozenset(("pose", "scene_idxs", "hidden", "with"))
"""What can be overridden of an instance itself."""


@dataclass(frozen=True, slots=True)
class Override:
    """What is said of one object.

    Attributes:
        value: a mapping, or `REMOVE`; names in it are full ones.
        record: where it is written.
        document: in which.
        scope: in which its names meant something.
    """

    value: Any
    record: TraceRecord
    document: SceneDocument
    scope: str

    def origin(self, *path: str) -> Origin:
        """Where a key of it is written; without one, its name."""
        return self.record.trace(path)


@dataclass(slots=True)
class InstanceOverrides:
    """The overrides of one instance.

    Attributes:
        instance: full name of it.
        prefix: before the names inside.
        entries: by the prefab's own names.
        inside: those names that there are, with section and full name of each.
    """

    instance: str
    prefix: str
    entries: dict[str, Override]
    inside: dict[str, tuple[str, str]] = field(default_factory=dict[str, tuple[str, str]])

    def find(self, section: str, full: str, sink: Sink) -> Override | None:
        """What is said of an object that was made inside; None for nothing.

        Args:
            section: of it; `use` for an instance.
            full: its full name; of a material its scope comes before its name.
            sink: takes the diagnostics.
        """
        name = full[len(self.instance) + 1 if section == "materials" else len(self.prefix) :]
        key = f"{section}/{name}" if section in OVERRIDE_SECTIONS else name
        found = self.entries.get(key)
        first, _ = self.inside.setdefault(key, (section, full))
        if found is not None and first != section:
            message = f"`{cut(key)}` names two objects inside the prefab, one in `{first}` and one in `{section}`"
            sink.report("SC243", message, found.origin(), at="key", hint="an override needs a unique name")
        return found

    def check(self, removed: Mapping[tuple[str, str], Origin], sink: Sink) -> None:
        """Reports names that do not exist inside, or that are inside an object in `removed`."""
        removals = [entry.origin() for entry in self.entries.values() if entry.value == REMOVE]
        for key, entry in self.entries.items():
            place = removed.get(self.inside[key]) if key in self.inside else None
            if place is not None and place != entry.origin() and place in removals:
                message = f"`{cut(key)}` is inside an object that is removed"
                sink.report("SC243", message, entry.origin(), at="key", related=[("removed here", place, "value")])
            elif key not in self.inside:
                message = f"nothing inside `{cut(self.instance)}` is called `{cut(key)}`"
                hint = suggest_name(key, self.inside, sink) if self.inside else "the prefab is empty"
                sink.report("SC243", message, entry.origin(), at="key", hint=hint)


def make_overrides(
    templates: Mapping[str, NodeTemplate], frame: ExpansionFrame, scope: str, prefix: str
) -> dict[str, Override]:
    """The overrides of one use of a prefab, with the values of the file that uses it.

    Args:
        templates: by name.
        frame: of the use.
        scope: of the file that uses it.
        prefix: before the names of its entities.
    """
    made: dict[str, Override] = {}
    for name, template in templates.items():
        frame.lists = {}
        value = template.make(frame)
        if not is_mapping(value) and value != REMOVE:
            message = f"`{cut(name)}` must be a mapping of keys, or `{REMOVE}`, not {show(value)}"
            refuse_structure(value, template.path, name, "SC103", message, frame)
            value = {}
        # Its names, and the shapes that it may put in place of fewer, count in each use.
        frame.objects.take(count_objects(value) - 1, frame, template.path)
        record = TraceRecord(frame.mark(template.path), frame.lists)
        made[name] = Override(_absolute(value, scope, prefix), record, template.part.document, scope)
    frame.lists = {}
    return made


_GROUP_KEY, _MATERIAL_KEY = "collision_group", "material"
_REFERENCE_KEYS = frozenset(("relative_to", "mount", "parent", "child", "on", "inside", "above", "facing", "region"))


def _absolute(value: Any, scope: str, prefix: str) -> Any:
    """A value whose names mean the same inside a prefab as in the scope in which they are written."""
    if isinstance(value, Template):
        return value.within(scope)
    if is_sequence(value):
        return [_absolute(item, scope, prefix) for item in value]
    if not is_mapping(value):
        return value
    return {key: _absolute_item(key, item, scope, prefix) for key, item in value.items()}


def _absolute_item(key: str, item: Any, scope: str, prefix: str) -> Any:
    if key == _MATERIAL_KEY:
        return map_alternatives(item, lambda one: _absolute_name(one, scope, prefix))
    if key == _GROUP_KEY:
        return _absolute_name(item, scope, prefix)
    if key in _REFERENCE_KEYS and isinstance(item, str):
        known = item == WORLD or isinstance(item, FailedValue)
        return item if known else f"{ABSOLUTE_PREFIX}{prefix}{item}"
    if key == "near" and is_mapping(item):
        return {f"{ABSOLUTE_PREFIX}{prefix}{name}": _absolute(one, scope, prefix) for name, one in item.items()}
    return item if key.startswith(NOTE_PREFIX) else _absolute(item, scope, prefix)


def _absolute_name(value: Any, scope: str, prefix: str) -> Any:
    """The name of a material or group. An expression that differs from scene to scene gives it within a text."""
    if isinstance(value, Template):
        return value.within(scope, ABSOLUTE_PREFIX + scoped_name(scope, value.text))
    if not isinstance(value, str):
        return _absolute(value, scope, prefix)
    known = isinstance(value, FailedValue) or value.startswith(ABSOLUTE_PREFIX)
    return value if known else ABSOLUTE_PREFIX + scoped_name(scope, value)


def says_world(value: Any) -> bool:
    """Whether an override names the world of its own file."""
    pose = value.get("pose")
    return value.get("parent") == WORLD or (is_mapping(pose) and pose.get("relative_to") == WORLD)


_REPLACED_KEYS = frozenset((_MATERIAL_KEY, "axis_angle", "scene_idxs"))
"""Keys whose mappings are one value."""

_PATTERN_KEYS = frozenset(("links", "joints", "drives"))
_NAME_KEYS = _PATTERN_KEYS | {"qpos", "qvel"}
"""Keys below which keys are names: none excludes another, and none is a form."""

_ITEM_COPY_KEYS = frozenset(("repeat", "if"))
"""Of shapes and links, which are repeated when overrides are merged."""

_EXCLUSIVE_KEYS = (
    ("mass", "inertial"),
    ("collision_group", "collision_bits"),
    ("limits", "limits_deg"),
    ("q", "rpy", "rpy_deg", "axis_angle", "look_at", "matrix", "yaw", "yaw_deg", "facing"),
    ("p", "matrix"),
    ("anchor", "matrix"),
    ("pose", "place"),
    ("pose", "joint"),
    ("on", "inside", "above"),
    ("at", "region"),
    ("fovy", "fovy_deg", "fovx", "fovx_deg", "intrinsic", "orthographic"),
    ("inner_fov", "inner_fov_deg"),
    ("outer_fov", "outer_fov_deg"),
    ("pose", "position"),
    ("pose", "direction"),
    ("origin", "pose_in_parent"),
    ("axis", "pose_in_child"),
    ("file", "heights"),
    ("urdf", "mjcf", "root"),
)
"""Keys of which a mapping has one."""

_EXCLUDED_BY: dict[str, frozenset[str]] = {}
for _keys in _EXCLUSIVE_KEYS:
    for _key in _keys:
        _EXCLUDED_BY[_key] = _EXCLUDED_BY.get(_key, frozenset()) | (frozenset(_keys) - {_key})


_TYPED_LISTS = {
    "shapes": ("shapes", "ShapeSpec"),
    "collisions": ("shapes", "CollisionSpec"),
    "visuals": ("shapes", "VisualSpec"),
}
_TYPED_SECTIONS = {"lights": ("rendering", "Light"), "constraints": ("constraint", "Constraint")}
"""Where `type` says which keys a mapping may have: the file of `scenecc.spec` and the union of its models."""


def _without_keys_of_other_types(node: Any, kind: Any, union: tuple[str, str] | None) -> Any:
    """A mapping without what one of another type cannot have. `kind`: the new type; None where it stays."""
    if union is None or not isinstance(kind, str) or kind == node.get(TYPE):
        return node
    module, name = union
    models: Any = getattr(import_module(f"scenecc.spec.{module}"), name).__metadata__[0]
    if kind not in models.types():
        return node
    known: Mapping[str, Any] = models.model(kind).model_fields
    return {key: item for key, item in node.items() if key in known}


class OverrideMerger:
    """Merges overrides into one object.

    Args:
        section: of the object.
        sink: takes the diagnostics.

    Attributes:
        places: as `TraceRecord.overrides` has them.
    """

    def __init__(self, section: str, sink: Sink) -> None:
        self._section = section
        self.places: dict[Path, OverridePlace] = {}
        self._count = 0
        self._sink = sink

    def merge(self, node: Any, override: Override) -> Any:
        """The object with what an override says. Nothing of `node` is changed."""
        self._count += 1
        kind = override.value.get(TYPE)
        node = _without_keys_of_other_types(node, kind, _TYPED_SECTIONS.get(self._section))
        return self._mapping(node, override.value, (), override.record, ())

    def _mapping(self, node: Any, given: Any, path: Path, record: TraceRecord, at: Path) -> Any:
        made: dict[str, Any] = dict(node)
        names = path[-1:] and path[-1] in _NAME_KEYS
        for key, item in given.items():
            if key.startswith(NOTE_PREFIX):
                continue
            below, written = (*path, key), (*at, key)
            if key in _ITEM_COPY_KEYS and isinstance(path[-1] if path else None, int):
                hint = "items of a list are overridden after `repeat`; give the whole list"
                self._sink.report("SC244", f"`{key}` cannot be overridden", record.trace(written), at="key", hint=hint)
                continue
            for other in () if names else _EXCLUDED_BY.get(key, frozenset()) & made.keys():
                del made[other]
                if other in given:
                    first: RelatedPlace = ("the first", record.trace((*at, other)), "key")
                    message = f"`{other}` and `{key}` exclude each other"
                    self._sink.report("SC111", message, record.trace(written), at="key", related=[first])
            if path[-1:] and path[-1] in _PATTERN_KEYS:
                self._pattern(made, key, item, path, record, written)
            else:
                made[key] = self._value(made.get(key), item, below, record, written)
        return made

    def _pattern(
        self, made: dict[str, Any], key: str, item: Any, path: Path, record: TraceRecord, written: Path
    ) -> None:
        """One pattern: it comes after all others, also where one of these is the same."""
        name = key
        while name in made and name != next(reversed(made)):
            name = f"(?:{name})"
        made[name] = self._value(made.get(name), item, (*path, name), record, written)

    def _value(self, node: Any, given: Any, path: Path, record: TraceRecord, at: Path) -> Any:
        if is_mapping(given) and path[-1] not in _REPLACED_KEYS:
            if is_mapping(node) and not (self._is_one_value(node, path) or self._is_one_value(given, path)):
                if path[-2:-1] and isinstance(path[-1], int):
                    node = _without_keys_of_other_types(node, given.get(TYPE), _TYPED_LISTS.get(str(path[-2])))
                return self._mapping(node, given, path, record, at)
            if is_sequence(node) and any(_is_index(key) for key in given):
                return self._items(node, given, path, record, at)
        self.places[path] = OverridePlace(record, at, self._count)
        return given

    @staticmethod
    def _is_one_value(node: dict[str, Any], path: Path) -> bool:
        return path[-1] not in _PATTERN_KEYS and not FORM_KEYS.isdisjoint(node)

    def _items(self, node: Any, given: Any, path: Path, record: TraceRecord, at: Path) -> list[Any]:
        made: list[Any] = list(node)
        for key, item in given.items():
            if key.startswith(NOTE_PREFIX):
                continue
            if not _is_index(key):
                message = f"`{cut(key)}` is not an item index like the other keys"
                hint = "items are counted from 0; or give the whole list"
                self._sink.report("SC243", message, record.trace((*at, key)), at="key", hint=hint)
                continue
            # No list has so many items that its index needs more digits.
            index = int(key) if len(key) < _MAX_DIGITS else len(made)
            if index >= len(made):
                message = f"there is no item {cut(key)}: the list has {len(made)}"
                hint = f"items are counted from 0, so the last is {len(made) - 1}" if made else "it is empty"
                self._sink.report("SC243", message, record.trace((*at, key)), at="key", hint=hint)
                continue
            made[index] = self._value(made[index], item, (*path, index), record, (*at, key))
        return made


def _is_index(key: str) -> bool:
    """Whether a key of an override is the number of an item in a list."""
    return key.isascii() and key.isdigit()


_MAX_DIGITS = 10


_OWNERS = (*SHARED_NAMESPACE, "constraints", "lights", "materials")
_LISTED = 10
"""How many of those that refer to something a message lists."""


def check_removals(output: ExpansionWriter, sink: Sink) -> None:
    """Reports each thing that was removed and that something else still refers to."""
    removed = {name: place for (section, name), place in output.removed.items() if section in SHARED_NAMESPACE}
    materials = {name: place for (section, name), place in output.removed.items() if section == "materials"}
    if not removed and not materials:
        return
    search = _ReferenceSearch(output, removed, materials)
    for section in _OWNERS:
        for name, node in output.sections[section].items():
            search.look(section, name, node)
    for (name, place), owners in search.found.items():
        shown = ", ".join(f"`{cut(owner)}`" for owner, _ in owners[:_LISTED])
        more = f" and {len(owners) - _LISTED} more" if len(owners) > _LISTED else ""
        message = f"`{cut(name)}` cannot be removed: {shown}{more} refer{'s' if len(owners) == 1 else ''} to it"
        related: list[RelatedPlace] = [("referred to here", origin, "value") for _, origin in owners[:_LISTED]]
        sink.report("SC245", message, place, hint="remove or override these objects too", related=related)


class _ReferenceSearch:
    """Looks for names of what was removed.

    Attributes:
        found: name and place of a removal → who refers to it, and where.
    """

    def __init__(self, output: ExpansionWriter, removed: dict[str, Origin], materials: dict[str, Origin]) -> None:
        self.found: dict[tuple[str, Origin], list[tuple[str, Origin]]] = {}
        self._output = output
        self._removed = removed
        self._materials = materials
        self._left = {name for section in SHARED_NAMESPACE for name in output.sections[section]}

    def look(self, section: str, owner: str, node: Any) -> None:
        """Looks through one named node."""
        if not is_mapping(node):
            return
        scope = self._output.names.scopes.get(qualified_name(section, owner), "")
        pose = node.get("pose")
        names: list[tuple[Path, Any]] = [((key,), node.get(key)) for key in ("mount", "parent", "child")]
        names.append((("pose", "relative_to"), pose.get("relative_to") if is_mapping(pose) else None))
        if is_mapping(place := node.get("place")):
            names += [(("place", key), place.get(key)) for key in ("on", "inside", "above", "facing", "relative_to")]
            names += [(("place", "near", name), name) for name in place.get("near") or ()]
        for path, written in names:
            if isinstance(written, str) and written != WORLD:
                self._take(self._output.names.full_name(written, scope), section, owner, path)
        for path, name in _materials_in(node, ()) if self._materials else ():
            full = name[1:] if name.startswith(ABSOLUTE_PREFIX) else scoped_name(scope, name)
            if full in self._materials:
                self._add(full, self._materials[full], section, owner, path)

    def _take(self, full: str, section: str, owner: str, path: Path) -> None:
        """A name, of which the end may be a link's: the longest is meant that is there, or was."""
        while full and full not in self._left:
            if full in self._removed:
                self._add(full, self._removed[full], section, owner, path)
                return
            full = full.rpartition("/")[0]

    def _add(self, name: str, place: Origin, section: str, owner: str, path: Path) -> None:
        self.found.setdefault((name, place), []).append((owner, self._output.trace(section, owner, path)))


def _materials_in(node: Any, path: Path) -> Iterator[tuple[Path, str]]:
    """The texts that name a material, alternatives of a form too, each with its path."""
    pairs = node.items() if is_mapping(node) else enumerate(node) if is_sequence(node) else ()
    for key, item in pairs:
        if isinstance(key, str) and key.startswith(NOTE_PREFIX):
            continue
        if isinstance(item, str):
            if "material" in {key, *path}:
                yield (*path, key), item
        else:
            yield from _materials_in(item, (*path, key))
