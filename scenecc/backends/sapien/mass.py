"""Mass properties that the plan gives in place of those that follow from the densities."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.columns import poses, scalars, taken, vectors
from scenecc.backends.sapien.failure import EngineFailure

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.diagnostics import Origin
    from scenecc.plan import BodyStructure, Inertial, Value


def mass_step(structure: BodyStructure, rows: NDArray[np.intp]) -> Callable[[Any, int], None] | None:
    """What to do to a component once its shapes are attached; None: the densities decide."""
    if structure.inertial is not None:
        return _given(structure.inertial, rows)
    if structure.mass is not None:
        return _scaled(structure.mass, rows, structure.origin)
    return None


def _given(inertial: Inertial, rows: NDArray[np.intp]) -> Callable[[Any, int], None]:
    """What sets mass, centre of mass and inertia as they are given, on a component of one of `rows`."""
    mass = _full(scalars(taken(inertial.mass, rows)), len(rows))
    com = _full(poses(taken(inertial.com, rows)), len(rows))
    inertia = _full(vectors(taken(inertial.inertia, rows)), len(rows))

    def step(component: Any, row: int) -> None:
        """Sets what is given for the row."""
        component.set_mass(mass[row])
        component.set_cmass_local_pose(com[row])
        component.set_inertia(inertia[row])

    return step


def _scaled(value: Value, rows: NDArray[np.intp], origin: Origin | None) -> Callable[[Any, int], None]:
    """What sets the mass alone, and scales with it the inertia that the engine computed from the densities."""
    mass = _full(scalars(taken(value, rows)), len(rows))

    def step(component: Any, row: int) -> None:
        """Sets the mass of the row; EngineFailure (SC512) where the computed one cannot be scaled."""
        computed = component.get_mass()
        if not 0 < computed < np.inf:
            # Sizes of a mesh are known here first; those of other shapes were checked.
            message = f"the densities give a mass of {computed} kg, which nothing can be scaled from"
            raise EngineFailure("SC512", message, origin=origin, hint="mend the scale or the density: metres, kg/m³")
        # In float64, and rounded once by the engine: "Numbers" in the language's description.
        inertia = component.get_inertia().astype(np.float64) * (mass[row] / computed)
        component.set_mass(mass[row])
        component.set_inertia(inertia)

    return step


def _full(column: list[Any], length: int) -> list[Any]:
    return column if len(column) == length else column * length
