"""The engine's objects of one entity, as the classes of a batch share them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.engine import physx

if TYPE_CHECKING:
    from collections.abc import Iterable


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


def can_move(component: Any) -> bool:
    """Whether a body has velocities of its own: it is dynamic, and not made kinematic meanwhile."""
    return isinstance(component, physx.PhysxRigidDynamicComponent) and not component.get_kinematic()


def is_kinematic(component: Any) -> bool:
    """Whether the engine moves a body by its pose alone, and has targets for it."""
    return isinstance(component, physx.PhysxRigidDynamicComponent) and component.get_kinematic()
