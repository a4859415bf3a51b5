"""A strict, table-driven `ActorBuilder` for batches. Shapes and mass are prepared once and applied in every scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.assets import Resources, load_all_parts
from scenecc.backends.sapien.engine import REFUSED_CODE, EngineFailure, engine_refusal, physx, render, sapien
from scenecc.backends.sapien.geometry import COLLISION_SHAPES, VISUAL_SHAPES, ShapeContext, front_face_column
from scenecc.backends.sapien.properties import (
    BODY_PROPERTIES,
    COLLISION_GROUPS,
    RENDER_PROPERTIES,
    SHAPE_POSE,
    SHAPE_PROPERTIES,
    VISUAL_POSE,
    FixedSetters,
    SetterColumn,
    apply_setters,
    property_setters,
    select_rows,
    set_center_of_mass,
    split_poses,
    split_setters,
    to_poses,
    to_scalars,
    to_vectors,
)
from scenecc.backends.sapien.shared_materials import SharedMaterial, add_shape
from scenecc.plan import MeshGeometry, Plane

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.backends.sapien.objects import DrawnObjects
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import (
        BodyStructure,
        CollisionGeometry,
        CollisionShape,
        Entity,
        Inertial,
        Value,
        VisualGeometry,
        VisualShape,
    )


class PreparedShape(NamedTuple):
    """How to make one shape of the plan, row by row. A plain tuple, because plans have many shapes.

    Attributes:
        make: returns the new shape of a row (a list of shapes if `many`).
        fixed: setters whose value is the same in every row.
        varying: setters with a value for each row.
        samples: rows that together name every file of the shape; empty without files.
        code: of the diagnostic if the engine refuses the shape.
        origin: the shape in the document.
    """

    make: Callable[[int], Any]
    fixed: FixedSetters
    varying: tuple[SetterColumn, ...]
    many: bool
    samples: tuple[int, ...]
    code: str
    origin: Origin | None


def attach_shape(component: Any, shape: PreparedShape, row: int) -> None:
    """Makes the shape of a row and attaches it to the component.

    Raises:
        EngineFailure: the engine cannot make the shape.
    """
    try:
        made = shape.make(row)
        for part in made if shape.many else (made,):
            for setter, value in shape.fixed:
                setter(part, value)
            for setter, values in shape.varying:
                setter(part, values[row])
            component.attach(part)
    except (RuntimeError, TypeError, ValueError) as error:
        raise shape_failure(shape, error) from error


def shape_failure(shape: PreparedShape, error: Exception) -> EngineFailure:
    """Returns the engine's error about a shape, in its own words."""
    return EngineFailure(shape.code, f"the engine cannot make this shape: {error}", origin=shape.origin)


def _cooking_failure(shape: PreparedShape, row: int) -> EngineFailure | None:
    try:
        if shape.many:
            load_all_parts(lambda: shape.make(row))
        else:
            shape.make(row)
    except (RuntimeError, TypeError, ValueError) as error:
        return shape_failure(shape, error)
    return None


def _prepare_collision(
    shape: CollisionShape, groups: Value | None, rows: NDArray[np.intp], resources: Resources, entity: Entity
) -> PreparedShape:
    material = resources.physical(shape.material, rows, entity.scene_idxs)
    holders = [one if isinstance(one, SharedMaterial) else None for one in material]
    material = [one.material if isinstance(one, SharedMaterial) else one for one in material]
    try:
        known = COLLISION_SHAPES[type(shape.geometry)]
        make = known.make(shape.geometry, ShapeContext(rows, material, resources))
    except EngineFailure as failure:
        failure.origin = failure.origin or shape.origin
        raise
    found = SHAPE_PROPERTIES.steps(shape, rows)
    if groups is not None:
        found += property_setters(COLLISION_GROUPS, groups, rows)
    if shape.pose is not None:
        found = property_setters(SHAPE_POSE, shape.pose, rows) + found
    if shape.density is None and isinstance(shape.geometry, Plane):
        # SAPIEN's builder leaves a plane the density of a new shape.
        found.append((SHAPE_PROPERTIES.by_field["density"].set, [0.0]))
    if any(holders):
        found.append((add_shape, holders))
    fixed, varying = split_setters(found)
    return PreparedShape(make, fixed, varying, known.many, _rows_of_files(shape.geometry, rows), "SC801", shape.origin)


def _prepare_visual(shape: VisualShape, rows: NDArray[np.intp], resources: Resources, entity: Entity) -> PreparedShape:
    try:
        material = None if shape.material is None else resources.visual(shape.material, rows, entity.scene_idxs)
        make = VISUAL_SHAPES[type(shape.geometry)].make(shape.geometry, ShapeContext(rows, material, resources))
    except EngineFailure as failure:
        failure.origin = failure.origin or shape.origin
        raise
    found = [] if shape.pose is None else property_setters(VISUAL_POSE, shape.pose, rows)
    faces = front_face_column(shape.geometry, shape.front_face, rows)
    if faces is not None:
        found.append((render.RenderShape.set_front_face, faces))
    if shape.name:
        found.append((render.RenderShape.set_name, [shape.name]))
    fixed, varying = split_setters(found)
    return PreparedShape(make, fixed, varying, False, _rows_of_files(shape.geometry, rows), "SC807", shape.origin)


def _rows_of_files(geometry: CollisionGeometry | VisualGeometry, rows: NDArray[np.intp]) -> tuple[int, ...]:
    if not isinstance(geometry, MeshGeometry):
        return ()
    _, first = np.unique(select_rows(geometry.file, rows), return_index=True)
    return tuple(first.tolist())


def prepare_mass(
    structure: BodyStructure, rows: NDArray[np.intp], drawn: DrawnObjects
) -> Callable[[Any, int], None] | None:
    """Returns a function that sets a component's mass once its shapes are attached. None: the mass follows from
    densities.

    `drawn` receives mass and inertia by density if a reset redraws the mass.
    """
    steps: list[Callable[[Any, int], None]] = []
    if structure.inertial is not None:
        steps.append(_inertial_setter(structure.inertial, rows))
    if structure.mass is not None:
        steps.append(_mass_setter(structure.mass, rows, structure.origin, drawn))
    if structure.com is not None:
        column = _expand_column(to_vectors(select_rows(structure.com, rows)), len(rows))
        steps.append(lambda component, row: set_center_of_mass(component, column[row]))
    if len(steps) < 2:
        return steps[0] if steps else None

    def apply(component: Any, row: int) -> None:
        for step in steps:
            step(component, row)

    return apply


def _inertial_setter(inertial: Inertial, rows: NDArray[np.intp]) -> Callable[[Any, int], None]:
    """Returns a function that sets the given mass, centre of mass and inertia on a component of one of `rows`."""
    mass = _expand_column(to_scalars(select_rows(inertial.mass, rows)), len(rows))
    com = _expand_column(to_poses(select_rows(inertial.com, rows)), len(rows))
    inertia = _expand_column(to_vectors(select_rows(inertial.inertia, rows)), len(rows))

    def step(component: Any, row: int) -> None:
        """Sets the values of the row."""
        component.set_mass(mass[row])
        component.set_cmass_local_pose(com[row])
        component.set_inertia(inertia[row])

    return step


def _mass_setter(
    value: Value, rows: NDArray[np.intp], origin: Origin | None, drawn: DrawnObjects
) -> Callable[[Any, int], None]:
    """Returns a function that sets the mass, and scales the inertia that the engine computed from the densities."""
    is_drawn_anew = value.recipe is not None
    mass = _expand_column(to_scalars(select_rows(value, rows)), len(rows))

    def step(component: Any, row: int) -> None:
        """Sets the mass of the row. Raises EngineFailure (SC512) if the computed one cannot be scaled."""
        computed = component.get_mass()
        if not 0 < computed < np.inf:
            # The size of a mesh is known only here; other shapes were checked before.
            message = f"the densities give a mass of {computed} kg, so the inertia cannot be scaled"
            raise EngineFailure("SC512", message, origin=origin, hint="fix the scale (metres) or the density (kg/m³)")
        # In float64, and rounded once by the engine: see "Numbers" in the language reference.
        inertia = component.get_inertia().astype(np.float64)
        if is_drawn_anew:
            drawn.densities[component] = computed, inertia
        inertia = inertia * (mass[row] / computed)
        component.set_mass(mass[row])
        component.set_inertia(inertia)

    return step


def _expand_column(column: list[Any], length: int) -> list[Any]:
    return column if len(column) == length else column * length


class PreparedBody:
    """A body or a link of the plan: its shapes, its mass and its properties, for each of its rows.

    Attributes:
        name: of its components.
        visuals: its visual shapes, in the order of the plan; empty without rendering.
    """

    def __init__(
        self,
        name: str,
        entity: Entity,
        structure: BodyStructure,
        rows: NDArray[np.intp],
        resources: Resources,
        *,
        rendered: bool,
    ) -> None:
        self.name = name
        self._collisions = tuple(
            _prepare_collision(shape, groups, rows, resources, entity)
            for shape, groups in zip(structure.collisions, structure.shape_groups(), strict=True)
        )
        visuals = structure.visuals if rendered else ()
        self.visuals = tuple(_prepare_visual(shape, rows, resources, entity) for shape in visuals)
        self._set_mass = prepare_mass(structure, rows, resources.drawn)
        self._properties = split_setters(BODY_PROPERTIES.steps(structure, rows))
        self._look = split_setters(RENDER_PROPERTIES.steps(structure, rows) if self.visuals else [])

    def cook(self) -> list[EngineFailure]:
        """Reads and cooks every file once, so that all failures are known before any scene is built."""
        tried = [_cooking_failure(shape, row) for shape in (*self._collisions, *self.visuals) for row in shape.samples]
        return [failure for failure in tried if failure is not None]

    def fill(self, component: Any, row: int) -> None:
        """Sets shapes, mass and properties of a new physical component for a row.

        Raises:
            EngineFailure: the engine cannot make one of the shapes.
        """
        for shape in self._collisions:
            attach_shape(component, shape, row)
        if self._set_mass is not None:
            self._set_mass(component, row)
        apply_setters(self._properties, component, row)
        component.set_name(self.name)

    def make_render_component(self, row: int) -> Any:
        """Returns a render component with the visuals of a row. Raises EngineFailure as `fill` does."""
        component = render.RenderBodyComponent()
        for shape in self.visuals:
            attach_shape(component, shape, row)
        apply_setters(self._look, component, row)
        component.set_name(self.name)
        return component


_COMPONENTS: dict[str, Any] = {
    "dynamic": physx.PhysxRigidDynamicComponent,
    "kinematic": physx.PhysxRigidDynamicComponent,
    "static": physx.PhysxRigidStaticComponent,
    "none": None,
}


class BatchActorBuilder(sapien.ActorBuilder):
    """Builds one structure of an entity, once for each of its rows.

    A shape that cannot be cooked raises `EngineFailure`; SAPIEN's builder would skip it silently. A body of type none
    is an entity with only a render component.

    Attributes:
        row: the row that the methods of SAPIEN's builder (`build`, `build_entity`, …) make.
    """

    def __init__(
        self,
        entity: Entity,
        structure: BodyStructure,
        rows: NDArray[np.intp],
        resources: Resources,
        *,
        rendered: bool,
    ) -> None:
        super().__init__()
        if structure.body_type in ("static", "none"):
            _refuse_unsupported_fields(structure)
        # Shapes come only from the plan, so SAPIEN's add_* methods, which append to these, must fail.
        self.collision_records = self.visual_records = ()  # pyright: ignore[reportAttributeAccessIssue]
        self.name = entity.name
        self.physx_body_type = structure.body_type
        self.row = 0
        self._origin = structure.origin
        self._component = _COMPONENTS[structure.body_type]
        self._body = PreparedBody(entity.name, entity, structure, rows, resources, rendered=rendered)
        self._only_pose: Any = None
        if entity.pose.varies:
            # One at a time, while the objects are still in the processor's cache.
            self._p, self._q = split_poses(select_rows(entity.pose, rows))
        else:
            numbers = entity.pose.as_drawn()
            self._only_pose = sapien.Pose(numbers[:3], numbers[3:])

    def cook(self) -> list[EngineFailure]:
        """Cooks every mesh once and returns the failures."""
        return self._body.cook()

    def make(self, row: int) -> tuple[Any, Any]:
        """Returns a new entity, not yet in a scene, and its physical component (None if it has none).

        Raises:
            EngineFailure: the engine cannot make one of its shapes, or refuses a value.
        """
        try:
            return self._make(row)
        except (RuntimeError, TypeError, ValueError) as error:
            raise engine_refusal("this body", error, self._origin) from error

    def _make(self, row: int) -> tuple[Any, Any]:
        entity = sapien.Entity()
        component = None
        if self._body.visuals:
            entity.add_component(self._body.make_render_component(row))
        if self._component is not None:
            component = self._make_physx_component(row)
            entity.add_component(component)
        entity.set_name(self.name)
        pose = self._only_pose
        entity.set_pose(sapien.Pose(self._p[row], self._q[row]) if pose is None else pose)
        return entity, component

    def build_entity(self) -> Any:
        """Returns the entity of `row`, at its pose."""
        entity, _ = self.make(self.row)
        self.initial_pose = entity.pose
        return entity

    def build_physx_component(self, link_parent: None = None) -> Any:
        """Returns the physical component of `row`; None for the body type none."""
        del link_parent
        return None if self._component is None else self._make_physx_component(self.row)

    def build_render_component(self) -> Any:
        """Returns the render component of `row`."""
        return self._body.make_render_component(self.row)

    def _make_physx_component(self, row: int) -> Any:
        component = self._component()
        if self.physx_body_type == "kinematic":
            component.set_kinematic(True)
        self._body.fill(component, row)
        return component


def _refuse_unsupported_fields(structure: BodyStructure) -> None:
    """Refuses fields of a body type whose component cannot hold them, so that none is dropped silently."""
    said = [prop.get for prop, _ in BODY_PROPERTIES.list_specified(structure)]
    said += [name for name in ("mass", "com", "inertial") if getattr(structure, name) is not None]
    if structure.body_type == "none":
        said += [name for name in ("collisions", "collision_groups") if getattr(structure, name)]
    if said:
        raise EngineFailure(
            REFUSED_CODE, f"a body of type {structure.body_type} has no {said[0]}", origin=structure.origin
        )
