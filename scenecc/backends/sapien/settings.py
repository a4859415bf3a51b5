"""SAPIEN's process-wide defaults: set for a build where the plan names them, put back after it."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.engine import physx
from scenecc.plan.physics import CONFIG_KINDS, SCENE_CONFIG_FIELDS, process_wide_settings

if TYPE_CHECKING:
    from collections.abc import Generator

    from scenecc.plan import Physics


@contextmanager
def engine_settings(physics: Physics) -> Generator[None]:
    """Sets SAPIEN's defaults to what the plan names and restores all of them, also after an error.

    The default material is not among them: a build hands its own to the shapes that name none. Nor
    is the GPU memory, which only a GPU simulation reads and which SAPIEN lets nobody read back.
    """
    before = {kind: getattr(physx, f"get_{kind}_config")() for kind in CONFIG_KINDS}
    try:
        for kind, given in process_wide_settings(physics).items():
            _set(kind, given, physics.cpu_workers if kind == "scene" else None)
        yield
    finally:
        # The objects hold everything, also the number of workers, which has no property to read.
        for kind, config in before.items():
            getattr(physx, f"set_{kind}_config")(config)


def _set(kind: str, given: dict[str, Any], cpu_workers: int | None) -> None:
    config: Any = getattr(physx, f"get_{kind}_config")()
    if cpu_workers is not None:
        present = {name: getattr(config, name) for name in SCENE_CONFIG_FIELDS}
        physx.set_scene_config(**(present | given), cpu_workers=cpu_workers)
    elif given:
        for name, value in given.items():
            setattr(config, name, value)
        getattr(physx, f"set_{kind}_config")(config)
