"""Wavefront OBJ: vertices, faces, objects, and the files that it and its MTL name."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from scenecc.checks.mesh_data import AssetError, MeshData, Part, Reading, Reference, part

if TYPE_CHECKING:
    from collections.abc import Iterator

_MAPS = re.compile(r"(?i)(map_\w+|bump|norm|disp|decal|refl)\s+(.*)")
_OPTION_WORDS = {"-mm": 2} | dict.fromkeys(
    ("-blendu", "-blendv", "-boost", "-texres", "-clamp", "-bm", "-imfchan", "-type", "-cc"), 1
)


def read_obj(data: bytes, reading: Reading) -> MeshData:
    """Reads an OBJ. A part is what lies between two `o` or `g` lines, as SAPIEN has it.

    Args:
        data: the file.
        reading: where the mesh is seen, its MTL is read too, to learn which images it names.

    Raises:
        AssetError: a line cannot be read, or a file that it names cannot.
    """
    vertices: list[tuple[float, ...]] = []
    groups: list[list[tuple[int, int, int]]] = [[]]
    materials: list[str] = []
    for number, line in _lines(data):
        word, _, rest = line.partition(" ")
        try:
            if word == "v":
                vertices.append(_vertex(rest))
            elif word in {"f", "fo"}:
                groups[-1].extend(_triangles(rest, len(vertices)))
            elif word in {"o", "g"}:
                groups.append([])
            elif word == "mtllib":
                materials.append(rest.strip())
            elif word.startswith("f"):
                # SAPIEN's reader takes it for a face and gives up.
                groups[-1].extend(_triangles(word[1:], len(vertices)))
        except ValueError as error:
            raise AssetError(
                "SC412", f"line {number} of the OBJ cannot be read: {error}", "export the mesh again"
            ) from error
    points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    parts = tuple(_part(points, faces) for faces in groups if faces)
    return MeshData(parts, _references(materials, reading))


def _lines(data: bytes) -> Iterator[tuple[int, str]]:
    """Numbered lines without blanks around them, continued ones joined, comments and empty ones left out."""
    text = data.removeprefix(b"\xef\xbb\xbf").decode("utf-8", "replace")
    waiting = ""
    for number, raw in enumerate(text.split("\n"), start=1):
        line = waiting + raw.strip().replace("\t", " ")
        waiting = ""
        if line.endswith("\\"):
            waiting = line[:-1] + " "
        elif line and line[0] != "#":
            yield number, line


def _vertex(text: str) -> tuple[float, ...]:
    numbers = text.split()
    if len(numbers) not in {3, 4, 6, 7}:
        raise ValueError(f"a vertex has three coordinates, not {len(numbers)} numbers")
    return tuple(map(float, numbers[:3]))


def _triangles(text: str, known: int) -> list[tuple[int, int, int]]:
    """A polygon as a fan. Indices count from 1, negative ones back from the last vertex."""
    corners = [int(corner.split("/", 1)[0]) for corner in text.split("#", 1)[0].split()]
    if not corners:
        raise ValueError("a face without vertices")
    if 0 in corners:
        raise ValueError("vertices count from 1, and the face names 0")
    index = [corner - 1 if corner > 0 else known + corner for corner in corners]
    return [(index[0], index[i], index[i + 1]) for i in range(1, len(index) - 1)]


def _part(points: np.ndarray[tuple[int, ...], np.dtype[np.float64]], faces: list[tuple[int, int, int]]) -> Part:
    try:
        return part(points, np.array(faces, dtype=np.int64))
    except OverflowError as error:
        raise AssetError("SC412", "a face names a vertex that is not there", "export the mesh again") from error


def _references(materials: list[str], reading: Reading) -> tuple[Reference, ...]:
    found: list[Reference] = []
    for name in dict.fromkeys(materials):
        library = Reference(name, "material")
        found.append(library)
        if reading.seen:
            found.extend(Reference(image, "image") for image in _images(reading.open_named(library)))
    return tuple(dict.fromkeys(found))


def _images(data: bytes) -> Iterator[str]:
    for _, line in _lines(data):
        match = _MAPS.match(line)
        if match is not None:
            name = _without_options(match[2].split(" "))
            if name:
                yield name


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
