"""A strict, table-driven `ArticulationBuilder` for batches. Links, joints and tendons are prepared once and made in
every scene.

The order of operations is that of SAPIEN's `ArticulationBuilder.build` and the calls that a user makes after it: links
with their shapes and joints, the pose of the root, tendons, adding the entities to the scene; properties of the
articulation, velocities of the root, `qpos`, `qvel`. Joint properties are set when the joint is made, which has the
same effect in the engine. Velocities of links follow from those of the root once `qpos` or `qvel` is set.

`qpos` is always set, if only to its default. SAPIEN then moves the entities of all links to their poses; otherwise
those of a new articulation stay at the origin until it is stepped.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.builder import PreparedBody
from scenecc.backends.sapien.engine import REFUSED_CODE, EngineFailure, engine_refusal, physx, sapien
from scenecc.backends.sapien.properties import (
    ARTICULATION_PROPERTIES,
    BODY_PROPERTIES,
    DRIVE_DEFAULTS,
    JOINT_FRAMES,
    JOINT_LIMITS,
    JOINT_PROPERTIES,
    LINK_CLASS,
    LINK_FIELDS,
    ROOT_PROPERTIES,
    apply_setters,
    row_item,
    select_rows,
    split_setters,
    to_poses,
    to_scalars,
    zip_columns,
)
from scenecc.plan.articulation import (
    MAX_LINKS,
    tendon_coefficients,
    tendon_links,
    tendon_pull,
)
from scenecc.plan.tendons import soft_tendon
from scenecc.plan.value import Value
from scenecc.plan.walk import walk_fields

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from numpy.typing import NDArray

    from scenecc.backends.sapien.assets import Resources
    from scenecc.backends.sapien.properties import SetterColumn
    from scenecc.plan import ArticulationStructure, BodyStructure, Entity, Joint, Link, Mimic


class PreparedJoint:
    """The setter calls for a link's joint, row by row."""

    __slots__ = ("_properties", "_setters", "name", "type")

    def __init__(self, joint: Joint, rows: NDArray[np.intp]) -> None:
        self.name = joint.name
        self.type = joint.type
        # Always set: the engine stores frames relative to the centre of mass, which the shapes have moved by then, and
        # rounds them.
        self._setters: list[SetterColumn] = [
            (frame.set, frame.column(getattr(joint, field), rows)) for field, frame in JOINT_FRAMES.items()
        ]
        if joint.type != "fixed":
            self._setters.append((JOINT_LIMITS.set, JOINT_LIMITS.column(joint.limits, rows)))
            self._setters.append((lambda obj, values: obj.set_drive_properties(*values), drive_properties(joint, rows)))
        self._properties = split_setters([] if joint.type == "fixed" else JOINT_PROPERTIES.steps(joint, rows))

    def apply(self, joint: Any, row: int) -> None:
        """Sets the type and properties of a new link's joint, in the order of SAPIEN's builder."""
        joint.set_name(self.name)
        joint.set_type(self.type)
        for setter, column in self._setters:
            setter(joint, row_item(column, row))
        apply_setters(self._properties, joint, row)


def drive_properties(joint: Joint, rows: NDArray[np.intp]) -> list[tuple[Any, ...]]:
    """Returns stiffness, damping, force limit and mode for each row, or once for all, with SAPIEN's defaults."""
    columns = [
        [default] if (value := getattr(joint, field)) is None else to_scalars(select_rows(value, rows))
        for field, default in DRIVE_DEFAULTS.items()
    ]
    return zip_columns([*columns, [joint.drive_mode or "force"]])


class PreparedLink:
    """How to make one link of the plan, row by row.

    Attributes:
        parent: index of the parent link. None: it is the root.
        body: its shapes and properties.
    """

    __slots__ = ("_joint", "_origin", "body", "parent")

    def __init__(
        self, link: Link, entity: Entity, rows: NDArray[np.intp], resources: Resources, *, rendered: bool
    ) -> None:
        _refuse_link_fields(link.body)
        self.parent = link.parent
        self._origin = link.body.origin
        self.body = PreparedBody(link.name, entity, link.body, rows, resources, rendered=rendered)
        self._joint = None if link.joint is None else PreparedJoint(link.joint, rows)

    def make(self, parent: Any, row: int) -> tuple[Any, Any]:
        """Returns a new entity, not yet in a scene, and its link, a child of `parent`.

        Raises:
            EngineFailure: the engine cannot make one of its shapes, or refuses a value.
        """
        try:
            return self._make(parent, row)
        except (RuntimeError, TypeError, ValueError) as error:
            raise engine_refusal(f"the link '{self.body.name}'", error, self._origin) from error

    def _make(self, parent: Any, row: int) -> tuple[Any, Any]:
        link = LINK_CLASS(parent)
        self.body.fill(link, row)
        entity = sapien.Entity()
        entity.add_component(link)
        if self.body.visuals:
            entity.add_component(self.body.make_render_component(row))
        entity.set_name(self.body.name)
        if self._joint is not None:
            self._joint.apply(link.get_joint(), row)
        return entity, link


def _refuse_link_fields(body: BodyStructure) -> None:
    """Refuses properties that SAPIEN's links lack, so that none is dropped silently."""
    said = [prop.get for prop, _ in BODY_PROPERTIES.list_specified(body) if prop.get not in LINK_FIELDS]
    if said:
        raise EngineFailure(REFUSED_CODE, f"a link has no {said[0]}", origin=body.origin)


def _prepare_tendon(
    structure: ArticulationStructure, mimic: Mimic, rows: NDArray[np.intp], timestep: float
) -> Callable[[Any, list[Any], int], None]:
    try:
        over = tendon_links(structure, mimic)
    except ValueError as error:
        raise EngineFailure(REFUSED_CODE, str(error), origin=mimic.origin or structure.origin) from None
    numbers = np.broadcast_arrays(select_rows(mimic.multiplier, rows), select_rows(mimic.offset, rows))
    pulls = [tendon_pull(*pair) for pair in zip(*(column.tolist() for column in numbers), strict=True)]
    made = [(tendon_coefficients(structure, mimic, over, ends), ends.rest_length) for ends in pulls]
    known: dict[tuple[float, ...], tuple[list[float], float]] | None = {} if _has_one_inertia(structure) else None

    def soften(links: list[Any], coefficients: list[float]) -> tuple[list[float], float]:
        found = None if known is None else known.get(tuple(coefficients))
        if found is None:
            temporal = physx.get_scene_config().enable_tgs
            found = soft_tendon(links, list(over), coefficients, timestep, temporal=temporal)
            if known is not None:
                known[tuple(coefficients)] = found
        return found

    def bind(articulation: Any, links: list[Any], row: int) -> None:
        coefficients, rest_length = row_item(made, row)
        shares, stiffness = soften(links, coefficients)
        articulation.create_fixed_tendon(
            [links[number] for number in over], coefficients, shares, rest_length=rest_length, stiffness=stiffness
        )

    return bind


def _has_one_inertia(structure: ArticulationStructure) -> bool:
    """Whether masses, joint frames, armatures and solver iterations are the same in all scenes."""
    values: list[Any] = [structure.solver_position_iterations]
    for link in structure.links:
        values += [item for _, _, item in walk_fields(link.body)]
        values += [getattr(link.joint, name, None) for name in ("pose_in_parent", "pose_in_child", "armature")]
    return not any(isinstance(value, Value) and value.may_vary for value in values)


class BatchArticulationBuilder:
    """Builds one structure of an entity, once for each of its rows."""

    def __init__(
        self,
        entity: Entity,
        structure: ArticulationStructure,
        rows: NDArray[np.intp],
        resources: Resources,
        *,
        rendered: bool,
    ) -> None:
        _refuse_unsupported_articulation(structure)
        self._name = entity.name
        self._origin = structure.origin or entity.origin
        self._structure = structure
        self._rows = rows
        self._links = [PreparedLink(link, entity, rows, resources, rendered=rendered) for link in structure.links]
        self._root_type = "fixed" if structure.fix_root_link else "undefined"
        self._poses = to_poses(select_rows(entity.pose, rows))
        self._tendons = [_prepare_tendon(structure, mimic, rows, resources.timestep) for mimic in structure.mimics]
        self._properties = split_setters(ARTICULATION_PROPERTIES.steps(structure, rows))
        self._velocities = split_setters(ROOT_PROPERTIES.steps(structure, rows))
        self._qpos: list[NDArray[np.float32]] | None = None
        self._qvel: list[NDArray[np.float32]] = []

    def cook(self) -> list[EngineFailure]:
        """Cooks every mesh once and returns the failures."""
        return [failure for link in self._links for failure in link.body.cook()]

    def make(self, row: int) -> tuple[list[Any], list[Any]]:
        """Returns new entities, not yet in a scene, and their links, in the order of the plan. The root is at its pose.

        Raises:
            EngineFailure: the engine cannot make a shape, or refuses a value.
        """
        entities: list[Any] = []
        links: list[Any] = []
        for steps in self._links:
            entity, link = steps.make(None if steps.parent is None else links[steps.parent], row)
            entities.append(entity)
            links.append(link)
        links[0].get_joint().set_type(self._root_type)
        entities[0].set_pose(row_item(self._poses, row))
        if self._tendons:
            articulation = links[0].get_articulation()
            with self._report_refusal():
                apply_setters(self._properties, articulation, row)  # tendons depend on the number of solver iterations
            for tendon in self._tendons:
                tendon(articulation, links, row)
        return entities, links

    def settle(self, links: list[Any], row: int) -> Any:
        """Returns the articulation of links that are in a scene, with its name and properties, but not yet in its
        initial state.

        Raises:
            EngineFailure: the engine refuses a value.
        """
        articulation = links[0].get_articulation()
        with self._report_refusal():
            articulation.set_name(self._name)
            apply_setters(self._properties, articulation, row)
        return articulation

    def start(self, links: list[Any], row: int) -> Any:
        """Returns the articulation of links that are in a scene, in its initial state.

        Raises:
            EngineFailure: the engine refuses a value.
        """
        articulation = self.settle(links, row)
        with self._report_refusal():
            self._start(articulation, links, row)
        return articulation

    @contextmanager
    def _report_refusal(self) -> Generator[None]:
        try:
            yield
        except (RuntimeError, TypeError, ValueError) as error:
            raise engine_refusal(f"the articulation '{self._name}'", error, self._origin) from error

    def _start(self, articulation: Any, links: list[Any], row: int) -> None:
        if self._qpos is None:
            order = engine_joint_order(self._structure, links)
            self._qpos = list(joint_rows(self._structure, "qpos", self._rows, order))
            if any(joint.qvel is not None for joint in self._structure.active_joints):
                self._qvel = list(joint_rows(self._structure, "qvel", self._rows, order))
        apply_setters(self._velocities, articulation, row)
        set_joint_positions(articulation, row_item(self._qpos, row))
        if self._qvel:
            articulation.set_qvel(row_item(self._qvel, row))


def set_joint_positions(articulation: Any, qpos: NDArray[np.float32]) -> None:
    """Sets `qpos`, which also moves the entities of all links. Without active joints, only moves the entities."""
    if len(qpos):
        articulation.set_qpos(qpos)
    else:
        articulation.set_root_pose(articulation.get_root_pose())


def engine_joint_order(structure: ArticulationStructure, links: list[Any]) -> NDArray[np.intp]:
    """Returns indices among `active_joints` in the order of the engine's `qpos`, level by level."""
    moving = [n for n, link in enumerate(structure.links) if link.joint is not None and link.joint.type != "fixed"]
    return np.argsort([links[number].get_index() for number in moving], kind="stable")


def joint_rows(
    structure: ArticulationStructure, field: str, rows: NDArray[np.intp], order: NDArray[np.intp]
) -> NDArray[np.float32]:
    """Returns a field of the active joints, (B, dof) or (1, dof), in the given order; 0 by default."""
    columns = [getattr(joint, field) for joint in structure.active_joints]
    data = [np.zeros(1) if value is None else select_rows(value, rows) for value in columns]
    found = np.stack(np.broadcast_arrays(*data), axis=-1) if data else np.zeros((1, 0))
    return np.ascontiguousarray(found[:, order], dtype=np.float32)


def _refuse_unsupported_articulation(structure: ArticulationStructure) -> None:
    count = len(structure.links)
    if count > MAX_LINKS:
        message = f"an articulation has {count} links; PhysX on the CPU supports at most {MAX_LINKS}"
        raise EngineFailure(REFUSED_CODE, message, origin=structure.origin)
    if structure.fix_root_link and (said := [prop.get for prop, _ in ROOT_PROPERTIES.list_specified(structure)]):
        raise EngineFailure(REFUSED_CODE, f"a fixed root has no {said[0]}", origin=structure.origin)
