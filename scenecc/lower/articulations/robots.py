"""Makes drafts of robots from files: the file's values, before the scene's overrides."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc import plan
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.lower.articulations.drafts import ArticulationDraft, ContactDefaults, DraftJoint, DraftLink, DraftMimic
from scenecc.lower.materials import LoweredMaterial, MaterialChoice
from scenecc.lower.references import select_per_scene
from scenecc.lower.shapes import coacd_params, count_heights
from scenecc.plan import CollisionShape, Inertial, Value, VisualShape, literal
from scenecc.plan.body import AssetFile, PhysicalMaterial, Texture, VisualMaterial
from scenecc.plan.geometry import SOLIDS, Solid
from scenecc.plan.properties import DEFAULT_DENSITY
from scenecc.robots import description as robots

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics.diagnostic import Location, Origin
    from scenecc.geometry.rotations import Pose7
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
    """Makes drafts of robots.

    Args:
        tables: receive their files and materials.
        materials: of the document.
    """

    def __init__(self, tables: PlanTables, materials: MaterialLowerer) -> None:
        self._tables = tables
        self._materials = materials
        self._looks: dict[int, tuple[DescribedMaterial, VisualMaterial]] = {}

    def draft(
        self, robot: DescribedRobot, keys: Any, file: Value, origin: Origin, fields: FieldLowerer
    ) -> ArticulationDraft:
        """Makes a draft of a robot.

        Args:
            robot: as its file describes it.
            keys: of the entity, for the collision meshes.
            file: (·,) index of its file.
            origin: of the node that names the file.
            fields: of the entity.
        """
        meshes = _MeshCollision(keys)
        links = tuple(self._link(link, meshes, origin, fields) for link in robot.links)
        place = origin if robot.location is None else origin.into(robot.location)
        return ArticulationDraft(links, place, robot.fixed, file)

    def _link(self, link: DescribedLink, meshes: _MeshCollision, origin: Origin, fields: FieldLowerer) -> DraftLink:
        place = origin.into(link.location, "links", link.name)

        def shaping(contact: ContactDefaults) -> tuple[tuple[CollisionShape, ...], tuple[VisualShape, ...]]:
            """The scene's material and density replace the file's."""
            collisions = tuple(self._collision(shape, meshes, contact, origin, fields) for shape in link.collisions)
            return collisions, tuple(self._visual(shape, contact, origin, fields) for shape in link.visuals)

        weight, inertial, mass, com = link.inertial, None, None, None
        if weight is not None and weight.inertia is not None:
            inertial = Inertial(literal(weight.mass), literal(weight.com), literal(weight.inertia))
        elif weight is not None:
            mass = literal(weight.mass)
            com = literal(weight.com[:3]) if weight.keeps_com else None
        joint = link.joint and _joint(link.joint, origin)
        return DraftLink(
            link.name,
            place,
            shaping,
            link.parent,
            joint,
            inertial=inertial,
            ignore_bits=link.ignore_bits,
            mass=mass,
            com=com,
            disable_gravity=link.disable_gravity,
            collides=bool(link.collisions),
        )

    def _collision(
        self,
        shape: DescribedCollision,
        meshes: _MeshCollision,
        contact: ContactDefaults,
        origin: Origin,
        fields: FieldLowerer,
    ) -> CollisionShape:
        place = origin.into(shape.location)
        described: Value | None = None
        if shape.friction is not None:
            described = self._tables.physical(PhysicalMaterial(*map(literal, shape.friction)), place)
        density = None if shape.density is None else literal(shape.density)
        surface = contact.default.surface
        if isinstance(surface, MaterialChoice):
            material, dense = self._choose_materials(surface, described, density, fields)
        else:
            material, dense = surface.physical, surface.density
        shape_density = contact.default.density if dense is None else dense
        return CollisionShape(
            geometry=self._collision_geometry(shape.geometry, meshes, place, fields),
            pose=_pose(shape.pose),
            material=described if material is None else material,
            density=density if shape_density is None else shape_density,
            patch_radius=contact.patch_radius,
            min_patch_radius=contact.min_patch_radius,
            collision_groups=_groups(shape, contact),
            origin=place,
        )

    def _choose_materials(
        self, surfaces: MaterialChoice, described: Value | None, density: Value | None, fields: FieldLowerer
    ) -> tuple[Value | None, Value | None]:
        """Material and density if scenes have different materials."""
        scenes = fields.scenes
        material = dense = None
        if described is not None or any(surface.physical is not None for surface in surfaces.each):
            default = described or self._materials.default()
            physical = [surface.physical or default for surface in surfaces.each]
            material = select_per_scene(physical, surfaces.pick, scenes)
        if any(surface.density is not None for surface in surfaces.each):
            default = density or literal(DEFAULT_DENSITY)
            dense = select_per_scene([surface.density or default for surface in surfaces.each], surfaces.pick, scenes)
        return material, dense

    def _collision_geometry(
        self, geometry: robots.Geometry, meshes: _MeshCollision, place: Origin, fields: FieldLowerer
    ) -> Any:
        if isinstance(geometry, robots.MeshGeometry):
            file = self._mesh_file(geometry, place)
            scale = self._tables.size(geometry.scale)
            if geometry.collision == "sdf":
                return plan.TriangleMesh(file, scale, sdf=True)
            parts = meshes.parts if geometry.collision is None else geometry.collision == "parts"
            return plan.ConvexParts(file, scale, meshes.coacd) if parts else plan.ConvexMesh(file, scale)
        if isinstance(geometry, robots.PlaneGeometry):
            return plan.Plane()
        return self._solid_geometry(geometry, place, fields)

    def _visual(
        self, shape: DescribedVisual, contact: ContactDefaults, origin: Origin, fields: FieldLowerer
    ) -> VisualShape:
        geometry, place = shape.geometry, origin.into(shape.location)
        if isinstance(geometry, robots.MeshGeometry):
            made: Any = plan.Mesh(self._mesh_file(geometry, place), literal(geometry.scale))
        elif isinstance(geometry, robots.PlaneGeometry):
            made = plan.VisualPlane(literal(geometry.half_size or (10.0, 10.0)))
        else:
            made = self._solid_geometry(geometry, place, fields)
        material = self._visual_material(shape, contact, origin, fields)
        return VisualShape(made, _pose(shape.pose), material, shape.name or None, None, place)

    def _visual_material(
        self, shape: DescribedVisual, contact: ContactDefaults, origin: Origin, fields: FieldLowerer
    ) -> Value | None:
        described = None if shape.look is None else self._look(shape.look, shape.location, origin)
        surface = contact.default.surface
        if isinstance(surface, LoweredMaterial):
            visual = surface.visual or described
            return None if visual is None else self._tables.visual_materials.value(visual)
        visuals = [one.visual or described or VisualMaterial() for one in surface.each]
        values = [self._tables.visual_materials.value(visual) for visual in visuals]
        return select_per_scene(values, surface.pick, fields.scenes)

    def _look(self, look: DescribedMaterial, location: Location, origin: Origin) -> VisualMaterial:
        known = self._looks.get(id(look))
        if known is not None:
            return known[1]
        texture, image = None, look.base_color_texture
        if image is not None:
            file = AssetFile(image.uri, image.path)
            texture = Texture(self._file(file, origin.into(location)))
        numbers: dict[str, Any] = {
            name: literal(item)
            for name in ("base_color", "emission", "specular", "roughness", "metallic")
            if (item := getattr(look, name)) is not None
        }
        made = VisualMaterial(**numbers, base_color_texture=texture)
        # Keeping the look keeps its id unique.
        self._looks[id(look)] = look, made
        return made

    def _solid_geometry(
        self, geometry: robots.SolidGeometry | robots.HeightfieldGeometry, place: Origin, fields: FieldLowerer
    ) -> plan.Heightfield | Solid:
        size = self._tables.size
        if isinstance(geometry, robots.HeightfieldGeometry):
            fault = count_heights(geometry.heights, self._tables)
            if fault is not None:
                fields.sink.report("SC529", f"invalid heightfield: {fault}", place)
            return plan.Heightfield(size(geometry.size), geometry.heights)
        values = [size(geometry.sizes)] if geometry.kind == "box" else map(size, geometry.sizes)
        return SOLIDS[geometry.kind](*values)

    def _mesh_file(self, mesh: robots.MeshGeometry, place: Origin) -> Value:
        return self._file(AssetFile(mesh.uri, mesh.path, optional_names=mesh.optional_names, data=mesh.data), place)

    def _file(self, file: AssetFile, place: Origin) -> Value:
        value = self._tables.files.value(file)
        self._tables.file_origins.setdefault(int(value.numbers()[0]), place)
        return value


class _MeshCollision:
    """Default collision geometry for the meshes of an entity.

    Attributes:
        parts: whether connected parts collide separately.
        coacd: how to decompose the mesh; None: the file's own parts.
    """

    def __init__(self, keys: Any) -> None:
        self.parts: bool = bool(getattr(keys, "load_multiple_collisions", None))
        self.coacd = coacd_params(keys) if hasattr(keys, "decomposition") else None


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
        properties={name: literal(float(number)) for name, number in _numbers(joint) if number is not None},
        qpos=joint.qpos,
        effort=None if joint.effort is None else literal(float(joint.effort)),
        friction_force=None if joint.friction_force is None else literal(joint.friction_force),
        friction_origin=place,
        mimic=None
        if mimic is None
        else DraftMimic(
            mimic.source, literal(mimic.multiplier), literal(mimic.offset), origin.into(mimic.location, "mimic")
        ),
    )


def _numbers(joint: DescribedJoint) -> Iterator[tuple[str, float | None]]:
    """The numbers of a joint in its file, by field of `Joint`."""
    drive = joint.drive
    yield "friction", joint.friction
    # PhysX has only the drive's damping. A joint's own damping adds to the actuator's.
    yield "damping", (joint.damping + (0.0 if drive is None else drive.damping)) or None
    yield "armature", joint.armature
    yield "max_velocity", joint.velocity
    if drive is not None:
        yield "stiffness", drive.stiffness or None
        yield "force_limit", drive.force_limit
        yield "drive_target", drive.target


def _groups(shape: DescribedCollision, contact: ContactDefaults) -> Value | None:
    """The four collision integers of a shape; None: those of its link."""
    if shape.bits is None or contact.ignore is None:
        return None
    return literal((*shape.bits, *contact.ignore), "int64")


def _pose(pose: Pose7) -> Value | None:
    """None for the identity, compared bit by bit: a pose with -0.0 is passed to the engine."""
    return None if pose == _IDENTITY_NUMBERS and "-" not in repr(pose) else literal(pose)
