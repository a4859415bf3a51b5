"""What the engine should hold: properties of fresh objects, settings, meshes cooked again, and the mass of a body by
density and volume.

Defaults are read before a build sets anything, because the build itself is what the audit checks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from itertools import takewhile
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.assets import UNMIRRORED, AxisSigns, axis_signs, collision_file, decompose, mirror_mesh
from scenecc.backends.sapien.audit.comparison import AUDIT_CODE, EngineDifference, format_value, is_same, pose_numbers
from scenecc.backends.sapien.engine import physx, render, sapien
from scenecc.backends.sapien.geometry import COLLISION_SHAPES, make_revolved_parts
from scenecc.backends.sapien.properties import (
    ARTICULATION_PROPERTIES,
    BODY_PROPERTIES,
    COLLISION_GROUPS,
    JOINT_PROPERTIES,
    LINK_FIELDS,
    RENDER_PROPERTIES,
    SHAPE_PROPERTIES,
    PropertyTable,
    row_value,
    select_rows,
)
from scenecc.plan import ConvexMesh, ConvexParts, Cylinder, Heightfield, Plane, TriangleMesh
from scenecc.plan.body import VisualMaterial
from scenecc.plan.geometry import RevolvedSolid, Solid
from scenecc.plan.properties import DEFAULT_DENSITY, FLOAT32_MAX, round_to_float32

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterable, Iterator

    from numpy.typing import NDArray

    from scenecc.backends.sapien.audit.comparison import ExpectedProperties
    from scenecc.plan import BodyStructure, CoacdParams, CollisionGeometry, CollisionShape, MeshGeometry, ScenePlan
    from scenecc.plan.body import Friction
    from scenecc.plan.scene import Physics


PHYSICAL_MATERIAL_FIELDS = ("static_friction", "dynamic_friction", "restitution")

RENDER_MATERIAL_FIELDS = tuple(f.name for f in fields(VisualMaterial) if not f.name.endswith("_texture"))

DEFAULT_TIMESTEP = 0.01
"""SAPIEN's [s]."""

_PLAN_NAMES = {"subgridSize": "subgrid_size"}
"""SAPIEN's names of settings to the plan's, where they differ."""


@dataclass(frozen=True, slots=True)
class EngineDefaults:
    """Properties of fresh objects, by the engine's names.

    Attributes:
        material: the process-wide `PhysxMaterial`.
        friction: properties of the material of shapes that name none.
        shape, plane: of a collision shape of a body without collision groups of its own.
        pose: of a shape.
        dynamic, kinematic: of a rigid body.
        link, joint, articulation: of these.
        look, paint: of a render body and of a `RenderMaterial`; empty where nothing renders.
        scene, sdf: the settings of a scene's system, and those by which distance fields are cooked.
        timestep: of a scene [s].
    """

    material: Any
    friction: ExpectedProperties
    shape: ExpectedProperties
    plane: ExpectedProperties
    pose: ExpectedProperties
    dynamic: ExpectedProperties
    kinematic: ExpectedProperties
    link: ExpectedProperties
    joint: ExpectedProperties
    articulation: ExpectedProperties
    look: ExpectedProperties
    paint: ExpectedProperties
    scene: ExpectedProperties
    sdf: ExpectedProperties
    timestep: float = DEFAULT_TIMESTEP

    def with_settings(self, physics: Physics) -> EngineDefaults:
        """These where the plan's settings say nothing, and what they say where they do."""
        friction = self.friction if physics.default_material is None else expected_friction(physics.default_material)
        return replace(
            self,
            friction=friction,
            shape=_overlay(self.shape, physics),
            plane=_overlay(self.plane, physics),
            dynamic=_overlay(self.dynamic, physics),
            kinematic=_overlay(self.kinematic, physics),
            articulation=_overlay(self.articulation, physics),
            scene=_overlay(self.scene, physics),
            sdf=self.sdf if physics.sdf is None else _overlay(self.sdf, physics.sdf),
            timestep=self.timestep if physics.timestep is None else round_to_float32(physics.timestep),
        )


def read_defaults(*, rendered: bool) -> EngineDefaults:
    """Reads them off objects that nothing else has touched, under the settings that the process has now."""
    material = physx.get_default_material()
    fresh = physx.PhysxCollisionShapeSphere(1.0, material)
    shape = _read_table(SHAPE_PROPERTIES, fresh) | _read_properties(fresh, [COLLISION_GROUPS.get])
    body = _read_table(BODY_PROPERTIES, physx.PhysxRigidDynamicComponent())
    link, joint, articulation = _articulation_defaults()
    scene, sdf = physx.get_scene_config(), physx.get_sdf_config()
    return EngineDefaults(
        material=material,
        friction=_read_properties(material, PHYSICAL_MATERIAL_FIELDS),
        shape=shape,
        plane=shape | {"density": 0.0},
        pose={"local_pose": pose_numbers(fresh.local_pose)},
        dynamic=body | {"kinematic": False},
        kinematic=body | {"kinematic": True},
        link=link,
        joint=joint,
        articulation=articulation,
        look=_read_table(RENDER_PROPERTIES, render.RenderBodyComponent()) if rendered else {},
        paint=_read_properties(render.RenderMaterial(), RENDER_MATERIAL_FIELDS) if rendered else {},
        scene=_read_properties(scene, setting_names(scene)),
        sdf=_read_properties(sdf, setting_names(sdf)),
    )


def _articulation_defaults() -> tuple[ExpectedProperties, ExpectedProperties, ExpectedProperties]:
    """Of links, of joints and of a whole, off two links, one of which hangs on the other."""
    links = [physx.PhysxArticulationLinkComponent(None)]
    links.append(physx.PhysxArticulationLinkComponent(links[0]))
    entities = [sapien.Entity() for _ in links]
    for entity, link in zip(entities, links, strict=True):
        entity.add_component(link)
    joint = links[1].get_joint()
    joint.set_type("revolute")
    articulation = links[0].get_articulation()
    return (
        _read_properties(links[0], LINK_FIELDS),
        _read_table(JOINT_PROPERTIES, joint),
        _read_table(ARTICULATION_PROPERTIES, articulation),
    )


def expected_friction(material: Friction) -> ExpectedProperties:
    """What the engine must hold of a material of the plan."""
    return {name: round_to_float32(getattr(material, name)) for name in PHYSICAL_MATERIAL_FIELDS}


def setting_names(config: object) -> list[str]:
    """The names of everything that can be read of one of SAPIEN's configuration objects."""
    return [name for name, kind in vars(type(config)).items() if isinstance(kind, property)]


def _overlay(present: ExpectedProperties, settings: object) -> ExpectedProperties:
    found = {name: getattr(settings, _PLAN_NAMES.get(name, name), None) for name in present}
    return present | {
        name: round_to_float32(value) if isinstance(value, float) else value
        for name, value in found.items()
        if value is not None
    }


def _read_table(properties: PropertyTable, engine: object) -> ExpectedProperties:
    return _read_properties(engine, [prop.get for prop in properties.by_field.values()])


def _read_properties(engine: object, names: Iterable[str]) -> ExpectedProperties:
    return {name: getattr(engine, name) for name in names}


def scene_differences(defaults: EngineDefaults, scene: Any) -> Iterator[EngineDifference]:
    """What differs in the time step and in the configuration that the scene's system took over."""
    yield from _config_differences(defaults.scene, scene.physx_system.config)
    if not is_same(defaults.timestep, scene.timestep):
        yield EngineDifference("timestep", format_value(defaults.timestep), format_value(scene.timestep))


def cooking_differences(defaults: EngineDefaults) -> Iterator[EngineDifference]:
    """What differs in the settings by which distance fields were cooked; no shape tells them."""
    yield from _config_differences(defaults.sdf, physx.get_sdf_config())


def _config_differences(expected: ExpectedProperties, config: Any) -> Iterator[EngineDifference]:
    for name, value in expected.items():
        if not is_same(value, found := getattr(config, name)):
            yield EngineDifference(name, format_value(value), format_value(found))


_UNIT_SCALE = (1.0, 1.0, 1.0)


class ReferenceMeshes:
    """Fresh shapes of the files that a plan uses, unscaled.

    Vertices and volumes are read from shapes made here and not by the builder, so that what the
    builder made can be held against them.
    """

    def __init__(self, plan: ScenePlan, material: Any) -> None:
        self._plan = plan
        self._material = material
        self._known: dict[Hashable, Any] = {}

    def hull(self, file: int, signs: AxisSigns = UNMIRRORED) -> Any:
        """The convex hull of a file, as `signs` mirror it."""
        path = self._hull_path(file, signs)
        make = physx.PhysxCollisionShapeConvexMesh
        return self._once(("hull", path), lambda: make(path, _UNIT_SCALE, self._material))

    def parts(self, file: int, params: CoacdParams | None, signs: AxisSigns = UNMIRRORED) -> list[Any]:
        """The convex parts of a file, as `signs` mirror them."""
        path = self._parts_path(file, params, signs)
        load = physx.PhysxCollisionShapeConvexMesh.load_multiple
        return self._once(("parts", path), lambda: load(path, _UNIT_SCALE, self._material))

    def triangles(self, file: int, *, sdf: bool) -> Any:
        """The triangles of a file. `sdf` as the plan has it: what PhysX has cooked of the file is found again."""
        make = physx.PhysxCollisionShapeTriangleMesh
        key = ("triangles", file, sdf)
        return self._once(key, lambda: make(self._path(file), _UNIT_SCALE, self._material, sdf))

    def revolved_parts(self, geometry: RevolvedSolid, row: int) -> list[Any]:
        """The convex parts of a solid of revolution, of unit size."""
        profile, _ = geometry.unit_profile(*geometry.sizes(row))
        return self._once(("revolved", profile), lambda: make_revolved_parts(profile, _UNIT_SCALE, self._material))

    def terrain(self, geometry: Heightfield, row: int) -> Any:
        """The triangles of a heightfield."""
        key = ("terrain", geometry.size.row(row).tobytes(), geometry.heights)
        return self._once(key, lambda: self.fresh(geometry, row)[0])

    def fresh(self, geometry: CollisionGeometry, row: int) -> list[Any]:
        """New shapes of an entity's row, of the engine's own density and without a pose."""
        shape = COLLISION_SHAPES[type(geometry)]
        sizes = shape.expected(geometry, row).values()
        match geometry:
            case ConvexMesh(file=file, scale=scale):
                return [
                    shape.engine(self._hull_path(int(file.row(row)), axis_signs(scale, row)), *sizes, self._material)
                ]
            case TriangleMesh(file=file, sdf=sdf):
                return [shape.engine(self._path(int(file.row(row))), *sizes, self._material, sdf)]
            case ConvexParts(file=file, scale=scale, coacd=coacd):
                path = self._parts_path(int(file.row(row)), coacd, axis_signs(scale, row))
                return shape.engine.load_multiple(path, *sizes, self._material)
            case Heightfield():
                vertices, triangles, *_ = geometry.surface(row)
                return [shape.engine(vertices, triangles, *sizes, self._material)]
            case RevolvedSolid():
                profile, scale = geometry.unit_profile(*geometry.sizes(row))
                return make_revolved_parts(profile, scale, self._material)
            case _:
                return [shape.engine(*sizes, self._material)]

    def hull_volume(self, file: int, signs: AxisSigns) -> float:
        """[m³] of the hull of a file, mirrored and unscaled."""
        return self.cooked_volumes(self.hull(file, signs))[1]

    def parts_volume(self, file: int, params: CoacdParams | None, signs: AxisSigns) -> float:
        """[m³] of all convex parts of a file, mirrored and unscaled."""
        return sum(self.cooked_volumes(part)[1] for part in self.parts(file, params, signs))

    def triangle_volume(self, file: int) -> float:
        """[m³] that the triangles of a file, cooked with a field, enclose unscaled, whichever way they face."""
        return self.cooked_volumes(self.triangles(file, sdf=True))[1]

    def cooked_volumes(self, shape: Any) -> tuple[float, float]:
        """What one of these shapes encloses and what the engine weighs it by [m³]; 0 where its faces look inwards."""

        def weigh() -> tuple[float, float]:
            """Both volumes [m³]; the first of a hull is below 0 where its faces look inwards."""
            volume = enclosed_volume(shape)
            if not isinstance(shape, physx.PhysxCollisionShapeConvexMesh):
                volume = abs(volume)
            if not volume > 0:
                return volume, 0.0
            # The engine gives no body less than a milligram: this one weighs a kilogram, or the mesh is wrong.
            shape.set_density(1 / volume)
            body = physx.PhysxRigidDynamicComponent()
            body.attach(shape)
            return volume, body.mass * volume

        return self._once(("volumes", id(shape)), weigh)

    def _path(self, file: int) -> str:
        return str(collision_file(self._plan.files[file]))

    def _hull_path(self, file: int, signs: AxisSigns) -> str:
        return self._once(("hull path", file, signs), lambda: mirror_mesh(self._path(file), signs, parts=False))

    def _parts_path(self, file: int, params: CoacdParams | None, signs: AxisSigns) -> str:
        def path() -> str:
            whole = self._plan.files[file]
            return mirror_mesh(
                str(collision_file(whole) if params is None else decompose(whole, params)), signs, parts=True
            )

        return self._once(("path", file, params, signs), path)

    def _once(self, key: Hashable, make: Callable[[], Any]) -> Any:
        if key not in self._known:
            self._known[key] = make()
        return self._known[key]


def enclosed_volume(shape: Any) -> float:
    """[m³] inside a closed mesh: the sum of signed tetrahedra from a vertex to each triangle."""
    vertices: NDArray[np.float64] = shape.vertices.astype(np.float64)
    # Written out: `np.cross` takes seven times as long, and every build comes here.
    x, y, z = (vertices - vertices[0]).T[:, shape.triangles.T]
    twice_areas = (y[1] * z[2] - y[2] * z[1], z[1] * x[2] - z[2] * x[1], x[1] * y[2] - x[2] * y[1])
    return float((x[0] * twice_areas[0] + y[0] * twice_areas[1] + z[0] * twice_areas[2]).sum() / 6)


MINIMUM_MASS = 1e-6
"""Mass [kg] and moments [kg·m²] that SAPIEN gives where the shapes' are less."""

PRECISION_CODE = "SC512"
"""The code of a mass, or of a centre of mass, that single precision does not hold."""

CYLINDER_AREA_RATIO = 32 / (2 * math.pi) * math.sin(2 * math.pi / 32)
"""Area of the 32-sided prism that PhysX has for a cylinder, by that of the circle around it."""

MASS_TOLERANCE = 1e-4
"""Between an engine that adds in float32 and this."""

MESH_TOLERANCE = 1e-2
"""Between the volume by which PhysX weighs a hull and that of its triangles: its polygons are not quite plane."""


def round_as_inverse(value: NDArray[np.float64]) -> NDArray[np.float32]:
    """What PhysX gives back of a mass or a moment of inertia: it keeps the inverse, in float32."""
    with np.errstate(divide="ignore", over="ignore"):
        return np.float32(1) / (np.float32(1) / value.astype(np.float32))


def expected_mass(
    structure: BodyStructure, rows: NDArray[np.intp], meshes: ReferenceMeshes
) -> tuple[NDArray[Any], bool]:
    """The mass [kg] a row, or one for all rows, and whether it must be met to the bit."""
    given = structure.inertial.mass if structure.inertial is not None else structure.mass
    if given is not None:
        return round_as_inverse(select_rows(given, rows)), True
    return shapes_mass(structure, rows, meshes), False


def shapes_mass(structure: BodyStructure, rows: NDArray[np.intp], meshes: ReferenceMeshes) -> NDArray[np.float64]:
    """What the shapes weigh [kg] a row, or in all rows, by their densities and volumes."""
    total = np.zeros(1)
    for shape in _weighed_shapes(structure):
        density = DEFAULT_DENSITY if shape.density is None else select_rows(shape.density, rows)
        total = total + density * shape_volume(shape.geometry, rows, meshes)
    if structure.body_type == "kinematic":
        # It is moved by nobody's force, so that nobody minds the milligram.
        return np.maximum(total, MINIMUM_MASS)
    return np.where(total == 0, MINIMUM_MASS, total)


def body_mass(structure: BodyStructure, row: int, meshes: ReferenceMeshes) -> float:
    """As `shapes_mass`, for one row: in plain numbers, since arrays of one number take most of an audit's time."""
    total = 0.0
    for shape in _weighed_shapes(structure):
        density = DEFAULT_DENSITY if shape.density is None else row_value(shape.density, row)
        total += density * _row_volume(shape.geometry, row, meshes)
    return max(total, MINIMUM_MASS) if structure.body_type == "kinematic" else total or MINIMUM_MASS


def _weighed_shapes(structure: BodyStructure) -> Iterator[CollisionShape]:
    """SAPIEN weighs a body anew with each shape; PhysX cannot, once one of them is endless."""
    return takewhile(lambda shape: not isinstance(shape.geometry, Plane), structure.collisions)


def is_right_mass(found: Any, expected: Any) -> Any:
    """Whether masses, numbers or arrays of them, are those that the shapes give; what is no number is not."""
    return abs(found - expected) <= MASS_TOLERANCE * expected


def wrong_mass_code(expected: float) -> str:
    """The code of a mass that differs: what a mesh weighs is known only now, of all else a check has told it."""
    return "SC511" if expected < MINIMUM_MASS else AUDIT_CODE if expected <= FLOAT32_MAX else PRECISION_CODE


def shape_volume(geometry: CollisionGeometry, rows: NDArray[np.intp], meshes: ReferenceMeshes) -> NDArray[np.float64]:
    """[m³] a row, or one for all rows. PhysX has none of planes and of triangle meshes without a distance field."""
    match geometry:
        case Solid():
            sizes = [size for value in geometry.values for size in np.atleast_2d(select_rows(value, rows).T)]
            return geometry.volume(*sizes) * (CYLINDER_AREA_RATIO if isinstance(geometry, Cylinder) else 1)
        case ConvexMesh():
            return _scaled_volume(geometry, rows, meshes.hull_volume)
        case ConvexParts():
            return _scaled_volume(geometry, rows, lambda file, signs: meshes.parts_volume(file, geometry.coacd, signs))
        case TriangleMesh(sdf=True):
            return _scaled_volume(geometry, rows, lambda file, _: meshes.triangle_volume(file))
        case Plane() | TriangleMesh() | Heightfield():
            return np.zeros(1)


def _row_volume(geometry: CollisionGeometry, row: int, meshes: ReferenceMeshes) -> float:
    if not isinstance(geometry, Solid):
        return float(shape_volume(geometry, np.array([row]), meshes)[0])
    sizes: list[float] = []
    for value in geometry.values:
        size = row_value(value, row)
        sizes.extend([size] if isinstance(size, int | float) else size)
    return geometry.volume(*sizes) * (CYLINDER_AREA_RATIO if isinstance(geometry, Cylinder) else 1)


def _scaled_volume(
    geometry: MeshGeometry, rows: NDArray[np.intp], unscaled: Callable[[int, AxisSigns], float]
) -> NDArray[np.float64]:
    files, scales = select_rows(geometry.file, rows), select_rows(geometry.scale, rows)
    count = max(len(files), len(scales))
    signs: list[AxisSigns] = [tuple(row) for row in np.broadcast_to(np.sign(scales), (count, 3)).tolist()]
    meshes = list(zip(np.broadcast_to(files, count).tolist(), signs, strict=True))
    of_mesh = {mesh: unscaled(*mesh) for mesh in dict.fromkeys(meshes)}
    return np.array([of_mesh[mesh] for mesh in meshes]) * np.abs(np.prod(scales, axis=1))


def part_counts(structure: BodyStructure, row: int, meshes: ReferenceMeshes) -> list[int]:
    """How many shapes of the engine each shape of the plan is, in an entity's row."""
    return [_part_count(shape.geometry, row, meshes) for shape in structure.collisions]


def _part_count(geometry: CollisionGeometry, row: int, meshes: ReferenceMeshes) -> int:
    match geometry:
        case ConvexParts(file=file, coacd=coacd):
            return len(meshes.parts(int(file.row(row)), coacd))
        case RevolvedSolid():
            return len(meshes.revolved_parts(geometry, row))
        case _:
            return 1
