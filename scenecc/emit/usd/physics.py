"""Writes bodies, colliders, articulation joints and constraints of UsdPhysics.

USD counts angles in degrees, and so the stiffness that acts on them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.emit.unsupported import unsupported_fields
from scenecc.emit.xml import pose_in_row
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.meshes.builder import bake_scale
from scenecc.plan import ArticulationStructure, BodyStructure, CollisionShape, Connection, Distance, Drive, Weld
from scenecc.plan.articulation import VELOCITY_FIELDS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.emit import Show
    from scenecc.emit.usd.stage import Prim, Stage, UsdMaterials
    from scenecc.meshes.builder import MeshBuilder
    from scenecc.meshes.surface import MeshShape
    from scenecc.plan import AxisLimit, Constraint, Value
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredJoint, MeasuredMesh, MeasuredShape


UNSUPPORTED_BODY_FIELDS: Final = unsupported_fields(
    BodyStructure, "mass", "inertial", "visibility", *VELOCITY_FIELDS, "shading_mode"
)
"""What UsdPhysics has no word for."""

_UNSUPPORTED_SHAPE_FIELDS: Final = unsupported_fields(CollisionShape, "pose", "material", "density")


class UsdBodyWriter:
    """Writes bodies below their entities."""

    def __init__(self, stage: Stage, drawer: MeshBuilder, looks: UsdMaterials, show: Show) -> None:
        self._stage = stage
        self._drawer = drawer
        self._looks = looks
        self._show = show

    def fill(self, made: Prim, entity: MeasuredEntity, body: MeasuredBody) -> None:
        """Makes a frame the body: its mass, what it looks like, what of it collides.

        Raises:
            MeshError: a file cannot be shown.
        """
        stage = self._stage
        prim = made.GetPrim()
        if body.mass is not None:
            rigid = stage.physics.RigidBodyAPI.Apply(prim)
            if body.body_type == "kinematic":
                rigid.CreateKinematicEnabledAttr(defaultValue=True)
            self._move(rigid, entity, body)
            self._weigh(prim, body)
        path = str(prim.GetPath())
        if self._show == "visual":
            for shape in self._drawer.visuals(body.body, entity.row):
                self._draw(path, shape, entity.entity.name)
        for shape in body.shapes:
            self._collide(path, shape, body, entity)
        place = body.body.origin or entity.structure.origin
        stage.unsupported.fields(entity.entity.name, body.body, UNSUPPORTED_BODY_FIELDS, place)
        if body.body.shading_mode is not None and self._show == "collision":
            stage.unsupported.fields(entity.entity.name, body.body, ("shading_mode",), place)

    def _move(self, rigid: Prim, entity: MeasuredEntity, body: MeasuredBody) -> None:
        """Velocities at the start; USD counts in degrees."""
        linear, angular = body.body.linear_velocity, body.body.angular_velocity
        if linear is not None:
            rigid.CreateVelocityAttr(self._stage.vec3(tuple(linear.row(entity.row))))
        if angular is not None:
            rigid.CreateAngularVelocityAttr(self._stage.vec3(tuple(map(math.degrees, angular.row(entity.row)))))

    def _weigh(self, prim: Prim, body: MeasuredBody) -> None:
        mass = body.mass
        assert mass is not None  # of every body that moves
        api = self._stage.physics.MassAPI.Apply(prim)
        api.CreateMassAttr(mass.mass)
        api.CreateCenterOfMassAttr(self._stage.vec3(mass.com[:3]))
        api.CreateDiagonalInertiaAttr(self._stage.vec3(mass.inertia))
        api.CreatePrincipalAxesAttr(self._stage.quat(mass.com))

    def _draw(self, above: str, shape: MeshShape, entity: str) -> None:
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
            st.Set(stage.vec2s(uvs * (1, -1) + (0, 1)))  # USD counts from the bottom of an image
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

    def _collide(self, above: str, shape: MeasuredShape, body: MeasuredBody, entity: MeasuredEntity) -> None:
        stage = self._stage
        path = stage.path(above, f"{shape.kind}_collision")
        made, scale = self._collider(path, shape)
        stage.place(made, shape.pose, scale)
        stage.physics.CollisionAPI.Apply(made.GetPrim())
        self._looks.rub(made, shape)
        if self._show == "visual":
            made.CreatePurposeAttr(stage.geom.Tokens.guide)
        else:
            (drawn,) = self._drawer.collision(shape, body).parts
            self._looks.bind(made, drawn.look, entity.entity.name, shape.shape.origin)
        stage.unsupported.fields(
            entity.entity.name, shape.shape, _UNSUPPORTED_SHAPE_FIELDS, shape.shape.origin, " of a shape"
        )

    def _collider(self, path: str, shape: MeasuredShape) -> tuple[Prim, tuple[float, ...] | None]:
        """A shape, and its scale where it has one. As in SAPIEN, what is round lies along x, and a plane faces x."""
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
                assert shape.mesh is not None  # of every shape that is no primitive
                return self._cooked(path, shape, shape.mesh), None

    def _cooked(self, path: str, shape: MeasuredShape, mesh: MeasuredMesh) -> Prim:
        made = self._mesh(path, mesh.vertices, mesh.triangles)
        api = self._stage.physics.MeshCollisionAPI.Apply(made.GetPrim())
        convex = shape.kind == "convex_mesh"
        api.CreateApproximationAttr(
            self._stage.physics.Tokens.convexHull if convex else self._stage.physics.Tokens.none
        )
        return made


_UNSUPPORTED_JOINT_FIELDS: Final = ("friction", "armature", "max_velocity", "qvel")

_UNSUPPORTED_ARTICULATION_FIELDS: Final = unsupported_fields(ArticulationStructure, "file")


def write_joints(stage: Stage, entity: MeasuredEntity, above: str, links: list[str]) -> None:
    """The joints of an articulation, whose prim is at `above`. `links`: paths of its links."""
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
            stage.unsupported.fields(
                name, planned.joint, _UNSUPPORTED_JOINT_FIELDS, planned.joint.origin or structure.origin, of
            )
    for mimic in structure.mimics:
        words = f"that `{mimic.joint}` follows `{mimic.source}`"
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
    """The limits of an axis [m, rad], by setters of USD's, which counts angles in degrees."""
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
    """The drive of an axis of USD's.

    Args:
        stage: that has the joint.
        made: the joint.
        axis: "linear", "angular", or a degree of freedom, as "transX" or "rotX".
        mode: "force" or "acceleration".
        strength: stiffness, damping and limit of force, in radians where it turns.
        target: position and velocity [m, m/s or rad, rad/s].
    """
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
    """Puts a joint between two bodies, by their paths. `parent`: None is the world. Frames: p then q (wxyz)."""
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
"""An axis of a drive as USD's degrees of freedom."""

_JOINT_CLASSES: Final[dict[type, str]] = {
    Weld: "FixedJoint",
    Connection: "SphericalJoint",
    Distance: "DistanceJoint",
    Drive: "Joint",
}

_UNSUPPORTED_DRIVE_FIELDS: Final = ("inv_mass_scales", "inv_inertia_scales")


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
    made.CreateCollisionEnabledAttr(defaultValue=True)
    if isinstance(joint, Distance):
        low, high = map(float, joint.limits.row(row))
        made.CreateMinDistanceAttr(low)
        if math.isfinite(high):
            made.CreateMaxDistanceAttr(high)
        stage.unsupported.fields(constraint.name, joint, ("stiffness", "damping"), constraint.origin)
    elif isinstance(joint, Drive):
        _write_drive(stage, made, constraint, joint, row)


def _write_drive(stage: Stage, made: Prim, constraint: Constraint, joint: Drive, row: int) -> None:
    for limit in joint.limits:
        _write_axis_limit(stage, made, limit, row)
        stage.unsupported.fields(
            constraint.name, limit, ("stiffness", "damping"), constraint.origin, f" of the limit of {limit.axis}"
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
    """Position and velocity along each axis that the drive pulls to [m, m/s]."""

    def rows(value: Value | None) -> list[float]:
        return [0.0] * 3 if value is None else [float(number) for number in value.row(row)[:3]]

    along = zip("XYZ", rows(joint.target), rows(joint.linear_velocity_target), strict=True)
    return {f"trans{axis}": (position, speed) for axis, position, speed in along}
