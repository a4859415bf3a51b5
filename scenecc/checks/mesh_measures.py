"""What trimesh measures of a mesh file, kept in the user's cache folder by the content of the file."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from functools import lru_cache
from hashlib import sha256
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.files import cache_folder, replace_all
from scenecc.geometry.hulls import hull_volume
from scenecc.placing.bodies import mesh_of

if TYPE_CHECKING:
    from scenecc.plan import AssetFile

_VERSION = 2
"""Of these measures: others are not read."""


@dataclass(frozen=True, slots=True)
class MeshMeasures:
    """A mesh as its file has it, without scale, corners in one place joined.

    Attributes:
        low, high: corners of the box around it (3,) [m].
        faces: how many triangles it has.
        degenerate: how many of these have no area.
        open_edges: how many edges have one triangle. 0: it is watertight, or worse.
        crowded_edges: how many edges have three triangles or more.
        consistent: whether neighbours wind the same way.
        volume: signed [m³]; below 0 its triangles face inwards. It has a meaning where there are no open edges.
        hull_volume: of its convex hull [m³]; 0: it is flat.
        unused: how many vertices no triangle uses.
        beyond: how far these lie outside of the box [m]; 0: all are in it.
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    faces: int
    degenerate: int
    open_edges: int
    crowded_edges: int
    consistent: bool
    volume: float
    hull_volume: float
    unused: int
    beyond: float

    @property
    def is_watertight(self) -> bool:
        """Whether each edge has two triangles."""
        return self.open_edges == self.crowded_edges == 0


@lru_cache(maxsize=1024)
def measure_mesh(file: AssetFile) -> MeshMeasures:
    """The measures of a mesh file.

    Raises:
        MeshError: it cannot be read, or pycollada is missing.
    """
    digest = sha256(repr((_VERSION, file.sha256, [one.sha256 for one in file.names])).encode()).hexdigest()
    kept = cache_folder("measures") / f"{digest}.json"
    try:
        known: dict[str, Any] = json.loads(kept.read_bytes())
        known |= {name: tuple(known[name]) for name in ("low", "high")}
        return MeshMeasures(**known)
    except (OSError, ValueError, TypeError, KeyError):
        measures = _measure(file)
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        replace_all({kept: json.dumps(asdict(measures)).encode()})
    except OSError:
        pass  # it is measured again the next time
    return measures


def _measure(file: AssetFile) -> MeshMeasures:
    import trimesh

    vertices, faces = mesh_of(file)
    mesh: Any = trimesh.Trimesh(vertices, faces, process=False)
    has_area = mesh.area_faces > 0
    mesh.update_faces(has_area)
    uses = np.unique(np.unique(np.sort(mesh.edges, axis=1), axis=0, return_counts=True)[1], return_counts=True)
    edges = dict(zip(*(each.tolist() for each in uses), strict=True))
    used = vertices[np.unique(mesh.faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    unused = np.delete(vertices, np.unique(faces), axis=0)
    flat = len(used) < 4 or np.linalg.matrix_rank(used - used[0], tol=1e-9 * float(np.ptp(used))) < 3
    return MeshMeasures(
        tuple(low.tolist()),
        tuple(high.tolist()),
        len(faces),
        int((~has_area).sum()),
        edges.get(1, 0),
        sum(count for times, count in edges.items() if times > 2),
        bool(mesh.is_winding_consistent),
        float(mesh.volume),
        0.0 if flat else hull_volume(used),
        len(unused),
        float(np.maximum(low - unused, unused - high).max(initial=0.0)),
    )
