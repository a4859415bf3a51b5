"""What was taken: pictures of scenes, and the files of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.diagnostics import Diagnostic
from scenecc.render.images import What, colors, encoded, png, png_of_ids, sheet

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.plan import ScenePlan


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
