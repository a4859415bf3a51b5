"""Overrides: changes to objects of a prefab, made by the file that uses it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, show, suggest_name
from scenecc.expand.arguments import ABSOLUTE_PREFIX
from scenecc.expand.documents import FailedValue, SceneDocument, count_node_objects
from scenecc.expand.expansion import ExpansionFrame, ExpansionWriter, OverridePlace, TraceRecord, scoped_name
from scenecc.expand.patterns import refuse_structure
from scenecc.spec.base import NOTE_PREFIX, exclusions
from scenecc.spec.keys import change_leaves, model_places, section_place
from scenecc.spec.nodes import TYPE, LazyUnion, is_mapping, is_sequence
from scenecc.spec.references import SHARED_NAMESPACE, WORLD, qualified_name
from scenecc.variation.forms import Template

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin, Path, RelatedPlace
    from scenecc.expand.module_compiler import NodeTemplate
    from scenecc.spec.base import NameKind
    from scenecc.spec.keys import KeyPlace

REMOVE = "remove"
"""The override that removes an object."""

OVERRIDE_SECTIONS = ("lights", "cameras", "constraints", "frames", "materials")
"""Sections whose names have the section as prefix in an override. Other names are entities."""

INSTANCE_KEYS = frozenset(("pose", "scene_idxs", "hidden", "with"))
"""Keys of an instance that can be overridden."""


@dataclass(frozen=True, slots=True)
class Override:
    """The override of one object.

    Attributes:
        value: a mapping, or `REMOVE`.
        record: its source.
        document: its document.
        scope: scope of the names in it.
        prefix: prefix of the entity names of that scope.
    """

    value: Any
    record: TraceRecord
    document: SceneDocument
    scope: str
    prefix: str

    def origin(self, *path: str) -> Origin:
        """Returns the origin of a key of the override; without a path, of the override."""
        return self.record.trace(path)


@dataclass(slots=True)
class InstanceOverrides:
    """The overrides of one instance.

    Attributes:
        instance: full name of the instance.
        prefix: prefix of the names inside.
        entries: overrides, by name within the prefab.
        inside: section and full name of the objects found so far, by name within the prefab.
    """

    instance: str
    prefix: str
    entries: dict[str, Override]
    inside: dict[str, tuple[str, str]] = field(default_factory=dict[str, tuple[str, str]])

    def find(self, section: str, full: str, sink: Sink) -> Override | None:
        """Returns the override of an object inside the instance, or None. An instance has the section `use`."""
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
    """Instantiates the overrides of one use of a prefab. Frame, scope and prefix are those of the overriding file."""
    made: dict[str, Override] = {}
    for name, template in templates.items():
        frame.lists = {}
        value = template.make(frame)
        if not is_mapping(value) and value != REMOVE:
            message = f"`{cut(name)}` must be a mapping of keys, or `{REMOVE}`, not {show(value)}"
            refuse_structure(value, template.path, name, "SC103", message, frame)
            value = {}
        # Each use counts the names, and the shapes that may replace fewer shapes.
        frame.objects.take(count_node_objects(value) - 1, frame, template.path)
        record = TraceRecord(frame.mark(template.path), frame.lists)
        made[name] = Override(value, record, template.part.document, scope, prefix)
    frame.lists = {}
    return made


def _make_absolute(value: Any, kind: NameKind | None, override: Override) -> Any:
    """Converts a scalar so that names of the overriding file are valid inside the prefab."""
    is_shared = kind in {"material", "group"}
    if isinstance(value, Template):
        # A varying expression returns the name of a material as text, so the text gets the scope.
        text = ABSOLUTE_PREFIX + scoped_name(override.scope, value.text) if is_shared else None
        return value.within(override.scope, text)
    if not (is_shared or kind in {"entity", "frame"}) or not isinstance(value, str) or isinstance(value, FailedValue):
        return value
    if value == WORLD or value.startswith(ABSOLUTE_PREFIX):
        return value
    return ABSOLUTE_PREFIX + (scoped_name(override.scope, value) if is_shared else override.prefix + value)


def says_world(value: Any) -> bool:
    """Returns whether an override refers to `world`, which is the world of the overriding file."""
    pose = value.get("pose")
    return value.get("parent") == WORLD or (is_mapping(pose) and pose.get("relative_to") == WORLD)


_ITEM_COPY_KEYS = frozenset(("repeat", "if"))
"""Keys of shapes and links that are already expanded when overrides are merged."""


class OverrideMerger:
    """Merges overrides into one object.

    Args:
        section: section of the object.
        sink: receives diagnostics.

    Attributes:
        places: see `TraceRecord.overrides`.
    """

    _override: Override

    def __init__(self, section: str, sink: Sink) -> None:
        self._section = section
        self.places: dict[Path, OverridePlace] = {}
        self._count = 0
        self._sink = sink

    def merge(self, node: Any, override: Override) -> Any:
        """Returns the object merged with an override. `node` is not changed."""
        self._count += 1
        self._override = override
        return self._mapping(node, override.value, section_place(self._section), (), ())

    def _mapping(self, node: Any, given: Any, place: KeyPlace, path: Path, at: Path) -> Any:
        made, model = dict[str, Any](node), place.model({**node, **given})
        if isinstance(place.choice, LazyUnion) and model is not None and node.get(TYPE) != given.get(TYPE, node[TYPE]):
            made = {key: item for key, item in made.items() if key in model_places(model)}
        excluded = {} if model is None else exclusions(model)
        for key, item in given.items():
            if key.startswith(NOTE_PREFIX):
                continue
            written = (*at, key)
            if key in _ITEM_COPY_KEYS and isinstance(path[-1] if path else None, int):
                hint = "items of a list are overridden after `repeat`; give the whole list"
                self._sink.report("SC244", f"`{key}` cannot be overridden", self._origin(written), at="key", hint=hint)
                continue
            for other in excluded.get(key, frozenset()) & made.keys():
                del made[other]
                if other in given:
                    first: RelatedPlace = ("the first", self._origin((*at, other)), "key")
                    message = f"`{other}` and `{key}` exclude each other"
                    self._sink.report("SC111", message, self._origin(written), at="key", related=[first])
            name = key
            # An overriding pattern must come last to win. If an equal one exists, a group makes it a new key.
            while place.key is not None and place.key.pattern and name in made and name != next(reversed(made)):
                name = f"(?:{name})"
            below = place.below({**node, **given}, key)
            if place.key is not None:
                name = _make_absolute(name, place.key.names, self._override)
            made[name] = self._value(made.get(name), item, below, (*path, name), written)
        return made

    def _value(self, node: Any, given: Any, place: KeyPlace, path: Path, at: Path) -> Any:
        if is_mapping(given) and not place.whole:
            if is_mapping(node) and not (place.is_form(node) or place.is_form(given)):
                return self._mapping(node, given, place, path, at)
            if is_sequence(node) and any(_is_index(key) for key in given):
                return self._items(node, given, place, path, at)
        self.places[path] = OverridePlace(self._override.record, at, self._count)
        return change_leaves(given, place, lambda leaf, kind, _: _make_absolute(leaf, kind, self._override))

    def _origin(self, path: Path) -> Origin:
        return self._override.record.trace(path)

    def _items(self, node: Any, given: Any, place: KeyPlace, path: Path, at: Path) -> list[Any]:
        made: list[Any] = list(node)
        for key, item in given.items():
            if key.startswith(NOTE_PREFIX):
                continue
            if not _is_index(key):
                message = f"`{cut(key)}` is not an item index like the other keys"
                hint = "items are counted from 0; or give the whole list"
                self._sink.report("SC243", message, self._origin((*at, key)), at="key", hint=hint)
                continue
            # No list index has more digits.
            index = int(key) if len(key) < _MAX_DIGITS else len(made)
            if index >= len(made):
                message = f"there is no item {cut(key)}: the list has {len(made)}"
                hint = f"items are counted from 0, so the last is {len(made) - 1}" if made else "it is empty"
                self._sink.report("SC243", message, self._origin((*at, key)), at="key", hint=hint)
                continue
            made[index] = self._value(made[index], item, place.below(node, index), (*path, index), (*at, key))
        return made


def _is_index(key: str) -> bool:
    """Whether a key of an override is the index of a list item."""
    return key.isascii() and key.isdigit()


_MAX_DIGITS = 10


_OWNERS = (*SHARED_NAMESPACE, "constraints", "lights", "materials")
_LISTED = 10
"""Most references that a message lists."""


def check_removals(output: ExpansionWriter, sink: Sink) -> None:
    """Reports each removed object that other objects still refer to."""
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
    """Searches for references to removed objects.

    Attributes:
        found: name and origin of a removal → name and origin of each reference.
    """

    def __init__(self, output: ExpansionWriter, removed: dict[str, Origin], materials: dict[str, Origin]) -> None:
        self.found: dict[tuple[str, Origin], list[tuple[str, Origin]]] = {}
        self._output = output
        self._removed = removed
        self._materials = materials
        self._left = {name for section in SHARED_NAMESPACE for name in output.sections[section]}

    def look(self, section: str, owner: str, node: Any) -> None:
        """Searches one named node."""
        if not is_mapping(node):
            return
        scope = self._output.names.scopes.get(qualified_name(section, owner), "")

        def look_at(text: Any, kind: NameKind | None, path: Path) -> Any:
            """Adds a scalar to the references if it names a removed object, and returns it."""
            if not isinstance(text, str):
                return text
            if kind == "material":
                full = text[1:] if text.startswith(ABSOLUTE_PREFIX) else scoped_name(scope, text)
                if full in self._materials:
                    self._add(full, self._materials[full], section, owner, path)
            elif kind in {"entity", "frame"} and text != WORLD:
                self._take(self._output.names.full_name(text, scope), section, owner, path)
            return text

        change_leaves(node, section_place(section), look_at)

    def _take(self, full: str, section: str, owner: str, path: Path) -> None:
        """Adds a reference to a removed object. The end of the name may be a link; the longest match counts."""
        while full and full not in self._left:
            if full in self._removed:
                self._add(full, self._removed[full], section, owner, path)
                return
            full = full.rpartition("/")[0]

    def _add(self, name: str, place: Origin, section: str, owner: str, path: Path) -> None:
        self.found.setdefault((name, place), []).append((owner, self._output.trace(section, owner, path)))
