"""Cameras, in scripts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.emit.python.columns import number
from scenecc.emit.python.layout import call, string
from scenecc.emit.python.lights import write_held
from scenecc.emit.python.scenes import in_scenes
from scenecc.plan import Intrinsic, Orthographic, Perspective

if TYPE_CHECKING:
    from scenecc.emit.python.columns import Columns
    from scenecc.emit.python.layout import Source
    from scenecc.emit.python.tables import Tables
    from scenecc.plan import Camera, ScenePlan


def write_cameras(source: Source, plan: ScenePlan, tables: Tables) -> None:
    """The cameras, in order. Of a plan without any only a batch makes one, for its pictures."""
    if not plan.cameras:
        return
    source.gap()
    with source.block("if render:"):
        for camera in plan.cameras:
            with in_scenes(source, camera.name, camera.name, camera.scene_idxs, plan.num_scenes, tables.names) as (
                inner,
                columns,
            ):
                _write_camera(inner, camera, columns)
                write_held(inner, camera, "camera", columns, tables)


def _write_camera(source: Source, camera: Camera, columns: Columns) -> None:
    size = (str(camera.width), str(camera.height))
    shader = () if camera.shader is None else (f"sapien.__path__[0] + {string('/vulkan_shader/' + camera.shader)}",)
    source.statement(call("sapien.render.RenderCameraComponent", *size, *shader), assign="camera")
    near, far = columns.value(camera.near, "near"), columns.value(camera.far, "far")
    match camera.lens:
        case Perspective() as lens:
            alone = str(lens.fovx is None or lens.fovy is None)
            if lens.fovy is not None:
                source.statement(call("camera.set_fovy", columns.value(lens.fovy, "fovy"), compute_x=alone))
            if lens.fovx is not None:
                source.statement(call("camera.set_fovx", columns.value(lens.fovx, "fovx"), compute_y=alone))
            source.statement(near, assign="camera.near")
            source.statement(far, assign="camera.far")
        case Intrinsic() as lens:
            names = ("fx", "fy", "cx", "cy", "skew")
            matrix = [columns.value(getattr(lens, name), name) for name in names]
            source.statement(call("camera.set_perspective_parameters", near, far, *matrix))
        case Orthographic() as lens:
            # Not with `top` alone, where SAPIEN divides width by height in whole numbers.
            top = columns.value(lens.top, "top")
            source.statement(top, assign="top")
            source.line(f"right = top * {number(camera.width)} / {number(camera.height)}")
            source.statement(call("camera.set_orthographic_parameters", near, far, "-right", "right", "-top", "top"))
