"""The MuJoCo model under construction: sections, names, files, and geoms with their materials.

Collision geoms are in group 3, visual geoms in group 0.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.colors import linear_to_srgb
from scenecc.emit.output import Z_TO_X, AssetFolder, UnsupportedFeatures, XmlElement, optional_fields
from scenecc.geometry.obj import encode_obj
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose
from scenecc.meshes.builder import MeshBuilder, bake_scale
from scenecc.meshes.surface import MeshShape, SurfaceMaterial, encode_png
from scenecc.names import UniqueNames
from scenecc.plan import CollisionShape, Heightfield, VisualPlane
from scenecc.plan.geometry import LYING_SOLIDS, SOLIDS, Solid
from scenecc.plan.schema import type_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.meshes import Image
    from scenecc.plan import BodyStructure, ScenePlan, VisualGeometry
    from scenecc.plan.body import Mount
    from scenecc.plan.snapshot import MeasuredBody, MeasuredMesh, MeasuredScene, MeasuredShape

SECTIONS = ("asset", "worldbody", "contact", "equality", "tendon", "actuator", "keyframe")


@dataclass(frozen=True, slots=True)
class ModelBody:
    """A body of the model.

    Attributes:
        name: in the model.
        element: its element.
        pose: initial pose in the world.
        measured: its snapshot.
        is_fixed: whether it never moves: it is static or kinematic, or fixed to such a body.
    """

    name: str
    element: XmlElement
    pose: Pose7
    measured: MeasuredBody
    is_fixed: bool


@dataclass(frozen=True, slots=True)
class InitialState:
    """Initial state of a joint.

    Attributes:
        qpos, qvel: its entries of MuJoCo's `qpos` and `qvel`.
    """

    qpos: tuple[float, ...]
    qvel: tuple[float, ...]


@dataclass(slots=True)
class MjcfModel:
    """One scene, while it is written.

    Attributes:
        sections: elements of the root, by their tags.
        bodies: entities and links, by (entity, link or None), in the order of the plan.
        joints: names of joints in the model, by (entity, joint's name).
        starts: initial states, by the `id` of the joint's element.
        controls: of each actuator, in order.
        is_commanded: whether an actuator moves its joint away from its initial position.
        looks, textures: names of materials, and of textures by the digests of their images.
        meshes: names of meshes.
    """

    plan: ScenePlan
    scene: MeasuredScene
    mesh_builder: MeshBuilder
    assets: AssetFolder
    unsupported: UnsupportedFeatures
    root: XmlElement
    sections: dict[str, XmlElement] = field(init=False)
    bodies: dict[tuple[str, str | None], ModelBody] = field(default_factory=dict[tuple[str, "str | None"], ModelBody])
    joints: dict[tuple[str, str], str] = field(default_factory=dict[tuple[str, str], str])
    starts: dict[int, InitialState] = field(default_factory=dict[int, InitialState])
    controls: list[float] = field(default_factory=list[float])
    is_commanded: bool = False
    looks: dict[SurfaceMaterial, str] = field(default_factory=dict["SurfaceMaterial", str])
    textures: dict[str, str] = field(default_factory=dict[str, str])
    meshes: set[str] = field(default_factory=set[str])
    _names: dict[str, UniqueNames] = field(default_factory=dict[str, UniqueNames])

    def __post_init__(self) -> None:
        self.sections = {tag: XmlElement(tag) for tag in SECTIONS}

    @property
    def world(self) -> XmlElement:
        """The world body."""
        return self.sections["worldbody"]

    def name(self, kind: str, wish: str) -> str:
        """Returns a unique name of a kind ("world" is reserved)."""
        if kind not in self._names:
            self._names[kind] = UniqueNames("world")
        return self._names[kind].new(wish)

    def key(self, mount: Mount) -> tuple[str, str | None]:
        """Returns the key of a mount in `bodies`; for an articulation without a link, that of its root."""
        key = (mount.entity, mount.link)
        return key if key in self.bodies else next(each for each in self.bodies if each[0] == mount.entity)

    def head(self, tag: str) -> XmlElement:
        """Returns a section before all bodies, created on first use."""
        for each in self.root.children:
            if each.tag == tag:
                return each
        return self.root.add(tag)


_UNSUPPORTED_IMAGES: Final = (
    "normal_image",
    "roughness_image",
    "metallic_image",
    "emission_image",
    "transmission_image",
)


def write_material(model: MjcfModel, look: SurfaceMaterial, shape: MeshShape, name: str) -> str:
    """Returns the name of a material's element; equal materials share one. `name`: of the first entity with it."""
    if look not in model.looks:
        _report_material(model, look, shape, name)
        emission = _emission(model, look, shape, name)
        image = look.base_color_image
        model.looks[look] = model.name("material", f"{name}_material")
        model.sections["asset"].add(
            "material",
            name=model.looks[look],
            texture=None if image is None else _texture(model, image),
            rgba=(*map(linear_to_srgb, look.tint[:3]), look.tint[3]),  # MuJoCo shows them as they are
            emission=emission or None,
            specular=look.specular,
            shininess=1 - look.roughness,
            metallic=look.metallic,
            roughness=look.roughness,
        )
    return model.looks[look]


def _emission(model: MjcfModel, look: SurfaceMaterial, shape: MeshShape, name: str) -> float:
    """Returns the emission relative to the material's colour, because MuJoCo has a single number."""
    strongest, brightest = max(look.emission), max(look.tint[:3])
    if strongest == 0:
        return 0.0
    if brightest == 0:
        model.unsupported.leave_out(name, "`emission` of a black material", shape.origin)
        return 0.0
    strength = strongest / brightest
    if any(abs(strength * own - shines) > 1e-6 for own, shines in zip(look.tint, look.emission, strict=False)):
        model.unsupported.change(name, "`emission` has the colour of the material, as in MuJoCo", shape.origin)
    return strength


def _report_material(model: MjcfModel, look: SurfaceMaterial, shape: MeshShape, name: str) -> None:
    for image in _UNSUPPORTED_IMAGES:
        if getattr(look, image) is not None:
            model.unsupported.leave_out(name, f"`{image.replace('_image', '_texture')}`", shape.origin)
    if look.transmission:
        model.unsupported.leave_out(name, "`transmission`", shape.origin)


def _texture(model: MjcfModel, image: Image) -> str:
    """Returns the name of an image's texture element. The file is a PNG, which MuJoCo can read."""
    if image.digest not in model.textures:
        data = image.data if image.suffix == ".png" else encode_png(image.pixels)
        file = model.assets.add(image.name or "texture", ".png", data)
        name = model.textures[image.digest] = model.name("texture", file.removesuffix(".png"))
        model.sections["asset"].add("texture", name=name, type="2d", file=file)
    return model.textures[image.digest]


COLLISION_GROUP, VISUAL_GROUP = 3, 0

_GRID_SPACING = 1.0
"""Spacing of the grid lines of a plane [m]."""

_UNSUPPORTED_SHAPE_FIELDS = optional_fields(CollisionShape, "pose", "material", "density", "collision_groups")


def write_collision_geoms(model: MjcfModel, name: str, body: MeasuredBody, element: XmlElement) -> None:
    """Writes one massless geom per collision shape of the engine."""
    for shape in body.shapes:
        if shape.mesh is not None and not isinstance(shape.shape.geometry, Heightfield) and _is_flat(shape.mesh):
            words = "a flat collision mesh: MuJoCo needs a hull with a volume"
            model.unsupported.leave_out(name, words, shape.shape.origin)
            continue
        pose, attributes = _collision_geom(model, name, shape)
        bits, mask, _, _ = map(_to_int32, shape.groups)
        element.add(
            "geom",
            name=model.name("geom", f"{element.attributes['name']}/collision"),
            **attributes,
            **pose_attributes(pose),
            contype=None if bits == 1 else bits,
            conaffinity=None if mask == 1 else mask,
            friction=(shape.dynamic_friction,),
            group=COLLISION_GROUP,
        )
        _report_shape(model, name, shape)


def _is_flat(mesh: MeasuredMesh) -> bool:
    """Returns whether the vertices of a mesh lie in one plane."""
    vertices = np.asarray(mesh.vertices, np.float64)
    extents = np.linalg.svd(vertices - vertices.mean(axis=0), compute_uv=False)
    return bool(extents[-1] <= 1e-7 * extents[0])


def _collision_geom(model: MjcfModel, name: str, shape: MeasuredShape) -> tuple[Pose7, dict[str, Any]]:
    """Returns pose and geometry attributes of a geom."""
    upright = compose(shape.pose, Z_TO_X)
    if shape.kind == "plane":
        return upright, {"type": "plane", "size": (0, 0, _GRID_SPACING)}
    if shape.mesh is None:
        return upright if shape.kind in LYING_SOLIDS else shape.pose, {"type": shape.kind, "size": shape.sizes}
    if isinstance(shape.shape.geometry, Heightfield):
        return _height_field(model, name, shape.pose, shape.shape.geometry, shape.mesh)
    if shape.kind == "triangle_mesh":
        words = "a triangle mesh collides as its convex hull, like all meshes in MuJoCo"
        model.unsupported.change(name, words, shape.shape.origin)
    cooked = _mesh_asset(model, f"{name}_collision", encode_obj(shape.mesh.vertices, shape.mesh.triangles))
    return shape.pose, {"type": "mesh", "mesh": cooked}


_BASE_THICKNESS = 0.1
"""Thickness of the ground below a height field [m]: MuJoCo's are solid, SAPIEN's are surfaces."""


def _height_field(
    model: MjcfModel, name: str, pose: Pose7, terrain: Heightfield, mesh: MeasuredMesh
) -> tuple[Pose7, dict[str, Any]]:
    """Returns pose and geometry attributes of terrain. MuJoCo scales the elevations to 0 to 1."""
    low, high = np.min(mesh.vertices, axis=0), np.max(mesh.vertices, axis=0)
    x, y, z = ((high - low) / (2, 2, 1)).tolist()
    asset = model.name("hfield", f"{name}_terrain")
    model.sections["asset"].add(
        "hfield",
        name=asset,
        nrow=len(terrain.heights),
        ncol=len(terrain.heights[0]),
        # MuJoCo requires a height, even for flat terrain.
        size=(x, y, z or _BASE_THICKNESS, _BASE_THICKNESS),
        elevation=tuple(height for row in terrain.heights for height in row),
    )
    return compose(pose, (0.0, 0.0, float(low[2]), *IDENTITY_POSE[3:])), {"type": "hfield", "hfield": asset}


def _report_shape(model: MjcfModel, name: str, shape: MeasuredShape) -> None:
    plan, unsupported = shape.shape, model.unsupported
    unsupported.fields(name, plan, _UNSUPPORTED_SHAPE_FIELDS, plan.origin, " of a shape")
    if plan.material is None:
        return
    if shape.static_friction != shape.dynamic_friction:
        words = "`static_friction` is replaced by `dynamic_friction`: MuJoCo has one coefficient"
        unsupported.change(name, words, plan.origin)
    if shape.restitution:
        unsupported.leave_out(name, "`restitution` of a shape", plan.origin)


def write_visual_geoms(
    model: MjcfModel, name: str, row: int, body: BodyStructure, element: XmlElement, *, is_fixed: bool
) -> None:
    """Writes geoms for the visual shapes of a body. `is_fixed`: whether it never moves. Raises AssetError."""
    for shape, plan in zip(model.mesh_builder.visuals(body, row), body.visuals, strict=False):
        parts = bake_scale(shape)
        native = None if parts[0].look.base_color_image else _primitive_geom(plan.geometry, row, is_fixed=is_fixed)
        pose = shape.pose if native is None else compose(shape.pose, native[0])
        for part in parts if native is None else parts[:1]:
            if native is None:
                asset = _mesh_asset(model, shape.name or name, part.to_obj())
                attributes: dict[str, Any] = {"type": "mesh", "mesh": asset}
            else:
                attributes = native[1]
            element.add(
                "geom",
                name=model.name("geom", shape.name) if shape.name else None,
                **attributes,
                **pose_attributes(pose),
                contype=0,
                conaffinity=0,
                group=VISUAL_GROUP,
                material=write_material(model, part.look, shape, name),
            )


def _primitive_geom(geometry: VisualGeometry, row: int, *, is_fixed: bool) -> tuple[Pose7, dict[str, Any]] | None:
    """Returns relative pose and attributes of a visual shape as a primitive geom, or None if it needs a mesh."""
    match geometry:
        case Solid() if (kind := type_name(type(geometry))) in SOLIDS:
            return Z_TO_X if kind in LYING_SOLIDS else IDENTITY_POSE, {"type": kind, "size": geometry.sizes(row)}
        case VisualPlane(half_size=size) if is_fixed:  # MuJoCo only allows planes on fixed bodies
            return Z_TO_X, {"type": "plane", "size": (*size.row(row), _GRID_SPACING)}
        case _:
            return None


def _mesh_asset(model: MjcfModel, stem: str, data: bytes) -> str:
    """Returns the name of a mesh file's asset; equal files share one. Its inertia is unused."""
    file = model.assets.add(stem, ".obj", data)
    name = file.removesuffix(".obj")
    if name not in model.meshes:
        model.meshes.add(name)
        model.sections["asset"].add("mesh", name=name, file=file, inertia="shell")
    return name


def pose_attributes(pose: Pose7) -> dict[str, Sequence[float] | None]:
    """Returns `pos` and `quat` of a pose, or None for each that is the identity."""
    return {
        "pos": None if pose[:3] == IDENTITY_POSE[:3] else pose[:3],
        "quat": None if pose[3:] == IDENTITY_POSE[3:] else pose[3:],
    }


def _to_int32(bits: int) -> int:
    """Returns 32 bits as a signed integer, as MuJoCo reads them."""
    return bits - (1 << 32) if bits >= 1 << 31 else bits
