"""Mesh data, measures and limits that all mesh readers share, and a fast reader for text formats. Text is read
thousands of lines at once where the lines are regular, and word by word elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenecc.assets.errors import AssetError

if TYPE_CHECKING:
    from numpy.typing import NDArray


_COORDINATE_PATTERN = re.compile(r"(?i)[-+]?(?:[0-9]{1,18}(?:\.[0-9]*)?(?:e([-+]?[0-9]{1,3}))?|nan|inf|infinity)")
"""What the engine's readers take for the same number; digits beyond these overflow there."""

_CONTROL_CHARACTER = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")

_LONE_RETURN = re.compile(rb"\r(?![\r\n])")

_CHUNK_SIZE = 2**18
"""How many triangles or points are measured at once: numbers in between take several times their size."""

_INDEX_PATTERN = re.compile(r"[-+]?[0-9]{1,12}")


@dataclass(frozen=True, slots=True)
class AssetReference:
    """A file that an asset names.

    Attributes:
        uri: as written.
        kind: images and OBJ material files matter to visual meshes, buffers to all; "instead" is a file that the engine
            opens in place of a missing material file.
        escaped: it has percent escapes, which SAPIEN does not decode: it would look for a file of that very name.
    """

    uri: str
    kind: Literal["material", "image", "buffer", "instead"]
    escaped: bool = False


OpenReference = Callable[[AssetReference], bytes]
"""Reads a file that the asset names. Raises `AssetError`."""


class AssetBudgetError(AssetError):
    """All files of a scene together take too much."""


@dataclass(slots=True)
class AssetBudget:
    """Counts what is read for one scene.

    Attributes:
        most: how much that may be (limit `assets_bytes`) [bytes].
        taken: how much it was.
        exceeded: whether it was reported that this is too much.
    """

    most: int
    taken: int = 0
    exceeded: bool = False

    def take(self, size: int) -> None:
        """Counts so many bytes.

        Raises:
            AssetError: they are too many.
        """
        self.taken += size
        if self.taken > self.most:
            raise AssetBudgetError(
                "SC607",
                f"with it, the files of the scene and their triangles take more than {self.most} bytes",
                "use fewer or simpler meshes, or raise the limit with --limit assets_bytes=N",
            )


Precision = type[np.float32] | type[np.float64]


@dataclass(frozen=True, slots=True)
class MeshReadContext:
    """How a mesh is read.

    Attributes:
        open_named: reads a file that it names.
        max_bytes: size of the largest file [bytes]; its triangles take a few times as much in memory.
        total: counts what all meshes of a scene take [bytes].
        precision: of coordinates: the engine's, or that in which a text can be written.
    """

    open_named: OpenReference
    max_bytes: int
    total: AssetBudget
    precision: Precision = np.float32


@dataclass(frozen=True, slots=True)
class MeshFilePart:
    """What SAPIEN cooks to one convex shape when it loads several of a file.

    Attributes:
        vertices: (n, 3), as the engine has them where `Precision` is not float64 [m].
        faces: (m, 3) indices into `vertices`.
    """

    vertices: NDArray[Any]
    faces: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class MeshData:
    """A mesh file: its parts, the files it names and the images it holds itself.

    Attributes:
        fault: why it cannot be shown, where it still collides.
    """

    parts: tuple[MeshFilePart, ...]
    references: tuple[AssetReference, ...] = ()
    images: tuple[bytes, ...] = ()
    fault: AssetError | None = None


def decode_text(data: bytes) -> str:
    """A text file as text.

    Raises:
        ValueError: it holds characters that no text has.
    """
    check_text(data)
    return data.removeprefix(b"\xef\xbb\xbf").decode("utf-8", "replace")


def check_text(data: bytes) -> None:
    """Whether it can be a text.

    Raises:
        ValueError: it holds characters that no text has.
    """
    if _CONTROL_CHARACTER.search(data) is not None:
        raise ValueError("it contains control characters, so it is not text")
    if b"\r" in data and _LONE_RETURN.search(data) is not None:
        raise ValueError("it has a carriage return without a line feed, which only SAPIEN takes for a line end")


def parse_coordinate(word: str) -> float:
    """A coordinate of a text file.

    Raises:
        ValueError: it is written in a way that Python reads and the engine does not (`1_0`, `.5`, `0.e50000`).
    """
    match = _COORDINATE_PATTERN.fullmatch(word)
    value = 0.0 if match is None else float(word)
    # Ten to that power is infinite in single precision: nothing times it is no number there.
    if match is None or (int(match[1] or 0) > 38 and abs(value) < 1e38):
        raise ValueError(f"`{word[:40]}` is not a number")
    return value


def parse_index(word: str) -> int:
    """An index of a text file.

    Raises:
        ValueError: it is none.
    """
    if _INDEX_PATTERN.fullmatch(word) is None:
        raise ValueError(f"`{word[:40]}` is not an index")
    return int(word)


def make_part(
    vertices: NDArray[np.floating], faces: NDArray[np.integer], precision: Precision = np.float32
) -> MeshFilePart:
    """A part with the vertices that its faces use.

    Raises:
        AssetError: a face refers to a missing vertex.
    """
    if len(faces) and (int(faces.min()) < 0 or int(faces.max()) >= len(vertices)):
        raise AssetError("SC412", "a face refers to a missing vertex", "export the mesh again")
    if 4 * faces.size < len(vertices):
        used, flat = np.unique(faces, return_inverse=True)
    else:
        # The same without sorting; not for each of many small parts of one large table of vertices.
        named = np.zeros(len(vertices), dtype=bool)
        named[faces] = True
        used, flat = np.flatnonzero(named), (np.cumsum(named) - 1)[faces]
    with np.errstate(over="ignore"):
        return MeshFilePart(vertices[used].astype(precision), flat.reshape(-1, 3).astype(np.int64, copy=False))


def transform_part(part: MeshFilePart, place: NDArray[np.float64], precision: Precision) -> MeshFilePart:
    """A part where a node places it. `place`: (4, 4)."""
    with np.errstate(all="ignore"):
        return MeshFilePart((part.vertices @ place[:3, :3].T + place[:3, 3]).astype(precision), part.faces)


def fan_triangles(polygons: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles (·, 3) of polygons (n, corners), about the first corner of each; of fewer than three corners, none."""
    second, third = polygons[:, 1:-1], polygons[:, 2:]
    first = np.broadcast_to(polygons[:, :1], second.shape)
    return np.stack([first, second, third], axis=2).reshape(-1, 3)


def strip_triangles(strip: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles (·, 3) of a strip (n,)."""
    return np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)


def principal_extents(vertices: NDArray[np.float32]) -> tuple[float, float]:
    """Thickness and length of a cloud of finite points, along its principal axes [m]."""
    centre = vertices.mean(axis=0, dtype=np.float64)
    pieces = range(0, len(vertices), _CHUNK_SIZE)
    spread = np.zeros((3, 3))
    for start in pieces:
        centred = vertices[start : start + _CHUNK_SIZE] - centre
        spread += centred.T @ centred
    axes = np.linalg.eigh(spread)[1]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for start in pieces:
        along = (vertices[start : start + _CHUNK_SIZE] - centre) @ axes
        low, high = np.minimum(low, along.min(axis=0)), np.maximum(high, along.max(axis=0))
    size = high - low
    return float(size.min()), float(size.max())


def is_degenerate(mesh: MeshFilePart) -> bool:
    """Whether PhysX leaves out all triangles: the square of a normal's length is 0 in single precision."""
    for start in range(0, len(mesh.faces), _CHUNK_SIZE):
        corners = mesh.vertices[mesh.faces[start : start + _CHUNK_SIZE]].astype(np.float32)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        if (normals * normals).sum(axis=1).any():
            return False
    return True


def connected_parts(mesh: MeshFilePart) -> tuple[MeshFilePart, ...]:
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
    return tuple(make_part(mesh.vertices, mesh.faces[rows]) for rows in np.split(order, starts))


EXPONENT_PATTERN = rb"(?:[eE](?:-[0-9]{1,3}|\+?0{0,2}[12]?[0-9]))?"

NUMBER_PATTERN = rb"[-+]?[0-9]{1,18}(?:\.[0-9]*)?" + EXPONENT_PATTERN
"""A coordinate as nearly all files write it. No text matches it in two ways, so a failed match costs nothing."""

INDEX_PATTERN = rb"[0-9]{1,9}"

_BLANKS = rb"[ \t]+"

_LINE_END = rb"[ \t]*\r?\n"

MAX_RUN_LINES = 4096
"""Lines in a run: the matcher keeps a state for each."""


def line_run_pattern(*words: bytes, lines: bytes = b"") -> re.Pattern[bytes]:
    """Matches a run of lines that each have these words, patterns themselves; or of `lines`, a pattern of several."""
    return re.compile(rb"(?:" + (lines or line_pattern(*words)) + rb"){1,%d}" % MAX_RUN_LINES)


def line_pattern(*words: bytes) -> bytes:
    """The pattern of a line that has these words."""
    return _BLANKS.join(words) + _LINE_END


def parse_floats(run: bytes) -> NDArray[np.float64]:
    """The numbers of a text of nothing but numbers and blanks."""
    with np.errstate(over="ignore"):
        return np.fromstring(run, dtype=np.float64, sep=" ")


def parse_integers(run: bytes) -> NDArray[np.int64]:
    """Likewise, of integers."""
    return np.fromstring(run, dtype=np.int64, sep=" ")


def split_words(line: str) -> list[str]:
    """The words of a line. What Python takes for a blank besides these two, the engine's readers do not."""
    return [word for word in line.replace("\t", " ").split(" ") if word]


class MeshTextReader:
    """A text read from its start to its end.

    Attributes:
        row: how many lines were read.
    """

    def __init__(self, data: bytes, budget: MeshBudget, start: int = 0) -> None:
        """Starts at an offset. The budget pays for each run, and for each line that is read alone: they take time.

        Raises:
            ValueError: the data holds characters that no text has.
        """
        check_text(data)
        self.row = 0
        self._data = data
        self._budget = budget
        self._at = start

    def letter(self) -> bytes:
        """The first byte of the next line; empty at the end."""
        return self._data[self._at : self._at + 1]

    def run(self, pattern: re.Pattern[bytes]) -> bytes:
        """The lines that match here, which are then read; empty where none do."""
        match = pattern.match(self._data, self._at)
        if match is None:
            return b""
        self._budget.spend(ROW_BYTES)
        self._at = match.end()
        run = match[0]
        self.row += run.count(b"\n")
        return run

    def line(self) -> str | None:
        """The next line without blanks around it; None at the end."""
        line = self.raw()
        return None if line is None else line.strip(" \t")

    def raw(self) -> str | None:
        """The next line with the blanks around it; None at the end."""
        if self._at >= len(self._data):
            return None
        end = self._data.find(b"\n", self._at)
        end = len(self._data) if end < 0 else end
        self._budget.spend(ROW_BYTES + _LETTER_BYTES * (end - self._at))
        line = self._data[self._at : end]
        self._at = end + 1
        self.row += 1
        return line.decode("utf-8", "replace").rstrip("\r")

    def filled(self) -> str | None:
        """The next line that is not empty, without blanks around it; None at the end."""
        line = self.line()
        while line == "":
            line = self.line()
        return line


ROW_BYTES, _LETTER_BYTES = 512, 16
"""Budget of a line that is read alone, and of each of its characters, besides its data: splitting it takes time."""

_MEMORY_FACTOR = 3
"""Arrays take up to three times the file of which they are all: `f 1 2 3` is eight bytes, and 24 as integers."""


class MeshBudget:
    """Counts what a mesh takes in memory, before it is made: a file may ask for far more than its own size."""

    def __init__(self, max_bytes: int, total: AssetBudget) -> None:
        self._max_bytes = _MEMORY_FACTOR * max_bytes
        self._total = total
        self._used = 0

    def spend(self, size: int) -> None:
        """Counts what takes time, or memory for a moment, for all meshes of the scene together.

        Raises:
            AssetError: it is too much.
        """
        self._total.take(size)

    def take(self, size: int) -> None:
        """Counts so many bytes.

        Raises:
            AssetError: they are too many.
        """
        self.spend(size)
        self._used += size
        if self._used > self._max_bytes:
            raise AssetError(
                "SC607",
                f"the mesh takes more than {self._max_bytes} bytes in memory",
                "simplify it, or raise the limit with --limit asset_bytes=N",
            )
