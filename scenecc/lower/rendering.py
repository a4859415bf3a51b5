"""Lowers lights, cameras and the environment."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import radians
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import IDENTITY, shortest_from_x
from scenecc.lower.field_types import (
    LIGHT_COLOR,
    POSITION,
    FieldType,
    field_type,
    report_unused_key,
)
from scenecc.lower.forms import FieldPlace, VariationLowerer, field_place
from scenecc.lower.local_poses import report_unused_anchor
from scenecc.lower.mounts import MountLookup
from scenecc.lower.poses import POSE, lower_angle, pose_item
from scenecc.plan import Value, literal
from scenecc.plan.rendering import (
    FAR,
    FOVY_DEGREES,
    HEIGHT,
    NEAR,
    WIDTH,
    AreaLight,
    Camera,
    CubeMap,
    DirectionalLight,
    Environment,
    Intrinsic,
    Light,
    Orthographic,
    Perspective,
    PointLight,
    Shadow,
    SkyMap,
    SpotLight,
    TexturedLight,
)
from scenecc.spec.pose import PoseMapping
from scenecc.spec.references import NameScopes, qualified_name
from scenecc.variation.forms import alternative_values
from scenecc.variation.nodes import Pointing, Posed

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.entities import EntityLowerer
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.frames import FrameGraph
    from scenecc.lower.materials import MaterialLowerer
    from scenecc.lower.references import PlanTables
    from scenecc.plan import Entity
    from scenecc.plan.body import Mount
    from scenecc.spec.document import SceneFile
    from scenecc.spec.rendering import CameraSpec as CameraKeys
    from scenecc.spec.rendering import EnvironmentSpec as EnvironmentKeys


_FORWARD = (1.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class MountPose:
    """A parsed pose.

    Attributes:
        item: seven numbers, or a node.
        variation: of the pose.
        relative_to: as written.
    """

    item: Any
    variation: VariationLowerer
    relative_to: str | None = None


def read_pose(pose: Any, origin: Origin, fields: FieldLowerer) -> MountPose:
    """Reads a pose; None: the identity. `origin`: of the node that has the key `pose`."""
    place = field_place(origin.child("pose"))
    variation = VariationLowerer(fields, place.origin)
    report_unused_anchor(pose, "on lights and cameras", place.origin, fields.sink)
    relative_to = pose.relative_to if isinstance(pose, PoseMapping) else None
    return MountPose(pose_item(pose, place, variation, fields.sink), variation, relative_to)


def read_direction(position: Any, direction: Any, origin: Origin, fields: FieldLowerer) -> MountPose:
    """Reads a position [m] and a direction. The shortest rotation turns +x to the direction. Either may be None."""
    variation = VariationLowerer(fields, origin)
    p: Any = (0.0, 0.0, 0.0) if position is None else position
    p = variation.item(p, POSITION, field_place(origin.child("position")))
    q = (
        IDENTITY
        if direction is None
        else _direction_turn(direction, field_place(origin.child("direction")), variation, fields)
    )
    if p.__class__ is tuple and q.__class__ is tuple:
        return MountPose((*p, *q), variation)
    return MountPose(Posed(p, q), variation)


def _direction_turn(direction: Any, place: FieldPlace, variation: VariationLowerer, fields: FieldLowerer) -> Any:
    def convert(one: Any) -> Any:
        return tuple(one) if any(one) else None

    def complain(_one: Any, origin: Origin, _sink: Any) -> None:
        fields.sink.report("SC114", "a direction of length 0 points nowhere", origin)

    item = variation.item(direction, FieldType((3,), convert=convert, complain=complain, fallback=_FORWARD), place)
    if item.__class__ is tuple:
        return shortest_from_x(item)
    return variation.risk(Pointing(item), place.origin)


def mounted_pose(mount_pose: MountPose, what: str, origin: Origin, fields: FieldLowerer) -> Value:
    """The pose of a mounted object in the frame of the body.

    Args:
        mount_pose: the parsed pose.
        what: the object, for a message.
        origin: of the node that has the key `pose`.
        fields: of the object.
    """
    if mount_pose.relative_to is not None:
        where = f"here: {what} that is mounted is in the frame of its body"
        hint = "leave `relative_to` out, or `mount`"
        report_unused_key("relative_to", where, origin.child("pose"), fields.sink, hint=hint)
    if mount_pose.item.__class__ is tuple:
        return literal(mount_pose.item)
    return fields.finish(mount_pose.item, mount_pose.variation, POSE, origin.child("pose"), reset=True)


@frozen
class RenderObjects:
    """Everything besides the entities that pictures need; fields as in `ScenePlan`."""

    environment: Environment | None = None
    lights: tuple[Light, ...] = ()
    cameras: tuple[Camera, ...] = ()


def lower_render_objects(
    scene: SceneFile,
    built: tuple[Entity, ...],
    entities: EntityLowerer,
    names: NameScopes,
    tables: PlanTables,
    materials: MaterialLowerer,
    of_all: FieldLowerer,
    origin: Origin,
    sink: Sink,
) -> RenderObjects:
    """Lowers the environment, lights and cameras of a document. Those with errors are left out.

    Args:
        scene: the document.
        built: its lowered entities.
        entities: has lowered them.
        names: of the document.
        tables: receive its files.
        materials: of the document, for pictures.
        of_all: field lowerer over all scenes.
        origin: of the document's root.
        sink: receives the diagnostics.
    """
    environment: Environment | None = None
    if scene.environment is not None:
        environment = lower_environment(scene.environment, tables, of_all, origin.child("environment"))
    mounts = MountLookup(built, entities.frames.unread, names, sink)
    lowering = _RenderObjectLowerer(mounts, entities.frames, materials, sink)
    lights = [
        lowering.light(name, light, entities.fields(qualified_name("lights", name)), origin.child("lights", name))
        for name, light in scene.lights.items()
    ]
    cameras = [
        lowering.camera(name, camera, entities.fields(name), origin.child("cameras", name))
        for name, camera in scene.cameras.items()
    ]
    return RenderObjects(environment, tuple(light for light in lights if light is not None), tuple(cameras))


FACES = ("px", "nx", "py", "ny", "pz", "nz")


def lower_environment(given: EnvironmentKeys, tables: PlanTables, fields: FieldLowerer, origin: Origin) -> Environment:
    """Lowers the environment of every scene. A map with an error is left out.

    Args:
        given: as written.
        tables: receive its files.
        fields: over all scenes.
        origin: of the environment.
    """
    ambient = fields.optional(given.ambient_light, LIGHT_COLOR, origin, "ambient_light")
    return Environment(ambient, _map(given.map, tables, fields, origin.child("map")), origin)


def _map(given: Any, tables: PlanTables, fields: FieldLowerer, origin: Origin) -> SkyMap | CubeMap | None:
    if given is None:
        return None
    if _are_faces(given):
        faces = [tables.files_of(getattr(given, face), origin.child(face), fields) for face in FACES]
        found = [face for face in faces if face is not None]
        return CubeMap(*found) if len(found) == len(FACES) else None
    if any(map(_are_faces, alternative_values(given))):
        message = "alternatives of a map must be files, not six images"
        fields.sink.report("SC321", message, origin, hint="write the form for each of px, nx, py, ny, pz and nz")
        return None
    file = tables.files_of(given, origin, fields)
    return None if file is None else SkyMap(file)


def _are_faces(given: Any) -> bool:
    """Whether the value is the six pictures of a cube map, not a file or a form of one."""
    return hasattr(given, FACES[0])


_SHADOW = ("shadow_near", "shadow_far", "shadow_scale", "shadow_map_size")
"""Keys for shadows."""

_FLAG = FieldType(dtype="bool", fallback=False)

_MAP_SIZE = field_type("Shadow.map_size", fallback=1)

_HALF_WIDTH, _HALF_HEIGHT = field_type("AreaLight.half_width"), field_type("AreaLight.half_height")

_SCALE = field_type("Shadow.half_size")

_SHADOW_DEPTH = {"directional": field_type("Shadow.near")}

_POINT_SHADOW_DEPTH = replace(field_type("Camera.near"), reset=False)
"""The shadow of a light with a position starts in front of it."""

_INTRINSIC = {name: field_type(f"Intrinsic.{name}") for name in ("fx", "fy", "cx", "cy", "skew")}

_TOP = field_type("Orthographic.top")

_NEAR, _FAR = field_type("Camera.near"), field_type("Camera.far")


@frozen
class _RenderObjectLowerer:
    """Lowers the lights and cameras of a document.

    Attributes:
        mounts: resolves their mounts.
        frames: poses of entities and frames.
        materials: of the document, for pictures.
        sink: receives the diagnostics.
    """

    mounts: MountLookup
    frames: FrameGraph
    materials: MaterialLowerer
    sink: Sink

    def light(self, name: str, light: Any, fields: FieldLowerer, origin: Origin) -> Light | None:
        """Lowers a light; None after an error in its type-specific keys.

        Args:
            name: of the light.
            light: as written.
            fields: over its scenes.
            origin: of the light.
        """
        made = self._make_light(light, fields, origin)
        shadow = self._shadow(light, fields, origin)
        color = fields.value(light.color, LIGHT_COLOR, origin, "color")
        mount = self._mount(light, fields, origin)
        mount_pose = self._read_light_pose(light, fields, origin)
        pose = self._pose(qualified_name("lights", name), light, "a light", mount_pose, fields, origin)
        return made and Light(name, fields.scenes, made, pose, color, mount, shadow, origin)

    def _make_light(self, light: Any, fields: FieldLowerer, origin: Origin) -> Any:
        match light.type:
            case "directional":
                return DirectionalLight()
            case "point":
                return PointLight()
            case "area":
                return AreaLight(
                    fields.value(light.half_width, _HALF_WIDTH, origin, "half_width"),
                    fields.value(light.half_height, _HALF_HEIGHT, origin, "half_height"),
                )
            case "spot":
                return SpotLight(*self._cone(light, fields, origin))
            case _:
                texture = self.materials.texture(light.texture, origin.child("texture"), fields)
                return texture and TexturedLight(*self._cone(light, fields, origin), texture)

    def _cone(self, light: Any, fields: FieldLowerer, origin: Origin) -> tuple[Value, Value]:
        inner, outer = (self._read_opening(light, name, fields, origin) for name in ("inner_fov", "outer_fov"))
        return inner, outer

    def _read_opening(self, light: Any, name: str, fields: FieldLowerer, origin: Origin) -> Value:
        found = lower_angle(light, f"SpotLight.{name}", origin, fields)
        if found is None:
            message = f"a light of type {light.type} needs `{name}` [rad] or `{name}_deg`"
            self.sink.report("SC102", message, origin)
            return literal(1.0)
        return found

    def _shadow(self, light: Any, fields: FieldLowerer, origin: Origin) -> Shadow | None:
        given = {key: item for key in _SHADOW if (item := getattr(light, key, None)) is not None}
        shadow = getattr(light, "shadow", None)
        if shadow is None or shadow is False:
            for key in given:
                hint = "set `shadow: true`, or leave it out"
                report_unused_key(key, "on a light without a shadow", origin, self.sink, hint=hint)
            return None
        depth = _SHADOW_DEPTH.get(light.type, _POINT_SHADOW_DEPTH)
        return Shadow(
            fields.value(light.shadow, _FLAG, origin, "shadow"),
            fields.optional(light.shadow_near, depth, origin, "shadow_near"),
            fields.optional(light.shadow_far, depth, origin, "shadow_far"),
            fields.optional(getattr(light, "shadow_scale", None), _SCALE, origin, "shadow_scale"),
            fields.optional(light.shadow_map_size, _MAP_SIZE, origin, "shadow_map_size"),
        )

    def _read_light_pose(self, light: Any, fields: FieldLowerer, origin: Origin) -> MountPose:
        given = [key for key in ("position", "direction") if getattr(light, key, None) is not None]
        if light.pose is not None:
            return read_pose(light.pose, origin, fields)
        missing = _find_missing_pose_keys(light, given)
        if missing is not None:
            message = f"a light of type {light.type} needs {missing}, or a `mount`"
            self.sink.report("SC102", message, origin)
        return read_direction(getattr(light, "position", None), getattr(light, "direction", None), origin, fields)

    def camera(self, name: str, camera: CameraKeys, fields: FieldLowerer, origin: Origin) -> Camera:
        """Lowers a camera.

        Args:
            name: of the camera.
            camera: as written.
            fields: over its scenes.
            origin: of the camera.
        """
        width = WIDTH if camera.width is None else camera.width
        height = HEIGHT if camera.height is None else camera.height
        mount = self._mount(camera, fields, origin)
        return Camera(
            name=name,
            scene_idxs=fields.scenes,
            pose=self._pose(name, camera, "a camera", read_pose(camera.pose, origin, fields), fields, origin),
            width=width,
            height=height,
            lens=self._lens(camera, (width, height), fields, origin),
            near=literal(NEAR) if camera.near is None else fields.value(camera.near, _NEAR, origin, "near"),
            far=literal(float(FAR)) if camera.far is None else fields.value(camera.far, _FAR, origin, "far"),
            mount=mount,
            shader=camera.shader,
            origin=origin,
        )

    def _mount(self, given: Any, fields: FieldLowerer, origin: Origin) -> Mount | None:
        if given.mount is None:
            return None
        return self.mounts.find(given.mount, fields.scope, fields.scenes, origin.child("mount"))

    def _pose(
        self, key: str, given: Any, what: str, mount_pose: MountPose, fields: FieldLowerer, origin: Origin
    ) -> Value:
        """The pose of a light or a camera. `key`: its name among frames."""
        if given.mount is not None:
            return mounted_pose(mount_pose, what, origin, fields)
        return self.frames.follow(key, mount_pose.relative_to, mount_pose.item, mount_pose.variation, fields, origin)

    def _lens(
        self, camera: Any, size: tuple[int, int], fields: FieldLowerer, origin: Origin
    ) -> Perspective | Intrinsic | Orthographic:
        if camera.orthographic is not None:
            return Orthographic(fields.value(camera.orthographic.top, _TOP, origin, "orthographic", "top"))
        if camera.intrinsic is not None:
            return _intrinsic(camera.intrinsic, size, fields, origin)
        fovx = lower_angle(camera, "Perspective.fovx", origin, fields)
        if fovx is not None:
            return Perspective(fovx=fovx)
        fovy = lower_angle(camera, "Perspective.fovy", origin, fields)
        return Perspective(fovy=literal(radians(FOVY_DEGREES)) if fovy is None else fovy)


def _find_missing_pose_keys(light: Any, given: list[str]) -> str | None:
    """The keys that a light lacks for its position or direction; None if it is complete."""
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


def _intrinsic(given: Any, size: tuple[int, int], fields: FieldLowerer, origin: Origin) -> Intrinsic:
    left_out = {"cx": size[0] / 2, "cy": size[1] / 2, "skew": 0.0}
    values: dict[str, Value] = {}
    for name, kind in _INTRINSIC.items():
        item = getattr(given, name)
        values[name] = literal(left_out[name]) if item is None else fields.value(item, kind, origin, "intrinsic", name)
    return Intrinsic(**values)
