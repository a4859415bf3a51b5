"""Which of SAPIEN's process-wide configurations holds what of `Physics`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenecc.plan.physics import Physics

SCENE = (
    "gravity",
    "bounce_threshold",
    "enable_pcm",
    "enable_tgs",
    "enable_ccd",
    "enable_enhanced_determinism",
    "enable_friction_every_iteration",
)
"""Properties of `physx.get_scene_config()`; the number of workers is an argument of its setter alone."""

_SHAPE = ("contact_offset", "rest_offset")
_BODY = ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")
SDF = {
    "spacing": "spacing",
    "subgrid_size": "subgridSize",
    "num_threads_for_construction": "num_threads_for_construction",
}
"""The plan's names and SAPIEN's."""

CONFIGS = ("scene", "shape", "body", "sdf")
"""`physx.get_…_config()` and `physx.set_…_config()` of each."""


def process_settings(physics: Physics) -> dict[str, dict[str, Any]]:
    """For each of `CONFIGS` what the plan says, by SAPIEN's names; empty where it says nothing."""
    sdf = physics.sdf
    said = {
        "scene": {name: getattr(physics, name) for name in SCENE},
        "shape": {name: getattr(physics, name) for name in _SHAPE},
        "body": {name: getattr(physics, name) for name in _BODY},
        "sdf": {} if sdf is None else {theirs: getattr(sdf, name) for name, theirs in SDF.items()},
    }
    return {kind: {name: value for name, value in given.items() if value is not None} for kind, given in said.items()}
