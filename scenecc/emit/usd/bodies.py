"""Bodies: what is seen of them, their colliders, and their mass as the engine has it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.meshes import baked

if TYPE_CHECKING:
    from scenecc.emit.choice import Show
    from scenecc.emit.usd.looks import Looks
    from scenecc.emit.usd.stage import Prim, Stage
    from scenecc.meshes import Drawer, Shape
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredMesh, MeasuredShape

NOT_OF_A_BODY: Final = (
    "disable_gravity",
    "locked_motion_axes",
    "linear_damping",
    "angular_damping",
    "max_linear_velocity",
    "max_angular_velocity",
    "max_depenetration_velocity",
    "max_contact_impulse",
    "sleep_threshold",
    "solver_position_iterations",
    "solver_velocity_iterations",
    "collision_groups",
)
"""What UsdPhysics has no word for."""

_NOT_OF_A_SHAPE: Final = ("contact_offset", "rest_offset", "patch_radius", "min_patch_radius")


class Bodies:
    """Writes bodies below their entities."""

    def __init__(self, stage: Stage, drawer: Drawer, looks: Looks, show: Show) -> None:
        self._stage = stage
        self._drawer = drawer
        self._looks = looks
        self._show = show

    def fill(self, made: Prim, entity: MeasuredEntity, body: MeasuredBody) -> None:
        """Makes a frame the body: its mass, what it looks like, what of it collides.

        Raises:
            MeshProblem: a file cannot be shown.
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
        stage.lost.fields(entity.entity.name, body.body, NOT_OF_A_BODY, place)
        if body.body.shading_mode is not None and self._show == "collision":
            stage.lost.fields(entity.entity.name, body.body, ("shading_mode",), place)

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

    def _draw(self, above: str, shape: Shape, entity: str) -> None:
        stage = self._stage
        for part in baked(shape):
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
        stage.lost.fields(entity.entity.name, shape.shape, _NOT_OF_A_SHAPE, shape.shape.origin, " of a shape")

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
