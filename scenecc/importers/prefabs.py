"""Equal models of an imported scene as instances of one prefab."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.frozen import frozen
from scenecc.importers.numbers import Names
from scenecc.scene_file import Node, is_list, is_mapping
from scenecc.scene_file.layout import scene_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

_LEAST_SAVED: Final = 20
"""Lines that a prefab must save; short models are read faster where they stand."""

_NOT_SHARED: Final = '"collision_group"'
"""Each instance of a prefab has collision groups of its own."""

_REFERENCES: Final = ("parent", "child", "mount", "relative_to")


@frozen
class Prefabs:
    """A scene with instances.

    Attributes:
        document: of the scene.
        files: the documents of the prefabs, by what `use` says.
        names: of an entity that became an instance → of what the instance holds.
    """

    document: Node
    files: Mapping[str, Node]
    names: Mapping[str, str]

    def name(self, old: str) -> str:
        """What an entity, or `ENTITY/LINK`, is called now."""
        entity, slash, link = old.partition("/")
        return f"{self.names.get(entity, entity)}{slash}{link}"


def find_prefabs(document: Node, taken: Iterable[str], path: Callable[[str], str]) -> Prefabs:
    """Equal entities, their poses aside, as instances of one prefab, where that is shorter.

    Args:
        document: a scene document; it is not changed.
        taken: names that no prefab may have.
        path: gives the file of a prefab its path, by its name.
    """
    entities: Node = document.get("entities", {})
    alike: dict[str, list[str]] = {}
    for name, node in entities.items():
        alike.setdefault(json.dumps(_content(node), sort_keys=True), []).append(name)
    files, free = dict[str, Node](), Names(*taken)
    made, inner = dict[str, Node](), dict[str, str]()
    for text, names in alike.items():
        content = _content(entities[names[0]])
        if "repeat" in content or _NOT_SHARED in text:
            continue
        lines = len(scene_text({"entities": {names[0]: content}}).splitlines())
        if (len(names) - 1) * lines - len(names) < _LEAST_SAVED:
            continue
        name = free.new(re.sub(r"[_.-]?\d+$", "", names[0]) or names[0])
        used = {each: document["materials"][each] for each in _materials(content)}
        files[path(name)] = {"scenecc": 1, "entities": {name: content}, **({"materials": used} if used else {})}
        for each in names:
            pose = {"pose": entities[each]["pose"]} if "pose" in entities[each] else {}
            made[each], inner[each] = {"use": path(name), **pose}, f"{each}/{name}"
    if not made:
        return Prefabs(document, {}, {})
    found = Prefabs({**document, "entities": {**entities, **made}}, files, inner)
    for section in ("constraints", "lights", "cameras"):
        if section in document:
            found.document[section] = {key: _renamed(node, found) for key, node in document[section].items()}
    kept = {*_materials(found.document["entities"])}
    named = {key: node for key, node in document.get("materials", {}).items() if key in kept}
    found.document.pop("materials", None)
    return replace(found, document={**found.document, **({"materials": named} if named else {})})


def _content(node: Node) -> Node:
    return {key: value for key, value in node.items() if key != "pose"}


def _materials(node: Any) -> Iterator[str]:
    """The names of materials that shapes have."""
    for item in node if is_list(node) else ():
        yield from _materials(item)
    for key, value in node.items() if is_mapping(node) else ():
        if key == "material" and isinstance(value, str):
            yield value
        else:
            yield from _materials(value)


def _renamed(node: Node, prefabs: Prefabs) -> Node:
    return {key: prefabs.name(value) if key in _REFERENCES else value for key, value in node.items()}
