"""Overlays of colour pictures: names, axes, contacts and a caption. Pillow is loaded when needed."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, pi, sin
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.formats.style import visible

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.render.projection import Projection

_SCALE: Final = 3
"""An overlay is drawn this many times larger and scaled down, for smooth lines."""

_AXES: Final = ((214, 39, 40), (44, 140, 44), (31, 90, 200))
_CONTACT, _FORCE = (255, 140, 0), (190, 0, 140)
_PAPER, _INK = (20, 22, 26, 205), (255, 255, 255)
_LEADER: Final = (20, 22, 26)
_LONGEST_NAME: Final = 40
_LEAST_SEEN: Final = 6
"""Smallest number of visible pixels of a body with a label."""


@dataclass(slots=True)
class Overlay:
    """Shapes to draw over a picture of this size [px]. Positions are to the right and down from its corner [px]."""

    width: int
    height: int
    lines: list[tuple[Sequence[float], Sequence[float], tuple[int, ...], float]] = field(default_factory=list[Any])
    dots: list[tuple[Sequence[float], tuple[int, ...], float]] = field(default_factory=list[Any])
    texts: list[tuple[tuple[float, float, float, float], str]] = field(default_factory=list[Any])
    captions: list[str] = field(default_factory=list[str])

    @property
    def letters(self) -> int:
        """Height of letters [px]."""
        return max(9, round(self.height / 40))

    @property
    def thick(self) -> float:
        """Width of lines [px]."""
        return max(1.5, self.height / 240)

    def add_axes(self, projection: Projection, poses: Iterable[NDArray[np.float64]], length: float) -> None:
        """Adds the axes of frames (7,) each, with this length [m]."""
        from scenecc.geometry.rotation_arrays import rotation_matrix

        for pose in poses:
            ends = pose[:3] + length * rotation_matrix(pose[3:]).T
            pixels, _ = projection.project(np.concatenate([pose[None, :3], ends]))
            for end, color in zip(pixels[1:], _AXES, strict=True):
                self.add_line(pixels[0], end, color, self.thick)

    def add_contacts(
        self, projection: Projection, points: NDArray[np.float64], forces: NDArray[np.float64], longest: float
    ) -> None:
        """Adds dots at points (N, 3) [m], and arrows for forces (N, 3) [N], the strongest with length `longest` [m]."""
        strengths = np.linalg.norm(forces, axis=1)
        most = float(strengths.max(initial=0))
        starts, _ = projection.project(points)
        ends, _ = projection.project(points + (forces / most * longest if most else 0))
        for start, end, strength in zip(starts, ends, strengths, strict=True):
            if strength > 0.01 * most:
                self._add_arrow(start, end)
            if np.isfinite(start).all():
                self.dots.append((start.tolist(), _CONTACT, 1.4 * self.thick))
        count = f"{len(points)} contact{'' if len(points) == 1 else 's'}"
        self.captions.append(f"{count}, strongest {most:.3g} N" if most else count)

    def _add_arrow(self, start: NDArray[np.float64], end: NDArray[np.float64]) -> None:
        self.add_line(start, end, _FORCE, self.thick)
        way = end - start
        length = float(np.hypot(*way)) if np.isfinite(way).all() else 0.0
        head = min(5 * self.thick, length / 2)
        for turn in (0.85 * pi, -0.85 * pi) if length else ():
            x, y = way / length
            side = np.array([x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn)])
            self.add_line(end, end + head * side, _FORCE, self.thick)

    def add_line(
        self, start: NDArray[np.float64], end: NDArray[np.float64], color: tuple[int, ...], width: float
    ) -> None:
        """Adds a line, unless an end is behind the camera or far outside."""
        ends = np.concatenate([start, end])
        if np.isfinite(ends).all() and np.abs(ends).max() < 1e5:
            self.lines.append((start.tolist(), end.tolist(), color, width))

    def add_labels(self, ids: NDArray[np.int32], names: Mapping[int, str]) -> None:
        """Adds a label on each visible object, without overlaps. `ids`: (H, W); several ids may have one name.

        The caption counts labels without space.
        """
        numbers: dict[str, list[int]] = {}
        for number in np.unique(ids).tolist():
            if number in names:
                numbers.setdefault(names[number], []).append(number)
        regions = [(name, np.isin(ids, found)) for name, found in numbers.items()]
        regions = [(name, region) for name, region in regions if region.sum() >= _LEAST_SEEN]
        # The smallest first, because a large floor can place its name elsewhere.
        regions.sort(key=lambda one: int(one[1].sum()))
        left_out = [name for name, region in regions if not self._place(name, region)]
        if left_out:
            self.captions.append(f"no room for {len(left_out)} more label{'' if len(left_out) == 1 else 's'}")

    def _place(self, name: str, region: NDArray[np.bool_]) -> bool:
        text = visible(name if len(name) <= _LONGEST_NAME else name[: _LONGEST_NAME - 1] + "…")
        x, y = _inner_point(region)
        width, height = text_width(text, self.letters) + 0.8 * self.letters, 1.5 * self.letters
        roomy = region.sum() > 6 * width * height
        for across, down in ((0.0, 0.0), *_OFFSETS) if roomy else _OFFSETS:
            left, top = x + across * height - width / 2, y + down * height - height / 2
            box = (left, top, left + width, top + height)
            if left < 0 or top < 0 or box[2] > self.width or box[3] > self.height:
                continue
            if any(_overlap(box, other) for other, _ in self.texts):
                continue
            if (across, down) != (0, 0):
                end = np.array([np.clip(x, left, box[2]), np.clip(y, top, box[3])])
                self.lines.append(([x, y], end.tolist(), _LEADER, self.thick / 2))
                self.dots.append(([x, y], _LEADER, self.thick))
            self.texts.append((box, text))
            return True
        return False

    def draw(self, pixels: NDArray[np.float32]) -> NDArray[np.float32]:
        """Returns the picture (H, W, 4) with the overlay, or unchanged if there is none."""
        if not (self.lines or self.dots or self.texts or self.captions):
            return pixels
        from PIL import Image, ImageDraw

        layer = Image.new("RGBA", (self.width * _SCALE, self.height * _SCALE))
        draw = ImageDraw.Draw(layer)
        for start, end, color, width in self.lines:
            ends = [(_SCALE * x, _SCALE * y) for x, y in (start, end)]
            draw.line(ends, fill=(*color, 255), width=max(1, round(_SCALE * width)))
        for (x, y), color, radius in self.dots:
            draw.circle((_SCALE * x, _SCALE * y), _SCALE * radius, fill=(*color, 255))
        height = 1.5 * self.letters
        lines = [
            ((0.0, top, text_width(text, self.letters) + 0.8 * self.letters, top + height), text)
            for number, text in enumerate(reversed(self.captions))
            for top in (self.height - (number + 1) * height,)
        ]
        for box, text in (*self.texts, *lines):
            corners = [_SCALE * edge for edge in box]
            draw.rounded_rectangle(corners, 0.3 * _SCALE * self.letters, fill=_PAPER)
            middle = ((corners[0] + corners[2]) / 2, (corners[1] + corners[3]) / 2)
            draw.text(middle, text, fill=_INK, font=font(_SCALE * self.letters), anchor="mm")
        over = np.asarray(layer.resize((self.width, self.height), Image.Resampling.BOX), np.float32) / 255
        share = over[..., 3:]
        color = pixels[..., :3] * (1 - share) + over[..., :3] * share
        return np.concatenate([color, np.maximum(pixels[..., 3:], share)], axis=-1).astype(np.float32)


_OFFSETS: Final = tuple(
    (1.6 * ring * cos(angle), 1.1 * ring * sin(angle))
    for ring in (1.5, 2.5, 3.5, 5, 7)
    for angle in (-pi / 2, -pi / 4, -3 * pi / 4, 0, pi, pi / 2, pi / 4, 3 * pi / 4)
)
"""Possible positions of a label beside its object, in label heights, right and down: above first."""


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _inner_point(region: NDArray[np.bool_]) -> tuple[float, float]:
    """Returns a pixel's centre (x, y) that is about as far from the region's edge as possible."""
    step = max(1, int(region.sum() ** 0.5) // 60)
    inner = region[::step, ::step] if region[::step, ::step].any() else region
    step = step if inner is not region else 1
    while True:
        padded = np.pad(inner, 1)
        smaller = inner & padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
        if not smaller.any():
            break
        inner = smaller
    rows, columns = np.nonzero(inner)
    middle = np.argmin((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2)
    return step * float(columns[middle]) + 0.5, step * float(rows[middle]) + 0.5


def font(size: float) -> Any:
    """Returns Pillow's own font with this height [px]."""
    from PIL import ImageFont

    return ImageFont.load_default(size)


def text_width(text: str, size: float) -> float:
    """Returns the width of a line of text [px]."""
    return float(font(size).getlength(text))
