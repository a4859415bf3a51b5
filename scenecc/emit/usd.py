"""Exports one measured scene to USD: visual geometry, and bodies, colliders and joints of UsdPhysics."""

from __future__ import annotations

import math
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.emit.output import PHYSX_SETTINGS, AssetFolder, UnsupportedFeatures, optional_fields, pose_in_row
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.interrupt import temporary_folder
from scenecc.meshes.builder import MeshBuilder, bake_scale
from scenecc.names import UniqueNames
from scenecc.plan import (
    ArticulationStructure,
    AxisLimit,
    BodyStructure,
    CollisionShape,
    Connection,
    Distance,
    Drive,
    Weld,
)
from scenecc.plan.articulation import VELOCITY_FIELDS
from scenecc.plan.properties import property_fields

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.emit import ExportOptions, Show
    from scenecc.meshes import Image
    from scenecc.meshes.surface import MeshShape, SurfaceMaterial
    from scenecc.plan import Constraint, ScenePlan, Value
    from scenecc.plan.snapshot import (
        EngineSnapshot,
        MeasuredBody,
        MeasuredEntity,
        MeasuredJoint,
        MeasuredMesh,
        MeasuredScene,
        MeasuredShape,
    )

Prim = Any
"""An object of usd-core, which is loaded lazily and has no type hints."""


class Stage:
    """A USD stage and the modules of usd-core.

    Attributes:
        stage: in metres and kilograms, z up.
        root: path of the root prim.
        unsupported: receives the features that USD does not support.
        assets: images.
    """

    def __init__(self, name: str, unsupported: UnsupportedFeatures) -> None:
        """Makes an empty stage. `name`: of the file, without its suffix."""
        self.usd: Any = import_module("pxr.Usd")
        self.geom: Any = import_module("pxr.UsdGeom")
        self.physics: Any = import_module("pxr.UsdPhysics")
        self.shade: Any = import_module("pxr.UsdShade")
        self.gf: Any = import_module("pxr.Gf")
        self.sdf: Any = import_module("pxr.Sdf")
        self.tf: Any = import_module("pxr.Tf")
        self.vt: Any = import_module("pxr.Vt")
        self.stage: Any = self.usd.Stage.CreateInMemory()
        self.unsupported = unsupported
        self.assets = AssetFolder(name)
        self.root = "/World"
        self._paths = UniqueNames()
        self.geom.SetStageUpAxis(self.stage, self.geom.Tokens.z)
        self.geom.SetStageMetersPerUnit(self.stage, 1.0)
        self.physics.SetStageKilogramsPerUnit(self.stage, 1.0)
        self.stage.SetDefaultPrim(self.geom.Xform.Define(self.stage, self.root).GetPrim())

    def path(self, above: str, name: str) -> str:
        """Returns a unique path below another. USD requires names to be identifiers."""
        return self._paths.new(f"{above}/{self.tf.MakeValidIdentifier(name)}")

    def xform(self, above: str, name: str, pose: tuple[float, ...] | None = None) -> Prim:
        """Adds an Xform with the scene's name as display name. `pose`: p then q (wxyz); None: the identity."""
        made = self.geom.Xform.Define(self.stage, self.path(above, name))
        made.GetPrim().SetDisplayName(name)
        if pose is not None:
            self.place(made, pose)
        return made

    def place(self, made: Prim, pose: tuple[float, ...], scale: tuple[float, ...] | None = None) -> None:
        """Sets pose, p [m] then q (wxyz), and scale of a prim."""
        made.AddTranslateOp(self.geom.XformOp.PrecisionDouble).Set(self.gf.Vec3d(*pose[:3]))
        made.AddOrientOp(self.geom.XformOp.PrecisionDouble).Set(self.gf.Quatd(*pose[3:]))
        if scale is not None:
            made.AddScaleOp(self.geom.XformOp.PrecisionDouble).Set(self.gf.Vec3d(*scale))

    def vec3(self, numbers: tuple[float, ...]) -> Any:
        """Converts three numbers."""
        return self.gf.Vec3f(*map(float, numbers))

    def quat(self, pose: tuple[float, ...]) -> Any:
        """Converts the rotation of a pose."""
        return self.gf.Quatf(*map(float, pose[3:]))

    def vec3s(self, rows: ArrayLike) -> Any:
        """Converts (n, 3) numbers."""
        return self.vt.Vec3fArray.FromNumpy(np.ascontiguousarray(rows, dtype=np.float32))

    def vec2s(self, rows: ArrayLike) -> Any:
        """Converts (n, 2) numbers."""
        return self.vt.Vec2fArray.FromNumpy(np.ascontiguousarray(rows, dtype=np.float32))

    def ints(self, numbers: ArrayLike) -> Any:
        """Converts (n,) integers."""
        return self.vt.IntArray.FromNumpy(np.ascontiguousarray(numbers, dtype=np.int32).ravel())


_WRAPS: Final = {"repeat": "repeat", "edge": "clamp", "mirror": "mirror", "border": "black"}


class UsdMaterialWriter:
    """The materials of a stage, each written once."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._made: dict[SurfaceMaterial, Prim] = {}
        self._frictions: dict[tuple[float, float, float], Prim] = {}
        self._scope: str | None = None

    def bind(self, made: Prim, look: SurfaceMaterial, entity: str, place: Origin | None) -> None:
        """Binds a material to a prim. `entity`, `place`: location for reports of unsupported features."""
        stage = self._stage
        if look not in self._made:
            self._made[look] = self._material(look)
            self._report_unsupported(look, entity, place)
        stage.shade.MaterialBindingAPI.Apply(made.GetPrim()).Bind(self._made[look])

    def bind_friction(self, made: Prim, shape: MeasuredShape) -> None:
        """Binds a physics material, friction and restitution, to a collider."""
        stage = self._stage
        key = (shape.static_friction, shape.dynamic_friction, shape.restitution)
        if key not in self._frictions:
            material = stage.shade.Material.Define(stage.stage, stage.path(self._folder(), "friction"))
            physics = stage.physics.MaterialAPI.Apply(material.GetPrim())
            physics.CreateStaticFrictionAttr(shape.static_friction)
            physics.CreateDynamicFrictionAttr(shape.dynamic_friction)
            physics.CreateRestitutionAttr(shape.restitution)
            self._frictions[key] = material
        binding = stage.shade.MaterialBindingAPI.Apply(made.GetPrim())
        binding.Bind(self._frictions[key], stage.shade.Tokens.fallbackStrength, "physics")

    def _folder(self) -> str:
        if self._scope is None:
            self._scope = self._stage.path(self._stage.root, "Looks")
            self._stage.geom.Scope.Define(self._stage.stage, self._scope)
        return self._scope

    def _material(self, look: SurfaceMaterial) -> Prim:
        stage = self._stage
        path = stage.path(self._folder(), "material")
        material = stage.shade.Material.Define(stage.stage, path)
        shader = stage.shade.Shader.Define(stage.stage, f"{path}/surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        types = stage.sdf.ValueTypeNames
        red, green, blue, alpha = look.tint
        # UsdPreviewSurface derives the reflectance at normal incidence from `ior`, SAPIEN from `specular`.
        root = math.sqrt(0.08 * look.specular)
        inputs: dict[str, tuple[Any, Any]] = {
            "diffuseColor": (types.Color3f, stage.gf.Vec3f(red, green, blue)),
            "opacity": (types.Float, alpha),
            "emissiveColor": (types.Color3f, stage.gf.Vec3f(*look.emission)),
            "roughness": (types.Float, look.roughness),
            "metallic": (types.Float, look.metallic),
            "ior": (types.Float, (1 + root) / (1 - root)),
            "useSpecularWorkflow": (types.Int, 0),
        }
        for name, (kind, value) in inputs.items():
            shader.CreateInput(name, kind).Set(value)
        self._images(look, path, shader)
        output = shader.CreateOutput("surface", types.Token)
        material.CreateSurfaceOutput().ConnectToSource(output)
        return material

    def _images(self, look: SurfaceMaterial, path: str, shader: Prim) -> None:
        types = self._stage.sdf.ValueTypeNames
        color = look.base_color_image
        if color is not None:
            found = self._texture(path, "base_color", color)
            self._connect(shader, "diffuseColor", types.Color3f, found, "rgb")
            if color.pixels.mode in {"RGBA", "LA", "PA"}:
                if look.visibility < 1:
                    found.CreateInput("scale", types.Float4).Set(self._stage.gf.Vec4f(1, 1, 1, look.visibility))
                self._connect(shader, "opacity", types.Float, found, "a")
        if look.emission_image is not None:
            found = self._texture(path, "emission", look.emission_image)
            found.CreateInput("scale", types.Float4).Set(self._stage.gf.Vec4f(*look.emission, 1))
            self._connect(shader, "emissiveColor", types.Color3f, found, "rgb")
        if look.normal_image is not None:
            found = self._texture(path, "normal", look.normal_image)
            found.CreateInput("scale", types.Float4).Set(self._stage.gf.Vec4f(2, 2, 2, 1))
            found.CreateInput("bias", types.Float4).Set(self._stage.gf.Vec4f(-1, -1, -1, 0))
            self._connect(shader, "normal", types.Normal3f, found, "rgb")
        for name, image in (("roughness", look.roughness_image), ("metallic", look.metallic_image)):
            if image is not None:
                self._connect(shader, name, types.Float, self._texture(path, name, image), image.channel)

    def _texture(self, path: str, name: str, image: Image) -> Prim:
        stage = self._stage
        types = stage.sdf.ValueTypeNames
        file = stage.assets.add(stage.tf.MakeValidIdentifier(image.name), image.suffix, image.data)
        reader = stage.shade.Shader.Define(stage.stage, f"{path}/st")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", types.String).Set("st")
        texture = stage.shade.Shader.Define(stage.stage, f"{path}/{name}")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", types.Asset).Set(stage.sdf.AssetPath(f"./{stage.assets.folder}/{file}"))
        texture.CreateInput("sourceColorSpace", types.Token).Set("sRGB" if image.srgb else "raw")
        for wrap in ("wrapS", "wrapT"):
            texture.CreateInput(wrap, types.Token).Set(_WRAPS[image.address_mode])
        texture.CreateInput("st", types.Float2).ConnectToSource(reader.CreateOutput("result", types.Float2))
        return texture

    def _connect(self, shader: Prim, name: str, kind: Any, texture: Prim, channel: str) -> None:
        types = self._stage.sdf.ValueTypeNames
        output = texture.CreateOutput(channel, types.Float3 if channel == "rgb" else types.Float)
        shader.CreateInput(name, kind).ConnectToSource(output)

    def _report_unsupported(self, look: SurfaceMaterial, entity: str, place: Origin | None) -> None:
        images = (look.base_color_image, look.normal_image, look.roughness_image, look.metallic_image)
        images = (*images, look.emission_image)
        if any(image is not None and image.filter_mode == "nearest" for image in images):
            self._stage.unsupported.leave_out(entity, "`filter_mode: nearest` of a texture", place)
        if look.transmission > 0 or look.transmission_image is not None:
            self._stage.unsupported.leave_out(entity, "`transmission` of a material", place)


UNSUPPORTED_BODY_FIELDS: Final = optional_fields(
    BodyStructure, "mass", "com", "inertial", "visibility", *VELOCITY_FIELDS, "shading_mode", "shapeless"
)
"""Fields that UsdPhysics does not support."""

_UNSUPPORTED_SHAPE_FIELDS: Final = optional_fields(CollisionShape, "pose", "material", "density")


class UsdBodyWriter:
    """Writes bodies: mass, visual geometry and colliders."""

    def __init__(self, stage: Stage, mesh_builder: MeshBuilder, looks: UsdMaterialWriter, show: Show) -> None:
        self._stage = stage
        self._mesh_builder = mesh_builder
        self._looks = looks
        self._show = show

    def write(self, made: Prim, entity: MeasuredEntity, body: MeasuredBody) -> None:
        """Writes a body into its Xform: mass, visual geometry, colliders.

        Raises:
            AssetError: a mesh file cannot be written.
        """
        stage = self._stage
        prim = made.GetPrim()
        if body.mass is not None:
            rigid = stage.physics.RigidBodyAPI.Apply(prim)
            if body.body_type == "kinematic":
                rigid.CreateKinematicEnabledAttr(defaultValue=True)
            self._write_velocities(rigid, entity, body)
            self._write_mass(prim, body)
        path = str(prim.GetPath())
        if self._show == "visual":
            for shape in self._mesh_builder.visuals(body.body, entity.row):
                self._write_visual(path, shape, entity.entity.name)
        for shape in body.shapes:
            self._write_collision(path, shape, body, entity)
        place = body.body.origin or entity.structure.origin
        stage.unsupported.fields(entity.entity.name, body.body, UNSUPPORTED_BODY_FIELDS, place)
        if body.body.shading_mode is not None and self._show == "collision":
            stage.unsupported.fields(entity.entity.name, body.body, ("shading_mode",), place)

    def _write_velocities(self, rigid: Prim, entity: MeasuredEntity, body: MeasuredBody) -> None:
        """Writes initial velocities. USD's angular velocities are in degrees per second."""
        linear, angular = body.body.linear_velocity, body.body.angular_velocity
        if linear is not None:
            rigid.CreateVelocityAttr(self._stage.vec3(tuple(linear.row(entity.row))))
        if angular is not None:
            rigid.CreateAngularVelocityAttr(self._stage.vec3(tuple(map(math.degrees, angular.row(entity.row)))))

    def _write_mass(self, prim: Prim, body: MeasuredBody) -> None:
        mass = body.mass
        assert mass is not None  # every body that moves has one
        api = self._stage.physics.MassAPI.Apply(prim)
        api.CreateMassAttr(mass.mass)
        api.CreateCenterOfMassAttr(self._stage.vec3(mass.com[:3]))
        api.CreateDiagonalInertiaAttr(self._stage.vec3(mass.inertia))
        api.CreatePrincipalAxesAttr(self._stage.quat(mass.com))

    def _write_visual(self, above: str, shape: MeshShape, entity: str) -> None:
        stage = self._stage
        for part in bake_scale(shape):
            mesh = self._mesh(stage.path(above, shape.name or shape.kind), part.vertices, part.faces)
            stage.place(mesh, shape.pose)
            if part.normals is not None:
                mesh.CreateNormalsAttr(stage.vec3s(part.normals))
                mesh.SetNormalsInterpolation(stage.geom.Tokens.vertex)
            uvs = np.zeros((len(part.vertices), 2)) if part.uvs is None else part.uvs
            kind = stage.sdf.ValueTypeNames.TexCoord2fArray
            st = stage.geom.PrimvarsAPI(mesh).CreatePrimvar("st", kind, stage.geom.Tokens.vertex)
            st.Set(stage.vec2s(uvs * (1, -1) + (0, 1)))  # USD's v starts at the bottom of an image
            self._looks.bind(mesh, part.look, entity, shape.origin)

    def _mesh(self, path: str, vertices: Any, faces: Any) -> Prim:
        stage = self._stage
        mesh = stage.geom.Mesh.Define(stage.stage, path)
        mesh.CreatePointsAttr(stage.vec3s(vertices))
        mesh.CreateFaceVertexCountsAttr(stage.ints(np.full(len(faces), 3)))
        mesh.CreateFaceVertexIndicesAttr(stage.ints(faces))
        mesh.CreateSubdivisionSchemeAttr(stage.geom.Tokens.none)
        mesh.CreateExtentAttr(stage.vec3s([vertices.min(axis=0), vertices.max(axis=0)]))
        return mesh

    def _write_collision(self, above: str, shape: MeasuredShape, body: MeasuredBody, entity: MeasuredEntity) -> None:
        stage = self._stage
        path = stage.path(above, f"{shape.kind}_collision")
        made, scale = self._collider(path, shape)
        stage.place(made, shape.pose, scale)
        stage.physics.CollisionAPI.Apply(made.GetPrim())
        self._looks.bind_friction(made, shape)
        if self._show == "visual":
            made.CreatePurposeAttr(stage.geom.Tokens.guide)
        else:
            (drawn,) = self._mesh_builder.collision(shape, body).parts
            self._looks.bind(made, drawn.look, entity.entity.name, shape.shape.origin)
        stage.unsupported.fields(
            entity.entity.name, shape.shape, _UNSUPPORTED_SHAPE_FIELDS, shape.shape.origin, " of a shape"
        )

    def _collider(self, path: str, shape: MeasuredShape) -> tuple[Prim, tuple[float, ...] | None]:
        """Returns a collider prim and its scale, if any. As in SAPIEN, solids lie along x, as does a plane's normal."""
        stage, geom = self._stage, self._stage.geom
        match shape.kind, shape.sizes:
            case "box", sizes:
                made = geom.Cube.Define(stage.stage, path)
                made.CreateSizeAttr(2.0)
                return made, sizes
            case "sphere", (radius,):
                made = geom.Sphere.Define(stage.stage, path)
                made.CreateRadiusAttr(radius)
                return made, None
            case "capsule" | "cylinder", (radius, half_length):
                made = (geom.Capsule if shape.kind == "capsule" else geom.Cylinder).Define(stage.stage, path)
                made.CreateAxisAttr(geom.Tokens.x)
                made.CreateRadiusAttr(radius)
                made.CreateHeightAttr(2 * half_length)
                return made, None
            case "plane", _:
                made = geom.Plane.Define(stage.stage, path)
                made.CreateAxisAttr(geom.Tokens.x)
                return made, None
            case _:
                assert shape.mesh is not None  # every shape that is not a primitive has one
                return self._write_cooked(path, shape, shape.mesh), None

    def _write_cooked(self, path: str, shape: MeasuredShape, mesh: MeasuredMesh) -> Prim:
        made = self._mesh(path, mesh.vertices, mesh.triangles)
        api = self._stage.physics.MeshCollisionAPI.Apply(made.GetPrim())
        convex = shape.kind == "convex_mesh"
        api.CreateApproximationAttr(
            self._stage.physics.Tokens.convexHull if convex else self._stage.physics.Tokens.none
        )
        return made


_UNSUPPORTED_JOINT_FIELDS: Final = (*property_fields("joint"), "qvel")

_UNSUPPORTED_ARTICULATION_FIELDS: Final = optional_fields(ArticulationStructure, "file")


def write_joints(stage: Stage, entity: MeasuredEntity, above: str, links: list[str]) -> None:
    """Writes the joints of an articulation, whose prim is at `above`. `links`: paths of its links."""
    structure = entity.structure
    assert isinstance(structure, ArticulationStructure)
    name = entity.entity.name
    stage.physics.ArticulationRootAPI.Apply(stage.stage.GetPrimAtPath(above))
    if structure.fix_root_link:
        fixed = stage.physics.FixedJoint.Define(stage.stage, stage.path(above, "fix_root_link"))
        connect_bodies(stage, fixed, None, links[0], entity.bodies[0].pose, IDENTITY_POSE)
    for body, link, planned in zip(entity.bodies, links, structure.links, strict=True):
        if body.joint is not None and body.parent is not None and planned.joint is not None:
            _write_joint(stage, body, body.joint, above, (links[body.parent], link))
            of = f" of the joint `{body.joint.name}`" if body.joint.name else " of a joint"
            # A joint with a friction force has the ratio 0, which loses nothing.
            lost = [field for field in _UNSUPPORTED_JOINT_FIELDS if field != "friction" or body.joint.friction]
            stage.unsupported.fields(name, planned.joint, lost, planned.joint.origin or structure.origin, of)
    for mimic in structure.mimics:
        words = f"the mimic joint `{mimic.joint}` of `{mimic.source}`"
        stage.unsupported.leave_out(name, words, mimic.origin or structure.origin)
    stage.unsupported.fields(name, structure, _UNSUPPORTED_ARTICULATION_FIELDS, structure.origin)


def _write_joint(stage: Stage, body: MeasuredBody, joint: MeasuredJoint, above: str, between: tuple[str, str]) -> None:
    path = stage.path(above, joint.name or f"{body.name}_joint")
    physics = stage.physics
    match joint.type:
        case "fixed":
            made = physics.FixedJoint.Define(stage.stage, path)
        case "prismatic":
            made = physics.PrismaticJoint.Define(stage.stage, path)
        case _:
            made = physics.RevoluteJoint.Define(stage.stage, path)
    connect_bodies(stage, made, *between, joint.pose_in_parent, joint.pose_in_child)
    if joint.type == "fixed":
        return
    angular = joint.type != "prismatic"
    made.CreateAxisAttr(stage.geom.Tokens.x)
    _write_limits(joint.limits, made.CreateLowerLimitAttr, made.CreateUpperLimitAttr, angular=angular)
    if joint.stiffness or joint.damping:
        strength = (joint.stiffness, joint.damping, joint.force_limit)
        target = (joint.drive_target, joint.drive_velocity_target)
        _write_drive_api(stage, made, "angular" if angular else "linear", joint.drive_mode, strength, target)


def _write_limits(limits: Iterable[float], set_low: Prim, set_high: Prim, *, angular: bool) -> None:
    """Writes the limits of an axis [m, rad] with setters of USD, which uses degrees."""
    for limit, set_limit in zip(limits, (set_low, set_high), strict=True):
        if math.isfinite(limit):
            set_limit(math.degrees(limit) if angular else float(limit))


def _write_drive_api(
    stage: Stage,
    made: Prim,
    axis: str,
    mode: str,
    strength: tuple[float, float, float],
    target: tuple[float, float],
) -> None:
    """Writes the drive of an axis: stiffness, damping and force limit, and target position and velocity [m, rad]."""
    drive = stage.physics.DriveAPI.Apply(made.GetPrim(), axis)
    each = math.radians(1) if axis.startswith(("rot", "angular")) else 1.0
    stiffness, damping, force_limit = strength
    drive.CreateTypeAttr(mode)
    drive.CreateStiffnessAttr(stiffness * each)
    drive.CreateDampingAttr(damping * each)
    drive.CreateTargetPositionAttr(target[0] / each)
    drive.CreateTargetVelocityAttr(target[1] / each)
    if math.isfinite(force_limit):
        drive.CreateMaxForceAttr(force_limit)


def connect_bodies(
    stage: Stage, made: Prim, parent: str | None, child: str, in_parent: tuple[float, ...], in_child: tuple[float, ...]
) -> None:
    """Connects two bodies, given by their paths, with a joint. `parent`: None: the world. Frames: p then q (wxyz)."""
    if parent is not None:
        made.CreateBody0Rel().SetTargets([parent])
    made.CreateBody1Rel().SetTargets([child])
    made.CreateLocalPos0Attr(stage.vec3(in_parent[:3]))
    made.CreateLocalRot0Attr(stage.quat(in_parent))
    made.CreateLocalPos1Attr(stage.vec3(in_child[:3]))
    made.CreateLocalRot1Attr(stage.quat(in_child))


_DEGREES_OF_FREEDOM: Final = {
    "x": ("transX",),
    "y": ("transY",),
    "z": ("transZ",),
    "twist": ("rotX",),
    "swing": ("rotY", "rotZ"),
    "slerp": ("rotX", "rotY", "rotZ"),
}
"""Axis of a drive → USD's degrees of freedom."""

_JOINT_CLASSES: Final[dict[type, str]] = {
    Weld: "FixedJoint",
    Connection: "SphericalJoint",
    Distance: "DistanceJoint",
    Drive: "Joint",
}

_UNSUPPORTED_DRIVE_FIELDS: Final = optional_fields(Drive, "target", "linear_velocity_target", "angular_velocity_target")


def write_constraint(stage: Stage, constraint: Constraint, row: int, paths: dict[tuple[str, str | None], str]) -> None:
    """Writes a constraint. `row`: of the scene in its values; `paths`: of entities and links."""
    joint = constraint.joint
    kind = _JOINT_CLASSES.get(type(joint))
    if kind is None:
        stage.unsupported.leave_out(constraint.name, "a gear", constraint.origin)
        return
    path = stage.path(stage.root, constraint.name)
    made = getattr(stage.physics, kind).Define(stage.stage, path)
    parent = None if constraint.parent is None else paths[constraint.parent.entity, constraint.parent.link]
    in_parent, in_child = (pose_in_row(pose, row) for pose in (constraint.pose_in_parent, constraint.pose_in_child))
    connect_bodies(stage, made, parent, paths[constraint.child.entity, constraint.child.link], in_parent, in_child)
    made.CreateExcludeFromArticulationAttr(defaultValue=True)
    # PhysX prevents collisions between two constrained bodies, even if the constraint is disabled.
    made.CreateCollisionEnabledAttr(parent is None or constraint.collide)
    if constraint.enabled is not None:
        made.CreateJointEnabledAttr(bool(constraint.enabled.row(row)))
    if isinstance(joint, Distance):
        low, high = map(float, joint.limits.row(row))
        made.CreateMinDistanceAttr(low)
        if math.isfinite(high):
            made.CreateMaxDistanceAttr(high)
        stage.unsupported.fields(constraint.name, joint, optional_fields(Distance), constraint.origin)
    elif isinstance(joint, Drive):
        _write_drive(stage, made, constraint, joint, row)


def _write_drive(stage: Stage, made: Prim, constraint: Constraint, joint: Drive, row: int) -> None:
    for limit in joint.limits:
        _write_axis_limit(stage, made, limit, row)
        stage.unsupported.fields(
            constraint.name, limit, optional_fields(AxisLimit), constraint.origin, f" of the limit of {limit.axis}"
        )
    targets = _axis_targets(joint, row)
    if joint.target is not None and not np.allclose(np.abs(joint.target.row(row)[3:]), IDENTITY_POSE[3:], atol=1e-6):
        stage.unsupported.leave_out(constraint.name, "the rotation of `target`", constraint.origin)
    if joint.angular_velocity_target is not None and joint.angular_velocity_target.row(row).any():
        stage.unsupported.leave_out(constraint.name, "`angular` of `velocity_target`", constraint.origin)
    for drive in joint.drives:
        limit = math.inf if drive.force_limit is None else float(drive.force_limit.row(row))
        strength = (float(drive.stiffness.row(row)), float(drive.damping.row(row)), limit)
        for freedom in _DEGREES_OF_FREEDOM[drive.axis]:
            target = targets.get(freedom, (0.0, 0.0))
            _write_drive_api(stage, made, freedom, drive.mode or "force", strength, target)
    stage.unsupported.fields(constraint.name, joint, _UNSUPPORTED_DRIVE_FIELDS, constraint.origin)


def _write_axis_limit(stage: Stage, made: Prim, limit: AxisLimit, row: int) -> None:
    api = stage.physics.LimitAPI.Apply(made.GetPrim(), _DEGREES_OF_FREEDOM[limit.axis][0])
    _write_limits(limit.limits.row(row), api.CreateLowAttr, api.CreateHighAttr, angular=limit.axis == "twist")


def _axis_targets(joint: Drive, row: int) -> dict[str, tuple[float, float]]:
    """Returns target position and velocity along each linear axis [m, m/s]."""

    def rows(value: Value | None) -> list[float]:
        return [0.0] * 3 if value is None else [float(number) for number in value.row(row)[:3]]

    along = zip("XYZ", rows(joint.target), rows(joint.linear_velocity_target), strict=True)
    return {f"trans{axis}": (position, speed) for axis, position, speed in along}


_UNSUPPORTED_PHYSICS_FIELDS: Final = ("timestep", *PHYSX_SETTINGS)
"""Simulation settings, which are not part of UsdPhysics."""


def write(plan: ScenePlan, measured: EngineSnapshot, options: ExportOptions, sink: Sink) -> dict[str, bytes] | None:
    """Returns the file and its images, or None after an error, which is reported to `sink`."""
    unsupported = UnsupportedFeatures(sink, left_out="SC750", otherwise="SC750")
    mesh_builder = MeshBuilder(plan, lambda problem, origin: problem.report(sink, origin), options.max_triangles)
    try:
        stage = Stage(options.name, unsupported)
        _write_scene(
            stage, plan, measured.scenes[0], UsdBodyWriter(stage, mesh_builder, UsdMaterialWriter(stage), options.show)
        )
    except AssetError as problem:
        problem.report(sink, mesh_builder.at)
        return None
    _report_unsupported(stage, plan, measured.scenes[0].index)
    suffix = ".usdc" if options.binary else ".usda"
    return {f"{options.name}{suffix}": _stage_to_bytes(stage, suffix), **stage.assets.files}


def _write_scene(stage: Stage, plan: ScenePlan, scene: MeasuredScene, bodies: UsdBodyWriter) -> None:
    physics = stage.physics.Scene.Define(stage.stage, stage.path(stage.root, "PhysicsScene"))
    strength = float(np.linalg.norm(scene.gravity))
    physics.CreateGravityMagnitudeAttr(strength)
    down = tuple(value / strength for value in scene.gravity) if strength else (0.0, 0.0, -1.0)
    physics.CreateGravityDirectionAttr(stage.vec3(down))
    paths: dict[tuple[str, str | None], str] = {}
    for entity in scene.entities:
        _write_entity(stage, entity, bodies, paths)
    for constraint in plan.constraints:
        if scene.index in constraint.scene_idxs:
            write_constraint(stage, constraint, constraint.scene_idxs.index(scene.index), paths)


def _write_entity(
    stage: Stage, entity: MeasuredEntity, bodies: UsdBodyWriter, paths: dict[tuple[str, str | None], str]
) -> None:
    name = entity.entity.name
    if entity.entity.hidden:
        stage.unsupported.leave_out(name, "`hidden`, which hides it from sensors", entity.entity.origin)
    if not isinstance(entity.structure, ArticulationStructure):
        (body,) = entity.bodies
        made = stage.xform(stage.root, name, body.pose)
        paths[name, None] = str(made.GetPath())
        bodies.write(made, entity, body)
        return
    # Links are siblings at their world poses, because USD would move a nested body twice.
    above = str(stage.xform(stage.root, name).GetPath())
    links: list[str] = []
    for body in entity.bodies:
        made = stage.xform(above, body.name, body.pose)
        links.append(str(made.GetPath()))
        paths[name, body.name] = links[-1]
        bodies.write(made, entity, body)
    write_joints(stage, entity, above, links)


def _report_unsupported(stage: Stage, plan: ScenePlan, scene: int) -> None:
    """Warns of everything that is not in the file."""
    unsupported = stage.unsupported
    for item in (*plan.lights, *plan.cameras):
        if scene in item.scene_idxs:
            unsupported.leave_out(item.name, "a light" if item in plan.lights else "a camera", item.origin)
    if plan.environment is not None:
        unsupported.leave_out("environment", "surroundings", plan.environment.origin)
    unsupported.fields("physics", plan.physics, _UNSUPPORTED_PHYSICS_FIELDS, plan.physics.origin)
    unsupported.report()


def _stage_to_bytes(stage: Stage, suffix: str) -> bytes:
    """Returns a stage as bytes. Usd-core writes the binary format only to files."""
    layer = stage.stage.GetRootLayer()
    if suffix == ".usda":
        return str(layer.ExportToString()).encode()
    with temporary_folder() as folder:
        file = Path(folder) / f"scene{suffix}"
        layer.Export(str(file))
        return file.read_bytes()
