"""Shapes of a link or body as entries of a scene document."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import chain
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

from scenecc.geometry.rotations import IDENTITY, Pose7, multiply_quaternions, rotate, shortest_from_x
from scenecc.importers.imported_scene import Asset
from scenecc.importers.numbers import SINGLE, Names, clean_pose, plain_axis, plain_number, plain_numbers, pose_key
from scenecc.robots.description import (
    DescribedCollision,
    DescribedMaterial,
    DescribedTexture,
    DescribedVisual,
    Geometry,
    HeightfieldGeometry,
    MeshGeometry,
    PlaneGeometry,
    SolidGeometry,
)
from scenecc.scene_file.shared_keys import SHAPE_LISTS, form_of, merge_shapes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.geometry.rotations import Quat, Vec3
    from scenecc.scene_file import Node

_LETTERS: Final[dict[str, Vec3]] = {"x": (1.0, 0.0, 0.0), "z": (0.0, 0.0, 1.0), "y": (0.0, 1.0, 0.0)}

_FRICTION_KEYS: Final = ("static_friction", "dynamic_friction", "restitution")

_HALF_TURNS: Final[tuple[Quat, ...]] = (IDENTITY, (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))

_USUAL_LOOK: Final = {"specular": 0.0, "roughness": 1.0, "metallic": 0.0}
"""SAPIEN's defaults, which are not written."""

_MESH_TYPES: Final[dict[str, Node]] = {
    "hull": {"type": "convex_mesh"},
    "parts": {"type": "convex_parts"},
    "coacd": {"type": "convex_parts", "decomposition": "coacd"},
    "triangles": {"type": "triangle_mesh"},
    "sdf": {"type": "triangle_mesh", "sdf": True},
}


@dataclass(slots=True)
class NamedMaterials:
    """Materials that have a name in the source.

    Attributes:
        named: section `materials`.
    """

    named: dict[str, Node] = field(default_factory=dict[str, "Node"])
    _free: Names = field(default_factory=Names)

    def note(self, content: Node, *names: str) -> None:
        """Names a material of several parts, unless an equal one or none of the parts has a name."""
        wishes = dict.fromkeys(filter(None, names))
        if content and wishes and self._name_of(content) is None:
            self.named[self._free.new("_".join(wishes))] = content

    def replace_in(self, node: Node) -> None:
        """Replaces the materials of a body or link and of its shapes by their names."""
        for entry in (node, *(entry for key in SHAPE_LISTS for entry in node.get(key, ()))):
            name = self._name_of(entry["material"]) if "material" in entry else None
            if name is not None:
                entry["material"] = name

    def is_look(self, material: Any) -> bool:
        """Returns whether a material, or that of a name, has a look."""
        return "visual" in (self.named[material] if isinstance(material, str) else material or ())

    def _name_of(self, content: Node) -> str | None:
        return next((name for name, other in self.named.items() if other == content), None)


def shape_lists(
    collisions: Sequence[DescribedCollision],
    visuals: Sequence[DescribedVisual],
    friction: tuple[float, float, float] | None,
    materials: NamedMaterials,
    *,
    weighs: bool,
) -> tuple[Node, list[Node]]:
    """Returns `shapes`, `collisions` and `visuals`, and the entry of each collision shape, in their order.

    Args:
        collisions: of one link.
        visuals: of the same link. A visual with the geometry of a collision becomes one shape with it.
        friction: default of the scene, which is not written.
        materials: receives the materials with a name.
        weighs: whether the mass follows from the densities.
    """
    seen = [_visual_entry(visual) for visual in visuals]
    left: dict[Any, list[int]] = {}
    for number, entry in enumerate(seen):
        left.setdefault(form_of(entry), []).append(number)
    found: dict[str, list[Node]] = {key: [] for key in SHAPE_LISTS}
    entries: list[Node] = []
    for collision in collisions:
        entry = _collision_entry(collision, friction, weighs=weighs)
        names, key = [collision.material], "collisions"
        if twins := left.get(form_of(entry)):
            twin = twins.pop(0)
            entry, key = merge_shapes(entry, seen[twin]), "shapes"
            names.insert(0, _look_name(visuals[twin]))
        materials.note(entry.get("material", {}), *names)
        entries.append(entry)
        found[key].append(entry)
    for number in sorted(chain.from_iterable(left.values())):
        materials.note(seen[number].get("material", {}), _look_name(visuals[number]))
        found["visuals"].append(seen[number])
    return {key: value for key, value in found.items() if value}, entries


def _collision_entry(shape: DescribedCollision, friction: tuple[float, float, float] | None, *, weighs: bool) -> Node:
    geometry = PlaneGeometry() if isinstance(shape.geometry, PlaneGeometry) else shape.geometry
    kind = geometry.collision or "hull" if isinstance(geometry, MeshGeometry) else "hull"
    entry = _geometry_keys(geometry, shape.pose, _MESH_TYPES[kind])
    if shape.density is not None and weighs:
        entry["density"] = plain_number(shape.density)
    for key in ("contact_offset", "rest_offset"):
        if (offset := getattr(shape, key)) is not None:
            entry[key] = plain_number(offset)
    if shape.friction is not None and shape.friction != friction:
        entry["material"] = {"physical": friction_keys(shape.friction)}
    return entry


def friction_keys(friction: tuple[float, float, float]) -> Node:
    """Returns static friction, dynamic friction and restitution as keys of a physical material."""
    return dict(zip(_FRICTION_KEYS, plain_numbers(friction), strict=True))


def _visual_entry(visual: DescribedVisual) -> Node:
    entry = _geometry_keys(visual.geometry, visual.pose, {"type": "mesh"})
    entry |= {"name": visual.name} if visual.name else {}
    look = None if visual.look is None else _look_keys(visual.look)
    if look is not None and set(look) == {"base_color"} and not _look_name(visual):
        entry["color"] = look["base_color"]
    elif look or (look is not None and isinstance(visual.geometry, MeshGeometry)):
        entry["material"] = {"visual": look}
    return entry


def _look_name(visual: DescribedVisual) -> str:
    return "" if visual.look is None else visual.look.name


def _look_keys(look: DescribedMaterial) -> Node:
    keys: Node = {}
    for name in ("base_color", "emission"):
        color = getattr(look, name)
        if color is not None:
            keys[name] = plain_numbers(color[:3] if color[3:] in {(), (1.0,)} else color)
    for name in _USUAL_LOOK:
        number = getattr(look, name)
        if number is not None and number != _USUAL_LOOK[name]:
            keys[name] = plain_number(number)
    for name in ("base_color", "normal", "roughness", "metallic", "emission"):
        if (image := getattr(look, f"{name}_texture")) is not None:
            keys[f"{name}_texture"] = texture_value(image)
    return keys


def texture_value(image: DescribedTexture) -> Any:
    """Returns a texture as a value of a key."""
    asset = Asset(image.path.name, image.path)
    keys = {"srgb": image.srgb, "address_mode": image.address_mode}
    given = {key: value for key, value in keys.items() if value is not None}
    return {"file": asset, **given} if given else asset


def _geometry_keys(geometry: Geometry, pose: Pose7, mesh: Node) -> Node:
    """Returns type, sizes and pose of a shape. `mesh`: keys of a mesh."""
    match geometry:
        case SolidGeometry():
            return _solid_keys(geometry, pose)
        case PlaneGeometry(half_size):
            size = {} if half_size is None else {"half_size": plain_numbers(half_size)}
            return {"type": "plane", **size, **_plane_place(pose)}
        case MeshGeometry():
            return {**mesh, **_mesh_keys(geometry), **pose_key(clean_pose(pose))}
        case HeightfieldGeometry(size, heights, image):
            keys: Node = {"type": "heightfield", "size": plain_numbers(size)}
            terrain = {"file": Asset(image.name, image)} if image else {"heights": [plain_numbers(r) for r in heights]}
            return {**keys, **terrain, **pose_key(clean_pose(pose))}


def _mesh_keys(mesh: MeshGeometry) -> Node:
    name = PurePath(mesh.uri).name or mesh.path.name
    keys: Node = {"file": Asset(name, mesh.path if mesh.data is None else mesh.data)}
    if mesh.scale == (1.0, 1.0, 1.0):
        return keys
    row = plain_numbers(mesh.scale)
    return {**keys, "scale": row[0] if len({*row}) == 1 else row}


def _solid_keys(solid: SolidGeometry, pose: Pose7) -> Node:
    if solid.kind == "box":
        return {"type": "box", "half_size": plain_numbers(solid.sizes), **pose_key(clean_pose(pose))}
    radius, *half = plain_numbers(solid.sizes)
    keys: Node = {"type": solid.kind, "radius": radius}
    if not half:
        return {**keys, **pose_key(clean_pose(pose))}
    axis, place = lying_axis(pose, is_symmetric=solid.kind != "cone")
    lies = {} if axis == "x" else {"axis": axis}
    return {**keys, "half_length": half[0], **lies, **pose_key(place)}


def lying_axis(pose: Pose7, *, is_symmetric: bool) -> tuple[str, Pose7]:
    """Returns the axis and the pose of a round solid along x of `pose`: those with the plainest rotation.

    It may be turned by 180° about its axis, and if `is_symmetric` also over, since both ends are then alike.
    """
    # Half a turn about its axis changes nothing.
    ways = [_unturned(pose, turn) for turn in _HALF_TURNS[: 4 if is_symmetric else 2]]
    places = [
        (name, clean_pose(_unturned(way, shortest_from_x(axis)))) for way in ways for name, axis in _LETTERS.items()
    ]
    return min(places, key=lambda place: _complexity(place[1]))


def axis_frames(in_parent: Pose7, in_child: Pose7) -> tuple[Any, Pose7, Pose7]:
    """Returns the axis and the frames of a constraint along x of two frames: those with the plainest rotations."""
    ways: list[tuple[Any, Pose7, Pose7]] = []
    for axis in (*_LETTERS.values(), rotate(in_child[3:], _LETTERS["x"])):
        parent, child = (clean_pose(_unturned(pose, shortest_from_x(axis))) for pose in (in_parent, in_child))
        ways.append((plain_axis(axis), parent, child))
    return min(ways, key=lambda way: _complexity(way[1]) + _complexity(way[2]))


def _plane_place(pose: Pose7) -> Node:
    """Returns normal and pose of a plane, whose normal is x of `pose`."""
    upright = clean_pose(_unturned(pose, shortest_from_x((0.0, 0.0, 1.0))))
    normal = rotate(pose[3:], (1.0, 0.0, 0.0))
    turned = clean_pose(_unturned(pose, shortest_from_x(normal)))
    if _complexity(turned) < _complexity(upright):
        return {"normal": _plain_axis_vector(normal), **pose_key(turned)}
    return pose_key(upright)


def _plain_axis_vector(axis: Vec3) -> list[float]:
    """Returns a direction as numbers."""
    plain = plain_axis(axis)
    return list(_LETTERS[plain]) if isinstance(plain, str) else plain


def _unturned(pose: Pose7, turn: Quat) -> Pose7:
    w, x, y, z = turn
    return (*pose[:3], *multiply_quaternions(pose[3:], (w, -x, -y, -z)))


def _complexity(pose: Pose7) -> int:
    q = pose[3:]
    if max(abs(abs(a) - b) for a, b in zip(q, IDENTITY, strict=True)) < SINGLE:
        return 0
    turn = pose_key(pose)["pose"]
    # Fewer angles are plainer, positive ones before negative ones.
    return sum(2 + (angle < 0) for angle in turn["rpy_deg"] if angle) if "rpy_deg" in turn else 10
