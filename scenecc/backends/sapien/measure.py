"""Reads a snapshot of the engine's values (see `scenecc.plan.measured`), and poses during a simulation."""

from __future__ import annotations

from hashlib import sha256
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.backends.sapien.audit.masses import CookedMeshes, part_count
from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.geometry import COLLISION_SHAPES
from scenecc.backends.sapien.properties import DRIVE_DEFAULTS, JOINT_PROPERTIES
from scenecc.plan import Heightfield, MeshGeometry
from scenecc.plan.articulation import ArticulationStructure
from scenecc.plan.geometry import Solid
from scenecc.plan.schema import type_name
from scenecc.plan.snapshot import (
    EngineSnapshot,
    MeasuredBody,
    MeasuredEntity,
    MeasuredJoint,
    MeasuredMass,
    MeasuredMesh,
    MeasuredScene,
    MeasuredShape,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien.batch import SceneBatch
    from scenecc.geometry.rotations import Pose7
    from scenecc.plan import BodyStructure, CollisionGeometry, Entity, Joint

_GEOMETRIES: Final = {
    shape.engine: geometry
    for geometry, shape in COLLISION_SHAPES.items()
    if not shape.many and geometry is not Heightfield
}
"""SAPIEN's shapes → geometry of a plan. Convex parts are convex meshes, terrain is a triangle mesh."""

_JOINT_NUMBERS: Final = (*JOINT_PROPERTIES.by_field, *DRIVE_DEFAULTS)
"""Fields of `MeasuredJoint`. SAPIEN uses the same names."""


def read_live_geometry(shape: Any) -> tuple[type[CollisionGeometry], tuple[float, ...]]:
    """Returns the geometry type of a live collision shape in a plan, and the values of its fields."""
    geometry = _GEOMETRIES[type(shape)]
    names = geometry.__slots__ if issubclass(geometry, Solid) else ()
    return geometry, tuple(number for name in names for number in np.ravel(getattr(shape, name)).tolist())


def measure_bodies(batch: SceneBatch) -> EngineSnapshot:
    """Returns all values that the engine holds for the bodies in a batch. Call it before the first step.

    Raises:
        RuntimeError: the batch is closed.
    """
    reader = _BatchReader(batch)
    scenes = zip(batch.scene_idxs, batch.scenes, strict=True)
    return EngineSnapshot(tuple(reader.scene(index, scene) for index, scene in scenes))


class _BatchReader:
    """Reads bodies. Keeps shared meshes only once."""

    def __init__(self, batch: SceneBatch) -> None:
        self._batch = batch
        self._files = CookedMeshes(batch.plan)
        self._meshes: dict[str, MeasuredMesh] = {}

    def scene(self, index: int, scene: Any) -> MeasuredScene:
        """Reads one scene of the batch, by its index in the plan."""
        entities = tuple(
            self._entity(entity, index) for entity in self._batch.plan.entities if self._exists(entity, index)
        )
        x, y, z = _floats(scene.physx_system.config.gravity)
        return MeasuredScene(index, float(scene.get_timestep()), (x, y, z), entities)

    def _exists(self, entity: Entity, index: int) -> bool:
        there = entity.name in self._batch.entities or entity.name in self._batch.articulations
        return there and index in entity.scene_idxs

    def _entity(self, entity: Entity, index: int) -> MeasuredEntity:
        row = entity.scene_idxs.index(index)
        structure = entity.structure(row)
        if isinstance(structure, ArticulationStructure):
            bodies = self._links(entity.name, structure, row, index)
        else:
            batch = self._batch.entities[entity.name]
            obj: Any = batch.objs[batch.scene_idxs.index(index)]
            component = obj.find_component_by_type(physx.PhysxRigidBaseComponent)
            shapes = self._shapes(structure, component, row)
            pose, mass = _read_pose(obj.get_pose()), _read_mass(component)
            bodies = (MeasuredBody(entity.name, structure.body_type, structure, pose, mass, shapes),)
        return MeasuredEntity(entity, structure, row, bodies)

    def _links(self, name: str, structure: ArticulationStructure, row: int, index: int) -> tuple[MeasuredBody, ...]:
        batch = self._batch.articulations[name]
        number = batch.scene_idxs.index(index)
        named = batch.links
        links = [named[link.name][number] for link in structure.links]
        numbers = _joint_positions(batch.objs[number], links)
        return tuple(
            MeasuredBody(
                link.name,
                link.body.body_type,
                link.body,
                _read_pose(made.get_entity().get_pose()),
                _read_mass(made),
                self._shapes(link.body, made, row),
                link.parent,
                None if link.joint is None else _read_joint(link.joint, made.get_joint(), *numbers[which]),
            )
            for which, (link, made) in enumerate(zip(structure.links, links, strict=True))
        )

    def _shapes(self, structure: BodyStructure, component: Any, row: int) -> tuple[MeasuredShape, ...]:
        if component is None:
            return ()
        shapes = [shape for shape in structure.collisions for _ in range(part_count(shape.geometry, row, self._files))]
        found: list[MeasuredShape] = []
        for made, shape in zip(component.get_collision_shapes(), shapes, strict=True):
            geometry, sizes = read_live_geometry(made)
            mesh = self._mesh(made) if issubclass(geometry, MeshGeometry) else None
            a, b, c, d = map(int, made.get_collision_groups())
            friction = made.get_physical_material()
            found.append(
                MeasuredShape(
                    kind=type_name(geometry),
                    sizes=sizes,
                    pose=_read_pose(made.get_local_pose()),
                    shape=shape,
                    mesh=mesh,
                    static_friction=float(friction.static_friction),
                    dynamic_friction=float(friction.dynamic_friction),
                    restitution=float(friction.restitution),
                    density=float(made.get_density()),
                    contact_offset=float(made.get_contact_offset()),
                    rest_offset=float(made.get_rest_offset()),
                    groups=(a, b, c, d),
                )
            )
        return tuple(found)

    def _mesh(self, made: Any) -> MeasuredMesh:
        scale = np.asarray(made.get_scale(), np.float64)
        vertices = np.ascontiguousarray(made.get_vertices().astype(np.float64) * scale)
        triangles = np.ascontiguousarray(made.get_triangles().astype(np.int64))
        digest = sha256(vertices.tobytes() + triangles.tobytes()).hexdigest()
        if digest not in self._meshes:
            for array in (vertices, triangles):
                array.setflags(write=False)
            self._meshes[digest] = MeasuredMesh(digest, vertices, triangles)
        return self._meshes[digest]


def _read_mass(component: Any) -> MeasuredMass | None:
    if not isinstance(component, physx.PhysxRigidBodyComponent):
        return None
    x, y, z = _floats(component.get_inertia())
    return MeasuredMass(float(component.get_mass()), _read_pose(component.get_cmass_local_pose()), (x, y, z))


def _joint_positions(articulation: Any, links: list[Any]) -> list[tuple[float, float]]:
    """Returns position and velocity of each link's joint; 0 for a joint that does not move."""
    moving = sorted((link.get_index(), which) for which, link in enumerate(links) if link.get_joint().get_dof())
    found = [(0.0, 0.0)] * len(links)
    for (_, which), qpos, qvel in zip(moving, articulation.get_qpos(), articulation.get_qvel(), strict=True):
        found[which] = (float(qpos), float(qvel))
    return found


def _read_joint(plan: Joint, joint: Any, qpos: float, qvel: float) -> MeasuredJoint:
    moves = bool(joint.get_dof())
    low, high = _floats(joint.get_limits()[0]) if moves else (0.0, 0.0)
    # For values that a fixed joint lacks, the engine returns empty arrays or arbitrary numbers.
    numbers = {name: float(np.ravel(getattr(joint, name))[0]) if moves else 0.0 for name in _JOINT_NUMBERS}
    return MeasuredJoint(
        joint=plan,
        type=joint.get_type(),
        name=joint.get_name(),
        pose_in_parent=_read_pose(joint.get_pose_in_parent()),
        pose_in_child=_read_pose(joint.get_pose_in_child()),
        limits=(low, high),
        drive_mode=joint.get_drive_mode() if moves else "force",
        qpos=qpos,
        qvel=qvel,
        **numbers,
    )


def _read_pose(pose: Any) -> Pose7:
    x, y, z, qw, qx, qy, qz = _floats((*pose.p, *pose.q))
    return x, y, z, qw, qx, qy, qz


def _floats(numbers: Any) -> tuple[float, ...]:
    return tuple(map(float, numbers))


class PoseTracker:
    """The dynamic and kinematic bodies and the links of a batch.

    Attributes:
        keys: for each, index of its scene, name of its entity, and its index among the entity's bodies.
    """

    def __init__(self, batch: SceneBatch) -> None:
        """Finds the bodies. Raises RuntimeError if the batch is closed."""
        found: list[tuple[tuple[int, str, int], Any]] = []
        for entity in batch.plan.entities:
            for row, index in enumerate(entity.scene_idxs):
                if index in batch.scene_idxs:
                    found += _moving_objects(batch, entity.name, entity.structure(row), index)
        self.keys = tuple(key for key, _ in found)
        self._objs = [obj for _, obj in found]

    def poses(self) -> NDArray[np.float32]:
        """Returns the pose of each (N, 7), p [m] then q (wxyz), in the world of its scene."""
        # All seven numbers in one call: `p` and `q` each make an array, and this runs thirty times a second.
        rows = [obj.get_pose().__getstate__() for obj in self._objs]
        return np.array(rows, np.float32).reshape(len(rows), 7)


def _moving_objects(batch: SceneBatch, name: str, structure: Any, index: int) -> list[tuple[tuple[int, str, int], Any]]:
    if isinstance(structure, ArticulationStructure):
        articulation = batch.articulations[name]
        row = articulation.scene_idxs.index(index)
        named = articulation.links
        links = [named[link.name][row].get_entity() for link in structure.links]
        return [((index, name, number), link) for number, link in enumerate(links)]
    if structure.body_type not in {"dynamic", "kinematic"}:
        return []
    entity = batch.entities[name]
    return [((index, name, 0), entity.objs[entity.scene_idxs.index(index)])]
