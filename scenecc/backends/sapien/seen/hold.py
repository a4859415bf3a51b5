"""Where lights and cameras are put: on an entity of their own, or on the body that they are mounted on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.columns import poses
from scenecc.backends.sapien.engine import sapien
from scenecc.backends.sapien.failure import EngineFailure

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from scenecc.backends.sapien.standing import Standing
    from scenecc.plan import Camera, Light


def hold(component: Any, held: Light | Camera, row: int, standing: Standing, number: int) -> None:
    """Puts a component into a scene.

    Args:
        component: of SAPIEN's, in no entity yet.
        held: what it is in the plan.
        row: its row in the plan's values.
        standing: what stands in the scenes.
        number: of the scene.

    Raises:
        EngineFailure: the renderer cannot take it.
    """
    component.name = held.name
    try:
        if held.mount is not None:
            standing.entity(held.mount, number).add_component(component)
            component.local_pose = pose_of(held.pose.row(row))
            return
        entity: Any = sapien.Entity()
        entity.name = held.name
        entity.add_component(component)
        entity.set_pose(pose_of(held.pose.row(row)))
        standing.scenes[number].add_entity(entity)
    except RuntimeError as error:
        raise EngineFailure("SC807", f"the renderer cannot make '{held.name}': {error}", origin=held.origin) from error


def pose_of(numbers: NDArray[np.float64]) -> Any:
    """A `sapien.Pose` of p, then q (7,)."""
    return poses(numbers[None])[0]
