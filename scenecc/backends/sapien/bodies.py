"""The engine's objects of one entity, as the classes of a batch share them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.selected import scene_indices

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Bodies:
    """One entity's bodies, one for each scene of the batch that has it.

    Attributes:
        scene_idxs: indices among all scenes of the plan, ascending.
        objs, components: the `sapien.Entity` and its physical component (None where it has none) of each scene.
        row_of: scene index → row of the above.
    """

    name: str
    scene_idxs: tuple[int, ...]
    objs: list[Any]
    components: list[Any]
    row_of: dict[int, int] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "row_of", {index: row for row, index in enumerate(self.scene_idxs)})

    def rows_in(self, scene_idxs: Iterable[int]) -> list[int]:
        """The rows of those of the scenes that have it, in the order given."""
        return [self.row_of[index] for index in scene_idxs if index in self.row_of]


@dataclass(frozen=True, slots=True)
class Articulations:
    """One entity's articulations, one for each scene of the batch that has it; made while all are in their scenes.

    Attributes:
        scene_idxs, row_of: as of `Bodies`.
        objs: the `PhysxArticulation` of each scene.
        entities, links: those of its links in each scene, in the order of the plan, in which they are added.
        joints: those that move, in the order of the engine's `qpos`. Outside of a scene it names none.
        columns: where in `qpos` each of them is that moves, in the order of the plan.
        dof: how many move, at most.
    """

    name: str
    scene_idxs: tuple[int, ...]
    objs: list[Any]
    entities: list[list[Any]]
    links: list[list[Any]]
    joints: list[list[Any]] = field(init=False)
    columns: list[NDArray[np.intp]] = field(init=False)
    dof: int = field(init=False)
    row_of: dict[int, int] = field(init=False)

    def __post_init__(self) -> None:
        joints = [obj.get_active_joints() for obj in self.objs]
        object.__setattr__(self, "row_of", {index: row for row, index in enumerate(self.scene_idxs)})
        object.__setattr__(self, "joints", joints)
        object.__setattr__(self, "columns", list(map(_columns, self.links)))
        object.__setattr__(self, "dof", max(map(len, joints), default=0))

    def rows_in(self, scene_idxs: Iterable[int]) -> list[int]:
        """The rows of those of the scenes that have it, in the order given."""
        return [self.row_of[index] for index in scene_idxs if index in self.row_of]

    def in_scene(self, row: int) -> bool:
        """Whether it is in its scene now."""
        return self.entities[row][0].get_scene() is not None


def _columns(links: list[Any]) -> NDArray[np.intp]:
    moving = [link.get_index() for link in links if link.get_joint().get_dof()]
    return np.argsort(np.argsort(moving))


def entities_of(held: Bodies | Articulations) -> Iterator[tuple[int, Any]]:
    """Scene index and `sapien.Entity` of each body, in build order in each scene."""
    if isinstance(held, Bodies):
        yield from zip(held.scene_idxs, held.objs, strict=True)
    else:
        for index, entities in zip(held.scene_idxs, held.entities, strict=True):
            yield from ((index, entity) for entity in entities)


def chosen_rows(held: Bodies | Articulations, scene_idxs: Sequence[int] | None) -> Sequence[int]:
    """The rows of the scenes that a user names, or all. Raises KeyError for one that has not the entity."""
    if scene_idxs is None:
        return range(len(held.objs))
    asked = scene_indices(scene_idxs)
    missing = [index for index in asked if index not in held.row_of]
    if missing:
        there = list(held.scene_idxs)
        raise KeyError(f"'{held.name}' is not in scene {missing[0]} of this batch; it is in {there}")
    return [held.row_of[index] for index in asked]


def can_move(component: Any) -> bool:
    """Whether a body has velocities of its own: it is dynamic, and not made kinematic meanwhile."""
    return isinstance(component, physx.PhysxRigidDynamicComponent) and not component.get_kinematic()


def is_kinematic(component: Any) -> bool:
    """Whether the engine moves a body by its pose alone, and has targets for it."""
    return isinstance(component, physx.PhysxRigidDynamicComponent) and component.get_kinematic()


def root_is_fixed(links: Sequence[Any]) -> bool:
    """Whether the first of an articulation's links is fixed to the world."""
    return links[0].get_joint().get_type() == "fixed"
