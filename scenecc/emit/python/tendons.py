"""Joints that follow others, as fixed tendons; how PhysX does them is in `scenecc.plan.tendons`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.emit.python.columns import number, numbers
from scenecc.emit.python.layout import call, list_of
from scenecc.plan.tendons import TENDON_STIFFNESS, tendon_coefficients, tendon_links, tendon_pull

if TYPE_CHECKING:
    from scenecc.emit.python.columns import Columns
    from scenecc.emit.python.layout import Source
    from scenecc.plan import ArticulationStructure


def write_tendons(source: Source, structure: ArticulationStructure, columns: Columns) -> None:
    """One call a joint that follows another, on `articulation` and its `links`."""
    for mimic in structure.mimics:
        over = tendon_links(structure, mimic)
        pairs = np.stack([columns.of_rows(mimic.multiplier), columns.of_rows(mimic.offset)], axis=1)
        pulls = [tendon_pull(*pair) for pair in pairs.tolist()]
        coefficients = np.array([tendon_coefficients(structure, mimic, over, ends) for ends in pulls])
        shares = columns.of_block(coefficients, "coefficients", numbers)
        rest = columns.of_block(np.array([ends.rest_length for ends in pulls]), "rest_length", numbers)
        source.comment(f"{mimic.joint} follows {mimic.source}: SAPIEN's own mimic joints turn it round.")
        source.statement(
            call(
                "articulation.create_fixed_tendon",
                list_of([f"links[{index}]" for index in over]),
                shares,
                shares,
                rest_length=rest,
                stiffness=number(TENDON_STIFFNESS),
            )
        )
