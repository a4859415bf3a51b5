"""Pictures and films: what they hold, and how a recorder takes them of live scenes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.diagnostics import Diagnostic
from scenecc.render.images import What, colors, encoded, png, png_of_ids, sheet, shown
from scenecc.render.images import film as filmed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import ScenePlan
    from scenecc.render.images import Film
    from scenecc.render.render import RenderSetup


@dataclass(frozen=True, slots=True)
class Picture:
    """What a camera sees of a scene.

    Attributes:
        scene_idx: the scene's index.
        pixels: (H, W, C) as `CameraBatch.capture` gives what was asked for: of a colour (H, W, 4) float32, of a depth
            (H, W, 1) float32 [m], of a segmentation (H, W, 1) int32, of normals (H, W, 3) float32.
        names: what the ids of a segmentation stand for in this scene.
    """

    scene_idx: int
    pixels: NDArray[Any]
    names: dict[int, str]


@dataclass(frozen=True, slots=True)
class LegendRow:
    """An id that is seen in a segmentation.

    Attributes:
        scene_idxs: the scenes in which it has this name and is seen, ascending.
        id: of the entity.
        color: of its pixels, as #rrggbb.
        name: of the entity, ENTITY/LINK of a link.
    """

    scene_idxs: tuple[int, ...]
    id: int
    color: str
    name: str


@dataclass(frozen=True, slots=True)
class Rendering:
    """Pictures of a scene, and how they were taken.

    Attributes:
        plan: the scene's plan.
        camera: the camera's name; None: one that frames the scene.
        what: what the pictures show.
        grid: whether they are written as one sheet.
        pictures: one a scene, by ascending index, as it is after the simulation.
        film: the bytes of the film's file; None: none was taken.
        frames, rate: how many pictures the film shows, and how many a second [1/s]; 0 without one. Equal pictures in a
            row are one frame of a GIF's file, which lasts as long as all of them.
        diagnostics: warnings and notes.
        timings: stage → seconds, in order.
    """

    plan: ScenePlan
    camera: str | None
    what: What
    grid: bool
    pictures: tuple[Picture, ...]
    film: bytes | None = None
    frames: int = 0
    rate: float = 0.0
    diagnostics: list[Diagnostic] = field(default_factory=list[Diagnostic])
    timings: dict[str, float] = field(default_factory=dict[str, float])

    def png(self) -> bytes:
        """The pictures as one PNG: the picture itself, or a sheet with a label above each.

        Colours and normals have three bytes a pixel, a depth 16 bits [mm], a segmentation the ids as a palette's
        indices, and colours on a sheet or where an id is beyond 255.
        """
        if self.grid:
            return png(labelled([encoded(self.what, picture.pixels) for picture in self.pictures], self.pictures))
        (picture,) = self.pictures
        if self.what == "segmentation":
            return png_of_ids(picture.pixels[..., 0])
        return png(encoded(self.what, picture.pixels))

    def legend(self) -> list[LegendRow]:
        """The ids that are seen in a segmentation, ascending; empty for other pictures."""
        scenes: dict[tuple[int, str], list[int]] = {}
        for picture in self.pictures if self.what == "segmentation" else ():
            for number in np.unique(picture.pixels).tolist():
                if number:
                    scenes.setdefault((number, picture.names.get(number, "")), []).append(picture.scene_idx)
        return [
            LegendRow(tuple(idxs), number, f"#{colors(np.array(number)).tobytes().hex()}", name)
            for (number, name), idxs in sorted(scenes.items())
        ]


def labelled(tiles: Sequence[NDArray[Any]], pictures: Sequence[Picture]) -> NDArray[Any]:
    """A sheet of pictures, (H, W) or (H, W, 3) each, with the scene of each above it."""
    return sheet(tiles, [f"scene {picture.scene_idx}" for picture in pictures])


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
