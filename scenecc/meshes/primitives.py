"""Primitives as in SAPIEN's renderer: the same vertices in the same order, normals and texture coordinates."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.geometry.surfaces import revolved_surface
from scenecc.meshes.surface import Surface
from scenecc.plan.geometry import REVOLVED_SOLIDS

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from scenecc.geometry.rotations import Vec3

_AROUND: Final = 32
"""Vertices of a circle."""

_CAP: Final = 8
"""Rings of a hemisphere, without the pole."""

_THIRD, _TWO_THIRDS = 1 / 3, 2 / 3

_BOX_SIDES: Final = (
    # Four corners, the normal, and left, bottom, right and top in the image: a cross of six squares.
    (((-1, 1, 1), (-1, -1, 1), (1, -1, 1), (1, 1, 1)), (0, 0, 1), (0.25, _THIRD, 0.5, _TWO_THIRDS)),
    (((1, 1, -1), (1, -1, -1), (-1, -1, -1), (-1, 1, -1)), (0, 0, -1), (0.75, _THIRD, 1, _TWO_THIRDS)),
    (((1, 1, 1), (1, -1, 1), (1, -1, -1), (1, 1, -1)), (1, 0, 0), (0.5, _THIRD, 0.75, _TWO_THIRDS)),
    (((-1, 1, -1), (-1, -1, -1), (-1, -1, 1), (-1, 1, 1)), (-1, 0, 0), (0, _THIRD, 0.25, _TWO_THIRDS)),
    (((-1, 1, -1), (-1, 1, 1), (1, 1, 1), (1, 1, -1)), (0, 1, 0), (0.25, _TWO_THIRDS, 0.5, 1)),
    (((-1, -1, 1), (-1, -1, -1), (1, -1, -1), (1, -1, 1)), (0, -1, 0), (0.25, 0, 0.5, _THIRD)),
)

_QUAD: Final = ((0, 1, 2), (0, 2, 3))


def make_surface(vertices: ArrayLike, faces: ArrayLike, normals: ArrayLike | None, uvs: ArrayLike | None) -> Surface:
    """Returns a surface with copies of array-like data."""
    return Surface(
        _make_read_only(np.array(vertices, np.float32)),
        _make_read_only(np.array(faces, np.int64)),
        None if normals is None else _make_read_only(np.array(normals, np.float32)),
        None if uvs is None else _make_read_only(np.array(uvs, np.float32)),
    )


def _make_read_only(array: NDArray[Any]) -> NDArray[Any]:
    array.setflags(write=False)
    return array


def scaled_surface(kind: str, sizes: tuple[float, ...]) -> tuple[Surface, Vec3]:
    """Returns a primitive of a plan, and its scale.

    Args:
        kind: shape type; for a plane, its visual shape.
        sizes: see `plan.geometry.Primitive`.
    """
    if kind in REVOLVED_SOLIDS:
        return make_surface(*revolved_surface(REVOLVED_SOLIDS[kind].profile(*sizes))), (1.0, 1.0, 1.0)
    match kind, sizes:
        case "box", (x, y, z):
            found = box(), (x, y, z)
        case "sphere", (radius,):
            found = sphere(), (radius, radius, radius)
        case "capsule", (radius, half_length):
            found = capsule(radius, half_length), (1.0, 1.0, 1.0)
        case "cylinder", (radius, half_length):
            found = cylinder(), (half_length, radius, radius)
        case "tiled_plane", (x, y, u, v):
            found = tiled_plane((u, v)), (x, y, 1.0)
        case _:
            y, z = sizes
            found = plane(), (1.0, y, z)
    return found


@cache
def box() -> Surface:
    """Returns a box with half sizes 1."""
    vertices = np.concatenate([corners for corners, _, _ in _BOX_SIDES])
    normals = np.repeat([normal for _, normal, _ in _BOX_SIDES], 4, axis=0)
    uvs = [
        corner
        for _, _, (left, low, right, high) in _BOX_SIDES
        for corner in ((left, high), (left, low), (right, low), (right, high))
    ]
    faces = np.concatenate([np.add(_QUAD, 4 * side) for side in range(len(_BOX_SIDES))])
    return make_surface(vertices, faces, normals, uvs)


@cache
def plane() -> Surface:
    """Returns a quad that faces +x, with half sizes 1 along y and z."""
    corners = [(0, 1, 1), (0, -1, 1), (0, -1, -1), (0, 1, -1)]
    return make_surface(corners, _QUAD, [(1, 0, 0)] * 4, [(0, 1), (0, 0), (1, 0), (1, 1)])


@cache
def tiled_plane(repeat: tuple[float, float]) -> Surface:
    """Returns a quad that faces +z, with half sizes 1 along x and y and a repeated image, as in ManiSkill."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float64)
    vertices = np.column_stack([corners, np.zeros(4)])
    return make_surface(vertices, _QUAD, [(0, 0, 1)] * 4, 0.5 + corners / 2 * repeat)


@cache
def sphere() -> Surface:
    """Returns a sphere of radius 1 with poles on x."""
    directions, uvs, faces = _ball(0.5)
    return make_surface(directions, faces, directions, uvs)


def capsule(radius: float, half_length: float) -> Surface:
    """Returns a capsule along x [m]; `half_length` excludes the caps."""
    directions, uvs, faces = _ball(0.25)
    shift = np.zeros_like(directions)
    half = len(directions) // 2
    shift[:half, 0], shift[half:, 0] = half_length, -half_length
    return make_surface(directions * radius + shift, faces, directions, uvs)


@cache
def cylinder() -> Surface:
    """Returns a cylinder of radius 1 and half length 1 along x. Texture coordinates are all (0, 0), as in SAPIEN."""
    angle = np.arange(_AROUND) * (2 * np.pi / _AROUND)
    circle = np.column_stack([np.zeros(_AROUND), np.cos(angle), np.sin(angle)])
    x = np.array([1.0, 0, 0])
    cap = np.concatenate([[x], circle + x])
    vertices = np.concatenate([cap, cap * (-1, 1, 1), circle + x, circle - x])
    normals = np.concatenate([np.tile(x, (_AROUND + 1, 1)), np.tile(-x, (_AROUND + 1, 1)), circle, circle])
    here = np.arange(_AROUND)
    there = (here + 1) % _AROUND
    zero = np.zeros(_AROUND, np.int64)
    low, side = _AROUND + 1, 2 * _AROUND + 2
    near = np.stack([zero, 1 + here, 1 + there], axis=1)
    far = np.stack([low + zero, low + 1 + there, low + 1 + here], axis=1)
    quads = _band_faces(side + here, side + there, side + _AROUND + here, side + _AROUND + there)
    return make_surface(vertices, np.concatenate([near, far, quads]), normals, np.zeros((len(vertices), 2)))


def _ball(cap: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Returns directions, texture coordinates and triangles of a sphere.

    Args:
        cap: share of the image's height for each hemisphere. Below 0.5 there is a belt between the hemispheres, and
            their edges are two rings; otherwise they share one.
    """
    rings = np.arange(1, 2 * _CAP) if cap == 0.5 else np.array([*range(1, _CAP + 1), *range(_CAP, 2 * _CAP)])
    down = rings * (np.pi / (2 * _CAP))
    around = np.arange(_AROUND + 1) * (2 * np.pi / _AROUND)
    x, radius = np.cos(down)[:, None], np.sin(down)[:, None]
    directions = np.stack(
        np.broadcast_arrays(x, radius * np.cos(around), radius * np.sin(around)),
        axis=-1,
    ).reshape(-1, 3)
    height = rings / _CAP * cap
    height[len(rings) // 2 + len(rings) % 2 :] += 1 - 2 * cap
    u, v = np.meshgrid(np.arange(_AROUND + 1) / _AROUND, 1 - height)
    uvs = np.stack([u, v], axis=-1).reshape(-1, 2)
    pole = np.tile([1.0, 0, 0], (_AROUND, 1))
    middle = (np.arange(_AROUND) + 0.5) / _AROUND
    return (
        np.concatenate([pole, directions, -pole]),
        np.concatenate([np.stack([middle, np.ones(_AROUND)], 1), uvs, np.stack([middle, np.zeros(_AROUND)], 1)]),
        _ball_faces(len(rings)),
    )


def _ball_faces(rings: int) -> NDArray[np.int64]:
    here = np.arange(_AROUND)
    first = _AROUND + here
    faces = [np.stack([here, first, first + 1], axis=1)]
    step = _AROUND + 1
    for ring in range(rings - 1):
        upper = first + ring * step
        faces.append(_band_faces(upper, upper + 1, upper + step, upper + step + 1, first="far"))
    last = first + (rings - 1) * step
    pole = _AROUND + rings * step + here
    faces.append(np.stack([last, pole, last + 1], axis=1))
    return np.concatenate(faces)


def _band_faces(
    a: NDArray[np.int64], b: NDArray[np.int64], c: NDArray[np.int64], d: NDArray[np.int64], *, first: str = "near"
) -> NDArray[np.int64]:
    """Returns two triangles for each square between ring a, b and the ring c, d below, split along a diagonal."""
    cut = ((a, c, d), (a, d, b)) if first == "far" else ((a, c, b), (b, c, d))
    return np.stack([np.stack(one, axis=1) for one in cut], axis=1).reshape(-1, 3)
