"""What is planned or was built of each entity, and of what is fastened to them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

from scenecc.inspect.entities import SIZE_FIELDS, articulation_size, body_types, mesh_size
from scenecc.inspect.facts import mount_words
from scenecc.inspect.varying import Fields, VaryingField, entity_fields, object_fields
from scenecc.plan import ArticulationStructure, BodyStructure, Camera, Constraint, Environment, Light
from scenecc.plan.extent import extent
from scenecc.plan.schema import type_name

if TYPE_CHECKING:
    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import Entity, ScenePlan
    from scenecc.plan.body import Mount

Section = Literal["entities", "constraints", "environment", "lights", "cameras"]


@dataclass(frozen=True, slots=True)
class SummaryRow:
    """One entity, constraint, light or camera, or what surrounds them.

    Attributes:
        body_type: of its structures, joined by `|` where they differ, "articulation" among them; of what is no
            entity its own type: "weld", "spot", "camera".
        shape_count: of the structure in its first scene, or of the largest where no engine was started: colliding
            shapes, or visible ones where those are more; of an articulation, those of its links.
        mass: [kg] in its first scene, as the engine has it; None where the body has none or no engine was started.
        size: extents along its own axes [m] in its first scene; None where only an engine or a file could tell, and
            where no engine was started and scenes differ in it.
        scene_idxs: the scenes it is in.
        field_count: how many fields have a value; 0 where an engine was started.
        varying: those that differ between scenes; empty where an engine was started.
        masses: the least and the largest of its scenes [kg], where there is a mass.
        size_differs: whether scenes may differ in its size.
        section: of the scene file.
        link_count, dof: of an articulation, in its first scene; of a body 0.
        mounts: what it holds on to, as a scene file names it: of a constraint child and parent.
    """

    name: str
    body_type: str
    shape_count: int
    mass: float | None
    size: tuple[float, float, float] | None
    scene_idxs: tuple[int, ...]
    field_count: int = 0
    varying: tuple[VaryingField, ...] = ()
    masses: tuple[float, float] | None = None
    size_differs: bool = False
    section: Section = "entities"
    link_count: int = 0
    dof: int = 0
    mounts: tuple[str, ...] = ()


def summarize(plan: ScenePlan, batch: SceneBatch | None, scene_idxs: tuple[int, ...] | None = None) -> list[SummaryRow]:
    """A row an entity, in build order; then a row a constraint, the environment, a row a light and a camera.

    Args:
        plan: the whole plan.
        batch: the live scenes; None after a dry run.
        scene_idxs: the scenes that were asked for; None: all of them.
    """
    asked = range(plan.num_scenes) if scene_idxs is None else set(scene_idxs)
    rows: list[SummaryRow] = []
    for entity in plan.entities:
        idxs = tuple(index for index in entity.scene_idxs if index in asked)
        if idxs:
            fields = entity_fields(entity, plan)
            rows.append(_planned(entity, idxs, fields) if batch is None else _built(entity, idxs, batch, fields))
    others: list[tuple[Section, Constraint | Environment | Light | Camera]] = [
        *[("constraints", one) for one in plan.constraints],
        *[("environment", one) for one in (plan.environment,) if one is not None],
        *[("lights", one) for one in plan.lights],
        *[("cameras", one) for one in plan.cameras],
    ]
    for section, one in others:
        within = range(plan.num_scenes) if isinstance(one, Environment) else one.scene_idxs
        idxs = tuple(index for index in within if index in asked)
        if idxs:
            rows.append(_other(section, one, idxs, object_fields(one, plan) if batch is None else _NO_FIELDS))
    return rows


_NO_FIELDS: Final = Fields(0, ())


def _other(
    section: Section, one: Constraint | Environment | Light | Camera, scene_idxs: tuple[int, ...], fields: Fields
) -> SummaryRow:
    mounts: tuple[Mount | None, ...] = ()
    match one:
        case Constraint():
            name, word, mounts = one.name, type_name(one.joint.__class__), (one.child, one.parent)
        case Light():
            name, word, mounts = one.name, type_name(one.light.__class__), (one.mount,)
        case Camera():
            name, word, mounts = one.name, "camera", (one.mount,)
        case Environment():
            name, word = "environment", "environment"
    return SummaryRow(
        name=name,
        body_type=word,
        shape_count=0,
        mass=None,
        size=None,
        scene_idxs=scene_idxs,
        field_count=fields.count,
        varying=fields.varying,
        section=section,
        mounts=tuple(map(mount_words, mounts)),
    )


def _planned(entity: Entity, scene_idxs: tuple[int, ...], fields: Fields) -> SummaryRow:
    structures = entity.structures
    first = entity.structure(entity.scene_idxs.index(scene_idxs[0])) if _is_known(entity) else structures[0]
    row = _common(entity, first, scene_idxs, fields)
    return replace(
        row,
        shape_count=max(map(_shape_count, structures)),
        size=None if row.size_differs or isinstance(first, ArticulationStructure) else extent(first),
        field_count=fields.count,
        varying=fields.varying,
    )


def _common(
    entity: Entity, first: BodyStructure | ArticulationStructure, scene_idxs: tuple[int, ...], fields: Fields
) -> SummaryRow:
    """What is told of an entity whether an engine has it or not. `first`: its structure in the first of the scenes."""
    articulated = isinstance(first, ArticulationStructure)
    return SummaryRow(
        name=entity.name,
        body_type=body_types(entity.structures),
        shape_count=_shape_count(first),
        mass=None,
        size=None,
        scene_idxs=scene_idxs,
        size_differs=_size_differs(entity, fields),
        link_count=len(first.links) if articulated else 0,
        dof=len(first.active_joints) if articulated else 0,
    )


def _is_known(entity: Entity) -> bool:
    """Whether its structures are told without drawing."""
    return entity.pick is None or entity.pick.known


def _shape_count(structure: BodyStructure | ArticulationStructure) -> int:
    return sum(max(len(body.collisions), len(body.visuals)) for body in structure.bodies)


def _size_differs(entity: Entity, fields: Fields) -> bool:
    return entity.pick is not None or any(
        "[" in field.field and field.field.rsplit(".", 1)[-1] in SIZE_FIELDS for field in fields.varying
    )


def _built(entity: Entity, scene_idxs: tuple[int, ...], batch: SceneBatch, fields: Fields) -> SummaryRow:
    row = entity.scene_idxs.index(scene_idxs[0])
    structure = entity.structure(row)
    if isinstance(structure, ArticulationStructure):
        masses, size = _of_links(batch.articulations[entity.name].objs)
    else:
        masses, size = _of_bodies(batch.entities[entity.name].objs, structure, row)
    return replace(
        _common(entity, structure, scene_idxs, fields),
        mass=masses[0] if masses else None,
        size=size,
        masses=(min(masses), max(masses)) if masses else None,
    )


def _of_links(objs: list[Any]) -> tuple[list[float], tuple[float, float, float] | None]:
    """Masses of some articulations, and the size of the first."""
    masses = [float(sum(link.get_mass() for link in obj.get_links())) for obj in objs]
    return masses, articulation_size(sorted(objs[0].get_links(), key=lambda link: link.get_index()))


def _of_bodies(
    objs: list[Any], structure: BodyStructure, row: int
) -> tuple[list[float], tuple[float, float, float] | None]:
    """Masses of some bodies, and the size of the first, which has the structure, in a row of its values."""
    body = _rigid_body(objs[0])
    # SAPIEN gives what has nothing to weigh a milligram.
    weighs = bool(structure.collisions) or structure.inertial is not None
    masses = [mass for obj in objs if (mass := getattr(_rigid_body(obj), "mass", None)) is not None] if weighs else []
    return masses, extent(structure, row) or (None if body is None else mesh_size(body))


def _rigid_body(obj: Any) -> Any:
    """The physical component of an entity of the engine; None where it is only seen."""
    return next((component for component in obj.components if hasattr(component, "collision_shapes")), None)
