"""What pictures need, built into scenes whose bodies stand: surroundings, lights, cameras."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.resources import Resources
from scenecc.backends.sapien.seen.batches import NOT_RENDERED, CameraBatch, HeldBatch, LightBatch, render_bodies
from scenecc.backends.sapien.seen.cameras import build_camera, new_camera
from scenecc.backends.sapien.seen.collision import CollisionShown
from scenecc.backends.sapien.seen.framing import HEIGHT, NAME, WIDTH, default_camera, framing
from scenecc.backends.sapien.seen.hold import hold, pose_of
from scenecc.backends.sapien.seen.lights import build_environment, build_light, has_light
from scenecc.plan import literal
from scenecc.plan.rendering import DEFAULT_AMBIENT_LIGHT, DEFAULT_LIGHT_DIRECTIONS, is_unlit
from scenecc.plan.schema import PIXEL_BOUNDS
from scenecc.variation.errors import DrawError
from scenecc.variation.per_scene_arrays import to_field_rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien.standing import Standing
    from scenecc.plan import Camera, Light, ScenePlan
    from scenecc.variation.evaluation import Batch

Moves = list[tuple[Any, Any]]
"""Entities of lights and cameras, and where they go."""


class Dress:
    """Lights and cameras of a batch.

    Attributes:
        lights, cameras: by name, in the order of the plan.
    """

    def __init__(self, plan: ScenePlan, standing: Standing, *, rendered: bool) -> None:
        """Builds them, where the batch renders.

        Raises:
            EngineFailure: the renderer cannot make one.
        """
        self._plan = plan
        self._standing: Standing | None = standing
        self._rendered = rendered
        self._seen_by_people = [entity.name for entity in plan.entities if entity.hidden]
        built: dict[str, list[Any]] = {}
        if rendered:
            resources = Resources(plan)
            if plan.environment is not None:
                build_environment(plan.environment, standing, resources)
            built = {light.name: build_light(light, standing, resources) for light in plan.lights}
        self.lights = {light.name: self._light(light, built.get(light.name)) for light in plan.lights}
        self._dark = set(standing.scene_idxs) if is_unlit(plan) else set[int]()
        self.cameras = {
            camera.name: self._camera(camera, build_camera(camera, standing) if rendered else None)
            for camera in plan.cameras
        }
        self._framed: list[CameraBatch] = []
        if not plan.cameras:
            self.cameras[NAME] = self.framed()

    def _present(self, held: Light | Camera) -> tuple[int, ...]:
        assert self._standing is not None
        having = frozenset(held.scene_idxs)
        return tuple(index for index in self._standing.scene_idxs if index in having)

    def _light(self, light: Light, objs: list[Any] | None) -> LightBatch:
        return LightBatch(light.name, self._present(light), objs)

    def _light_up(self, index: int) -> None:
        """Lights a scene for its first picture if nothing else does: without, every picture would be black.

        Not before, so that what is built is what the file says and nothing more.
        """
        if index not in self._dark or self._standing is None:
            return
        self._dark.remove(index)
        scene = self._standing.scenes[self._standing.scene_idxs.index(index)]
        if has_light(scene):
            return
        scene.set_ambient_light(DEFAULT_AMBIENT_LIGHT)
        for direction in DEFAULT_LIGHT_DIRECTIONS:
            scene.add_directional_light(direction, [1, 1, 1])

    def _camera(self, camera: Camera, objs: list[Any] | None) -> CameraBatch:
        return CameraBatch(camera.name, self._present(camera), objs, self._hidden, self._names, self._light_up)

    def framed(self, width: int = WIDTH, height: int = HEIGHT) -> CameraBatch:
        """A camera that frames each scene as it stands when the first picture of it is taken.

        It comes into a scene with this picture: it takes memory.

        Raises:
            ValueError: no renderer makes pictures of this size [px].
        """
        for size in (width, height):
            if not PIXEL_BOUNDS.allow(size):
                raise ValueError(f"a picture has {PIXEL_BOUNDS.low} to {PIXEL_BOUNDS.high} pixels a side, not {size}")
        camera = default_camera(self._plan.num_scenes, width, height)
        present = self._present(camera)
        found = CameraBatch(
            camera.name,
            present,
            [None] * len(present) if self._rendered else None,
            self._hidden,
            self._names,
            self._light_up,
            lambda number: self._frame(camera, found, number),
        )
        self._framed.append(found)
        return found

    def _frame(self, camera: Camera, batch: CameraBatch, number: int) -> None:
        assert self._standing is not None
        if batch.objs[number] is not None:
            return
        scene = self._standing.scenes[number]
        scene.update_render()
        pose, near, far = framing(scene, camera.width, camera.height)
        camera = replace(camera, pose=literal(tuple(pose.tolist())), near=literal(near), far=literal(far))
        component = new_camera(camera, 0)
        hold(component, camera, 0, self._standing, number)
        batch.objs[number] = component

    def show_collision(self) -> None:
        """Draws bodies as they collide in place of how they look, from now on.

        Raises:
            RuntimeError: the batch was built without rendering.
        """
        assert self._standing is not None
        if not self._rendered:
            raise RuntimeError(NOT_RENDERED.format(what="what is seen"))
        shown = CollisionShown()
        for index in self._standing.scene_idxs:
            for _, entity in self._standing.entities(index):
                shown.show(entity)

    def _hidden(self, index: int) -> list[Any]:
        if not self._seen_by_people or self._standing is None:
            return []
        hidden = {*self._seen_by_people}
        return [
            body
            for name, entity in self._standing.entities(index)
            if name in hidden or name.rpartition("/")[0] in hidden
            for body in render_bodies(entity)
        ]

    def _names(self, index: int) -> dict[int, str]:
        assert self._standing is not None
        return {
            entity.get_per_scene_id(): name
            for name, entity in self._standing.entities(index)
            if entity.get_scene() is not None
        }

    @property
    def follows(self) -> bool:
        """Whether a light or camera stands relative to what a reset draws anew."""
        held = (*self._plan.lights, *self._plan.cameras)
        return self._rendered and any(each.pose.recipe is not None for each in held)

    def moves(self, batch: Batch) -> Moves:
        """Where lights and cameras go that stand relative to what a reset draws anew; nothing is moved yet.

        Args:
            batch: the scenes that are reset.

        Raises:
            ValueError: one would stand nowhere.
        """
        held: list[tuple[Light | Camera, HeldBatch]] = []
        held += [(light, self.lights[light.name]) for light in self._plan.lights]
        held += [(camera, self.cameras[camera.name]) for camera in self._plan.cameras]
        return [move for each, found in held for move in moves_of(each, found, batch)]

    def close(self) -> None:
        """Lets go of everything."""
        for each in (*self.lights.values(), *self.cameras.values(), *self._framed):
            each._close()  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
        self.lights, self.cameras, self._framed, self._standing = {}, {}, [], None


def moves_of(held: Light | Camera, found: HeldBatch, batch: Batch) -> Moves:
    """Where a light or camera goes in those of the scenes that have it. Raises ValueError if it would stand nowhere."""
    recipe = held.pose.recipe
    row_of = {index: row for row, index in enumerate(found.scene_idxs)}
    having = [number for number, index in enumerate(batch.scenes.tolist()) if index in row_of]
    if recipe is None or not having:
        return []
    part = batch if len(having) == len(batch.scenes) else batch.only(np.array(having, dtype=np.intp))
    try:
        poses: NDArray[np.float64] = to_field_rows(part.evaluate(recipe))
    except DrawError as error:
        message = f"'{held.name}' in scene {error.scene}: its pose has no value: {error.message}"
        raise ValueError(message) from None
    rows: list[int] = [row_of[index] for index in part.scenes.tolist()]
    return [(found.objs[row].get_entity(), pose_of(pose)) for row, pose in zip(rows, poses, strict=True)]
