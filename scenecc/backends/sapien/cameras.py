"""Cameras in live scenes: creating and attaching them, framing a scene, and taking pictures as arrays."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.backends.sapien.engine import EngineFailure, render, sapien, supports_ray_tracing
from scenecc.backends.sapien.objects import ComponentBatch
from scenecc.backends.sapien.properties import to_poses
from scenecc.diagnostics.messages import listed, suggest
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.options import check_scene_idxs
from scenecc.plan import literal
from scenecc.plan.framing import FRAMING_FOVY
from scenecc.plan.rendering import (
    RAY_TRACING_SHADERS,
    Camera,
    Intrinsic,
    Orthographic,
    Perspective,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.preparation import EntityLookup
    from scenecc.plan.rendering import Light, ShaderName


MILLIMETRES = 1000.0
"""SAPIEN's shader pack `minimal` stores positions in millimetres."""


def read_color_image(camera: Any) -> NDArray[Any]:
    """Returns (H, W, 4) float32 RGBA as displayed (not linear), 0 to 1, and above 1 where brighter."""
    return camera.get_picture("Color")


def read_position(camera: Any) -> NDArray[Any]:
    """Returns (H, W, 3) float32 [m] in the frame of SAPIEN's pictures: x right, y up, z backwards.

    0 where there is nothing.
    """
    names = camera.get_picture_names()
    if "PositionSegmentation" in names:
        return camera.get_picture("PositionSegmentation")[..., :3].astype(np.float32) / np.float32(MILLIMETRES)
    found: NDArray[Any] = camera.get_picture("Position")[..., :3]
    if "HdrColor" in names:
        # Ray tracing gives the background a position too.
        found = np.where(read_segmentation(camera) == 0, np.float32(0), found)
    return found


def read_depth(camera: Any) -> NDArray[Any]:
    """Returns (H, W, 1) float32 [m], positive along the camera's axis; 0 where there is nothing."""
    # A subtraction gives 0.0, not -0.0, where there is nothing.
    return np.float32(0) - read_position(camera)[..., 2:3]


def read_segmentation(camera: Any) -> NDArray[Any]:
    """Returns (H, W, 1) int32, the `per_scene_id` of the visible entity; 0 where there is nothing."""
    if "PositionSegmentation" in camera.get_picture_names():
        return camera.get_picture("PositionSegmentation")[..., 3:4].astype(np.int32)
    return camera.get_picture("Segmentation")[..., 1:2].astype(np.int32)


def read_normal(camera: Any) -> NDArray[Any]:
    """Returns surface normals (H, W, 3) float32 in the frame of `read_position`; 0 where there is nothing.

    Raises:
        ValueError: the camera's shader pack does not have this picture.
    """
    if "Normal" not in (names := camera.get_picture_names()):
        raise ValueError(f"no picture 'normal' with this shader; {listed((*PICTURES, *sorted(names)), 'normal')}")
    return np.where(read_segmentation(camera) == 0, np.float32(0), camera.get_picture("Normal")[..., :3])


PICTURES: Final[dict[str, Callable[[Any], NDArray[Any]]]] = {
    "color": read_color_image,
    "depth": read_depth,
    "segmentation": read_segmentation,
    "position": read_position,
}
"""Pictures that every camera takes, in addition to SAPIEN's own."""

_READERS: Final[dict[str, Callable[[Any], NDArray[Any]]]] = {**PICTURES, "normal": read_normal}


def read_picture(camera: Any, what: str) -> NDArray[Any]:
    """Returns a picture that was taken, (H, W, C).

    Raises:
        ValueError: there is no picture of this name.
    """
    read = _READERS.get(what)
    if read is not None:
        return read(camera)
    names = camera.get_picture_names()
    if what not in names:
        raise ValueError(f"no picture {what!r}; {suggest(what, (*PICTURES, *sorted(names)))}")
    found: NDArray[Any] = camera.get_picture(what)
    return found if found.ndim == 3 else found[..., None]


NOT_RENDERED = (
    "the batch was built without rendering, so it has no {what}; build with render=True on a machine with a "
    "Vulkan driver"
)


class RenderComponentBatch(ComponentBatch):
    """A light or a camera of the plan, in every scene that has it. `objs` is None if the batch does not render."""

    def __init__(self, name: str, scene_idxs: tuple[int, ...], objs: list[Any] | None) -> None:
        super().__init__(name, scene_idxs, [] if objs is None else objs)
        self._rendered = objs is not None

    @property
    def objs(self) -> list[Any]:
        """SAPIEN's component in each of these scenes.

        Raises:
            RuntimeError: the batch was built without rendering, or is closed.
        """
        found = super().objs
        if not self._rendered:
            raise RuntimeError(NOT_RENDERED.format(what=f"'{self._name}'"))
        return found


class CameraBatch(RenderComponentBatch):
    """One camera of the plan; `objs` are `sapien.render.RenderCameraComponent`s.

    Args:
        hidden: returns the render bodies of a scene that are hidden from sensors.
        names: returns the names of the entities in a scene by their ids.
        light: called with a scene's index before each picture.
        aim: called with a row before each picture.
    """

    def __init__(
        self,
        name: str,
        scene_idxs: tuple[int, ...],
        objs: list[Any] | None,
        hidden: Callable[[int], Sequence[Any]],
        names: Callable[[int], dict[int, str]],
        light: Callable[[int], None],
        aim: Callable[[int], None] | None = None,
    ) -> None:
        super().__init__(name, scene_idxs, objs)
        self._hidden = hidden
        self._names = names
        self._light = light
        self._aim = aim

    def capture(
        self,
        what: str | Sequence[str] = tuple(PICTURES),
        scene_idxs: Sequence[int] | None = None,
        *,
        human: bool = False,
        shift: tuple[float, float] = (0, 0),
    ) -> dict[str, NDArray[Any]]:
        """Takes pictures of the scenes as they are now.

        Args:
            what: names of these pictures, or SAPIEN's own ("Normal", "Albedo", …), which are returned unchanged, with a
                last axis:

                - "color": (B, H, W, 4) float32 RGBA as displayed, 0 to 1.
                - "depth": (B, H, W, 1) float32 [m] along the camera's axis, 0 where there is nothing.
                - "segmentation": (B, H, W, 1) int32, ids of entities; `names` maps them to names. 0: nothing.
                - "position": (B, H, W, 3) float32 [m] in the frame of SAPIEN's pictures: x right, y up, z backwards;
                  `objs[i].get_model_matrix()` transforms it to the world. 0 where there is nothing.
                - "normal": (B, H, W, 3) float32 surface normals in the frame of "position", 0 where there is nothing.
                  Only if requested, because not every shader pack has it.
            scene_idxs: scenes to show, in this order. Default: all.
            human: show what the plan hides from sensors.
            shift: how far to shift the image right and down [px]. The mean of pictures with shifts within a pixel has
                smooth edges.

        Returns:
            Name → array; rows are the scenes.

        Raises:
            ValueError: there is no such picture.
            KeyError: the camera is not in this scene, or the scene is not in the batch.
            RuntimeError: the batch was built without rendering, it is closed, the camera was retired, or the body that
                it is mounted on is removed.
        """
        wanted = [what] if isinstance(what, str) else list(what)
        rows = self._rows(scene_idxs)
        found = [self._take(row, wanted, shift, human=human) for row in rows]
        return {name: np.stack([shot[i] for shot in found]) for i, name in enumerate(wanted)}

    def retire(self, scene_idx: int) -> None:
        """Removes the camera from a scene, and frees its image memory (about 300 bytes a pixel).

        A camera of `SceneBatch.framed` returns with the next picture of the scene and frames it again. Others take no
        more pictures of it.

        Raises:
            KeyError: the camera is not in this scene, or the scene is not in the batch.
            RuntimeError: the batch was built without rendering, or is closed.
        """
        (row,) = self._rows([scene_idx])
        component = self.objs[row]
        if component is not None:
            component.get_entity().remove_component(component)
            self.objs[row] = None

    def names(self, scene_idx: int) -> dict[int, str]:
        """Returns id → name for the segmentation of a scene: names of entities, and ENTITY/LINK for links.

        Raises:
            KeyError: the camera is not in this scene, or the scene is not in the batch.
            RuntimeError: the batch was built without rendering, or is closed.
        """
        self._rows([scene_idx])
        return self._names(scene_idx)

    def _rows(self, scene_idxs: Sequence[int] | None) -> list[int]:
        have, _ = self._scene_idxs, self.objs
        if scene_idxs is None:
            return list(range(len(have)))
        for index in (chosen := check_scene_idxs(scene_idxs)):
            if index not in have:
                raise KeyError(f"'{self._name}' is not in scene {index} of this batch; it is in {list(have)}")
        return [have.index(index) for index in chosen]

    def _take(self, row: int, wanted: Sequence[str], shift: tuple[float, float], *, human: bool) -> list[NDArray[Any]]:
        self._light(self._scene_idxs[row])
        if self._aim is not None:
            self._aim(row)
        camera = self.objs[row]
        if camera is None:
            raise RuntimeError(f"'{self._name}' was removed from scene {self._scene_idxs[row]}")
        scene = camera.get_entity().get_scene()
        if scene is None:
            raise RuntimeError(f"the mount of '{self._name}' is not in scene {self._scene_idxs[row]} now")
        hidden: Sequence[Any] = () if human else self._hidden(self._scene_idxs[row])
        with _hide_bodies(hidden, scene), _shift_picture(camera, *shift):
            scene.update_render()
            camera.take_picture()
            try:
                return [read_picture(camera, name) for name in wanted]
            except BaseException:
                # Reading waits for the device. Clearing a scene that is still being drawn crashes the process.
                with suppress(RuntimeError):
                    camera.get_picture(camera.get_picture_names()[0])
                raise


@contextmanager
def _hide_bodies(bodies: Sequence[Any], scene: Any) -> Generator[None, None, None]:
    """Hides render bodies of a scene within the block."""
    before = [body.visibility for body in bodies]
    try:
        for body in bodies:
            body.visibility = 0.0
        yield
    finally:
        for body, visibility in zip(bodies, before, strict=True):
            body.visibility = visibility
        if bodies:
            scene.update_render()


@contextmanager
def _shift_picture(camera: Any, right: float, down: float) -> Generator[None, None, None]:
    """Shifts a camera's image by some pixels within the block."""
    if right == down == 0:
        yield
    elif camera.mode == "orthographic":
        sides = [camera.ortho_left, camera.ortho_right, camera.ortho_bottom, camera.ortho_top]
        x, y = right * (sides[1] - sides[0]) / camera.width, down * (sides[3] - sides[2]) / camera.height
        camera.set_orthographic_parameters(
            camera.near, camera.far, sides[0] - x, sides[1] - x, sides[2] + y, sides[3] + y
        )
        try:
            yield
        finally:
            camera.set_orthographic_parameters(camera.near, camera.far, *sides)
    else:
        cx, cy = camera.cx, camera.cy
        camera.set_principal_point(cx + right, cy + down)
        try:
            yield
        finally:
            camera.set_principal_point(cx, cy)


def render_bodies(entity: Any) -> list[Any]:
    """Returns the render bodies of a `sapien.Entity`."""
    return [each for each in entity.components if isinstance(each, render.RenderBodyComponent)]


def attach_component(component: Any, item: Light | Camera, row: int, lookup: EntityLookup, number: int) -> None:
    """Adds a component, which is in no entity yet, to the scene with this number. `row`: of `item` in the plan's
    values.

    Raises:
        EngineFailure: the renderer cannot create it.
    """
    component.name = item.name
    try:
        if item.mount is not None:
            lookup.entity(item.mount, number).add_component(component)
            component.local_pose = sapien_pose(item.pose.row(row))
            return
        entity: Any = sapien.Entity()
        entity.name = item.name
        entity.add_component(component)
        entity.set_pose(sapien_pose(item.pose.row(row)))
        lookup.scenes[number].add_entity(entity)
    except RuntimeError as error:
        raise EngineFailure("SC807", f"the renderer cannot make '{item.name}': {error}", origin=item.origin) from error


def sapien_pose(numbers: NDArray[np.float64]) -> Any:
    """Returns a `sapien.Pose` from (7,), p then q."""
    return to_poses(numbers[None])[0]


def check_ray_tracing(camera: Camera) -> None:
    """Raises EngineFailure if a camera needs ray tracing and the device lacks it, since SAPIEN would crash."""
    if camera.shader in RAY_TRACING_SHADERS and not supports_ray_tracing():
        raise EngineFailure(
            "SC807",
            f"'{camera.name}' needs ray tracing, which the render device does not support",
            hint="leave `shader` out, or build where the Vulkan driver has VK_KHR_ray_tracing_pipeline",
            origin=camera.origin and camera.origin.child("shader"),
        )


def build_camera(camera: Camera, lookup: EntityLookup) -> list[Any]:
    """Returns the component of a camera in each built scene that has it.

    Raises:
        EngineFailure: the renderer cannot create it, or the device lacks the ray tracing that it needs.
    """
    check_ray_tracing(camera)
    made: list[Any] = []
    for number, row in rows_by_scene(camera, lookup):
        component = new_camera(camera, row)
        attach_component(component, camera, row, lookup, number)
        set_orthographic_again(component)
        made.append(component)
    return made


def set_orthographic_again(camera: Any) -> None:
    """Sets the lens of an orthographic camera, which SAPIEN resets when the camera enters a scene."""
    if camera is not None and camera.mode == "orthographic":
        sides = (camera.ortho_left, camera.ortho_right, camera.ortho_bottom, camera.ortho_top)
        camera.set_orthographic_parameters(camera.near, camera.far, *sides)


def rows_by_scene(item: Light | Camera, lookup: EntityLookup) -> list[tuple[int, int]]:
    """Returns, for each built scene that has a light or camera, the scene's number and the row in the plan's values."""
    rows = {index: row for row, index in enumerate(item.scene_idxs)}
    return [(number, rows[index]) for number, index in enumerate(lookup.scene_idxs) if index in rows]


def camera_values(camera: Camera, row: int) -> dict[str, float]:
    """Returns a camera's values in one scene by SAPIEN's names, in the order of SAPIEN's lens setter.

    Angles of view are only included if the plan sets them.
    """
    found = {"near": camera.near, "far": camera.far}
    match camera.lens:
        case Perspective(fovx=fovx, fovy=fovy):
            found |= {name: value for name, value in (("fovx", fovx), ("fovy", fovy)) if value is not None}
        case Intrinsic() as lens:
            found |= {name: getattr(lens, name) for name in ("fx", "fy", "cx", "cy", "skew")}
        case Orthographic():
            pass
    numbers = {name: float(value.row(row)) for name, value in found.items()}
    if isinstance(camera.lens, Orthographic):
        top = float(camera.lens.top.row(row))
        # SAPIEN's setter with only `top` uses integer division for the aspect ratio.
        right = top * camera.width / camera.height
        numbers |= {"ortho_left": -right, "ortho_right": right, "ortho_bottom": -top, "ortho_top": top}
    return numbers


def new_camera(camera: Camera, row: int) -> Any:
    """Returns a new `RenderCameraComponent`, in no entity, for one scene of a camera."""
    component = render.RenderCameraComponent(camera.width, camera.height, shader_folder(camera.shader))
    values = camera_values(camera, row)
    match camera.lens:
        case Perspective(fovx=fovx, fovy=fovy):
            # Pixels are square if only one angle is given.
            square = fovx is None or fovy is None
            if fovy is not None:
                component.set_fovy(values["fovy"], square)
            if fovx is not None:
                component.set_fovx(values["fovx"], square)
            component.near, component.far = values["near"], values["far"]
        case Intrinsic():
            component.set_perspective_parameters(*values.values())
        case Orthographic():
            component.set_orthographic_parameters(*values.values())
    return component


def shader_folder(name: str | None) -> str:
    """Returns the folder of a SAPIEN shader pack; "" for the default one."""
    return "" if name is None else str(Path(sapien.__file__).parent / "vulkan_shader" / name)


DEFAULT_CAMERA: Final = "default"

DEFAULT_WIDTH, DEFAULT_HEIGHT = 640, 480


def default_camera(num_scenes: int, width: int, height: int, shader: ShaderName | None = None) -> Camera:
    """Returns the default camera, not yet placed. `width`, `height`: of its pictures [px]."""
    return Camera(
        name=DEFAULT_CAMERA,
        scene_idxs=tuple(range(num_scenes)),
        pose=literal(IDENTITY_POSE),
        width=width,
        height=height,
        lens=Perspective(fovy=literal(FRAMING_FOVY)),
        near=literal(0.01),
        far=literal(100.0),
        shader=shader,
    )
