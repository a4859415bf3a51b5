"""Reader for glTF 2.0 (`.gltf`, `.glb`): a schema of the document, triangles in the file's frame, and file references.

No library is used, because a small glTF file can claim any number of vertices or place one mesh many times. Every
key that the engine's reader looks at is checked.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
import re
import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NoReturn, cast
from urllib.parse import unquote

import numpy as np

from scenecc.checks.mesh_data import (
    AssetError,
    AssetReference,
    MeshBudget,
    MeshData,
    MeshFilePart,
    MeshReadContext,
    fan_triangles,
    make_part,
    parse_coordinate,
    strip_triangles,
    transform_part,
)
from scenecc.plan.json_values import RepeatedKeyError, reject_repeated_keys

if TYPE_CHECKING:
    from numpy.typing import NDArray


WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}

ValueRule = type | int | str | tuple[Any, ...] | list[Any] | dict[str, Any]
"""What must stand somewhere: a value of a type (`int`: a size), so many numbers, an index into a section, one
of several values, a list of a kind, an object with members of kinds (`!`: that it must have; `*`: all)."""

_TEXTURE_RULE = {"index!": "textures", "texCoord": int, "scale": float, "strength": float}

_WRAP_MODES = (33071, 33648, 10497)

_DOCUMENT_RULES: dict[str, ValueRule] = {
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
        {
            "magFilter": (9728, 9729),
            "minFilter": (9728, 9729, *range(9984, 9988)),
            "wrapS": _WRAP_MODES,
            "wrapT": _WRAP_MODES,
        }
    ],
    "textures": [{"source": "images", "sampler": "samplers"}],
    "materials": [
        {
            "pbrMetallicRoughness": {
                "baseColorFactor": 4,
                "baseColorTexture": _TEXTURE_RULE,
                "metallicFactor": float,
                "roughnessFactor": float,
                "metallicRoughnessTexture": _TEXTURE_RULE,
            },
            "normalTexture": _TEXTURE_RULE,
            "occlusionTexture": _TEXTURE_RULE,
            "emissiveTexture": _TEXTURE_RULE,
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
        parse_float=_parse_json_float,
        parse_int=_parse_json_int,
        parse_constant=_reject_constant,
        object_pairs_hook=reject_repeated_keys,  # of a key that stands twice, the engine's reader takes the first
    )
    json.dumps(document, ensure_ascii=False).encode()  # halves of surrogate pairs raise
    if not isinstance(document, dict):
        raise TypeError("it is not a JSON object")
    whole = cast("dict[str, Any]", document)
    _check_value(whole, _DOCUMENT_RULES, whole, "the document")
    _check_sources(whole)
    _check_nodes(whole)
    return whole


def _parse_json_float(word: str) -> float:
    value = parse_coordinate(word)
    if not math.isfinite(value):
        raise ValueError(f"`{word[:40]}` is too large")
    return value


def _parse_json_int(word: str) -> int:
    if len(word) > 300:
        raise ValueError(f"`{word[:40]}…` is too large")
    return int(word)


def _reject_constant(word: str) -> NoReturn:
    raise ValueError(f"`{word}` is not JSON")


def _check_value(value: Any, kind: ValueRule, document: dict[str, Any], where: str) -> None:
    match kind:
        case str():
            items = document.get(kind)
            right = _is_size(value) and isinstance(items, list) and value < len(cast("list[Any]", items))
        case dict():
            right = isinstance(value, dict)
            if right:
                _check_members(cast("dict[str, Any]", value), kind, document, where)
        case list():
            right = isinstance(value, list)
            for i, item in enumerate(cast("list[Any]", value) if right else ()):
                _check_value(item, kind[0], document, f"{where}[{i}]")
        case tuple():
            right = type(value) in {int, str} and value in kind  # the reader takes 5126.0 for another number
        case int() as count:
            right = isinstance(value, list) and len(cast("list[Any]", value)) == count
            right = right and all(map(_is_number, cast("list[Any]", value)))
        case _:
            right = _is_size(value) if kind is int else _is_number(value) if kind is float else isinstance(value, kind)
    if not right:
        raise ValueError(f"{where} is {json.dumps(value)[:40]}, which is not valid here")


def _check_members(value: dict[str, Any], kind: dict[str, Any], document: dict[str, Any], where: str) -> None:
    for member, inner in kind.items():
        if member == "*":
            for name, item in value.items():
                _check_value(item, inner, document, f"{where}.{name[:40]}")
            continue
        name = member.removesuffix("!")
        if name in value:
            _check_value(value[name], inner, document, f"{where}.{name}")
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
                _check_value(value, _TEXTURE_RULE, document, f"{where}.{name[:40]}")
            _check_extensions(cast("dict[str, Any]", value), document, where)
    punctual = extensions.get("KHR_lights_punctual")
    if isinstance(punctual, dict) and "light" in punctual:
        extension = document.get("extensions", {}).get("KHR_lights_punctual")
        lights = {"lights": cast("dict[str, Any]", extension).get("lights") if isinstance(extension, dict) else None}
        _check_value(cast("dict[str, Any]", punctual)["light"], "lights", lights, f"{where}.light")
        _check_value(lights["lights"], [{"type!": ("directional", "point", "spot")}], document, "lights")
        for light in cast("list[dict[str, Any]]", lights["lights"]):
            if light["type"] == "spot" and not isinstance(light.get("spot"), dict):
                raise ValueError("a light has no `spot`")


def _check_sources(document: dict[str, Any]) -> None:
    """Checks required alternatives of images, cameras and animations."""
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
            raise ValueError("an animation channel refers to a missing sampler")


def _check_nodes(document: dict[str, Any]) -> None:
    """Checks that all nodes form trees, including unused ones."""
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
        raise ValueError("its nodes are not a tree")


_COMPRESSION_EXTENSIONS = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}

_MAX_NODE_DEPTH = 200

_VALUE_BYTES, _NODE_BYTES, _WIDEST = 64, 1024, 8
"""About what a value of the JSON takes, what a node counts for, and what a number takes at most [bytes]."""

_MALFORMED_ERRORS = (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError, RecursionError)


@dataclass(slots=True)
class _GltfFile:
    document: dict[str, Any]
    binary: bool
    chunk: bytes | None
    reading: MeshReadContext
    budget: MeshBudget
    buffers: dict[int, bytes] = field(default_factory=dict[int, bytes])


def read_gltf(data: bytes, reading: MeshReadContext) -> MeshData:
    """Reads a `.gltf` or `.glb`. A part is a primitive of a mesh, placed by one node.

    Args:
        data: the file.
        reading: reads the buffers that it names.

    Raises:
        AssetError: the file is not what glTF says, or too large, or a buffer cannot be read.
    """
    try:
        budget = MeshBudget(reading.max_bytes, reading.total)
        document, chunk = _split_chunks(data, budget)
        packed = _COMPRESSION_EXTENSIONS & set(document.get("extensionsUsed", ()))
        if packed:
            raise AssetError(
                "SC410", f"the glTF is compressed with {min(packed)}", "export it without mesh compression"
            )
        file = _GltfFile(document, data[:4] == b"glTF", chunk, reading, budget)
        parts = _read_parts(file)
        _check_skins_and_animations(file)
        images: list[dict[str, Any]] = document.get("images", [])
        named = tuple(_make_reference(image["uri"], "image") for image in images if _is_external(image.get("uri")))
        embedded = tuple(_embedded_image(file, image) for image in images if not _is_external(image.get("uri")))
        uris = [buffer.get("uri") for buffer in document.get("buffers", [])]
        buffers = tuple(_make_reference(uri, "buffer") for uri in uris if _is_external(uri))
    except _MALFORMED_ERRORS as error:
        raise AssetError("SC412", f"the glTF cannot be read: {_error_text(error)}", "export the file again") from error
    return MeshData(parts, (*buffers, *named), embedded)


def _error_text(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"{error.args[0]!r} is missing"
    if isinstance(error, RepeatedKeyError):
        return f"the key {error} occurs twice in one object"
    return "it is nested too deeply" if isinstance(error, RecursionError) else str(error)


def _split_chunks(data: bytes, budget: MeshBudget) -> tuple[dict[str, Any], bytes | None]:
    chunk = None
    if data[:4] == b"glTF":
        version, length = struct.unpack_from("<II", data.ljust(12, b"\0"), 4)
        if version != 2 or length > len(data):
            raise ValueError(f"its header declares version {version} and {length} bytes, but it has {len(data)} bytes")
        size, kind = struct.unpack_from("<I4s", data.ljust(20, b"\0"), 12)
        if kind != b"JSON" or 20 + size > length:
            raise ValueError("its first chunk is not JSON")
        text, start = data[20 : 20 + size], 20 + size
        if size % 4:
            raise ValueError("the length of its first chunk is not a multiple of 4")
        if start < length:
            size, kind = struct.unpack_from("<I4s", data.ljust(start + 8, b"\0"), start)
            if kind != b"BIN\0" or start + 8 + size > length:
                raise ValueError("its second chunk is not binary, or truncated")
            chunk = data[start + 8 : start + 8 + size]
    else:
        text = data
    budget.take(_VALUE_BYTES * sum(map(text.count, (b",", b"[", b"{"))))
    document = read_document(text)
    version = document["asset"]["version"]
    if not version.startswith("2."):
        raise ValueError(f"its glTF version is {version[:40]}")
    if data[:4] == b"glTF" and document.get("buffers") and "uri" in document["buffers"][0]:
        raise ValueError("its first buffer refers to a file, but is the binary chunk")
    return document, chunk


def _is_external(uri: object) -> bool:
    return isinstance(uri, str) and not uri.startswith("data:")


def _make_reference(uri: str, kind: Literal["image", "buffer"]) -> AssetReference:
    return AssetReference(uri, kind, escaped=unquote(uri) != uri)


def _read_parts(file: _GltfFile) -> tuple[MeshFilePart, ...]:
    """Every primitive, once for each node that shows it."""
    document = file.document
    nodes = document.get("nodes", [])
    roots = document["scenes"][document.get("scene", 0)].get("nodes", [])
    primitives: dict[int, list[MeshFilePart]] = {}
    parts: list[MeshFilePart] = []
    waiting = [(root, np.eye(4), 0) for root in roots]
    visited: set[int] = set()
    while waiting:
        index, above, depth = waiting.pop()
        if index in visited or depth > _MAX_NODE_DEPTH:
            raise ValueError("its nodes are not a tree, or are nested too deeply")
        visited.add(index)
        file.budget.take(_NODE_BYTES)
        node = nodes[index]
        place = above @ _node_transform(node)
        waiting.extend((child, place, depth + 1) for child in node.get("children", ()))
        if "mesh" not in node:
            continue
        mesh = node["mesh"]
        if mesh not in primitives:
            primitives[mesh] = [_read_primitive(file, item) for item in document["meshes"][mesh]["primitives"]]
        file.budget.take(sum(one.vertices.nbytes for one in primitives[mesh]))
        parts.extend(transform_part(one, place, file.reading.precision) for one in primitives[mesh] if len(one.faces))
    return tuple(parts)


def _node_transform(node: dict[str, Any]) -> NDArray[np.float64]:
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = map(float, node.get("rotation", (0, 0, 0, 1)))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(node.get("scale", (1, 1, 1)), dtype=np.float64)
    matrix[:3, 3] = np.array(node.get("translation", (0, 0, 0)), dtype=np.float64)
    return matrix


def _check_skins_and_animations(file: _GltfFile) -> None:
    """Checks skins and animations: nothing of them is built, but the engine's reader uses their indices."""
    document = file.document
    for skin in document.get("skins", ()):
        matrices = skin.get("inverseBindMatrices")
        if matrices is not None and len(_read_accessor(file, matrices, _FLOATS, ("MAT4",))) < len(skin["joints"]):
            raise ValueError("a skin has fewer matrices than joints")
    for node in document.get("nodes", ()):
        joints = len(document["skins"][node["skin"]]["joints"]) if "skin" in node else 0
        for primitive in document["meshes"][node["mesh"]]["primitives"] if joints and "mesh" in node else ():
            for name, number in primitive["attributes"].items():
                if (
                    name.startswith("JOINTS")
                    and int(_read_accessor(file, number, _UNSIGNED, ("VEC4",)).max()) >= joints
                ):
                    raise ValueError("a vertex refers to a joint that its skin does not have")
    for sampler in (sampler for animation in document.get("animations", ()) for sampler in animation["samplers"]):
        times = len(_read_accessor(file, sampler["input"], _FLOATS, ("SCALAR",)))
        rows = len(_read_accessor(file, sampler["output"], _FLOATS, ("SCALAR", "VEC3", "VEC4")))
        if rows < times * (3 if sampler.get("interpolation") == "CUBICSPLINE" else 1):
            raise ValueError("an animation has fewer values than times")


_FLOATS = (5126,)

_UNSIGNED = (5121, 5123)

_ATTRIBUTES = {
    "POSITION": (_FLOATS, ("VEC3",)),
    "NORMAL": (_FLOATS, ("VEC3",)),
    "TANGENT": (_FLOATS, ("VEC4",)),
    "TEXCOORD": ((*_UNSIGNED, *_FLOATS), ("VEC2",)),
    "COLOR": ((*_UNSIGNED, *_FLOATS), ("VEC3", "VEC4")),
    "JOINTS": (_UNSIGNED, ("VEC4",)),
    "WEIGHTS": ((*_UNSIGNED, *_FLOATS), ("VEC4",)),
}
"""Allowed component types and accessor types of vertex attributes."""


def _read_primitive(file: _GltfFile, primitive: dict[str, Any]) -> MeshFilePart:
    attributes = _read_attributes(file, primitive["attributes"])
    for target in primitive.get("targets", ()):
        _read_attributes(file, target, of_target=True)
    vertices = attributes["POSITION"]
    if "indices" in primitive:
        index = _read_accessor(file, primitive["indices"], (5121, 5123, 5125), ("SCALAR",)).astype(np.int64).ravel()
    else:
        file.budget.take(8 * len(vertices))
        index = np.arange(len(vertices), dtype=np.int64)
    if not len(index) or int(index.max()) >= len(vertices):
        raise ValueError("a primitive has no indices, or refers to a missing vertex")
    mode = primitive.get("mode", 4)
    if mode in {5, 6}:
        file.budget.take(24 * len(index))
    return make_part(vertices, _read_faces(mode, index))


def _read_attributes(file: _GltfFile, named: dict[str, Any], *, of_target: bool = False) -> dict[str, NDArray[Any]]:
    """What vertices have, by name: as much of each as of the positions."""
    found: dict[str, NDArray[Any]] = {}
    for name, number in named.items():
        base, _, rank = name.partition("_")
        known = next((one for one in _ATTRIBUTES if name.startswith(one)), None)
        if known is None:
            continue
        before = sum(one.startswith(known) for one in found)
        if base != known or rank != (str(before) if base in {"TEXCOORD", "COLOR", "JOINTS", "WEIGHTS"} else ""):
            raise ValueError(f"the attribute {name[:40]} is not numbered after the others of its kind")
        kinds, widths = _ATTRIBUTES[known]
        found[name] = _read_accessor(file, number, kinds, ("VEC3",) if of_target else widths)
    if not of_target and "POSITION" not in found:
        raise ValueError("a primitive has no positions")
    if len({len(one) for one in found.values()}) > 1:
        raise ValueError("the attributes of a primitive differ in count")
    return found


def _read_faces(mode: object, index: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles of a list, a strip or a fan; points and lines have none."""
    if mode == 4:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if mode == 5:
        return strip_triangles(index)
    if mode == 6:
        return fan_triangles(index[None])
    return np.zeros((0, 3), dtype=np.int64)


def _read_accessor(file: _GltfFile, number: int, kinds: tuple[int, ...], widths: tuple[str, ...]) -> NDArray[Any]:
    """The numbers of an accessor, one row each; it must be of one of the kinds and widths."""
    accessor = file.document["accessors"][number]
    if accessor["componentType"] not in kinds or accessor["type"] not in widths:
        raise ValueError(f"accessor {number} has the wrong type for its use")
    if accessor["count"] < 1:
        raise ValueError(f"accessor {number} has no rows")
    width, kind = WIDTHS[accessor["type"]], COMPONENTS[accessor["componentType"]]
    count = accessor["count"]
    # A mesh may be placed, and an accessor named, any number of times, and numbers are made wider than they are stored.
    file.budget.take(count * width * _WIDEST)
    sparse = accessor.get("sparse")
    if "bufferView" in accessor:
        packed = sparse is not None
        found = _read_view(
            file, accessor["bufferView"], accessor.get("byteOffset", 0), kind, (count, width), packed=packed
        )
    elif sparse is None:
        raise ValueError(f"accessor {number} has no data")
    else:
        found = np.zeros((count, width), dtype=kind)
    if sparse is not None:
        some, where, what = sparse["count"], sparse["indices"], sparse["values"]
        indices = COMPONENTS[where["componentType"]]
        rows = _read_view(file, where["bufferView"], where.get("byteOffset", 0), indices, (some, 1), packed=True)
        values = _read_view(file, what["bufferView"], what.get("byteOffset", 0), kind, (some, width), packed=True)
        found = found.copy()
        found[rows.ravel().astype(np.int64)] = values
    return found


def _read_view(
    file: _GltfFile, number: int, start: int, kind: str, shape: tuple[int, int], *, packed: bool = False
) -> NDArray[Any]:
    """Rows of a buffer view; `packed`: where the engine's reader knows no stride."""
    view = file.document["bufferViews"][number]
    data = _read_view_bytes(file, view)
    item = np.dtype(kind).itemsize * shape[1]
    stride = view.get("byteStride", 0) or item
    if stride < item or (packed and stride != item):
        raise ValueError("the stride of a buffer view is invalid")
    # The engine's reader wants room for the gap behind the last row, too.
    if start + stride * (shape[0] - 1) + item > len(data) or stride * shape[0] > len(data):
        raise ValueError("an accessor reaches past the end of its buffer view")
    return np.ndarray(shape, kind, data, start, (stride, np.dtype(kind).itemsize))


def _read_view_bytes(file: _GltfFile, view: dict[str, Any]) -> memoryview:
    data = _read_buffer(file, view["buffer"])
    start, size = view.get("byteOffset", 0), view["byteLength"]
    if start + size > len(data):
        raise ValueError("a buffer view reaches past the end of its buffer")
    return memoryview(data)[start : start + size]


def _read_buffer(file: _GltfFile, number: int) -> bytes:
    if number not in file.buffers:
        buffer = file.document["buffers"][number]
        uri = buffer.get("uri")
        if (uri is None) != (number == 0 and file.binary) or (file.binary and file.chunk is None):
            raise ValueError("only the first buffer of a GLB may be its binary chunk, and no other one")
        if uri is None:
            data = file.chunk or b""
        elif _is_external(uri):
            data = file.reading.open_named(_make_reference(uri, "buffer"))[: buffer["byteLength"]]
        else:
            data = _decode_data_uri(uri)
        if not (buffer["byteLength"] <= len(data) if uri is None else buffer["byteLength"] == len(data)):
            raise ValueError("the length of a buffer differs from its `byteLength`")
        file.budget.take(len(data))
        file.buffers[number] = data
    return file.buffers[number]


def _embedded_image(file: _GltfFile, image: dict[str, Any]) -> bytes:
    if "uri" in image:
        return _decode_data_uri(image["uri"])
    view = _read_view_bytes(file, file.document["bufferViews"][image["bufferView"]])
    file.budget.take(len(view))
    return bytes(view)


def _decode_data_uri(uri: str) -> bytes:
    head, comma, body = uri.partition(",")
    if not comma or not head.endswith(";base64"):
        raise ValueError("a data: URI is not base64")
    try:
        return base64.b64decode(body, validate=True)
    except binascii.Error as error:
        raise ValueError(f"a data: URI is not base64: {error}") from error
