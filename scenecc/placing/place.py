"""Places an entity: by its own tries, else by drawing earlier placements again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.placing.rearrange import rearrange
from scenecc.placing.trial import Trial

if TYPE_CHECKING:
    from scenecc.placing.placer import Placer
    from scenecc.plan.placement import Placement


def place_next(placer: Placer, placement: Placement) -> None:
    """Computes the pose of the next placement, and stores it in the placer and its `batch.placed`.

    Raises:
        PlacingError: it fits nowhere.
    """
    with np.errstate(all="ignore"):
        # Poses that overflow fit nowhere.
        trial = Trial(placer, placement)
        found, left = trial.poses()
        if left.size:
            found = rearrange(placer, trial, found, left)
    placer.settle(placement, found)
    placer.placed.append(placement)
