"""Wavefront OBJ: vertices, faces, objects, and the files that it and its MTL name."""

from __future__ import annotations

import re
from array import array
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from scenecc.checks.mesh_data import AssetError, MeshData, Reading, Reference, integer, number, part
from scenecc.checks.mesh_text import NUMBER, Budget, Lines, floats, integers, run_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MAPS = re.compile(r"(?i)(map_\w+|bump|norm|disp|decal|refl)\s+(.*)")
_VERTICES = run_of(b"v", NUMBER, NUMBER, NUMBER)
_TRIANGLES = run_of(b"f", *[rb"[1-9][0-9]{0,8}(?:/[0-9/]*)?"] * 3)
_PASSED = run_of(lines=rb"(?:v[nt][ \t]|#)[^\n\\]*\n")
"""What nearly all lines of an OBJ are; all others are read word by word."""
_SLASHES = re.compile(rb"/[0-9/]*")
_OPTION_WORDS = {"-mm": 2} | dict.fromkeys(
    ("-blendu", "-blendv", "-boost", "-texres", "-clamp", "-bm", "-imfchan", "-type", "-cc"), 1
)


def read_obj(data: bytes, reading: Reading) -> MeshData:
    """Reads an OBJ. A part is what lies between two `o` or `g` lines, as SAPIEN has it.

    Args:
        data: the file.
        reading: how much its triangles may take; an OBJ alone has them all.

    Raises:
        AssetError: a line cannot be read, or the triangles are too large.
    """
    mesh = _Mesh(Budget(reading.max_bytes))
    row = 0
    try:
        lines = Lines(data)
        while True:
            if run := lines.run(_VERTICES):
                mesh.add_vertices(floats(run.replace(b"v", b" ")))
            elif run := lines.run(_TRIANGLES):
                mesh.add_faces(integers(_SLASHES.sub(b"", run).replace(b"f", b" ")) - 1)
            elif not lines.run(_PASSED):
                line = _continued(lines)
                if line is None:
                    break
                row = lines.row
                _other(line, mesh)
    except ValueError as error:
        raise AssetError("SC412", f"the OBJ cannot be read (line {row}): {error}", "export the mesh again") from error
    points = np.frombuffer(mesh.vertices).reshape(-1, 3)
    parts = tuple(part(points, np.frombuffer(faces, np.int64).reshape(-1, 3)) for faces in mesh.groups if faces)
    return MeshData(parts, tuple(Reference(name, "material") for name in mesh.materials))


@dataclass(slots=True)
class _Mesh:
    """What was read so far: coordinates, and three indices a triangle for each group."""

    budget: Budget
    vertices: array[float] = field(default_factory=lambda: array("d"))
    groups: list[array[int]] = field(default_factory=lambda: [array("q")])
    materials: dict[str, None] = field(default_factory=dict[str, None])

    def add_vertices(self, numbers: NDArray[np.float64]) -> None:
        self.budget.take(numbers.nbytes)
        self.vertices.frombytes(numbers.tobytes())

    def add_faces(self, index: NDArray[np.int64]) -> None:
        self.budget.take(index.nbytes)
        self.groups[-1].frombytes(index.tobytes())


_GROUP_BYTES = 512
"""About what an empty group takes."""


def _other(line: str, mesh: _Mesh) -> None:
    """A line that is not of the usual kinds."""
    word, _, rest = line.partition(" ")
    if word == "v":
        mesh.add_vertices(np.array(_vertex(rest)))
    elif word.startswith("f"):
        # SAPIEN's reader takes `fx` for a face and gives up.
        text = rest if word in {"f", "fo"} else word[1:]
        mesh.add_faces(np.array(_triangles(text, len(mesh.vertices) // 3), dtype=np.int64))
    elif word in {"o", "g"}:
        mesh.budget.take(_GROUP_BYTES)
        mesh.groups.append(array("q"))
    elif word == "mtllib":
        mesh.materials[rest.strip()] = None


def _continued(lines: Lines) -> str | None:
    """The next line that is neither empty nor a comment, with those that continue it; None at the end."""
    waiting: list[str] = []
    while (raw := lines.line()) is not None:
        line = raw.replace("\t", " ")
        if line.endswith("\\"):
            waiting.append(line[:-1])
            continue
        line = " ".join([*waiting, line])
        waiting.clear()
        if line and line[0] != "#":
            return line
    return None


def _vertex(text: str) -> tuple[float, ...]:
    """Three coordinates; a fourth number divides them, six hold a colour too."""
    numbers = [number(word) for word in text.split()]
    if len(numbers) == 4 and numbers[3] != 0:
        return tuple(coordinate / numbers[3] for coordinate in numbers[:3])
    if len(numbers) not in {3, 6}:
        raise ValueError(f"a vertex has three coordinates, and not `{text.strip()[:60]}`")
    return tuple(numbers[:3])


def _triangles(text: str, known: int) -> list[int]:
    """A polygon as a fan, three indices a triangle.

    In the file they count from 1, negative ones back from the last vertex.
    """
    corners = [integer(corner.split("/", 1)[0]) for corner in text.split("#", 1)[0].split()]
    if not corners:
        raise ValueError("a face without vertices")
    if 0 in corners:
        raise ValueError("vertices count from 1, and the face names 0")
    index = [corner - 1 if corner > 0 else known + corner for corner in corners]
    if len(index) < 3:
        # No triangle, and yet the engine looks at its indices.
        return [index[0], index[0], index[-1]]
    return [corner for i in range(1, len(index) - 1) for corner in (index[0], index[i], index[i + 1])]


def mtl_images(data: bytes) -> tuple[Reference, ...]:
    """The images that an MTL names. SAPIEN seeks them beside the OBJ.

    Raises:
        AssetError: it is no text.
    """
    try:
        lines = Lines(data)
        matches = [_MAPS.match(line) for line in iter(lambda: _continued(lines), None)]
    except ValueError as error:
        raise AssetError("SC412", f"the MTL cannot be read: {error}", "export the mesh again") from error
    names = [_without_options(match[2].split(" ")) for match in matches if match]
    return tuple(Reference(name, "image") for name in dict.fromkeys(names) if name)


def _without_options(words: list[str]) -> str:
    """The file of a `map_…` line: what follows its options, blanks and all."""
    words = [word for word in words if word]
    while words and words[0].startswith("-"):
        option = words.pop(0).lower()
        if option in {"-o", "-s", "-t"}:
            while words and _is_number(words[0]):
                words.pop(0)
        else:
            del words[: _OPTION_WORDS.get(option, 0)]
    return " ".join(words)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
