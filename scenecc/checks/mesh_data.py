"""What a mesh file holds, as far as the checks look at it, and the measures they take."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_NUMBER = re.compile(r"(?i)[-+]?(?:[0-9]{1,18}(?:\.[0-9]*)?(?:e([-+]?[0-9]{1,3}))?|nan|inf|infinity)")
"""What the engine's readers take for the same number; digits beyond these overflow there."""
_CONTROL = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")
_LONE_RETURN = re.compile(rb"\r(?![\r\n])")
_AT_ONCE = 2**18
"""How many triangles or points are measured at once: numbers in between take several times their size."""

_INTEGER = re.compile(r"[-+]?[0-9]{1,12}")


class AssetError(Exception):
    """Why an asset cannot be used: a code of band 4 or 6, a message and what to do."""

    def __init__(self, code: str, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.code, self.message, self.hint = code, message, hint


@dataclass(frozen=True, slots=True)
class Reference:
    """A file that an asset names.

    Attributes:
        uri: as written.
        kind: a texture and an OBJ's material file matter to what is seen, a buffer to everything; "instead" is what the
            engine opens where there is no such material file.
        escaped: it has percent escapes, which SAPIEN does not decode: it would look for a file of that very name.
    """

    uri: str
    kind: Literal["material", "image", "buffer", "instead"]
    escaped: bool = False


OpenNamed = Callable[[Reference], bytes]
"""Reads a file that the asset names. Raises `AssetError`."""


class TotalError(AssetError):
    """All files of a scene together take too much."""


@dataclass(slots=True)
class Total:
    """Counts what is read for one scene.

    Attributes:
        most: how much that may be (limit `assets_bytes`) [bytes].
        taken: how much it was.
        told: whether it was reported that this is too much.
    """

    most: int
    taken: int = 0
    told: bool = False

    def take(self, size: int) -> None:
        """Counts so many bytes.

        Raises:
            AssetError: they are too many.
        """
        self.taken += size
        if self.taken > self.most:
            raise TotalError(
                "SC607",
                f"with it, the files of the scene and their triangles take more than {self.most} bytes",
                "use fewer or simpler meshes, or raise the limit with --limit assets_bytes=N",
            )


@dataclass(frozen=True, slots=True)
class Reading:
    """How a mesh is read.

    Attributes:
        open_named: reads a file that it names.
        max_bytes: size of the largest file [bytes]; its triangles take a few times as much in memory.
        total: counts what all meshes of a scene take [bytes].
    """

    open_named: OpenNamed
    max_bytes: int
    total: Total


@dataclass(frozen=True, slots=True)
class Part:
    """What SAPIEN cooks to one convex shape when it loads several of a file.

    Attributes:
        vertices: (n, 3) float32, as the engine has them [m].
        faces: (m, 3) indices into `vertices`.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class MeshData:
    """A mesh file: its parts, the files it names and the images it holds itself.

    Attributes:
        fault: why it cannot be shown, where it still collides.
    """

    parts: tuple[Part, ...]
    references: tuple[Reference, ...] = ()
    images: tuple[bytes, ...] = ()
    fault: AssetError | None = None


def plain_text(data: bytes) -> str:
    """A text file as text.

    Raises:
        ValueError: it holds characters that no text has.
    """
    check_plain(data)
    return data.removeprefix(b"\xef\xbb\xbf").decode("utf-8", "replace")


def check_plain(data: bytes) -> None:
    """Whether it can be a text.

    Raises:
        ValueError: it holds characters that no text has.
    """
    if _CONTROL.search(data) is not None:
        raise ValueError("it holds control characters, so it is no text")
    if b"\r" in data and _LONE_RETURN.search(data) is not None:
        raise ValueError("it has a carriage return without a line feed, which ends a line for SAPIEN alone")


def number(word: str) -> float:
    """A coordinate of a text file.

    Raises:
        ValueError: it is written in a way that Python reads and the engine does not (`1_0`, `.5`, `0.e50000`).
    """
    match = _NUMBER.fullmatch(word)
    value = 0.0 if match is None else float(word)
    # Ten to that power is infinite in single precision: nothing times it is no number there.
    if match is None or (int(match[1] or 0) > 38 and abs(value) < 1e38):
        raise ValueError(f"`{word[:40]}` is no number")
    return value


def integer(word: str) -> int:
    """An index of a text file.

    Raises:
        ValueError: it is none.
    """
    if _INTEGER.fullmatch(word) is None:
        raise ValueError(f"`{word[:40]}` is no index")
    return int(word)


def part(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> Part:
    """A part with the vertices that its faces use.

    Raises:
        AssetError: a face names a vertex that is not there.
    """
    if len(faces) and (int(faces.min()) < 0 or int(faces.max()) >= len(vertices)):
        raise AssetError("SC412", "a face names a vertex that is not there", "export the mesh again")
    if 4 * faces.size < len(vertices):
        used, flat = np.unique(faces, return_inverse=True)
    else:
        # The same without sorting; not for each of many small parts of one large table of vertices.
        named = np.zeros(len(vertices), dtype=bool)
        named[faces] = True
        used, flat = np.flatnonzero(named), (np.cumsum(named) - 1)[faces]
    with np.errstate(over="ignore"):
        return Part(vertices[used].astype(np.float32), flat.reshape(-1, 3).astype(np.int64, copy=False))


def extents(vertices: NDArray[np.float32]) -> tuple[float, float]:
    """Thickness and length of a cloud of finite points, along its principal axes [m]."""
    centre = vertices.mean(axis=0, dtype=np.float64)
    pieces = range(0, len(vertices), _AT_ONCE)
    spread = np.zeros((3, 3))
    for start in pieces:
        centred = vertices[start : start + _AT_ONCE] - centre
        spread += centred.T @ centred
    axes = np.linalg.eigh(spread)[1]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for start in pieces:
        along = (vertices[start : start + _AT_ONCE] - centre) @ axes
        low, high = np.minimum(low, along.min(axis=0)), np.maximum(high, along.max(axis=0))
    size = high - low
    return float(size.min()), float(size.max())


def area(mesh: Part) -> float:
    """Area of the triangles [m²]."""
    total = 0.0
    for start in range(0, len(mesh.faces), _AT_ONCE):
        corners = mesh.vertices[mesh.faces[start : start + _AT_ONCE]].astype(np.float64)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        total += float(np.linalg.norm(normals, axis=1).sum() / 2)
    return total


def connected(mesh: Part) -> tuple[Part, ...]:
    """The parts of a mesh that share no vertex. Vertices in the same place are still two."""
    label = np.arange(len(mesh.vertices))
    while True:
        # The lowest of the trees that meet in a triangle takes the others, root and all: their number halves at least.
        roots = label[mesh.faces]
        lowest = roots.min(axis=1)
        if bool((roots == lowest[:, None]).all()):
            break
        np.minimum.at(label, roots.ravel(), np.repeat(lowest, 3))
        while not np.array_equal(label, label[label]):
            label = label[label]
    order = np.argsort(label[mesh.faces[:, 0]], kind="stable")
    starts = np.flatnonzero(np.diff(label[mesh.faces[order, 0]])) + 1
    return tuple(part(mesh.vertices, mesh.faces[rows]) for rows in np.split(order, starts))
