"""Starts of a plan: which start a scene has for a seed, and the poses and joint positions in it."""

from __future__ import annotations

from bisect import bisect_left
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from scenecc.geometry.rotations import UNIT_TOLERANCE
from scenecc.plan.body import BodyStructure
from scenecc.variation.nodes import placements_read_by

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.plan.articulation import Joint
    from scenecc.plan.scene import Entity, ScenePlan, SettledStart

POSE = 7
"""Numbers of a pose: p, then q (wxyz)."""


class StartPart(NamedTuple):
    """One entity of a scene that has a start: a body that is not static, or an articulation.

    Attributes:
        entity: the entity.
        row: the scene's row of its values.
        joints: its active joints, in the plan's order.
    """

    entity: Entity
    row: int
    joints: tuple[Joint, ...]


def start_parts(plan: ScenePlan, scene: int) -> Iterator[StartPart]:
    """Yields the entities of a scene that have a start, in build order."""
    for entity in plan.entities:
        where = entity.scene_idxs
        row = scene if len(where) == plan.num_scenes else bisect_left(where, scene)
        if where[row : row + 1] != (scene,):
            continue
        structure = entity.structure(row)
        if not isinstance(structure, BodyStructure):
            yield StartPart(entity, row, structure.active_joints)
        elif structure.body_type != "static":
            yield StartPart(entity, row, ())


class StartTable:
    """The starts of a plan by scene. The plan must have at least one start."""

    def __init__(self, plan: ScenePlan) -> None:
        self._plan = plan
        self._by_scene: dict[int, dict[int, SettledStart]] = {}
        self._parts: dict[int, list[StartPart]] = {}
        for start in plan.starts:
            self._by_scene.setdefault(start.scene, {})[start.seed] = start

    def lacks(self, scene_idxs: Sequence[int]) -> list[int]:
        """Returns those of the scenes that have no start."""
        return [scene for scene in scene_idxs if scene not in self._by_scene]

    def seeds(self, scene_idxs: Sequence[int], seeds: Sequence[int]) -> list[int]:
        """Returns the seed of the start that each scene has for a seed.

        It is this seed if the scene has a start with it, else that of the start whose number is the seed modulo the
        number of its starts.

        Raises:
            ValueError: a scene has no start.
        """
        if lacking := self.lacks(scene_idxs):
            raise ValueError(f"scene {lacking[0]} has no start: it was dropped when the starts were made")
        found: list[int] = []
        for scene, seed in zip(scene_idxs, seeds, strict=True):
            known = self._by_scene[scene]
            found.append(seed if seed in known else [*known][seed % len(known)])
        return found

    def states(self, scene: int, seed: int) -> Iterator[tuple[StartPart, NDArray[np.float32], NDArray[np.float32]]]:
        """Yields pose (7,) and joint positions (dof,) of each entity in the start with exactly this seed."""
        numbers, at = np.frombuffer(self._by_scene[scene][seed].state, "<f4").astype(np.float32), 0
        if scene not in self._parts:
            self._parts[scene] = list(start_parts(self._plan, scene))
        for part in self._parts[scene]:
            joints = at + POSE
            at = joints + len(part.joints)
            yield part, numbers[joints - POSE : joints], numbers[joints:at]


def places_followers(plan: ScenePlan) -> bool:
    """Returns whether a light or a camera is where a reset places a body, so that it must be placed for a start too."""
    poses = (one.pose.recipe for one in (*plan.lights, *plan.cameras))
    return any(recipe is not None and placements_read_by(recipe) for recipe in poses)


def start_faults(plan: ScenePlan) -> Iterator[int]:
    """Yields the numbers of starts that the plan's scenes cannot have, or have already with the same seed."""
    known: set[tuple[int, int]] = set()
    parts = {scene: list(start_parts(plan, scene)) for scene in {start.scene for start in plan.starts}}
    for number, start in enumerate(plan.starts):
        is_whole = start.scene < plan.num_scenes and len(start.state) % 4 == 0
        is_again = (start.scene, start.seed) in known
        known.add((start.scene, start.seed))
        if is_again or not is_whole or not are_states(parts[start.scene], np.frombuffer(start.state, "<f4")[None]):
            yield number


def are_states(parts: Sequence[StartPart], states: NDArray[np.float32]) -> bool:
    """Returns whether states (·, n) have the right size for the entities, unit quaternions, and no huge numbers."""
    at = 0
    for part in parts:
        lengths = np.linalg.norm(states[:, at + 3 : at + POSE].astype(np.float64), axis=1)
        if not (np.abs(lengths - 1) <= UNIT_TOLERANCE).all():
            return False
        at += POSE + len(part.joints)
    return at == states.shape[1] and bool((np.abs(states) <= _LARGEST).all())


_LARGEST = 1e6
"""[m, rad] A body beyond it has diverged."""
