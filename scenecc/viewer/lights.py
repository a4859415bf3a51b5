"""The lights of a file as lights of a page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.colors import linear_to_srgb
from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import compose, normalized, rotate, to_pose
from scenecc.plan.rendering import DirectionalLight, PointLight, SpotLight, TexturedLight
from scenecc.viewer.cameras import mount_pose

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from scenecc.geometry.rotations import Vec3
    from scenecc.plan import Light, ScenePlan
    from scenecc.plan.snapshot import MeasuredScene

_PI: Final = float(np.pi)
"""SAPIEN multiplies ambient light and base colour, three.js divides the product by pi."""


@frozen
class PageLight:
    """A light of a page.

    Attributes:
        kind: viser's name of it: `directional`, `ambient`, `point` or `spot`.
        color: sRGB from 0 to 255. intensity: as three.js has it.
        position: on the page [m]; of a directional light, where it comes from.
        cone: direction, half angle [rad] and share of the angle in which a spot fades. None: not a spot.
        shadow: whether it casts a shadow.
    """

    kind: str
    color: tuple[int, int, int]
    intensity: float
    position: Vec3 = (0.0, 0.0, 0.0)
    cone: tuple[Vec3, float, float] | None = None
    shadow: bool = False

    def add(self, scene: Any, path: str, *, shadows: bool) -> Any:
        """Adds it to a viser scene. `shadows`: whether lights may cast them."""
        given: dict[str, Any] = {"color": self.color, "intensity": self.intensity}
        if self.kind != "ambient":
            given |= {"position": self.position, "cast_shadow": self.shadow and shadows}
        if self.cone is not None:
            direction, angle, penumbra = self.cone
            given |= {"direction": direction, "angle": angle, "penumbra": penumbra}
        return getattr(scene, f"add_light_{self.kind}")(path, **given)


def page_lights(plan: ScenePlan, scene: MeasuredScene, origin: Vec3) -> tuple[PageLight, ...]:
    """Returns the lights of a scene at its start; empty if the file has none that a page can show.

    An area light is visible only with ray tracing, and is left out. A textured light is a spot without its image.
    `origin`: origin of the scene on the page [m].
    """
    return tuple(_lights(plan, scene, origin))


def _lights(plan: ScenePlan, scene: MeasuredScene, origin: Vec3) -> Iterator[PageLight]:
    ambient = plan.environment and plan.environment.ambient_light
    if ambient is not None:
        yield PageLight("ambient", *_brightness(ambient.row(scene.index), _PI))
    for light in plan.lights:
        if scene.index in light.scene_idxs and isinstance(light.light, DirectionalLight | PointLight | _Spot):
            yield _light(light, scene, origin)


_Spot = SpotLight | TexturedLight


def _light(light: Light, scene: MeasuredScene, origin: Vec3) -> PageLight:
    row = light.scene_idxs.index(scene.index)
    x, y, z, *q = compose(mount_pose(light, scene), to_pose(light.pose.row(row)))
    ahead = rotate(normalized((q[0], q[1], q[2], q[3])), (1.0, 0.0, 0.0))
    color, intensity = _brightness(light.color.row(row))
    shadow = light.shadow is not None and bool(light.shadow.on.row(row))
    place = (x + origin[0], y + origin[1], z + origin[2])
    if isinstance(light.light, DirectionalLight):
        back = (-ahead[0], -ahead[1], -ahead[2])
        return PageLight("directional", color, intensity, back, shadow=shadow)
    if not isinstance(light.light, _Spot):
        return PageLight("point", color, intensity, place, shadow=shadow)
    inner, outer = (float(one.row(row)) for one in (light.light.inner_fov, light.light.outer_fov))
    fades = 1 - min(inner / outer, 1) if outer > 0 else 0.0
    return PageLight("spot", color, intensity, place, (ahead, min(outer, _PI) / 2, fades), shadow)


def _brightness(linear: Sequence[float], factor: float = 1.0) -> tuple[tuple[int, int, int], float]:
    """Returns a colour with 255 as its largest component, and the intensity."""
    largest = max(map(float, linear)) or 1.0
    red, green, blue = (round(255 * linear_to_srgb(max(float(one), 0.0) / largest)) for one in linear)
    return (red, green, blue), largest * factor
