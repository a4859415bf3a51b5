"""Describes the visuals and collisions of SDF links."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from scenecc.assets.images import IMAGE_SUFFIXES
from scenecc.assets.meshes import MESH_SUFFIXES
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose, relative_pose
from scenecc.importers.meshes import (
    MeshError,
    check_terrain_file,
    ellipsoid_obj,
    load_mesh,
    mesh_as_obj,
    polyline_obj,
)
from scenecc.importers.numbers import along_x
from scenecc.importers.sdf_files import SMALLEST, SdfFile, SourceElement, find_element, find_file, text_of
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

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.geometry.rotations import Vec3
    from scenecc.importers.sdf_scopes import Scope

_TEXTURES: Final = {
    "albedo_map": "base_color_texture",
    "normal_map": "normal_texture",
    "roughness_map": "roughness_texture",
    "metalness_map": "metallic_texture",
    "emissive_map": "emission_texture",
}


FRICTION: Final = (1.0, 1.0, 0.0)
"""Default static and dynamic friction, and restitution: `<mu>`, `<mu2>` and `<restitution_coefficient>` of SDF.

Drake's default friction is the same (`multibody::default_friction()`).
"""

_Z: Final[Vec3] = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class SdfLink:
    """A link of a model.

    Attributes:
        scope: the scope that contains it.
        element: the <link>.
        path: from the top model, for messages.
        own: its pose in the scope's own frame.
        pose: its pose in the world.
    """

    scope: Scope
    element: SourceElement
    path: str
    own: Pose7
    pose: Pose7

    def local(self, element: SourceElement) -> Pose7:
        """Returns the pose of a shape, light or sensor in the link's frame."""
        pose = element.find("pose")
        frame = "" if pose is None else pose.attributes.get("relative_to", "")
        own = self.scope.file.pose(element)
        if not frame:
            return own
        return relative_pose(self.own, compose(self.scope.pose_of(frame, element), own))


def read_visuals(link: SdfLink, *, moves: bool) -> tuple[DescribedVisual, ...]:
    """Returns the visual shapes of a link. `moves`: whether forces move it."""
    found = [(each, _geometry(each, link, collides=False, moves=moves)) for each in link.element.all("visual")]
    return tuple(
        DescribedVisual(*made, each.location, look=_look(each, link)) for each, made in found if made is not None
    )


def read_collisions(link: SdfLink, *, moves: bool) -> tuple[DescribedCollision, ...]:
    """Returns the collision shapes of a link."""
    found = (_collision(each, link, moves=moves) for each in link.element.all("collision"))
    return tuple(each for each in found if each is not None)


def _collision(element: SourceElement, link: SdfLink, *, moves: bool) -> DescribedCollision | None:
    file = link.scope.file
    made = _geometry(element, link, collides=True, moves=moves)
    if made is None:
        return None
    friction, mask = _friction(element, file), _bitmask(element, file)
    density = None if element.find("density") is None else file.positive(element, "density", default=1000)
    if file.flag(element, "surface", "contact", "collide_without_contact", default=False):
        file.lose("contactless-shapes", f"a shape of `{link.path}` without contacts is left out", element, link.path)
        return None
    return DescribedCollision(*made, element.location, friction, density, (mask, mask))


def _bitmask(element: SourceElement, file: SdfFile) -> int:
    """Two shapes collide if their bitmasks share a bit."""
    found = find_element(element, "surface", "contact", "collide_bitmask")
    text = "65535" if found is None else found.text
    try:
        return int(text, 0) & 0xFFFF
    except ValueError:
        file.error(f"a bitmask must be an integer, not `{text[:60]}`", found or element)
        return 0xFFFF


def _friction(element: SourceElement, file: SdfFile) -> tuple[float, float, float]:
    surface = element.find("surface")
    drake = element.find("drake:proximity_properties")
    mu = file.number(surface, "friction", "ode", "mu", default=1)
    other = file.number(surface, "friction", "ode", "mu2", default=mu)
    if surface is not None and find_element(surface, "friction", "ode") is None:
        mu = other = file.number(surface, "friction", "bullet", "friction", default=mu)
    if abs(mu - other) > 1e-9:
        file.lose("friction-directions", f"`mu2` of {other:g}; friction is {mu:g} in all directions", element)
    static = file.number(drake, "drake:mu_static", default=mu)
    dynamic = min(file.number(drake, "drake:mu_dynamic", default=static), static)
    bounce = file.number(surface, "bounce", "restitution_coefficient", default=0)
    return _within(static, 1e6), _within(dynamic, 1e6), _within(bounce, 1)


def _within(number: float, most: float) -> float:
    return min(max(number, 0.0), most)


def _look(element: SourceElement, link: SdfLink) -> DescribedMaterial | None:
    file, material = link.scope.file, element.find("material")
    alpha = 1 - _within(file.number(element, "transparency", default=0), 1)
    if material is None:
        return DescribedMaterial((1.0, 1.0, 1.0, alpha)) if alpha < 1 else None
    look: dict[str, Any] = {}
    diffuse = _color(material, "diffuse", file) or _color(material, "ambient", file)
    if diffuse is not None:
        look["base_color"] = (*diffuse[:3], diffuse[3] * alpha)
    emissive = _color(material, "emissive", file)
    if emissive is not None and any(emissive[:3]):
        look["emission"] = emissive[:3]
    if material.find("script") is not None and diffuse is None:
        name = text_of(material, "script", "name") or "script"
        file.lose("material-scripts", f"the material script `{name}` of `{link.path}`", element, link.path)
    metal = find_element(material, "pbr", "metal")
    for tag, key in (("roughness", "roughness"), ("metalness", "metallic")):
        if find_element(metal, tag) is not None:
            look[key] = _within(file.number(metal, tag, default=0.5), 1)
    for tag, key in _TEXTURES.items():
        uri = text_of(metal, tag) or (text_of(material, "drake:diffuse_map") if tag == "albedo_map" else "")
        found = find_file(uri, file) if uri else ""
        if uri and isinstance(found, str):
            file.lose("missing-files", f"a texture: {found}", element, link.path)
        elif not isinstance(found, str) and found.suffix.lower() not in IMAGE_SUFFIXES:
            file.lose("missing-files", f"the texture {found.name} has an unsupported format", element, link.path)
        elif not isinstance(found, str):
            look[key] = DescribedTexture(found.name, found)
    return DescribedMaterial(**look) if look else None


def _color(material: SourceElement, tag: str, file: SdfFile) -> tuple[float, ...] | None:
    element = material.find(tag)
    if element is None or not element.text:
        return None
    numbers = file.numbers(element, 3 if len(element.text.split()) == 3 else 4)
    return None if numbers is None else tuple(_within(each, 1) for each in (*numbers, 1.0)[:4])


_Made = tuple[Geometry, Pose7] | str
"""A geometry and its pose in the frame of the <visual> or <collision>, or why it is unsupported."""


def _geometry(element: SourceElement, link: SdfLink, *, collides: bool, moves: bool) -> tuple[Geometry, Pose7] | None:
    """Returns the geometry and pose of a <visual> or <collision>; None if unsupported (a loss)."""
    geometry = element.find("geometry")
    form = None if geometry is None else next((each for each in geometry.children if each.tag in _FORMS), None)
    pose = link.local(element)
    if form is not None:
        made = _FORMS[form.tag](_Request(form, link, collides, moves))
    elif geometry is not None and geometry.find("empty") is None:
        made = "has no supported geometry"
    else:
        return None
    if not isinstance(made, str):
        return made[0], compose(pose, made[1])
    kind, what = ("colliders", "collision") if collides else ("visuals", "visual")
    name = element.attributes.get("name", "")
    link.scope.file.lose(kind, f"the {what} `{name}` of `{link.path}` {made}", element, link.path)
    return None


@dataclass(frozen=True, slots=True)
class _Request:
    form: SourceElement
    link: SdfLink
    collides: bool
    moves: bool

    @property
    def file(self) -> SdfFile:
        return self.link.scope.file

    def size(self, tag: str, default: float = 1.0) -> float:
        return self.file.positive(self.form, tag, default=default)


def _box(asked: _Request) -> _Made:
    size = asked.file.vector(asked.form, "size", default=(1, 1, 1))
    if min(size) < SMALLEST:
        return f"has size {' '.join(f'{each:g}' for each in size)}"
    return SolidGeometry("box", tuple(each / 2 for each in size)), IDENTITY_POSE


def _sphere(asked: _Request) -> _Made:
    return SolidGeometry("sphere", (asked.size("radius"),)), IDENTITY_POSE


def _round(kind: str) -> Callable[[_Request], _Made]:
    def read(asked: _Request) -> _Made:
        return SolidGeometry(kind, (asked.size("radius", 0.5), asked.size("length") / 2)), along_x(_Z)

    return read


def _plane(asked: _Request) -> _Made:
    normal = asked.file.vector(asked.form, "normal", default=_Z)
    if math.hypot(*normal) < SMALLEST:
        return "has a zero normal"
    if asked.collides:
        return "is a plane on a moving body" if asked.moves else (PlaneGeometry(), along_x(normal))
    x, y = asked.file.numbers(asked.form.find("size"), 2) or (1.0, 1.0)
    if min(x, y) < SMALLEST:
        return "is a plane without a size"
    # With its x up, y of the plane is y of the shape, and its z is -x.
    return PlaneGeometry((y / 2, x / 2)), along_x(normal)


def _ellipsoid(asked: _Request) -> _Made:
    radii = asked.file.vector(asked.form, "radii", default=(1, 1, 1))
    if min(radii) < SMALLEST:
        return "has a radius that is not positive"
    if asked.collides:
        asked.file.lose("ellipsoids", f"an ellipsoid of `{asked.link.path}` collides as a hull", asked.form)
    mesh = _generated("ellipsoid.obj", ellipsoid_obj(), radii)
    return replace(mesh, collision="hull" if asked.collides else None), IDENTITY_POSE


def _generated(name: str, data: bytes, scale: Vec3 = (1.0, 1.0, 1.0)) -> MeshGeometry:
    return MeshGeometry(name, Path(name), scale, data=data)


def _polyline(asked: _Request) -> _Made:
    points = [asked.file.numbers(each, 2) for each in asked.form.all("point")]
    height = asked.size("height")
    corners = [(each[0], each[1]) for each in points if each is not None]
    try:
        data = polyline_obj(corners, height)
    except MeshError as error:
        return f"is a polyline that {error}"
    return _mesh_shape(asked, _generated("polyline.obj", data), is_convex=False)


def _heightmap(asked: _Request) -> _Made:
    uri = text_of(asked.form, "uri")
    found = find_file(uri, asked.file)
    if isinstance(found, str):
        return f"is a heightmap, and {found}"
    if found.suffix.lower() != ".png":
        return "is a heightmap, but not a PNG"
    if asked.moves:
        return "is a heightmap on a moving body"
    try:
        check_terrain_file(found, asked.file.context)
    except MeshError as error:
        return f"is a heightmap: {error}"
    size = asked.file.vector(asked.form, "size", default=(1, 1, 1))
    if min(size) < SMALLEST:
        return "is a heightmap without a size"
    position = asked.file.vector(asked.form, "pos", default=(0, 0, 0))
    return HeightfieldGeometry(size, image=found), (*position, *IDENTITY_POSE[3:])


def _mesh(asked: _Request) -> _Made:
    uri = text_of(asked.form, "uri") or text_of(asked.form, "filename")
    found = find_file(uri, asked.file)
    if isinstance(found, str):
        return f"is a mesh, and {found}"
    scale = asked.file.vector(asked.form, "scale", default=(1, 1, 1))
    if found.suffix.lower() not in MESH_SUFFIXES:
        return f"is a mesh of unsupported format ({found.suffix or 'no suffix'})"
    if min(map(abs, scale)) < SMALLEST:
        return "is a mesh with scale 0"
    try:
        mesh = _usable_mesh(found, scale, asked)
    except MeshError as error:
        return f"is a mesh: {error}"
    return _mesh_shape(asked, mesh, is_convex=asked.form.find("drake:declare_convex") is not None)


def _usable_mesh(path: Path, scale: Vec3, asked: _Request) -> MeshGeometry:
    """Returns a mesh: the original, or an OBJ if a scene cannot use the original.

    Raises:
        MeshError: it cannot be read.
    """
    file = asked.file
    mesh = load_mesh(path, file.context)
    submesh = text_of(asked.form, "submesh", "name")
    is_mirrored = asked.collides and min(scale) < 0
    if not (submesh or mesh.missing or is_mirrored or (asked.collides and path.suffix.lower() == ".dae")):
        return MeshGeometry(path.name, path, scale)
    center = file.flag(asked.form, "submesh", "center", default=False)
    whole = (1.0, 1.0, 1.0)
    data = mesh_as_obj(mesh, submesh=submesh, scale=[*(scale if is_mirrored else whole)], center=center)
    if not asked.collides:
        why = f"it names `{mesh.missing[0][:80]}`, which is missing" if mesh.missing else f"part `{submesh[:80]}`"
        file.lose("mesh-looks", f"the materials of {path.name}: {why}", asked.form)
    name = f"{path.stem}{'_' + submesh if submesh else ''}.obj"
    return _generated(name, data, whole if is_mirrored else scale)


def _mesh_shape(asked: _Request, mesh: MeshGeometry, *, is_convex: bool) -> _Made:
    if not asked.collides:
        return mesh, IDENTITY_POSE
    optimization = asked.form.attributes.get("optimization", "")
    if optimization == "convex_decomposition":
        return replace(mesh, collision="coacd"), IDENTITY_POSE
    if not (asked.moves or is_convex or optimization == "convex_hull"):
        return replace(mesh, collision="triangles"), IDENTITY_POSE
    if not is_convex and optimization != "convex_hull":
        asked.file.lose("hulls", f"a mesh of `{asked.link.path}` collides as its convex hull", asked.form)
    return replace(mesh, collision="hull"), IDENTITY_POSE


_FORMS: Final[dict[str, Callable[[_Request], _Made]]] = {
    "box": _box,
    "sphere": _sphere,
    "cylinder": _round("cylinder"),
    "capsule": _round("capsule"),
    "drake:capsule": _round("capsule"),
    "cone": _round("cone"),
    "plane": _plane,
    "ellipsoid": _ellipsoid,
    "drake:ellipsoid": _ellipsoid,
    "mesh": _mesh,
    "heightmap": _heightmap,
    "polyline": _polyline,
}
