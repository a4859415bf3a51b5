"""Depths and segmentations for viewing: depths as colours with a scale bar, and names beside the colours of ids."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.formats.style import visible
from scenecc.render.overlays import font, text_width

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

_SCALE: Final = (
    (0.00, (253, 231, 37)),
    (0.25, (94, 201, 98)),
    (0.50, (33, 145, 140)),
    (0.75, (59, 82, 139)),
    (1.00, (68, 1, 84)),
)
"""Near to far, from bright to dark, like viridis: readable in grey and by colour-blind people."""

_NOTHING: Final = (0, 0, 0)
_LETTERS, _MARGIN, _BAR, _SWATCH = 12, 8, 16, 12
_LONGEST: Final = 40


def depth_range(depths: Sequence[NDArray[np.float32]]) -> tuple[float, float]:
    """Returns smallest and largest depth in pictures [m], without the farthest 2 % of pixels; 0.5 and 1 if empty."""
    known = np.concatenate([depth[depth > 0] for depth in depths])
    if not known.size:
        return 0.5, 1.0
    low, high = float(known.min()), float(np.percentile(known, 98))
    return (low, high) if high > low else (low, low * 1.01)


def depth_colors(depth: NDArray[np.float32], low: float, high: float) -> NDArray[np.uint8]:
    """Returns colours (H, W, 3) of a depth (H, W, 1) [m], by its logarithm; black where there is nothing."""
    share = _shares(depth[..., 0], low, high)
    found = np.stack([np.interp(share, *_channel(channel)) for channel in range(3)], axis=-1)
    return np.where(depth > 0, np.rint(found), _NOTHING).astype(np.uint8)


def _shares(depth: NDArray[Any], low: float, high: float) -> NDArray[np.float64]:
    """Maps depths to 0 to 1 on a log scale, which separates near objects despite a far floor."""
    return np.clip(np.log(np.maximum(depth, low) / low) / np.log(high / low), 0, 1)


def _channel(number: int) -> tuple[list[float], list[int]]:
    return [place for place, _ in _SCALE], [color[number] for _, color in _SCALE]


def add_depth_bar(picture: NDArray[np.uint8], low: float, high: float) -> NDArray[np.uint8]:
    """Returns a picture (H, W, 3) with a bar of these depths [m] on its right."""
    from PIL import Image, ImageDraw

    height, width, _ = picture.shape
    top, bottom = _LETTERS, max(height - _LETTERS, _LETTERS + 2)
    steps = _ticks(low, high, bottom - top)
    texts = [f"{step:.6g} m" for step in steps]
    wide = _BAR + 3 * _MARGIN + ceil(max(text_width(text, _LETTERS) for text in texts))
    image = Image.new("RGB", (width + wide, height), "white")
    image.paste(Image.fromarray(picture), (0, 0))
    column = np.geomspace(low, high, bottom - top, dtype=np.float32)[:, None, None]
    bar = depth_colors(np.repeat(column, _BAR, axis=1), low, high)
    image.paste(Image.fromarray(bar), (width + _MARGIN, top))
    draw = ImageDraw.Draw(image)
    edge = width + _MARGIN + _BAR
    for step, text in zip(steps, texts, strict=True):
        y = top + float(_shares(np.array(step), low, high)) * (bottom - top)
        draw.line([(edge, y), (edge + 3, y)], fill="black")
        draw.text((edge + 6, y), text, fill="black", font=font(_LETTERS), anchor="lm")
    return np.asarray(image)


def _ticks(low: float, high: float, height: int) -> list[float]:
    """Returns round depths [m] whose labels do not overlap on a bar of this height [px], or else the ends."""
    rough = (high - low) / 40
    power = 10.0 ** np.floor(np.log10(rough))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough)
    numbers = np.arange(ceil(low / step - 1e-9), int(high / step + 1e-9) + 1)
    # The roundest first, so that they keep their places.
    numbers = sorted(
        numbers.tolist(), key=lambda number: -next(m for m in (100, 50, 20, 10, 5, 2, 1) if number % m == 0)
    )
    chosen: list[float] = []
    for number in numbers:
        place = float(_shares(np.array(number * step), low, high)) * height
        taken = [float(_shares(np.array(one), low, high)) * height for one in chosen]
        if all(abs(place - other) > 2.5 * _LETTERS for other in taken):
            chosen.append(float(round(number * step, 12)))
    return sorted(chosen) or [low, high]


def add_names(picture: NDArray[np.uint8], rows: Sequence[tuple[str, str]]) -> NDArray[np.uint8]:
    """Returns a picture (H, W, 3) with colours (#rrggbb) and names on its right, in as many columns as needed."""
    from PIL import Image, ImageDraw

    height, width, _ = picture.shape
    line = _LETTERS + 6
    each = max(1, (height - _MARGIN) // line)
    texts: list[tuple[str, str]] = [(color, _cut(name)) for color, name in rows]
    columns = [texts[start : start + each] for start in range(0, len(texts), each)]
    wides = [_SWATCH + 3 * _MARGIN + ceil(max(text_width(name, _LETTERS) for _, name in one)) for one in columns]
    image = Image.new("RGB", (width + sum(wides), height), "white")
    image.paste(Image.fromarray(picture), (0, 0))
    draw = ImageDraw.Draw(image)
    left = width + _MARGIN
    for column, wide in zip(columns, wides, strict=True):
        for number, (color, name) in enumerate(column):
            top = _MARGIN / 2 + number * line
            draw.rectangle([left, top + 2, left + _SWATCH, top + 2 + _SWATCH], fill=color, outline="black")
            draw.text((left + _SWATCH + _MARGIN, top + line / 2), name, fill="black", font=font(_LETTERS), anchor="lm")
        left += wide
    return np.asarray(image)


def _cut(name: str) -> str:
    shown: Any = visible(name)
    return shown if len(shown) <= _LONGEST else shown[: _LONGEST - 1] + "…"
