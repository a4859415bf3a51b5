"""Shapes of a body as prepared calls: arguments are found once, and the loop over bodies only calls."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.assets_on_disk import all_parts
from scenecc.backends.sapien.collision import COLLISION, Build
from scenecc.backends.sapien.columns import taken
from scenecc.backends.sapien.engine import render
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.backends.sapien.knobs import GROUPS, SHAPE_KNOBS, SHAPE_POSE, VISUAL_POSE, Step, knob_steps
from scenecc.backends.sapien.visual import VISUAL, Look, front_face
from scenecc.plan import ConvexParts, MeshGeometry, Plane

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.resources import Resources
    from scenecc.diagnostics import Origin
    from scenecc.plan import (
        BodyStructure,
        CollisionGeometry,
        CollisionShape,
        VisualGeometry,
        VisualShape,
    )

Fixed = tuple[tuple["Callable[[Any, Any], Any]", Any], ...]

Prepared = tuple[Fixed, tuple[Step, ...]]
"""Setters with one value for all rows, and setters with a value a row."""


class ShapeSteps(NamedTuple):
    """How one shape of the plan is made, row by row. A plain tuple: there is one for every shape of a plan.

    Attributes:
        make: a row to a new shape (`many`: to a list of shapes).
        fixed: setters whose value is the same in every row.
        varying: setters with a value a row.
        samples: rows that between them name every file of the shape; none where there is no file.
        code: of the diagnostic if the engine refuses.
        origin: the shape in the document.
    """

    make: Callable[[int], Any]
    fixed: Fixed
    varying: tuple[Step, ...]
    many: bool
    samples: tuple[int, ...]
    code: str
    origin: Origin | None


def attach(component: Any, shape: ShapeSteps, row: int) -> None:
    """Makes the shape of a row and gives it to the component; every failure is one.

    Raises:
        EngineFailure: the engine cannot make the shape.
    """
    try:
        made = shape.make(row)
        for part in made if shape.many else (made,):
            for setter, value in shape.fixed:
                setter(part, value)
            for setter, values in shape.varying:
                setter(part, values[row])
            component.attach(part)
    except (RuntimeError, TypeError, ValueError) as error:
        raise refused(shape, error) from error


def refused(shape: ShapeSteps, error: Exception) -> EngineFailure:
    """The engine's complaint about a shape, in its own words."""
    return EngineFailure(shape.code, f"the engine cannot make this shape: {error}", origin=shape.origin)


def cook(shapes: Sequence[ShapeSteps]) -> list[EngineFailure]:
    """Has the engine read and cook every file once, so that all that fail are known before any scene is built."""
    tried = [_cooking_failure(shape, row) for shape in shapes for row in shape.samples]
    return [failure for failure in tried if failure is not None]


def _cooking_failure(shape: ShapeSteps, row: int) -> EngineFailure | None:
    try:
        if shape.many:
            all_parts(lambda: shape.make(row))
        else:
            shape.make(row)
    except (RuntimeError, TypeError, ValueError) as error:
        return refused(shape, error)
    return None


def collision_steps(structure: BodyStructure, rows: NDArray[np.intp], resources: Resources) -> tuple[ShapeSteps, ...]:
    """The colliding shapes of a body, in the order of the plan."""
    groups = [] if structure.collision_groups is None else knob_steps(GROUPS, structure.collision_groups, rows)
    return tuple(_collision(shape, groups, rows, resources) for shape in structure.collisions)


def visual_steps(structure: BodyStructure, rows: NDArray[np.intp], resources: Resources) -> tuple[ShapeSteps, ...]:
    """The visible shapes of a body, in the order of the plan."""
    return tuple(_visual(shape, rows, resources) for shape in structure.visuals)


def render_component(visuals: Sequence[ShapeSteps], look: Prepared, name: str, row: int) -> Any:
    """What is seen of a body in a row.

    Raises:
        EngineFailure: the engine cannot make one of the shapes.
    """
    component = render.RenderBodyComponent()
    for shape in visuals:
        attach(component, shape, row)
    apply(look, component, row)
    component.set_name(name)
    return component


def apply(prepared: Prepared, obj: Any, row: int) -> None:
    """Calls the setters on an object of the engine, with the values of a row."""
    fixed, varying = prepared
    for setter, value in fixed:
        setter(obj, value)
    for setter, values in varying:
        setter(obj, values[row])


def split(found: Sequence[Step]) -> Prepared:
    """Setters with one value for all rows, and setters with a value a row."""
    if not found:
        return (), ()
    fixed = tuple((setter, column[0]) for setter, column in found if len(column) == 1)
    return fixed, tuple((setter, column) for setter, column in found if len(column) != 1)


def _collision(shape: CollisionShape, groups: list[Step], rows: NDArray[np.intp], resources: Resources) -> ShapeSteps:
    material = resources.physical(shape.material, rows)
    try:
        make = COLLISION[type(shape.geometry)](shape.geometry, Build(rows, material, resources))
    except EngineFailure as failure:
        failure.origin = failure.origin or shape.origin
        raise
    found = SHAPE_KNOBS.steps(shape, rows) + groups
    if shape.pose is not None:
        found = knob_steps(SHAPE_POSE, shape.pose, rows) + found
    if shape.density is None and isinstance(shape.geometry, Plane):
        # A fresh plane has the density of every fresh shape; SAPIEN's builder gives it none.
        found.append((SHAPE_KNOBS.by_field["density"].set, [0.0]))
    fixed, varying = split(found)
    many = isinstance(shape.geometry, ConvexParts)
    return ShapeSteps(make, fixed, varying, many, _samples(shape.geometry, rows), "SC801", shape.origin)


def _visual(shape: VisualShape, rows: NDArray[np.intp], resources: Resources) -> ShapeSteps:
    try:
        material = None if shape.material is None else resources.visual(shape.material, rows)
        make = VISUAL[type(shape.geometry)](shape.geometry, Look(rows, material, resources))
    except EngineFailure as failure:
        failure.origin = failure.origin or shape.origin
        raise
    found = [] if shape.pose is None else knob_steps(VISUAL_POSE, shape.pose, rows)
    faces = front_face(shape.geometry, shape.front_face, rows)
    if faces is not None:
        found.append((_set_front_face, faces))
    if shape.name:
        found.append((_set_name, [shape.name]))
    fixed, varying = split(found)
    return ShapeSteps(make, fixed, varying, False, _samples(shape.geometry, rows), "SC807", shape.origin)


def _samples(geometry: CollisionGeometry | VisualGeometry, rows: NDArray[np.intp]) -> tuple[int, ...]:
    if not isinstance(geometry, MeshGeometry):
        return ()
    _, first = np.unique(taken(geometry.file, rows), return_index=True)
    return tuple(first.tolist())


def _set_front_face(shape: Any, face: str) -> None:
    shape.set_front_face(face)


def _set_name(shape: Any, name: str) -> None:
    shape.set_name(name)
