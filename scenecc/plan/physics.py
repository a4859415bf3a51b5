"""Settings of the simulation, and the SAPIEN configuration that holds each. None means that SAPIEN's own value
applies.
"""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.plan.material import Friction


Vec3 = tuple[float, float, float]


@frozen
class SdfConfig:
    """`sapien.physx.set_sdf_config`. `spacing` [m]."""

    spacing: float | None = None
    subgrid_size: int | None = None
    num_threads_for_construction: int | None = None


@frozen
class GpuMemory:
    """`sapien.physx.set_gpu_memory_config`: capacities in bytes or in counts, as there."""

    temp_buffer_capacity: int | None = None
    max_rigid_contact_count: int | None = None
    max_rigid_patch_count: int | None = None
    heap_capacity: int | None = None
    found_lost_pairs_capacity: int | None = None
    found_lost_aggregate_pairs_capacity: int | None = None
    total_aggregate_pairs_capacity: int | None = None
    collision_stack_size: int | None = None


@frozen
class Physics:
    """What SAPIEN keeps per scene (`timestep` [s]) and as process-wide defaults (all others).

    Attributes:
        gravity: [m/s²], world frame.
        bounce_threshold: relative speed below which nothing bounces [m/s].
        contact_offset, rest_offset: of shapes that name none [m].
        scene_spacing: distance between scenes that share one GPU simulation [m].
    """

    timestep: float | None = None
    gravity: Vec3 | None = None
    bounce_threshold: float | None = None
    enable_pcm: bool | None = None
    enable_tgs: bool | None = None
    enable_ccd: bool | None = None
    enable_enhanced_determinism: bool | None = None
    enable_friction_every_iteration: bool | None = None
    cpu_workers: int | None = None
    default_material: Friction | None = None
    contact_offset: float | None = None
    rest_offset: float | None = None
    solver_position_iterations: int | None = None
    solver_velocity_iterations: int | None = None
    sleep_threshold: float | None = None
    sdf: SdfConfig | None = None
    scene_spacing: float | None = None
    gpu_memory: GpuMemory | None = None
    origin: Origin | None = field(default=None, compare=False)


SCENE_CONFIG_FIELDS = (
    "gravity",
    "bounce_threshold",
    "enable_pcm",
    "enable_tgs",
    "enable_ccd",
    "enable_enhanced_determinism",
    "enable_friction_every_iteration",
)
"""Properties of `physx.get_scene_config()`; the number of workers is an argument of its setter alone."""

_SHAPE_CONFIG_FIELDS = ("contact_offset", "rest_offset")

_BODY_CONFIG_FIELDS = ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")

SDF_CONFIG_NAMES = {
    "spacing": "spacing",
    "subgrid_size": "subgridSize",
    "num_threads_for_construction": "num_threads_for_construction",
}
"""The plan's names and SAPIEN's."""

CONFIG_KINDS = ("scene", "shape", "body", "sdf")
"""`physx.get_…_config()` and `physx.set_…_config()` of each."""


def process_wide_settings(physics: Physics) -> dict[str, dict[str, Any]]:
    """For each of `CONFIG_KINDS` what the plan says, by SAPIEN's names; empty where it says nothing."""
    sdf = physics.sdf
    said = {
        "scene": {name: getattr(physics, name) for name in SCENE_CONFIG_FIELDS},
        "shape": {name: getattr(physics, name) for name in _SHAPE_CONFIG_FIELDS},
        "body": {name: getattr(physics, name) for name in _BODY_CONFIG_FIELDS},
        "sdf": {} if sdf is None else {theirs: getattr(sdf, name) for name, theirs in SDF_CONFIG_NAMES.items()},
    }
    return {kind: {name: value for name, value in given.items() if value is not None} for kind, given in said.items()}
