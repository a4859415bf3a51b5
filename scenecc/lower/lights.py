"""Lights as written to those of the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.lower.angles import lower_angle
from scenecc.lower.field_types import LIGHT_COLOR, FieldType, number
from scenecc.lower.mounts import mounted_pose, read_direction, read_pose
from scenecc.plan import (
    AreaLight,
    DirectionalLight,
    Light,
    PointLight,
    Shadow,
    SpotLight,
    TexturedLight,
    literal,
)
from scenecc.spec.references import qualified_name

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.frames import FrameGraph
    from scenecc.lower.materials import MaterialLowerer
    from scenecc.lower.mounts import MountLookup, MountPose
    from scenecc.plan import Value
    from scenecc.plan.body import Mount

_SHADOW = ("shadow_near", "shadow_far", "shadow_scale", "shadow_map_size")
"""Keys that say how a shadow is made."""

_FLAG = FieldType(dtype="bool", fallback=False)
_MAP_SIZE = FieldType(dtype="int64", quantity="map_size", fallback=1)
_HALF_WIDTH, _HALF_HEIGHT = number("half_width"), number("half_height")
_SCALE = number("Shadow.half_size")
_SHADOW_DEPTH = {"directional": number("Shadow.near")}
_POINT_SHADOW_DEPTH = number("Camera.near")
"""Shadows of a light that stands somewhere begin in front of it."""


class LightLowerer:
    """Lowers the lights of a document.

    Args:
        mounts: what they may be mounted on.
        places: where entities and frames stand.
        materials: of the document, for pictures.
        sink: takes the diagnostics.
    """

    def __init__(self, mounts: MountLookup, places: FrameGraph, materials: MaterialLowerer, sink: Sink) -> None:
        self._mounts = mounts
        self._places = places
        self._materials = materials
        self._sink = sink

    def lower(self, name: str, light: Any, leaves: FieldLowerer, origin: Origin) -> Light | None:
        """A light of the plan; None where what only its type has was reported.

        Args:
            name: of it.
            light: as written.
            leaves: over its scenes.
            origin: of it.
        """
        made = self._typed(light, leaves, origin)
        shadow = self._shadow(light, leaves, origin)
        color = leaves.value(light.color, LIGHT_COLOR, origin, "color")
        mount: Mount | None = None
        if light.mount is not None:
            mount = self._mounts.find(light.mount, leaves.scope, leaves.scenes, origin.child("mount"))
        pose = self._pose(name, light, leaves, origin)
        return made and Light(name, leaves.scenes, made, pose, color, mount, shadow, origin)

    def _typed(self, light: Any, leaves: FieldLowerer, origin: Origin) -> Any:
        match light.type:
            case "directional":
                return DirectionalLight()
            case "point":
                return PointLight()
            case "area":
                return AreaLight(
                    leaves.value(light.half_width, _HALF_WIDTH, origin, "half_width"),
                    leaves.value(light.half_height, _HALF_HEIGHT, origin, "half_height"),
                )
            case "spot":
                return SpotLight(*self._cone(light, leaves, origin))
            case _:
                texture = self._materials.texture(light.texture, origin.child("texture"), leaves)
                return texture and TexturedLight(*self._cone(light, leaves, origin), texture)

    def _cone(self, light: Any, leaves: FieldLowerer, origin: Origin) -> tuple[Value, Value]:
        inner, outer = (self._opening(light, name, leaves, origin) for name in ("inner_fov", "outer_fov"))
        return inner, outer

    def _opening(self, light: Any, name: str, leaves: FieldLowerer, origin: Origin) -> Value:
        found = lower_angle(light, name, origin, leaves)
        if found is None:
            message = f"a light of type {light.type} needs `{name}` [rad] or `{name}_deg`"
            self._sink.report("SC102", message, origin)
            return literal(1.0)
        return found

    def _shadow(self, light: Any, leaves: FieldLowerer, origin: Origin) -> Shadow | None:
        given = {key: item for key in _SHADOW if (item := getattr(light, key, None)) is not None}
        shadow = getattr(light, "shadow", None)
        if shadow is None or shadow is False:
            for key in given:
                self._sink.report(
                    "SC115",
                    f"`{key}` does nothing on a light without a shadow",
                    origin.child(key),
                    at="key",
                    hint="set shadow: true, or leave it out",
                )
            return None
        depth = _SHADOW_DEPTH.get(light.type, _POINT_SHADOW_DEPTH)
        return Shadow(
            leaves.value(light.shadow, _FLAG, origin, "shadow"),
            leaves.given(light.shadow_near, depth, origin, "shadow_near"),
            leaves.given(light.shadow_far, depth, origin, "shadow_far"),
            leaves.given(getattr(light, "shadow_scale", None), _SCALE, origin, "shadow_scale"),
            leaves.given(light.shadow_map_size, _MAP_SIZE, origin, "shadow_map_size"),
        )

    def _pose(self, name: str, light: Any, leaves: FieldLowerer, origin: Origin) -> Value:
        stand = self._stand(light, leaves, origin)
        if light.mount is not None:
            return mounted_pose(stand, "a light", origin, leaves)
        key = qualified_name("lights", name)
        return self._places.follow(key, stand.relative_to, stand.item, stand.reading, leaves, origin)

    def _stand(self, light: Any, leaves: FieldLowerer, origin: Origin) -> MountPose:
        given = [key for key in ("position", "direction") if getattr(light, key, None) is not None]
        if light.pose is not None:
            for key in given:
                self._sink.report(
                    "SC111",
                    f"`pose` says where the light is and shines to, and so does `{key}`",
                    origin.child(key),
                    at="key",
                    related=[("the pose", origin.child("pose"), "key")],
                )
            return read_pose(light.pose, origin, leaves)
        missing = _missing_pose_keys(light, given)
        if missing is not None:
            message = f"a light of type {light.type} needs {missing}, or a `mount`"
            self._sink.report("SC102", message, origin)
        return read_direction(getattr(light, "position", None), getattr(light, "direction", None), origin, leaves)


def _missing_pose_keys(light: Any, given: list[str]) -> str | None:
    """What a light lacks that stands nowhere or shines nowhere; None where it has what it needs."""
    if light.mount is not None:
        return None
    match light.type:
        case "directional":
            return None if "direction" in given else "a `direction` or a `pose`"
        case "point":
            return None if "position" in given else "a `position` or a `pose`"
        case "area":
            return "a `pose`"
        case _:
            return None if len(given) == 2 else "a `position` and a `direction`, or a `pose`"
