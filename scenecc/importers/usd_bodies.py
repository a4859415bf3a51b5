"""USD bodies: mass, collision shapes and visual shapes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.geometry.rotations import IDENTITY, Pose7
from scenecc.importers.numbers import plain_number, plain_numbers, pose_key
from scenecc.importers.usd_shapes import SolidMass, UsdShape, UsdShapeReader
from scenecc.importers.usd_stage import Prim, UsdStage, quat_of, split_matrix

if TYPE_CHECKING:
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
        body_type: "dynamic", "kinematic", "static" or "none".
        colliders: collider prims, with their UsdPhysics descriptors.
        visuals: visible prims.
        parsed: UsdPhysics descriptor of the body; None for a static group.
    """

    prim: Prim
    pose: Pose7
    body_type: str
    colliders: list[tuple[Prim, Any]] = field(default_factory=list[tuple[Any, Any]])
    visuals: list[Prim] = field(default_factory=list[Any])
    parsed: Any = None


class UsdBodyReader:
    """Writes the keys of bodies.

    Attributes:
        masses: mass of each body as computed by UsdPhysics, by prim path [kg]; None: unknown.
    """

    def __init__(self, stage: UsdStage, materials: UsdMaterialReader) -> None:
        self.masses: dict[str, float | None] = {}
        self._stage = stage
        self._materials = materials
        self._shapes = UsdShapeReader(stage)

    def keys(self, body: UsdBody, *, is_link: bool = False) -> dict[str, Any]:
        """Returns all keys of a body except pose and type. `is_link`: of an articulation."""
        found: dict[str, list[tuple[dict[str, Any], Prim]]] = {"shapes": [], "collisions": [], "visuals": []}
        shapes: list[tuple[Prim, Any, UsdShape]] = []
        seen = {prim.GetPath() for prim in body.visuals}
        for prim, parsed in body.colliders:
            made = self._colliders(prim, body)
            shapes += [(prim, parsed, shape) for shape in made]
            if not parsed.collisionEnabled:
                continue
            for shape in made:
                entry = shape.entry() | self._contact_keys(prim)
                both = len(made) == 1 and prim.GetPath() in seen and self._matches_visual(prim, shape)
                if both:
                    seen.discard(prim.GetPath())
                    self._materials.set_both(entry, prim, parsed)
                else:
                    if shape.keys["type"] == "plane":
                        entry.pop("half_size", None)
                    self._materials.set_physical(entry, parsed)
                found["shapes" if both else "collisions"].append((entry, prim))
        for prim in body.visuals:
            if prim.GetPath() in seen:
                found["visuals"] += [(entry, prim) for entry in self._visuals(prim, body)]
        keys: dict[str, Any] = {}
        if body.body_type == "dynamic":
            keys |= self._mass_keys(
                body, shapes, [entry for name in ("shapes", "collisions") for entry, _ in found[name]]
            )
            keys |= self._motion_keys(body, is_link=is_link)
        for name, entries in found.items():
            if entries:
                keys[name] = [entry for entry, _ in entries]
        _join_equal(keys)
        return keys

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
        plain = str(prim.GetTypeName()) != "Mesh" or shape.keys["type"] in {"convex_mesh", "triangle_mesh"}
        if shape.keys["type"] in {"box", "sphere"} and str(prim.GetTypeName()) == "Mesh":
            return False
        return plain and not self._stage.geom.Subset.GetAllGeomSubsets(self._stage.geom.Imageable(prim))

    def _visuals(self, prim: Prim, body: UsdBody) -> list[dict[str, Any]]:
        """Returns the entries of a visible prim, one per material of its faces."""
        if str(prim.GetTypeName()) != "Mesh":
            shape = self._shapes.solid(prim, body.pose)
            if shape is None:
                return []
            entry = shape.entry()
            self._materials.set_visual(entry, prim)
            return [entry]
        mesh = self._shapes.read_mesh(prim)
        if mesh is None:
            return []
        entries: list[dict[str, Any]] = []
        for owner, part, suffix in self._materials.parts(prim, mesh):
            entry = self._shapes.mesh_shape(prim, part, body.pose, "mesh", suffix).entry()
            self._materials.set_visual(entry, owner)
            entries.append(entry)
        return entries

    def _contact_keys(self, prim: Prim) -> dict[str, Any]:
        """Returns contact offsets from PhysX's schema, which usd-core lacks; -inf means PhysX's default."""
        keys: dict[str, Any] = {}
        for key, name in (
            ("contact_offset", "physxCollision:contactOffset"),
            ("rest_offset", "physxCollision:restOffset"),
        ):
            found = self._stage.authored(prim, name)
            if found is not None and math.isfinite(found):
                keys[key] = plain_number(found * self._stage.frames.metres)
        return keys

    def _mass_keys(
        self, body: UsdBody, shapes: list[tuple[Prim, Any, UsdShape]], entries: list[dict[str, Any]]
    ) -> dict[str, Any]:
        """Returns `mass` or `inertial`, or sets densities in the entries; as few keys as match UsdPhysics."""
        stage = self._stage
        solids: dict[Any, list[SolidMass]] = {}
        for prim, _, shape in shapes:
            if shape.mass is not None:
                solids.setdefault(prim.GetPath(), []).append(shape.mass)
        computed = self._compute_mass(body, solids)
        said = {
            name: self._read_authored(body.prim, name)
            for name in ("mass", "centerOfMass", "diagonalInertia", "principalAxes")
        }
        plain = (
            bool(shapes) and all(shape.exact and shape.mass for _, _, shape in shapes) and len(entries) == len(shapes)
        )
        plain = plain and not any(self._read_authored(prim, "mass") for prim, _, _ in shapes if prim != body.prim)
        if plain and not any(said[name] is not None for name in said if name != "mass"):
            for (prim, parsed, _), entry in zip(shapes, entries, strict=True):
                density = self._density(prim, parsed, body.prim)
                if density != _DENSITY and not (said["mass"] and len(shapes) == 1):
                    entry["density"] = plain_number(density)
            return {"mass": plain_number(float(said["mass"]) * stage.frames.kilograms)} if said["mass"] else {}
        return {"inertial": self._inertial(body, solids, computed)}

    def _compute_mass(self, body: UsdBody, solids: dict[Any, list[SolidMass]]) -> tuple[float, Any, Any, Any]:
        """Returns mass, moments, centre and principal axes as computed by UsdPhysics, in the stage's units.

        `solids`: volumes of each collider, by path.
        """
        metres, api = self._stage.frames.metres, self._stage.physics.RigidBodyAPI
        gf: Any = import_module("pxr.Gf")

        def information(prim: Prim) -> Any:
            found = api.MassInformation()
            total = _add_masses(solids.get(prim.GetPath(), []))
            found.volume = total.volume / metres**3
            found.inertia = gf.Matrix3f(*(total.inertia / metres**5).ravel().tolist())
            found.localPos = gf.Vec3f(*(total.centre / metres).tolist())
            found.centerOfMass = gf.Vec3f(0)
            found.localRot = gf.Quatf(1)
            return found

        found = api(body.prim).ComputeMassProperties(information)
        known = found[0] > 0 and (solids or self._read_authored(body.prim, "mass"))
        self.masses[str(body.prim.GetPath())] = float(found[0]) * self._stage.frames.kilograms if known else None
        return found

    def _inertial(self, body: UsdBody, solids: dict[Any, list[SolidMass]], computed: Any) -> dict[str, Any]:
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
        inertia = [float(each) * frames.kilograms * frames.metres**2 for each in moments]
        # Without colliders usd-core leaves these uninitialised.
        if said is None and (not solids or not all(each > 0 and math.isfinite(each) for each in inertia)):
            inertia, axes = [0.4 * mass * _BALL_RADIUS**2] * 3, None
            message = f"a body without inertia; it gets that of a sphere of radius {_BALL_RADIUS} m"
            self._stage.lose("assumed-masses", message, body.prim)
        self._enforce_triangle_rule(inertia, body.prim)
        own = self._read_authored(body.prim, "centerOfMass")
        if own is not None:
            x, y, z = (split_matrix(frames.world(body.prim))[1] @ np.array(own, np.float64)).tolist()
        else:
            x, y, z = (float(each) * frames.metres if solids else 0.0 for each in centre)
        com = pose_key((x, y, z, *(IDENTITY if axes is None else quat_of(axes))), "com")
        return {"mass": plain_number(mass), **com, "inertia": plain_numbers(inertia)}

    def _enforce_triangle_rule(self, inertia: list[float], prim: Prim) -> None:
        """Lowers the largest moment to the sum of the others, its physical maximum."""
        largest = max(range(3), key=inertia.__getitem__)
        others = sum(inertia) - inertia[largest]
        if inertia[largest] > others * (1 + 1e-6):
            message = f"a moment of inertia of {inertia[largest]:.6g} above the sum of the others, {others:.6g}"
            self._stage.lose("inertias", message, prim)
            inertia[largest] = others

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

    def _motion_keys(self, body: UsdBody, *, is_link: bool) -> dict[str, Any]:
        """Returns initial velocities and the settings from PhysX's schema."""
        stage, keys = self._stage, dict[str, Any]()
        metres = stage.frames.metres
        if body.parsed is not None and not is_link:
            keys |= self.velocity_keys(body)
        if stage.authored(body.prim, "physxRigidBody:disableGravity"):
            keys["gravity"] = False
        for key, (name, factor) in _BODY_ATTRIBUTES.items():
            found = stage.authored(body.prim, f"physxRigidBody:{name}")
            if found is not None and math.isfinite(found) and abs(found) < _UNLIMITED:
                number = plain_number(
                    found * {"m": metres, "m²": metres * metres, "deg": math.radians(1)}.get(factor, 1.0)
                )
                if not (is_link and key in _NOT_OF_LINKS):
                    keys[key] = int(found) if factor == "count" else number
        locked = self._locked_axes(body.prim)
        if locked and not is_link:
            keys["locked_axes"] = locked
        return keys

    def velocity_keys(self, body: UsdBody) -> dict[str, Any]:
        """Returns initial velocities; USD gives them in the frame of the prim's parent."""
        frames, parsed = self._stage.frames, body.parsed
        above = body.prim.GetParent()
        pose = frames.pose(above) if above and not above.IsPseudoRoot() else None
        keys: dict[str, Any] = {}
        for key, velocity, factor in (
            ("linear_velocity", parsed.linearVelocity, frames.metres),
            ("angular_velocity", parsed.angularVelocity, math.radians(1)),
        ):
            if any(velocity):
                found = frames.turned(pose, velocity)
                keys[key] = plain_numbers([each * factor for each in found], 1e-9)
        return keys

    def _locked_axes(self, prim: Prim) -> list[str]:
        """Returns the locked axes. PhysX's bits are x, y, z from the lowest, in the stage's axes."""
        names: list[str] = []
        for attribute, prefix in (("lockedPosAxis", ""), ("lockedRotAxis", "r")):
            bits = int(self._stage.authored(prim, f"physxRigidBody:{attribute}") or 0)
            for k in range(3):
                if bits >> k & 1:
                    unit = [float(each == k) for each in range(3)]
                    world = self._stage.frames.direction(unit)
                    names.append(prefix + "xyz"[int(np.argmax(np.abs(world)))])
        return sorted(names, key=["x", "y", "z", "rx", "ry", "rz"].index)


_UNLIMITED: Final = 1e30
"""PhysX represents "no limit" by numbers above this."""

_BODY_ATTRIBUTES: Final = {
    "linear_damping": ("linearDamping", "1"),
    "angular_damping": ("angularDamping", "1"),
    "max_linear_velocity": ("maxLinearVelocity", "m"),
    "max_angular_velocity": ("maxAngularVelocity", "deg"),
    "max_depenetration_velocity": ("maxDepenetrationVelocity", "m"),
    "max_contact_impulse": ("maxContactImpulse", "1"),
    "sleep_threshold": ("sleepThreshold", "m²"),
    "solver_position_iterations": ("solverPositionIterationCount", "count"),
    "solver_velocity_iterations": ("solverVelocityIterationCount", "count"),
}
"""Key → attribute of PhysX's schema, and its unit."""

_NOT_OF_LINKS: Final = {"sleep_threshold", "solver_position_iterations", "solver_velocity_iterations"}


def _join_equal(keys: dict[str, Any]) -> None:
    """Moves a density shared by all shapes to the body, and merges equal collisions and visuals into shapes."""
    collisions, visuals = keys.get("collisions", []), keys.get("visuals", [])
    plain = [{key: value for key, value in entry.items() if key != "density"} for entry in collisions]
    if plain and plain == visuals and "shapes" not in keys:
        del keys["visuals"]
        keys["shapes"] = keys.pop("collisions")
    entries = [entry for name in ("shapes", "collisions") for entry in keys.get(name, [])]
    densities = [entry.get("density") for entry in entries]
    if densities and densities[0] is not None and len(set(densities)) == 1:
        shapes = {name: keys.pop(name) for name in ("shapes", "collisions", "visuals") if name in keys}
        keys["density"] = densities[0]
        keys.update(shapes)
        for entry in entries:
            del entry["density"]


def _add_masses(solids: list[SolidMass]) -> SolidMass:
    volume = sum(each.volume for each in solids)
    if not volume:
        return SolidMass(0.0, np.zeros(3), np.zeros((3, 3)))
    centre = sum((each.volume * each.centre for each in solids), np.zeros(3)) / volume
    inertia = np.zeros((3, 3))
    for each in solids:
        d = each.centre - centre
        inertia += each.inertia + each.volume * (d @ d * np.eye(3) - np.outer(d, d))
    return SolidMass(volume, centre, inertia)
