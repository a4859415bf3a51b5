"""Converts visuals and collisions of SDF links to shapes of a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from scenecc.assets.images import IMAGE_SUFFIXES
from scenecc.assets.meshes import MESH_SUFFIXES
from scenecc.geometry.rotations import Pose7, compose, relative_pose
from scenecc.importers.imported_scene import Asset
from scenecc.importers.meshes import (
    MeshError,
    check_terrain_file,
    ellipsoid_obj,
    load_mesh,
    mesh_as_obj,
    polyline_obj,
)
from scenecc.importers.numbers import plain_number, plain_numbers, pose_key
from scenecc.importers.sdf_files import SMALLEST, SdfFile, SourceElement, find_element, find_file, text_of

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from scenecc.importers.sdf_scopes import Scope

Shape = dict[str, Any]

_TEXTURES: Final = {
    "albedo_map": "base_color_texture",
    "normal_map": "normal_texture",
    "roughness_map": "roughness_texture",
    "metalness_map": "metallic_texture",
    "emissive_map": "emission_texture",
}


@dataclass(frozen=True, slots=True)
class LinkPlace:
    """Context for the shapes of a link.

    Attributes:
        scope: scope of the link.
        path: path of the link, for messages.
        pose: pose of the link in the scope's own frame.
        moves: whether forces move it.
    """

    scope: Scope
    path: str
    pose: Pose7
    moves: bool

    def local(self, element: SourceElement) -> Pose7:
        """Returns the pose of a shape, light or sensor in the link's frame."""
        pose = element.find("pose")
        frame = "" if pose is None else pose.attributes.get("relative_to", "")
        own = self.scope.file.pose(element)
        if not frame:
            return own
        return relative_pose(self.pose, compose(self.scope.pose_of(frame, element), own))


def read_shapes(link: SourceElement, place: LinkPlace) -> dict[str, list[Shape]]:
    """Returns `shapes`, `collisions` and `visuals` of a link. A visual and an equal collision become one shape."""
    collided = [shape for each in link.all("collision") for shape in _collision(each, place)]
    seen = [shape for each in link.all("visual") for shape in _visual(each, place)]
    twins: dict[str, list[int]] = {}
    for number, visual in enumerate(seen):
        twins.setdefault(repr(_geometry_keys(visual)), []).append(number)
    shapes: list[Shape] = []
    collisions: list[Shape] = []
    for collision in collided:
        form = _geometry_keys(collision)
        numbers = twins.get(repr(form), []) if _is_shared(collision) else []
        if numbers and _geometry_keys(seen[numbers[0]]) == form:
            shapes.append(_merge_sides(collision, seen[numbers[0]]))
            seen[numbers.pop(0)] = {}
        else:
            collisions.append(collision)
    visuals = [visual for visual in seen if visual]
    found = {"shapes": shapes, "collisions": collisions, "visuals": visuals}
    return {name: each for name, each in found.items() if each}


def solid_mass(shape: Shape, density: float) -> float:
    """Returns the mass of a collision solid [kg]; nan for a mesh."""
    density = shape.get("density", density)
    radius, half = shape.get("radius", 0.0), shape.get("half_length", 0.0)
    disc = math.pi * radius**2
    volumes = {
        "box": 8 * math.prod(shape.get("half_size", ())),
        "sphere": disc * radius * 4 / 3,
        "cylinder": disc * 2 * half,
        "capsule": disc * (2 * half + radius * 4 / 3),
        "cone": disc * 2 * half / 3,
        "plane": 0.0,
    }
    return density * volumes.get(shape["type"], math.nan)


def _geometry_keys(shape: Shape) -> dict[str, Any]:
    looks = {"material", "color", "density", "name", "bitmask"}
    form = {key: shape[key] for key in sorted(shape) if key not in looks}
    if form["type"] == "plane":
        form.pop("half_size", None)
    return {**form, "type": "mesh"} if form["type"] == "convex_mesh" else form


def _is_shared(shape: Shape) -> bool:
    return shape["type"] in {"box", "sphere", "capsule", "cylinder", "cone", "convex_mesh", "plane"}


def _merge_sides(collision: Shape, visual: Shape) -> Shape:
    """Returns a shape with the geometry of a collision and the look of a visual."""
    material = {**visual.get("material", {}), **collision.get("material", {})}
    merged = {**{key: value for key, value in visual.items() if key != "material"}, **collision}
    return {**merged, "material": material} if material else merged


def _collision(element: SourceElement, place: LinkPlace) -> list[Shape]:
    file = place.scope.file
    made = _geometry(element, place, collides=True)
    if made is None:
        return []
    physical = _physical(element, file)
    if physical:
        made["material"] = {"physical": physical}
    density = element.find("density")
    if density is not None:
        made["density"] = plain_number(file.positive(element, "density", default=1000))
    made["bitmask"] = _bitmask(element, file)
    if file.flag(element, "surface", "contact", "collide_without_contact", default=False):
        file.lose("contactless-shapes", f"a shape of `{place.path}` without contacts is left out", element, place.path)
        return []
    return [made]


def _bitmask(element: SourceElement, file: SdfFile) -> int:
    """Two shapes collide if their bitmasks share a bit."""
    found = find_element(element, "surface", "contact", "collide_bitmask")
    text = "65535" if found is None else found.text
    try:
        return int(text, 0) & 0xFFFF
    except ValueError:
        file.error(f"a bitmask must be an integer, not `{text[:60]}`", found or element)
        return 0xFFFF


def _physical(element: SourceElement, file: SdfFile) -> dict[str, Any]:
    """Returns friction and restitution that differ from SDF's default: 1, 1 and 0."""
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
    values = (max(static, 0.0), max(dynamic, 0.0), min(max(bounce, 0.0), 1.0))
    names = ("static_friction", "dynamic_friction", "restitution")
    if values == (1.0, 1.0, 0.0):
        return {}
    return {name: plain_number(min(value, 1e6)) for name, value in zip(names, values, strict=True)}


def _visual(element: SourceElement, place: LinkPlace) -> list[Shape]:
    made = _geometry(element, place, collides=False)
    if made is None:
        return []
    look = _look(element, place)
    if set(look) == {"base_color"}:
        made["color"] = look["base_color"]
    elif look:
        made["material"] = {"visual": look}
    return [made]


def _look(element: SourceElement, place: LinkPlace) -> dict[str, Any]:
    file, material = place.scope.file, element.find("material")
    alpha = 1 - min(max(file.number(element, "transparency", default=0), 0), 1)
    if material is None:
        return {"base_color": [1, 1, 1, alpha]} if alpha < 1 else {}
    look: dict[str, Any] = {}
    diffuse = _color(material, "diffuse", file) or _color(material, "ambient", file)
    if diffuse is not None:
        diffuse = [*diffuse[:3], diffuse[3] * alpha]
        look["base_color"] = plain_numbers(diffuse[:3] if diffuse[3] == 1 else diffuse)
    emissive = _color(material, "emissive", file)
    if emissive is not None and any(emissive[:3]):
        look["emission"] = plain_numbers(emissive[:3])
    if material.find("script") is not None and diffuse is None:
        name = text_of(material, "script", "name") or "script"
        file.lose("material-scripts", f"the material script `{name}` of `{place.path}`", element, place.path)
    metal = find_element(material, "pbr", "metal")
    for tag, key in (("roughness", "roughness"), ("metalness", "metallic")):
        if find_element(metal, tag) is not None:
            look[key] = plain_number(min(max(file.number(metal, tag, default=0.5), 0), 1))
    for tag, key in _TEXTURES.items():
        uri = text_of(metal, tag) or (text_of(material, "drake:diffuse_map") if tag == "albedo_map" else "")
        found = find_file(uri, file) if uri else ""
        if uri and isinstance(found, str):
            file.lose("missing-files", f"a texture: {found}", element, place.path)
        elif not isinstance(found, str) and found.suffix.lower() not in IMAGE_SUFFIXES:
            file.lose("missing-files", f"the texture {found.name} has an unsupported format", element, place.path)
        elif not isinstance(found, str):
            look[key] = Asset(found.name, found)
    return look


def _color(material: SourceElement, tag: str, file: SdfFile) -> list[float] | None:
    element = material.find(tag)
    if element is None or not element.text:
        return None
    numbers = file.numbers(element, 3 if len(element.text.split()) == 3 else 4)
    return None if numbers is None else [min(max(each, 0.0), 1.0) for each in (*numbers, 1.0)[:4]]


def _geometry(element: SourceElement, place: LinkPlace, *, collides: bool) -> Shape | None:
    """Returns the geometry and pose of a <visual> or <collision>; None if unsupported (a loss)."""
    geometry = element.find("geometry")
    form = None if geometry is None else next((each for each in geometry.children if each.tag in _FORMS), None)
    pose = place.local(element)
    if form is None:
        if geometry is not None and geometry.find("empty") is None:
            _lose_shape(element, place, collides, "has no supported geometry")
        return None
    made = _FORMS[form.tag](_Request(form, place, pose, collides))
    if isinstance(made, str):
        _lose_shape(element, place, collides, made)
        return None
    shape_pose = made.pop("pose", pose)
    return {**made, **pose_key(shape_pose)}


def _lose_shape(element: SourceElement, place: LinkPlace, collides: bool, why: str) -> None:  # noqa: FBT001
    kind, what = ("colliders", "collision") if collides else ("visuals", "visual")
    name = element.attributes.get("name", "")
    place.scope.file.lose(kind, f"the {what} `{name}` of `{place.path}` {why}", element, place.path)


@dataclass(frozen=True, slots=True)
class _Request:
    form: SourceElement
    place: LinkPlace
    pose: Pose7
    collides: bool

    @property
    def file(self) -> SdfFile:
        return self.place.scope.file

    def size(self, tag: str, default: float = 1.0) -> float:
        return self.file.positive(self.form, tag, default=default)


def _box(asked: _Request) -> Shape | str:
    size = asked.file.vector(asked.form, "size", default=(1, 1, 1))
    if min(size) < SMALLEST:
        return f"has size {' '.join(f'{each:g}' for each in size)}"
    return {"type": "box", "half_size": plain_numbers([each / 2 for each in size])}


def _sphere(asked: _Request) -> Shape | str:
    return {"type": "sphere", "radius": plain_number(asked.size("radius"))}


def _round(kind: str) -> Callable[[_Request], Shape | str]:
    def read(asked: _Request) -> Shape | str:
        radius, length = asked.size("radius", 0.5), asked.size("length")
        return {"type": kind, "radius": plain_number(radius), "half_length": plain_number(length / 2), "axis": "z"}

    return read


def _plane(asked: _Request) -> Shape | str:
    normal = asked.file.vector(asked.form, "normal", default=(0, 0, 1))
    if math.hypot(*normal) < SMALLEST:
        return "has a zero normal"
    made: Shape = {"type": "plane"} if normal == (0, 0, 1) else {"type": "plane", "normal": plain_numbers(normal)}
    if asked.collides:
        return "is a plane on a moving body" if asked.place.moves else made
    size = asked.file.numbers(asked.form.find("size"), 2) or (1.0, 1.0)
    if min(size) < SMALLEST:
        return "is a plane without a size"
    return {**made, "half_size": plain_numbers([size[0] / 2, size[1] / 2])}


def _ellipsoid(asked: _Request) -> Shape | str:
    radii = asked.file.vector(asked.form, "radii", default=(1, 1, 1))
    if min(radii) < SMALLEST:
        return "has a radius that is not positive"
    if asked.collides:
        asked.file.lose("ellipsoids", f"an ellipsoid of `{asked.place.path}` collides as a hull", asked.form)
    made = Asset("ellipsoid.obj", ellipsoid_obj())
    kind = "convex_mesh" if asked.collides else "mesh"
    return {"type": kind, "file": made, "scale": plain_numbers(radii)}


def _polyline(asked: _Request) -> Shape | str:
    points = [asked.file.numbers(each, 2) for each in asked.form.all("point")]
    height = asked.size("height")
    corners = [(each[0], each[1]) for each in points if each is not None]
    try:
        data = polyline_obj(corners, height)
    except MeshError as error:
        return f"is a polyline that {error}"
    return _mesh_shape(asked, Asset("polyline.obj", data), [1.0, 1.0, 1.0], is_convex=False)


def _heightmap(asked: _Request) -> Shape | str:
    uri = text_of(asked.form, "uri")
    found = find_file(uri, asked.file)
    if isinstance(found, str):
        return f"is a heightmap, and {found}"
    if found.suffix.lower() != ".png":
        return "is a heightmap, but not a PNG"
    if asked.place.moves:
        return "is a heightmap on a moving body"
    try:
        check_terrain_file(found, asked.file.context)
    except MeshError as error:
        return f"is a heightmap: {error}"
    size = asked.file.vector(asked.form, "size", default=(1, 1, 1))
    if min(size) < SMALLEST:
        return "is a heightmap without a size"
    x, y, z = asked.file.vector(asked.form, "pos", default=(0, 0, 0))
    pose = compose(asked.pose, (x, y, z, 1.0, 0.0, 0.0, 0.0))
    return {"type": "heightfield", "file": Asset(found.name, found), "size": plain_numbers(size), "pose": pose}


def _mesh(asked: _Request) -> Shape | str:
    uri = text_of(asked.form, "uri") or text_of(asked.form, "filename")
    found = find_file(uri, asked.file)
    if isinstance(found, str):
        return f"is a mesh, and {found}"
    scale = [*asked.file.vector(asked.form, "scale", default=(1, 1, 1))]
    if found.suffix.lower() not in MESH_SUFFIXES:
        return f"is a mesh of unsupported format ({found.suffix or 'no suffix'})"
    if min(map(abs, scale)) < SMALLEST:
        return "is a mesh with scale 0"
    try:
        asset, scale = _asset(found, scale, asked)
    except MeshError as error:
        return f"is a mesh: {error}"
    is_convex = asked.form.find("drake:declare_convex") is not None
    return _mesh_shape(asked, asset, scale, is_convex=is_convex)


def _asset(path: Path, scale: list[float], asked: _Request) -> tuple[Asset, list[float]]:
    """Returns a mesh's file and scale: the original, or an OBJ if a scene cannot use the original.

    Raises:
        MeshError: it cannot be read.
    """
    file = asked.file
    mesh = load_mesh(path, file.context)
    submesh = text_of(asked.form, "submesh", "name")
    is_mirrored = asked.collides and min(scale) < 0
    if not (submesh or mesh.missing or is_mirrored or (asked.collides and path.suffix.lower() == ".dae")):
        return Asset(path.name, path), scale
    center = file.flag(asked.form, "submesh", "center", default=False)
    baked = scale if is_mirrored else [1.0, 1.0, 1.0]
    data = mesh_as_obj(mesh, submesh=submesh, scale=baked, center=center)
    if not asked.collides:
        why = f"it names `{mesh.missing[0][:80]}`, which is missing" if mesh.missing else f"part `{submesh[:80]}`"
        file.lose("mesh-looks", f"the materials of {path.name}: {why}", asked.form)
    name = f"{path.stem}{'_' + submesh if submesh else ''}.obj"
    return Asset(name, data), [1.0, 1.0, 1.0] if is_mirrored else scale


def _mesh_shape(asked: _Request, asset: Asset, scale: list[float], *, is_convex: bool) -> Shape:
    made: Shape = {"type": "mesh", "file": asset}
    if scale != [1.0, 1.0, 1.0]:
        made["scale"] = plain_numbers(scale)
    if not asked.collides:
        return made
    optimization = asked.form.attributes.get("optimization", "")
    if optimization == "convex_decomposition":
        return {**made, "type": "convex_parts", "decomposition": "coacd"}
    if not (asked.place.moves or is_convex or optimization == "convex_hull"):
        return {**made, "type": "triangle_mesh"}
    if not is_convex and optimization != "convex_hull":
        asked.file.lose("hulls", f"a mesh of `{asked.place.path}` collides as its convex hull", asked.form)
    return {**made, "type": "convex_mesh"}


_FORMS: Final[dict[str, Callable[[_Request], Shape | str]]] = {
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
