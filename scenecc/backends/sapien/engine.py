"""The one place that imports SAPIEN. Everything here that needs the engine takes it from this module."""

from __future__ import annotations

import importlib
import warnings
from typing import Any

with warnings.catch_warnings():
    # SAPIEN warns at import where it finds no system libvulkan; physics needs none, and a user can do nothing with it.
    warnings.simplefilter("ignore")
    import sapien

# The stubs of these two leave most argument types open, so they are taken as untyped: the engine's edge.
physx: Any = importlib.import_module("sapien.physx")
render: Any = importlib.import_module("sapien.render")

__all__ = ["physx", "render", "sapien"]
