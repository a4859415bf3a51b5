"""The lights of a plan that has none: without any, every picture would be black."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from scenecc.plan.scene import ScenePlan

AMBIENT: Final = (0.3, 0.3, 0.3)
DIRECTIONS: Final = ((1.0, 1.0, -1.0), (0.0, 0.0, -1.0))
"""Ambient light, and where two white directional lights without shadows shine to: as in ManiSkill's tasks."""


def is_unlit(plan: ScenePlan) -> bool:
    """Whether a plan has neither a light nor an ambient light nor a map, so that it is seen under these."""
    around = plan.environment
    return not plan.lights and (around is None or (around.ambient_light is None and around.map is None))
