"""The content of a page as data: frames, meshes and names by their paths."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.emit.glb import part_to_glb
from scenecc.meshes.builder import clip_to_scene, grid_cell, scene_corners
from scenecc.plan import ArticulationStructure
from scenecc.plan.rendering import FLAT_THICKNESS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Quat, Vec3
    from scenecc.meshes import Surface
    from scenecc.meshes.builder import BodyMeshes, EntityMeshes, SceneMeshes
    from scenecc.meshes.surface import MeshPart, MeshShape
    from scenecc.meshes.surface import SurfaceMaterial as Material
    from scenecc.viewer.options import ViewOptions


Key = tuple[int, str, int]
"""A body: index of its scene, name of its entity, and its own number among the entity's."""

_UNTURNED: Final[Quat] = (1.0, 0.0, 0.0, 0.0)

_FAINT: Final = 0.5
"""How visible what collides is, over what is seen."""

_SLASH: Final = "\N{DIVISION SLASH}"
"""Stands for the slash of a name: what is below a path on the page moves with it."""


@frozen
class Frame:
    """A frame below that of the path above it. `axes`: whether they are shown."""

    position: Vec3
    wxyz: Quat
    axes: bool = False


@frozen
class SurfaceNode:
    """A surface of a body.

    Attributes:
        digest: of its file, see `Files`.
        position, wxyz: in the body's frame. scale: along its own axes.
        body: that has it.
    """

    digest: str
    position: Vec3
    wxyz: Quat
    scale: Vec3
    body: Key

    def is_moved(self, before: SurfaceNode) -> bool:
        """Whether it is the same surface of the same body, at another place perhaps."""
        return (self.digest, self.body) == (before.digest, before.body)


@frozen
class Name:
    """A text at the origin of the frame above it."""

    text: str


Node = Frame | SurfaceNode | Name


@frozen
class PageContent:
    """All that is shown.

    Attributes:
        nodes: by path, what is above others before these.
        bodies: the path of each.
        corners: (N, 3) around everything but the ground [m].
        shadows: whether there are any.
    """

    nodes: dict[str, Node]
    bodies: dict[Key, str]
    corners: NDArray[np.float64]
    shadows: bool

    def moved(self, keys: Sequence[Key], poses: NDArray[np.float32]) -> PageContent:
        """The same with some bodies elsewhere. `poses`: (N, 7) p [m] then q (wxyz), in their scenes."""
        nodes = dict(self.nodes)
        for key, pose in zip(keys, poses.tolist(), strict=True):
            path = self.bodies[key]
            position, wxyz = _placed(tuple(pose))
            nodes[path] = replace(nodes[path], position=position, wxyz=wxyz)
        return replace(self, nodes=nodes)


class Files:
    """Surfaces as files. What was made once is kept as long as something shown uses it."""

    def __init__(self) -> None:
        self._digests: dict[tuple[str, Material, bool], str] = {}
        self._surfaces: dict[Surface, str] = {}
        self.contents: dict[str, bytes] = {}

    def digest(self, part: MeshPart, *, turned: bool) -> str:
        """The digest of a part's file, which is in `contents`."""
        key = (self._surface(part.surface), part.look, turned)
        if key not in self._digests:
            content = part_to_glb(_shaded(part), turned=turned)
            digest = sha256(content).hexdigest()
            self._digests[key] = digest
            self.contents[digest] = content
        return self._digests[key]

    def keep(self, used: set[str]) -> None:
        """Forgets every file that is not among these."""
        self._surfaces = {}
        self._digests = {key: digest for key, digest in self._digests.items() if digest in used}
        self.contents = {digest: content for digest, content in self.contents.items() if digest in used}

    def _surface(self, surface: Surface) -> str:
        if surface not in self._surfaces:
            digest = sha256()
            for array in (surface.vertices, surface.faces, surface.normals, surface.uvs):
                digest.update(b"-" if array is None else b"%d:" % array.size + array.tobytes())
            self._surfaces[surface] = digest.hexdigest()
        return self._surfaces[surface]


def page_content(
    visual: tuple[SceneMeshes, ...], colliding: tuple[SceneMeshes, ...] | None, look: ViewOptions, files: Files
) -> PageContent:
    """All that is shown.

    Args:
        visual: the scenes with what is seen of bodies.
        colliding: the same scenes with what collides; None: it is not shown.
        look: what is shown of them.
        files: takes the surfaces.
    """
    painter = _Painter(look, files)
    drawn = (*(visual if look.visual else ()), *(colliding or ())) or visual
    solid = tuple(map(_solid, drawn))
    drawn = solid if any(one.entities for one in solid) else drawn
    cell = grid_cell(drawn) if look.grid else None
    origins = np.zeros((len(visual), 3)) if cell is None else cell.origins(len(visual))
    half = None if cell is None else cell.half
    for number, (scene, origin) in enumerate(zip(visual, origins, strict=True)):
        root = f"/scene {scene.scene.index}"
        x, y, z = map(float, origin)
        painter.nodes[root] = Frame((x, y, z), _UNTURNED)
        painter.scene(root, scene, "visual", half, show=look.visual)
        if colliding is not None:
            painter.scene(root, colliding[number], "collision", half, show=True)
    at = {scene.scene.index: origin for scene, origin in zip(visual, origins, strict=True)}
    corners = [scene_corners([scene]) + at[scene.scene.index] for scene in drawn]
    return PageContent(painter.nodes, painter.bodies, np.concatenate(corners), look.shadows)


def _solid(scene: SceneMeshes) -> SceneMeshes:
    """The scene without what is flat, as the ground is: where there is anything else, that takes no room."""
    entities = [replace(one, bodies=tuple(filter(_is_solid, one.bodies))) for one in scene.entities]
    return replace(scene, entities=tuple(one for one in entities if one.bodies))


def _is_solid(body: BodyMeshes) -> bool:
    return len(body.corners) > 0 and float(np.ptp(body.corners, axis=0).min()) > FLAT_THICKNESS


class _Painter:
    def __init__(self, look: ViewOptions, files: Files) -> None:
        self._look = look
        self._files = files
        self.nodes: dict[str, Node] = {}
        self.bodies: dict[Key, str] = {}

    def scene(self, root: str, scene: SceneMeshes, role: str, half: float | None, *, show: bool) -> None:
        """Adds the bodies of a scene, and their shapes in a role where these are to be shown."""
        for entity in scene.entities:
            if isinstance(entity.measured.structure, ArticulationStructure):
                # Its links stand below it and not below one another, so that it moves none of them.
                self.nodes[f"{root}/{_escaped(entity.measured.entity.name)}"] = Frame((0.0, 0.0, 0.0), _UNTURNED)
            for key, path, name, body in _bodies(root, scene, entity):
                self.bodies[key] = path
                self.nodes[path] = Frame(*_placed(body.body.pose), axes=self._look.frames)
                if self._look.names:
                    self.nodes[f"{path}/name"] = Name(name)
                shapes = body.shapes if show else ()
                # What collides lies mostly where something is seen.
                see_through = role == "collision" and self._look.visual
                for number, shape in enumerate(shapes):
                    fitted = _tiles_cut(clip_to_scene(shape, body, scene, half), half)
                    self._shape(f"{path}/{role} {number}", fitted, key, see_through=see_through)

    def _shape(self, path: str, shape: MeshShape, key: Key, *, see_through: bool) -> None:
        place = _placed(shape.pose)
        parts = [_seen_through(part) for part in shape.parts] if see_through else shape.parts
        for number, part in enumerate(parts):
            # Parts of one shape: one path each.
            own = path if len(shape.parts) == 1 else f"{path}.{number}"
            digest = self._files.digest(part, turned=shape.turned)
            self.nodes[own] = SurfaceNode(digest, *place, shape.scale, key)


def _bodies(root: str, scene: SceneMeshes, entity: EntityMeshes) -> Iterator[tuple[Key, str, str, BodyMeshes]]:
    """The bodies of an entity: key, path and name."""
    name = entity.measured.entity.name
    path = f"{root}/{_escaped(name)}"
    for number, body in enumerate(entity.bodies):
        key = (scene.scene.index, name, number)
        if isinstance(entity.measured.structure, ArticulationStructure):
            yield key, f"{path}/{_escaped(body.body.name)}", f"{name}/{body.body.name}", body
        else:
            yield key, path, name, body


def _tiles_cut(shape: MeshShape, half: float | None) -> MeshShape:
    """The shape; of a tiled plane as much as there is room for in a cell, with tiles as large as before."""
    x, y, _ = shape.scale
    if shape.kind != "tiled_plane" or half is None or max(x, y) <= half:
        return shape
    small = min(x, half), min(y, half)
    parts: list[MeshPart] = []
    for part in shape.parts:
        uvs = part.surface.uvs
        kept = None if uvs is None else 0.5 + (uvs - 0.5) * np.array((small[0] / x, small[1] / y), np.float32)
        parts.append(replace(part, surface=replace(part.surface, uvs=kept)))
    return replace(shape, parts=tuple(parts), scale=(*small, 1.0))


def _shaded(part: MeshPart) -> MeshPart:
    """A part as viser shades it as SAPIEN does.

    viser computes normals itself, by all triangles that have a vertex; where the file gives normals, it writes over
    them, and over the places of vertices, too, where both are the same numbers, as of a ball. So none are given, and a
    triangle that is flat has vertices of its own.
    """
    surface = part.surface
    if surface.normals is not None:
        return replace(part, surface=replace(surface, normals=None))
    corners = surface.faces.ravel()
    uvs = None if surface.uvs is None else surface.uvs[corners]
    apart = replace(surface, vertices=surface.vertices[corners], faces=np.arange(len(corners)).reshape(-1, 3), uvs=uvs)
    return replace(part, surface=apart)


def _seen_through(part: MeshPart) -> MeshPart:
    return replace(part, look=replace(part.look, visibility=_FAINT))


def _escaped(name: str) -> str:
    """A name as one step of a path."""
    return name.replace("/", _SLASH)


def _placed(pose: tuple[float, ...]) -> tuple[Vec3, Quat]:
    x, y, z, qw, qx, qy, qz = pose
    return (x, y, z), (qw, qx, qy, qz)
