"""STL, binary and text. Strict: what SAPIEN's own reader forgives differs from release to release."""

from __future__ import annotations

import numpy as np

from scenecc.checks.mesh_data import AssetError, MeshData, Reading, number, part, plain_text

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_TEXT_FACET = 21
"""Words of `facet normal x y z outer loop vertex x y z vertex x y z vertex x y z endloop endfacet`."""
_WORDS = {
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
_LINES = {"facet": 5, "outer": 2, "vertex": 4, "endloop": 1, "endfacet": 1}
"""How many words the line has that begins so: SAPIEN's reader goes by lines."""
_NUMBERS = [2, 3, 4, 8, 9, 10, 12, 13, 14, 16, 17, 18]


def read_stl(data: bytes, reading: Reading) -> MeshData:
    """Reads an STL. Corners in the same place become one vertex, as SAPIEN joins them.

    Raises:
        AssetError: it is neither a whole binary STL nor a whole text one.
    """
    del reading
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + 50 * count:
        corners = np.frombuffer(data, _FACET, count, 84)["corners"].reshape(-1, 3)
    elif data.lstrip()[:5].lower() == b"solid":
        corners = _text_corners(data)
    else:
        said = f"says {count} triangles" if len(data) >= 84 else "is shorter than its header"
        raise AssetError(
            "SC412", f"the STL is broken or cut short: it has {len(data)} bytes and {said}", "export the mesh again"
        )
    if not len(corners):
        return MeshData(())
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    return MeshData((part(vertices, index.reshape(-1, 3)),))


def _text_corners(data: bytes) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    try:
        words = [word for line in plain_text(data.lower()).split("\n") for word in _words(line)]
    except ValueError as error:
        raise AssetError("SC412", f"the STL cannot be read: {error}", "export the mesh again") from error
    if len(words) % _TEXT_FACET:
        raise AssetError("SC412", "the STL is cut short within a triangle", "export the mesh again")
    if not words:
        return np.zeros((0, 3), dtype=np.float32)
    table = np.array(words).reshape(-1, _TEXT_FACET)
    for column, word in _WORDS.items():
        if not bool((table[:, column] == word).all()):
            raise AssetError("SC412", f"the STL lacks the word `{word}`", "export the mesh again")
    try:
        with np.errstate(over="ignore"):
            numbers = np.array([[number(str(word)) for word in row] for row in table[:, _NUMBERS]])
            return numbers[:, 3:].astype(np.float32).reshape(-1, 3)
    except ValueError as error:
        raise AssetError("SC412", f"the STL cannot be read: {error}", "export the mesh again") from error


def _words(line: str) -> list[str]:
    """The words of a line; none of the lines that begin and end a solid, which hold its name."""
    words = line.split()
    if not words or words[0] in {"solid", "endsolid"}:
        return []
    if _LINES.get(words[0]) != len(words):
        raise ValueError(f"it has the line `{line.strip()[:60]}`")
    return words
