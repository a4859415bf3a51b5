"""PLY, binary and text. Strict: a PLY that is cut short, or has an index too many, ends SAPIEN's whole process."""

from __future__ import annotations

import re
import struct
from array import array
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.checks.mesh_data import (
    INDEX_PATTERN,
    MAX_RUN_LINES,
    NUMBER_PATTERN,
    ROW_BYTES,
    AssetError,
    MeshBudget,
    MeshData,
    MeshReadContext,
    MeshTextReader,
    decode_text,
    fan_triangles,
    line_run_pattern,
    make_part,
    parse_coordinate,
    parse_floats,
    parse_index,
    parse_integers,
    split_words,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

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
_FACE_PROPERTIES = {"vertex_indices", "vertex_index"}
_STRUCT_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}
_COUNTING_COMMENT = re.compile(
    rb"ply\r?\n[ \t]*format[ \t]+ascii[^\n]*\n"
    rb"(?:(?![ \t]*(?:element|comment[ \t]+\S))[^\n]*\n)*[ \t]*comment[ \t]+[0-9]"
)
"""SAPIEN's reader leaves out as many rows of a text as its first comment says, if that begins with a number."""
_TWO_BLANKS = re.compile(r"(?:format|property[ \t]+list)[ \t]* {2}")
_TRIANGLES = line_run_pattern(b"3", INDEX_PATTERN, INDEX_PATTERN, INDEX_PATTERN)


@dataclass(frozen=True, slots=True)
class _PlyProperty:
    """One property; `count` is the type of a list's length, None for a single value."""

    name: str
    kind: str
    count: str | None = None


@dataclass(slots=True)
class _PlyElement:
    name: str
    rows: int
    properties: list[_PlyProperty] = field(default_factory=list[_PlyProperty])


def read_ply(data: bytes, reading: MeshReadContext) -> MeshData:
    """Reads the vertices and faces of a PLY.

    Raises:
        AssetError: the header is not what PLY says, or the data does not hold what the header claims.
    """
    budget = MeshBudget(reading.max_bytes, reading.total)
    try:
        order, elements, start = _read_header(data)
        if order and data[start : start + 1] in {b"\n", b"\r"}:
            # SAPIEN's reader skips it as a part of the header, reads every index shifted, and ends the process.
            hint = "export it as GLB or as a text PLY"
            raise AssetError("SC412", "its data begins with a line break byte, which crashes SAPIEN", hint)
        found = dict(
            _read_binary(data, start, order, elements, budget) if order else _read_text(data, start, elements, budget)
        )
    except (ValueError, IndexError, OverflowError, struct.error) as error:
        raise AssetError("SC412", f"the PLY is broken or truncated: {error}", "export the mesh again") from error
    faces = found.get("face")
    if faces is None or not len(faces) or "vertex" not in found:
        return MeshData(())
    fault = None
    if b"TextureFile" in data[:start]:
        what = "its header names a texture, which SAPIEN finds in some headers, misses in others and misreads in more"
        fault = AssetError("SC410", what, "export it as GLB, or take the comment out")
    part = make_part(found["vertex"], faces.astype(np.int64, copy=False), reading.precision)
    return MeshData((part,), fault=fault)


def _triangulate(faces: NDArray[Any], budget: MeshBudget) -> NDArray[np.int64]:
    """Triangles of faces that have the same number of corners each, (m, corners)."""
    corners = faces.shape[1]
    if len(faces) and corners < 3:
        # SAPIEN does not survive these.
        raise ValueError("a face has fewer than three corners")
    budget.take(len(faces) * 24 * max(0, corners - 2))
    with np.errstate(invalid="ignore"):
        index = faces.astype(np.int64)
    return fan_triangles(index)


def _read_header(data: bytes) -> tuple[str, list[_PlyElement], int]:
    """Byte order ("" for text), elements, and where the data starts."""
    end = data.find(b"\nend_header", 0, 1 << 16) + 1
    newline = max(data.find(b"\n", end), end)
    if not data.startswith((b"ply\n", b"ply\r\n")) or data[end:newline].rstrip(b" \t\r") != b"end_header":
        raise ValueError("its header has no start or no end")
    if _COUNTING_COMMENT.match(data, 0, end):
        raise ValueError("the first comment of its header begins with a number, which SAPIEN takes for a count of rows")
    order: str | None = None
    elements: list[_PlyElement] = []
    for line in decode_text(data[:end]).split("\n")[1:-1]:
        if _TWO_BLANKS.match(line):
            raise ValueError(f"its header has two blanks in `{line[:60]}`, where SAPIEN's reader takes one")
        match split_words(line.removesuffix("\r")):
            case ["format", kind, "1.0"] if kind in _ORDERS and order is None:
                order = _ORDERS[kind]
            case _ if order is None:
                raise ValueError("its second line is not a format")
            case ["comment" | "obj_info", *_]:
                pass
            case ["element", name, rows] if rows.isdigit() and len(rows) < 12 and int(rows) <= len(data):
                elements.append(_PlyElement(name, int(rows)))
            case ["property", "list", count, kind, name] if (
                elements and kind in _TYPES and _TYPES.get(count, "f")[0] in "iu"
            ):
                elements[-1].properties.append(_PlyProperty(name, _TYPES[kind], _TYPES[count]))
            case ["property", kind, name] if elements and kind in _TYPES:
                elements[-1].properties.append(_PlyProperty(name, _TYPES[kind]))
            case _:
                raise ValueError(f"its header has the line `{line[:60]}`")
    if order is None:
        raise ValueError("its header has no format")
    _check_elements(elements)
    return order, elements, newline + 1


def _check_elements(elements: list[_PlyElement]) -> None:
    names = [element.name for element in elements]
    for element in elements:
        own = [one.name for one in element.properties]
        if len(set(own)) < len(own) or names.count(element.name) > 1:
            raise ValueError(f"its header has a duplicate name in `{element.name}`")
        if element.name == "vertex" and not {"x", "y", "z"} <= {p.name for p in element.properties if p.kind[0] == "f"}:
            raise ValueError("its vertices do not have the coordinates x, y and z")
        if element.name == "face" and not any(p.name in _FACE_PROPERTIES and p.count for p in element.properties):
            raise ValueError("its faces have no vertex_indices")


def _read_binary(
    data: bytes, start: int, order: str, elements: list[_PlyElement], budget: MeshBudget
) -> Iterator[tuple[str, NDArray[Any]]]:
    """Vertices, (n, 3), and triangles, (m, 3)."""
    for element in elements:
        dtype = _row_type(data, start, order, element)
        table = None
        if start + dtype.itemsize * element.rows <= len(data):
            table = np.frombuffer(data, dtype, element.rows, start)
        lists = [one for one in element.properties if one.count]
        if table is None or any(bool((table["#" + one.name] != table["#" + one.name][:1]).any()) for one in lists):
            if not lists:
                raise ValueError("it has fewer bytes than its header claims")
            faces, start = _read_uneven_faces(data, start, order, element, budget)
        else:
            start += dtype.itemsize * element.rows
            named = next((one.name for one in lists if one.name in _FACE_PROPERTIES and element.name == "face"), None)
            faces = None if named is None else _triangulate(table[named], budget)
            if element.name == "vertex":
                budget.take(12 * element.rows)
                yield "vertex", np.stack([table[axis] for axis in "xyz"], axis=1)
        if element.name == "face" and faces is not None:
            yield "face", faces
    if start != len(data):
        raise ValueError(f"it has {len(data) - start} bytes more than its header claims")


def _row_type(data: bytes, start: int, order: str, element: _PlyElement) -> np.dtype[Any]:
    """The layout of an element's rows, if all have lists as long as those of the first one."""
    columns: list[tuple[str, str, tuple[int, ...]]] = []
    for one in element.properties:
        count: tuple[int, ...] = ()
        if one.count:
            length = np.dtype(order + one.count)
            columns.append(("#" + one.name, length.str, ()))
            count = (int(np.frombuffer(data, length, 1, start)[0]) if element.rows else 0,)
            if count[0] < 0 or count[0] > len(data):
                raise ValueError("a list has an invalid length")
            start += length.itemsize
        columns.append((one.name, order + one.kind, count))
        start += np.dtype(one.kind).itemsize * (count[0] if count else 1)
    return np.dtype(columns)


def _read_uneven_faces(
    data: bytes, start: int, order: str, element: _PlyElement, budget: MeshBudget
) -> tuple[NDArray[np.int64], int]:
    """The triangles of an element whose lists differ in length, one after another, and where it ends."""
    ends = order.replace("|", "") or "<"
    plan = [
        (
            one.name in _FACE_PROPERTIES and element.name == "face",
            _STRUCT_CODES[one.kind],
            np.dtype(one.kind).itemsize,
            one.count,
        )
        for one in element.properties
    ]
    lengths = {code: struct.Struct(ends + code) for code in set(_STRUCT_CODES.values())}
    triangles = array("q")
    budget.spend(ROW_BYTES * element.rows * len(plan))
    for _ in range(element.rows):
        for wanted, code, size, counted in plan:
            count = 1
            if counted:
                length = lengths[_STRUCT_CODES[counted]]
                (count,) = length.unpack_from(data, start)
                start += length.size
            if count < 0 or start + size * count > len(data):
                raise ValueError("a list is truncated")
            if wanted:
                _add_fan(struct.unpack_from(f"{ends}{count}{code}", data, start), triangles, budget)
            start += size * count
    return np.frombuffer(triangles, np.int64).reshape(-1, 3), start


def _add_fan(corners: Sequence[float], triangles: array[int], budget: MeshBudget) -> None:
    if len(corners) < 3:
        # SAPIEN does not survive these.
        raise ValueError("a face has fewer than three corners")
    budget.take(24 * (len(corners) - 2))
    index = [int(corner) for corner in corners]
    for i in range(1, len(index) - 1):
        triangles.extend((index[0], index[i], index[i + 1]))


def _read_text(
    data: bytes, start: int, elements: list[_PlyElement], budget: MeshBudget
) -> Iterator[tuple[str, NDArray[Any]]]:
    """Likewise, of a text."""
    lines = MeshTextReader(data, budget, start)
    for element in elements:
        if element.name == "face":
            yield "face", _read_text_faces(lines, element, budget)
            continue
        numbers = array("d")
        plain = not any(one.count for one in element.properties)
        names = [one.name for one in element.properties]
        axes = [names.index(axis) for axis in "xyz"] if element.name == "vertex" else []
        pattern = line_run_pattern(
            *[NUMBER_PATTERN if one.kind[0] == "f" else INDEX_PATTERN for one in element.properties]
        )
        left = element.rows
        while left:
            if plain and left >= MAX_RUN_LINES and (run := lines.run(pattern)):
                left -= run.count(b"\n")
                table = parse_floats(run).reshape(-1, len(names))[:, axes]
                budget.take(table.nbytes)
                numbers.frombytes(table.tobytes())
                continue
            row = _read_row(_next_words(lines), element)
            left -= 1
            if axes:
                budget.take(24)
                numbers.extend(row)
        yield element.name, np.frombuffer(numbers).reshape(-1, 3)
    if lines.filled() is not None:
        raise ValueError("it has more lines than its header claims")


def _read_text_faces(lines: MeshTextReader, element: _PlyElement, budget: MeshBudget) -> NDArray[np.int64]:
    triangles = array("q")
    left = element.rows
    while left:
        if len(element.properties) == 1 and left >= MAX_RUN_LINES and (run := lines.run(_TRIANGLES)):
            left -= run.count(b"\n")
            index = parse_integers(run).reshape(-1, 4)[:, 1:]
            budget.take(index.nbytes)
            triangles.frombytes(index.tobytes())
            continue
        row = _read_row(_next_words(lines), element)
        left -= 1
        _add_fan(row, triangles, budget)
    return np.frombuffer(triangles, np.int64).reshape(-1, 3)


def _next_words(lines: MeshTextReader) -> list[str]:
    line = lines.filled()
    if line is None:
        raise ValueError("it has fewer lines than its header claims")
    return split_words(line)


def _read_row(words: list[str], element: _PlyElement) -> list[float]:
    """Coordinates of a vertex, indices of a face; what else stands in the line is only counted."""
    found: dict[str, list[float]] = {}
    at = 0
    for one in element.properties:
        count = 1
        if one.count:
            count, at = parse_index(words[at]), at + 1
        values = words[at : at + count]
        if count < 0 or len(values) < count:
            raise ValueError("a line has fewer numbers than it should")
        found[one.name] = [parse_coordinate(word) if one.kind[0] == "f" else parse_index(word) for word in values]
        at += count
    if at != len(words):
        raise ValueError("a line has more numbers than it should")
    if element.name == "vertex":
        return [number for axis in "xyz" for number in found[axis]]
    return next((found[name] for name in _FACE_PROPERTIES if name in found), list[float]())
