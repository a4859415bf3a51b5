"""Surroundings, lights and cameras against the plan: everything that the renderer gives back of them.

What SAPIEN gives nobody is not looked at: the files of a map, and a camera's shader pack.
"""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.bodies import expected_texture
from scenecc.backends.sapien.audit.comparison import DifferenceGroups, EngineDifference, format_value, is_same
from scenecc.backends.sapien.engine import render
from scenecc.backends.sapien.rendering import LIGHT_CLASSES, light_values
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import (
    AreaLight,
    Camera,
    Intrinsic,
    Orthographic,
    Perspective,
    TexturedLight,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.backends.sapien.cameras import RenderComponentBatch
    from scenecc.backends.sapien.preparation import EntityLookup
    from scenecc.backends.sapien.rendering import LightsAndCameras
    from scenecc.diagnostics import Sink
    from scenecc.plan import Light, ScenePlan, Value


_ANGLE_TOLERANCE = 1e-6
"""Of an angle of view, relative: SAPIEN keeps the focal length that it makes of one."""


def audit_rendering(plan: ScenePlan, dress: LightsAndCameras, standing: EntityLookup, sink: Sink) -> bool:
    """Compares what pictures need with the plan, reports every difference, and says whether there is none.

    To be called before the first picture, which may bring lights and a camera of its own.
    """
    told = DifferenceGroups(sink)
    for number, index in enumerate(standing.scene_idxs):
        for each in _environment_differences(plan, standing.scenes[number], index):
            told.add("the scene", each.words, index, plan.environment and plan.environment.origin, key=each.what)
    for held in (*plan.lights, *plan.cameras):
        found: RenderComponentBatch = (dress.cameras if isinstance(held, Camera) else dress.lights)[held.name]
        rows = {index: row for row, index in enumerate(held.scene_idxs)}
        for index, component in zip(found.scene_idxs, found.objs, strict=True):
            number, row = standing.scene_idxs.index(index), rows[index]
            placement = _placement_differences(held, component, row, standing, number)
            for each in chain(placement, _component_differences(plan, held, component, row)):
                told.add(f"'{held.name}'", each.words, index, held.origin, key=each.what)
    return told.report()


def _environment_differences(plan: ScenePlan, scene: Any, index: int) -> Iterator[EngineDifference]:
    """What differs in a scene as a whole, of an index among all of the plan."""
    system, environment = scene.render_system, plan.environment
    ambient: Any = (0.0, 0.0, 0.0)
    if environment is not None and environment.ambient_light is not None:
        ambient = environment.ambient_light.row(index)
    map_ = environment is not None and environment.map is not None
    return _property_differences(
        ("ambient_light", ambient, system.ambient_light),
        ("cubemap", _map_presence(there=map_), _map_presence(there=system.cubemap is not None)),
        ("lights", sum(index in light.scene_idxs for light in plan.lights), len(system.lights)),
        ("cameras", sum(index in camera.scene_idxs for camera in plan.cameras), len(system.cameras)),
    )


def _placement_differences(
    held: Light | Camera, component: Any, row: int, standing: EntityLookup, number: int
) -> Iterator[EngineDifference]:
    """What differs in where a component is: in which entity and at which pose."""
    entity = component.get_entity()
    yield from _property_differences(("name", held.name, component.name))
    if held.mount is not None:
        yield from _property_differences(("local_pose", held.pose.row(row), component.local_pose))
        if entity != standing.entity(held.mount, number):
            yield EngineDifference("entity", f"that of '{held.mount.entity}'", "another")
        return
    if entity is None or entity.get_scene() != standing.scenes[number]:
        yield EngineDifference("scene", "its own", "another" if entity and entity.get_scene() else "none")
        return
    yield from _property_differences(
        ("entity.name", held.name, entity.name),
        ("entity.pose", held.pose.row(row), entity.get_pose()),
        ("local_pose", IDENTITY_POSE, component.local_pose),
    )


def _component_differences(
    plan: ScenePlan, held: Light | Camera, component: Any, row: int
) -> Iterator[EngineDifference]:
    if isinstance(held, Camera):
        yield from _camera_differences(held, component, row)
    else:
        yield from _light_differences(plan, held, component, row)


def _light_differences(plan: ScenePlan, light: Light, component: Any, row: int) -> Iterator[EngineDifference]:
    kind = getattr(render, LIGHT_CLASSES[type(light.light)])
    if type(component) is not kind:
        yield EngineDifference("type", kind.__name__, type(component).__name__)
        return
    expected = light_values(light)
    if isinstance(light.light, AreaLight):
        expected |= {"half_width": light.light.half_width, "half_height": light.light.half_height}
    yield from _value_differences(expected, component, row)
    if isinstance(light.light, TexturedLight):
        image = component.texture
        if image is None:
            yield EngineDifference("texture", "an image", "none")
            return
        for name, wanted in expected_texture(plan, light.light.texture, row).items():
            yield from _property_differences((f"texture.{name}", wanted, getattr(image, name)))


def _camera_differences(camera: Camera, component: Any, row: int) -> Iterator[EngineDifference]:
    mode = "orthographic" if isinstance(camera.lens, Orthographic) else "perspective"
    yield from _property_differences(
        ("width", camera.width, component.width), ("height", camera.height, component.height)
    )
    if component.mode != mode:
        yield EngineDifference("mode", format_value(mode), format_value(component.mode))
        return
    yield from _value_differences({"near": camera.near, "far": camera.far}, component, row)
    match camera.lens:
        case Orthographic(top):
            high = float(top.row(row))
            right = high * camera.width / camera.height
            edges = {"left": -right, "right": right, "bottom": -high, "top": high}
            yield from _property_differences(
                *((f"ortho_{name}", edge, getattr(component, f"ortho_{name}")) for name, edge in edges.items())
            )
        case Intrinsic() as lens:
            yield from _value_differences(
                {name: getattr(lens, name) for name in ("fx", "fy", "cx", "cy", "skew")}, component, row
            )
        case Perspective() as lens:
            yield from _angle_differences(camera, lens, component, row)


def _angle_differences(camera: Camera, lens: Perspective, component: Any, row: int) -> Iterator[EngineDifference]:
    for name, value in (("fovx", lens.fovx), ("fovy", lens.fovy)):
        if value is None:
            continue
        wanted, found = float(value.row(row)), getattr(component, name)
        if not abs(found - wanted) <= _ANGLE_TOLERANCE * wanted:
            yield EngineDifference(name, format_value(np.float32(wanted)), format_value(np.float32(found)))
    if lens.fovx is None or lens.fovy is None:
        yield from _property_differences(("fx / fy", 1.0, component.fx / component.fy))
    middle = (("cx", camera.width / 2, component.cx), ("cy", camera.height / 2, component.cy))
    yield from _property_differences(*middle, ("skew", 0.0, component.skew))


def _value_differences(expected: dict[str, Value], component: Any, row: int) -> Iterator[EngineDifference]:
    """`expected`: values of the plan by the engine's names."""
    yield from _property_differences(
        *((name, value.row(row), getattr(component, name)) for name, value in expected.items())
    )


def _property_differences(*triples: tuple[str, Any, Any]) -> Iterator[EngineDifference]:
    """Of names, what the plan asks for, and what the engine holds."""
    for name, wanted, found in triples:
        if not is_same(wanted, found):
            yield EngineDifference(name, format_value(wanted), format_value(found))


def _map_presence(*, there: bool) -> str:
    return "a map" if there else "none"
