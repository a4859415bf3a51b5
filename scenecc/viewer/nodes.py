"""The content of a page as data: frames, meshes and names by path."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotation_arrays import compose
from scenecc.geometry.rotations import to_vector
from scenecc.meshes.builder import clip_to_scene, grid_cell, scene_corners
from scenecc.plan import ArticulationStructure
from scenecc.plan.framing import Motion, Solids
from scenecc.plan.rendering import FLAT_THICKNESS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Pose7, Quat, Vec3
    from scenecc.meshes.builder import BodyMeshes, EntityMeshes, SceneMeshes
    from scenecc.meshes.surface import MeshPart, MeshShape, Surface
    from scenecc.viewer.cameras import BrowserView
    from scenecc.viewer.lights import PageLight
    from scenecc.viewer.options import ViewOptions
    from scenecc.viewer.surfaces import SurfaceFiles


Key = tuple[int, str, int]
"""A body: index of its scene, name of its entity, and its index among the entity's bodies."""

_UNTURNED: Final[Quat] = (1.0, 0.0, 0.0, 0.0)

_FEW: Final = 8
"""Up to this many copies of a surface are separate nodes, which follow the frame of their body; the browser moves them
without redrawing. More copies become instances of one node."""

_COLORS: Final = 100
"""From this many plain materials of one surface on, its copies are instances of one node and show only their colours,
without gloss: each material would be a file and a node of its own."""

_FAINT: Final = 0.5
"""Opacity of collision shapes over visual shapes, and of everything while contacts are shown."""

_APART: Final = 0.12
"""Distance between the names of two links, in sizes of their articulation."""

_NUMBER_AT: Final = 0.8
"""Place of a scene's number in a grid, towards the corner of its cell that is near the first view."""

_SLASH: Final = "\N{DIVISION SLASH}"
"""Replaces slashes in names, because slashes separate the path: nodes move with their parent path."""


@frozen
class Frame:
    """A frame below the path above it. `axes`: whether its axes are shown."""

    position: Vec3
    wxyz: Quat
    axes: bool = False


@frozen
class SurfaceNode:
    """A surface of a body.

    Attributes:
        file: name of its file, see `SurfaceFiles`.
        position, wxyz: in the body's frame. scale: along its own axes.
        body: its body.
    """

    file: str
    position: Vec3
    wxyz: Quat
    scale: Vec3
    body: Key

    def is_moved(self, before: SurfaceNode) -> bool:
        """Returns whether it is the same surface of the same body, perhaps with another pose."""
        return (self.file, self.body) == (before.file, before.body)


@frozen
class Name:
    """A text label.

    Attributes:
        text: the text.
        position: in the frame above it [m].
        body: its body. None: it is the number of a scene.
        is_link: whether it is shown only while its link is selected.
        is_apart: whether a link's name is also shown while another link of its articulation is selected, because it
            hides no other name of that articulation.
    """

    text: str
    position: Vec3
    body: Key | None = None
    is_link: bool = False
    is_apart: bool = False

    def is_shown(self, selected: Key | None) -> bool:
        """Returns whether it is shown while a body is selected."""
        same = selected is not None and self.body is not None and self.body[:2] == selected[:2]
        return not self.is_link or (same and (self.is_apart or self.body == selected))


@frozen
class Instances:
    """Copies of one surface on many bodies, as one node. Compared by identity.

    Attributes:
        file: name of its file, see `SurfaceFiles`.
        rows: (N,) body of each copy, as a row of `BodyPoses`.
        places: (N, 7) p [m] then q (wxyz) of each copy in its body's frame.
        scales: (N, 3) scales along its own axes.
        surface: its surface, if it has no file.
        colors: (N, 4) linear RGBA of each copy of `surface`.
    """

    file: str
    rows: NDArray[np.intp]
    places: NDArray[np.float64]
    scales: NDArray[np.float32]
    surface: Surface | None = None
    colors: NDArray[np.float64] | None = None

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @staticmethod
    def of(nodes: Sequence[SurfaceNode], file: str, rows: Mapping[Key, int]) -> Instances:
        """Merges copies of one surface into one node. `rows`: rows of their bodies."""
        return Instances(
            file,
            np.array([rows[node.body] for node in nodes], np.intp),
            np.array([(*node.position, *node.wxyz) for node in nodes], np.float64),
            np.array([node.scale for node in nodes], np.float32),
        )

    def is_moved(self, before: Instances) -> bool:
        """Returns whether it has as many copies of the same surface, perhaps with other poses or bodies."""
        same = (self.file, len(self.rows)) == (before.file, len(before.rows))
        return same and (self.surface is None) == (before.surface is None)

    def poses(self, bodies: BodyPoses) -> NDArray[np.float64]:
        """(N, 7) poses of the copies on the page."""
        return compose(bodies.world[self.rows], self.places)


Node = Frame | SurfaceNode | Name | Instances


@frozen
class BodyPoses:
    """Poses of the bodies on a page. Compared by identity.

    Attributes:
        rows: row of each body, in order.
        origins: (N, 3) origins of their scenes on the page [m].
        world: (N, 7) p [m] then q (wxyz) of each body on the page.
    """

    rows: Mapping[Key, int]
    origins: NDArray[np.float64]
    world: NDArray[np.float64]

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @staticmethod
    def of(poses: Mapping[Key, Pose7], origins: Mapping[int, Vec3]) -> BodyPoses:
        """Creates poses from poses in the scenes and the origins of the scenes on the page [m]."""
        rows = {key: row for row, key in enumerate(poses)}
        places = np.array([origins[index] for index, _, _ in poses], np.float64).reshape(-1, 3)
        world = np.array([*poses.values()], np.float64).reshape(-1, 7)
        world[:, :3] += places
        return BodyPoses(rows, places, world)

    def moved(self, keys: Sequence[Key], poses: NDArray[np.float32]) -> BodyPoses:
        """Returns the poses with some bodies moved. `poses`: (N, 7) p [m] then q (wxyz), in their scenes."""
        rows, world = [self.rows[key] for key in keys], self.world.copy()
        world[rows] = poses
        world[rows, :3] += self.origins[rows]
        return replace(self, world=world)

    def key(self, row: int) -> Key:
        """Returns the body in a row."""
        return [*self.rows][row]


@frozen
class PageContent:
    """Everything on the page.

    Attributes:
        nodes: nodes by path; parents come first.
        bodies: frame path of each body; bodies with only instances have none.
        poses: poses of all bodies.
        corners: (N, 3) corners around everything but the ground [m].
        shadows: whether shadows are drawn.
        origins: origins of the scenes, by index [m].
        solids: boxes of the first scene, to frame what moves in it.
        views: views of the file's cameras.
        lights: lights of the first scene; empty: neutral light.
    """

    nodes: dict[str, Node]
    bodies: dict[Key, str]
    poses: BodyPoses
    corners: NDArray[np.float64]
    shadows: bool
    origins: Mapping[int, Vec3]
    solids: Solids
    views: tuple[BrowserView, ...] = ()
    lights: tuple[PageLight, ...] = ()

    def moved(self, keys: Sequence[Key], poses: NDArray[np.float32]) -> PageContent:
        """Returns the content with some bodies moved. `poses`: (N, 7) p [m] then q (wxyz), in their scenes."""
        nodes = dict(self.nodes)
        for key, pose in zip(keys, poses.tolist(), strict=True):
            path = self.bodies.get(key)
            if path is not None:
                position, wxyz = _split_pose(tuple(pose))
                nodes[path] = replace(nodes[path], position=position, wxyz=wxyz)
        return replace(self, nodes=nodes, poses=self.poses.moved(keys, poses))


def page_content(
    visual: tuple[SceneMeshes, ...], colliding: tuple[SceneMeshes, ...] | None, look: ViewOptions, files: SurfaceFiles
) -> PageContent:
    """Returns everything on the page.

    Args:
        visual: the scenes with visual shapes.
        colliding: the same scenes with collision shapes; None: they are not shown.
        look: what is shown of them.
        files: collects the surfaces.
    """
    painter = _Painter(look, files)
    drawn = (*(visual if look.visual else ()), *(colliding or ())) or visual
    solid = tuple(map(_solid, drawn))
    drawn = solid if any(one.entities for one in solid) else drawn
    cell = grid_cell(drawn) if look.grid else None
    places = np.zeros((len(visual), 3)) if cell is None else cell.origins(len(visual))
    half = None if cell is None else cell.half
    origins: dict[int, Vec3] = {}
    for number, (scene, (x, y, z)) in enumerate(zip(visual, places.tolist(), strict=True)):
        origins[scene.scene.index] = (x, y, z)
        painter.scene(scene, "visual", half, show=look.visual)
        if colliding is not None:
            painter.scene(colliding[number], "collision", half, show=True)
    corners = [scene_corners([scene]) + origins[scene.scene.index] for scene in drawn]
    poses = BodyPoses.of(painter.poses, origins)
    nodes, bodies = painter.nodes(poses.rows, origins)
    if half is not None:
        corner = half * _NUMBER_AT
        nodes |= {
            f"/number {index}": Name(f"Scene {index}", (x + corner, y + corner, z))
            for index, (x, y, z) in origins.items()
        }
    return PageContent(nodes, bodies, poses, np.concatenate(corners), look.shadows, origins, _solids(drawn[0]))


def _solids(scene: SceneMeshes) -> Solids:
    """Returns the boxes of all shapes of one scene, without planes."""
    bodies = [body for entity in scene.entities for body in entity.bodies]
    corners = [body.corners.reshape(-1, 8, 3) for body in bodies]
    every = np.concatenate([np.zeros((0, 8, 3)), *corners])
    return Solids(
        np.stack([every.min(axis=1), every.max(axis=1)], axis=1),
        np.repeat(np.arange(len(bodies)), [len(boxes) for boxes in corners]),
        np.array([_MOTIONS.get(body.body.body_type, Motion.STATIC) for body in bodies], np.int64),
    )


_MOTIONS: Final = {"dynamic": Motion.DYNAMIC, "link": Motion.DYNAMIC, "kinematic": Motion.KINEMATIC}


def _solid(scene: SceneMeshes) -> SceneMeshes:
    """Returns the scene without flat bodies such as the ground, unless there is nothing else."""
    entities = [replace(one, bodies=tuple(filter(_is_solid, one.bodies))) for one in scene.entities]
    return replace(scene, entities=tuple(one for one in entities if one.bodies))


def _is_solid(body: BodyMeshes) -> bool:
    return len(body.corners) > 0 and float(np.ptp(body.corners, axis=0).min()) > FLAT_THICKNESS


class _Painter:
    """Collects the shapes of bodies, and creates nodes once the number of copies is known."""

    def __init__(self, look: ViewOptions, files: SurfaceFiles) -> None:
        self._look = look
        self._files = files
        self.poses: dict[Key, Pose7] = {}
        self._paths: dict[Key, tuple[str, ...]] = {}
        self._names: dict[Key, Name] = {}
        self._surfaces: dict[Key, list[tuple[str, SurfaceNode]]] = {}

    def scene(self, scene: SceneMeshes, role: str, half: float | None, *, show: bool) -> None:
        """Adds the bodies of a scene, with their shapes in a role if these are shown."""
        # Collision shapes mostly overlap visual shapes, and contacts are inside both.
        see_through = self._look.contacts or (role == "collision" and self._look.visual)
        for entity in scene.entities:
            hidden = entity.measured.entity.name in self._look.hidden
            bodies = [*_bodies(scene, entity)]
            if self._look.names:
                self._names |= _names(entity, [(key, name, body) for key, _, name, body in bodies])
            for key, steps, _, body in bodies:
                self.poses[key], self._paths[key] = body.body.pose, steps
                surfaces = self._surfaces.setdefault(key, [])
                for number, shape in enumerate(body.shapes if show and not hidden else ()):
                    fitted = _tiles_cut(clip_to_scene(shape, body, scene, half), half)
                    surfaces += self._shape(f"{role} {number}", fitted, key, see_through=see_through)

    def _shape(self, name: str, shape: MeshShape, key: Key, *, see_through: bool) -> Iterator[tuple[str, SurfaceNode]]:
        place = _split_pose(shape.pose)
        parts = [_seen_through(part) for part in shape.parts] if see_through else shape.parts
        for number, part in enumerate(parts):
            # Parts of one shape share a path.
            own = name if len(shape.parts) == 1 else f"{name}.{number}"
            yield own, SurfaceNode(self._files.name(part, turned=shape.turned), *place, shape.scale, key)

    def nodes(self, rows: Mapping[Key, int], origins: Mapping[int, Vec3]) -> tuple[dict[str, Node], dict[Key, str]]:
        """Returns all nodes by path, and the frame path of each body that has one.

        Args:
            rows: rows of the bodies, for instances.
            origins: origins of the scenes on the page [m].
        """
        groups = self._groups()
        sizes = Counter(groups[node.file] for _, node in self._each() if _may_be_instance(node))
        many = {group: list[SurfaceNode]() for group, size in sizes.items() if size >= _FEW}
        nodes: dict[str, Node] = {_root(index): Frame(origin, _UNTURNED) for index, origin in origins.items()}
        bodies: dict[Key, str] = {}
        roles: dict[str, str] = {}
        for key, surfaces in self._surfaces.items():
            own: dict[str, Node] = {}
            for name, node in surfaces:
                group = groups[node.file]
                if group in many and _may_be_instance(node):
                    many[group].append(node)
                    roles[group] = name.partition(" ")[0]
                else:
                    own[name] = node
                    self._files.write(node.file)
            if self._look.names:
                own["name"] = self._names[key]
            if own or self._look.frames:
                bodies[key] = self._add_frame(nodes, key)
                nodes.update({f"{bodies[key]}/{name}": node for name, node in own.items()})
        nodes |= {f"/copies/{roles[group]} {group}": self._copies(group, found, rows) for group, found in many.items()}
        return nodes, bodies

    def _groups(self) -> dict[str, str]:
        """Returns for each file the one whose copies are merged: itself, or that of the surface without its colour."""
        files = dict.fromkeys(node.file for _, node in self._each())
        plain = {file: self._files.plain(file) for file in files}
        colors = Counter(plain.values())
        return {file: white if white and colors[white] >= _COLORS else file for file, white in plain.items()}

    def _copies(self, group: str, nodes: Sequence[SurfaceNode], rows: Mapping[Key, int]) -> Instances:
        if all(node.file == group for node in nodes):
            self._files.write(group)
            return Instances.of(nodes, group, rows)
        colors = np.array([self._files.tint(node.file) for node in nodes], np.float64)
        return replace(Instances.of(nodes, group, rows), surface=self._files.surface(group), colors=colors)

    def _add_frame(self, nodes: dict[str, Node], key: Key) -> str:
        """Adds the frame of a body, and returns its path."""
        *above, last = self._paths[key]
        path = _root(key[0])
        for step in above:
            # The links of an articulation are siblings below it, so that moving one does not move another.
            path = f"{path}/{step}"
            nodes.setdefault(path, Frame((0.0, 0.0, 0.0), _UNTURNED))
        path = f"{path}/{last}"
        nodes[path] = Frame(*_split_pose(self.poses[key]), axes=self._look.frames)
        return path

    def _each(self) -> Iterator[tuple[str, SurfaceNode]]:
        for surfaces in self._surfaces.values():
            yield from surfaces


def _may_be_instance(node: SurfaceNode) -> bool:
    """Returns whether it is not mirrored: all instances of a node are drawn with the same winding."""
    x, y, z = node.scale
    return x * y * z > 0


def _root(index: int) -> str:
    return f"/scene {index}"


def _bodies(scene: SceneMeshes, entity: EntityMeshes) -> Iterator[tuple[Key, tuple[str, ...], str, BodyMeshes]]:
    """Yields the bodies of an entity: key, steps of its path below the scene, and name. A root link is named after its
    articulation.
    """
    name = entity.measured.entity.name
    for number, body in enumerate(entity.bodies):
        key = (scene.scene.index, name, number)
        if isinstance(entity.measured.structure, ArticulationStructure):
            yield key, (_escaped(name), _escaped(body.body.name)), body.body.name if number else name, body
        else:
            yield key, (_escaped(name),), name, body


def _names(entity: EntityMeshes, bodies: Iterable[tuple[Key, str, BodyMeshes]]) -> dict[Key, Name]:
    """Returns the names of the bodies of an entity, each in the middle of its shapes: two links often have the same
    origin.
    """
    corners = np.concatenate([np.zeros((0, 3)), *(body.corners for body in entity.bodies)])
    apart = _APART * float(np.linalg.norm(np.ptp(corners, axis=0))) if len(corners) else 0.0
    found: dict[Key, Name] = {}
    kept: list[NDArray[np.float64]] = []
    for key, text, body in bodies:
        place, is_apart = (0.0, 0.0, 0.0), False
        if len(body.corners):
            middle = (body.corners.min(axis=0) + body.corners.max(axis=0)) / 2
            place = to_vector((middle - body.place[:3, 3]) @ body.place[:3, :3])
            is_apart = all(np.linalg.norm(middle - other) > apart for other in kept)
            kept += [middle] * is_apart
        found[key] = Name(text, place, key, is_link=key[2] > 0, is_apart=is_apart)
    return found


def _tiles_cut(shape: MeshShape, half: float | None) -> MeshShape:
    """Returns the shape, with a tiled plane cut to the size of a grid cell."""
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


def _seen_through(part: MeshPart) -> MeshPart:
    return replace(part, look=replace(part.look, visibility=_FAINT))


def _escaped(name: str) -> str:
    """Returns a name as one step of a path."""
    return name.replace("/", _SLASH)


def _split_pose(pose: tuple[float, ...]) -> tuple[Vec3, Quat]:
    x, y, z, qw, qx, qy, qz = pose
    return (x, y, z), (qw, qx, qy, qz)
