"""Light rigs for scenes that have no lights."""

from __future__ import annotations

from math import radians
from typing import TYPE_CHECKING, Final, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.plan.scene import ScenePlan


@frozen
class RigLight:
    """A directional light of a rig; `azimuth` [rad] is to the camera's right, from the subject."""

    azimuth: float
    elevation: float
    brightness: float


@frozen
class LightRig:
    """Lights for a scene that has none.

    Attributes:
        ambient: brightness from all directions.
        lights: key, fill and rim, white; the first casts a shadow if `shadow` is set.
        background: colour beyond the scene, as "#rrggbb".
    """

    ambient: float
    lights: tuple[RigLight, ...]
    shadow: bool
    background: str


Preset = Literal["studio", "plain", "dark"]


def _rig(ambient: float, key: float, fill: float, rim: float, background: str, *, shadow: bool = True) -> LightRig:
    """Makes a rig whose directions give the sides and the top of a box different shades at any heading."""
    places = ((-68, 49, key), (30, 16, fill), (-170, 43, rim))
    lights = tuple(RigLight(radians(azimuth), radians(elevation), value) for azimuth, elevation, value in places)
    return LightRig(ambient, lights, shadow, background)


LIGHT_RIGS: Final[dict[Preset, LightRig]] = {
    "studio": _rig(0.15, 2.0, 0.12, 0.6, "#e6e8eb"),
    "plain": _rig(0.24, 1.65, 0.04, 0.3, "#ffffff", shadow=False),
    "dark": _rig(0.04, 1.35, 0.06, 0.85, "#16181d"),
}
"""Rigs by `preset`. Diffuse surfaces are never brighter than white and never black."""

DEFAULT_PRESET: Final[Preset] = "studio"


def is_unlit(plan: ScenePlan) -> bool:
    """Whether a plan has no light, ambient light or environment map, so that a rig lights it."""
    around = plan.environment
    return not plan.lights and (around is None or (around.ambient_light is None and around.map is None))
