"""Entities of an imported scene that differ only in their pose, as instances of one prefab."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Final

from scenecc.diagnostics.frozen import frozen
from scenecc.importers.numbers import Names
from scenecc.scene_file import Node, is_list_node, is_mapping_node
from scenecc.scene_file.layout import scene_text
from scenecc.scene_file.shared_keys import SHAPE_LISTS

_LEAST_SAVED: Final = 20
"""Minimum number of lines that a prefab must save; short models are easier to read inline."""

_NOT_SHARED: Final = '"collision_group"'
"""Each instance of a prefab has its own collision groups."""

_REFERENCES: Final = ("parent", "child", "mount", "relative_to")


@frozen
class Prefabs:
    """A scene with instances.

    Attributes:
        document: the scene.
        files: documents of the prefabs, by the value of `use`.
        names: entity that became an instance → entity inside the instance.
    """

    document: Node
    files: Mapping[str, Node]
    names: Mapping[str, str]

    def name(self, old: str) -> str:
        """Returns the current name of an entity or `ENTITY/LINK`."""
        entity, slash, link = old.partition("/")
        return f"{self.names.get(entity, entity)}{slash}{link}"


def find_prefabs(document: Node, taken: Iterable[str], path: Callable[[str], str]) -> Prefabs:
    """Replaces entities that differ only in pose by instances of one prefab, if that is shorter.

    Args:
        document: a scene document; it is not changed.
        taken: names that no prefab may have.
        path: returns the path of a prefab's file, from its name.
    """
    entities: Node = document.get("entities", {})
    alike: dict[str, list[str]] = {}
    for name, node in entities.items():
        alike.setdefault(json.dumps(_shared_content(name, node), sort_keys=True), []).append(name)
    files, free = dict[str, Node](), Names(*taken)
    made, inner = dict[str, Node](), dict[str, str]()
    for text, names in alike.items():
        content = _shared_content(names[0], entities[names[0]])
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
            found.document[section] = {key: _rename_prefabs(node, found) for key, node in document[section].items()}
    kept = {*_materials(found.document["entities"])}
    named = {key: node for key, node in document.get("materials", {}).items() if key in kept}
    found.document.pop("materials", None)
    found.document.update({"materials": named} if named else {})
    return found


def _shared_content(name: str, node: Node) -> Node:
    """Returns an entity without its pose, and a body without its name at the start of the names of its shapes.

    An MJCF needs unique names of geoms: `chair_1_seat` of the body `chair_1` becomes `seat`.
    """
    content = {key: value for key, value in node.items() if key != "pose"}
    own = re.compile(rf"^{re.escape(name)}[_./-](?=[A-Za-z])")
    for key in SHAPE_LISTS & content.keys() if "root" not in node else ():
        shapes = [{**one, "name": own.sub("", one["name"])} if "name" in one else one for one in node[key]]
        names = [one["name"] for one in shapes if "name" in one]
        content[key] = shapes if len({*names}) == len(names) else node[key]
    return content


def _materials(node: Any) -> Iterator[str]:
    for item in node if is_list_node(node) else ():
        yield from _materials(item)
    for key, value in node.items() if is_mapping_node(node) else ():
        if key == "material" and isinstance(value, str):
            yield value
        else:
            yield from _materials(value)


def _rename_prefabs(node: Node, prefabs: Prefabs) -> Node:
    return {key: prefabs.name(value) if key in _REFERENCES else value for key, value in node.items()}
