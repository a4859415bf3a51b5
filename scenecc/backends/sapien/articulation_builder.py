"""A strict, table-driven `ArticulationBuilder` for batches: everything that is the same is prepared once.

The order of operations is that of SAPIEN's `ArticulationBuilder.build`, and then what a user calls: links with their
shapes and joints, the pose of the root, tendons, the entities into the scene; the articulation's own numbers,
velocities of the root, `qpos`, `qvel`. What has a setter on a joint is set with the joint, which the engine takes as
the same. The velocities of links follow those of the root once `qpos` or `qvel` is set.

`qpos` is always set, to what a new articulation has where nothing is said: SAPIEN then moves the entities of all links
to where they are, which a fresh articulation leaves at the origin until it is stepped.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.columns import at, poses, taken
from scenecc.backends.sapien.failure import REFUSED, EngineFailure
from scenecc.backends.sapien.knobs import ARTICULATION_KNOBS, ROOT_KNOBS
from scenecc.backends.sapien.links import LinkSteps
from scenecc.backends.sapien.shapes import apply, split
from scenecc.backends.sapien.tendons import tendons
from scenecc.plan.articulation import MAX_LINKS

if TYPE_CHECKING:
    from collections.abc import Generator

    from numpy.typing import NDArray

    from scenecc.backends.sapien.resources import Resources
    from scenecc.plan import ArticulationStructure, Entity


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
        _refuse_what_cannot_be(structure)
        self._name = entity.name
        self._origin = structure.origin or entity.origin
        self._structure = structure
        self._rows = rows
        self._links = [LinkSteps(link, rows, resources, rendered=rendered) for link in structure.links]
        self._root_type = "fixed" if structure.fix_root_link else "undefined"
        self._poses = poses(taken(entity.pose, rows))
        self._tendons = tendons(structure, rows)
        self._knobs = split(ARTICULATION_KNOBS.steps(structure, rows))
        self._velocities = split(ROOT_KNOBS.steps(structure, rows))
        self._qpos: list[NDArray[np.float32]] | None = None
        self._qvel: list[NDArray[np.float32]] = []

    def cook(self) -> list[EngineFailure]:
        """Cooks every mesh once; what the engine refuses."""
        return [failure for link in self._links for failure in link.cook()]

    def make(self, row: int) -> tuple[list[Any], list[Any]]:
        """New entities, not yet in a scene, and their links, in the order of the plan. The root is at its pose.

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
        entities[0].set_pose(at(self._poses, row))
        if self._tendons:
            articulation = links[0].get_articulation()
            for tendon in self._tendons:
                tendon(articulation, links, row)
        return entities, links

    def settle(self, links: list[Any], row: int) -> Any:
        """The articulation of links that are in a scene now, with its name and numbers, and not yet at its start.

        Raises:
            EngineFailure: the engine refuses a value.
        """
        articulation = links[0].get_articulation()
        with self._told():
            articulation.set_name(self._name)
            apply(self._knobs, articulation, row)
        return articulation

    def start(self, links: list[Any], row: int) -> Any:
        """The articulation of links that are in a scene now, at its start.

        Raises:
            EngineFailure: the engine refuses a value.
        """
        articulation = self.settle(links, row)
        with self._told():
            self._start(articulation, links, row)
        return articulation

    @contextmanager
    def _told(self) -> Generator[None]:
        try:
            yield
        except (RuntimeError, TypeError, ValueError) as error:
            words = str(error).partition("\n")[0]
            message = f"the engine refuses the articulation '{self._name}': {words}"
            raise EngineFailure(REFUSED, message, origin=self._origin) from error

    def _start(self, articulation: Any, links: list[Any], row: int) -> None:
        if self._qpos is None:
            order = engine_order(self._structure, links)
            self._qpos = list(joint_rows(self._structure, "qpos", self._rows, order))
            if any(joint.qvel is not None for joint in self._structure.active_joints):
                self._qvel = list(joint_rows(self._structure, "qvel", self._rows, order))
        apply(self._velocities, articulation, row)
        place(articulation, at(self._qpos, row))
        if self._qvel:
            articulation.set_qvel(at(self._qvel, row))


def place(articulation: Any, qpos: NDArray[np.float32]) -> None:
    """Sets `qpos`, and with it the poses of the entities of all links; without joints that move, these alone."""
    if len(qpos):
        articulation.set_qpos(qpos)
    else:
        articulation.set_root_pose(articulation.get_root_pose())


def engine_order(structure: ArticulationStructure, links: list[Any]) -> NDArray[np.intp]:
    """Numbers among `active_joints` in the order of the engine's `qpos`: that of its links, level after level."""
    moving = [n for n, link in enumerate(structure.links) if link.joint is not None and link.joint.type != "fixed"]
    return np.argsort([links[number].get_index() for number in moving], kind="stable")


def joint_rows(
    structure: ArticulationStructure, field: str, rows: NDArray[np.intp], order: NDArray[np.intp]
) -> NDArray[np.float32]:
    """(B, dof) or (1, dof) of a number of the joints that move, in some order; 0 where nothing is said."""
    columns = [getattr(joint, field) for joint in structure.active_joints]
    data = [np.zeros(1) if value is None else taken(value, rows) for value in columns]
    found = np.stack(np.broadcast_arrays(*data), axis=-1) if data else np.zeros((1, 0))
    return np.ascontiguousarray(found[:, order], dtype=np.float32)


def _refuse_what_cannot_be(structure: ArticulationStructure) -> None:
    count = len(structure.links)
    if count > MAX_LINKS:
        message = f"an articulation of {count} links; PhysX on the CPU takes {MAX_LINKS} at most"
        raise EngineFailure(REFUSED, message, origin=structure.origin)
    if structure.fix_root_link and (said := [knob.get for knob, _ in ROOT_KNOBS.said(structure)]):
        raise EngineFailure(REFUSED, f"a root that is fixed has no {said[0]}", origin=structure.origin)
