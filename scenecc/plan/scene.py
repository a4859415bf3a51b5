"""The plan of a batch of scenes: the objects, their poses and build order, and the simulation settings. Independent of
the engine and of the language.
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
    """`sapien.physx.set_gpu_memory_config`: capacities in bytes or counts, as in SAPIEN."""

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
    """SAPIEN's settings per scene (`timestep` [s]) and process-wide defaults (all others).

    Attributes:
        gravity: [m/s²], world frame.
        bounce_threshold: relative speed below which nothing bounces [m/s].
        contact_offset, rest_offset: default for shapes [m].
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


DEFAULT_TIMESTEP = 0.01
"""SAPIEN's [s]."""

SCENE_CONFIG_FIELDS = (
    "gravity",
    "bounce_threshold",
    "enable_pcm",
    "enable_tgs",
    "enable_ccd",
    "enable_enhanced_determinism",
    "enable_friction_every_iteration",
)
"""Properties of `physx.get_scene_config()`. The number of workers is only an argument of its setter."""

_SHAPE_CONFIG_FIELDS = ("contact_offset", "rest_offset")

_BODY_CONFIG_FIELDS = ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")

SDF_CONFIG_NAMES = {
    "spacing": "spacing",
    "subgrid_size": "subgridSize",
    "num_threads_for_construction": "num_threads_for_construction",
}
"""The plan's names → SAPIEN's."""

CONFIG_KINDS = ("scene", "shape", "body", "sdf")
"""Each has `physx.get_…_config()` and `physx.set_…_config()`."""


def process_wide_settings(physics: Physics) -> dict[str, dict[str, Any]]:
    """The plan's settings for each of `CONFIG_KINDS`, by SAPIEN's names; empty if it has none."""
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
        scene_idxs: its scenes, ascending, unique, not empty. Rows of every `Value` below follow this order.
        pose: (·, 7) in the world of its scene, p [m] then q (wxyz).
        structures: one, or one per variant; all bodies or all articulations.
        pick: (·,) index of each scene's structure; None: the first.
        hidden: whether it is invisible to sensors and only shown to people.
    """

    name: str
    scene_idxs: tuple[int, ...]
    pose: Value
    structures: tuple[BodyStructure | ArticulationStructure, ...]
    pick: Value | None = None
    hidden: bool = False
    origin: Origin | None = field(default=None, compare=False)

    def structure(self, row: int) -> BodyStructure | ArticulationStructure:
        """The structure in row `row` (not a scene index)."""
        return self.structures[0 if self.pick is None else int(self.pick.row(row))]

    @property
    def bodies(self) -> tuple[BodyStructure, ...]:
        """The bodies of all its structures, including links."""
        return tuple(body for structure in self.structures for body in structure.bodies)


def structure_type(structure: BodyStructure | ArticulationStructure) -> str:
    """The type of a structure: a body's type, or "articulation"."""
    return structure.body_type if isinstance(structure, BodyStructure) else "articulation"


@frozen
class SettledStart:
    """Where the bodies of one scene came to rest with one seed.

    Attributes:
        seed: of all draws of the scene.
        scene: index of the scene.
        state: little-endian float32. For each entity of the scene that is not static, in build order, its pose (7,) and
            the positions of its active joints.
    """

    seed: int
    scene: int
    state: bytes


@frozen
class ScenePlan:
    """A whole batch, ready to be instantiated or emitted.

    `entities` are in build order, which affects PhysX's trajectories. `draws` are the shared draws by name, in order;
    each may read earlier ones. They include poses that recipes continue from (`shared_pose_name`). `placements` are in
    the order in which they are made. Constraints, lights and cameras are built after the entities. `expectations` are
    not built. If there are `starts`, the scenes begin there; the poses and joint positions of the entities are those
    that `seed` selects (`plan.starts`).
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
    starts: tuple[SettledStart, ...] = ()
    origin: Origin | None = field(default=None, compare=False)


MAX_COMPOSED_POSES = 16
"""Most poses that one recipe composes; longer chains continue from a shared pose, since the reader limits nesting."""

_POSE_SUFFIX, _ONCE_SUFFIX = ".pose", ".once"


def shared_pose_name(name: str, number: int = 0) -> str:
    """Name of the draw for the pose of an entity or a frame; no draw in a file can have it. `number`: of the pose."""
    return f"{name}{_POSE_SUFFIX}.{number}" if number else name + _POSE_SUFFIX


def kept_draw_name(path: str) -> str:
    """Name of the draw for the value of a `once`; no draw of a file can have it. `path`: keys of the `once`."""
    return path + _ONCE_SUFFIX


def placing_draw_name(name: str, path: str) -> str:
    """Name of the draw with the chosen numbers of a placement; no draw of a file can have it. `path`: of its key."""
    return f"{name}.{path}"


def is_unnamed_draw(name: str) -> bool:
    """Whether a shared draw is a pose, the value of a `once` or the numbers of a placement.

    A file's draw has no dot after its scope.
    """
    return "." in name.rpartition("/")[2]


def find_body(name: str, entities: Mapping[str, Entity]) -> tuple[Entity, str | None] | None:
    """The entity of ENTITY or ENTITY/LINK, by its longest name, and the link; None if not found.

    A link may exist in only some of the articulation's structures.
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
    """Whether any structure of an articulation has a moving joint of this name."""
    return any(
        link.joint is not None and link.joint.name == joint and link.joint.type != "fixed"
        for one in entity.structures
        if not isinstance(one, BodyStructure)
        for link in one.links
    )
