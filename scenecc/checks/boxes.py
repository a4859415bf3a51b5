"""Bounding boxes of shapes, bodies and entities of a plan, for the rules that compare where things are."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.assets.files import check_measures
from scenecc.assets.meshes import checked_content, read_mesh
from scenecc.geometry.rotation_arrays import pose_matrix
from scenecc.plan import BodyStructure, MeshGeometry
from scenecc.plan.geometry import Heightfield, Primitive, TiledPlane, VisualPlane
from scenecc.plan.link_poses import link_poses

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from numpy.typing import NDArray

    from scenecc.plan import CollisionShape, Entity, ScenePlan, VisualShape

    Floats = NDArray[np.float64]
    Box = tuple[Floats, Floats]
    """Lower and upper corner, each (3,) [m]."""

_CORNERS: Final = np.array(list(product((0, 1), repeat=3)), bool)


class PlacedBox(NamedTuple):
    """The bounding box of an entity in one scene.

    Attributes:
        entity: the entity.
        low, high: corners (3,) in the world [m].
        collides: whether the box is that of colliding shapes; False: nothing of the entity collides.
        parts: boxes of its shapes.
    """

    entity: Entity
    low: Floats
    high: Floats
    collides: bool
    parts: tuple[Box, ...]


def shape_box(geometry: Any, row: int, plan: ScenePlan, rotation: Floats | None = None) -> Box | None:
    """Returns the bounding box of a geometry around its own origin; None for a colliding plane, which has no end.

    `rotation` (3, 3): that of its frame; primitives use it for a tighter box, so that `local_box` is exact.

    Raises:
        AssetError: a mesh file changed since it was checked.
    """
    turn = np.eye(3) if rotation is None else rotation
    if isinstance(geometry, Primitive):
        return geometry.bounds(turn, *geometry.sizes(row))
    if isinstance(geometry, MeshGeometry):
        measures = check_measures(read_mesh(checked_content(plan.files[int(geometry.file.row(row))])))
        ends = np.array([measures.low, measures.high]) * geometry.scale.row(row)
    elif isinstance(geometry, Heightfield):
        heights = np.array(geometry.heights)
        ends = np.array([(-0.5, -0.5, heights.min()), (0.5, 0.5, heights.max())]) * geometry.size.row(row)
    else:
        return None
    middle, reach = turn @ ends.mean(axis=0), np.abs(turn) @ (np.abs(np.ptp(ends, axis=0)) / 2)
    return middle - reach, middle + reach


def local_box(shape: CollisionShape | VisualShape, row: int, plan: ScenePlan) -> Box | None:
    """Returns the bounding box of a shape in the frame of its body. Otherwise like `shape_box`."""
    matrix = np.eye(4) if shape.pose is None else pose_matrix(shape.pose.row(row).tolist())
    box = shape_box(shape.geometry, row, plan, matrix[:3, :3])
    return box and (box[0] + matrix[:3, 3], box[1] + matrix[:3, 3])


def corners(box: Box) -> Floats:
    """Returns the corners (8, 3) of a box, in a fixed order."""
    return np.where(_CORNERS, box[1], box[0])


def bounding_box(boxes: Iterable[Box]) -> Box:
    """Returns the box around several boxes."""
    lows, highs = zip(*boxes, strict=True)
    return np.min(lows, axis=0), np.max(highs, axis=0)


def placed_boxes(plan: ScenePlan, scene: int) -> list[PlacedBox]:
    """Returns the boxes of all entities of a scene that have an extent: planes have none.

    Only colliding shapes count, unless an entity has none.
    """
    found: list[PlacedBox] = []
    for entity in plan.entities:
        if scene not in entity.scene_idxs:
            continue
        row = entity.scene_idxs.index(scene)
        each = list(_posed_bodies(entity, row))
        collides = any(body.collisions for _, body in each)
        try:
            boxes = [
                _world_box(frame, box)
                for frame, body in each
                for shape in (body.collisions if collides else body.visuals)
                if not isinstance(shape.geometry, VisualPlane | TiledPlane)
                for box in [local_box(shape, row, plan)]
                if box is not None
            ]
        except AssetError:
            continue  # the build reports that the file changed
        if boxes:
            found.append(PlacedBox(entity, *bounding_box(boxes), collides, tuple(boxes)))
    return found


def _posed_bodies(entity: Entity, row: int) -> Iterator[tuple[Floats, BodyStructure]]:
    """Yields the bodies of an entity in one row, with their poses (7,) in the world."""
    root = entity.pose.row(row)
    structure = entity.structure(row)
    if isinstance(structure, BodyStructure):
        yield root, structure
        return
    poses = link_poses(structure, root[None], lambda value: np.asarray(value.row(row))[None])
    yield from ((pose[0], link.body) for pose, link in zip(poses, structure.links, strict=True))


def _world_box(frame: Floats, box: Box) -> Box:
    matrix = pose_matrix(frame.tolist())
    placed = corners(box) @ matrix[:3, :3].T + matrix[:3, 3]
    return placed.min(axis=0), placed.max(axis=0)
