"""Rules of the pictures that surround the scenes."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING

from scenecc.checks.asset_image import image_size
from scenecc.checks.judged import indices, rows
from scenecc.diagnostics import Origin
from scenecc.plan import CubeMap

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan, SkyMap


def check_surroundings(plan: ScenePlan, sink: Sink) -> None:
    """Reports pictures around the scenes that do not fit together; each alone was found to be one."""
    if plan.environment is None or plan.environment.map is None:
        return
    place = (plan.environment.origin or plan.origin or Origin(None)).child("map")
    if isinstance(plan.environment.map, CubeMap):
        _check_faces(plan, plan.environment.map, place, sink)
    else:
        _check_sky(plan, plan.environment.map, place, sink)


def _check_faces(plan: ScenePlan, surroundings: CubeMap, origin: Origin, sink: Sink) -> None:
    """That six pictures make a cube in every scene: they have one size, and one kind of pixels."""
    faces = [getattr(surroundings, item.name) for item in fields(surroundings)]
    found = rows(faces)
    # Of what is drawn any may meet any.
    sides = [[index for face in faces for index in indices(face)]] if found is None else found
    for side in sides:
        numbers = [int(index[0]) if isinstance(index, tuple) else index for index in side]
        sizes = {index: image_size(plan.files[index].path) for index in dict.fromkeys(numbers)}
        few = next((index for index in numbers if not sizes[index].has_all_levels), None)
        if few is not None:
            message = f"a side of a cube has levels down to one pixel, or none, and {plan.files[few].uri} has fewer"
            sink.report("SC553", message, origin)
            return
        first = numbers[0]
        other = next((index for index in numbers if sizes[index] != sizes[first]), None)
        if other is not None:
            a, b = (f"{plan.files[index].uri} ({sizes[index]})" for index in (first, other))
            sink.report("SC553", f"the sides of a cube are alike, and {a} and {b} are not", origin)
            return


def _check_sky(plan: ScenePlan, surroundings: SkyMap, origin: Origin, sink: Sink) -> None:
    """That one picture holds the whole sphere: a turn from left to right, and half a one from top to bottom."""
    for index in indices(surroundings.file):
        size = image_size(plan.files[index].path)
        if size.levels and not (size.sides == 6 and size.columns == size.rows and size.has_all_levels):
            what = "a KTX of all directions has six square sides, and levels down to one pixel"
            hint = "make it with its mipmaps, or take one picture in PNG, HDR or EXR"
            sink.report("SC554", f"{what}; {plan.files[index].uri} has not", origin, hint=hint)
            return
        if not size.levels and size.columns != 2 * size.rows:
            message = f"a map of all directions is twice as wide as it is high, and {plan.files[index].uri} is not"
            sink.report("SC554", f"{message} ({size})", origin, hint="six pictures are written {px: …, nx: …, …}")
            return
