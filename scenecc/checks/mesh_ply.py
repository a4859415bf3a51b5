"""PLY, binary and text. Strict: a PLY that is cut short, or has an index too many, ends SAPIEN's whole process."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from scenecc.checks.mesh_data import AssetError, MeshData, Reading, integer, number, part, plain_text

_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_FACES = {"vertex_indices", "vertex_index"}


@dataclass(frozen=True, slots=True)
class _Property:
    """One property; `count` is the type of a list's length, None for a single value."""

    name: str
    kind: str
    count: str | None = None


@dataclass(slots=True)
class _Element:
    name: str
    rows: int
    properties: list[_Property] = field(default_factory=list[_Property])


def read_ply(data: bytes, reading: Reading) -> MeshData:
    """Reads the vertices and faces of a PLY.

    Raises:
        AssetError: the header is not what PLY says, or the data does not hold what the header claims.
    """
    del reading
    try:
        order, elements, start = _header(data)
        if order and data[start : start + 1] in {b"\n", b"\r"}:
            # SAPIEN's reader skips it as a part of the header, reads every index shifted, and ends the process.
            hint = "export it as GLB or as a text PLY"
            raise AssetError("SC412", "its data begins with the byte of a line break, which crashes SAPIEN", hint)
        found = dict(_binary(data, start, order, elements) if order else _text(data[start:], elements))
        triangles = _triangles(found.get("face", []))
    except (ValueError, IndexError, OverflowError) as error:
        raise AssetError("SC412", f"the PLY is broken or cut short: {error}", "export the mesh again") from error
    if not triangles or "vertex" not in found:
        return MeshData(())
    vertices = np.array(found["vertex"], dtype=np.float64).reshape(-1, 3)
    return MeshData((part(vertices, np.array(triangles, dtype=np.int64).reshape(-1, 3)),))


def _triangles(faces: list[list[float]]) -> list[tuple[float, float, float]]:
    if any(len(face) < 3 for face in faces):
        # SAPIEN does not survive these.
        raise ValueError("a face has fewer than three corners")
    return [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    """Byte order ("" for text), elements, and where the data starts."""
    end = data.find(b"\nend_header", 0, 1 << 16) + 1
    newline = data.find(b"\n", end)
    if not data.startswith((b"ply\n", b"ply\r\n")) or end == 0 or newline < 0:
        raise ValueError("its header has no beginning or no end")
    order: str | None = None
    elements: list[_Element] = []
    for line in plain_text(data[:end]).split("\n")[1:-1]:
        words = line.split()
        match words:
            case ["format", kind, "1.0"] if kind in _ORDERS:
                order = _ORDERS[kind]
            case ["comment" | "obj_info", *_]:
                pass
            case ["element", name, rows] if rows.isdigit() and len(rows) < 12 and int(rows) <= len(data):
                elements.append(_Element(name, int(rows)))
            case ["property", "list", count, kind, name] if (
                elements and kind in _TYPES and _TYPES.get(count, "f")[0] in "iu"
            ):
                elements[-1].properties.append(_Property(name, _TYPES[kind], _TYPES[count]))
            case ["property", kind, name] if elements and kind in _TYPES:
                elements[-1].properties.append(_Property(name, _TYPES[kind]))
            case _:
                raise ValueError(f"its header has the line `{line[:60]}`")
    if order is None:
        raise ValueError("its header names no format")
    _check_elements(elements)
    return order, elements, newline + 1


def _check_elements(elements: list[_Element]) -> None:
    names = [element.name for element in elements]
    for element in elements:
        own = [one.name for one in element.properties]
        if len(set(own)) < len(own) or names.count(element.name) > 1:
            raise ValueError(f"its header names something twice in `{element.name}`")
        if element.name == "vertex" and not {"x", "y", "z"} <= {p.name for p in element.properties if p.kind[0] == "f"}:
            raise ValueError("its vertices have no coordinates x, y and z")
        if element.name == "face" and not any(p.name in _FACES and p.count for p in element.properties):
            raise ValueError("its faces have no vertex_indices")


def _binary(data: bytes, start: int, order: str, elements: list[_Element]) -> Iterator[tuple[str, list[list[float]]]]:
    for element in elements:
        if any(one.count for one in element.properties):
            rows, start = _lists(data, start, order, element)
            yield element.name, rows
            continue
        dtype = np.dtype([(one.name, order + one.kind) for one in element.properties])
        table = np.frombuffer(data, dtype, element.rows, start)
        start += dtype.itemsize * element.rows
        if element.name == "vertex":
            yield "vertex", np.stack([table[axis] for axis in "xyz"], axis=1).tolist()
    if start != len(data):
        raise ValueError(f"it has {len(data) - start} bytes more than its header claims")


def _lists(data: bytes, start: int, order: str, element: _Element) -> tuple[list[list[float]], int]:
    """The faces' indices, row by row, or of another element with lists nothing, and where it ends."""
    triangles = _only_triangles(data, start, order, element)
    if triangles is not None:
        return triangles
    kinds = [(one, np.dtype(order + one.kind), np.dtype(order + (one.count or "u1"))) for one in element.properties]
    rows: list[list[float]] = []
    for _ in range(element.rows):
        for one, item, length in kinds:
            count = 1
            if one.count:
                count = int(np.frombuffer(data, length, 1, start)[0])
                start += length.itemsize
            if count < 0:
                raise ValueError("a list has a negative length")
            values = np.frombuffer(data, item, count, start) if count else np.zeros(0, item)
            start += item.itemsize * count
            if one.name in _FACES and element.name == "face":
                rows.append([float(index) for index in values])
    return rows, start


def _only_triangles(data: bytes, start: int, order: str, element: _Element) -> tuple[list[list[float]], int] | None:
    """The same at once, where each face is three indices and nothing else; None where it is not so."""
    if element.name != "face" or len(element.properties) != 1:
        return None
    one = element.properties[0]
    dtype = np.dtype([("count", order + str(one.count)), ("index", order + one.kind, 3)])
    if start + dtype.itemsize * element.rows > len(data):
        return None
    table = np.frombuffer(data, dtype, element.rows, start)
    if not bool((table["count"] == 3).all()):
        return None
    return table["index"].tolist(), start + dtype.itemsize * element.rows


def _text(data: bytes, elements: list[_Element]) -> Iterator[tuple[str, list[list[float]]]]:
    lines = [line.split() for line in plain_text(data).split("\n") if line.strip()]
    if len(lines) != sum(element.rows for element in elements):
        raise ValueError("it has fewer or more lines than its header claims")
    at = 0
    for element in elements:
        yield element.name, [_row(words, element) for words in lines[at : at + element.rows]]
        at += element.rows


def _row(words: list[str], element: _Element) -> list[float]:
    """Coordinates of a vertex, indices of a face; what else stands in the line is only counted."""
    found: dict[str, list[float]] = {}
    at = 0
    for one in element.properties:
        count = 1
        if one.count:
            count, at = integer(words[at]), at + 1
        values = words[at : at + count]
        if count < 0 or len(values) < count:
            raise ValueError("a line has fewer numbers than it should")
        found[one.name] = [number(word) if one.kind[0] == "f" else integer(word) for word in values]
        at += count
    if at != len(words):
        raise ValueError("a line has more numbers than it should")
    if element.name == "vertex":
        return [number for axis in "xyz" for number in found[axis]]
    return next((found[name] for name in _FACES if name in found), list[float]())
