"""Reads bodies of live scenes: shapes, materials, masses, and other values that differ from SAPIEN's defaults."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cache, lru_cache
from itertools import takewhile
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np

from scenecc.backends.sapien.engine import physx, render, sapien
from scenecc.backends.sapien.geometry import COLLISION_SHAPES, VISUAL_SHAPES
from scenecc.backends.sapien.properties import BODY_PROPERTIES, COLLISION_GROUPS, LINK_FIELDS, RENDER_PROPERTIES
from scenecc.decompiler.tables import TEXTURES
from scenecc.decompiler.values import (
    FileNamer,
    Node,
    Same,
    color_value,
    nearly_same,
    pose_value,
    same_single,
    scale_value,
    to_number,
    to_numbers,
)
from scenecc.geometry.rotations import shortest_from_x
from scenecc.plan.body import PhysicalMaterial, VisualMaterial
from scenecc.plan.geometry import Box, Capsule, Cylinder, Sphere
from scenecc.plan.properties import DEFAULT_DENSITY, properties_of
from scenecc.plan.schema import type_name
from scenecc.scene_file.shared_keys import form_of, merge_shapes, move_shape_keys_up
from scenecc.spec.body import MOTION_AXES

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.decompiler.record import Recording

_AXES: Final = {"y": shortest_from_x((0.0, 1.0, 0.0)), "z": shortest_from_x((0.0, 0.0, 1.0))}

_UP: Final = _AXES["z"]

_KINDS: Final = {
    shape.engine: (type_name(geometry), shape.sizes)
    for table in (COLLISION_SHAPES, VISUAL_SHAPES)
    for geometry, shape in table.items()
    if geometry in (Box, Sphere, Capsule, Cylinder)
}
"""SAPIEN's collision and render classes of primitives → types and size keys of a scene file."""

_LYING: Final = frozenset(engine for engine, (type_, _) in _KINDS.items() if type_ in ("capsule", "cylinder"))

_SHAPE_KEYS: Final = {row.field: row.key for row in properties_of("shape")}

_BODY_KEYS: Final = {row.field: row.key for row in properties_of("body")}


@dataclass(frozen=True)
class SceneDefaults:
    """Default values of a scene's shapes and bodies, from its section `physics`.

    Attributes:
        friction: static friction, dynamic friction, restitution.
        shape, body: properties by SAPIEN's names.
    """

    friction: tuple[float, ...] = (0.3, 0.3, 0.1)
    shape: Node = field(default_factory=dict[str, Any])
    body: Node = field(default_factory=dict[str, Any])


@cache
def untouched() -> dict[str, Node]:
    """Returns the values of newly created SAPIEN objects, by "shape", "body", "link", "look"."""
    shape = physx.PhysxShapeConfig()
    body = physx.PhysxBodyConfig()
    fresh = physx.PhysxRigidDynamicComponent()
    link = physx.PhysxArticulationLinkComponent(None)
    own = {name: getattr(body, name) for name in ("sleep_threshold",) if hasattr(body, name)}
    own |= {
        f"solver_{kind}_iterations": getattr(body, f"solver_{kind}_iterations") for kind in ("position", "velocity")
    }
    return {
        "shape": {
            "density": float(DEFAULT_DENSITY),
            "patch_radius": 0.0,
            "min_patch_radius": 0.0,
            "contact_offset": shape.contact_offset,
            "rest_offset": shape.rest_offset,
        },
        "body": {name: getattr(fresh, name) for name in BODY_PROPERTIES.by_field} | own,
        "link": {name: getattr(link, name) for name in LINK_FIELDS},
        "look": {"visibility": 1.0, "shading_mode": 0},
    }


def plain_value(value: Any) -> Any:
    """Converts an engine value to plain data."""
    if isinstance(value, bool | int | str):
        return value
    return to_numbers(value) if hasattr(value, "__len__") else to_number(value)


def is_equal(first: Any, second: Any) -> bool:
    """Returns whether two engine values are the same."""
    return plain_value(first) == plain_value(second)


_FRICTION_FIELDS = tuple(field.name for field in fields(PhysicalMaterial))

_LOOK_FIELDS = tuple(field.name for field in fields(VisualMaterial) if not field.name.endswith("_texture"))


def friction_of(material: Any) -> tuple[float, ...]:
    """Returns the numbers of a `PhysxMaterial`."""
    return tuple(getattr(material, name) for name in _FRICTION_FIELDS)


def physical_material(friction: Iterable[float]) -> Node:
    """Returns a material with the numbers of `friction_of`."""
    return {"physical": dict(zip(_FRICTION_FIELDS, to_numbers(friction), strict=True))}


class LiveBodyReader:
    """Reads bodies of live scenes.

    Attributes:
        problems: content that a scene file cannot represent, one sentence each.
    """

    def __init__(self, recording: Recording | None, files: FileNamer, defaults: SceneDefaults) -> None:
        self._recording = recording
        self._files = files
        self._defaults = defaults
        self.problems: list[str] = []
        self._batches: list[Any] = []

    def body(self, name: str, component: Any, look: Any) -> Node:
        """Returns a body from its physical and its render component; either may be None."""
        node: Node = {}
        kind = body_type(component)
        if kind != "dynamic":
            node["body_type"] = kind
        node |= self.shapes(name, component, look) or {"shapes": []}
        if kind in ("dynamic", "kinematic"):
            node |= self._motion(component, untouched()["body"] | self._defaults.body, _BODY_KEYS)
        if kind == "dynamic" and not component.auto_compute_mass:
            node["inertial"] = inertial(component)
        return node

    def link_properties(self, component: Any) -> Node:
        """Returns the properties of a link that differ from a new link's."""
        return self._motion(component, untouched()["link"], {name: _BODY_KEYS[name] for name in LINK_FIELDS})

    def link_default(self, key: str) -> Any:
        """Returns a new link's value of a key."""
        (name,) = (name for name, other in _BODY_KEYS.items() if other == key)
        value = untouched()["link"][name]
        return not value if name == "disable_gravity" else plain_value(value)

    def articulation_properties(self, articulation: Any, names: Iterable[str]) -> Node:
        """Returns the properties of an articulation that differ from a new one's."""
        fresh = untouched()["body"] | self._defaults.body
        return {
            name: plain_value(getattr(articulation, name))
            for name in names
            if not is_equal(getattr(articulation, name), fresh[name])
        }

    def keep_alive(self, batch: Any) -> None:
        """Keeps a batch alive as long as this reader, since values read from it are engine objects."""
        self._batches.append(batch)

    @staticmethod
    def look_of(entity: Any) -> Any:
        """Returns an entity's render body; None if it has none."""
        return next((each for each in entity.components if isinstance(each, render.RenderBodyComponent)), None)

    def _motion(self, component: Any, fresh: Node, keys: dict[str, str]) -> Node:
        kinematic = getattr(component, "kinematic", False)
        found: Node = {}
        for name, key in keys.items():
            value = getattr(component, name)
            if is_equal(value, fresh[name]) or (kinematic and name.endswith("_velocity") and "max" not in name):
                continue
            if name == "disable_gravity":
                found[key] = not value
            elif name == "locked_motion_axes":
                found[key] = [axis for axis, locked in zip(MOTION_AXES, value, strict=True) if locked]
            else:
                found[key] = plain_value(value)
        return found

    def shapes(self, name: str, component: Any, look: Any) -> Node:
        """Returns `shapes`, `collisions` and `visuals`, and the keys that they share."""
        collisions = self._collisions(name, component) if component is not None else []
        visuals = [self._visual(name, shape) for shape in look.render_shapes] if look is not None else []
        if component is not None and look is not None and len(collisions) == len(component.collision_shapes):
            pairs = zip(component.collision_shapes, look.render_shapes, strict=False)
            for number, (shape, seen) in enumerate(pairs):
                if _same_place(shape.local_pose, seen.local_pose):
                    place = {key: value for key, value in collisions[number].items() if key in _PLACE}
                    visuals[number] = {k: v for k, v in visuals[number].items() if k not in _PLACE} | place
        pairs = zip(collisions, visuals, strict=False)
        both = [merge_shapes(*pair) for pair in takewhile(lambda pair: form_of(pair[0]) == form_of(pair[1]), pairs)]
        lists = {"shapes": both, "collisions": collisions[len(both) :], "visuals": visuals[len(both) :]}
        node: Node = {key: items for key, items in lists.items() if items}
        move_shape_keys_up(node, is_link=isinstance(component, physx.PhysxArticulationLinkComponent), least=2)
        if look is not None:
            fresh = untouched()["look"]
            looks = {key: plain_value(getattr(look, key)) for key in RENDER_PROPERTIES.by_field}
            node |= {key: value for key, value in looks.items() if value != fresh[key]}
        return node

    def _collisions(self, name: str, component: Any) -> list[Node]:
        nodes: list[Node] = []
        parts: set[int] = set()
        for shape in component.collision_shapes:
            source = self._recording.mesh_of(shape) if self._recording is not None else None
            if source is not None and source.parts:
                if source.load in parts:
                    continue
                parts.add(source.load)
            node = self._collision(name, shape, source)
            groups = list(shape.get_collision_groups())
            if groups != list(COLLISION_GROUPS.default):
                node["collision_bits"] = groups
            nodes.append(node)
        return nodes

    def _collision(self, name: str, shape: Any, source: Any) -> Node:
        node = self._geometry(name, shape, source)
        fresh = untouched()["shape"] | self._defaults.shape
        if node["type"] == "plane":
            fresh["density"] = 0.0
        for field_name, key in _SHAPE_KEYS.items():
            value = getattr(shape, field_name)
            if not is_equal(value, fresh[field_name]):
                node[key] = plain_value(value)
        friction = friction_of(shape.physical_material)
        if not same_single(friction, self._defaults.friction):
            node["material"] = physical_material(friction)
        return node

    def _geometry(self, name: str, shape: Any, source: Any) -> Node:
        kind: Any = cast("Any", type(shape))
        pose = shape.local_pose
        if kind in _KINDS:
            type_, sizes = _KINDS[kind]
            node: Node = {"type": type_} | {size: plain_value(getattr(shape, size)) for size in sizes}
            return node | _turned_pose(pose, is_same_in_shape, lying=kind in _LYING)
        if kind is physx.PhysxCollisionShapePlane:
            return {"type": "plane", **_plane_pose(pose, is_same_in_shape)}
        if source is None:
            self.problems.append(
                f"`{name}`: a collision mesh whose file is unknown; build the scene in `scenecc.record()`"
            )
            return {"type": "box", "half_size": [1.0, 1.0, 1.0]}
        node = {"type": source.type, "file": self._files.name(source.file)}
        scale = scale_value(shape.scale)
        node |= {} if scale is None else {"scale": scale}
        node |= source.keys
        value = pose_value(pose, is_same_in_shape)
        return node | ({} if value is None else {"pose": value})

    def _visual(self, name: str, shape: Any) -> Node:
        kind: Any = cast("Any", type(shape))
        if kind in _KINDS:
            type_, sizes = _KINDS[kind]
            node: Node = {"type": type_} | {size: plain_value(getattr(shape, size)) for size in sizes}
            node |= _turned_pose(shape.local_pose, nearly_same, lying=kind in _LYING)
        elif kind is render.RenderShapePlane:
            node = {
                "type": "plane",
                "half_size": to_numbers(shape.scale[1:]),
                **_plane_pose(shape.local_pose, nearly_same),
            }
            if same_single(node["half_size"], (10.0, 10.0)):
                del node["half_size"]
        else:
            node = self._visual_mesh(name, shape)
        if shape.name:
            node["name"] = shape.name
        mirrored = node["type"] == "mesh" and float(shape.scale[0] * shape.scale[1] * shape.scale[2]) < 0
        if (shape.front_face == "clockwise") != mirrored:
            node["front_face"] = shape.front_face
        return node | self._look(shape, node)

    def _visual_mesh(self, name: str, shape: Any) -> Node:
        value = pose_value(shape.local_pose, nearly_same)
        node: Node = {} if value is None else {"pose": value}
        if shape.filename:
            scale = scale_value(shape.scale)
            return {"type": "mesh", "file": self._files.name(shape.filename), **node} | (
                {} if scale is None else {"scale": scale}
            )
        tiled = _tiled_plane(shape)
        if tiled is None:
            self.problems.append(f"`{name}`: a visual mesh without a file")
            tiled = {"type": "tiled_plane", "half_size": [1.0, 1.0], "texture_repeat": [1.0, 1.0]}
        if "pose" in tiled and "pose" in node:
            self.problems.append(f"`{name}`: a rotated flat mesh away from its origin")
        return {**tiled, **node}

    def _look(self, shape: Any, node: Node) -> Node:
        if node["type"] == "mesh":
            looks = [visual_material(part.material, self._files) for part in shape.parts]
            if looks == _looks_of_file(shape.filename, self._files):
                return {}
            if any(look != looks[0] for look in looks):
                self.problems.append(f"the parts of the mesh {node['file']} have materials that its file does not have")
            found = looks[0]
        else:
            found = visual_material(shape.parts[0].material, self._files)
        if not found.keys() - {"base_color"}:
            color = found.get("base_color")
            if color is not None or node["type"] == "mesh":
                return {"color": color or [1.0, 1.0, 1.0]}
            return {}
        return {"material": {"visual": found}}


def body_type(component: Any) -> str:
    """Returns the body type for a scene file. `component`: physical component or None."""
    if component is None:
        return "none"
    if isinstance(component, physx.PhysxRigidStaticComponent):
        return "static"
    return "kinematic" if component.kinematic else "dynamic"


def inertial(component: Any) -> Node:
    """Returns the mass properties of a component."""
    com = pose_value(component.cmass_local_pose)
    node = {"mass": to_number(component.mass), "inertia": to_numbers(component.inertia)}
    return node if com is None else {**node, "com": com}


def is_same_in_shape(given: Iterable[float], found: Iterable[float]) -> bool:
    """Returns whether a collision shape stores the given quaternion as the found one, since PhysX normalizes it."""
    shape = _any_shape()
    shape.set_local_pose(sapien.Pose(q=list(given)))
    return same_single(shape.local_pose.q, found)


@cache
def _any_shape() -> Any:
    return physx.PhysxCollisionShapeSphere(1.0, physx.get_default_material())


def _turned_pose(pose: Any, same: Same, *, lying: bool) -> Node:
    """Returns `pose`, and `axis` for solids along an axis."""
    if lying:
        for axis, turn in _AXES.items():
            if same(turn, to_numbers(pose.q)):
                p = to_numbers(pose.p)
                return {"axis": axis, **({"pose": p} if any(p) else {})}
    value = pose_value(pose, same)
    return {} if value is None else {"pose": value}


def _plane_pose(pose: Any, same: Same) -> Node:
    p = to_numbers(pose.p)
    if same(_UP, to_numbers(pose.q)):
        return {"pose": p} if any(p[:2]) else {"offset": p[2]} if p[2] else {}
    value = pose_value(pose, same)
    return {"normal": [1.0, 0.0, 0.0], **({} if value is None else {"pose": value})}


def _tiled_plane(shape: Any) -> Node | None:
    """Returns a flat grid that faces +z as a `tiled_plane`; None for other meshes."""
    (part, *others) = shape.parts
    found = flat_grid(part.vertices, part.get_vertex_uv())
    if others or found is None or not same_single(shape.scale, (1, 1, 1)):
        return None
    low, high, uv_low, uv_high = found
    node: Node = {
        "type": "tiled_plane",
        "half_size": to_numbers((high - low) / 2),
        "texture_repeat": to_numbers(uv_high - uv_low),
    }
    centre = [*to_numbers((high + low) / 2), to_number(part.vertices[0, 2])]
    return {**node, "pose": centre} if any(centre) else node


def flat_grid(vertices: Any, uvs: Any) -> tuple[Any, Any, Any, Any] | None:
    """Returns corners (2,), (2,) and their texture coordinates (2,), (2,) if vertices (N, 3) form an evenly textured
    rectangle in a z plane, else None.
    """
    if len(vertices) < 4 or len(uvs) != len(vertices) or np.ptp(vertices[:, 2]) > 0:
        return None
    places, uvs = vertices[:, :2].astype(np.float64), uvs.astype(np.float64)
    low, high, uv_low, uv_high = places.min(0), places.max(0), uvs.min(0), uvs.max(0)
    if not ((high > low).all() and (uv_high > uv_low).all()):
        return None
    even = uv_low + (places - low) / (high - low) * (uv_high - uv_low)
    return (low, high, uv_low, uv_high) if np.abs(even - uvs).max() <= 1e-4 * (1 + np.abs(uvs).max()) else None


def visual_material(material: Any, files: FileNamer) -> Node:
    """Returns the values of a `RenderMaterial` that differ from a new one's."""
    fresh = _fresh_material()
    found: Node = {}
    for name in _LOOK_FIELDS:
        value = plain_value(getattr(material, name))
        if value != fresh[name]:
            found[name] = color_value(value) if isinstance(value, list) else value
    for name in TEXTURES:
        texture = getattr(material, f"{name}_texture")
        if texture is not None:
            found[f"{name}_texture"] = _texture(texture, files)
    return found


def _texture(texture: Any, files: FileNamer) -> Any:
    file = files.name(texture.filename) if texture.filename else ""
    defaults = {"mipmap_levels": 1, "filter_mode": "linear", "address_mode": "repeat", "srgb": True}
    given = {key: getattr(texture, "is_srgb" if key == "srgb" else key) for key in defaults}
    changed = {key: value for key, value in given.items() if value != defaults[key]}
    return {"file": file, **changed} if changed else file


@cache
def _fresh_material() -> Node:
    fresh = render.RenderMaterial()
    return {name: plain_value(getattr(fresh, name)) for name in _LOOK_FIELDS}


@lru_cache(maxsize=256)
def _looks_of_file(filename: str, files: FileNamer) -> list[Node]:
    """Returns the materials of a mesh file's parts.

    The cache serves one `decompile`, which creates one `FileNamer`: texture paths depend on its base.
    """
    mesh = render.RenderShapeTriangleMesh(filename, [1, 1, 1], None)
    return [visual_material(part.material, files) for part in mesh.parts]


_PLACE: Final = frozenset(("pose", "axis", "normal", "offset"))


def _same_place(first: Any, second: Any) -> bool:
    """Returns whether two poses look the same, since PhysX normalizes the rotations of collision shapes."""
    turns = [np.asarray(pose.q, np.float64) / np.linalg.norm(pose.q) for pose in (first, second)]
    return bool(np.abs(first.p - second.p).max() <= _NEAR and abs(turns[0] @ turns[1]) >= 1 - _NEAR)


_NEAR: Final = 1e-6
