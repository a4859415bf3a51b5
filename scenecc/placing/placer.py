"""Poses of entities and placements in the scenes of a batch, and what they leave free for the next placement."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.geometry import rotation_arrays
from scenecc.placing.bodies import Part, entity_parts, link_pose, matrices
from scenecc.placing.pairs import are_too_near
from scenecc.placing.surfaces import SupportSurface, upward_surfaces

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Mapping, Sequence

    from scenecc.geometry.rotation_arrays import Flags, Floats, Indices
    from scenecc.plan import Mount, ScenePlan
    from scenecc.plan.placement import Placement
    from scenecc.variation.evaluation import Batch


class PlacingError(Exception):
    """An entity fits nowhere in some scenes, even if earlier placements are drawn again.

    Attributes:
        name: name of the placement.
        scenes: indices of those scenes.
        message: the error in one sentence.
        why: the most frequent reason in the first of the scenes.
    """

    def __init__(self, name: str, scenes: Sequence[int], message: str, why: str = "") -> None:
        super().__init__(message)
        self.name, self.scenes, self.message, self.why = name, tuple(scenes), message, why


def round_poses(poses: Floats) -> Floats:
    """Returns poses rounded to float32, so that a build and a reset have the same obstacles."""
    return poses.astype(np.float32).astype(np.float64)


class Placer:
    """The entities of a batch, of which placements get their poses one after another.

    Args:
        plan: plan of the scenes.
        batch: evaluates draws; its `placed` receives the poses.
        standing: poses (B, 7) in the world of all entities that are not placed.
        local: poses (B, 7) of the other members of placements, relative to the placement.
        still: placements that keep their built pose.
        redrawn: entities whose poses a reset draws; kept placements do not avoid them.

    Attributes:
        bodies: collision parts in the world of all entities with a final pose: entity → parts.
        poses: their poses (B, 7).
        placed: the placements with a pose, in order.
        lifted: entities that are to be placed again, which nothing avoids, and the scenes (B,).
    """

    def __init__(
        self,
        plan: ScenePlan,
        batch: Batch,
        standing: Mapping[str, Floats],
        local: Mapping[str, Floats],
        still: Container[str],
        redrawn: Container[str],
    ) -> None:
        self.plan = plan
        self.batch = batch
        self.local = local
        self._still, self._redrawn = still, redrawn
        self.poses: dict[str, Floats] = {name: round_poses(pose) for name, pose in standing.items()}
        self._entities = {entity.name: entity for entity in plan.entities}
        self.bodies: dict[str, list[Part]] = {
            name: [part.moved(matrices(pose[:, 3:]), pose[:, :3]) for part in self.own_parts(name)]
            for name, pose in self.poses.items()
        }
        self._surfaces: dict[tuple[str, str | None], list[SupportSurface]] = {}
        self.by_member = {member: one for one in plan.placements for member in one.entities}
        self.placed: list[Placement] = []
        self.lifted: dict[str, Flags] = {}

    def selected(self, rows: Indices) -> Placer:
        """Returns a placer with the same poses in some rows of the batch."""
        standing = {name: pose[rows] for name, pose in self.poses.items() if name not in self.local}
        local = {name: pose[rows] for name, pose in self.local.items()}
        part = Placer(self.plan, self.batch.only(rows), standing, local, self._still, self._redrawn)
        for placement in self.placed:
            part.settle(placement, self.batch.placed[placement.name][part.batch.scenes])
        part.placed = [*self.placed]
        return part

    def own_parts(self, name: str) -> list[Part]:
        """Returns the collision parts of an entity in its own frame."""
        return entity_parts(self._entities[name], self.plan.files, self.batch)

    def moves_with(self, placement: Placement) -> list[Placement]:
        """Returns the earlier placements that may be drawn again for this one: not built ones for one at a reset."""
        is_still = placement.name in self._still
        return [one for one in self.placed if (one.name in self._still) == is_still]

    def settle(self, placement: Placement, found: Floats) -> None:
        """Stores the poses (B, 7) of a placement."""
        by_scene: Any = np.zeros((self.batch.num_scenes, 7))
        by_scene[:, 3] = 1.0
        by_scene[self.batch.scenes] = found
        self.batch.placed = {**self.batch.placed, placement.name: by_scene}
        for member in placement.entities:
            self.poses[member] = world = round_poses(rotation_arrays.compose(found, self.local[member]))
            turn = matrices(world[:, 3:])
            self.bodies[member] = [part.moved(turn, world[:, :3]) for part in self.own_parts(member)]
        self._surfaces = {key: one for key, one in self._surfaces.items() if key[0] not in placement.entities}

    def target_parts(self, mount: Mount) -> list[Part]:
        """Returns the parts of the target of a placement."""
        return [part for part in self.bodies[mount.entity] if mount.link is None or part.link == mount.link]

    def pose_of(self, mount: Mount) -> Floats:
        """Returns the pose of an entity or a link (B, 7)."""
        pose = self.poses[mount.entity]
        if mount.link is None:
            return pose
        return rotation_arrays.compose(pose, link_pose(self._entities[mount.entity], mount.link, self.batch))

    def surfaces(self, mount: Mount) -> list[SupportSurface]:
        """Returns the upward surfaces of a body with a final pose."""
        key = (mount.entity, mount.link)
        if key not in self._surfaces:
            self._surfaces[key] = [one for part in self.target_parts(mount) for one in upward_surfaces(part)]
        return self._surfaces[key]

    def obstacles(self, placement: Placement) -> Iterable[tuple[str, Part, float]]:
        """Yields all other parts with a final pose: entity, part, and required distance [m]; 0: no overlap."""
        members, carrying = set(placement.entities), set(placement.carrying)
        for name, parts in self.bodies.items():
            if name in members or (placement.name in self._still and name in self._redrawn):
                continue
            other = self.by_member.get(name)
            for part in parts:
                yield name, part, 0.0 if name in carrying else self._distance(placement, other, name, part.link)

    def drawn_overlap(self) -> str | None:
        """Returns a message about a drawn pose that is too close to a kept placement; None if there is none."""
        drawn = [name for name in self.bodies if name in self._redrawn and name not in self.by_member]
        for placement in self.plan.placements:
            for member in placement.entities if placement.name in self._still else ():
                for name in drawn:
                    near = np.zeros(len(self.batch.scenes), np.bool_)
                    for own, part in product(self.bodies[member], self.bodies[name]):
                        near |= are_too_near(own, part, placement.apart)
                    if near.any():
                        how = f"are less than {placement.apart:g} m apart" if placement.apart else "overlap"
                        return f"in scene {self.batch.scenes[near.argmax()]} `{member}` and `{name}` {how}"
        return None

    def _distance(self, placement: Placement, other: Placement | None, name: str, link: str | None) -> float:
        beside = () if placement.next_to is None else (placement.next_to.mount,)
        if any(name == mount.entity and mount.link in (None, link) for mount in (placement.target, *beside)):
            return 0.0
        return max(placement.apart, 0.0 if other is None else other.apart)
