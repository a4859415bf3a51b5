"""Mass properties of solids of density 1, as the engine computes them from collision shapes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.geometry.rotations import AXES, rotate
from scenecc.robots.description import SolidGeometry

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Pose7
    from scenecc.robots.description import DescribedCollision, DescribedInertial

_EQUAL = 2e-6
"""Relative difference of equal mass properties in single precision."""

_LEAST_MOMENT = 1e-6
"""Least moment of inertia that SAPIEN computes from densities, before it is scaled to a mass [kg·m²]."""

_DENSITY = 1000.0
"""Default density [kg/m³]."""


@dataclass(frozen=True)
class SolidMass:
    """Mass properties.

    Attributes:
        mass: [kg].
        centre: (3,) centre of mass [m].
        inertia: (3, 3) about the centre of mass [kg·m²].
    """

    mass: float
    centre: NDArray[np.float64]
    inertia: NDArray[np.float64]


EXACT_SOLIDS = frozenset({"box", "sphere", "capsule"})
"""Solids whose mass PhysX computes exactly. It computes others as meshes, whose volume is smaller."""


def solid_mass(shape: DescribedCollision) -> SolidMass | None:
    """Returns the mass properties that PhysX computes of a solid with density 1; None for other shapes."""
    geometry = shape.geometry
    if not isinstance(geometry, SolidGeometry) or geometry.kind not in EXACT_SOLIDS:
        return None
    return exact_mass(geometry, shape.pose)


def exact_mass(geometry: SolidGeometry, pose: Pose7) -> SolidMass | None:
    """Returns the mass properties of a solid with density 1 at a pose; None for other kinds."""
    centre = 0.0
    match geometry.kind, geometry.sizes:
        case "box", (a, b, c):
            volume, squares = 8 * a * b * c, (a * a / 3, b * b / 3, c * c / 3)
        case "sphere", (radius,):
            volume, squares = 4 / 3 * math.pi * radius**3, (radius**2 / 5,) * 3
        case "capsule", (radius, half):
            tube, balls = 2 * math.pi * radius**2 * half, 4 / 3 * math.pi * radius**3
            volume = tube + balls
            # Of a half ball, the mean of its distance to the flat side is 3/8 r, that of its square 1/5 r².
            along = tube * half**2 / 3 + balls * (half**2 + 0.75 * half * radius + radius**2 / 5)
            across = tube * radius**2 / 4 + balls * radius**2 / 5
            squares = (along / volume, across / volume, across / volume)
        case "cylinder", (radius, half):
            volume, squares = 2 * math.pi * radius**2 * half, (half**2 / 3, radius**2 / 4, radius**2 / 4)
        case "cone", (radius, half):  # its tip is at +x
            volume, centre = 2 / 3 * math.pi * radius**2 * half, -half / 2
            squares = (0.15 * half**2, 0.15 * radius**2, 0.15 * radius**2)
        case _:
            return None
    turn = np.array([rotate(pose[3:], axis) for axis in AXES.values()]).T
    moments = volume * (sum(squares) - np.array(squares))
    return SolidMass(volume, np.array(pose[:3]) + centre * turn[:, 0], turn @ np.diag(moments) @ turn.T)


def joined_mass(masses: Iterable[SolidMass]) -> SolidMass:
    """Returns the mass properties of several solids, of which one has a mass above 0."""
    each = list(masses)
    mass = sum(one.mass for one in each)
    centre: Any = sum((one.mass * one.centre for one in each), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for one in each:
        d = one.centre - centre
        inertia += one.inertia + one.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return SolidMass(mass, centre, inertia)


def is_raised(whole: SolidMass, density: float = _DENSITY) -> bool:
    """Returns whether SAPIEN raises a moment of inertia that it computes from a density [kg/m³].

    `whole`: with density 1.
    """
    return float(np.linalg.eigvalsh(whole.inertia)[0]) * density < _LEAST_MOMENT


def follows_from_shapes(inertial: DescribedInertial, collisions: Iterable[DescribedCollision]) -> bool:
    """Returns whether an inertial is that of the link's collision shapes with one density."""
    found = [solid_mass(shape) for shape in collisions]
    if not found or inertial.inertia is None:
        return False
    solids = [one for one in found if one is not None and one.mass > 0]
    if len(solids) < len(found):
        return False
    whole = joined_mass(solids)
    turn = np.array([rotate(inertial.com[3:], axis) for axis in AXES.values()]).T
    inertia = turn @ np.diag(inertial.inertia) @ turn.T
    scaled, largest = whole.inertia * (inertial.mass / whole.mass), max(inertial.inertia)
    off = np.abs(whole.centre - np.array(inertial.com[:3])).max()
    # The square root is the radius of gyration [m].
    near = off <= _EQUAL * math.sqrt(largest / inertial.mass) and not is_raised(whole)
    return bool(near and np.abs(scaled - inertia).max() <= _EQUAL * largest)
