"""Poses among the shared draws of a plan: what stands relative to many others goes on from one of them."""

from __future__ import annotations

MOST_COMPOSED = 16
"""How many poses one recipe composes before it goes on from a shared one: what is nested more cannot be read back."""

_SUFFIX = ".pose"


def pose_name(name: str, number: int = 0) -> str:
    """What the pose of an entity or a frame is called, as no draw of a file is. `number`: of several such poses."""
    return f"{name}{_SUFFIX}.{number}" if number else name + _SUFFIX


def is_pose(name: str) -> bool:
    """Whether a shared draw is the pose of an entity or a frame. A draw of a file has no dot after its scope."""
    return "." in name.rpartition("/")[2]
