"""Cameras of the plan as ManiSkill's sensors, and what these are not to see."""

from __future__ import annotations

from math import atan, tan
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.maniskill.compat import SHADERS, UNSUPPORTED_CODE, CameraConfig, Pose, torch
from scenecc.backends.sapien.engine import EngineFailure
from scenecc.plan import ArticulationStructure, BodyStructure, Intrinsic, Perspective

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

    from scenecc.plan import Camera, Entity, Orthographic, ScenePlan, Value

_DEFAULT_SHADER = "minimal"
"""ManiSkill's shader for sensors that name none."""


def camera_configs(plan: ScenePlan, actors: Mapping[str, Any], articulations: Mapping[str, Any]) -> list[Any]:
    """ManiSkill's configuration of each camera, by the names in the plan.

    Args:
        plan: where nothing renders, those of its cameras that `unsupported_cameras` finds wrong are left out.
        actors: by entity.
        articulations: by entity.
    """
    return [
        _camera_config(camera, actors, articulations)
        for camera in plan.cameras
        if _unsupported_camera(camera, plan) is None
    ]


def unsupported_cameras(plan: ScenePlan) -> Iterator[EngineFailure]:
    """What ManiSkill cannot see with, or cannot hide."""
    for camera in plan.cameras:
        found = _unsupported_camera(camera, plan)
        if found is not None:
            message, hint = found
            yield EngineFailure(
                UNSUPPORTED_CODE, f"the camera '{camera.name}' {message}", origin=camera.origin, hint=hint
            )
    for entity in plan.entities:
        if entity.hidden and not _can_hide(entity):
            message = f"'{entity.name}' is hidden, and ManiSkill hides what nothing collides with and can be moved"
            hint = "`body_type: kinematic`, with `visuals` alone"
            yield EngineFailure(UNSUPPORTED_CODE, message, origin=entity.origin, hint=hint)


def hidden_objects(plan: ScenePlan, scene: Any) -> list[Any]:
    """The actors that sensors do not see: not the views of them, of which ManiSkill hides none.

    Where nothing renders, those that `unsupported_cameras` finds wrong are left out.
    """
    return [scene.actors[entity.name] for entity in plan.entities if entity.hidden and _can_hide(entity)]


def _unsupported_camera(camera: Camera, plan: ScenePlan) -> tuple[str, str] | None:
    """What is wrong with a camera, and what to do."""
    if len(camera.scene_idxs) < plan.num_scenes:
        return "is in some environments only", "ManiSkill's sensors are in all: leave `scene_idxs` out"
    if camera.pose.recipe is not None:
        return "stands relative to what a reset draws anew", "mount it on that, and it moves along"
    mount = camera.mount and next(entity for entity in plan.entities if entity.name == camera.mount.entity)
    if mount is not None and _has_several_links(mount):
        told = f"is mounted on '{mount.name}', whose links differ from environment to environment"
        return told, "ManiSkill's view of such robots has no links: leave `mount` out"
    return _unsupported_lens(camera)


def _unsupported_lens(camera: Camera) -> tuple[str, str] | None:
    """Likewise, wherever it is."""
    if not isinstance(camera.lens, Perspective | Intrinsic):
        return "has no perspective", "ManiSkill's sensors have: give it a `fovy`"
    if isinstance(camera.lens, Intrinsic) and camera.lens.skew.data.any():
        return "has a skew", "ManiSkill's sensors have none"
    if camera.shader is not None and camera.shader not in SHADERS:
        return f"wants the shader '{camera.shader}'", f"ManiSkill has {', '.join(SHADERS)}"
    return None


def _has_several_links(entity: Entity) -> bool:
    """Whether it is one of several robots, whose links have not the same names."""
    links = [[link.name for link in one.links] for one in entity.structures if isinstance(one, ArticulationStructure)]
    return any(names != links[0] for names in links)


def _can_hide(entity: Entity) -> bool:
    return all(
        isinstance(structure, BodyStructure)
        and structure.body_type in ("dynamic", "kinematic")
        and not structure.collisions
        for structure in entity.structures
    )


def _camera_config(camera: Camera, actors: Mapping[str, Any], articulations: Mapping[str, Any]) -> Any:
    mount: Any = None
    if camera.mount is not None and camera.mount.entity in actors:
        mount = actors[camera.mount.entity]
    elif camera.mount is not None:
        articulation = articulations[camera.mount.entity]
        mount = articulation.root if camera.mount.link is None else articulation.links_map[camera.mount.link]
    pose = np.ascontiguousarray(camera.pose.data.astype(np.float32))
    return CameraConfig(
        uid=camera.name,
        pose=Pose.create(torch.from_numpy(pose)),
        width=camera.width,
        height=camera.height,
        near=_one_or_all(camera.near),
        far=_one_or_all(camera.far),
        mount=mount,
        shader_pack=camera.shader or _DEFAULT_SHADER,
        **_lens_arguments(camera),
    )


def _one_or_all(value: Value) -> float | list[float]:
    found: list[float] = value.data.astype(np.float64).tolist()
    return found if value.varies else found[0]


def _lens_arguments(camera: Camera) -> dict[str, Any]:
    lens: Perspective | Intrinsic | Orthographic = camera.lens
    if isinstance(lens, Perspective):
        if lens.fovx is None:
            assert lens.fovy is not None
            return {"fov": _one_or_all(lens.fovy)}
        if lens.fovy is None:
            # The lens of a camera whose pixels are square.
            upright = [2 * atan(tan(fovx / 2) * camera.height / camera.width) for fovx in lens.fovx.data.tolist()]
            return {"fov": upright if lens.fovx.varies else upright[0]}
        fx, fy = (
            side / 2 / np.tan(fov.data / 2) for side, fov in ((camera.width, lens.fovx), (camera.height, lens.fovy))
        )
        return {"intrinsic": _intrinsic_matrix(fx, fy, np.array([camera.width / 2]), np.array([camera.height / 2]))}
    assert isinstance(lens, Intrinsic)
    return {"intrinsic": _intrinsic_matrix(lens.fx.data, lens.fy.data, lens.cx.data, lens.cy.data)}


def _intrinsic_matrix(*numbers: NDArray[np.float64]) -> NDArray[np.float32]:
    """(B, 3, 3), or (3, 3) where all cameras have the same."""
    fx, fy, cx, cy = np.broadcast_arrays(*numbers)
    found = np.zeros((len(fx), 3, 3), np.float32)
    found[:, 0, 0], found[:, 1, 1], found[:, 0, 2], found[:, 1, 2], found[:, 2, 2] = fx, fy, cx, cy, 1
    return found if len(found) > 1 else found[0]
