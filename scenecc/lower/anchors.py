"""`anchor` of a pose: a point of the bounds of a body or an articulation, in the frame of its root."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.geometry.rotation_arrays import pose_matrix
from scenecc.lower.local_poses import chain_poses
from scenecc.plan import BodyStructure, Heightfield, MeshGeometry, Plane
from scenecc.plan.geometry import Primitive
from scenecc.plan.link_poses import steps_to_link

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Vec3
    from scenecc.plan import ArticulationStructure, CollisionShape, Value, VisualShape

MeshVertices = Callable[[int], "NDArray[np.float32] | None"]
"""The vertices (n, 3) [m] of a file of the plan, by its index; None after an error."""


class AnchorError(Exception):
    """A body has no such anchor point."""


class AnchorPoints:
    """Anchor points on the bounds of an entity.

    Args:
        structures: all its alternatives.
        pick: index of each scene's structure.
        scenes: of the entity.
        vertices: reads meshes.
    """

    def __init__(
        self,
        structures: Sequence[BodyStructure | ArticulationStructure],
        pick: Value | None,
        scenes: tuple[int, ...],
        vertices: MeshVertices,
    ) -> None:
        self._shapes = [list(_iterate_placed_shapes(structure, scenes)) for structure in structures]
        self._pick = pick
        self._scenes = scenes
        self._vertices = vertices
        self._values = [value for shapes in self._shapes for place, shape in shapes for value in _values(place, shape)]
        self._values += [] if pick is None else [pick]

    @property
    def known(self) -> bool:
        """Whether the points depend only on the scene index."""
        return all(value.known for value in self._values)

    def rows(self, anchor: str) -> list[Vec3]:
        """One point for all scenes, or one per scene, in the frame of the root [m].

        Raises:
            AnchorError: there is no such point.
            DrawError: a drawn value is missing.
        """
        count = 1 if all(value.is_constant for value in self._values) else len(self._scenes)
        return [self._point(anchor, row) for row in range(count)]

    def _point(self, anchor: str, row: int) -> Vec3:
        shapes = self._shapes[0 if self._pick is None else int(self._pick.row(row))]
        corners = [corner for place, shape in shapes for corner in self._bounds(place, shape, row)]
        if not corners:
            raise AnchorError("it has no shapes")
        low, high = np.min(corners, axis=0), np.max(corners, axis=0)
        x, y, z = ((low + high) / 2).tolist()
        return (x, y, {"bottom": float(low[2]), "center": z, "top": float(high[2])}[anchor])

    def _bounds(self, place: Value | None, shape: CollisionShape | VisualShape, row: int) -> Iterator[NDArray[Any]]:
        """Corners of a shape's bounding box. `place`: of its link."""
        frame = np.eye(4)
        for pose in (place, shape.pose):
            frame = frame if pose is None else frame @ pose_matrix(pose.row(row))
        rotation, centre, geometry = frame[:3, :3], frame[:3, 3], shape.geometry
        if isinstance(geometry, Plane):
            raise AnchorError("a plane is infinite")
        if isinstance(geometry, Primitive):
            yield from (centre + corner for corner in geometry.bounds(rotation, *geometry.sizes(row)))
            return
        points: Any
        if isinstance(geometry, Heightfield):
            points = geometry.surface(row)[0]
        else:
            found = self._vertices(int(geometry.file.row(row)))
            if found is None:
                raise AnchorError("its mesh cannot be read")
            points = found.astype(np.float64) * geometry.scale.row(row)
        points = points @ rotation.T + centre
        yield from (points.min(axis=0), points.max(axis=0))


def _iterate_placed_shapes(
    structure: BodyStructure | ArticulationStructure, scenes: tuple[int, ...]
) -> Iterator[tuple[Value | None, CollisionShape | VisualShape]]:
    """The collision shapes, or the visual ones if there are none, each with the pose of its link."""
    colliding = any(body.collisions for body in structure.bodies)
    if isinstance(structure, BodyStructure):
        yield from ((None, shape) for shape in (structure.collisions if colliding else structure.visuals))
        return
    for link in structure.links:
        shapes = link.body.collisions if colliding else link.body.visuals
        if shapes:
            place = chain_poses(steps_to_link(structure, link.name, scenes), scenes)
            yield from ((place, shape) for shape in shapes)


def _values(place: Value | None, shape: CollisionShape | VisualShape) -> Iterator[Value]:
    yield from (value for value in (place, shape.pose) if value is not None)
    geometry = shape.geometry
    if isinstance(geometry, MeshGeometry):
        yield from (geometry.file, geometry.scale)
    elif not isinstance(geometry, Plane):
        yield from geometry.values
