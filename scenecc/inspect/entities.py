"""Entities of a scene, planned or built: as items of the tree, and as rows of the summary."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.diagnostics.messages import index_ranges
from scenecc.geometry.rotation_arrays import pose_matrix, rotation_matrix
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.inspect.facts import Fact, FactReader, Item, axis_words, fact, mount_words, plain_data
from scenecc.inspect.varying import Fields, VaryingField, entity_fields, object_fields
from scenecc.plan import ArticulationStructure, BodyStructure, Constraint, Plane, VisualPlane
from scenecc.plan.articulation import friction_force
from scenecc.plan.constraint import is_ball
from scenecc.plan.display import link_shape_path, shape_path
from scenecc.plan.geometry import SOLID_SIZES, SOLIDS, Primitive, Solid
from scenecc.plan.properties import JOINT_PROPERTIES
from scenecc.plan.rendering import Camera, Environment, Light
from scenecc.plan.scene import structure_type
from scenecc.plan.schema import type_name

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import Entity, Link, ScenePlan, Value
    from scenecc.plan.body import BodyStructure, CollisionShape, Mount, PhysicalMaterial, VisualMaterial, VisualShape
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredShape


def measure_extents(structure: BodyStructure, row: int = 0) -> tuple[float, float, float] | None:
    """Returns the extents of a body along the axes of its own frame [m], visual shapes included.

    None if a shape is a mesh, or an infinite plane without a visual. `row`: of the scene among the entity's scenes.
    """
    corners: list[NDArray[np.float64]] = []
    seen_plane = any(isinstance(shape.geometry, VisualPlane) for shape in structure.visuals)
    for shape in chain(structure.collisions, structure.visuals):
        if not isinstance(shape.geometry, Primitive):
            if seen_plane and isinstance(shape.geometry, Plane):
                continue
            return None
        pose = np.array(IDENTITY_POSE) if shape.pose is None else shape.pose.row(row)
        bounds = shape.geometry.bounds(rotation_matrix(pose[3:]), *shape.geometry.sizes(row))
        corners += [pose[:3] + corner for corner in bounds]
    if not corners:
        return None
    x, y, z = np.max(corners, axis=0) - np.min(corners, axis=0)
    # A rotated flat shape has a rounding error as its thickness.
    return (round(float(x), 12), round(float(y), 12), round(float(z), 12))


Size = tuple[float, float, float]


def measured_size(bodies: Iterable[MeasuredBody]) -> Size | None:
    """Returns the extents of the collision shapes of some bodies, along the axes of the first body [m].

    None if there are no collision shapes, or one is a plane.
    """
    found: list[NDArray[np.float64] | None] = []
    root: NDArray[np.float64] | None = None
    for body in bodies:
        frame = pose_matrix(body.pose)
        root = np.array(np.linalg.inv(frame), np.float64) if root is None else root
        for shape in body.shapes:
            place = root @ frame @ pose_matrix(shape.pose)
            found.append(shape_bounds(shape, place))
    return _extents(found)


def shape_bounds(shape: MeasuredShape, frame: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Returns points (n, 3) that bound a shape at a pose (4, 4): the vertices of a mesh; None for a plane."""
    return _bounds(SOLIDS.get(shape.kind), shape.sizes, None if shape.mesh is None else shape.mesh.vertices, frame)


def _bounds(
    solid: type[Solid] | None,
    sizes: tuple[float, ...],
    vertices: NDArray[np.float64] | None,
    frame: NDArray[np.float64],
) -> NDArray[np.float64] | None:
    """Returns points (n, 3) that bound a solid or a mesh at a pose (4, 4), or None for a plane."""
    rotation, centre = frame[:3, :3], frame[:3, 3]
    if vertices is not None:
        return vertices @ rotation.T + centre
    if solid is None:
        return None
    half = solid.extent(rotation, *sizes)
    return np.array([centre - half, centre + half])


def _extents(bounds: Sequence[NDArray[np.float64] | None]) -> Size | None:
    """Returns the extents of all points, or None if there are none or a shape has no bounds."""
    points = [one for one in bounds if one is not None]
    if not points or len(points) < len(bounds):
        return None
    x, y, z = np.ptp(np.concatenate(points), axis=0).tolist()
    return (x, y, z)


_TURNING: Final = {
    **{row.field: row.unit for row in JOINT_PROPERTIES if row.unit},
    **dict.fromkeys(("limits", "offset"), "rad"),
    "friction_force": "N·m",
}

_SLIDING: Final = {name: unit.replace("rad", "m") for name, unit in _TURNING.items()} | {"friction_force": "N"}

SIZE_FIELDS: Final = SOLID_SIZES | {"size", "heights", "scale", "file", "pick", "p", "q"}
"""Fields that change the size and the mass of a body."""

_MASSES: Final = SIZE_FIELDS | {"density", "mass"}

_POSITIONS: Final = SIZE_FIELDS | {"qpos"}

_NEUTRAL: Final[dict[str, Any]] = {"pose.p": [0, 0, 0], "scale": [1, 1, 1]}
"""Values of shapes that have no effect, and are not displayed."""

Made = tuple[int, "MeasuredEntity"]
"""Index of a scene, and a measured entity of it."""


def entity_item(entity: Entity, plan: ScenePlan, scene: int | None, made: Made | None) -> Item:
    """Returns the item of an entity in a scene (None: in all). `made`: the measured entity, if it was built."""
    row = None if scene is None else entity.scene_idxs.index(scene)
    structures = entity.structures if row is None else (entity.structure(row),)
    one = structures[0]
    words = body_types(structures)
    facts = [*scene_facts(entity.scene_idxs, plan), *FactReader(plan, row).value("pose", entity.pose)]
    if entity.hidden:
        facts.append(Fact("hidden", value=True, words="from sensors"))
    body = _Bodies(entity, plan, row, made)
    if len(structures) == 1:
        return Item(entity.name, words, (*facts, *body.facts(one)), body.groups(one))
    variants = tuple(
        Item(f"variants[{index}]", structure_type(each), tuple(body.facts(each)), body.groups(each))
        for index, each in enumerate(structures)
    )
    return Item(entity.name, words, tuple(facts), (("variants", variants),))


def body_types(structures: Iterable[BodyStructure | ArticulationStructure]) -> str:
    """Returns the types of some structures, joined by `|` if they differ."""
    return "|".join(dict.fromkeys(map(structure_type, structures)))


def scene_facts(scene_idxs: Sequence[int], plan: ScenePlan) -> Iterator[Fact]:
    """Yields the scenes of an object."""
    if len(scene_idxs) == plan.num_scenes:
        yield Fact("scene_idxs", "all", "")
    else:
        yield Fact("scene_idxs", list(scene_idxs), f"{index_ranges(scene_idxs)} of {plan.num_scenes}")


class _Bodies:
    """Describes the bodies of one entity."""

    def __init__(self, entity: Entity, plan: ScenePlan, row: int | None, made: Made | None) -> None:
        self._plan = plan
        self._row = row
        self._made = made
        self._facts = FactReader(plan, row)
        differing = entity_fields(entity, plan).varying if row is None else ()
        names = [field.field for field in differing if not field.field.startswith("pose.")]
        of_bodies = {name.rsplit(".", 1)[-1] for name in names if ".joint." not in name}
        self._mass_differs = not of_bodies.isdisjoint(_MASSES)
        self._size_differs = not of_bodies.isdisjoint(SIZE_FIELDS)
        self._stance_differs = not _POSITIONS.isdisjoint(name.rsplit(".", 1)[-1] for name in names)

    def facts(self, structure: BodyStructure | ArticulationStructure) -> Iterator[Fact]:
        """Yields the facts of a structure itself."""
        if not isinstance(structure, ArticulationStructure):
            made = self._measured_bodies(structure)
            yield from self._body(structure, made[0] if made else None)
            return
        yield fact("link_count", len(structure.links))
        yield fact("dof", len(structure.active_joints))
        yield from self._measured_facts(structure)
        yield from self._facts.of(structure, without=("links", "mimics"))

    def groups(
        self, structure: BodyStructure | ArticulationStructure
    ) -> tuple[tuple[str, Item | tuple[Item, ...]], ...]:
        """Returns the items of a structure: its shapes, or its links."""
        if not isinstance(structure, ArticulationStructure):
            return (("shapes", tuple(self._shapes(structure, in_link=False))),)
        return (("links", tuple(self._link(structure, number) for number in range(len(structure.links)))),)

    def _measured_facts(self, structure: ArticulationStructure) -> Iterator[Fact]:
        """Yields measured mass and size of all links."""
        made = self._measured_bodies(structure)
        if made:
            masses = [body.mass.mass for body in made if body.mass is not None]
            if masses:
                yield self._with_scene(fact("mass", sum(masses)), differs=self._mass_differs)
        if made and (size := measured_size(made)) is not None:
            yield self._with_scene(_size(size), differs=self._stance_differs)

    def _measured_bodies(self, structure: BodyStructure | ArticulationStructure) -> tuple[MeasuredBody, ...]:
        """Returns the measured bodies of a structure; empty if it was not built."""
        if self._made is None or self._made[1].structure is not structure:
            return ()
        return self._made[1].bodies

    def _body(self, body: BodyStructure, made: MeasuredBody | None) -> Iterator[Fact]:
        """Yields the facts of a body or a link."""
        given = body.mass if body.inertial is None else body.inertial.mass
        if given is not None and (made is None or (self._row is None and given.may_vary)):
            yield from self._facts.value("mass", given)
        elif made is not None and made.mass is not None and (body.collisions or body.inertial is not None):
            yield self._with_scene(fact("mass", made.mass.mass), differs=self._mass_differs)
        planned = measure_extents(body, self._row or 0) if self._row is not None or not self._size_differs else None
        size = planned or (measured_size((made,)) if made is not None else None)
        if size is not None:
            yield self._with_scene(_size(size), differs=planned is None and self._size_differs)
        yield from self._facts.of(body, without=("body_type", "collisions", "visuals", "mass", "inertial"))
        yield from self._facts.of(body.inertial, "inertial", without=("mass",))

    def _with_scene(self, measured: Fact, *, differs: bool) -> Fact:
        """Returns a measured fact, with its scene if it may differ in others."""
        if self._made is None or not differs:
            return measured
        words = f"{measured.words} in scene {self._made[0]}"
        return Fact(measured.name, {"value": measured.value, "scene": self._made[0]}, words)

    def _shapes(self, body: BodyStructure, *, in_link: bool) -> Iterator[Item]:
        visuals = list(enumerate(body.visuals))
        for index, shape in enumerate(body.collisions):
            label = _label(shape, f"collisions[{index}]", in_link=in_link)
            twin = next((pair for pair in visuals if _is_same(shape, pair[1], in_link=in_link)), None)
            if twin is not None:
                visuals.remove(twin)
            yield self._shape(label, shape, None if twin is None else twin[1])
        for index, shape in visuals:
            yield self._shape(_label(shape, f"visuals[{index}]", in_link=in_link), None, shape)

    def _shape(self, label: str, collision: CollisionShape | None, visual: VisualShape | None) -> Item:
        """Returns the item of a collision shape, a visual shape, or both."""
        roles = [name for name, shape in (("collides", collision), ("seen", visual)) if shape is not None]
        found: dict[str, Fact] = {"roles": Fact("roles", roles, ", ".join(roles))}
        for shape in (collision, visual):
            if shape is None:
                continue
            for one in (
                *self._facts.of(shape.geometry),
                *self._facts.of(shape, without=("geometry", "material", "name")),
                *([] if shape is collision or not visual or not visual.name else [fact("render_name", visual.name)]),
            ):
                here = one.name in _NEUTRAL and one.value == _NEUTRAL[one.name]
                found.setdefault(one.name, Fact(one.name, one.value, "") if here else one)
        for one in (
            *self._material("physical", collision and collision.material, self._plan.physical_materials),
            *self._material("visual", visual and visual.material, self._plan.visual_materials),
        ):
            found[one.name] = one
        shape = collision or visual
        assert shape is not None
        return Item(label, type_name(type(shape.geometry)), tuple(found.values()))

    def _material(
        self, kind: str, index: Value | None, table: Sequence[PhysicalMaterial] | Sequence[VisualMaterial]
    ) -> Iterator[Fact]:
        if index is None:
            return
        name = f"{kind}_material"
        if self._row is None and not index.is_constant:
            options = [int(item) for item in index.bounds.alternatives or ()]
            yield Fact(name, {"alternatives": options}, f"one of {len(options)}")
            return
        number = int(index.row(self._row or 0))
        yield Fact(name, number, "")
        yield from self._facts.of(table[number])

    def _link(self, structure: ArticulationStructure, number: int) -> Item:
        link = structure.links[number]
        made = self._measured_bodies(structure)
        facts = [*self._body(link.body, made[number] if made else None)]
        facts += self._facts.of(link, without=("name", "body", "parent", "joint"))
        shapes = tuple(self._shapes(link.body, in_link=True))
        if link.joint is None or link.parent is None:
            return Item(link.name, "link", tuple(facts), (("shapes", shapes),))
        parent = structure.links[link.parent].name
        groups = (("joint", self._joint(link, structure)), ("shapes", shapes))
        return Item(link.name, "link", (Fact("parent", parent, ""), *facts), groups, under=link.parent)

    def _joint(self, link: Link, structure: ArticulationStructure) -> Item:
        joint = link.joint
        assert joint is not None
        units = _SLIDING if joint.type == "prismatic" else _TURNING
        facts = FactReader(self._plan, self._row, units)
        found: list[Fact] = []
        frame = joint.pose_in_child
        if joint.type != "fixed" and (frame is None or self._row is not None or frame.is_constant):
            q = np.array([1, 0, 0, 0.0]) if frame is None else frame.row(self._row or 0)[3:]
            axis: list[float] = rotation_matrix(q)[:, 0].tolist()
            found.append(Fact("axis", plain_data(axis), axis_words(axis)))
        force = friction_force(joint)
        if force is not None:
            found += facts.value("friction_force", force)
        hidden = () if force is None else ("damping", "force_limit")
        if force is not None and joint.friction is not None and not any(joint.friction.numbers()):
            hidden += ("friction",)  # the force replaces the ratio
        found += facts.of(joint, without=("type", "name", *hidden))
        for mimic in structure.mimics:
            if mimic.joint == joint.name:
                found.append(fact("mimic", mimic.source))
                found += facts.of(mimic, "mimic", without=("joint", "source"))
        return Item(joint.name, joint.type, tuple(found))


def _size(size: Size) -> Fact:
    words = " × ".join(f"{length:.4g}" for length in size)
    return Fact("size", list(size), f"{words} m")


def _label(shape: CollisionShape | VisualShape, otherwise: str, *, in_link: bool) -> str:
    """Returns the path of a shape below its body, as in a scene file."""
    if in_link:
        return link_shape_path("", shape.origin, otherwise).removeprefix(".")
    place = shape_path(shape.origin, otherwise)
    return place.partition("].")[2] if place.startswith("variants[") else place


def _is_same(collision: CollisionShape, visual: VisualShape, *, in_link: bool) -> bool:
    """Returns whether a collision and a visual shape come from one shape of the file."""
    a, b = (_label(shape, "", in_link=in_link) for shape in (collision, visual))
    alike = collision.geometry == visual.geometry or (
        isinstance(collision.geometry, Plane) and isinstance(visual.geometry, VisualPlane)
    )
    return a == b and alike and collision.pose == visual.pose


def used_materials(entity: Entity) -> Mapping[str, set[int]]:
    """Returns the indices of materials that an entity's shapes may have, by table of the plan."""
    found: dict[str, set[int]] = {"physical": set(), "visual": set()}
    for body in entity.bodies:
        shapes: tuple[tuple[str, Any], ...] = (("physical", body.collisions), ("visual", body.visuals))
        for kind, listed in shapes:
            for shape in listed:
                if shape.material is not None:
                    found[kind] |= {int(item) for item in shape.material.bounds.alternatives or ()}
    return found


def mesh_size(body: Any) -> Size | None:
    """Returns the extents of an engine's body whose collision shapes are all meshes [m]."""
    shapes = body.collision_shapes
    if not shapes or not all(hasattr(shape, "vertices") for shape in shapes):
        return None
    return _extents([_engine_bounds(shape, shape.local_pose) for shape in shapes])


def articulation_size(links: Iterable[Any]) -> Size | None:
    """Returns the current extents of the collision shapes of some engine links, along the axes of the first [m].

    None if there are no collision shapes, or one is a plane.
    """
    found: list[NDArray[np.float64] | None] = []
    root: Any = None
    for link in links:
        pose = link.entity_pose
        root = pose.inv() if root is None else root
        found += [_engine_bounds(shape, root * pose * shape.local_pose) for shape in link.collision_shapes]
    return _extents(found)


def _engine_bounds(shape: Any, pose: Any) -> NDArray[np.float64] | None:
    """Returns points that bound a shape of the engine. `pose`: of the shape."""
    from scenecc.backends.sapien.measure import read_live_geometry

    geometry, sizes = read_live_geometry(shape)
    solid = geometry if issubclass(geometry, Solid) else None
    vertices = np.asarray(shape.vertices * shape.scale, np.float64) if hasattr(shape, "vertices") else None
    return _bounds(solid, sizes, vertices, pose.to_transformation_matrix().astype(np.float64))


Section = Literal["entities", "constraints", "environment", "lights", "cameras"]


@dataclass(frozen=True, slots=True)
class SummaryRow:
    """One entity, constraint, light, camera, or the environment.

    Attributes:
        body_type: of its structures, joined by `|` if they differ; "articulation" is one of them. Other objects have
            their own type: "weld", "spot", "camera".
        shape_count: number of collision shapes, or of visual shapes if there are more; includes all links. Of the
            structure in the first scene, or of the largest if no engine was started.
        mass: [kg] in its first scene, from the engine. None: it has none, or no engine was started.
        size: extents along its own axes [m] in its first scene. None: it follows from a mesh or from the engine, or no
            engine was started and it differs between scenes.
        scene_idxs: its scenes.
        field_count: number of fields with a value; 0 if an engine was started.
        varying: the fields that differ between scenes; empty if an engine was started.
        masses: smallest and largest of its scenes [kg], if it has a mass.
        size_differs: whether its size may differ between scenes.
        section: of the scene file.
        link_count, dof: for an articulation, in its first scene; 0 for a body.
        mounts: its mount, as in a scene file; for a constraint, child and parent.
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
    """Returns one row per entity, in build order, and then the constraints, the environment, lights and cameras.

    Args:
        plan: the whole plan.
        batch: the live scenes. None: after a dry run.
        scene_idxs: scenes to summarize. None: all.
    """
    asked = range(plan.num_scenes) if scene_idxs is None else set(scene_idxs)
    rows: list[SummaryRow] = []
    for entity in plan.entities:
        idxs = tuple(index for index in entity.scene_idxs if index in asked)
        if idxs:
            fields = entity_fields(entity, plan)
            rows.append(
                _planned_row(entity, idxs, fields) if batch is None else _built_row(entity, idxs, batch, fields)
            )
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
            rows.append(_other_row(section, one, idxs, object_fields(one, plan) if batch is None else _NO_FIELDS))
    return rows


_NO_FIELDS: Final = Fields(0, ())


def _other_row(
    section: Section, one: Constraint | Environment | Light | Camera, scene_idxs: tuple[int, ...], fields: Fields
) -> SummaryRow:
    mounts: tuple[Mount | None, ...] = ()
    match one:
        case Constraint():
            name, mounts = one.name, (one.child, one.parent)
            word = "ball" if is_ball(one.joint) else type_name(one.joint.__class__)
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


def _planned_row(entity: Entity, scene_idxs: tuple[int, ...], fields: Fields) -> SummaryRow:
    structures = entity.structures
    first = entity.structure(entity.scene_idxs.index(scene_idxs[0])) if _is_known(entity) else structures[0]
    row = _common_fields(entity, first, scene_idxs, fields)
    return replace(
        row,
        shape_count=max(map(_shape_count, structures)),
        size=None if row.size_differs or isinstance(first, ArticulationStructure) else measure_extents(first),
        field_count=fields.count,
        varying=fields.varying,
    )


def _common_fields(
    entity: Entity, first: BodyStructure | ArticulationStructure, scene_idxs: tuple[int, ...], fields: Fields
) -> SummaryRow:
    """Returns the part of a row that needs no engine. `first`: the structure in the first of the scenes."""
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
    """Returns whether an entity's structures are known without drawing."""
    return entity.pick is None or entity.pick.known


def _shape_count(structure: BodyStructure | ArticulationStructure) -> int:
    return sum(max(len(body.collisions), len(body.visuals)) for body in structure.bodies)


def _size_differs(entity: Entity, fields: Fields) -> bool:
    return entity.pick is not None or any(
        "[" in field.field and field.field.rsplit(".", 1)[-1] in SIZE_FIELDS for field in fields.varying
    )


def _built_row(entity: Entity, scene_idxs: tuple[int, ...], batch: SceneBatch, fields: Fields) -> SummaryRow:
    row = entity.scene_idxs.index(scene_idxs[0])
    structure = entity.structure(row)
    if isinstance(structure, ArticulationStructure):
        masses, size = _measure_links(batch.articulations[entity.name].objs)
    else:
        masses, size = _measure_bodies(batch.entities[entity.name].objs, structure, row)
    return replace(
        _common_fields(entity, structure, scene_idxs, fields),
        mass=masses[0] if masses else None,
        size=size,
        masses=(min(masses), max(masses)) if masses else None,
    )


def _measure_links(objs: list[Any]) -> tuple[list[float], tuple[float, float, float] | None]:
    """Returns the masses of some articulations [kg], and the size of the first [m]."""
    masses = [float(sum(link.get_mass() for link in obj.get_links())) for obj in objs]
    return masses, articulation_size(sorted(objs[0].get_links(), key=lambda link: link.get_index()))


def _measure_bodies(
    objs: list[Any], structure: BodyStructure, row: int
) -> tuple[list[float], tuple[float, float, float] | None]:
    """Returns the masses of some bodies [kg], and the size of the first [m], which has this structure and row."""
    body = _rigid_body(objs[0])
    # SAPIEN gives a body without collision shapes a milligram.
    weighs = bool(structure.collisions) or structure.inertial is not None
    masses = [mass for obj in objs if (mass := getattr(_rigid_body(obj), "mass", None)) is not None] if weighs else []
    return masses, measure_extents(structure, row) or (None if body is None else mesh_size(body))


def _rigid_body(obj: Any) -> Any:
    """Returns the physics component of an engine's entity, or None if it has only visual shapes."""
    return next((component for component in obj.components if hasattr(component, "collision_shapes")), None)
