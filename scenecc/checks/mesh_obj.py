"""Wavefront OBJ: vertices, faces, objects, and the files that it and its MTL name."""

from __future__ import annotations

import re
from array import array
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from scenecc.checks.mesh_data import AssetError, MeshData, Reading, Reference, number, part
from scenecc.checks.mesh_text import NUMBER, Budget, Lines, floats, integers, run_of, words

if TYPE_CHECKING:
    from numpy.typing import NDArray

_CORNER = re.compile(r"(-?[1-9][0-9]{0,8})(?:/(-?[1-9][0-9]{0,8})?(?:/(-?[1-9][0-9]{0,8}))?)?")
_INDEX = rb"[1-9][0-9]{0,8}"
_TABLES = {
    run_of(b"v", *[NUMBER] * 3): 0,
    run_of(b"vt", *[NUMBER] * 2): 1,
    run_of(b"vt", *[NUMBER] * 3): 1,
    run_of(b"vn", *[NUMBER] * 3): 2,
}
"""Lines that hold numbers alone, by what they define: a place, a texture coordinate, a normal."""
_FACES = {
    run_of(b"f", *[corner] * corners): (corners, columns)
    for corners in (3, 4)
    for corner, columns in (
        (_INDEX, (0,)),
        (_INDEX + b"/" + _INDEX, (0, 1)),
        (_INDEX + b"//" + _INDEX, (0, 2)),
        (_INDEX + b"/" + _INDEX + b"/" + _INDEX, (0, 1, 2)),
    )
}
"""Triangles and squares, by their corners and what the numbers of one name. Other lines are read word by word."""
_COMMENTS = run_of(lines=rb"(?:#[^\n\\]*|[ \t]*\r?)\n")
_LONGEST_LINE = 1_000_000
_NAMED = ("vertex", "texture coordinate", "normal")
_LETTERS = {"v": 0, "vt": 1, "vn": 2}
_NUMBERS = ({3, 4, 6}, {2, 3}, {3})


def read_obj(data: bytes, reading: Reading) -> MeshData:
    """Reads an OBJ. A part is what lies between two `o` or `g` lines, as SAPIEN has it.

    Args:
        data: the file.
        reading: how much its triangles may take; an OBJ alone has them all.

    Raises:
        AssetError: a line cannot be read, or the triangles are too large.
    """
    mesh = _Mesh(Budget(reading.max_bytes, reading.total))
    row = 0
    try:
        lines = _lines(data, mesh.budget)
        while True:
            if not _run(lines, mesh):
                line = _continued(lines)
                if line is None:
                    break
                row = lines.row
                _line(line, mesh)
        _check_named(mesh)
    except ValueError as error:
        raise AssetError("SC412", f"the OBJ cannot be read (line {row}): {error}", "export the mesh again") from error
    points = np.frombuffer(mesh.vertices).reshape(-1, 3)
    parts = tuple(part(points, np.frombuffer(faces, np.int64).reshape(-1, 3)) for faces in mesh.groups if faces)
    parts = parts if mesh.has_faces else ()
    return MeshData(parts, tuple(Reference(name, "material") for name in mesh.materials))


def _lines(data: bytes, budget: Budget) -> Lines:
    if data.startswith(b"\xef\xbb\xbf") and data[3:4] not in {b"#", b"\r", b"\n"}:
        raise ValueError("a mark of UTF-8 stands before its first line, which SAPIEN's reader skips then")
    return Lines(data, budget)


def _continued(lines: Lines) -> str | None:
    """The next line, with those in which it goes on behind a backslash; None at the end.

    Raises:
        AssetError: it is longer than any that is meant.
    """
    pieces: list[str] = []
    length = 0
    while (line := lines.raw()) is not None:
        length += len(line)
        if length > _LONGEST_LINE:
            message = f"line {lines.row} of the OBJ has more than {_LONGEST_LINE} characters"
            raise AssetError("SC607", message, "export the mesh again, as triangles")
        if not line.endswith("\\"):
            return "".join([*pieces, line]) if pieces else line
        pieces.append(line[:-1])
    return "".join(pieces) if pieces else None


@dataclass(slots=True)
class _Mesh:
    """What was read so far: coordinates, and three indices a triangle for each group.

    Attributes:
        known: how many vertices, texture coordinates and normals were defined.
        named: the highest of each that a face names, counted from 1.
    """

    budget: Budget
    vertices: array[float] = field(default_factory=lambda: array("d"))
    groups: list[array[int]] = field(default_factory=lambda: [array("q")])
    materials: dict[str, None] = field(default_factory=dict[str, None])
    objects: set[str] = field(default_factory=set[str])
    group: str = ""
    known: list[int] = field(default_factory=lambda: [0, 0, 0])
    named: list[int] = field(default_factory=lambda: [0, 0, 0])
    has_faces: bool = False

    def add_vertices(self, numbers: NDArray[np.float64]) -> None:
        self.budget.take(numbers.nbytes)
        self.vertices.frombytes(numbers.tobytes())
        self.known[0] += numbers.size // 3

    def add_faces(self, index: NDArray[np.int64]) -> None:
        self.budget.take(index.nbytes)
        self.groups[-1].frombytes(index.tobytes())

    def start(self, name: str) -> None:
        """Begins an object: what follows is a part of its own."""
        self.budget.take(_GROUP_BYTES)
        self.groups.append(array("q"))
        self.objects.add(name)


_GROUP_BYTES = 512
"""About what an empty group takes."""


def _run(lines: Lines, mesh: _Mesh) -> bool:
    """Reads thousands of plain lines at once, where such are next."""
    match lines.letter():
        case b"v":
            for pattern, kind in _TABLES.items():
                if run := lines.run(pattern):
                    if kind == 0:
                        mesh.add_vertices(floats(run.replace(b"v", b" ")))
                    else:
                        mesh.known[kind] += run.count(b"\n")
                    return True
        case b"f":
            for pattern, (corners, columns) in _FACES.items():
                if run := lines.run(pattern):
                    index = integers(run.replace(b"f", b" ").replace(b"/", b" ")).reshape(-1, corners, len(columns))
                    for kind, highest in zip(columns, index.max(axis=(0, 1)).tolist(), strict=True):
                        _name(mesh, kind, highest)
                    fans = [index[:, [0, i, i + 1], 0] for i in range(1, corners - 1)]
                    mesh.has_faces = True
                    mesh.add_faces(np.stack(fans, axis=1) - 1)
                    return True
        case b"#" | b" " | b"\t" | b"\r" | b"\n":
            return bool(lines.run(_COMMENTS))
        case _:
            pass
    return False


def _name(mesh: _Mesh, kind: int, highest: int) -> None:
    if kind == 1 and mesh.known[2] and not mesh.known[1]:
        raise ValueError("a face names a texture coordinate before there is one, and SAPIEN takes it for a normal")
    mesh.named[kind] = max(mesh.named[kind], highest)


def _check_named(mesh: _Mesh) -> None:
    """That what faces name is there. Where a file has no texture coordinates or normals at all, no one misses them."""
    for kind in (1, 2):
        if 0 < mesh.known[kind] < mesh.named[kind]:
            raise ValueError(f"a face names a {_NAMED[kind]} that is not there")


def _line(line: str, mesh: _Mesh) -> None:
    """A line that is not of the usual kinds."""
    if not line.strip(" \t") or line[0] == "#":
        return
    if line[0] in " \t":
        raise ValueError("it begins with a blank, and SAPIEN's reader skips such lines")
    word, *rest = words(line)
    if word in _LETTERS:
        _define(_LETTERS[word], rest, mesh)
    elif word in {"f", "fo", "l", "p"}:
        mesh.has_faces = mesh.has_faces or word[0] == "f"
        mesh.add_faces(np.array(_triangles(word, rest, mesh), dtype=np.int64))
    elif word[0] in "flp" or word[:2] in _LETTERS or word == "cstype":
        # SAPIEN's reader goes by the first letters, and skips all lines inside `cstype`.
        raise ValueError(f"it has `{word[:40]}`, which is not read")
    elif word[0] == "o" and rest and rest[0] not in mesh.objects:
        mesh.start(rest[0])
    elif word[0] == "g" and (name := line[len(word) :].lstrip(" \t")) != mesh.group:
        mesh.start(name)
        mesh.group = name
    elif word == "mtllib":
        mesh.materials[line[len(word) :].lstrip(" \t")] = None


def _define(kind: int, rest: list[str], mesh: _Mesh) -> None:
    """A vertex, of which a fourth number divides three, and six hold a colour too; a texture coordinate; a normal."""
    numbers = [number(word) for word in rest]
    if len(numbers) not in _NUMBERS[kind] or (kind == 0 and len(numbers) == 4 and numbers[3] == 0):
        raise ValueError(f"a {_NAMED[kind]} has {min(_NUMBERS[kind])} coordinates, and not `{' '.join(rest)[:60]}`")
    if kind:
        mesh.known[kind] += 1
        return
    divisor = numbers[3] if len(numbers) == 4 else 1.0
    mesh.add_vertices(np.array([coordinate / divisor for coordinate in numbers[:3]]))


def _triangles(word: str, rest: list[str], mesh: _Mesh) -> list[int]:
    """A polygon as a fan, three indices a triangle; of lines and points, triangles without a size.

    In the file indices count from 1, negative ones back from the last that was defined.
    """
    corners = [_CORNER.fullmatch(corner) for corner in rest]
    found: list[list[int]] = []
    for kind in range(3):
        said = [int(corner[kind + 1]) for corner in corners if corner is not None and corner[kind + 1]]
        if mesh.known[kind] and said and len(said) < len(corners):
            raise ValueError(
                f"corners of one face name a {_NAMED[kind]} each, or none does, and not `{' '.join(rest)[:60]}`"
            )
        index = [corner if corner > 0 else mesh.known[kind] + 1 + corner for corner in said]
        if min(index, default=1) < 1 and (kind == 0 or mesh.known[kind]):
            raise ValueError(f"a face names a {_NAMED[kind]} before the first")
        if index:
            _name(mesh, kind, max(index))
        found.append([corner - 1 for corner in index])
    index = found[0]
    if (
        not index
        or len(index) < len(corners)
        or (word == "l" and len(index) < 2)
        or (word == "p" and "/" in "".join(rest))
    ):
        raise ValueError(f"`{word} {' '.join(rest)[:60]}` has no vertices, or numbers that are no index")
    if len(index) < 3 or word in {"l", "p"}:
        # No triangle, and yet the engine looks at its vertices.
        return [each for corner in index for each in (corner, corner, corner)]
    return [corner for i in range(1, len(index) - 1) for corner in (index[0], index[i], index[i + 1])]
