"""The one place that imports SAPIEN. Everything here that needs the engine takes it from this module."""

from __future__ import annotations

import warnings

with warnings.catch_warnings():
    # SAPIEN warns at import where it finds no system libvulkan; physics needs none, and a user can do nothing with it.
    warnings.simplefilter("ignore")
    import sapien
    import sapien.render as render
    from sapien import physx

__all__ = ["physx", "render", "sapien"]
