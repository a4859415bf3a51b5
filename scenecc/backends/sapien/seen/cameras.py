"""Cameras of the plan in live scenes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.engine import render, sapien
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.backends.sapien.machine import traces_rays
from scenecc.backends.sapien.seen.hold import hold
from scenecc.plan import Intrinsic, Orthographic, Perspective
from scenecc.plan.camera import RAY_TRACING_SHADERS

if TYPE_CHECKING:
    from scenecc.backends.sapien.standing import Standing
    from scenecc.plan import Camera


def build_camera(camera: Camera, standing: Standing) -> list[Any]:
    """The component of a camera in each scene that has it, among those that are built.

    Raises:
        EngineFailure: the renderer cannot make it, or the device cannot trace the rays that it asks for.
    """
    if camera.shader in RAY_TRACING_SHADERS and not traces_rays():
        raise EngineFailure(
            "SC807",
            f"'{camera.name}' traces rays, and the render device cannot",
            hint="leave `shader` out, or build where the Vulkan driver has VK_KHR_ray_tracing_pipeline",
            origin=camera.origin and camera.origin.child("shader"),
        )
    rows = {index: row for row, index in enumerate(camera.scene_idxs)}
    made: list[Any] = []
    for number, index in enumerate(standing.scene_idxs):
        if (row := rows.get(index)) is not None:
            component = new_camera(camera, row)
            hold(component, camera, row, standing, number)
            made.append(component)
    return made


def new_camera(camera: Camera, row: int) -> Any:
    """A `RenderCameraComponent` in no entity, as a camera is in one of its scenes."""
    component = render.RenderCameraComponent(camera.width, camera.height, shader_folder(camera.shader))
    near, far = float(camera.near.row(row)), float(camera.far.row(row))
    match camera.lens:
        case Perspective() as lens:
            _open(component, lens, row)
            component.near, component.far = near, far
        case Intrinsic() as lens:
            numbers = [float(value.row(row)) for value in (lens.fx, lens.fy, lens.cx, lens.cy, lens.skew)]
            component.set_perspective_parameters(near, far, *numbers)
        case Orthographic() as lens:
            top = float(lens.top.row(row))
            # SAPIEN's own form with `top` alone divides width by height in whole numbers.
            right = top * camera.width / camera.height
            component.set_orthographic_parameters(near, far, -right, right, -top, top)
    return component


def _open(component: Any, lens: Perspective, row: int) -> None:
    alone = lens.fovx is None or lens.fovy is None
    if lens.fovy is not None:
        component.set_fovy(float(lens.fovy.row(row)), alone)
    if lens.fovx is not None:
        component.set_fovx(float(lens.fovx.row(row)), alone)


def shader_folder(name: str | None) -> str:
    """Where a shader pack of SAPIEN's is; "" for the default one."""
    return "" if name is None else str(Path(sapien.__file__).parent / "vulkan_shader" / name)
