"""What a glTF document may hold: every key that the engine's reader looks at, with what must stand there.

The reader takes what it does not expect for absent, for other bytes, or ends its process: all of a document is checked.
"""

from __future__ import annotations

import json
import math
import re
from typing import Any, NoReturn, cast

from scenecc.checks.mesh_data import number
from scenecc.source.plain_data import reject_repeated_keys

WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}

Kind = type | int | str | tuple[Any, ...] | list[Any] | dict[str, Any]
"""What must stand somewhere: a value of a type (`int`: a size), so many numbers, an index into a section, one
of several values, a list of a kind, an object with members of kinds (`!`: that it must have; `*`: all)."""

_TEXTURE = {"index!": "textures", "texCoord": int, "scale": float, "strength": float}
_WRAPS = (33071, 33648, 10497)
_DOCUMENT: dict[str, Kind] = {
    "asset!": {"version!": str},
    "scene": "scenes",
    "extensionsUsed": [str],
    "extensionsRequired": [str],
    "accessors": [
        {
            "bufferView": "bufferViews",
            "byteOffset": int,
            "componentType!": tuple(COMPONENTS),
            "count!": int,
            "type!": tuple(WIDTHS),
            "normalized": bool,
            "sparse": {
                "count!": int,
                "indices!": {"bufferView!": "bufferViews", "byteOffset": int, "componentType!": (5121, 5123, 5125)},
                "values!": {"bufferView!": "bufferViews", "byteOffset": int},
            },
        }
    ],
    "bufferViews": [{"buffer!": "buffers", "byteOffset": int, "byteLength!": int, "byteStride": int}],
    "buffers": [{"byteLength!": int, "uri": str}],
    "images": [{"uri": str, "bufferView": "bufferViews", "mimeType": str}],
    "samplers": [
        {"magFilter": (9728, 9729), "minFilter": (9728, 9729, *range(9984, 9988)), "wrapS": _WRAPS, "wrapT": _WRAPS}
    ],
    "textures": [{"source": "images", "sampler": "samplers"}],
    "materials": [
        {
            "pbrMetallicRoughness": {
                "baseColorFactor": 4,
                "baseColorTexture": _TEXTURE,
                "metallicFactor": float,
                "roughnessFactor": float,
                "metallicRoughnessTexture": _TEXTURE,
            },
            "normalTexture": _TEXTURE,
            "occlusionTexture": _TEXTURE,
            "emissiveTexture": _TEXTURE,
            "emissiveFactor": 3,
            "alphaMode": ("OPAQUE", "MASK", "BLEND"),
            "alphaCutoff": float,
            "doubleSided": bool,
        }
    ],
    "meshes": [
        {
            "primitives!": [
                {
                    "attributes!": {"*": "accessors"},
                    "indices": "accessors",
                    "material": "materials",
                    "mode": tuple(range(7)),
                    "targets": [{"*": "accessors"}],
                }
            ],
            "weights": [float],
        }
    ],
    "nodes": [
        {
            "children": ["nodes"],
            "mesh": "meshes",
            "skin": "skins",
            "camera": "cameras",
            "matrix": 16,
            "translation": 3,
            "rotation": 4,
            "scale": 3,
            "weights": [float],
        }
    ],
    "scenes!": [{"nodes": ["nodes"]}],
    "skins": [{"joints!": ["nodes"], "inverseBindMatrices": "accessors", "skeleton": "nodes"}],
    "animations": [
        {
            "channels!": [
                {
                    "sampler!": int,
                    "target!": {"node": "nodes", "path!": ("translation", "rotation", "scale", "weights")},
                }
            ],
            "samplers!": [
                {
                    "input!": "accessors",
                    "output!": "accessors",
                    "interpolation": ("LINEAR", "STEP", "CUBICSPLINE"),
                }
            ],
        }
    ],
    "cameras": [{"type!": ("perspective", "orthographic"), "perspective": {}, "orthographic": {}}],
}


def read_document(text: bytes) -> dict[str, Any]:
    """The JSON of a glTF, all of which is as glTF says.

    Raises:
        ValueError: it is not.
    """
    document: Any = json.loads(
        text.decode(),
        parse_float=_real,
        parse_int=_whole,
        parse_constant=_no_constant,
        object_pairs_hook=reject_repeated_keys,  # of a key that stands twice, the engine's reader takes the first
    )
    json.dumps(document, ensure_ascii=False).encode()  # halves of surrogate pairs raise
    if not isinstance(document, dict):
        raise TypeError("it is not a JSON object")
    whole = cast("dict[str, Any]", document)
    _check(whole, _DOCUMENT, whole, "the document")
    _check_named(whole)
    _check_nodes(whole)
    return whole


def _real(word: str) -> float:
    value = number(word)
    if not math.isfinite(value):
        raise ValueError(f"`{word[:40]}` is too large")
    return value


def _whole(word: str) -> int:
    if len(word) > 300:
        raise ValueError(f"`{word[:40]}…` is too large")
    return int(word)


def _no_constant(word: str) -> NoReturn:
    raise ValueError(f"`{word}` is no JSON")


def _check(value: Any, kind: Kind, document: dict[str, Any], where: str) -> None:
    match kind:
        case str():
            held = document.get(kind)
            right = _is_size(value) and isinstance(held, list) and value < len(cast("list[Any]", held))
        case dict():
            right = isinstance(value, dict)
            if right:
                _check_members(cast("dict[str, Any]", value), kind, document, where)
        case list():
            right = isinstance(value, list)
            for i, item in enumerate(cast("list[Any]", value) if right else ()):
                _check(item, kind[0], document, f"{where}[{i}]")
        case tuple():
            right = type(value) in {int, str} and value in kind  # the reader takes 5126.0 for another number
        case int() as count:
            right = isinstance(value, list) and len(cast("list[Any]", value)) == count
            right = right and all(map(_is_number, cast("list[Any]", value)))
        case _:
            right = _is_size(value) if kind is int else _is_number(value) if kind is float else isinstance(value, kind)
    if not right:
        raise ValueError(f"{where} is {json.dumps(value)[:40]}, which cannot stand there")


def _check_members(value: dict[str, Any], kind: dict[str, Any], document: dict[str, Any], where: str) -> None:
    for member, inner in kind.items():
        if member == "*":
            for name, item in value.items():
                _check(item, inner, document, f"{where}.{name[:40]}")
            continue
        name = member.removesuffix("!")
        if name in value:
            _check(value[name], inner, document, f"{where}.{name}")
        elif name != member:
            raise ValueError(f"{where} has no {name}")
    extensions = value.get("extensions", {})
    if not isinstance(extensions, dict):
        raise TypeError(f"{where}.extensions is no object")
    _check_extensions(cast("dict[str, Any]", extensions), document, where)


def _is_size(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**32


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 3e38


def _check_extensions(extensions: dict[str, Any], document: dict[str, Any], where: str) -> None:
    """The textures and lights that extensions name."""
    for name, value in extensions.items():
        if isinstance(value, dict):
            if name.endswith("Texture"):
                _check(value, _TEXTURE, document, f"{where}.{name[:40]}")
            _check_extensions(cast("dict[str, Any]", value), document, where)
    punctual = extensions.get("KHR_lights_punctual")
    if isinstance(punctual, dict) and "light" in punctual:
        held = document.get("extensions", {}).get("KHR_lights_punctual")
        lights = {"lights": cast("dict[str, Any]", held).get("lights") if isinstance(held, dict) else None}
        _check(cast("dict[str, Any]", punctual)["light"], "lights", lights, f"{where}.light")
        _check(lights["lights"], [{"type!": ("directional", "point", "spot")}], document, "lights")
        for light in cast("list[dict[str, Any]]", lights["lights"]):
            if light["type"] == "spot" and not isinstance(light.get("spot"), dict):
                raise ValueError("a light has no `spot`")


def _check_named(document: dict[str, Any]) -> None:
    """What images, cameras and animations have one of."""
    for image in document.get("images", ()):
        if "uri" not in image and re.fullmatch(r"image/\w{1,8}", str(image.get("mimeType"))) is None:
            raise ValueError("an image has neither a `uri` nor a `mimeType`")
        if "uri" not in image and "bufferView" not in image:
            raise ValueError("an image has neither a `uri` nor a `bufferView`")
    for camera in document.get("cameras", ()):
        if camera["type"] not in camera:
            raise ValueError(f"a camera has no `{camera['type']}`")
    for animation in document.get("animations", ()):
        if any(channel["sampler"] >= len(animation["samplers"]) for channel in animation["channels"]):
            raise ValueError("a channel of an animation names a sampler that is not there")


def _check_nodes(document: dict[str, Any]) -> None:
    """That nodes make trees, those too that no scene shows."""
    nodes: list[dict[str, Any]] = document.get("nodes", [])
    children = [child for node in nodes for child in node.get("children", ())]
    waiting = list(set(range(len(nodes))).difference(children))
    reached = len(waiting)
    while waiting:
        inside = nodes[waiting.pop()].get("children", ())
        reached += len(inside)
        waiting.extend(inside)
        if reached > len(nodes):
            break
    if reached != len(nodes) or len(set(children)) < len(children):
        raise ValueError("its nodes are no tree")
