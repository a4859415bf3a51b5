"""Environment maps, lights and the view of collision shapes, and the setup of everything that pictures need."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.backends.sapien.assets import Resources
from scenecc.backends.sapien.cameras import (
    DEFAULT_CAMERA,
    DEFAULT_HEIGHT,
    DEFAULT_WIDTH,
    NOT_RENDERED,
    CameraBatch,
    RenderComponentBatch,
    attach_component,
    build_camera,
    check_ray_tracing,
    default_camera,
    new_camera,
    render_bodies,
    rows_by_scene,
    set_orthographic_again,
)
from scenecc.backends.sapien.engine import EngineFailure, physx, render
from scenecc.backends.sapien.geometry import RENDER_SHAPES
from scenecc.backends.sapien.solids import read_solids
from scenecc.plan import literal
from scenecc.plan.framing import azimuth_of, find_subject, frame_subject, hidden_share, toward
from scenecc.plan.light_rigs import DEFAULT_PRESET, LIGHT_RIGS, is_unlit
from scenecc.plan.rendering import (
    COLLISION_COLORS,
    LIGHT_CLASSES,
    LIGHT_NUMBERS,
    PLANE_HALF_SIZE,
    AreaLight,
    CubeMap,
    Perspective,
    SkyMap,
    TexturedLight,
    shadow_parameters,
)
from scenecc.plan.schema import PIXEL_BOUNDS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.preparation import EntityLookup
    from scenecc.plan import ScenePlan, Value
    from scenecc.plan.framing import FramedView, Subject, View
    from scenecc.plan.light_rigs import LightRig, Preset
    from scenecc.plan.rendering import Camera, Environment, Light, ShaderName


def has_light(scene: Any) -> bool:
    """Returns whether a live scene has any lights, ambient light or environment map, from the plan or added by hand."""
    system = scene.render_system
    return bool(system.get_lights()) or any(system.get_ambient_light()) or system.get_cubemap() is not None


def light_values(light: Light) -> dict[str, Value]:
    """Returns the values of a light by SAPIEN's property names, in the order in which they are set."""
    own = {name: getattr(light.light, name) for name in LIGHT_NUMBERS[type(light.light)]}
    return {"color": light.color, **shadow_parameters(light), **own}


def build_light(light: Light, lookup: EntityLookup, resources: Resources) -> list[Any]:
    """Returns the component of a light in each built scene that has it.

    Raises:
        EngineFailure: its image cannot be loaded.
    """
    values = light_values(light)
    made: list[Any] = []
    for number, row in rows_by_scene(light, lookup):
        component = getattr(render, LIGHT_CLASSES[type(light.light)])()
        given = {name: value.row(row) for name, value in values.items()}
        if isinstance(light.light, AreaLight):  # SAPIEN has one setter for both
            component.set_shape(float(given.pop("half_width")), float(given.pop("half_height")))
        for name, value in given.items():
            setattr(component, name, value if value.ndim else value.item())
        if isinstance(light.light, TexturedLight):
            component.texture = resources.texture(light.light.texture, row)
        attach_component(component, light, row, lookup, number)
        made.append(component)
    return made


def build_environment(environment: Environment, lookup: EntityLookup, resources: Resources) -> None:
    """Sets the ambient light and environment map of each scene.

    Raises:
        EngineFailure: the map cannot be loaded.
    """
    maps: dict[tuple[str, ...], Any] = {}
    for scene, index in zip(lookup.scenes, lookup.scene_idxs, strict=True):
        if environment.ambient_light is not None:
            scene.render_system.ambient_light = environment.ambient_light.row(index)
        if environment.map is None:
            continue
        files = _cubemap_files(environment.map, index)
        paths = tuple(resources.path(file) for file in files)
        if paths not in maps:
            for file, path in zip(files, paths, strict=True):
                if not path.endswith(_CHECKED_TO_THE_END):
                    resources.image(file)
            maps[paths] = _make_cubemap(paths, environment)
        scene.render_system.cubemap = maps[paths]


_CHECKED_TO_THE_END: Final = (".hdr", ".ktx")
"""Suffixes of images that SAPIEN loads if scenecc accepts them. Others are loaded once as a texture, because a map is
only read at the first picture.
"""


def _cubemap_files(surroundings: SkyMap | CubeMap, index: int) -> list[int]:
    if isinstance(surroundings, SkyMap):
        return [int(surroundings.file.row(index))]
    faces = (getattr(surroundings, face) for face in ("px", "nx", "py", "ny", "pz", "nz"))
    return [int(face.row(index)) for face in faces]


def _make_cubemap(paths: tuple[str, ...], environment: Environment) -> Any:
    try:
        return render.RenderCubemap(*paths)
    except RuntimeError as error:
        origin = environment.origin and environment.origin.child("map")
        message = f"the renderer cannot load the map '{paths[0]}': {error}"
        raise EngineFailure("SC807", message, origin=origin) from error


def _flat_shaded_mesh(shape: Any, material: Any) -> Any:
    """Returns a mesh with flat shading, so that edges are visible: shared vertices would make it look round."""
    corners = np.asarray(shape.vertices * shape.scale, np.float32)[shape.triangles]
    if np.prod(shape.scale) < 0:
        corners = corners[:, ::-1]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(np.float32).tiny)
    faces = np.arange(3 * len(corners), dtype=np.uint32).reshape(-1, 3)
    return render.RenderShapeTriangleMesh(
        corners.reshape(-1, 3), faces, np.repeat(normals, 3, axis=0), np.zeros((0, 2), np.float32), material
    )


def _render_shape(shape: Any, material: Any) -> Any:
    """Returns a render shape with the form of a collision shape."""
    if isinstance(shape, physx.PhysxCollisionShapePlane):
        return render.RenderShapePlane([1, PLANE_HALF_SIZE, PLANE_HALF_SIZE], material)
    like = RENDER_SHAPES.get(type(shape))
    if like is None:
        return _flat_shaded_mesh(shape, material)
    return like.engine(*(getattr(shape, name) for name in like.sizes), material)


class CollisionView:
    """Shows the collision shapes of bodies, with one material for each body type."""

    def __init__(self) -> None:
        self._materials = {kind: render.RenderMaterial(base_color=color) for kind, color in COLLISION_COLORS.items()}

    def show(self, entity: Any) -> None:
        """Replaces the visuals of a `sapien.Entity` by its collision shapes, if any."""
        for component in entity.components:
            if isinstance(component, render.RenderBodyComponent):
                entity.remove_component(component)
        for component in entity.components:
            if isinstance(component, physx.PhysxRigidBaseComponent) and component.collision_shapes:
                entity.add_component(self._body(component))

    def _body(self, component: Any) -> Any:
        body: Any = render.RenderBodyComponent()
        material = self._materials[_body_type(component)]
        for shape in component.collision_shapes:
            drawn = _render_shape(shape, material)
            drawn.local_pose = shape.local_pose
            body.attach(drawn)
        body.name = component.name
        return body


def _body_type(component: Any) -> str:
    if isinstance(component, physx.PhysxArticulationLinkComponent):
        return "link"
    if isinstance(component, physx.PhysxRigidStaticComponent):
        return "static"
    return "kinematic" if component.kinematic else "dynamic"


class LightSet:
    """Environment and lights of scenes.

    Attributes:
        lights: by name, in the order of the plan.
    """

    def __init__(self, plan: ScenePlan, lookup: EntityLookup, *, rendered: bool) -> None:
        """Builds them if the scenes render.

        Raises:
            EngineFailure: the renderer cannot make one.
        """
        self._plan = plan
        self._lookup: EntityLookup | None = lookup
        self._rendered = rendered
        built: dict[str, list[Any]] = {}
        if rendered:
            resources = Resources(plan)
            if plan.environment is not None:
                build_environment(plan.environment, lookup, resources)
            built = {light.name: build_light(light, lookup, resources) for light in plan.lights}
        self.lights: dict[str, LightBatch] = {
            light.name: LightBatch(light.name, self._built_scenes_with(light), built.get(light.name))
            for light in plan.lights
        }

    def _built_scenes_with(self, item: Light | Camera) -> tuple[int, ...]:
        assert self._lookup is not None
        having = frozenset(item.scene_idxs)
        return tuple(index for index in self._lookup.scene_idxs if index in having)

    @property
    def render_systems(self) -> dict[int, Any]:
        """Returns the render systems by scene index; empty if nothing renders."""
        lookup = self._lookup
        if lookup is None or not self._rendered:
            return {}
        return {index: scene.render_system for index, scene in zip(lookup.scene_idxs, lookup.scenes, strict=True)}


_MOST_HIDDEN: Final = 0.5
"""Largest fraction of the subject's bodies that may be hidden from the key light."""

_SHADOW_MAP: Final = 4096
"""Side of the shadow map of the default key light [px]."""


def _shadow_depth(radius: float) -> float:
    """Returns half the depth of that shadow map [m]: what is farther is black, and float32 resolves 1e-7 of it."""
    return radius * min(max(100 / radius, 200), 1e4)


def _free_side(subject: Subject, ahead: float, rig: LightRig) -> tuple[int, bool]:
    """Returns 1 for the rig or -1 for its mirror image, and whether the key light casts a shadow.

    The rig is mirrored if a wall hides the subject from the key light. Within walls the key light casts no shadow.
    """
    key, distance = rig.lights[0], 100 * subject.radius
    for side in (1, -1):
        place = subject.center + distance * toward(ahead + side * key.azimuth, key.elevation)
        if hidden_share(subject, place) <= _MOST_HIDDEN:
            return side, rig.shadow
    return 1, False


def _without_unused_metal(scene: Any) -> None:
    """Removes the metallic textures of mesh files whose metallic factor is 0.

    In glTF the factor multiplies the texture, but SAPIEN ignores it. Such a surface, for example the top of ManiSkill's
    table, would be pure metal, on which no shadow is visible. Textures of scene files have a file name and stay.
    """
    shapes = (shape for body in scene.render_system.render_bodies for shape in body.render_shapes)
    for shape in shapes:
        for part in shape.parts if isinstance(shape, render.RenderShapeTriangleMesh) else ():
            look = part.material
            if look.metallic == 0 and look.metallic_texture is not None and not look.metallic_texture.filename:
                look.metallic_texture = None


class LightsAndCameras(LightSet):
    """Lights and cameras of a batch.

    Attributes:
        cameras: by name, in the order of the plan.
        preset: the rig that lights a scene without lights at its first picture.
    """

    def __init__(self, plan: ScenePlan, lookup: EntityLookup, *, rendered: bool) -> None:
        """Builds them if the batch renders.

        Raises:
            EngineFailure: the renderer cannot make one.
        """
        super().__init__(plan, lookup, rendered=rendered)
        self._seen_by_people = [entity.name for entity in plan.entities if entity.hidden]
        self.preset: Preset = DEFAULT_PRESET
        self._dark = set(lookup.scene_idxs) if is_unlit(plan) else set[int]()
        self.cameras = {
            camera.name: self._camera(camera, build_camera(camera, lookup) if rendered else None)
            for camera in plan.cameras
        }
        self._framed: list[CameraBatch] = []
        if not plan.cameras:
            self.cameras[DEFAULT_CAMERA] = self.framed()

    def _light_up(self, index: int, view: Callable[[int], FramedView] | None = None) -> None:
        """Lights a scene before its first picture if it has no light; otherwise pictures would be black.

        This happens only then, so that the built scene has nothing that the file lacks. The rig is placed for `view`,
        or for a camera that frames the scene.
        """
        if index not in self._dark or self._lookup is None:
            return
        self._dark.remove(index)
        scene = self._scene(index)
        if has_light(scene):
            return
        subject, rig = self.subject(index), LIGHT_RIGS[self.preset]
        seen = None if view is None else view(index)
        ahead = azimuth_of(subject.center if seen is None else seen.pose[:3], subject)
        reach = subject.reach(50 * subject.radius if seen is None else seen.visible(subject.center))
        scene.set_ambient_light([rig.ambient] * 3)
        _without_unused_metal(scene)
        side, shadowed = _free_side(subject, ahead, rig)
        for number, light in enumerate(rig.lights):
            scene.add_directional_light(
                -toward(ahead + side * light.azimuth, light.elevation),
                [light.brightness] * 3,
                shadow=shadowed and number == 0,
                position=subject.center,
                shadow_scale=reach,
                shadow_near=-_shadow_depth(subject.radius),
                shadow_far=_shadow_depth(subject.radius),
                shadow_map_size=_SHADOW_MAP,
            )

    def _scene(self, index: int) -> Any:
        assert self._lookup is not None
        return self._lookup.scenes[self._lookup.scene_idxs.index(index)]

    def subject(self, index: int, focus: str | None = None) -> Subject:
        """Returns what a picture of the current scene frames.

        Args:
            index: of the scene.
            focus: the only entity or link (ENTITY/LINK) to frame. None: what moves.

        Raises:
            KeyError: this entity has no visuals in the scene.
            RuntimeError: the batch was built without rendering.
        """
        assert self._lookup is not None
        self._check_rendered()
        scene = self._scene(index)
        scene.update_render()
        solids, owners = read_solids(scene)
        if focus is None:
            return find_subject(solids)
        wanted = {
            entity for name, entity in self._lookup.entities(index) if name == focus or name.startswith(f"{focus}/")
        }
        bodies = [number for number in set(solids.bodies.tolist()) if owners[number] in wanted]
        if not bodies:
            raise KeyError(focus)
        return find_subject(solids, bodies)

    def poses(self, index: int) -> dict[str, NDArray[np.float64]]:
        """Returns the poses (7,) of bodies in a scene, by name; links are ENTITY/LINK."""
        assert self._lookup is not None
        return {
            name: np.concatenate([entity.pose.p, entity.pose.q]).astype(np.float64)
            for name, entity in self._lookup.entities(index)
            if entity.get_scene() is not None
        }

    def _camera(self, camera: Camera, objs: list[Any] | None) -> CameraBatch:
        return CameraBatch(
            camera.name, self._built_scenes_with(camera), objs, self._hidden, self._names, self._light_up
        )

    def framed(
        self,
        width: int = DEFAULT_WIDTH,
        height: int = DEFAULT_HEIGHT,
        *,
        focus: str | None = None,
        eye: Sequence[float] | None = None,
        look_at: Sequence[float] | None = None,
        view: View | None = None,
        zoom: float = 1.0,
        shader: ShaderName | None = None,
    ) -> CameraBatch:
        """Returns a camera that frames each scene at its first picture.

        It is added to a scene with that picture, because it takes memory.

        Raises:
            ValueError: the renderer does not support pictures of this size [px].
            RuntimeError: the device does not support ray tracing, which the shader needs.
        """
        for size in (width, height):
            if not PIXEL_BOUNDS.allow(size):
                raise ValueError(
                    f"pictures must be {PIXEL_BOUNDS.low} to {PIXEL_BOUNDS.high} pixels a side, not {size}"
                )
        camera = default_camera(self._plan.num_scenes, width, height, shader)
        if self._rendered:
            try:
                check_ray_tracing(camera)
            except EngineFailure as failure:
                raise RuntimeError(f"{failure.message}: {failure.hint}") from failure
        present = self._built_scenes_with(camera)

        def framing(index: int) -> FramedView:
            subject = self.subject(index, focus)
            return frame_subject(subject, width, height, eye=eye, look_at=look_at, view=view, zoom=zoom)

        found = CameraBatch(
            camera.name,
            present,
            [None] * len(present) if self._rendered else None,
            self._hidden,
            self._names,
            lambda index: self._light_up(index, framing),
            lambda number: self._frame(camera, found, number, framing),
        )
        self._framed.append(found)
        return found

    def _frame(self, camera: Camera, batch: CameraBatch, number: int, view: Callable[[int], FramedView]) -> None:
        assert self._lookup is not None
        if batch.objs[number] is not None:
            return
        seen = view(self._lookup.scene_idxs[number])
        camera = replace(
            camera,
            pose=literal(tuple(seen.pose.tolist())),
            lens=Perspective(fovy=literal(seen.fovy)),
            near=literal(seen.near),
            far=literal(seen.far),
        )
        component = new_camera(camera, 0)
        attach_component(component, camera, 0, self._lookup, number)
        batch.objs[number] = component

    def show_collision(self) -> None:
        """Shows collision shapes instead of visuals from now on.

        Raises:
            RuntimeError: the batch was built without rendering.
        """
        assert self._lookup is not None
        self._check_rendered()
        shown = CollisionView()
        for index in self._lookup.scene_idxs:
            for _, entity in self._lookup.entities(index):
                shown.show(entity)

    def _check_rendered(self) -> None:
        if not self._rendered:
            raise RuntimeError(NOT_RENDERED.format(what="visuals"))

    def _hidden(self, index: int) -> list[Any]:
        if not self._seen_by_people or self._lookup is None:
            return []
        hidden = {*self._seen_by_people}
        return [
            body
            for name, entity in self._lookup.entities(index)
            if name in hidden or name.rpartition("/")[0] in hidden
            for body in render_bodies(entity)
        ]

    def _names(self, index: int) -> dict[int, str]:
        assert self._lookup is not None
        return {
            entity.get_per_scene_id(): name
            for name, entity in self._lookup.entities(index)
            if entity.get_scene() is not None
        }

    def enter_new_scene(self, scene_idx: int) -> None:
        """Restores camera settings that SAPIEN loses when the entities of a scene move to another `sapien.Scene`."""
        for camera in self.cameras.values():
            if self._rendered and scene_idx in camera.scene_idxs:
                set_orthographic_again(camera.objs[camera.scene_idxs.index(scene_idx)])

    def close(self) -> None:
        """Releases all objects."""
        for each in (*self.lights.values(), *self.cameras.values(), *self._framed):
            each._close()  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
        self.lights, self.cameras, self._framed, self._lookup = {}, {}, [], None


class LightBatch(RenderComponentBatch):
    """One light of the plan; `objs` are `sapien.render.RenderLightComponent`s."""
