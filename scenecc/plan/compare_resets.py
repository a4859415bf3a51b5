"""Whether resets give the same in two plans, however their recipes are written."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.variation.errors import DrawError
from scenecc.variation.per_scene_arrays import to_field_rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan.compare_tables import Side
    from scenecc.plan.scene import ScenePlan
    from scenecc.plan.value import Value
    from scenecc.variation.evaluation import Batch

FEWEST_SEEDS: Final = 4
FEWEST_DRAWS: Final = 256
"""So many seeds at least, and so many draws of each value over all scenes: one that is seldom another shows."""

_FIRST_SEED: Final = 0x5CE9E


class Resets:
    """Evaluates the recipes of two plans with the same seeds.

    Attributes:
        plans: the two.
        same_draws: whether their shared draws are written alike.
    """

    def __init__(self, a: ScenePlan, b: ScenePlan) -> None:
        self.same_draws = repr(a.draws) == repr(b.draws) and a.num_scenes == b.num_scenes
        self.plans = (a, b)
        self._batches: dict[tuple[Side, bytes], Batch] = {}

    def differing(
        self,
        scenes: NDArray[np.int64],
        values: tuple[Value, Value],
        rows: tuple[NDArray[Any], NDArray[Any]],
        part: slice | None = None,
    ) -> int:
        """In how many scenes some seed gives the two something else.

        Args:
            scenes: indices of those that both have (B,).
            values: of the two plans.
            rows: their data there, or a part of it (B, …) or (1, …), for what a reset leaves as it is.
            part: of each row that a recipe gives; None: all of it.
        """
        x, y = values
        if x.recipe is None and y.recipe is None:
            return 0
        if self.same_draws and repr(x.recipe) == repr(y.recipe):
            return 0
        first, second = self._given(0, scenes, x, rows[0], part), self._given(1, scenes, y, rows[1], part)
        if isinstance(first, str) or isinstance(second, str):
            # What has no value with one of the seeds is the same only as what fails alike.
            return 0 if isinstance(first, str) and first == second else len(scenes)
        return int((first != second).any(axis=(0, 2)).sum())

    def _given(
        self, side: Side, scenes: NDArray[np.int64], value: Value, rows: NDArray[Any], part: slice | None
    ) -> NDArray[np.uint8] | str:
        """What the seeds give, to the bit: (seeds, B, bytes); or why one of them gives nothing."""
        seeds = max(FEWEST_SEEDS, -(-FEWEST_DRAWS // len(scenes)))
        if value.recipe is None:
            data = np.broadcast_to(rows, (seeds, len(scenes), *rows.shape[1:]))
        else:
            try:
                data = to_field_rows(self._batch(side, scenes, seeds).evaluate(value.recipe))
            except DrawError as error:
                return str(error)
            data = data if part is None else data[:, part]
        numbers = np.ascontiguousarray(data, dtype=np.float64)
        return numbers.reshape(seeds, len(scenes), -1).view(np.uint8)

    def _batch(self, side: Side, scenes: NDArray[np.int64], seeds: int) -> Batch:
        from scenecc.variation.evaluation import Batch  # noqa: PLC0415 - most plans have no recipes

        key = (side, scenes.tobytes())
        if key not in self._batches:
            plan = self.plans[side]
            each = np.repeat(np.arange(_FIRST_SEED, _FIRST_SEED + seeds), len(scenes)).tolist()
            self._batches[key] = Batch(np.tile(scenes, seeds), tuple(each), plan.num_scenes, dict(plan.draws), {})
        return self._batches[key]
