"""The convex pairs of two parts that may be near one another: of a mesh that is no hull, its triangles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.placing.bodies import Part
    from scenecc.placing.distances import Cores

    Indices = NDArray[np.intp]


def core_pairs(a: Part, a_rows: Indices, b: Part, b_rows: Indices, within: float) -> tuple[Indices, Cores, Cores]:
    """Pairs of cores (k,), and of which pair of rows each is.

    Args:
        a: the one part; no plane.
        a_rows: its rows (n,).
        b: the other part; no plane.
        b_rows: its rows (n,).
        within: triangles that are farther away are left out [m].
    """
    if b.triangles is None and a.triangles is None:
        return np.arange(len(a_rows)), a.cores(a_rows), b.cores(b_rows)
    if b.triangles is None:
        pair, second, first = core_pairs(b, b_rows, a, a_rows, within)
        return pair, first, second
    pair, triangle = b.triangles_near(b_rows, a.p[a_rows], a.reach[a_rows] + within)
    theirs = b.triangle_cores(b_rows[pair], triangle)
    if a.triangles is None:
        return pair, a.cores(a_rows[pair]), theirs
    assert theirs.corners is not None
    middle = theirs.corners.mean(axis=1)
    reach = np.sqrt(((theirs.corners - middle[:, None]) ** 2).sum(axis=2).max(axis=1))
    world = np.matmul(theirs.turn, middle[:, :, None])[:, :, 0] + theirs.p
    again, own = a.triangles_near(a_rows[pair], world, reach + within)
    return (
        pair[again],
        a.triangle_cores(a_rows[pair][again], own),
        b.triangle_cores(b_rows[pair][again], triangle[again]),
    )
