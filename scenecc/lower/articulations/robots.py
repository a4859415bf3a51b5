"""Robots as their files describe them to drafts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc import plan
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.lower.articulations.drafts import ArticulationDraft, ContactDefaults, DraftJoint, DraftLink, DraftMimic
from scenecc.lower.materials import LoweredMaterial, MaterialChoice
from scenecc.lower.references import select_per_scene
from scenecc.lower.shapes import SAPIEN_DENSITY
from scenecc.plan import (
    AssetFile,
    CollisionShape,
    Inertial,
    PhysicalMaterial,
    Texture,
    Value,
    VisualMaterial,
    VisualShape,
    literal,
)
from scenecc.robots import description as robots

if TYPE_CHECKING:
    from scenecc.diagnostics import Location, Origin
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.materials import MaterialLowerer
    from scenecc.lower.references import PlanTables
    from scenecc.robots.description import (
        DescribedCollision,
        DescribedJoint,
        DescribedLink,
        DescribedMaterial,
        DescribedRobot,
        DescribedVisual,
    )

_IDENTITY_NUMBERS = IDENTITY_POSE


class RobotDrafter:
    """Makes drafts of described robots.

    Args:
        tables: take their files and materials.
        materials: of the document.
    """

    def __init__(self, tables: PlanTables, materials: MaterialLowerer) -> None:
        self._tables = tables
        self._materials = materials
        self._looks: dict[int, tuple[DescribedMaterial, VisualMaterial]] = {}

    def draft(
        self, robot: DescribedRobot, keys: Any, file: Value, origin: Origin, leaves: FieldLowerer
    ) -> ArticulationDraft:
        """A robot as a draft.

        Args:
            robot: as its file describes it.
            keys: of the entity: how its meshes collide.
            file: (·,) index of its file.
            origin: of the node that names the file.
            leaves: of the entity.
        """
        meshes = _MeshCollision(keys)
        links = tuple(self._link(link, meshes, origin, leaves) for link in robot.links)
        place = origin if robot.location is None else origin.into(robot.location)
        return ArticulationDraft(links, place, robot.fixed, file)

    def _link(self, link: DescribedLink, meshes: _MeshCollision, origin: Origin, leaves: FieldLowerer) -> DraftLink:
        place = origin.into(link.location, "links", link.name)

        def shaping(touch: ContactDefaults) -> tuple[tuple[CollisionShape, ...], tuple[VisualShape, ...]]:
            """What the scene says of material and density replaces what the file says."""
            collisions = tuple(self._collision(shape, meshes, touch, origin, leaves) for shape in link.collisions)
            return collisions, tuple(self._visual(shape, touch, origin, leaves) for shape in link.visuals)

        inertial = link.inertial and Inertial(
            literal(link.inertial.mass), literal(link.inertial.com), literal(link.inertial.inertia)
        )
        joint = link.joint and _joint(link.joint, origin)
        return DraftLink(link.name, place, shaping, link.parent, joint, None, inertial, link.ignore_bits)

    def _collision(
        self,
        shape: DescribedCollision,
        meshes: _MeshCollision,
        touch: ContactDefaults,
        origin: Origin,
        leaves: FieldLowerer,
    ) -> CollisionShape:
        place = origin.into(shape.location)
        described: Value | None = None
        if shape.friction is not None:
            described = self._tables.physical(PhysicalMaterial(*map(literal, shape.friction)), place)
        density = None if shape.density is None else literal(shape.density)
        surface = touch.default.surface
        if isinstance(surface, MaterialChoice):
            material, dense = self._several(surface, described, density, leaves)
        else:
            material, dense = surface.physical, surface.density
        said = touch.default.density if dense is None else dense
        return CollisionShape(
            geometry=self._colliding(shape.geometry, meshes, shape.location, origin),
            pose=_pose(shape.pose),
            material=described if material is None else material,
            density=density if said is None else said,
            patch_radius=touch.patch_radius,
            min_patch_radius=touch.min_patch_radius,
            origin=place,
        )

    def _several(
        self, surfaces: MaterialChoice, described: Value | None, density: Value | None, leaves: FieldLowerer
    ) -> tuple[Value | None, Value | None]:
        """Material and density where the scenes have one of several materials."""
        rows = len(leaves.scenes)
        material = dense = None
        if described is not None or any(surface.physical is not None for surface in surfaces.each):
            default = described or self._materials.default()
            material = select_per_scene([surface.physical or default for surface in surfaces.each], surfaces.pick, rows)
        if any(surface.density is not None for surface in surfaces.each):
            default = density or literal(SAPIEN_DENSITY)
            dense = select_per_scene([surface.density or default for surface in surfaces.each], surfaces.pick, rows)
        return material, dense

    def _colliding(self, geometry: robots.Geometry, meshes: _MeshCollision, location: Location, origin: Origin) -> Any:
        if isinstance(geometry, robots.MeshGeometry):
            file = self._file(geometry.uri, geometry.path, location, origin)
            scale = self._tables.size(geometry.scale)
            parts = meshes.parts if geometry.parts is None else geometry.parts
            return plan.ConvexParts(file, scale, meshes.coacd) if parts else plan.ConvexMesh(file, scale)
        if isinstance(geometry, robots.PlaneGeometry):
            return plan.Plane()
        return self._solid(geometry)

    def _visual(
        self, shape: DescribedVisual, touch: ContactDefaults, origin: Origin, leaves: FieldLowerer
    ) -> VisualShape:
        geometry = shape.geometry
        if isinstance(geometry, robots.MeshGeometry):
            file = self._file(geometry.uri, geometry.path, shape.location, origin)
            made: Any = plan.Mesh(file, literal(geometry.scale))
        elif isinstance(geometry, robots.PlaneGeometry):
            made = plan.VisualPlane(literal(geometry.half_size or (10.0, 10.0)))
        else:
            made = self._solid(geometry)
        material = self._seen(shape, touch, origin, leaves)
        return VisualShape(made, _pose(shape.pose), material, shape.name or None, None, origin.into(shape.location))

    def _seen(
        self, shape: DescribedVisual, touch: ContactDefaults, origin: Origin, leaves: FieldLowerer
    ) -> Value | None:
        described = None if shape.look is None else self._look(shape.look, shape.location, origin)
        surface = touch.default.surface
        if isinstance(surface, LoweredMaterial):
            visual = surface.visual or described
            return None if visual is None else self._tables.visual_materials.value(visual)
        visuals = [one.visual or described or VisualMaterial() for one in surface.each]
        values = [self._tables.visual_materials.value(visual) for visual in visuals]
        return select_per_scene(values, surface.pick, len(leaves.scenes))

    def _look(self, look: DescribedMaterial, location: Location, origin: Origin) -> VisualMaterial:
        known = self._looks.get(id(look))
        if known is not None:
            return known[1]
        texture = None
        if look.texture is not None:
            texture = Texture(self._file(look.texture_uri or str(look.texture), look.texture, location, origin))
        numbers: dict[str, Any] = {
            name: literal(item)
            for name in ("base_color", "emission", "specular", "roughness", "metallic")
            if (item := getattr(look, name)) is not None
        }
        made = VisualMaterial(**numbers, base_color_texture=texture)
        # Kept, so that its id stays its own.
        self._looks[id(look)] = look, made
        return made

    def _solid(self, geometry: Any) -> Any:
        size = self._tables.size
        match geometry:
            case robots.BoxGeometry(half_size):
                return plan.Box(size(half_size))
            case robots.SphereGeometry(radius):
                return plan.Sphere(size(radius))
            case robots.CapsuleGeometry(radius, half_length):
                return plan.Capsule(size(radius), size(half_length))
            case _:
                return plan.Cylinder(size(geometry.radius), size(geometry.half_length))

    def _file(self, uri: str, path: Any, location: Location, origin: Origin) -> Value:
        file = AssetFile(uri, path)
        value = self._tables.files.value(file)
        self._tables.file_origins.setdefault(int(value.numbers()[0]), origin.into(location))
        return value


class _MeshCollision:
    """How the meshes of an entity collide that say nothing of it themselves.

    Attributes:
        parts: whether their connected parts collide one by one.
        coacd: how these are cut; None: they are the file's own.
    """

    def __init__(self, keys: Any) -> None:
        self.parts: bool = bool(getattr(keys, "load_multiple_collisions", None))
        self.coacd: plan.CoacdParams | None = None
        if getattr(keys, "decomposition", None) == "coacd":
            given = keys.decomposition_params
            self.coacd = plan.CoacdParams(**given.model_dump()) if given else plan.CoacdParams()


def _joint(joint: DescribedJoint, origin: Origin) -> DraftJoint:
    place = origin.into(joint.location, "joints", joint.name)
    mimic = joint.mimic
    return DraftJoint(
        type=joint.type,
        name=joint.name,
        origin=place,
        pose_in_parent=_pose(joint.pose_in_parent),
        pose_in_child=_pose(joint.pose_in_child),
        limits=None if joint.limits is None else literal(joint.limits),
        friction=_number(joint.friction),
        damping=_number(joint.damping or None),
        armature=_number(joint.armature),
        max_velocity=_number(joint.velocity),
        effort=_number(joint.effort),
        mimic=None
        if mimic is None
        else DraftMimic(
            mimic.source, literal(mimic.multiplier), literal(mimic.offset), origin.into(mimic.location, "mimic")
        ),
    )


def _number(given: float | None) -> Value | None:
    return None if given is None else literal(float(given))


def _pose(pose: robots.PoseNumbers) -> Value | None:
    """To the bit: what is at -0.0 is told to the engine."""
    return None if pose == _IDENTITY_NUMBERS and "-" not in repr(pose) else literal(pose)
