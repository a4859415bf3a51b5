"""The plan of a batch of scenes: what is built, where, and in which order. It knows neither an engine nor the
language.
"""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen
from scenecc.plan.body import BodyStructure

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.plan.articulation import ArticulationStructure
    from scenecc.plan.camera import Camera
    from scenecc.plan.constraint import Constraint
    from scenecc.plan.light import Environment, Light
    from scenecc.plan.material import AssetFile, PhysicalMaterial, VisualMaterial
    from scenecc.plan.physics import Physics
    from scenecc.plan.value import Value
    from scenecc.variation.nodes import Node


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
    `draws` are the shared draws that recipes read, by name; one may read those before it. Among them are poses that
    recipes go on from, see `scenecc.plan.scene`. Constraints, lights and cameras are built after the entities.
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
    draws: tuple[tuple[str, Node], ...] = ()
    origin: Origin | None = field(default=None, compare=False)


MAX_COMPOSED_POSES = 16
"""How many poses one recipe composes before it goes on from a shared one: what is nested more cannot be read back."""

_POSE_SUFFIX = ".pose"


def shared_pose_name(name: str, number: int = 0) -> str:
    """What the pose of an entity or a frame is called, as no draw of a file is. `number`: of several such poses."""
    return f"{name}{_POSE_SUFFIX}.{number}" if number else name + _POSE_SUFFIX


def is_shared_pose(name: str) -> bool:
    """Whether a shared draw is the pose of an entity or a frame. A draw of a file has no dot after its scope."""
    return "." in name.rpartition("/")[2]
