"""Wavefront OBJ: vertices, faces, objects, and the files that it and its MTL name."""

from __future__ import annotations

import re
from array import array
from typing import TYPE_CHECKING

import numpy as np

from scenecc.checks.mesh_data import AssetError, MeshData, Reading, Reference, integer, number, part, plain_text

if TYPE_CHECKING:
    from collections.abc import Iterator

_MAPS = re.compile(r"(?i)(map_\w+|bump|norm|disp|decal|refl)\s+(.*)")
_VERTEX = re.compile(r"v +" + r" +".join([r"([-+]?[0-9]+\.?[0-9]*(?:[eE][-+]?[0-9]{1,3})?)"] * 3))
_TRIANGLE = re.compile(r"f +" + r" +".join([r"([1-9][0-9]{0,8})(?:/[0-9/]*)?"] * 3))
"""What nearly all lines of an OBJ are; all others are read word by word."""
_OPTION_WORDS = {"-mm": 2} | dict.fromkeys(
    ("-blendu", "-blendv", "-boost", "-texres", "-clamp", "-bm", "-imfchan", "-type", "-cc"), 1
)


def read_obj(data: bytes, reading: Reading) -> MeshData:
    """Reads an OBJ. A part is what lies between two `o` or `g` lines, as SAPIEN has it.

    Args:
        data: the file.
        reading: not used; an OBJ alone has all its triangles.

    Raises:
        AssetError: a line cannot be read.
    """
    del reading
    vertices, groups, materials = array("d"), [array("q")], dict[str, None]()
    row = 0
    try:
        for row, line in _lines(data):  # noqa: B007 - the message below names it
            if (plain := _VERTEX.fullmatch(line)) is not None:
                vertices.extend(map(float, plain.groups()))
            elif (plain := _TRIANGLE.fullmatch(line)) is not None:
                groups[-1].extend(int(index) - 1 for index in plain.groups())
            else:
                _other(line, vertices, groups, materials)
    except ValueError as error:
        raise AssetError("SC412", f"the OBJ cannot be read (line {row}): {error}", "export the mesh again") from error
    points = np.array(vertices).reshape(-1, 3)
    parts = tuple(part(points, np.array(faces).reshape(-1, 3)) for faces in groups if faces)
    return MeshData(parts, tuple(Reference(name, "material") for name in materials))


def _other(line: str, vertices: array[float], groups: list[array[int]], materials: dict[str, None]) -> None:
    """A line that is not of the usual two kinds."""
    word, _, rest = line.partition(" ")
    if word == "v":
        vertices.extend(_vertex(rest))
    elif word in {"f", "fo"}:
        groups[-1].extend(_triangles(rest, len(vertices) // 3))
    elif word in {"o", "g"}:
        groups.append(array("q"))
    elif word == "mtllib":
        materials[rest.strip()] = None
    elif word.startswith("f"):
        # SAPIEN's reader takes it for a face and gives up.
        groups[-1].extend(_triangles(word[1:], len(vertices) // 3))


def _lines(data: bytes) -> Iterator[tuple[int, str]]:
    """Numbered lines without blanks around them, continued ones joined, comments and empty ones left out."""
    waiting = ""
    for row, raw in enumerate(plain_text(data).split("\n"), start=1):
        line = waiting + raw.strip().replace("\t", " ")
        waiting = ""
        if line.endswith("\\"):
            waiting = line[:-1] + " "
        elif line and line[0] != "#":
            yield row, line


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
        matches = [_MAPS.match(line) for _, line in _lines(data)]
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
