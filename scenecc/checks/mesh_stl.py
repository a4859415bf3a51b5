"""STL, binary and text. Strict: what SAPIEN's own reader forgives differs from release to release."""

from __future__ import annotations

import re
from array import array
from typing import TYPE_CHECKING

import numpy as np

from scenecc.checks.mesh_data import (
    NUMBER_PATTERN,
    AssetError,
    MeshBudget,
    MeshData,
    MeshReadContext,
    MeshTextReader,
    line_pattern,
    line_run_pattern,
    make_part,
    parse_coordinate,
    parse_floats,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

_FACET_TYPE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_TEXT_FACET = 21
"""Words of `facet normal x y z outer loop vertex x y z vertex x y z vertex x y z endloop endfacet`."""
_FACET_WORDS = {
    0: "facet",
    1: "normal",
    5: "outer",
    6: "loop",
    7: "vertex",
    11: "vertex",
    15: "vertex",
    19: "endloop",
    20: "endfacet",
}
_LINE_WORD_COUNTS = {"facet": 5, "outer": 2, "vertex": 4, "endloop": 1, "endfacet": 1}
"""How many words the line has that begins so: SAPIEN's reader goes by lines."""
_FACET_RUN = line_run_pattern(
    lines=rb"[ \t]*".join(
        [
            b"",
            line_pattern(b"facet", b"normal", NUMBER_PATTERN, NUMBER_PATTERN, NUMBER_PATTERN),
            line_pattern(b"outer", b"loop"),
            *[line_pattern(b"vertex", NUMBER_PATTERN, NUMBER_PATTERN, NUMBER_PATTERN)] * 3,
            line_pattern(b"endloop"),
            line_pattern(b"endfacet"),
        ]
    )
)
_FACET_WORD = re.compile(rb"facet|normal|outer|loop|vertex|endloop|endfacet")
_COORDINATE_COLUMNS = [2, 3, 4, 8, 9, 10, 12, 13, 14, 16, 17, 18]


def read_stl(data: bytes, reading: MeshReadContext) -> MeshData:
    """Reads an STL. Corners in the same place become one vertex, as SAPIEN joins them.

    Raises:
        AssetError: it is neither a whole binary STL nor a whole text one.
    """
    budget = MeshBudget(reading.max_bytes, reading.total)
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + 50 * count:
        corners = np.frombuffer(data, _FACET_TYPE, count, 84)["corners"].reshape(-1, 3)
    elif data.lstrip()[:5] == b"solid":
        corners = _read_text_corners(data, budget)
    else:
        said = f"says {count} triangles" if len(data) >= 84 else "is shorter than its header"
        raise AssetError(
            "SC412", f"the STL is broken or cut short: it has {len(data)} bytes and {said}", "export the mesh again"
        )
    if not len(corners):
        return MeshData(())
    budget.take(corners.nbytes)
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    return MeshData((make_part(vertices, index.reshape(-1, 3)),))


def _read_text_corners(data: bytes, budget: MeshBudget) -> NDArray[np.float32]:
    corners = array("f")
    words: list[str] = []
    try:
        lines = MeshTextReader(data, budget)
        while True:
            if not words and (run := lines.run(_FACET_RUN)):
                numbers = parse_floats(_FACET_WORD.sub(b" ", run)).reshape(-1, 12)[:, 3:]
                with np.errstate(over="ignore"):
                    found = numbers.astype(np.float32)
                budget.take(found.nbytes)
                corners.frombytes(found.tobytes())
                continue
            line = lines.line()
            if line is None:
                break
            words += _next_words(line)
            if len(words) >= _TEXT_FACET:
                budget.take(36)
                with np.errstate(over="ignore"):
                    corners.frombytes(np.array(_parse_facet(words[:_TEXT_FACET])).astype(np.float32).tobytes())
                del words[:_TEXT_FACET]
    except ValueError as error:
        raise AssetError("SC412", f"the STL cannot be read: {error}", "export the mesh again") from error
    if words:
        raise AssetError("SC412", "the STL is cut short within a triangle", "export the mesh again")
    return np.frombuffer(corners, np.float32).reshape(-1, 3)


def _parse_facet(words: list[str]) -> list[float]:
    """The nine coordinates of a triangle."""
    for column, word in _FACET_WORDS.items():
        if words[column] != word:
            raise ValueError(f"it lacks the word `{word}`")
    return [parse_coordinate(words[column]) for column in _COORDINATE_COLUMNS][3:]


def _next_words(line: str) -> list[str]:
    """The words of a line; none of the lines that begin and end a solid, which hold its name."""
    words = line.split()
    if not words or words[0] in {"solid", "endsolid"}:
        return []
    if _LINE_WORD_COUNTS.get(words[0]) != len(words):
        raise ValueError(f"it has the line `{line.strip()[:60]}`")
    return words
