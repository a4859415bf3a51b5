"""The plan of a batch of scenes: what is built, where, in which order. No engine, no language."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.plan.body import BodyStructure
    from scenecc.plan.material import AssetFile, PhysicalMaterial, VisualMaterial
    from scenecc.plan.physics import Physics
    from scenecc.plan.value import Value
    from scenecc.values.nodes import Node


@frozen
class Entity:
    """One logical object: a body in each of its scenes.

    Attributes:
        name: unique in the plan.
        scene_idxs: the scenes it exists in, ascending, without repetition; not empty. Rows of every
            `Value` below follow this order.
        pose: (·, 7) in the world of its scene, p [m] then q (wxyz).
        structures: one, or one a variant.
        pick: (·,) which structure each of its scenes has; None: all have the first.
    """

    name: str
    scene_idxs: tuple[int, ...]
    pose: Value
    structures: tuple[BodyStructure, ...]
    pick: Value | None = None
    origin: Origin | None = field(default=None, compare=False)

    def structure(self, row: int) -> BodyStructure:
        """The structure in its scene number `row` (not a scene index)."""
        return self.structures[0 if self.pick is None else int(self.pick.row(row))]


@frozen
class ScenePlan:
    """A whole batch, ready to be instantiated or emitted.

    `entities` stand in the order in which they are built: PhysX gives other trajectories in another.
    `draws` are the shared draws that recipes read, by name; one may read those before it. Among them are poses that
    recipes go on from, see `scenecc.plan.shared_poses`.
    """

    name: str
    num_scenes: int
    entities: tuple[Entity, ...]
    physics: Physics
    files: tuple[AssetFile, ...] = ()
    physical_materials: tuple[PhysicalMaterial, ...] = ()
    visual_materials: tuple[VisualMaterial, ...] = ()
    description: str = ""
    seed: int = 0
    draws: tuple[tuple[str, Node], ...] = ()
    origin: Origin | None = field(default=None, compare=False)
