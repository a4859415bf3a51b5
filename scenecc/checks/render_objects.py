"""Rules of lights and cameras that SAPIEN does not enforce: it would render nothing, or nonsense."""

from __future__ import annotations

from operator import gt
from typing import TYPE_CHECKING

from scenecc.checks.value_queries import find_wrong_pair, report_fault
from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan.properties import round_to_float32
from scenecc.plan.rendering import RAY_TRACING_SHADERS, AreaLight, SpotLight, TexturedLight, shadow_parameters

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan, Value
    from scenecc.plan.rendering import Light


def check_render_objects(plan: ScenePlan, sink: Sink) -> None:
    """Applies every rule to every light and camera.

    Args:
        plan: with or without lines for its origins.
        sink: collects diagnostics.
    """
    around = plan.origin or Origin(None)
    for camera in plan.cameras:
        origin = camera.origin or around.child("cameras", camera.name)
        _check_clip_planes(camera.near, camera.far, ("near", "far"), origin, sink)
    for light in plan.lights:
        origin = light.origin or around.child("lights", light.name)
        if light.shadow is not None:
            numbers = shadow_parameters(light)
            keys = ("shadow_near", "shadow_far")
            _check_clip_planes(numbers[keys[0]], numbers[keys[1]], keys, origin, sink)
        if isinstance(light.light, SpotLight | TexturedLight):
            _check_cone_angles(light.light.inner_fov, light.light.outer_fov, origin, sink)
        _check_area_light_visible(light, plan, origin, sink)


def _check_clip_planes(near: Value, far: Value, keys: tuple[str, str], origin: Origin, sink: Sink) -> None:
    """Checks that the near plane is in front of the far one, in float32."""
    found = find_wrong_pair(near, far, lambda a, b: round_to_float32(a) >= round_to_float32(b))
    if found is not None:
        wrong, sample = found
        message = f"`{keys[0]}` {wrong[0]:g} must be below `{keys[1]}` {wrong[1]:g}"
        hint = f"lower `{keys[0]}` or raise `{keys[1]}`"
        report_fault(sink, "SC550", message, origin, hint, sample)


def _check_cone_angles(inner: Value, outer: Value, origin: Origin, sink: Sink) -> None:
    found = find_wrong_pair(inner, outer, gt)
    if found is not None:
        wider, sample = found
        message = f"the inner cone ({wider[0]:g} rad) is wider than the outer one ({wider[1]:g} rad)"
        hint = "light fades from the inner cone to the outer one"
        report_fault(sink, "SC551", message, origin, hint, sample)


def _check_area_light_visible(light: Light, plan: ScenePlan, origin: Origin, sink: Sink) -> None:
    if (
        isinstance(light.light, AreaLight)
        and plan.cameras
        and RAY_TRACING_SHADERS.isdisjoint(camera.shader for camera in plan.cameras)
    ):
        message = f"no camera shows the light of `{light.name}`: only ray tracing does"
        hint = "give a camera `shader: rt`, or use a light of another type"
        sink.report("SC552", message, origin, at="key", hint=hint)
