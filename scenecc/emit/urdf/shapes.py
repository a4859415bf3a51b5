"""What is seen of a link, and what of it collides."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Final

from scenecc.emit.urdf.origins import origin
from scenecc.emit.xml import frames
from scenecc.emit.xml.elements import Element
from scenecc.emit.xml.meshes import obj
from scenecc.meshes import Look, baked
from scenecc.plan import Box, Capsule, Cylinder, Sphere

if TYPE_CHECKING:
    from scenecc.emit.urdf.robot import Robot
    from scenecc.geometry.rotations import Pose7
    from scenecc.meshes import Shape
    from scenecc.plan import VisualGeometry
    from scenecc.plan.snapshot import MeasuredBody, MeasuredShape

_LYING: Final[Pose7] = (0.0, 0.0, 0.0, 0.7071067811865476, 0.0, -0.7071067811865476, 0.0)
"""From a frame in which a capsule lies along x to one in which it stands along z."""

_OF_A_SHAPE: Final = ("material", "contact_offset", "rest_offset", "patch_radius", "min_patch_radius")
_SEEN: Final = frozenset({"base_color", "base_color_image", "visibility"})
_PLAIN: Final = Look()


def write_collisions(robot: Robot, body: MeasuredBody, back: Pose7, link: Element) -> None:
    """A collision for each colliding shape of the engine. `back`: from the link's own frame to that in the file."""
    for shape in body.shapes:
        robot.lost.fields(robot.name, shape.shape, _OF_A_SHAPE, shape.shape.origin, " of a shape")
        if shape.kind == "plane":
            robot.lost.leave_out(robot.name, "a plane", shape.shape.origin)
            continue
        element = link.add("collision")
        pose = frames.compose(shape.pose, _LYING) if shape.kind in {"capsule", "cylinder"} else shape.pose
        origin(element, frames.compose(back, pose))
        _write_colliding(robot, shape, element.add("geometry"))


def _write_colliding(robot: Robot, shape: MeasuredShape, geometry: Element) -> None:
    mesh = shape.mesh
    if mesh is None:
        _write_primitive(geometry, shape.kind, shape.sizes)
        return
    if shape.kind == "triangle_mesh":
        words = "a triangle mesh may be read as its convex hull, as SAPIEN's own loader does"
        robot.lost.change(robot.name, words, shape.shape.origin)
    _write_mesh(robot, geometry, f"{robot.name}_collision", obj(mesh.vertices, mesh.triangles))


def _write_primitive(geometry: Element, kind: str, sizes: tuple[float, ...]) -> None:
    if kind == "box":
        geometry.add("box", size=tuple(2 * size for size in sizes))
    elif kind == "sphere":
        geometry.add("sphere", radius=sizes[0])
    else:
        geometry.add(kind, radius=sizes[0], length=2 * sizes[1])


def _write_mesh(robot: Robot, geometry: Element, stem: str, data: bytes) -> None:
    file = robot.beside.add(stem, ".obj", data)
    geometry.add("mesh", filename=f"{robot.beside.folder}/{file}")


def write_visuals(robot: Robot, body: MeasuredBody, back: Pose7, link: Element) -> None:
    """A visual for all that is seen, a mesh for each of its parts. Raises MeshProblem."""
    row = robot.measured.row
    for shape, plan in zip(robot.drawer.visuals(body.body, row), body.body.visuals, strict=False):
        parts = baked(shape)
        native = _native(plan.geometry, row)
        for part in parts:
            element = link.add("visual", name=shape.name or None)
            lying = native is not None and native[0] in {"capsule", "cylinder"}
            pose = frames.compose(shape.pose, _LYING) if lying else shape.pose
            origin(element, frames.compose(back, pose))
            geometry = element.add("geometry")
            if native is None:
                uvs = part.uvs if part.look.base_color_image else None
                _write_mesh(robot, geometry, shape.name or robot.name, obj(part.vertices, part.faces, uvs))
            else:
                _write_primitive(geometry, *native)
            element.take(_material(robot, part.look, shape))


def _native(geometry: VisualGeometry, row: int) -> tuple[str, tuple[float, ...]] | None:
    """URDF's own kind of what is seen, and its sizes; None: it is drawn of triangles."""
    match geometry:
        case Box(half_size=size):
            return "box", tuple(map(float, size.row(row)))
        case Sphere(radius=radius):
            return "sphere", (float(radius.row(row)),)
        case Capsule(radius=radius, half_length=length):
            return "capsule", (float(radius.row(row)), float(length.row(row)))
        case Cylinder(radius=radius, half_length=length):
            return "cylinder", (float(radius.row(row)), float(length.row(row)))
        case _:
            return None


def _material(robot: Robot, look: Look, shape: Shape) -> Element:
    """A colour or an image."""
    lost = [f"`{item.name.replace('_image', '_texture')}`" for item in fields(look) if _is_lost(look, item.name)]
    if look.visibility < 1 and look.base_color_image is not None:
        lost.append("`visibility`")
    if lost:
        robot.lost.leave_out(robot.name, ", ".join(lost), shape.origin)
    name = robot.looks.setdefault(look, f"material_{len(robot.looks)}")
    element = Element("material", name=name)
    image = look.base_color_image
    if image is None:
        element.add("color", rgba=look.tint)
    else:
        file = robot.beside.add(image.name or "texture", image.suffix, image.data)
        element.add("texture", filename=f"{robot.beside.folder}/{file}")
    return element


def _is_lost(look: Look, field: str) -> bool:
    return field not in _SEEN and getattr(look, field) != getattr(_PLAIN, field)
