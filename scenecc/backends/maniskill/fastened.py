"""What is fastened to the objects of a plan, or stands beside them: constraints, surroundings and lights."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.maniskill.failure import UNFIT
from scenecc.backends.sapien.constraints import Tie
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.backends.sapien.resources import Resources
from scenecc.backends.sapien.seen.batches import LightBatch
from scenecc.backends.sapien.seen.dress import moves_of
from scenecc.backends.sapien.seen.lights import build_environment, build_light
from scenecc.backends.sapien.standing import Standing
from scenecc.backends.sapien.ties import again_of
from scenecc.backends.sapien.turn import ArticulationTurn

if TYPE_CHECKING:
    from scenecc.backends.sapien.seen.dress import Moves
    from scenecc.backends.sapien.ties import Again
    from scenecc.plan import Light, ScenePlan
    from scenecc.plan.body import Mount
    from scenecc.variation.evaluation import Batch


class InManiSkill(Standing):
    """Bodies by their mounts; links by their names in the plan, which ManiSkill's are longer than."""

    def component(self, mount: Mount, number: int) -> Any:
        """The physical component that a mount names in the scene of a number. Errors as of `Standing`."""
        turn = self._turns[mount.entity]
        if not isinstance(turn, ArticulationTurn) or mount.link is None:
            return super().component(mount, number)
        row = self._row_of[mount.entity][self.scene_idxs[number]]
        (part,) = (part for part in turn.parts if row in part.numbers)
        names = [link.name for link in part.structure.links]
        return turn.links[row][names.index(mount.link)]


class Ties:
    """Constraints of the plan, built once all entities stand."""

    def __init__(self, plan: ScenePlan, standing: Standing, scene: Any) -> None:
        """Builds them.

        Raises:
            EngineFailure: one holds on to the world where environments share one simulation.
        """
        self._built: list[tuple[Tie, list[Any]]] = []
        for constraint in plan.constraints:
            if constraint.parent is None and scene.gpu_sim_enabled and plan.num_scenes > 1:
                message = f"'{constraint.name}' holds on to the world, which environments share on the GPU"
                hint = "put a static or kinematic body there, and hold on to that"
                raise EngineFailure(UNFIT, message, origin=constraint.origin, hint=hint)
            tie = Tie(constraint, standing.scene_idxs)
            self._built.append((tie, tie.build(standing)))

    def again(self, batch: Batch) -> Again:
        """The targets of drives at the start, drawn anew; nothing is set yet. Raises ValueError as `again_of` does."""
        return [step for tie, components in self._built for step in again_of(tie, components, batch)]


class Lights:
    """Surroundings and lights of scenes that render."""

    def __init__(self, plan: ScenePlan, standing: Standing) -> None:
        """Builds them.

        Raises:
            EngineFailure: the renderer cannot make one.
        """
        resources = Resources(plan)
        if plan.environment is not None:
            build_environment(plan.environment, standing, resources)
        self._built: list[tuple[Light, LightBatch]] = []
        for light in plan.lights:
            where = tuple(index for index in standing.scene_idxs if index in light.scene_idxs)
            self._built.append((light, LightBatch(light.name, where, build_light(light, standing, resources))))

    def moves(self, batch: Batch) -> Moves:
        """Where those go that stand relative to what a reset draws anew. Raises ValueError as `moves_of` does."""
        return [move for light, found in self._built for move in moves_of(light, found, batch)]
