"""Robots from files: the file's own values, and the scene's overrides by link or joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc import plan
from scenecc.diagnostics.messages import cut, nearest
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.lower.articulations.drafts import ArticulationDraft, ContactDefaults, DraftJoint, DraftLink, DraftMimic
from scenecc.lower.materials import LoweredMaterial, MaterialChoice
from scenecc.lower.poses import lower_limits
from scenecc.lower.references import select_per_scene
from scenecc.lower.shapes import coacd_params, count_heights
from scenecc.plan import CollisionShape, Inertial, Value, VisualShape, literal
from scenecc.plan.body import AssetFile, PhysicalMaterial, Texture, VisualMaterial
from scenecc.plan.geometry import SOLIDS, Solid
from scenecc.plan.properties import DEFAULT_DENSITY
from scenecc.robots import description as robots
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.references import NamePattern, compile_name_pattern

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Location, Origin
    from scenecc.geometry.rotations import Pose7
    from scenecc.lower.articulations.drafts import Layer
    from scenecc.lower.field_types import FieldType
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
        self, robot: DescribedRobot, keys: Any, file: Value, origin: Origin, fields: FieldLowerer
    ) -> ArticulationDraft:
        """A robot as a draft.

        Args:
            robot: as its file describes it.
            keys: of the entity: how its meshes collide.
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
            """Material and density: the scene's values replace the file's."""
            collisions = tuple(self._collision(shape, meshes, contact, origin, fields) for shape in link.collisions)
            return collisions, tuple(self._visual(shape, contact, origin, fields) for shape in link.visuals)

        weight, inertial, mass = link.inertial, None, None
        if weight is not None and weight.inertia is not None:
            inertial = Inertial(literal(weight.mass), literal(weight.com), literal(weight.inertia))
        elif weight is not None:
            mass = literal(weight.mass)
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
            material, dense = self._several(surface, described, density, fields)
        else:
            material, dense = surface.physical, surface.density
        shape_density = contact.default.density if dense is None else dense
        return CollisionShape(
            geometry=self._colliding(shape.geometry, meshes, place, fields),
            pose=_pose(shape.pose),
            material=described if material is None else material,
            density=density if shape_density is None else shape_density,
            patch_radius=contact.patch_radius,
            min_patch_radius=contact.min_patch_radius,
            collision_groups=_groups(shape, contact),
            origin=place,
        )

    def _several(
        self, surfaces: MaterialChoice, described: Value | None, density: Value | None, fields: FieldLowerer
    ) -> tuple[Value | None, Value | None]:
        """Material and density where the scenes have one of several materials."""
        rows = len(fields.scenes)
        material = dense = None
        if described is not None or any(surface.physical is not None for surface in surfaces.each):
            default = described or self._materials.default()
            material = select_per_scene([surface.physical or default for surface in surfaces.each], surfaces.pick, rows)
        if any(surface.density is not None for surface in surfaces.each):
            default = density or literal(DEFAULT_DENSITY)
            dense = select_per_scene([surface.density or default for surface in surfaces.each], surfaces.pick, rows)
        return material, dense

    def _colliding(self, geometry: robots.Geometry, meshes: _MeshCollision, place: Origin, fields: FieldLowerer) -> Any:
        if isinstance(geometry, robots.MeshGeometry):
            file = self._mesh_file(geometry, place)
            scale = self._tables.size(geometry.scale)
            parts = meshes.parts if geometry.parts is None else geometry.parts
            return plan.ConvexParts(file, scale, meshes.coacd) if parts else plan.ConvexMesh(file, scale)
        if isinstance(geometry, robots.PlaneGeometry):
            return plan.Plane()
        return self._other(geometry, place, fields)

    def _visual(
        self, shape: DescribedVisual, contact: ContactDefaults, origin: Origin, fields: FieldLowerer
    ) -> VisualShape:
        geometry, place = shape.geometry, origin.into(shape.location)
        if isinstance(geometry, robots.MeshGeometry):
            made: Any = plan.Mesh(self._mesh_file(geometry, place), literal(geometry.scale))
        elif isinstance(geometry, robots.PlaneGeometry):
            made = plan.VisualPlane(literal(geometry.half_size or (10.0, 10.0)))
        else:
            made = self._other(geometry, place, fields)
        material = self._seen(shape, contact, origin, fields)
        return VisualShape(made, _pose(shape.pose), material, shape.name or None, None, place)

    def _seen(
        self, shape: DescribedVisual, contact: ContactDefaults, origin: Origin, fields: FieldLowerer
    ) -> Value | None:
        described = None if shape.look is None else self._look(shape.look, shape.location, origin)
        surface = contact.default.surface
        if isinstance(surface, LoweredMaterial):
            visual = surface.visual or described
            return None if visual is None else self._tables.visual_materials.value(visual)
        visuals = [one.visual or described or VisualMaterial() for one in surface.each]
        values = [self._tables.visual_materials.value(visual) for visual in visuals]
        return select_per_scene(values, surface.pick, len(fields.scenes))

    def _look(self, look: DescribedMaterial, location: Location, origin: Origin) -> VisualMaterial:
        known = self._looks.get(id(look))
        if known is not None:
            return known[1]
        texture = None
        if look.texture is not None:
            file = AssetFile(look.texture_uri or str(look.texture), look.texture)
            texture = Texture(self._file(file, origin.into(location)))
        numbers: dict[str, Any] = {
            name: literal(item)
            for name in ("base_color", "emission", "specular", "roughness", "metallic")
            if (item := getattr(look, name)) is not None
        }
        made = VisualMaterial(**numbers, base_color_texture=texture)
        # Kept, so that its id stays its own.
        self._looks[id(look)] = look, made
        return made

    def _other(
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
    """How the meshes of an entity collide that say nothing of it themselves.

    Attributes:
        parts: whether their connected parts collide one by one.
        coacd: how these are cut; None: they are the file's own.
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
        mimic=None
        if mimic is None
        else DraftMimic(
            mimic.source, literal(mimic.multiplier), literal(mimic.offset), origin.into(mimic.location, "mimic")
        ),
    )


def _numbers(joint: DescribedJoint) -> Iterator[tuple[str, float | None]]:
    """What a file says of a joint, by field of `Joint`."""
    drive = joint.drive
    yield "friction", joint.friction
    # PhysX has one damping, of the drive; one that the joint has itself acts besides the actuator's.
    yield "damping", (joint.damping + (0.0 if drive is None else drive.damping)) or None
    yield "armature", joint.armature
    yield "max_velocity", joint.velocity
    if drive is not None:
        yield "stiffness", drive.stiffness or None
        yield "force_limit", drive.force_limit
        yield "drive_target", drive.target


def _groups(shape: DescribedCollision, contact: ContactDefaults) -> Value | None:
    """The four integers of a shape; None: those of its link."""
    if shape.bits is None or contact.ignore is None:
        return None
    return literal((*shape.bits, *contact.ignore), "int64")


def _pose(pose: Pose7) -> Value | None:
    """None for the identity. To the bit: a pose with -0.0 is passed to the engine."""
    return None if pose == _IDENTITY_NUMBERS and "-" not in repr(pose) else literal(pose)


_SHOWN = 12
"""How many names a hint lists."""

MOST_MATCHING = 1_000_000_000
"""Steps that all patterns of a document may take, a few seconds; each pair of a pattern and a name counts once.

A stranger's file could name ten thousand patterns, and a robot with names of any length.
"""

_PAIR_STEPS = 5000
"""Steps that take as long as everything else that is done for a pair."""


class PatternMatcher:
    """Matches names with the patterns of a document, each pair once, and no more than `MOST_MATCHING`."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], bool] = {}
        self._patterns: dict[str, NamePattern] = {}
        self._left = MOST_MATCHING

    @property
    def exhausted(self) -> bool:
        """Whether there is more to be matched than is: what is left over matches nothing."""
        return self._left < 0

    def matches(self, pattern: str, name: str) -> bool:
        """Whether a pattern matches a whole name."""
        found = self._found.get((pattern, name))
        if found is None:
            read = self._patterns.get(pattern)
            if read is None:
                read = self._patterns[pattern] = compile_name_pattern(pattern)
            self._left -= _PAIR_STEPS + read.steps(len(name))
            found = self._found[pattern, name] = self._left >= 0 and read.matches(name)
        return found


class PatternOverrides:
    """The `links`, `joints` and `drives` of an articulation.

    Args:
        entity: the articulation as written.
        origin: of it.
        matching: of the document.
        sink: takes the diagnostics.
    """

    def __init__(self, entity: Any, origin: Origin, matching: PatternMatcher, sink: Sink) -> None:
        self._sink = sink
        self._matching = matching
        self._origin = origin
        self._maps: dict[str, list[tuple[str, Layer]]] = {
            section: [
                (pattern, (keys, origin.child(section, pattern)))
                for pattern, keys in getattr(entity, section).items()
                if not pattern.startswith(NOTE_PREFIX)
            ]
            for section in ("links", "joints", "drives")
        }

    def layers(self, section: str, name: str) -> tuple[Layer, ...]:
        """The overrides of a link or a joint; later ones take precedence."""
        if self._matching.exhausted:
            return ()
        matches = self._matching.matches
        return tuple(layer for pattern, layer in self._maps[section] if matches(pattern, name))

    def check(self, drafts: Sequence[ArticulationDraft]) -> None:
        """Reports every pattern that matches nothing in any of the articulations that the entity may be."""
        links = _distinct(link.name for draft in drafts for link in draft.links)
        joints = [link.joint for draft in drafts for link in draft.links if link.joint is not None]
        moving = _distinct(joint.name for joint in joints if joint.moves)
        fixed = _distinct(joint.name for joint in joints if not joint.moves)
        for section, names in (("links", links), ("joints", moving), ("drives", moving)):
            for pattern, (_, origin) in self._maps[section]:
                if self._any(pattern, names):
                    continue
                what = "link" if section == "links" else "joint that moves"
                still = section != "links" and self._any(pattern, fixed)
                if self._matching.exhausted:
                    self._too_many()
                    return
                self._nothing(pattern, what, names, still=still, origin=origin)

    def _any(self, pattern: str, names: Sequence[str]) -> bool:
        return any(self._matching.matches(pattern, name) for name in names)

    def _too_many(self) -> None:
        message = f"matching the patterns with the names of links and joints takes more than {MOST_MATCHING} steps"
        self._sink.report("SC323", message, self._origin, at="key", hint="use one pattern for several links or joints")

    def _nothing(self, pattern: str, what: str, names: Sequence[str], *, still: bool, origin: Origin) -> None:
        message = f"`{cut(pattern)}` matches no {what}"
        if still:
            message += ": it matches only fixed joints"
        self._sink.report("SC324", message, origin, at="key", hint=names_hint(names, pattern))


def names_hint(names: Sequence[str], wrong: str) -> str:
    """A hint with the names that there are, the one that was probably meant first."""
    known = [name for name in names if name]
    if not known:
        return "none of them has a name"
    near = nearest(wrong, known)
    shown = ", ".join(f"`{cut(name)}`" for name in known[:_SHOWN])
    rest = f" and {len(known) - _SHOWN} more" if len(known) > _SHOWN else ""
    return (f"did you mean `{near}`? " if near is not None else "") + f"there are {shown}{rest}"


def nearest_override(layers: Sequence[Layer], *keys: str) -> Layer | None:
    """The nearest of some layers that has a key, or one of several."""
    for layer in reversed(layers):
        if any(getattr(layer[0], key, None) is not None for key in keys):
            return layer
    return None


def _distinct(names: Any) -> list[str]:
    unique: Mapping[str, None] = dict.fromkeys(names)
    return list(unique)


class OverrideValues:
    """The values of one articulation.

    A value of a pattern is drawn once, and all links or joints that match share it.

    Args:
        materials: of the document.
        fields: of the entity.
    """

    def __init__(self, materials: MaterialLowerer, fields: FieldLowerer) -> None:
        self.fields = fields
        self._materials = materials
        self._known: dict[tuple[int, str], Any] = {}

    def value(self, layers: Sequence[Layer], key: str, kind: FieldType, *, reset: bool | None = None) -> Value | None:
        """The value of a key in the nearest layer that has it; None if none has."""
        layer = nearest_override(layers, key)
        return None if layer is None else self.of(layer, key, kind, reset=reset)

    def of(self, layer: Layer, key: str, kind: FieldType, *, reset: bool | None = None) -> Value:
        """The value of a key in a layer that has it."""
        keys, origin = layer
        found = self._known.get((id(keys), key))
        if found is None:
            found = self.fields.value(getattr(keys, key), kind, origin, key, reset=reset)
            self._known[id(keys), key] = found
        return found

    def limits(self, layer: Layer) -> Value | None:
        """The limits of a layer; None if it has none."""
        keys, origin = layer
        found = self._known.get((id(keys), "limits"))
        if found is None:
            found = self._known[id(keys), "limits"] = lower_limits(keys, origin, self.fields)
        return found

    def surface(self, layers: Sequence[Layer]) -> LoweredMaterial | MaterialChoice | None:
        """The material of the nearest layer that has one."""
        layer = nearest_override(layers, "material")
        if layer is None:
            return None
        keys, origin = layer
        found = self._known.get((id(keys), "material"))
        if found is None:
            found = self._known[id(keys), "material"] = self._materials.surface(keys.material, origin, self.fields)
        return found
