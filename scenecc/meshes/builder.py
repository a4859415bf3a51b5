"""Builds meshes of a plan's bodies, of measured scenes and of a grid of scenes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.obj import encode_obj
from scenecc.geometry.rotation_arrays import pose_matrix
from scenecc.geometry.rotations import IDENTITY_POSE, Vec3, to_pose, to_vector
from scenecc.meshes import primitives
from scenecc.meshes.files import MeshFiles
from scenecc.meshes.surface import MaterialCache, MeshPart, MeshShape, Surface, SurfaceMaterial
from scenecc.plan import Heightfield, Mesh
from scenecc.plan.rendering import COLLISION_COLORS
from scenecc.plan.schema import type_name

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from scenecc.assets.errors import AssetError
    from scenecc.diagnostics import Origin
    from scenecc.plan import BodyStructure, ScenePlan, VisualGeometry, VisualShape
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredMesh, MeasuredScene, MeasuredShape

_COLLISION_MATERIALS: Final = {kind: SurfaceMaterial(base_color=color) for kind, color in COLLISION_COLORS.items()}


class MeshBuilder:
    """Builds meshes of a plan's bodies. Equal surfaces and materials are shared, and files are read once."""

    def __init__(
        self,
        plan: ScenePlan,
        on_left_out: Callable[[AssetError, Origin | None], None],
        max_triangles: int | None = None,
    ) -> None:
        """`on_left_out`: called once for each image that is left out, with the first shape that uses it.
        `max_triangles`: of a visual mesh from a file, which is simplified if it has more.
        """
        self._plan = plan
        self._now: Origin | None = None
        self._looks = MaterialCache(plan, lambda problem: on_left_out(problem, self._now))
        self._files = MeshFiles(max_triangles)
        self._primitives: dict[tuple[str, tuple[float, ...]], tuple[Surface, Vec3]] = {}
        self._terrains: dict[tuple[object, ...], Surface] = {}
        self._meshes: dict[str, Surface] = {}
        self._flat: dict[Surface, Surface] = {}
        self._boxes: dict[Surface, NDArray[np.float64]] = {}

    def visuals(self, body: BodyStructure, row: int) -> tuple[MeshShape, ...]:
        """Returns the visual shapes of a body in a row of its entity; empty if its visibility is 0.

        Raises:
            AssetError: a file cannot be shown, or a package is missing. `MeshBuilder.at` is the shape with the error.
        """
        visibility = 1.0 if body.visibility is None else float(body.visibility.row(row))
        if visibility == 0:
            return ()
        flat = body.shading_mode is not None and int(body.shading_mode.row(row)) == 1
        return tuple(self._visual(shape, row, visibility, flat=flat) for shape in body.visuals)

    def collisions(self, body: MeasuredBody) -> tuple[MeshShape, ...]:
        """Returns the collision shapes of a body, with cooked meshes."""
        return tuple(self.collision(shape, body) for shape in body.shapes)

    def body(self, body: MeasuredBody, shapes: tuple[MeshShape, ...]) -> BodyMeshes:
        """Returns a body at its measured pose, with some of its shapes."""
        place = pose_matrix(body.pose)
        corners = [
            self._box_corners(part.surface, place, shape)
            for shape in shapes
            if shape.kind != "plane"
            for part in shape.parts
        ]
        return BodyMeshes(body, shapes, place, np.concatenate([np.zeros((0, 3)), *corners]))

    def _box_corners(self, surface: Surface, body: NDArray[np.float64], shape: MeshShape) -> NDArray[np.float64]:
        """Returns (8, 3) corners of a surface's bounding box along its own axes."""
        if surface not in self._boxes:
            ends = np.array([surface.vertices.min(axis=0), surface.vertices.max(axis=0)], np.float64)
            self._boxes[surface] = np.array(list(product(*ends.T)))
        place = body @ pose_matrix(shape.pose)
        return (self._boxes[surface] * shape.scale) @ place[:3, :3].T + place[:3, 3]

    @property
    def at(self) -> Origin | None:
        """Origin of the shape that was built last."""
        return self._now

    def _visual(self, shape: VisualShape, row: int, visibility: float, *, flat: bool) -> MeshShape:
        self._now = shape.origin
        own = None if shape.material is None else self._looks.look(shape.material, row)
        parts, scale = self._parts(shape.geometry, row, own)
        if visibility != 1 or flat:
            shown = [self._shade_surface(part.surface, flat=flat) for part in parts]
            looks = [replace(part.look, visibility=visibility) for part in parts]
            parts = tuple(map(MeshPart, shown, looks))
        mirrored = isinstance(shape.geometry, Mesh) and scale[0] * scale[1] * scale[2] < 0
        turned = shape.front_face is not None and (shape.front_face == "clockwise") != mirrored
        pose = IDENTITY_POSE if shape.pose is None else to_pose(shape.pose.row(row))
        kind = type_name(type(shape.geometry))
        return MeshShape(shape.name or "", kind, parts, pose, scale, turned, origin=shape.origin)

    def _parts(
        self, geometry: VisualGeometry, row: int, own: SurfaceMaterial | None
    ) -> tuple[tuple[MeshPart, ...], Vec3]:
        if isinstance(geometry, Mesh):
            parts = self._files.parts(self._plan.files[int(geometry.file.row(row))])
            if own is not None:
                parts = tuple(MeshPart(part.surface, own) for part in parts)
            return parts, to_vector(geometry.scale.row(row))
        if isinstance(geometry, Heightfield):
            key = (geometry.heights, geometry.size.row(row).tobytes())
            if key not in self._terrains:
                self._terrains[key] = primitives.make_surface(*geometry.surface(row))
            return (MeshPart(self._terrains[key], own or SurfaceMaterial()),), (1.0, 1.0, 1.0)
        surface, scale = self._primitive(type_name(type(geometry)), geometry.sizes(row))
        return (MeshPart(surface, own or SurfaceMaterial()),), scale

    def _primitive(self, kind: str, sizes: tuple[float, ...]) -> tuple[Surface, Vec3]:
        key = (kind, sizes)
        if key not in self._primitives:
            self._primitives[key] = primitives.scaled_surface(kind, sizes)
        return self._primitives[key]

    def _shade_surface(self, surface: Surface, *, flat: bool) -> Surface:
        return self._flat.setdefault(surface, replace(surface, normals=None)) if flat else surface

    def collision(self, shape: MeasuredShape, body: MeasuredBody) -> MeshShape:
        """Returns a collision shape of a body."""
        endless = shape.kind == "plane"
        if shape.mesh is not None:
            surface, scale = self._cook_surface(shape.mesh), (1.0, 1.0, 1.0)
        else:
            surface, scale = self._primitive(shape.kind, (1.0, 1.0) if endless else shape.sizes)
        parts = (MeshPart(surface, _COLLISION_MATERIALS[body.body_type]),)
        return MeshShape("", shape.kind, parts, shape.pose, scale, endless=endless, origin=shape.shape.origin)

    def _cook_surface(self, mesh: MeasuredMesh) -> Surface:
        if mesh.digest not in self._meshes:
            self._meshes[mesh.digest] = primitives.make_surface(mesh.vertices, mesh.triangles, None, None)
        return self._meshes[mesh.digest]


_MARGIN: Final = 0.1
"""Margin on each side of a scene, as a fraction of its size."""

_MIN_HALF_SIZE: Final = 0.5
"""Minimum half side of a clipped plane [m]."""


@dataclass(frozen=True, slots=True)
class BodyMeshes:
    """A body and its shapes.

    Attributes:
        place: (4, 4) pose in its scene.
        corners: (·, 3) corners of the bounding boxes of all surfaces except planes, in its scene [m].
    """

    body: MeasuredBody
    shapes: tuple[MeshShape, ...]
    place: NDArray[np.float64]
    corners: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class EntityMeshes:
    """An entity and its bodies, in plan order."""

    measured: MeasuredEntity
    bodies: tuple[BodyMeshes, ...]


@dataclass(frozen=True, slots=True)
class SceneMeshes:
    """A scene and its entities."""

    scene: MeasuredScene
    entities: tuple[EntityMeshes, ...]


@dataclass(frozen=True, slots=True)
class GridCell:
    """The cell of each scene in a grid: (2,) lowest and highest x and y relative to the scene's origin [m]."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @property
    def half(self) -> float:
        """Half of its shorter side [m]."""
        return float((self.high - self.low).min()) / 2

    def origins(self, count: int) -> NDArray[np.float64]:
        """Returns (count, 3) origins of scenes, row by row [m]: x to the right and y up, viewed from above."""
        columns = math.ceil(math.sqrt(count))
        row, column = np.divmod(np.arange(count), columns)
        x, y = self.high - self.low
        return np.stack([column * x, -row * y, np.zeros(count)], axis=1)


def build_scene_meshes(
    mesh_builder: MeshBuilder, scene: MeasuredScene, show: Literal["visual", "collision"]
) -> SceneMeshes:
    """Builds the visual or the collision meshes of a scene.

    Raises:
        AssetError: a file cannot be shown, or a package is missing. `MeshBuilder.at` is the shape with the error.
    """
    entities: list[EntityMeshes] = []
    for entity in scene.entities:
        bodies: list[BodyMeshes] = []
        for body in entity.bodies:
            shapes = mesh_builder.visuals(body.body, entity.row) if show == "visual" else mesh_builder.collisions(body)
            bodies.append(mesh_builder.body(body, shapes))
        entities.append(EntityMeshes(entity, tuple(bodies)))
    return SceneMeshes(scene, tuple(entities))


def grid_cell(scenes: tuple[SceneMeshes, ...]) -> GridCell:
    """Returns a cell that contains each of the scenes, without planes."""
    every = scene_corners(scenes)[:, :2]
    if not len(every):
        return GridCell(np.full(2, -1.0), np.full(2, 1.0))
    low, high = every.min(axis=0), every.max(axis=0)
    margin = np.maximum((high - low) * _MARGIN, _MIN_HALF_SIZE / 2)
    return GridCell(low - margin, high + margin)


def plane_half_size(scene: SceneMeshes, place: NDArray[np.float64]) -> float:
    """Returns half the side for drawing an infinite plane under a scene [m]. `place`: (4, 4) pose of the plane."""
    corners = scene_corners([scene])
    if not len(corners):
        return _MIN_HALF_SIZE
    far = np.linalg.norm(corners - place[:3, 3], axis=1).max()
    return max(_MIN_HALF_SIZE, float(far) * (1 + _MARGIN))


def clip_plane(shape: MeshShape, half: float) -> MeshShape:
    """Limits the sides of a plane to 2 · `half` [m]."""
    x, y, z = shape.scale
    return replace(shape, scale=(x, half, half) if shape.endless else (x, min(y, half), min(z, half)))


def clip_to_scene(shape: MeshShape, body: BodyMeshes, scene: SceneMeshes, half: float | None) -> MeshShape:
    """Limits a plane to its scene's cell; returns other shapes unchanged.

    Args:
        shape: shape of the body.
        body: body in the scene.
        scene: the scene.
        half: half the side of the scene's cell [m]; None: no cell, so only infinite planes are clipped.
    """
    if shape.kind != "plane" or (half is None and not shape.endless):
        return shape
    return clip_plane(shape, plane_half_size(scene, body.place @ pose_matrix(shape.pose)) if half is None else half)


def scene_corners(scenes: Iterable[SceneMeshes]) -> NDArray[np.float64]:
    """Returns (·, 3) corners of all bodies, each in its own scene [m]. Planes have none."""
    corners = [body.corners for scene in scenes for entity in scene.entities for body in entity.bodies]
    return np.concatenate([np.zeros((0, 3)), *corners])


@frozen
class BakedMesh:
    """Triangles in the frame of their shape.

    Attributes:
        vertices: (V, 3) float64 [m].
        faces: (F, 3) int64, counterclockwise from the front.
        normals: (V, 3) float64 unit vectors; None: flat shading.
        uvs: (V, 2) float64 from the image's top left corner; None: (0, 0) everywhere.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    normals: NDArray[np.float64] | None
    uvs: NDArray[np.float64] | None
    look: SurfaceMaterial

    def to_obj(self) -> bytes:
        """Returns an OBJ file, with texture coordinates if there is a base colour image."""
        if self.uvs is None or self.look.base_color_image is None:
            return encode_obj(self.vertices, self.faces)
        from_bottom = np.column_stack([self.uvs[:, 0], 1 - self.uvs[:, 1]])
        return encode_obj(self.vertices, self.faces, (from_bottom, self.faces))


def bake_scale(shape: MeshShape) -> tuple[BakedMesh, ...]:
    """Returns the parts of a shape with its scale applied, but not its pose."""
    scale = np.array(shape.scale)
    inside_out = (np.prod(scale) < 0) != shape.turned
    found: list[BakedMesh] = []
    for part in shape.parts:
        surface = part.surface
        faces = surface.faces[:, ::-1] if inside_out else surface.faces
        normals = None
        if surface.normals is not None:
            normals = surface.normals / scale  # normals transform by the inverse transpose
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            normals *= -1 if shape.turned else 1
        uvs = None if surface.uvs is None else surface.uvs.astype(np.float64)
        found.append(BakedMesh(surface.vertices.astype(np.float64) * scale, faces, normals, uvs, part.look))
    return tuple(found)
