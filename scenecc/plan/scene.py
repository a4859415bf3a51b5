"""The plan of a batch of scenes: what is built, where, and in which order, and the settings of the simulation. It
knows neither an engine nor the language.
"""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.plan.body import AssetFile, BodyStructure, Friction, PhysicalMaterial, VisualMaterial

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.geometry.rotations import Vec3
    from scenecc.plan.articulation import ArticulationStructure
    from scenecc.plan.constraint import Constraint
    from scenecc.plan.expect import Condition, NoOverlap, Settled
    from scenecc.plan.placement import Placement
    from scenecc.plan.rendering import Camera, Environment, Light
    from scenecc.plan.value import Value
    from scenecc.variation.nodes import Node


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


@frozen
class Entity:
    """One logical object: a body or an articulation in each of its scenes.

    Attributes:
        name: unique in the plan.
        scene_idxs: the scenes it exists in, ascending, without repetition; not empty. Rows of every
            `Value` below follow this order.
        pose: (·, 7) in the world of its scene, p [m] then q (wxyz).
        structures: one, or one a variant; all bodies or all articulations.
        pick: (·,) which structure each of its scenes has; None: all have the first.
        hidden: whether only people see it, and no sensor.
    """

    name: str
    scene_idxs: tuple[int, ...]
    pose: Value
    structures: tuple[BodyStructure | ArticulationStructure, ...]
    pick: Value | None = None
    hidden: bool = False
    origin: Origin | None = field(default=None, compare=False)

    def structure(self, row: int) -> BodyStructure | ArticulationStructure:
        """The structure in its scene number `row` (not a scene index)."""
        return self.structures[0 if self.pick is None else int(self.pick.row(row))]

    @property
    def bodies(self) -> tuple[BodyStructure, ...]:
        """The bodies of all its structures, links of articulations among them."""
        return tuple(body for structure in self.structures for body in structure.bodies)


def structure_type(structure: BodyStructure | ArticulationStructure) -> str:
    """What a structure is called: a body's type, or "articulation"."""
    return structure.body_type if isinstance(structure, BodyStructure) else "articulation"


@frozen
class ScenePlan:
    """A whole batch, ready to be instantiated or emitted.

    `entities` stand in the order in which they are built: PhysX gives other trajectories in another.
    `draws` are the shared draws that recipes and expectations read, by name; one may read those before it. Among them
    are poses that recipes go on from, see `scenecc.plan.scene`. `placements` stand in the order in which they are made.
    Constraints, lights and cameras are built after the entities. Nothing is built of `expectations`.
    """

    name: str
    num_scenes: int
    entities: tuple[Entity, ...]
    physics: Physics
    files: tuple[AssetFile, ...] = ()
    physical_materials: tuple[PhysicalMaterial, ...] = ()
    visual_materials: tuple[VisualMaterial, ...] = ()
    constraints: tuple[Constraint, ...] = ()
    environment: Environment | None = None
    lights: tuple[Light, ...] = ()
    cameras: tuple[Camera, ...] = ()
    description: str = ""
    seed: int = 0
    placements: tuple[Placement, ...] = ()
    expectations: tuple[Settled | NoOverlap | Condition, ...] = ()
    draws: tuple[tuple[str, Node], ...] = ()
    origin: Origin | None = field(default=None, compare=False)


MAX_COMPOSED_POSES = 16
"""How many poses one recipe composes before it goes on from a shared one: what is nested more cannot be read back."""

_POSE_SUFFIX, _ONCE_SUFFIX = ".pose", ".once"


def shared_pose_name(name: str, number: int = 0) -> str:
    """What the pose of an entity or a frame is called, as no draw of a file is. `number`: of several such poses."""
    return f"{name}{_POSE_SUFFIX}.{number}" if number else name + _POSE_SUFFIX


def kept_draw_name(path: str) -> str:
    """What the value of a `once` is called, as no draw of a file is. `path`: of the keys that lead to it."""
    return path + _ONCE_SUFFIX


def is_unnamed_draw(name: str) -> bool:
    """Whether a shared draw is a pose or the value of a `once`. A draw of a file has no dot after its scope."""
    return "." in name.rpartition("/")[2]


def find_body(name: str, entities: Mapping[str, Entity]) -> tuple[Entity, str | None] | None:
    """The entity of ENTITY or ENTITY/LINK, by its longest name, and the link; None where there is none.

    A link that only some of the articulation's structures have is one.
    """
    ahead = name
    while ahead not in entities and "/" in ahead:
        ahead = ahead.rpartition("/")[0]
    entity, link = entities.get(ahead), name[len(ahead) + 1 :] or None
    if entity is None or link is None:
        return None if entity is None else (entity, None)
    links = (part for one in entity.structures if not isinstance(one, BodyStructure) for part in one.links)
    return (entity, link) if any(part.name == link for part in links) else None


def has_joint(entity: Entity, joint: str) -> bool:
    """Whether a joint of the name moves in any of an articulation's structures."""
    return any(
        link.joint is not None and link.joint.name == joint and link.joint.type != "fixed"
        for one in entity.structures
        if not isinstance(one, BodyStructure)
        for link in one.links
    )
