"""A pose as seven numbers."""

from __future__ import annotations

from typing import Final

Pose7 = tuple[float, float, float, float, float, float, float]
"""p [m] then q (wxyz), of unit length."""

IDENTITY_POSE: Final[Pose7] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
