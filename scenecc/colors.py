"""sRGB and linear light (IEC 61966-2-1), and colours as texts of scene files."""

from __future__ import annotations

from collections.abc import Sequence


def srgb_to_linear(value: float) -> float:
    """Returns the linear light, 0 to 1, of an sRGB value, 0 to 1."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def linear_to_srgb(value: float) -> float:
    """Returns the sRGB value, 0 to 1, of linear light, 0 to 1."""
    return 12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055


LINEAR_BYTES = tuple(srgb_to_linear(byte / 255) for byte in range(256))
"""Linear light of each sRGB byte."""


def read_color_text(text: str) -> tuple[float, float, float, float]:
    """Returns linear RGBA of "#rrggbb" or "#rrggbbaa": sRGB bytes, and an alpha over 255."""
    red, green, blue, *rest = bytes.fromhex(text[1:])
    return (LINEAR_BYTES[red], LINEAR_BYTES[green], LINEAR_BYTES[blue], rest[0] / 255 if rest else 1.0)


def color_text(color: Sequence[float], tolerance: float) -> str | None:
    """Returns "#rrggbb[aa]" of linear RGB or RGBA, without an alpha of 1; None if no text is as near as `tolerance`."""
    if not all(0 <= part <= 1 for part in color):
        return None
    shares = [*map(linear_to_srgb, color[:3]), *color[3:]]
    text = "#" + bytes(round(share * 255) for share in shares).hex()
    near = all(abs(a - b) <= tolerance for a, b in zip(read_color_text(text), color, strict=False))
    return (text.removesuffix("ff") if len(color) == 4 else text) if near else None
