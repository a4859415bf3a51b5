"""The four collision integers of a shape, as SAPIEN takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

ID_BITS = 0xFFFF
"""The bits of the fourth integer within which those of the third count."""


def collide(a: Sequence[int], b: Sequence[int]) -> bool:
    """SAPIEN's rule over the four integers of two shapes (`PhysxCollisionShape.set_collision_groups`)."""
    ignored = bool(a[2] & b[2]) and (a[3] & ID_BITS) == (b[3] & ID_BITS)
    return bool((a[0] & b[1]) or (a[1] & b[0])) and not ignored
