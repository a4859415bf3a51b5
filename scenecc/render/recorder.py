"""Scenes before a camera: simulated, and pictures taken of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.render.images import film as filmed
from scenecc.render.images import shown
from scenecc.render.results import Picture, labelled

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    import numpy as np
    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.render.images import Film, What
    from scenecc.render.render import RenderSetup

_FRAMES_A_SECOND = 30
"""About as many has a film of which nothing is said."""

_STRIDE = 10
"""Steps between two reports of the progress."""


class FrameRecorder:
    """Simulates scenes and takes their pictures. `human`: show what is hidden too."""

    def __init__(
        self,
        batch: SceneBatch,
        setup: RenderSetup,
        what: What,
        progress: Callable[[int, int], None] | None,
        *,
        human: bool,
    ) -> None:
        self._batch = batch
        named = setup.camera
        self._camera = batch.framed(setup.width, setup.height) if named is None else batch.cameras[named.name]
        self._what: What = what
        self._grid = setup.grid
        self._human = human
        self._progress = progress or _untold

    def take(
        self, steps: int, film: Film | None, every: int | None
    ) -> tuple[tuple[Picture, ...], tuple[bytes | None, int, float]]:
        """A picture of each scene after the steps, and the film: its bytes, its number of frames and its rate [1/s].

        Raises:
            SceneError: the simulation diverges.
            RuntimeError: the renderer fails.
            OSError: the film's encoder does.
        """
        if film is None:
            self._step(steps)
            return self._stills(), (None, 0, 0.0)
        stride = every or min(steps, max(1, round(1 / (_FRAMES_A_SECOND * self._batch.timestep))))
        count, rate = 1 + steps // stride, 1 / (stride * self._batch.timestep)
        data = filmed(film, self._frames(count, stride), rate, count)
        self._batch.step(steps % stride, check=True)
        return self._stills(), (data, count, rate)

    def _step(self, steps: int) -> None:
        for done in range(0, steps, _STRIDE):
            self._progress(done, steps)
            self._batch.step(min(_STRIDE, steps - done), check=True)

    def _frames(self, count: int, stride: int) -> Iterator[NDArray[np.uint8]]:
        for number in range(count):
            self._progress(number, count)
            self._batch.step(stride if number else 0, check=True)
            pictures = [self._picture(index) for index in self._batch.scene_idxs]
            tiles = [shown(self._what, picture.pixels) for picture in pictures]
            yield labelled(tiles, pictures) if self._grid else tiles[0]

    def _stills(self) -> tuple[Picture, ...]:
        """The last pictures that are taken: the memory of one camera is enough for all of them."""
        pictures: list[Picture] = []
        for index in self._batch.scene_idxs:
            self._progress(len(pictures), len(self._batch))
            pictures.append(self._picture(index))
            self._camera.retire(index)
        return tuple(pictures)

    def _picture(self, index: int) -> Picture:
        name = self._what
        pixels = self._camera.capture(name, [index], human=self._human)[name][0]
        return Picture(index, pixels, self._camera.names(index) if name == "segmentation" else {})


def _untold(done: int, of: int) -> None:
    """Progress that nobody is told."""
