"""Mimic joints of an articulation as prepared calls; how PhysX does them is in `scenecc.plan.tendons`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.columns import at, taken
from scenecc.backends.sapien.failure import REFUSED, EngineFailure
from scenecc.plan.tendons import TENDON_STIFFNESS, tendon_coefficients, tendon_links, tendon_pull

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.plan import ArticulationStructure, Mimic


def tendons(structure: ArticulationStructure, rows: NDArray[np.intp]) -> list[Callable[[Any, list[Any], int], None]]:
    """One call a mimic, on a new articulation and its links, of one of `rows`.

    Raises:
        EngineFailure: PhysX cannot do it.
    """
    return [_tendon(structure, mimic, rows) for mimic in structure.mimics]


def _tendon(
    structure: ArticulationStructure, mimic: Mimic, rows: NDArray[np.intp]
) -> Callable[[Any, list[Any], int], None]:
    try:
        over = tendon_links(structure, mimic)
    except ValueError as error:
        raise EngineFailure(REFUSED, str(error), origin=mimic.origin or structure.origin) from None
    numbers = np.broadcast_arrays(taken(mimic.multiplier, rows), taken(mimic.offset, rows))
    pulls = [tendon_pull(*pair) for pair in zip(*(column.tolist() for column in numbers), strict=True)]
    made = [(tendon_coefficients(structure, mimic, over, ends), ends.rest_length) for ends in pulls]

    def bind(articulation: Any, links: list[Any], row: int) -> None:
        coefficients, rest_length = at(made, row)
        articulation.create_fixed_tendon(
            [links[number] for number in over],
            coefficients,
            coefficients,
            rest_length=rest_length,
            stiffness=TENDON_STIFFNESS,
        )

    return bind
