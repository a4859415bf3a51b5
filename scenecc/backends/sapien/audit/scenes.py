"""The audit after a build: compares what only the engine decides with the plan.

Values that were passed to setters are not read back: `tests/fidelity/test_setters.py` tests the setters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.differences import (
    AUDIT_CODE,
    AuditDifference,
    format_engine_numbers,
    report_differences,
)
from scenecc.backends.sapien.audit.entities import (
    articulation_block,
    entity_differences,
    plain_block,
)
from scenecc.backends.sapien.audit.masses import (
    MASS_TOLERANCE,
    MESH_TOLERANCE,
    MINIMUM_MASS,
    CookedMeshes,
    Volumes,
    given_mass,
    mesh_keys,
    part_count,
    shapes_mass,
)
from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.geometry import COLLISION_SHAPES
from scenecc.backends.sapien.live_properties import components_of
from scenecc.backends.sapien.preparation import PreparedArticulation, StructureRows
from scenecc.plan import MeshGeometry, TriangleMesh
from scenecc.plan.geometry import RevolvedSolid
from scenecc.plan.properties import FLOAT32_MAX, MAX_BODY_OFFSET
from scenecc.plan.rendering import Camera, Light

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.objects import ComponentBatch
    from scenecc.backends.sapien.preparation import EntityLookup, PreparedEntity
    from scenecc.diagnostics import Sink
    from scenecc.plan import BodyStructure, CollisionGeometry, Constraint, ScenePlan

PRECISION_CODE = "SC512"
"""The code of a mass or centre of mass that does not fit in float32."""


@dataclass(frozen=True, slots=True)
class BuiltScenes:
    """The result of a build.

    Attributes:
        plan: of the scenes.
        prepared: its entities, with the objects that were built.
        lookup: the scenes and their entities.
        constraints: those of the plan that were built, with their components.
        rendering: lights and cameras that were built, with their components.
        rendered: whether the scenes render.
        shared: whether the scenes also hold other objects, as in a ManiSkill environment.
        poses: whether all entities are at their planned poses.
        link_poses: whether links are at the poses of their joints; a simulation on a GPU moves them later.
    """

    plan: ScenePlan
    prepared: Sequence[PreparedEntity]
    lookup: EntityLookup
    constraints: Sequence[tuple[Constraint, ComponentBatch]] = ()
    rendering: Sequence[tuple[Light | Camera, ComponentBatch]] = ()
    rendered: bool = False
    shared: bool = False
    poses: bool = True
    link_poses: bool = True


def audit_scenes(built: BuiltScenes, sink: Sink) -> bool:
    """Compares scenes with the plan before the first step and reports differences. Returns True if there are none."""
    return report_differences(_differences(built), sink)


def _differences(built: BuiltScenes) -> Iterator[AuditDifference]:
    blocks = [
        articulation_block(prepared, moved=built.link_poses)
        if isinstance(prepared, PreparedArticulation)
        else plain_block(prepared.entity, prepared.scene_idxs, prepared.rows, prepared.objs)
        for prepared in built.prepared
    ]
    for item, batch in built.rendering:
        if item.mount is None:
            rows = np.searchsorted(item.scene_idxs, batch.scene_idxs)
            blocks.append(plain_block(item, batch.scene_idxs, rows, [one.get_entity() for one in batch.objs]))
    yield from entity_differences(blocks, built.lookup, shared=built.shared, poses=built.poses)
    meshes = CookedMeshes(built.plan)
    for group in _body_groups(built.prepared):
        if group.part.structure.body_type != "none":
            yield from group.shape_differences(meshes)
        if group.part.structure.body_type not in {"static", "none"}:
            yield from group.mass_differences(meshes)
    for prepared in built.prepared:
        if isinstance(prepared, PreparedArticulation):
            yield from _articulation_differences(prepared)
    yield from _constraint_differences(built)
    yield from _rendering_differences(built)


@dataclass(frozen=True, slots=True)
class _BodyGroup:
    """A body, or a link of an articulation, in the scenes in which it has one structure."""

    prepared: PreparedEntity
    part: StructureRows[BodyStructure]
    components: Sequence[Any]
    link: str = ""

    def difference(
        self, number: int, what: str, expected: object, found: object, code: str = AUDIT_CODE
    ) -> AuditDifference:
        """Returns a difference of the body in one of the scenes."""
        scene = self.prepared.scene_idxs[int(self.part.numbers[number])]
        return AuditDifference(
            self.prepared.entity, what, expected, found, scene, self.link, self.part.structure.origin, code
        )

    def shape_differences(self, meshes: CookedMeshes) -> Iterator[AuditDifference]:
        """Yields differences in the number of its shapes and the volumes of its cooked meshes."""
        shapes, rows = self.part.structure.collisions, self.part.rows
        several = [shape.geometry for shape in shapes if COLLISION_SHAPES[type(shape.geometry)].many]
        single = len(shapes) - len(several)
        # Only mesh parts can be missing. Other bodies are checked in one scene, because this takes time.
        for number, row in enumerate(rows.tolist() if several else rows[:1].tolist()):
            expected = single + sum(part_count(geometry, row, meshes) for geometry in several)
            if (found := len(self.components[number].get_collision_shapes())) != expected:
                yield self.difference(number, "collision_shapes", expected, found)
        for shape in shapes:
            for number, volumes in _badly_cooked_parts(shape.geometry, rows, meshes):
                values = map(format_engine_numbers, volumes)
                yield self.difference(number, "volume of the cooked mesh", *values)._replace(origin=shape.origin)

    def mass_differences(self, meshes: CookedMeshes) -> Iterator[AuditDifference]:
        """Yields differences in mass and, for meshes, weights and centres of mass that do not fit in float32."""
        structure, rows = self.part.structure, self.part.rows
        given = given_mass(structure, rows)
        wanted = shapes_mass(structure, rows, meshes) if given is None else given
        for number, (component, expected) in enumerate(zip(self.components, wanted, strict=True)):
            mass: float = component.get_mass()
            if not abs(mass - expected) <= MASS_TOLERANCE * expected:
                code = _mass_code(expected) if given is None else AUDIT_CODE
                yield self.difference(
                    number, "mass", format_engine_numbers(expected), format_engine_numbers(mass), code
                )
        has_mesh = any(isinstance(shape.geometry, MeshGeometry) for shape in structure.collisions)
        if has_mesh and structure.inertial is None and structure.body_type != "kinematic":
            yield from self._mesh_mass_differences(meshes)

    def _mesh_mass_differences(self, meshes: CookedMeshes) -> Iterator[AuditDifference]:
        """Yields weights and centres of mass out of range. For other shapes these are checked before the build."""
        weights = shapes_mass(self.part.structure, self.part.rows, meshes)
        for number, (component, weight) in enumerate(zip(self.components, weights, strict=True)):
            if self.part.structure.mass is not None and weight < MINIMUM_MASS:
                least = f"{MINIMUM_MASS:g} or more"
                yield self.difference(number, "mass by density", least, format_engine_numbers(weight), "SC511")
            centre = component.cmass_local_pose.p
            if not (np.abs(centre) <= MAX_BODY_OFFSET).all():
                near = "a point within 10 km"
                yield self.difference(number, "cmass_local_pose.p", near, format_engine_numbers(centre), PRECISION_CODE)


def _mass_code(expected: float) -> str:
    """Returns the code for a wrong mass, since the weight of a mesh is only known here."""
    return "SC511" if expected < MINIMUM_MASS else AUDIT_CODE if expected <= FLOAT32_MAX else PRECISION_CODE


def _badly_cooked_parts(
    geometry: CollisionGeometry, rows: NDArray[np.intp], meshes: CookedMeshes
) -> Iterator[tuple[int, Volumes]]:
    """Yields the mesh parts whose volume is wrong in the engine, each with an example row."""
    cooked: list[tuple[int, list[Volumes]]] = []
    if isinstance(geometry, RevolvedSolid):
        several = rows if any(value.varies for value in geometry.values) else rows[:1]
        cooked = [(number, meshes.revolved_parts(geometry, row)) for number, row in enumerate(several.tolist())]
    elif isinstance(geometry, MeshGeometry) and not (isinstance(geometry, TriangleMesh) and not geometry.sdf):
        keys = mesh_keys(geometry, rows)
        cooked = [(keys.index(key), meshes.parts(geometry, key)) for key in dict.fromkeys(keys)]
    for number, parts in cooked:
        for part in parts:
            if not abs(part.weighed - part.enclosed) < MESH_TOLERANCE * part.enclosed:
                yield number, part


def _body_groups(prepared_entities: Sequence[PreparedEntity]) -> Iterator[_BodyGroup]:
    for prepared in prepared_entities:
        if not isinstance(prepared, PreparedArticulation):
            for part in prepared.parts:
                components = prepared.components
                if len(prepared.parts) > 1:
                    components = [components[number] for number in part.numbers.tolist()]
                yield _BodyGroup(prepared, part, components)
            continue
        for part in prepared.parts:
            numbers: list[int] = part.numbers.tolist()
            for which, link in enumerate(part.structure.links):
                own = StructureRows(link.body, part.numbers, part.rows)
                yield _BodyGroup(prepared, own, [prepared.links[number][which] for number in numbers], link.name)


def _articulation_differences(prepared: PreparedArticulation) -> Iterator[AuditDifference]:
    """Yields differences in the numbers of links and of active joints."""
    for part in prepared.parts:
        wanted = {"links": len(part.structure.links), "dof": len(part.structure.active_joints)}
        numbers: list[int] = part.numbers.tolist()
        for number in numbers:
            made = prepared.objs[number]
            counts: dict[str, int] = {"links": len(made.get_links()), "dof": made.dof}
            for what, found in counts.items():
                if found != wanted[what]:
                    yield AuditDifference(prepared.entity, what, wanted[what], found, prepared.scene_idxs[number])


def _constraint_differences(built: BuiltScenes) -> Iterator[AuditDifference]:
    """Yields bodies that lack constraints of the plan, or have them in another order."""
    number_of = {index: number for number, index in enumerate(built.lookup.scene_idxs)}
    expected: dict[int, tuple[Any, list[Any], int, Constraint]] = {}
    for constraint, batch in built.constraints:
        for index, component in zip(batch.scene_idxs, batch.objs, strict=True):
            entity = built.lookup.entity(constraint.child, number_of[index])
            wanted = expected.setdefault(id(entity), (entity, [], index, constraint))[1]
            wanted += components_of(component)
    for entity, wanted, index, constraint in expected.values():
        found = [one for one in entity.components if isinstance(one, physx.PhysxJointComponent)]
        if found != wanted:
            what = f"constraints of '{constraint.child}'"
            yield AuditDifference(constraint, what, _names(wanted), _names(found), index)


def _rendering_differences(built: BuiltScenes) -> Iterator[AuditDifference]:
    """Yields scenes whose lights or cameras differ from the plan; extra ones are allowed if the scene is shared."""
    for kind, name in ((Light, "lights"), (Camera, "cameras")) if built.rendered else ():
        expected: dict[int, set[Any]] = {index: set() for index in built.lookup.scene_idxs}
        origin = built.plan.origin
        for item, batch in built.rendering:
            for index, component in zip(batch.scene_idxs, batch.objs, strict=True) if type(item) is kind else ():
                expected[index].add(component)
                origin = item.origin
        scenes: list[Any] = built.lookup.scenes
        for (index, wanted), scene in zip(expected.items(), scenes, strict=True):
            found = set(getattr(scene.render_system, name))
            if not wanted <= found or (found != wanted and not built.shared):
                yield AuditDifference(None, name, _names(wanted), _names(found), index, origin=origin)


def _names(components: Iterable[Any]) -> str:
    return ", ".join(sorted(f"'{component.name}'" for component in components)) or "none"
