"""Placement at a reset: only in the scenes that are reset, with the same results as in a build of all scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.placing.place import place_next
from scenecc.placing.placer import Placer, PlacingError
from scenecc.variation.nodes import placements_read_by

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotation_arrays import Floats
    from scenecc.plan import ScenePlan
    from scenecc.variation.evaluation import Batch


def placed_members(plan: ScenePlan) -> dict[str, str]:
    """Returns the entities that a reset places, each with its placement."""
    found: dict[str, str] = {}
    for entity in plan.entities:
        if entity.pose.recipe is not None:
            for name in placements_read_by(entity.pose.recipe):
                found[entity.name] = name
    return found


def place_anew(plan: ScenePlan, batch: Batch, poses: Mapping[str, tuple[Sequence[int], NDArray[np.floating]]]) -> None:
    """Computes the poses of the entities that a reset places, and stores them in `batch.placed`.

    Args:
        plan: plan of the scenes.
        batch: evaluates recipes in the reset scenes.
        poses: for each entity in some of these scenes, the scenes and the poses (·, 7) as built or drawn; those of
            placed entities are ignored.

    Raises:
        ValueError: an entity fits nowhere; the message names the scenes.
    """
    members = placed_members(plan)
    number_of = {scene: number for number, scene in enumerate(batch.scenes.tolist())}
    standing: dict[str, Floats] = {}
    local: dict[str, Floats] = {}
    for entity in plan.entities:
        where, known = poses.get(entity.name, ((), np.empty((0, 7))))
        rows = [number_of[scene] for scene in where]
        found = np.tile(np.array(IDENTITY_POSE), (len(batch.scenes), 1))
        root = members.get(entity.name)
        if root is None:
            found[rows] = known
            standing[entity.name] = found
            continue
        if rows:
            part = batch.only(np.array(rows, np.intp))
            part.placed = {root: np.tile(np.array(IDENTITY_POSE), (batch.num_scenes, 1))}
            assert entity.pose.recipe is not None
            found[rows] = part.evaluate(entity.pose.recipe)
        local[entity.name] = found
    placed = set(members.values())
    still = {one.name for one in plan.placements} - placed
    drawn = {one.name for one in plan.entities if one.pose.recipe is not None and one.name not in members}
    placer = Placer(plan, batch, standing, local, still, drawn)
    try:
        for placement in plan.placements:
            if placement.name in placed:
                place_next(placer, placement)
    except PlacingError as error:
        shown = ", ".join(map(str, error.scenes[:10])) + (", …" if len(error.scenes) > 10 else "")
        raise ValueError(f"{error.message}, in scenes {shown}" + (f"; {error.why}" if error.why else "")) from None
    overlap = placer.drawn_overlap()
    if overlap is not None:
        raise ValueError(overlap)
