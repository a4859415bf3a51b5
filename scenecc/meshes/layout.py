"""Where shapes stand: in one scene or in several side by side, planes cut to what there is to stand on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from scenecc.plan.extent import pose_matrix

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from scenecc.meshes.draw import Drawer
    from scenecc.meshes.surface import Shape, Surface
    from scenecc.plan.measured import MeasuredBody, MeasuredEntity, MeasuredScene

_MARGIN: Final = 0.1
"""Of what a scene takes, on each of its sides."""

_SMALLEST: Final = 0.5
"""Half the side of a plane at least [m]."""


@dataclass(frozen=True, slots=True)
class DrawnBody:
    """A body and its shapes.

    Attributes:
        place: (4, 4) in its scene.
        corners: (·, 3) of boxes around all surfaces that are no planes, in its scene [m].
    """

    body: MeasuredBody
    shapes: tuple[Shape, ...]
    place: NDArray[np.float64]
    corners: NDArray[np.float64]

    @staticmethod
    def of(body: MeasuredBody, shapes: tuple[Shape, ...]) -> DrawnBody:
        """A body where it was measured."""
        place = pose_matrix(body.pose)
        corners = [
            _corners(part.surface, place, shape) for shape in shapes if shape.kind != "plane" for part in shape.parts
        ]
        return DrawnBody(body, shapes, place, np.concatenate([np.zeros((0, 3)), *corners]))


@dataclass(frozen=True, slots=True)
class DrawnEntity:
    """An entity and its bodies, in the order of the plan."""

    measured: MeasuredEntity
    bodies: tuple[DrawnBody, ...]


@dataclass(frozen=True, slots=True)
class DrawnScene:
    """A scene and its entities."""

    scene: MeasuredScene
    entities: tuple[DrawnEntity, ...]


@dataclass(frozen=True, slots=True)
class Cell:
    """The room that each scene has: (2,) lowest and highest x and y from the scene's origin [m]."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @property
    def half(self) -> float:
        """Of its shorter side [m]."""
        return float((self.high - self.low).min()) / 2

    def origins(self, count: int) -> NDArray[np.float64]:
        """(count, 3) where the origins of as many scenes are: row by row, as one reads, seen from above [m]."""
        columns = math.ceil(math.sqrt(count))
        row, column = np.divmod(np.arange(count), columns)
        x, y = self.high - self.low
        return np.stack([column * x, -row * y, np.zeros(count)], axis=1)


def draw_scene(drawer: Drawer, scene: MeasuredScene, show: Literal["visual", "collision"]) -> DrawnScene:
    """A scene's bodies as they are seen, or as they collide.

    Raises:
        MeshProblem: a file cannot be shown, or a package is missing. `Drawer.at` is the shape that has it.
    """
    entities: list[DrawnEntity] = []
    for entity in scene.entities:
        bodies: list[DrawnBody] = []
        for body in entity.bodies:
            shapes = drawer.visuals(body.body, entity.row) if show == "visual" else drawer.collisions(body)
            bodies.append(DrawnBody.of(body, shapes))
        entities.append(DrawnEntity(entity, tuple(bodies)))
    return DrawnScene(scene, tuple(entities))


def cell_of(scenes: tuple[DrawnScene, ...]) -> Cell:
    """A room for each scene that holds what any of them has, planes left out."""
    every = corners_of(scenes)[:, :2]
    if not len(every):
        return Cell(np.full(2, -1.0), np.full(2, 1.0))
    low, high = every.min(axis=0), every.max(axis=0)
    margin = np.maximum((high - low) * _MARGIN, _SMALLEST / 2)
    return Cell(low - margin, high + margin)


def reach(scene: DrawnScene, place: NDArray[np.float64]) -> float:
    """Half the side of an endless plane that reaches below all of a scene [m]. `place`: its own."""
    corners = corners_of([scene])
    if not len(corners):
        return _SMALLEST
    far = np.linalg.norm(corners - place[:3, 3], axis=1).max()
    return max(_SMALLEST, float(far) * (1 + _MARGIN))


def cut(shape: Shape, half: float) -> Shape:
    """A plane with sides of at most twice `half` [m]."""
    x, y, z = shape.scale
    return replace(shape, scale=(x, half, half) if shape.endless else (x, min(y, half), min(z, half)))


def bounded(shape: Shape, body: DrawnBody, scene: DrawnScene, half: float | None) -> Shape:
    """The shape; of a plane as much as there is room for.

    Args:
        shape: of the body.
        body: in the scene.
        scene: as it was drawn.
        half: of the side of the scene's cell [m]; None: it has none, and only endless planes are cut.
    """
    if shape.kind != "plane" or (half is None and not shape.endless):
        return shape
    return cut(shape, reach(scene, body.place @ pose_matrix(shape.pose)) if half is None else half)


def corners_of(scenes: Iterable[DrawnScene]) -> NDArray[np.float64]:
    """(·, 3) corners of all bodies of scenes, each in its own [m]. Planes have none."""
    corners = [body.corners for scene in scenes for entity in scene.entities for body in entity.bodies]
    return np.concatenate([np.zeros((0, 3)), *corners])


def _corners(surface: Surface, body: NDArray[np.float64], shape: Shape) -> NDArray[np.float64]:
    """(8, 3) of the box around a surface along its own axes."""
    ends = np.array([surface.vertices.min(axis=0), surface.vertices.max(axis=0)], np.float64)
    place = body @ pose_matrix(shape.pose)
    return (np.array(list(product(*ends.T))) * shape.scale) @ place[:3, :3].T + place[:3, 3]
