"""Replaces bodies by instances of scenecc's prefabs that build them bit-identically."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.decompiler.reading import read_scene
from scenecc.decompiler.verify import default_engine_settings, tidy
from scenecc.diagnostics import Sink
from scenecc.expand.documents import PREFAB_FOLDER
from scenecc.scene_file import is_list_node, is_mapping_node
from scenecc.source import read_file

if TYPE_CHECKING:
    from scenecc.decompiler.reading import LiveObject
    from scenecc.decompiler.values import Node


def use_prefabs(document: Node, live: LiveObject, *, render: bool) -> Node:
    """Replaces bodies by instances of prefabs that build the same bodies.

    Args:
        document: a scene document; it is not changed.
        live: its first scene as read, with the document's names.
        render: whether visuals were read. If not, an instance adds the prefab's visuals.
    """
    entities: Node = document.get("entities", {})
    bodies = {part.name: part for part in (_physical(each) for each in live.of_kind("entity"))}
    for instance, names, given in _candidates(entities, render=render):
        if not all(name in entities and name in bodies for name in names) or instance in entities:
            continue
        use, parameters = given
        node = {"use": use, "prefix": "", **({"with": parameters} if parameters else {})}
        # Boxes have the same body as ManiSkill's mesh, but no texture, which takes seconds to check.
        quick = {**node, "with": {**parameters, "visual": "boxes"}} if use == _TABLE else node
        if _build_instance(quick, document) == {name: bodies[name] for name in names}:
            places = {name: {instance: node} if name == names[0] else {} for name in names}
            entities = {
                key: value for name, other in entities.items() for key, value in places.get(name, {name: other}).items()
            }
    return {**document, "entities": entities} if "entities" in document else document


def use_lights(document: Node) -> Node:
    """Replaces lights that equal ManiSkill's by an include of ManiSkill's lights."""
    shipped = read_file(PREFAB_FOLDER / _LIGHTS, Sink())
    assert shipped is not None
    shown = {"environment": shipped.data["environment"], "lights": list(shipped.data["lights"].values())}
    found = {"environment": document.get("environment"), "lights": list(document.get("lights", {}).values())}
    taken = {name for section in ("entities", "constraints", "cameras") for name in document.get(section, {})}
    if _single(found) != _single(shown) or taken & shipped.data["lights"].keys():
        return document
    rest = {key: value for key, value in document.items() if key not in shown}
    return {**rest, "include": [f"pkg://scenecc/prefabs/{_LIGHTS}"]}


_LIGHTS: Final = "parts/maniskill_lights.yaml"


def _single(value: Any) -> Any:
    """Converts the numbers of plain data to single precision."""
    if is_list_node(value):
        return [_single(item) for item in value]
    if is_mapping_node(value):
        return {key: _single(item) for key, item in value.items()}
    return np.float32(value) if isinstance(value, int | float) else value


def _physical(facts: LiveObject) -> LiveObject:
    return tidy(replace(facts, parts=tuple(part for part in facts.parts if part.kind.startswith("Physx"))))


_TABLE, _GROUND = "scenecc:table_workspace", "scenecc:ground"

_TABLE_LOOKS: Final = [
    {
        "type": "mesh",
        "file": "pkg://mani_skill/utils/scene_builder/table/assets/table.glb",
        "pose": {"rpy_deg": [0.0, 0.0, 90.0]},
        "scale": 1.75,
    }
]

_Candidate = tuple[str, list[str], tuple[str, "Node"]]


def _candidates(entities: Node, *, render: bool) -> list[_Candidate]:
    """Returns instances that may replace entities: instance name, entity names, prefab and parameters."""
    ground: Any = entities.get("ground")
    if not is_mapping_node(ground) or "collisions" not in ground:
        return []
    floor = _floor(ground, render=render)
    (plane, *_) = ground["collisions"]
    if floor is None or "urdf" in ground or plane["type"] != "plane":
        return []
    found: list[_Candidate] = []
    looks = [
        {**item, "scale": float(item.get("scale", 1))}
        for item in entities.get("table-workspace", {}).get("visuals", [])
    ]
    if "table-workspace" in entities and "floor_length" not in floor and (looks == _TABLE_LOOKS or not render):
        found.append(("table", ["table-workspace", "ground"], (_TABLE, floor)))
    altitude = {"altitude": plane["offset"]} if "offset" in plane else {}
    found.append(("floor", ["ground"], (_GROUND, {**floor, **altitude})))
    return found


def _floor(ground: Node, *, render: bool) -> Node | None:
    """Returns the parameters of a tiled ground; None if the ground looks different."""
    if not render:
        return {}
    if [item.get("type") for item in ground.get("visuals", [])] != ["tiled_plane"]:
        return None
    (tiles,) = ground["visuals"]
    length, width = (2 * edge for edge in tiles["half_size"])
    squares = [edge / count for edge, count in zip((length, width), tiles["texture_repeat"], strict=True)]
    texture: Any = tiles.get("material", {}).get("visual", {}).get("base_color_texture", {})
    x, y, _ = tiles.get("pose", [0.0, 0.0, 0.0])
    if not is_mapping_node(texture) or texture.get("mipmap_levels") != _MIPMAPS or abs(squares[0] - squares[1]) > _NEAR:
        return None
    found: Node = {} if width == _USUAL_WIDTH else {"floor_width": width}
    found |= {} if length == width else {"floor_length": length}
    found |= {"xy_origin": [x, y]} if x or y else {}
    found |= {} if abs(squares[0] - _USUAL_SQUARE) <= _NEAR else {"texture_square_len": squares[0]}
    return found | {"texture_file": texture["file"]}


_MIPMAPS, _USUAL_WIDTH, _USUAL_SQUARE, _NEAR = 4, 100.0, 4.0, 1e-4
"""Constants of `scenecc:ground`."""


def _build_instance(node: Node, document: Node) -> dict[str, LiveObject]:
    """Builds an instance with the document's settings; returns its bodies by name."""
    import scenecc  # noqa: PLC0415 - the facade is above this module's other users

    minimal = {"scenecc": 1, "physics": document.get("physics", {}), "entities": {"instance": node}}
    try:
        with default_engine_settings(), scenecc.load_scene(minimal, render=False, allow_outside_assets=True) as batch:
            return {part.name: _physical(part) for part in read_scene(batch.scenes[0]).of_kind("entity")}
    except scenecc.SceneError:
        return {}
