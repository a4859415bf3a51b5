"""Simulates scenes and takes their pictures, with multisampling, background, ground grid and overlays."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.plan.framing import cell_size
from scenecc.render.ground import draw_ground
from scenecc.render.images import VideoFormat, What, encode_video, sheet, video_pixels
from scenecc.render.overlays import Overlay
from scenecc.render.projection import Projection

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan.framing import Subject
    from scenecc.render.choices import RenderSetup


@dataclass(frozen=True, slots=True)
class Picture:
    """A camera's picture of a scene.

    Attributes:
        scene_idx: the scene's index.
        pixels: (H, W, C) as from `CameraBatch.capture`: colour (H, W, 4) float32, depth (H, W, 1) float32 [m],
            segmentation (H, W, 1) int32, normals (H, W, 3) float32. A colour includes background and overlays; alpha is
            0 where there is nothing.
        names: id → name for a segmentation of this scene.
    """

    scene_idx: int
    pixels: NDArray[Any]
    names: dict[int, str]


def label_sheet(tiles: Sequence[NDArray[Any]], pictures: Sequence[Picture]) -> NDArray[Any]:
    """Joins pictures, (H, W) or (H, W, 3) each, on a sheet, with the scene of each above it."""
    return sheet(tiles, [f"scene {picture.scene_idx}" for picture in pictures])


_FRAMES_A_SECOND: Final = 30
"""Approximate default frame rate of a video [1/s]."""

_STRIDE: Final = 10
"""Steps between two progress reports."""

_GAMMA: Final = 2.2
"""SAPIEN's gamma, from linear light to display values."""

_TILE_SIDE: Final = 64
"""Longer side of the small picture for timing ray tracing [px]."""

_AXES, _FORCES = 0.18, 0.5
"""Lengths of axes and of the strongest force, in radii of the subject."""


def sample_shifts(count: int) -> list[tuple[float, float]]:
    """Returns the offsets of `count` samples from a pixel's centre [px]: the first of an evenly spread sequence.

    The sequence is that of the two-dimensional golden ratio: no two are in one row or column.
    """
    if count == 1:
        return [(0.0, 0.0)]
    ratio = 1.32471795724474602596
    shifts = [((0.5 + n / ratio) % 1 - 0.5, (0.5 + n / ratio**2) % 1 - 0.5) for n in range(count)]
    right, down = (sum(each) / count for each in zip(*shifts, strict=True))
    return [(x - right, y - down) for x, y in shifts]


class FrameRecorder:
    """Simulates scenes and takes their pictures. `human`: also show hidden entities.

    Raises RuntimeError if the device does not support ray tracing and the pictures need it.
    """

    def __init__(
        self, batch: SceneBatch, setup: RenderSetup, progress: Callable[[int, int], None] | None, *, human: bool
    ) -> None:
        self._batch = batch
        self._setup = setup
        self._choices = setup.choices
        self._camera = self._framing_camera(setup.width, setup.height)
        if setup.camera is not None:
            self._camera = batch.cameras[setup.camera.name]
        self._what: What = setup.what
        self._human = human
        self._progress = progress or _ignore
        self._subjects: dict[int, Subject] = {}

    def _framing_camera(self, width: int, height: int) -> Any:
        choices = self._choices
        return self._batch.framed(
            width,
            height,
            focus=choices.get("focus"),
            eye=choices.get("eye"),
            look_at=choices.get("look_at"),
            view=choices.get("view"),
            zoom=choices.get("zoom") or 1.0,
            shader=choices.get("shader"),
        )

    @property
    def cell(self) -> float | None:
        """The side of a cell of the ground grid [m], the same in all scenes. None without a grid."""
        return cell_size(self._subject(self._batch.scene_idxs[0])) if self._choices.get("ground") else None

    def estimate(self, pictures: int) -> float:
        """Returns the expected time for ray tracing a number of pictures [s], from a small one of the first scene."""
        setup, index = self._setup, self._batch.scene_idxs[0]
        factor = min(1.0, _TILE_SIDE / max(setup.width, setup.height))
        width, height = (max(1, round(factor * side)) for side in (setup.width, setup.height))
        tile = self._framing_camera(width, height)
        tile.capture("color", [index])  # the first picture compiles shaders
        started = time.perf_counter()
        tile.capture("color", [index], shift=(0.25, 0.25))  # SAPIEN renders again only after a change
        seconds = time.perf_counter() - started
        tile.retire(index)
        return seconds * pictures * setup.width * setup.height / (width * height)

    def take(
        self, steps: int, video: VideoFormat | None, every: int | None
    ) -> tuple[tuple[Picture, ...], tuple[bytes | None, int, float]]:
        """Returns a picture of each scene after the steps, and the video: its bytes, number of frames and frame rate
        [1/s].

        Raises:
            SceneError: the simulation diverges.
            RuntimeError: the renderer fails.
            OSError: the video's encoder fails.
        """
        if video is None:
            self._step(steps)
            return self._stills(), (None, 0, 0.0)
        stride = self.stride(steps, every)
        count, rate = 1 + steps // stride, 1 / (stride * self._batch.timestep)
        data = encode_video(video, self._frames(count, stride), rate, count)
        self._batch.step(steps % stride, check=True)
        return self._stills(), (data, count, rate)

    def stride(self, steps: int, every: int | None) -> int:
        """Returns the steps between two frames of a video."""
        return every or min(steps, max(1, round(1 / (_FRAMES_A_SECOND * self._batch.timestep))))

    def _step(self, steps: int) -> None:
        for done in range(0, steps, _STRIDE):
            self._progress(done, steps)
            self._batch.step(min(_STRIDE, steps - done), check=True)

    def _frames(self, count: int, stride: int) -> Iterator[NDArray[np.uint8]]:
        for number in range(count):
            self._progress(number, count)
            self._batch.step(stride if number else 0, check=True)
            pictures = [self._picture(index) for index in self._batch.scene_idxs]
            tiles = [video_pixels(self._what, picture.pixels) for picture in pictures]
            yield label_sheet(tiles, pictures) if self._setup.grid else tiles[0]

    def _stills(self) -> tuple[Picture, ...]:
        """Takes the last pictures, scene by scene, so that the memory of one camera is enough."""
        pictures: list[Picture] = []
        for index in self._batch.scene_idxs:
            self._progress(len(pictures), len(self._batch))
            pictures.append(self._picture(index))
            self._camera.retire(index)
        return tuple(pictures)

    def _picture(self, index: int) -> Picture:
        name = self._what
        if name == "color":
            return Picture(index, self._overlay(index, self._color(index)), {})
        pixels = self._camera.capture(name, [index], human=self._human)[name][0]
        return Picture(index, pixels, self._camera.names(index) if name == "segmentation" else {})

    def _color(self, index: int) -> NDArray[np.float32]:
        """Returns the mean of all samples (H, W, 4) in linear light, without the background."""
        setup = self._setup
        shifts = sample_shifts(1 if setup.traced else setup.samples)
        ground = self._choices.get("ground", False)
        if len(shifts) == 1 and setup.background is None and not ground:
            return self._camera.capture("color", [index], human=self._human)["color"][0]
        total = np.zeros((setup.height, setup.width, 4))
        for shift in shifts:
            shot = self._camera.capture(("color", "depth"), [index], human=self._human, shift=shift)
            color = np.asarray(shot["color"][0], np.float64)
            linear, alpha = np.maximum(color[..., :3], 0) ** _GAMMA, color[..., 3:]
            if setup.background is not None:
                beyond = (np.array(setup.background) / 255) ** _GAMMA
                linear = np.where(alpha == 0, beyond, linear)
            if ground:
                linear = self._draw_ground_grid(index, linear, shot["depth"][0], shift)
            total += np.concatenate([linear, alpha], axis=-1) / len(shifts)
        return np.concatenate([total[..., :3] ** (1 / _GAMMA), total[..., 3:]], axis=-1).astype(np.float32)

    def _draw_ground_grid(
        self, index: int, linear: NDArray[np.float64], depth: NDArray[np.float32], shift: tuple[float, float]
    ) -> NDArray[np.float64]:
        cell = self.cell
        assert cell is not None
        return draw_ground(linear, depth, self._projection(index), self._subject(index).ground, cell, shift)

    def _overlay(self, index: int, pixels: NDArray[np.float32]) -> NDArray[np.float32]:
        choices, overlay = self._choices, Overlay(self._setup.width, self._setup.height)
        if (cell := self.cell) is not None:
            overlay.captions.append(f"1 cell = {cell:.10g} m")
        if choices.get("frames"):
            poses = self._batch.body_poses(index).values()
            overlay.add_axes(self._projection(index), poses, _AXES * self._subject(index).radius)
        if choices.get("contacts"):
            found = self._batch.contacts(scene_idxs={index})
            # On `b`, which was built later: a table supports what is on it.
            forces = -found.impulse.astype(np.float64) / self._batch.timestep
            longest = _FORCES * self._subject(index).radius
            overlay.add_contacts(self._projection(index), found.point.astype(np.float64), forces, longest)
        if choices.get("labels"):
            ids = self._camera.capture("segmentation", [index], human=self._human)["segmentation"][0, ..., 0]
            links = self._batch.articulations
            names = {number: _entity(name, links) for number, name in self._camera.names(index).items()}
            overlay.add_labels(ids, names)
        return overlay.draw(pixels)

    def _projection(self, index: int) -> Projection:
        camera = self._camera
        return Projection.of(camera.objs[camera.scene_idxs.index(index)])

    def _subject(self, index: int) -> Subject:
        """Returns the subject of a scene at its first picture."""
        if index not in self._subjects:
            self._subjects[index] = self._batch.subject(index, self._choices.get("focus"))
        return self._subjects[index]


def _entity(name: str, articulations: Any) -> str:
    """Returns the entity of a body, or the articulation of a link."""
    owner = name.rpartition("/")[0]
    return owner if owner in articulations else name


def _ignore(done: int, of: int) -> None:
    """Ignores progress."""
