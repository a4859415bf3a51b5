"""Lights and cameras of a batch, as a user handles them."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.component_batch import ComponentBatch
from scenecc.backends.sapien.engine import render
from scenecc.backends.sapien.seen.pictures import PICTURES, picture
from scenecc.backends.sapien.selected import scene_indices

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from numpy.typing import NDArray

NOT_RENDERED = (
    "the batch was built without rendering, so that {what} is not there; build with render=True on a machine with a "
    "Vulkan driver"
)


class HeldBatch(ComponentBatch):
    """A light or a camera of the plan, in every scene that has it.

    Args:
        name: in the plan.
        scene_idxs: the scenes of the batch that have it, ascending.
        objs: its components in this order; None where the batch does not render.
    """

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


class LightBatch(HeldBatch):
    """One light of the plan; `objs` are `sapien.render.RenderLightComponent`s."""


class CameraBatch(HeldBatch):
    """One camera of the plan; `objs` are `sapien.render.RenderCameraComponent`s.

    Args:
        hidden: the render bodies of a scene that only people see.
        names: what ids of entities in a scene stand for.
        light: called with a scene's index before a picture of it.
        aim: called with a row before a picture.
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
    ) -> dict[str, NDArray[Any]]:
        """Takes pictures of the scenes as they are now.

        Args:
            what: of these, or SAPIEN's own names of pictures ("Normal", "Albedo", …), which are given as SAPIEN has
                them, with a last axis:

                - "color": (B, H, W, 4) float32, red, green, blue and alpha as on a screen, 0 to 1.
                - "depth": (B, H, W, 1) float32 [m] along the camera's axis, 0 where there is nothing.
                - "segmentation": (B, H, W, 1) int32, ids of entities; `names` says whose. 0: nothing.
                - "position": (B, H, W, 3) float32 [m] in the frame of SAPIEN's pictures: x right, y up, z backwards;
                  `objs[i].get_model_matrix()` takes it to the world. 0 where there is nothing.
                - "normal": (B, H, W, 3) float32, where surfaces face, of length 1, in the frame of "position"; 0 where
                  there is nothing. Only if asked for: not every shader pack has it.
            scene_idxs: which of its scenes, in this order; all by default.
            human: show what the plan hides from sensors.

        Returns:
            Name → array; rows are the scenes.

        Raises:
            ValueError: there is no such picture.
            KeyError: the camera is in no such scene of this batch.
            RuntimeError: the batch was built without rendering, it is closed, or what the camera is mounted on is
                taken out of its scene, or it was itself.
        """
        wanted = [what] if isinstance(what, str) else list(what)
        rows = self._rows(scene_idxs)
        found = [self._shot(row, wanted, human=human) for row in rows]
        return {name: np.stack([shot[i] for shot in found]) for i, name in enumerate(wanted)}

    def retire(self, scene_idx: int) -> None:
        """Takes it out of a scene for good, with the memory that its pictures take: some 300 bytes a pixel.

        One of `SceneBatch.framed` comes back with the next picture of the scene, and frames it anew; another takes
        no more pictures of it.

        Raises:
            KeyError: the camera is in no such scene of this batch.
            RuntimeError: the batch was built without rendering, or is closed.
        """
        (row,) = self._rows([scene_idx])
        component = self.objs[row]
        if component is not None:
            component.get_entity().remove_component(component)
            self.objs[row] = None

    def names(self, scene_idx: int) -> dict[int, str]:
        """What the ids of a segmentation stand for in a scene: names of entities, and ENTITY/LINK of links.

        Raises:
            KeyError: the camera is in no such scene of this batch.
            RuntimeError: the batch was built without rendering, or is closed.
        """
        self._rows([scene_idx])
        return self._names(scene_idx)

    def _rows(self, scene_idxs: Sequence[int] | None) -> list[int]:
        have, _ = self._scene_idxs, self.objs
        if scene_idxs is None:
            return list(range(len(have)))
        for index in (chosen := scene_indices(scene_idxs)):
            if index not in have:
                raise KeyError(f"'{self._name}' is in no scene {index} of this batch; it is in {list(have)}")
        return [have.index(index) for index in chosen]

    def _shot(self, row: int, wanted: Sequence[str], *, human: bool) -> list[NDArray[Any]]:
        self._light(self._scene_idxs[row])
        if self._aim is not None:
            self._aim(row)
        camera = self.objs[row]
        if camera is None:
            raise RuntimeError(f"'{self._name}' was taken out of scene {self._scene_idxs[row]}")
        scene = camera.get_entity().get_scene()
        if scene is None:
            raise RuntimeError(f"what '{self._name}' is mounted on is not in scene {self._scene_idxs[row]} now")
        with _out_of_sight([] if human else self._hidden(self._scene_idxs[row]), scene):
            scene.update_render()
            camera.take_picture()
            try:
                return [picture(camera, name) for name in wanted]
            except BaseException:
                # Reading waits for the device: scenes that are cleared while it still draws them end the process.
                with suppress(RuntimeError):
                    camera.get_picture(camera.get_picture_names()[0])
                raise


@contextmanager
def _out_of_sight(bodies: Sequence[Any], scene: Any) -> Generator[None, None, None]:
    """Hides render bodies of a scene for a while."""
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


def render_bodies(entity: Any) -> list[Any]:
    """What is seen of a `sapien.Entity`."""
    return [each for each in entity.components if isinstance(each, render.RenderBodyComponent)]
