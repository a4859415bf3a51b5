"""Mesh readers by file suffix, and what a mesh must satisfy for each use so that PhysX cooks what the file shows.

The readers are scenecc's own: a check must be at least as strict as SAPIEN's readers, some of which end the process
on a broken file, and an untrusted file must not use more memory than the limit allows.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.checks.mesh_collada import read_collada
from scenecc.checks.mesh_data import (
    NUMBER_PATTERN,
    AssetBudget,
    AssetError,
    MeshBudget,
    MeshData,
    MeshFilePart,
    MeshReadContext,
    MeshTextReader,
    Precision,
    connected_parts,
    is_degenerate,
    line_pattern,
    line_run_pattern,
    make_part,
    parse_coordinate,
    parse_floats,
    principal_extents,
)
from scenecc.checks.mesh_gltf import read_gltf
from scenecc.checks.mesh_obj import read_obj
from scenecc.checks.mesh_ply import read_ply
from scenecc.geometry.hulls import MAX_CORNERS, PLANE_TOLERANCE, cooked_volume_ratio, plane_tolerance
from scenecc.geometry.rotations import MAX_COORDINATE

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
        corners = _read_text_corners(data, budget, reading.precision)
    else:
        declared = f"declares {count} triangles" if len(data) >= 84 else "is shorter than its header"
        raise AssetError(
            "SC412", f"the STL is broken or truncated: it has {len(data)} bytes and {declared}", "export the mesh again"
        )
    if not len(corners):
        return MeshData(())
    budget.take(corners.nbytes)
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    return MeshData((make_part(vertices, index.reshape(-1, 3), reading.precision),))


def _read_text_corners(data: bytes, budget: MeshBudget, precision: Precision) -> NDArray[np.floating]:
    corners: array[float] = array("f" if precision is np.float32 else "d")
    words: list[str] = []
    try:
        lines = MeshTextReader(data, budget)
        while True:
            if not words and (run := lines.run(_FACET_RUN)):
                numbers = parse_floats(_FACET_WORD.sub(b" ", run)).reshape(-1, 12)[:, 3:]
                with np.errstate(over="ignore"):
                    found = numbers.astype(precision)
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
                    corners.frombytes(np.array(_parse_facet(words[:_TEXT_FACET])).astype(precision).tobytes())
                del words[:_TEXT_FACET]
    except ValueError as error:
        raise AssetError("SC412", f"the STL cannot be read: {error}", "export the mesh again") from error
    if words:
        raise AssetError("SC412", "the STL ends within a triangle", "export the mesh again")
    return np.frombuffer(corners, precision).reshape(-1, 3)


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


_READERS: dict[str, Callable[[bytes, MeshReadContext], MeshData]] = {
    ".obj": read_obj,
    ".gltf": read_gltf,
    ".glb": read_gltf,
    ".stl": read_stl,
    ".ply": read_ply,
    ".dae": read_collada,
}

MESH_SUFFIXES = tuple(_READERS)
"""Suffixes of the formats that are read, in lower case."""


def read_mesh(data: bytes, suffix: str, reading: MeshReadContext) -> MeshData:
    """Reads a mesh.

    Args:
        data: the file.
        suffix: its suffix in lower case, one of `MESH_SUFFIXES`.
        reading: how to read files that it names, and limits.

    Raises:
        AssetError: it cannot be read, or a file that it names cannot.
    """
    return _READERS[suffix](data, reading)


MIN_THICKNESS = 1e-5
"""Thickness below which a hull is refused [m]. PhysX cooks a thinner one to something else, or not at all."""

_SAFE_THICKNESS = 32
"""Thickness from which PhysX's tolerance takes less than a twentieth of any hull, in that tolerance."""

_MAX_CHANGE = 0.5
"""By how much of its volume a hull may be cooked to another: thin stickers on real robots gain a quarter."""

_TOLD_CHANGE = 0.25
"""From how much on that is told."""

_MIN_LENGTH = 0.01
"""Length of a mesh at which PhysX's tolerance may take a tenth of its volume and more [m]."""


_HULL_COST, _CORNER_COST = 2**16, 2**10
"""Budget of computing what PhysX cooks of a hull, and of each of its corners."""


def check_mesh_use(mesh: MeshData, use: str, suffix: str, total: AssetBudget) -> Iterator[AssetError]:
    """Faults of a mesh in one use, the first of a part alone.

    Args:
        mesh: what was read.
        use: "hull", "parts", "triangles", "decomposed" or "seen".
        suffix: of the file, in lower case.
        total: counts the time that hulls take.
    """
    try:
        vertices = mesh_vertices(mesh)
    except AssetError as fault:
        yield fault
        return
    if use == "seen" and mesh.fault is not None:
        yield mesh.fault
    if use == "parts" and suffix == ".stl":
        yield AssetError(
            "SC421",
            "an STL has no parts: SAPIEN guesses them from its triangles",
            "export the parts as objects of an OBJ",
        )
    if use in {"triangles", "decomposed"} and all(map(is_degenerate, mesh.parts)):
        yield AssetError("SC415", "all triangles of the mesh are degenerate", "export the mesh again")
    if use == "hull":
        yield from _hull_faults([vertices], "", total)
    if use == "parts":
        # A COLLADA becomes a PLY, in which corners in one place are joined.
        whole = [_weld(one) for one in mesh.parts] if suffix == ".dae" else mesh.parts
        parts = (
            [loose for one in whole for loose in connected_parts(one)]
            if suffix in {".ply", ".stl", ".dae"}
            else mesh.parts
        )
        yield from _hull_faults([one.vertices for one in parts], " of one of its parts", total)


def mesh_vertices(mesh: MeshData) -> NDArray[Any]:
    """The vertices (n, 3) of all triangles of a mesh [m].

    Raises:
        AssetError: there are none, or they are where nothing may be.
    """
    if not mesh.parts:
        raise AssetError("SC413", "the mesh has no triangles", "export it with its faces")
    vertices = np.concatenate([one.vertices for one in mesh.parts])
    largest = float(np.abs(vertices).max())
    if not np.isfinite(largest):
        raise AssetError("SC414", "the mesh has coordinates that are not finite", "export it again")
    if largest > MAX_COORDINATE:
        raise AssetError(
            "SC417",
            f"the mesh reaches {largest:.3g} m from its origin, and {MAX_COORDINATE:.0e} m is the most",
            "export it in metres, about its own centre",
        )
    return vertices


def _weld(part: MeshFilePart) -> MeshFilePart:
    vertices, index = np.unique(part.vertices, axis=0, return_inverse=True)
    return make_part(vertices, index.reshape(-1)[part.faces])


def _hull_faults(clouds: list[NDArray[np.float32]], whose: str, total: AssetBudget) -> Iterator[AssetError]:
    sizes = [principal_extents(cloud) for cloud in clouds]
    thin = min(thickness for thickness, _ in sizes)
    if thin < MIN_THICKNESS:
        yield AssetError(
            "SC415", f"the hull{whose} has no volume: it is {thin:.3g} m thick", "give it a thickness, or use a box"
        )
        return
    for cloud, (thickness, length) in zip(clouds, sizes, strict=True):
        try:
            fault = _cooking_fault(cloud, thickness, length, whose, total)
        except AssetError as error:
            fault = error
        if fault is not None:
            yield fault
            return
    small = min(length for _, length in sizes)
    if thin < 2 * PLANE_TOLERANCE or small < _MIN_LENGTH:
        yield AssetError(
            "SC416",
            f"the hull{whose} is {thin:.3g} m thick and {small:.3g} m long, and PhysX leaves out corners within "
            f"{PLANE_TOLERANCE} m",
            "store the mesh larger and give the shape a `scale`: corners are left out before it is scaled",
        )


def _cooking_fault(
    cloud: NDArray[np.float32], thickness: float, length: float, whose: str, total: AssetBudget
) -> AssetError | None:
    """Of a hull that PhysX cooks to one of another volume, or without an end, by its thickness and length [m]."""
    tolerance = plane_tolerance(cloud)
    reach = np.abs(cloud).max()
    if np.spacing(reach) > tolerance:
        return AssetError(
            "SC417",
            f"the hull{whose} is {length:.3g} m long and reaches {reach:.3g} m from its origin, where coordinates are "
            f"rounded to {np.spacing(reach):.2g} m",
            "export it about its own centre",
        )
    if thickness >= _SAFE_THICKNESS * tolerance:
        return None
    total.take(_HULL_COST + _CORNER_COST * min(len(cloud), MAX_CORNERS))
    ratio = cooked_volume_ratio(cloud)
    if abs(ratio - 1) <= _TOLD_CHANGE:
        return None
    enlarge = "store the mesh larger, about 1 m long, and give the shape a `scale`; or "
    return AssetError(
        "SC423" if abs(ratio - 1) > _MAX_CHANGE else "SC416",
        f"PhysX cooks the hull{whose} to {ratio:.0%} of its volume: it is {thickness:.3g} m thick and {length:.3g} m "
        f"long, and corners within {tolerance:.2g} m are left out",
        f"{enlarge if tolerance <= PLANE_TOLERANCE else ''}use a box or another solid, or cut the mesh into shorter "
        "parts (`convex_parts`, with `coacd` if need be)",
    )
