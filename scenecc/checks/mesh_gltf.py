"""glTF 2.0, as text or binary: its triangles in the file's frame, and the files that it names.

Read here and not by a library, so that a small file cannot ask for much memory: a glTF may claim any number of
vertices without storing one, and place one mesh many times.
"""

from __future__ import annotations

import base64
import binascii
import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal
from urllib.parse import unquote

import numpy as np

from scenecc.checks.mesh_data import AssetError, MeshData, Part, Reading, Reference, part
from scenecc.checks.mesh_gltf_rules import COMPONENTS, WIDTHS, read_document
from scenecc.checks.mesh_text import Budget
from scenecc.source.plain_data import RepeatedKeyError

if TYPE_CHECKING:
    from numpy.typing import NDArray

_PACKED = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}
_DEEPEST = 200
_VALUE_BYTES, _NODE_BYTES, _WIDEST = 64, 1024, 8
"""About what a value of the JSON takes, what a node counts for, and what a number takes at most [bytes]."""

_MALFORMED = (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError, RecursionError)


@dataclass(slots=True)
class _File:
    document: dict[str, Any]
    binary: bool
    chunk: bytes | None
    reading: Reading
    budget: Budget
    buffers: dict[int, bytes] = field(default_factory=dict[int, bytes])


def read_gltf(data: bytes, reading: Reading) -> MeshData:
    """Reads a `.gltf` or `.glb`. A part is a primitive of a mesh, placed by one node.

    Args:
        data: the file.
        reading: reads the buffers that it names.

    Raises:
        AssetError: the file is not what glTF says, or too large, or a buffer cannot be read.
    """
    try:
        budget = Budget(reading.max_bytes, reading.total)
        document, chunk = _split(data, budget)
        packed = _PACKED & set(document.get("extensionsUsed", ()))
        if packed:
            raise AssetError("SC410", f"the glTF is packed with {min(packed)}", "export it without mesh compression")
        file = _File(document, data[:4] == b"glTF", chunk, reading, budget)
        parts = _parts(file)
        _check_motion(file)
        images: list[dict[str, Any]] = document.get("images", [])
        named = tuple(_reference(image["uri"], "image") for image in images if _names_file(image.get("uri")))
        embedded = tuple(_embedded(file, image) for image in images if not _names_file(image.get("uri")))
        uris = [buffer.get("uri") for buffer in document.get("buffers", [])]
        buffers = tuple(_reference(uri, "buffer") for uri in uris if _names_file(uri))
    except _MALFORMED as error:
        raise AssetError("SC412", f"the glTF cannot be read: {_said(error)}", "export the file again") from error
    return MeshData(parts, (*buffers, *named), embedded)


def _said(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"{error.args[0]!r} is missing"
    if isinstance(error, RepeatedKeyError):
        return f"the key {error} stands twice in one object"
    return "it is nested too deeply" if isinstance(error, RecursionError) else str(error)


def _split(data: bytes, budget: Budget) -> tuple[dict[str, Any], bytes | None]:
    chunk = None
    if data[:4] == b"glTF":
        version, length = struct.unpack_from("<II", data.ljust(12, b"\0"), 4)
        if version != 2 or length > len(data):
            raise ValueError(f"it says version {version} and {length} bytes, and has {len(data)}")
        size, kind = struct.unpack_from("<I4s", data.ljust(20, b"\0"), 12)
        if kind != b"JSON" or 20 + size > length:
            raise ValueError("its first chunk is not JSON")
        text, start = data[20 : 20 + size], 20 + size
        if size % 4:
            raise ValueError("its first chunk does not end where the next can begin")
        if start < length:
            size, kind = struct.unpack_from("<I4s", data.ljust(start + 8, b"\0"), start)
            if kind != b"BIN\0" or start + 8 + size > length:
                raise ValueError("its second chunk is not binary, or cut short")
            chunk = data[start + 8 : start + 8 + size]
    else:
        text = data
    budget.take(_VALUE_BYTES * sum(map(text.count, (b",", b"[", b"{"))))
    document = read_document(text)
    version = document["asset"]["version"]
    if not version.startswith("2."):
        raise ValueError(f"it says glTF version {version[:40]}")
    if data[:4] == b"glTF" and document.get("buffers") and "uri" in document["buffers"][0]:
        raise ValueError("its first buffer names a file, and is its binary chunk")
    return document, chunk


def _names_file(uri: object) -> bool:
    return isinstance(uri, str) and not uri.startswith("data:")


def _reference(uri: str, kind: Literal["image", "buffer"]) -> Reference:
    return Reference(uri, kind, escaped=unquote(uri) != uri)


def _parts(file: _File) -> tuple[Part, ...]:
    """Every primitive, once for each node that shows it."""
    document = file.document
    nodes = document.get("nodes", [])
    roots = document["scenes"][document.get("scene", 0)].get("nodes", [])
    primitives: dict[int, list[Part]] = {}
    parts: list[Part] = []
    waiting = [(root, np.eye(4), 0) for root in roots]
    seen: set[int] = set()
    while waiting:
        index, above, depth = waiting.pop()
        if index in seen or depth > _DEEPEST:
            raise ValueError("its nodes are no tree, or one of great depth")
        seen.add(index)
        file.budget.take(_NODE_BYTES)
        node = nodes[index]
        place = above @ _matrix(node)
        waiting.extend((child, place, depth + 1) for child in node.get("children", ()))
        if "mesh" not in node:
            continue
        mesh = node["mesh"]
        if mesh not in primitives:
            primitives[mesh] = [_primitive(file, item) for item in document["meshes"][mesh]["primitives"]]
        file.budget.take(sum(one.vertices.nbytes for one in primitives[mesh]))
        parts.extend(_moved(one, place) for one in primitives[mesh] if len(one.faces))
    return tuple(parts)


def _moved(one: Part, place: NDArray[np.float64]) -> Part:
    with np.errstate(all="ignore"):
        return Part((one.vertices @ place[:3, :3].T + place[:3, 3]).astype(np.float32), one.faces)


def _matrix(node: dict[str, Any]) -> NDArray[np.float64]:
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


def _check_motion(file: _File) -> None:
    """Skins and animations: nothing of them is built, and the engine's reader goes by their numbers all the same."""
    document = file.document
    for skin in document.get("skins", ()):
        matrices = skin.get("inverseBindMatrices")
        if matrices is not None and len(_accessor(file, matrices, _FLOATS, ("MAT4",))) < len(skin["joints"]):
            raise ValueError("a skin has fewer matrices than joints")
    for node in document.get("nodes", ()):
        joints = len(document["skins"][node["skin"]]["joints"]) if "skin" in node else 0
        for primitive in document["meshes"][node["mesh"]]["primitives"] if joints and "mesh" in node else ():
            for name, number in primitive["attributes"].items():
                if name.startswith("JOINTS") and int(_accessor(file, number, _UNSIGNED, ("VEC4",)).max()) >= joints:
                    raise ValueError("a vertex names a joint that its skin has not")
    for sampler in (sampler for animation in document.get("animations", ()) for sampler in animation["samplers"]):
        times = len(_accessor(file, sampler["input"], _FLOATS, ("SCALAR",)))
        rows = len(_accessor(file, sampler["output"], _FLOATS, ("SCALAR", "VEC3", "VEC4")))
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
"""The kinds of numbers, and how many, of what a vertex has."""


def _primitive(file: _File, primitive: dict[str, Any]) -> Part:
    attributes = _attributes(file, primitive["attributes"])
    for target in primitive.get("targets", ()):
        _attributes(file, target, of_target=True)
    vertices = attributes["POSITION"]
    if "indices" in primitive:
        index = _accessor(file, primitive["indices"], (5121, 5123, 5125), ("SCALAR",)).astype(np.int64).ravel()
    else:
        file.budget.take(8 * len(vertices))
        index = np.arange(len(vertices), dtype=np.int64)
    if not len(index) or int(index.max()) >= len(vertices):
        raise ValueError("a primitive has no indices, or one of a vertex that is not there")
    mode = primitive.get("mode", 4)
    if mode in {5, 6}:
        file.budget.take(24 * len(index))
    return part(vertices, _faces(mode, index))


def _attributes(file: _File, named: dict[str, Any], *, of_target: bool = False) -> dict[str, NDArray[Any]]:
    """What vertices have, by name: as much of each as of the positions."""
    found: dict[str, NDArray[Any]] = {}
    for name, number in named.items():
        base, _, rank = name.partition("_")
        known = next((one for one in _ATTRIBUTES if name.startswith(one)), None)
        if known is None:
            continue
        before = sum(one.startswith(known) for one in found)
        if base != known or rank != (str(before) if base in {"TEXCOORD", "COLOR", "JOINTS", "WEIGHTS"} else ""):
            raise ValueError(f"the attribute {name[:40]} does not follow the others of its kind")
        kinds, widths = _ATTRIBUTES[known]
        found[name] = _accessor(file, number, kinds, ("VEC3",) if of_target else widths)
    if not of_target and "POSITION" not in found:
        raise ValueError("a primitive has no positions")
    if len({len(one) for one in found.values()}) > 1:
        raise ValueError("a primitive has more of one attribute than of another")
    return found


def _faces(mode: object, index: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles of a list, a strip or a fan; points and lines have none."""
    if mode == 4:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if mode == 5 and len(index) > 2:
        return np.stack([index[:-2], index[1:-1], index[2:]], axis=1)
    if mode == 6 and len(index) > 2:
        return np.stack([np.full(len(index) - 2, index[0]), index[1:-1], index[2:]], axis=1)
    return np.zeros((0, 3), dtype=np.int64)


def _accessor(file: _File, number: int, kinds: tuple[int, ...], widths: tuple[str, ...]) -> NDArray[Any]:
    """The numbers of an accessor, one row each; it must be of one of the kinds and widths."""
    accessor = file.document["accessors"][number]
    if accessor["componentType"] not in kinds or accessor["type"] not in widths:
        raise ValueError(f"accessor {number} is of another type than what it is for")
    if accessor["count"] < 1:
        raise ValueError(f"accessor {number} has no rows")
    width, kind = WIDTHS[accessor["type"]], COMPONENTS[accessor["componentType"]]
    count = accessor["count"]
    # A mesh may be placed, and an accessor named, any number of times, and numbers are made wider than they are stored.
    file.budget.take(count * width * _WIDEST)
    sparse = accessor.get("sparse")
    if "bufferView" in accessor:
        packed = sparse is not None
        found = _view(file, accessor["bufferView"], accessor.get("byteOffset", 0), kind, (count, width), packed=packed)
    elif sparse is None:
        raise ValueError(f"accessor {number} has no data")
    else:
        found = np.zeros((count, width), dtype=kind)
    if sparse is not None:
        some, where, what = sparse["count"], sparse["indices"], sparse["values"]
        indices = COMPONENTS[where["componentType"]]
        rows = _view(file, where["bufferView"], where.get("byteOffset", 0), indices, (some, 1), packed=True)
        values = _view(file, what["bufferView"], what.get("byteOffset", 0), kind, (some, width), packed=True)
        found = found.copy()
        found[rows.ravel().astype(np.int64)] = values
    return found


def _view(
    file: _File, number: int, start: int, kind: str, shape: tuple[int, int], *, packed: bool = False
) -> NDArray[Any]:
    """Rows of a buffer view; `packed`: where the engine's reader knows no stride."""
    view = file.document["bufferViews"][number]
    data = _view_bytes(file, view)
    item = np.dtype(kind).itemsize * shape[1]
    stride = view.get("byteStride", 0) or item
    if stride < item or (packed and stride != item):
        raise ValueError("the rows of a buffer view overlap, or have gaps where none may be")
    # The engine's reader wants room for the gap behind the last row, too.
    if start + stride * (shape[0] - 1) + item > len(data) or stride * shape[0] > len(data):
        raise ValueError("an accessor reaches past the end of its buffer view")
    return np.ndarray(shape, kind, data, start, (stride, np.dtype(kind).itemsize))


def _view_bytes(file: _File, view: dict[str, Any]) -> memoryview:
    data = _buffer(file, view["buffer"])
    start, size = view.get("byteOffset", 0), view["byteLength"]
    if start + size > len(data):
        raise ValueError("a buffer view reaches past the end of its buffer")
    return memoryview(data)[start : start + size]


def _buffer(file: _File, number: int) -> bytes:
    if number not in file.buffers:
        buffer = file.document["buffers"][number]
        uri = buffer.get("uri")
        if (uri is None) != (number == 0 and file.binary) or (file.binary and file.chunk is None):
            raise ValueError("the first buffer of a GLB is its binary chunk, and all others are files")
        if uri is None:
            data = file.chunk or b""
        elif _names_file(uri):
            data = file.reading.open_named(_reference(uri, "buffer"))[: buffer["byteLength"]]
        else:
            data = _data_uri(uri)
        if not (buffer["byteLength"] <= len(data) if uri is None else buffer["byteLength"] == len(data)):
            raise ValueError("a buffer is not as long as it says")
        file.budget.take(len(data))
        file.buffers[number] = data
    return file.buffers[number]


def _embedded(file: _File, image: dict[str, Any]) -> bytes:
    if "uri" in image:
        return _data_uri(image["uri"])
    view = _view_bytes(file, file.document["bufferViews"][image["bufferView"]])
    file.budget.take(len(view))
    return bytes(view)


def _data_uri(uri: str) -> bytes:
    head, comma, body = uri.partition(",")
    if not comma or not head.endswith(";base64"):
        raise ValueError("a data: URI is not base64")
    try:
        return base64.b64decode(body, validate=True)
    except binascii.Error as error:
        raise ValueError(f"a data: URI is not base64: {error}") from error
