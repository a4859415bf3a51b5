"""What is built in a scene once all its entities are there: one line for each section of the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.backends.sapien.standing import Addition, Standing
    from scenecc.plan import ScenePlan


def prepare_additions(plan: ScenePlan, standing: Standing, *, rendered: bool) -> list[Addition]:
    """Everything of them that is done once, in the order in which they are built: constraints, lights, cameras.

    Raises:
        EngineFailure: one cannot be prepared.
    """
    del plan, standing, rendered
    return []
