"""Audit of bodies: every property of single bodies and their shapes, and shape counts and masses of all as arrays."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.assets import axis_signs, visual_file
from scenecc.backends.sapien.audit.comparison import (
    AUDIT_CODE,
    BatchComparison,
    BodyLocation,
    ExpectedProperties,
    format_value,
    is_same,
    is_same_local_pose,
    pose_numbers,
)
from scenecc.backends.sapien.audit.reference import (
    MESH_TOLERANCE,
    PRECISION_CODE,
    EngineDefaults,
    ReferenceMeshes,
    body_mass,
    expected_friction,
    expected_mass,
    is_right_mass,
    part_counts,
    round_as_inverse,
    wrong_mass_code,
)
from scenecc.backends.sapien.engine import physx, render
from scenecc.backends.sapien.geometry import COLLISION_SHAPES, VISUAL_SHAPES
from scenecc.backends.sapien.properties import (
    BODY_PROPERTIES,
    COLLISION_GROUPS,
    RENDER_PROPERTIES,
    SHAPE_PROPERTIES,
    row_value,
    to_poses,
)
from scenecc.plan import ConvexMesh, ConvexParts, Heightfield, Mesh, MeshGeometry, Plane, TriangleMesh
from scenecc.plan.body import Texture, VisualMaterial
from scenecc.plan.geometry import RevolvedSolid
from scenecc.plan.properties import MAX_BODY_OFFSET

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from scenecc.backends.sapien.preparation import PreparedActor, PreparedEntity, StructureRows
    from scenecc.plan import BodyStructure, CollisionShape, Inertial, ScenePlan, Value, VisualShape


class ShapeAudit:
    """Reads the colliding shapes of bodies."""

    def __init__(
        self, plan: ScenePlan, defaults: EngineDefaults, meshes: ReferenceMeshes, comparison: BatchComparison
    ) -> None:
        self._defaults = defaults
        self._meshes = meshes
        self._comparison = comparison
        self._materials = plan.physical_materials
        self._frictions: dict[int, ExpectedProperties] = {}

    def look_at(self, structure: BodyStructure, body: Any, row: int, place: BodyLocation) -> None:
        """All shapes of a body."""
        found, counts = body.collision_shapes, part_counts(structure, row, self._meshes)
        if len(found) != sum(counts):
            self._comparison.tell(place, "collision_shapes", sum(counts), len(found))
            return
        start = 0
        for shape, count in zip(structure.collisions, counts, strict=True):
            where = BodyLocation(place.prepared, place.number, shape.origin, place.link)
            self._shape(structure, shape, found[start : start + count], row, where)
            start += count

    def _shape(
        self, structure: BodyStructure, shape: CollisionShape, parts: Sequence[Any], row: int, place: BodyLocation
    ) -> None:
        known = COLLISION_SHAPES[type(shape.geometry)]
        own = self._own(structure, shape, row)
        no_density = shape.density is None and isinstance(shape.geometry, Plane)
        defaults = self._defaults.plane if no_density else self._defaults.shape
        material = shape.material
        friction = self._defaults.friction if material is None else self._friction(int(material.row(row)), row)
        for number, part in enumerate(parts):
            if type(part) is not known.engine:
                self._comparison.tell(place, "type", known.engine.__name__, type(part).__name__)
                continue
            for name, size in known.expected(shape.geometry, row).items():
                self._comparison.hold(name, size, part, place)
            if isinstance(shape.geometry, MeshGeometry | RevolvedSolid | Heightfield):
                self._mesh(shape.geometry, part, number, row, place)
            compare_shape_pose(shape.pose, part, row, place, self._comparison, self._defaults)
            self._comparison.expect_but(defaults, own, part, place)
            self._comparison.expect(friction, part.physical_material, place)

    def _friction(self, index: int, row: int) -> ExpectedProperties:
        known = self._frictions.get(index)
        if known is None:
            material = self._materials[index]
            known = expected_friction(material.row(row))
            if not any(value.varies for value in material.values()):
                self._frictions[index] = known
        return known

    def _own(self, structure: BodyStructure, shape: CollisionShape, row: int) -> ExpectedProperties:
        said = {prop.get: row_value(value, row) for prop, value in SHAPE_PROPERTIES.said(shape)}
        groups = shape.collision_groups or structure.collision_groups
        if groups is not None:
            said[COLLISION_GROUPS.get] = groups.row(row).tolist()
        return said

    def _mesh(
        self,
        geometry: ConvexMesh | ConvexParts | TriangleMesh | RevolvedSolid | Heightfield,
        part: Any,
        number: int,
        row: int,
        place: BodyLocation,
    ) -> None:
        match geometry:
            case Heightfield():
                reference = self._meshes.terrain(geometry, row)
            case RevolvedSolid():
                reference = self._meshes.revolved_parts(geometry, row)[number]
            case ConvexMesh(file=file, scale=scale):
                reference = self._meshes.hull(int(file.row(row)), axis_signs(scale, row))
            case ConvexParts(file=file, scale=scale, coacd=coacd):
                reference = self._meshes.parts(int(file.row(row)), coacd, axis_signs(scale, row))[number]
            case TriangleMesh(file=file, sdf=sdf):
                reference = self._meshes.triangles(int(file.row(row)), sdf=sdf)
        for name in ("vertices", "triangles"):
            if not np.array_equal(getattr(reference, name), getattr(part, name)):
                self._comparison.tell(place, name, "those of the file", "others")
        if not isinstance(geometry, Heightfield) and not (isinstance(geometry, TriangleMesh) and not geometry.sdf):
            volume, weighed = self._meshes.cooked_volumes(reference)
            if not abs(weighed - volume) < MESH_TOLERANCE * volume:
                self._comparison.tell(place, "volume of the cooked mesh", format_value(volume), format_value(weighed))


def compare_shape_pose(
    pose: Value | None, part: Any, row: int, place: BodyLocation, comparison: BatchComparison, defaults: EngineDefaults
) -> None:
    """The pose of a shape, colliding or seen, in its body."""
    if pose is None:
        comparison.expect(defaults.pose, part, place)
    else:
        comparison.hold("local_pose", pose.row(row), part, place)


_TEXTURE_FIELDS = tuple(
    f"{name}_texture" for name in ("base_color", "normal", "roughness", "metallic", "emission", "transmission")
)

_SAMPLER_FIELDS = {
    "mipmap_levels": "mipmap_levels",
    "filter_mode": "filter_mode",
    "address_mode": "address_mode",
    "is_srgb": "srgb",
}
"""SAPIEN's names for how an image is sampled to the plan's."""

_SAMPLER_DEFAULTS = {"mipmap_levels": 1, "filter_mode": "linear", "address_mode": "repeat", "is_srgb": True}
"""What `sapien.render.RenderTexture2D` takes for an image of which nothing is said, by its signature."""

_DEFAULT_MATERIAL = VisualMaterial()


class VisualAudit:
    """Reads the render components of bodies."""

    def __init__(self, plan: ScenePlan, defaults: EngineDefaults, comparison: BatchComparison) -> None:
        self._plan = plan
        self._paths: dict[int, str] = {}
        self._defaults = defaults
        self._comparison = comparison

    def look_at(self, structure: BodyStructure, component: Any, row: int, place: BodyLocation) -> None:
        """A render component and all its shapes."""
        own = {prop.get: row_value(value, row) for prop, value in RENDER_PROPERTIES.said(structure)}
        self._comparison.expect_but(self._defaults.look, own, component, place)
        found = component.render_shapes
        if len(found) != len(structure.visuals):
            self._comparison.tell(place, "render_shapes", len(structure.visuals), len(found))
            return
        for shape, made in zip(structure.visuals, found, strict=True):
            self._shape(shape, made, row, place._replace(origin=shape.origin))

    def _shape(self, shape: VisualShape, found: Any, row: int, place: BodyLocation) -> None:
        known = VISUAL_SHAPES[type(shape.geometry)]
        if type(found) is not known.engine:
            self._comparison.tell(place, "type", known.engine.__name__, type(found).__name__)
            return
        expected = known.expected(shape.geometry, row) | {
            "name": shape.name or "",
            "front_face": _expected_front_face(shape, row),
        }
        if isinstance(shape.geometry, Mesh):
            expected["filename"] = self._path(int(shape.geometry.file.row(row)))
        self._compare(expected, found, place)
        compare_shape_pose(shape.pose, found, row, place, self._comparison, self._defaults)
        if known.surface is not None:
            part = found.parts[0]
            for name, wanted in known.surface(shape.geometry, row).items():
                actual = part.vertices if name == "vertices" else part.get_vertex_uv()
                if not is_same(wanted, actual):
                    self._comparison.tell(place, name, wanted.tolist(), actual.tolist())
        if shape.material is not None or not isinstance(shape.geometry, Mesh):
            material = (
                _DEFAULT_MATERIAL
                if shape.material is None
                else self._plan.visual_materials[int(shape.material.row(row))]
            )
            for part in found.parts:
                self._paint(material, part.material, row, place)

    def _paint(self, material: VisualMaterial, found: Any, row: int, place: BodyLocation) -> None:
        self._compare(self._defaults.paint | material.row(row), found, place)
        for name in _TEXTURE_FIELDS:
            texture, image = getattr(material, name), getattr(found, name)
            if texture is None or image is None:
                if texture is not image:
                    self._comparison.tell(place, name, _image_presence(texture), _image_presence(image))
                continue
            for key, wanted in expected_texture(self._plan, texture, row).items():
                if wanted != (actual := getattr(image, key)):
                    self._comparison.tell(place, f"{name}.{key}", wanted, actual)

    def _compare(self, expected: Mapping[str, Any], found: Any, place: BodyLocation) -> None:
        for name, value in expected.items():
            actual = getattr(found, name)
            if not is_same(value, actual):
                self._comparison.tell(place, name, format_value(value), format_value(actual))

    def _path(self, file: int) -> str:
        if file not in self._paths:
            self._paths[file] = str(visual_file(self._plan.files[file]))
        return self._paths[file]


def expected_texture(plan: ScenePlan, texture: Texture, row: int) -> dict[str, object]:
    """What can be read of an image, by the engine's names; SAPIEN's own where the plan says nothing."""
    said = {key: getattr(texture, name) for key, name in _SAMPLER_FIELDS.items()}
    own = {key: _SAMPLER_DEFAULTS[key] if value is None else value for key, value in said.items()}
    return {"filename": str(plan.files[int(texture.file.row(row))].path), **own}


def _image_presence(image: object) -> str:
    return "none" if image is None else "an image"


def _expected_front_face(shape: VisualShape, row: int) -> str:
    if shape.front_face is not None:
        return shape.front_face
    mirrored = isinstance(shape.geometry, Mesh) and math.prod(shape.geometry.scale.row(row).tolist()) < 0
    return "clockwise" if mirrored else "counterclockwise"


_COMPONENT_CLASSES = {
    "dynamic": physx.PhysxRigidDynamicComponent,
    "kinematic": physx.PhysxRigidDynamicComponent,
    "static": physx.PhysxRigidStaticComponent,
    "link": physx.PhysxArticulationLinkComponent,
}


class BodyAudit:
    """Reads bodies; differences go to the comparison."""

    def __init__(
        self,
        plan: ScenePlan,
        defaults: EngineDefaults,
        meshes: ReferenceMeshes,
        comparison: BatchComparison,
        *,
        rendered: bool,
    ) -> None:
        self._meshes = meshes
        self._defaults = defaults
        self._comparison = comparison
        self._rendered = rendered
        self._shapes = ShapeAudit(plan, defaults, meshes, comparison)
        self._visuals = VisualAudit(plan, defaults, comparison)

    def look_at(self, prepared: PreparedActor, structure: BodyStructure, number: int) -> None:
        """The body that is number `number` of its entity; its name, scene and pose are looked at elsewhere."""
        place = BodyLocation(prepared, number, structure.origin)
        self.components(
            prepared.entity.name, structure, prepared.objs[number].components, int(prepared.rows[number]), place
        )

    def components(
        self, name: str, structure: BodyStructure, components: list[Any], row: int, place: BodyLocation
    ) -> None:
        """What an entity has: a body of a name, in a row of the plan's values."""
        kinds = self._kinds(structure)
        if list(map(type, components)) != kinds:
            names = [[kind.__name__ for kind in some] for some in (kinds, map(type, components))]
            self._comparison.tell(place, "components", names[0], names[1])
            return
        for component in components:
            self._comparison.hold("component.name", name, component, place)
            if isinstance(component, render.RenderBodyComponent):
                self._visuals.look_at(structure, component, row, place)
            else:
                self._body(structure, component, row, place)

    def _kinds(self, structure: BodyStructure) -> list[Any]:
        visible: list[Any] = [render.RenderBodyComponent] if self._rendered and structure.visuals else []
        if structure.body_type == "none":
            return visible
        own = _COMPONENT_CLASSES[structure.body_type]
        # SAPIEN's builders make the look of an actor first, and that of a link last.
        return [own, *visible] if structure.body_type == "link" else [*visible, own]

    def _body(self, structure: BodyStructure, body: Any, row: int, place: BodyLocation) -> None:
        self._shapes.look_at(structure, body, row, place)
        if structure.body_type != "static":
            kinds = {"kinematic": self._defaults.kinematic, "link": self._defaults.link}
            defaults = kinds.get(structure.body_type, self._defaults.dynamic)
            own = {prop.get: row_value(value, row) for prop, value in BODY_PROPERTIES.said(structure)}
            self._comparison.expect_but(defaults, own, body, place)
            if structure.inertial is not None:
                self._given_mass(structure.inertial, body, row, place)
            else:
                self._mass(structure, body, row, place)

    def _given_mass(self, inertial: Inertial, body: Any, row: int, place: BodyLocation) -> None:
        self._stored(inertial.mass.row(row), inertial.inertia.row(row), body, place)
        if not is_same_local_pose(inertial.com.row(row), body.cmass_local_pose):
            self._comparison.tell(
                place, "cmass_local_pose", format_value(inertial.com.row(row)), format_value(body.cmass_local_pose)
            )

    def _mass(self, structure: BodyStructure, body: Any, row: int, place: BodyLocation) -> None:
        """The engine computes mass and inertia again, on a body of the shapes alone, and must weigh what these do."""
        reference = self._reference(structure, row)
        weight, mass = body_mass(structure, row, self._meshes), reference.mass
        if not is_right_mass(mass, weight):
            self._comparison.tell(place, "mass", format_value(weight), format_value(mass), wrong_mass_code(weight))
        wanted = reference.cmass_local_pose
        x, y, z = centre = pose_numbers(wanted)[:3]
        near = abs(x) <= MAX_BODY_OFFSET and abs(y) <= MAX_BODY_OFFSET and abs(z) <= MAX_BODY_OFFSET
        if structure.body_type != "kinematic" and not near:
            self._comparison.tell(
                place, "cmass_local_pose.p", "a place within 10 km", format_value(centre), PRECISION_CODE
            )
        if structure.mass is not None:
            given = structure.mass.row(row)
            self._stored(given, reference.inertia.astype(np.float64) * (given / mass), body, place)
        else:
            self._comparison.hold("mass", mass, body, place)
            self._comparison.hold("inertia", reference.inertia, body, place)
        # To the bit, unlike poses of the plan: the engine has computed and normalised both.
        found = body.cmass_local_pose
        if pose_numbers(found) != pose_numbers(wanted):
            self._comparison.tell(place, "cmass_local_pose", format_value(wanted), format_value(found))

    def _stored(self, mass: Any, inertia: Any, body: Any, place: BodyLocation) -> None:
        if body.mass != round_as_inverse(mass):
            self._comparison.tell(place, "mass", format_value(mass), format_value(body.mass))
        if (body.inertia != round_as_inverse(inertia)).any():
            self._comparison.tell(place, "inertia", format_value(inertia), format_value(body.inertia))

    def _reference(self, structure: BodyStructure, row: int) -> Any:
        body = physx.PhysxRigidDynamicComponent()
        for shape in structure.collisions:
            for part in self._meshes.fresh(shape.geometry, row):
                if shape.pose is not None:
                    part.set_local_pose(to_poses(shape.pose.row(row)[None])[0])
                if shape.density is not None:
                    part.set_density(float(shape.density.row(row)))
                body.attach(part)
        return body


_get_collision_shapes = physx.PhysxRigidBaseComponent.get_collision_shapes

_get_mass = physx.PhysxRigidBodyComponent.get_mass


def compare_bodies(
    prepared: PreparedEntity,
    part: StructureRows[BodyStructure],
    components: list[Any],
    meshes: ReferenceMeshes,
    comparison: BatchComparison,
    *,
    link: str | None = None,
) -> None:
    """Shape count and mass of all bodies of one structure, given their components."""

    def place(body: int) -> BodyLocation:
        return BodyLocation(prepared, int(part.numbers[body]), part.structure.origin, link)

    _compare_shape_counts(part, components, place, meshes, comparison)
    if part.structure.body_type != "static":
        _compare_masses(part, components, place, meshes, comparison)


def _compare_shape_counts(
    part: StructureRows[BodyStructure],
    components: list[Any],
    place: Callable[[int], BodyLocation],
    meshes: ReferenceMeshes,
    comparison: BatchComparison,
) -> None:
    # One body's shapes at a time: Python's objects for all of them would have to be made and kept at once.
    shapes: Iterator[Any] = map(_get_collision_shapes, components)
    found = np.fromiter(map(len, shapes), dtype=np.int64, count=len(components))
    if any(COLLISION_SHAPES[type(shape.geometry)].many for shape in part.structure.collisions):
        expected = np.array([sum(part_counts(part.structure, row, meshes)) for row in map(int, part.rows)])
    else:
        expected = np.full(len(found), len(part.structure.collisions))
    for i in np.flatnonzero(found != expected).tolist():
        comparison.tell(place(i), "collision_shapes", int(expected[i]), int(found[i]))


def _compare_masses(
    part: StructureRows[BodyStructure],
    components: list[Any],
    place: Callable[[int], BodyLocation],
    meshes: ReferenceMeshes,
    comparison: BatchComparison,
) -> None:
    found = np.array([*map(_get_mass, components)], dtype=np.float32)
    expected, exact = expected_mass(part.structure, part.rows, meshes)
    if exact:
        wrong = found != expected
    else:
        wrong = ~is_right_mass(found, expected)
        if len(expected) == 1:
            # One value of every size and density: then the engine's sum is one value, too.
            wrong |= found != found[0]
    for i in np.flatnonzero(wrong).tolist():
        wanted = np.broadcast_to(expected, found.shape)[i]
        comparison.tell(
            place(i),
            "mass",
            format_value(wanted),
            format_value(found[i]),
            AUDIT_CODE if exact else wrong_mass_code(wanted),
        )
