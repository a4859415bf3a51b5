"""Reader for Wavefront OBJ meshes and their MTL materials, with the files that they name."""

from __future__ import annotations

import re
from array import array
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from scenecc.checks.mesh_data import (
    NUMBER_PATTERN,
    AssetError,
    AssetReference,
    MeshBudget,
    MeshData,
    MeshReadContext,
    MeshTextReader,
    fan_triangles,
    line_run_pattern,
    make_part,
    parse_coordinate,
    parse_floats,
    parse_integers,
    split_words,
)
from scenecc.geometry.obj_materials import image_of_line

if TYPE_CHECKING:
    from numpy.typing import NDArray


_NUMBER_LINE = re.compile(r"([kK][adse]|Tf|Ps)|disp|[da]|Tr|[nN][si]|P[rm]|Pcr?")
"""How lines begin that hold a colour (the group) or a number: SAPIEN's reader looks at their first letters alone."""

_MTL_NUMBER = re.compile(r"(?i)[-+]?(?:(?:[0-9]{1,18}\.?[0-9]*|\.[0-9]+)(?:e[-+]?[0-9]{1,3})?|nan|inf|infinity)")


def mtl_images(data: bytes, budget: MeshBudget) -> tuple[AssetReference, ...]:
    """The images that an MTL names. SAPIEN looks for them next to the OBJ.

    Raises:
        AssetError: it is no text, SAPIEN reads a line of it otherwise, or it lacks a number, which ends the loading of
            the whole mesh.
    """
    names: dict[str, None] = {}
    row = 0
    try:
        lines = MeshTextReader(data, budget)
        while (raw := lines.raw()) is not None:
            row = lines.row
            line = raw.lstrip(" \t")
            _check_numbers(line)
            names[image_of_line(line)] = None
    except ValueError as error:
        message = f"the MTL cannot be read (line {row}): {error}"
        raise AssetError("SC412", message, "export the mesh again") from error
    return tuple(AssetReference(name, "image") for name in names if name)


def _check_numbers(line: str) -> None:
    match = _NUMBER_LINE.match(line)
    if match is None or match[0] == "disp":
        return
    words = split_words(line[match.end() :])
    if match[1] and len(words) != 1:
        words = [*words, "", ""][:3]
    elif match[1] and line[-1] in " \t":
        raise ValueError(f"`{line[:40]}` ends with a blank, after which SAPIEN's reader expects a number")
    wrong = next((word for word in words[: 3 if match[1] else 1] if _MTL_NUMBER.fullmatch(word) is None), None)
    if wrong is not None:
        raise ValueError(f"`{line[:40]}` lacks a number that SAPIEN's reader expects")


_CORNER_PATTERN = re.compile(r"(-?[1-9][0-9]{0,8})(?:/(-?[1-9][0-9]{0,8})?(?:/(-?[1-9][0-9]{0,8}))?)?")

_OBJ_INDEX = rb"[1-9][0-9]{0,8}"

_VERTEX_RUNS = {
    line_run_pattern(b"v", *[NUMBER_PATTERN] * 3): 0,
    line_run_pattern(b"vt", *[NUMBER_PATTERN] * 2): 1,
    line_run_pattern(b"vt", *[NUMBER_PATTERN] * 3): 1,
    line_run_pattern(b"vn", *[NUMBER_PATTERN] * 3): 2,
}
"""Lines that hold numbers alone, by what they define: a place, a texture coordinate, a normal."""

_FACE_RUNS = {
    line_run_pattern(b"f", *[corner] * corners): (corners, columns)
    for corners in (3, 4)
    for corner, columns in (
        (_OBJ_INDEX, (0,)),
        (_OBJ_INDEX + b"/" + _OBJ_INDEX, (0, 1)),
        (_OBJ_INDEX + b"//" + _OBJ_INDEX, (0, 2)),
        (_OBJ_INDEX + b"/" + _OBJ_INDEX + b"/" + _OBJ_INDEX, (0, 1, 2)),
    )
}
"""Triangles and squares, by their corners and what the numbers of one name. Other lines are read word by word."""

_COMMENT_RUN = line_run_pattern(lines=rb"(?:#[^\n\\]*|[ \t]*\r?)\n")

_MAX_LINE_CHARS = 1_000_000

_VERTEX_KINDS = ("vertex", "texture coordinate", "normal")

_VERTEX_WORDS = {"v": 0, "vt": 1, "vn": 2}

_VERTEX_NUMBER_COUNTS = ({3, 4, 6}, {2, 3}, {3})


def read_obj(data: bytes, reading: MeshReadContext) -> MeshData:
    """Reads an OBJ. A part is what lies between two `o` or `g` lines, as SAPIEN has it.

    Args:
        data: the file.
        reading: how much its triangles may take; an OBJ alone has them all.

    Raises:
        AssetError: a line cannot be read, or the triangles are too large.
    """
    mesh = _ObjState(MeshBudget(reading.max_bytes, reading.total))
    row = 0
    try:
        lines = _open_lines(data, mesh.budget)
        while True:
            if not _read_run(lines, mesh):
                line = _next_logical_line(lines)
                if line is None:
                    break
                row = lines.row
                _read_line(line, mesh)
        _check_indices(mesh)
    except ValueError as error:
        raise AssetError("SC412", f"the OBJ cannot be read (line {row}): {error}", "export the mesh again") from error
    points = np.frombuffer(mesh.vertices).reshape(-1, 3)
    groups = [np.frombuffer(faces, np.int64).reshape(-1, 3) for faces in mesh.groups if faces]
    parts = tuple(make_part(points, faces, reading.precision) for faces in groups)
    parts = parts if mesh.has_faces else ()
    return MeshData(parts, tuple(AssetReference(name, "material") for name in mesh.materials))


def _open_lines(data: bytes, budget: MeshBudget) -> MeshTextReader:
    if data.startswith(b"\xef\xbb\xbf") and data[3:4] not in {b"#", b"\r", b"\n"}:
        raise ValueError("a byte order mark precedes its first line, which SAPIEN's reader then skips")
    return MeshTextReader(data, budget)


def _next_logical_line(lines: MeshTextReader) -> str | None:
    """The next line, with those in which it goes on behind a backslash; None at the end.

    Raises:
        AssetError: it is longer than any that is meant.
    """
    pieces: list[str] = []
    length = 0
    while (line := lines.raw()) is not None:
        length += len(line)
        if length > _MAX_LINE_CHARS:
            message = f"line {lines.row} of the OBJ has more than {_MAX_LINE_CHARS} characters"
            raise AssetError("SC607", message, "export the mesh again, as triangles")
        if not line.endswith("\\"):
            return "".join([*pieces, line]) if pieces else line
        pieces.append(line[:-1])
    return "".join(pieces) if pieces else None


@dataclass(slots=True)
class _ObjState:
    """What was read so far: coordinates, and three indices a triangle for each group.

    Attributes:
        known: how many vertices, texture coordinates and normals were defined.
        named: the highest of each that a face names, counted from 1.
    """

    budget: MeshBudget
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


def _read_run(lines: MeshTextReader, mesh: _ObjState) -> bool:
    """Reads thousands of plain lines at once, where such are next."""
    match lines.letter():
        case b"v":
            for pattern, kind in _VERTEX_RUNS.items():
                if run := lines.run(pattern):
                    if kind == 0:
                        mesh.add_vertices(parse_floats(run.replace(b"v", b" ")))
                    else:
                        mesh.known[kind] += run.count(b"\n")
                    return True
        case b"f":
            for pattern, (corners, columns) in _FACE_RUNS.items():
                if run := lines.run(pattern):
                    index = parse_integers(run.replace(b"f", b" ").replace(b"/", b" ")).reshape(
                        -1, corners, len(columns)
                    )
                    for kind, highest in zip(columns, index.max(axis=(0, 1)).tolist(), strict=True):
                        _note_index(mesh, kind, highest)
                    mesh.has_faces = True
                    mesh.add_faces(fan_triangles(index[:, :, 0]) - 1)
                    return True
        case b"#" | b" " | b"\t" | b"\r" | b"\n":
            return bool(lines.run(_COMMENT_RUN))
        case _:
            pass
    return False


def _note_index(mesh: _ObjState, kind: int, highest: int) -> None:
    if kind == 1 and mesh.known[2] and not mesh.known[1]:
        raise ValueError("a face refers to a texture coordinate before the first one, and SAPIEN takes it for a normal")
    mesh.named[kind] = max(mesh.named[kind], highest)


def _check_indices(mesh: _ObjState) -> None:
    """That what faces name is there. Where a file has no texture coordinates or normals at all, no one misses them."""
    for kind in (1, 2):
        if 0 < mesh.known[kind] < mesh.named[kind]:
            raise ValueError(f"a face refers to a missing {_VERTEX_KINDS[kind]}")


def _read_line(line: str, mesh: _ObjState) -> None:
    """A line that is not of the usual kinds."""
    if not line.strip(" \t") or line[0] == "#":
        return
    if line[0] in " \t":
        raise ValueError("it begins with a blank; SAPIEN's reader skips such lines")
    word, *rest = split_words(line)
    if word in _VERTEX_WORDS:
        _define_vertex(_VERTEX_WORDS[word], rest, mesh)
    elif word in {"f", "fo", "l", "p"}:
        mesh.has_faces = mesh.has_faces or word[0] == "f"
        mesh.add_faces(np.array(_triangulate(word, rest, mesh), dtype=np.int64))
    elif word[0] in "flp" or word[:2] in _VERTEX_WORDS or word == "cstype":
        # SAPIEN's reader goes by the first letters, and skips all lines inside `cstype`.
        raise ValueError(f"it has `{word[:40]}`, which is not supported")
    elif word[0] == "o" and rest and rest[0] not in mesh.objects:
        mesh.start(rest[0])
    elif word[0] == "g" and (name := line[len(word) :].lstrip(" \t")) != mesh.group:
        mesh.start(name)
        mesh.group = name
    elif word == "mtllib":
        mesh.materials[line[len(word) :].lstrip(" \t")] = None


def _define_vertex(kind: int, rest: list[str], mesh: _ObjState) -> None:
    """A vertex, of which a fourth number divides three, and six hold a colour too; a texture coordinate; a normal."""
    numbers = [parse_coordinate(word) for word in rest]
    if len(numbers) not in _VERTEX_NUMBER_COUNTS[kind] or (kind == 0 and len(numbers) == 4 and numbers[3] == 0):
        wanted = f"{min(_VERTEX_NUMBER_COUNTS[kind])} coordinates"
        raise ValueError(f"a {_VERTEX_KINDS[kind]} has {wanted}, and not `{' '.join(rest)[:60]}`")
    if kind:
        mesh.known[kind] += 1
        return
    divisor = numbers[3] if len(numbers) == 4 else 1.0
    mesh.add_vertices(np.array([coordinate / divisor for coordinate in numbers[:3]]))


def _triangulate(word: str, rest: list[str], mesh: _ObjState) -> list[int]:
    """A polygon as a fan, three indices a triangle; of lines and points, triangles without a size.

    In the file indices count from 1, negative ones back from the last that was defined.
    """
    corners = [_CORNER_PATTERN.fullmatch(corner) for corner in rest]
    found: list[list[int]] = []
    for kind in range(3):
        numbers = [int(corner[kind + 1]) for corner in corners if corner is not None and corner[kind + 1]]
        if mesh.known[kind] and numbers and len(numbers) < len(corners):
            raise ValueError(
                f"corners of one face name a {_VERTEX_KINDS[kind]} each, or none does, and not `{' '.join(rest)[:60]}`"
            )
        index = [corner if corner > 0 else mesh.known[kind] + 1 + corner for corner in numbers]
        if min(index, default=1) < 1 and (kind == 0 or mesh.known[kind]):
            raise ValueError(f"a face refers to a {_VERTEX_KINDS[kind]} before the first one")
        if index:
            _note_index(mesh, kind, max(index))
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
