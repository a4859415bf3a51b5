"""USD bodies: mass, collision shapes and visual shapes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.geometry.rotations import IDENTITY, IDENTITY_POSE, Pose7, Vec3, to_vector
from scenecc.importers.usd_shapes import UsdShape, UsdShapeReader
from scenecc.importers.usd_stage import UNITS, Prim, UsdStage, quat_of, split_matrix
from scenecc.robots.description import (
    DescribedCollision,
    DescribedDynamics,
    DescribedInertial,
    DescribedLink,
    DescribedMotion,
    DescribedVisual,
    MeshGeometry,
    MotionAxis,
)
from scenecc.robots.rules import enforce_triangle_rule
from scenecc.robots.solids import SolidMass, is_raised, joined_mass

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.importers.usd_materials import UsdMaterialReader

_BALL_RADIUS: Final = 0.1
"""Radius of the sphere that gives a body without inertia its moments, as in usd-core [m]."""

_DENSITY: Final = 1000.0
"""Default density, in USD as in SAPIEN [kg/m³]."""


@dataclass(slots=True)
class UsdBody:
    """A body: a prim with `RigidBodyAPI`, or a group of static prims.

    Attributes:
        prim: its frame.
        pose: of that frame in the world.
        body_type: of a body; "static" for a group.
        colliders: collider prims, with their UsdPhysics descriptors.
        visuals: visible prims.
        parsed: UsdPhysics descriptor of the body; None for a static group.
    """

    prim: Prim
    pose: Pose7
    body_type: Literal["dynamic", "kinematic", "static"]
    colliders: list[tuple[Prim, Any]] = field(default_factory=list[tuple[Any, Any]])
    visuals: list[Prim] = field(default_factory=list[Any])
    parsed: Any = None

    @property
    def path(self) -> str:
        """Path of its prim."""
        return str(self.prim.GetPath())

    @property
    def collides(self) -> bool:
        """Whether it has a collider that is on."""
        return any(parsed.collisionEnabled for _, parsed in self.colliders)


class UsdBodyReader:
    """Describes bodies.

    Attributes:
        masses: mass of each body as computed by UsdPhysics, by prim path [kg]; None: unknown.
    """

    def __init__(self, stage: UsdStage, materials: UsdMaterialReader) -> None:
        self.masses: dict[str, float | None] = {}
        self._stage = stage
        self._materials = materials
        self._shapes = UsdShapeReader(stage)

    def link(self, body: UsdBody, name: str, *, is_weighed: bool = False) -> DescribedLink:
        """Returns a body as a link. `is_weighed`: with its mass and inertia, also where they follow from densities."""
        seen = {prim.GetPath() for prim in body.visuals}
        shapes: list[tuple[Prim, Any, UsdShape]] = []
        collisions: list[DescribedCollision] = []
        visuals: list[DescribedVisual] = []
        for prim, parsed in body.colliders:
            made = self._colliders(prim, body)
            shapes += [(prim, parsed, shape) for shape in made]
            if not parsed.collisionEnabled:
                continue
            collisions += [self._collision(prim, parsed, shape) for shape in made]
            if len(made) == 1 and prim.GetPath() in seen and self._matches_visual(prim, made[0]):
                seen.discard(prim.GetPath())
                visuals.append(self._visual(made[0], prim))
        for prim in body.visuals:
            if prim.GetPath() in seen:
                visuals += self._visuals(prim, body)
        inertial = None
        if body.body_type == "dynamic":
            inertial, collisions = self._weigh(body, shapes, collisions, is_weighed=is_weighed)
        return DescribedLink(
            name,
            self._stage.place,
            collisions=tuple(collisions),
            visuals=tuple(visuals),
            inertial=inertial,
            disable_gravity=bool(self._stage.authored(body.prim, "physxRigidBody:disableGravity")),
            motion=DescribedMotion(**self._read_settings(body.prim, _MOTION)),
            source=body.path,
        )

    def _collision(self, prim: Prim, parsed: Any, shape: UsdShape) -> DescribedCollision:
        path = self._materials.physical_path(parsed)
        friction = to_vector(self._materials.friction(path).values()) if path else None
        offsets: list[float | None] = []
        for name in ("contactOffset", "restOffset"):  # -inf means PhysX's default
            found = self._stage.authored(prim, f"physxCollision:{name}")
            offsets.append(found * self._stage.frames.metres if found is not None and math.isfinite(found) else None)
        return DescribedCollision(
            shape.geometry,
            shape.pose,
            self._stage.place,
            friction,
            contact_offset=offsets[0],
            rest_offset=offsets[1],
            material=path.rpartition("/")[2],
        )

    def _visual(self, shape: UsdShape, prim: Prim) -> DescribedVisual:
        """Returns a visual shape. `prim`: has its material."""
        geometry = shape.geometry
        if isinstance(geometry, MeshGeometry):
            geometry = replace(geometry, collision=None)
        return DescribedVisual(geometry, shape.pose, self._stage.place, look=self._materials.look(prim))

    def _colliders(self, prim: Prim, body: UsdBody) -> list[UsdShape]:
        moves = body.body_type == "dynamic"
        approximation = str(self._stage.value(prim, "physics:approximation", "none"))
        made = self._shapes.collider(prim, body.pose, moves=moves, approximation=approximation)
        if moves and str(prim.GetTypeName()) == "Plane":
            self._stage.lose("colliders", "a moving plane, which cannot collide", prim)
            return []
        return made

    def _matches_visual(self, prim: Prim, shape: UsdShape) -> bool:
        """Returns whether a collision shape looks like its prim."""
        is_same = str(prim.GetTypeName()) != "Mesh" or isinstance(shape.geometry, MeshGeometry)
        return is_same and not self._stage.geom.Subset.GetAllGeomSubsets(self._stage.geom.Imageable(prim))

    def _visuals(self, prim: Prim, body: UsdBody) -> list[DescribedVisual]:
        """Returns the shapes of a visible prim, one per material of its faces."""
        if str(prim.GetTypeName()) != "Mesh":
            shape = self._shapes.solid(prim, body.pose)
            return [] if shape is None else [self._visual(shape, prim)]
        mesh = self._shapes.read_mesh(prim)
        parts = () if mesh is None else self._materials.parts(prim, mesh)
        return [
            self._visual(self._shapes.mesh_shape(prim, part, body.pose, suffix=suffix), owner)
            for owner, part, suffix in parts
        ]

    def _weigh(
        self,
        body: UsdBody,
        shapes: list[tuple[Prim, Any, UsdShape]],
        collisions: list[DescribedCollision],
        *,
        is_weighed: bool,
    ) -> tuple[DescribedInertial | None, list[DescribedCollision]]:
        """Returns the inertial of a body as UsdPhysics has it, and its shapes with the densities it depends on."""
        solids: dict[Any, list[SolidMass]] = {}
        for prim, _, shape in shapes:
            if shape.mass is not None:
                solids.setdefault(prim.GetPath(), []).append(shape.mass)
        computed = self._compute_mass(body, solids)
        names = ("mass", "centerOfMass", "diagonalInertia", "principalAxes")
        mass, *others = (self._read_authored(body.prim, name) for name in names)
        is_plain = (
            bool(shapes)
            and not is_weighed
            and len(collisions) == len(shapes)
            and all(shape.exact and shape.mass for _, _, shape in shapes)
            and not any(self._read_authored(prim, "mass") for prim, _, _ in shapes if prim != body.prim)
            and all(each is None for each in others)
        )
        if mass and len(shapes) == 1:
            densities = [_DENSITY]
        else:
            densities = [self._density(prim, parsed, body.prim) for prim, parsed, _ in shapes]
        if not is_plain or is_raised(joined_mass(shape.mass for _, _, shape in shapes if shape.mass), min(densities)):
            return self._inertial(body, solids, computed), collisions
        rows = zip(collisions, densities, strict=True)
        collisions = [each if density == _DENSITY else replace(each, density=density) for each, density in rows]
        if not mass:
            return None, collisions
        mass *= self._stage.frames.kilograms
        return DescribedInertial(mass, IDENTITY_POSE, None, self._stage.place), collisions

    def _compute_mass(self, body: UsdBody, solids: dict[Any, list[SolidMass]]) -> tuple[float, Any, Any, Any]:
        """Returns mass, moments, centre and principal axes as computed by UsdPhysics, in the stage's units.

        `solids`: volumes of each collider, by path.
        """
        metres, api = self._stage.frames.metres, self._stage.physics.RigidBodyAPI
        gf: Any = import_module("pxr.Gf")

        def information(prim: Prim) -> Any:
            found = api.MassInformation()
            total = joined_mass(solids[prim.GetPath()]) if prim.GetPath() in solids else _NO_MASS
            found.volume = total.mass / metres**3
            found.inertia = gf.Matrix3f(*(total.inertia / metres**5).ravel().tolist())
            found.localPos = gf.Vec3f(*(total.centre / metres).tolist())
            found.centerOfMass = gf.Vec3f(0)
            found.localRot = gf.Quatf(1)
            return found

        found = api(body.prim).ComputeMassProperties(information)
        known = found[0] > 0 and (solids or self._read_authored(body.prim, "mass"))
        self.masses[str(body.prim.GetPath())] = float(found[0]) * self._stage.frames.kilograms if known else None
        return found

    def _inertial(self, body: UsdBody, solids: dict[Any, list[SolidMass]], computed: Any) -> DescribedInertial:
        frames = self._stage.frames
        mass, moments, centre, axes = computed
        mass = float(mass) * frames.kilograms
        if not mass > 0:
            mass = 1.0
            self._stage.lose(
                "assumed-masses", "a body without mass and colliders; it gets 1 kg, as in PhysX", body.prim
            )
        said = self._read_authored(body.prim, "diagonalInertia")
        if said is not None:  # usd-core ignores small moments
            moments, axes = said, self._read_authored(body.prim, "principalAxes")
        inertia = to_vector(float(each) * frames.kilograms * frames.metres**2 for each in moments)
        # Without colliders usd-core leaves these uninitialised.
        if said is None and (not solids or not all(each > 0 and math.isfinite(each) for each in inertia)):
            moment, axes = 0.4 * mass * _BALL_RADIUS**2, None
            inertia = (moment, moment, moment)
            message = f"a body without inertia; it gets that of a sphere of radius {_BALL_RADIUS} m"
            self._stage.lose("assumed-masses", message, body.prim)
        ruled = enforce_triangle_rule(inertia)
        if ruled != inertia:
            message = f"a moment of inertia of {max(inertia):.6g} above the sum of the others, {max(ruled):.6g}"
            self._stage.lose("inertias", message, body.prim)
        own = self._read_authored(body.prim, "centerOfMass")
        if own is not None:
            x, y, z = (split_matrix(frames.world(body.prim))[1] @ np.array(own, np.float64)).tolist()
        else:
            x, y, z = (float(each) * frames.metres if solids else 0.0 for each in centre)
        com = (x, y, z, *(IDENTITY if axes is None else quat_of(axes)))
        return DescribedInertial(mass, com, ruled, self._stage.place)

    def _read_authored(self, prim: Prim, name: str) -> Any:
        """Returns an authored number of a prim's `MassAPI`; None if it is missing, or a placeholder like 0 or -inf."""
        found = self._stage.authored(prim, f"physics:{name}")
        if found is None:
            return None
        if name == "mass":
            return float(found) if found > 0 else None
        if name == "centerOfMass":
            return found if all(map(math.isfinite, found)) else None
        if name == "diagonalInertia":
            return found if any(found) else None
        return found if found.GetLength() > 0 else None

    def _density(self, prim: Prim, parsed: Any, body: Prim) -> float:
        frames = self._stage.frames
        for owner in (prim, body):
            found = self._stage.authored(owner, "physics:density")
            if found is not None and found > 0:
                return float(found) * frames.kilograms / frames.metres**3
        found = self._materials.density(parsed)
        return _DENSITY if not found else found * frames.kilograms / frames.metres**3

    def dynamics(self, body: UsdBody) -> DescribedDynamics:
        """Returns initial velocities and settings of a single body."""
        settings = self._read_settings(body.prim, _DYNAMICS)
        return replace(self.velocities(body), locked_axes=self._locked_axes(body.prim), **settings)

    def velocities(self, body: UsdBody) -> DescribedDynamics:
        """Returns initial velocities; USD gives them in the frame of the prim's parent."""
        frames, parsed = self._stage.frames, body.parsed
        above = body.prim.GetParent()
        pose = frames.pose(above) if above and not above.IsPseudoRoot() else None
        linear = [each * frames.metres for each in frames.turned(pose, parsed.linearVelocity)]
        angular = [math.radians(each) for each in frames.turned(pose, parsed.angularVelocity)]
        return DescribedDynamics(_velocity(linear), _velocity(angular))

    def _read_settings(self, prim: Prim, names: Mapping[str, tuple[str, str]]) -> dict[str, Any]:
        """Returns the settings of PhysX's schema that a prim has. `names`: field → attribute, and its unit."""
        metres, found = self._stage.frames.metres, dict[str, Any]()
        units = {"m": metres, "m²": metres * metres, "deg": math.radians(1)}
        for key, (name, unit) in names.items():
            number = self._stage.authored(prim, f"physxRigidBody:{name}")
            if number is not None and math.isfinite(number) and abs(number) < _UNLIMITED:
                found[key] = int(number) if unit == "count" else number * units.get(unit, 1.0)
        return found

    def _locked_axes(self, prim: Prim) -> tuple[MotionAxis, ...]:
        """Returns the locked axes. PhysX's bits are x, y, z from the lowest, in the stage's axes."""
        names: set[str] = set()
        for prefix, bits in self._read_settings(prim, _LOCKS).items():
            for k, unit in enumerate(UNITS.values()):
                if bits >> k & 1:
                    world = self._stage.frames.direction(unit)
                    names.add(prefix + "xyz"[int(np.argmax(np.abs(world)))])
        return tuple(axis for axis in _MOTION_AXES if axis in names)


_MOTION_AXES: Final[tuple[MotionAxis, ...]] = ("x", "y", "z", "rx", "ry", "rz")

_UNLIMITED: Final = 1e30
"""PhysX represents "no limit" by numbers above this."""

_NOISE: Final = 1e-9
"""Smaller velocities are rounding noise [m/s, rad/s]."""

_MOTION: Final = {
    "linear_damping": ("linearDamping", "1"),
    "angular_damping": ("angularDamping", "1"),
    "max_linear_velocity": ("maxLinearVelocity", "m"),
    "max_angular_velocity": ("maxAngularVelocity", "deg"),
    "max_depenetration_velocity": ("maxDepenetrationVelocity", "m"),
    "max_contact_impulse": ("maxContactImpulse", "1"),
}
"""Field of `DescribedMotion` → attribute of PhysX's schema, and its unit."""

_DYNAMICS: Final = {
    "sleep_threshold": ("sleepThreshold", "m²"),
    "solver_position_iterations": ("solverPositionIterationCount", "count"),
    "solver_velocity_iterations": ("solverVelocityIterationCount", "count"),
}
"""Field of `DescribedDynamics` → attribute of PhysX's schema, and its unit."""

_LOCKS: Final = {"": ("lockedPosAxis", "count"), "r": ("lockedRotAxis", "count")}
"""Prefix of `_MOTION_AXES` → attribute of PhysX's schema."""

_NO_MASS: Final = SolidMass(0.0, np.zeros(3), np.zeros((3, 3)))


def _velocity(row: list[float]) -> Vec3 | None:
    """Returns a velocity; None for 0."""
    return to_vector(0.0 if abs(each) < _NOISE else each for each in row) if any(row) else None
