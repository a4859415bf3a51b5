"""glTF 2.0, as text or binary: its triangles in the file's frame, and the files that it names.

Read here and not by a library, so that a small file cannot ask for much memory: a glTF may claim any number of
vertices without storing one, and place one mesh many times.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, cast
from urllib.parse import unquote

import numpy as np

from scenecc.checks.mesh_data import AssetError, MeshData, Part, Reading, Reference, number, part

if TYPE_CHECKING:
    from numpy.typing import NDArray

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_PACKED = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}
_DEEPEST = 200
_MALFORMED = (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError, RecursionError)


@dataclass(slots=True)
class _File:
    document: dict[str, Any]
    chunk: bytes | None
    reading: Reading
    buffers: dict[int, bytes] = field(default_factory=dict[int, bytes])
    unpacked: int = 0

    def unpack(self, size: int) -> None:
        """Counts what is made in memory: a mesh may be placed, and an accessor named, any number of times."""
        self.unpacked += size
        if self.unpacked > self.reading.max_bytes:
            raise AssetError(
                "SC607",
                f"the triangles of the glTF take more than {self.reading.max_bytes} bytes",
                "simplify it, or raise the limit with --limit asset_bytes=N",
            )


def read_gltf(data: bytes, reading: Reading) -> MeshData:
    """Reads a `.gltf` or `.glb`. A part is a primitive of a mesh, placed by one node.

    Args:
        data: the file.
        reading: reads the buffers that it names.

    Raises:
        AssetError: the file is not what glTF says, or too large, or a buffer cannot be read.
    """
    try:
        document, chunk = _split(data)
        packed = _PACKED & set(document.get("extensionsUsed", ()))
        if packed:
            raise AssetError("SC410", f"the glTF is packed with {min(packed)}", "export it without mesh compression")
        file = _File(document, chunk, reading)
        parts = _parts(file)
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
    return "it is nested too deeply" if isinstance(error, RecursionError) else str(error)


def _split(data: bytes) -> tuple[dict[str, Any], bytes | None]:
    chunk = None
    if data[:4] == b"glTF":
        version, length = struct.unpack_from("<II", data.ljust(12, b"\0"), 4)
        if version != 2 or length > len(data):
            raise ValueError(f"it says version {version} and {length} bytes, and has {len(data)}")
        size, kind = struct.unpack_from("<I4s", data.ljust(20, b"\0"), 12)
        if kind != b"JSON" or 20 + size > length:
            raise ValueError("its first chunk is not JSON")
        text, start = data[20 : 20 + size], 20 + size
        if start + 8 <= length:
            size, kind = struct.unpack_from("<I4s", data, start)
            if start + 8 + size > length:
                raise ValueError("its binary chunk is cut short")
            chunk = data[start + 8 : start + 8 + size] if kind == b"BIN\0" else None
    else:
        text = data
    document = json.loads(text, parse_float=number)
    if not isinstance(document, dict):
        raise TypeError("it is not a JSON object")
    version = str(cast("dict[str, Any]", document)["asset"]["version"])
    if not version.startswith("2."):
        raise ValueError(f"it says glTF version {version}")
    return cast("dict[str, Any]", document), chunk


def _names_file(uri: object) -> bool:
    return isinstance(uri, str) and not uri.startswith("data:")


def _reference(uri: str, kind: Literal["image", "buffer"]) -> Reference:
    return Reference(uri, kind, escaped=unquote(uri) != uri)


def _parts(file: _File) -> tuple[Part, ...]:
    """Every primitive, once for each node that shows it."""
    document = file.document
    nodes = document.get("nodes", [])
    roots = document["scenes"][_index(document.get("scene", 0))].get("nodes", [])
    primitives: dict[int, list[Part]] = {}
    parts: list[Part] = []
    waiting = [(_index(root), np.eye(4), 0) for root in roots]
    seen: set[int] = set()
    while waiting:
        index, above, depth = waiting.pop()
        if index in seen or depth > _DEEPEST:
            raise ValueError("its nodes are no tree, or one of great depth")
        seen.add(index)
        node = nodes[index]
        place = above @ _matrix(node)
        waiting.extend((_index(child), place, depth + 1) for child in node.get("children", ()))
        if "mesh" not in node:
            continue
        mesh = _index(node["mesh"])
        if mesh not in primitives:
            primitives[mesh] = [_primitive(file, item) for item in document["meshes"][mesh]["primitives"]]
        file.unpack(sum(one.vertices.nbytes for one in primitives[mesh]))
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


def _primitive(file: _File, primitive: dict[str, Any]) -> Part:
    mode = primitive.get("mode", 4)
    vertices = _accessor(file, primitive["attributes"]["POSITION"])
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ValueError("positions do not have three coordinates")
    if "indices" in primitive:
        index = _accessor(file, primitive["indices"]).astype(np.int64).ravel()
    else:
        index = np.arange(len(vertices), dtype=np.int64)
    faces = _faces(mode, index)
    return part(vertices, faces)


def _faces(mode: object, index: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles of a list, a strip or a fan; points and lines have none."""
    if mode == 4:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if mode == 5 and len(index) > 2:
        return np.stack([index[:-2], index[1:-1], index[2:]], axis=1)
    if mode == 6 and len(index) > 2:
        return np.stack([np.full(len(index) - 2, index[0]), index[1:-1], index[2:]], axis=1)
    return np.zeros((0, 3), dtype=np.int64)


def _accessor(file: _File, number: object) -> NDArray[Any]:
    accessor = file.document["accessors"][_index(number)]
    width, kind = _WIDTHS[accessor["type"]], _COMPONENTS[accessor["componentType"]]
    count = _index(accessor["count"])
    file.unpack(count * width * np.dtype(kind).itemsize)
    if "bufferView" in accessor:
        found = _view(file, accessor["bufferView"], accessor.get("byteOffset", 0), kind, (count, width))
    else:
        found = np.zeros((count, width), dtype=kind)
    sparse = accessor.get("sparse")
    if sparse is not None:
        some = _index(sparse["count"])
        where, what = sparse["indices"], sparse["values"]
        rows = _view(
            file, where["bufferView"], where.get("byteOffset", 0), _COMPONENTS[where["componentType"]], (some, 1)
        )
        found = found.copy()
        found[rows.ravel().astype(np.int64)] = _view(
            file, what["bufferView"], what.get("byteOffset", 0), kind, (some, width)
        )
    return found / np.iinfo(kind).max if accessor.get("normalized") is True and kind != "<f4" else found


def _view(file: _File, number: object, offset: object, kind: str, shape: tuple[int, int]) -> NDArray[Any]:
    view = file.document["bufferViews"][_index(number)]
    data = _view_bytes(file, view)
    item = np.dtype(kind).itemsize * shape[1]
    stride = _index(view.get("byteStride", item))
    start = _index(offset)
    if shape[0] and start + stride * (shape[0] - 1) + item > len(data):
        raise ValueError("an accessor reaches past the end of its buffer")
    if not shape[0]:
        return np.zeros(shape, dtype=kind)
    return np.ndarray(shape, kind, data, start, (stride, np.dtype(kind).itemsize))


def _view_bytes(file: _File, view: dict[str, Any]) -> memoryview:
    data = _buffer(file, _index(view["buffer"]))
    start, size = _index(view.get("byteOffset", 0)), _index(view["byteLength"])
    if start + size > len(data):
        raise ValueError("a buffer view reaches past the end of its buffer")
    return memoryview(data)[start : start + size]


def _buffer(file: _File, number: int) -> bytes:
    if number not in file.buffers:
        buffer = file.document["buffers"][number]
        uri = buffer.get("uri")
        if uri is None:
            if number != 0 or file.chunk is None:
                raise ValueError("a buffer has neither a file nor a binary chunk")
            data = file.chunk
        else:
            data = file.reading.open_named(_reference(uri, "buffer")) if _names_file(uri) else _data_uri(uri)
        if _index(buffer["byteLength"]) > len(data):
            raise ValueError("a buffer is shorter than it says")
        file.buffers[number] = data
    return file.buffers[number]


def _embedded(file: _File, image: dict[str, Any]) -> bytes:
    if "uri" in image:
        return _data_uri(image["uri"])
    return bytes(_view_bytes(file, file.document["bufferViews"][_index(image["bufferView"])]))


def _data_uri(uri: str) -> bytes:
    head, comma, body = uri.partition(",")
    if not comma or not head.endswith(";base64"):
        raise ValueError("a data: URI is not base64")
    try:
        return base64.b64decode(unquote(body), validate=True)
    except binascii.Error as error:
        raise ValueError(f"a data: URI is not base64: {error}") from error


def _index(number: object) -> int:
    if isinstance(number, bool) or not isinstance(number, int) or number < 0:
        raise ValueError(f"{str(number)[:40]} is not an index or a size")
    return number
