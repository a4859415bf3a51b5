"""The only module that imports SAPIEN: its process-wide settings, its log, and what the machine supports.

All modules of this folder raise `EngineFailure` to stop a build.
"""

from __future__ import annotations

import atexit
import importlib
import os
import sys
import tempfile
import warnings
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Literal

from scenecc.diagnostics.coded_error import CodedError
from scenecc.plan.scene import CONFIG_KINDS, SCENE_CONFIG_FIELDS, Physics, process_wide_settings

if TYPE_CHECKING:
    from collections.abc import Generator

    from scenecc.diagnostics.diagnostic import Origin


with warnings.catch_warnings():
    # SAPIEN warns at import if it finds no system libvulkan. Physics does not need one, and a user cannot act on it.
    warnings.simplefilter("ignore")
    import sapien

# The stubs of these two leave most argument types open, so they are treated as untyped at this boundary.
physx: Any = importlib.import_module("sapien.physx")

render: Any = importlib.import_module("sapien.render")

REFUSED_CODE = "SC808"
"""The code for a property of a body that the engine does not support."""


class EngineFailure(CodedError):
    """The engine or the machine cannot do what the plan asks: a code of band 8, unless a file is at fault."""


def engine_refusal(what: str, error: Exception, origin: Origin | None) -> EngineFailure:
    """Returns the failure for something that the engine refuses, with the first line of the engine's message."""
    words = str(error).partition("\n")[0]
    return EngineFailure(REFUSED_CODE, f"the engine refuses {what}: {words}", origin=origin)


def new_render_system() -> Any:
    """Returns a `sapien.render.RenderSystem`. Raises RuntimeError without a render device."""
    return render.RenderSystem()


@cache
def keep_renderer() -> Any:
    """Keeps the renderer until the process ends or forks: without one, SAPIEN discards its compiled shaders.

    A forked process could not use it. Raises RuntimeError without a render device.
    """
    return render.RenderSystem()


def release_renderer() -> None:
    """Discards the kept renderer. SAPIEN has one for a process, so that ManiSkill could make none on another device."""
    keep_renderer.cache_clear()


atexit.register(keep_renderer.cache_clear)
os.register_at_fork(before=keep_renderer.cache_clear)


@cache
def supports_ray_tracing() -> bool:
    """Returns whether SAPIEN's render device supports ray tracing. Asked once per process.

    Without support, SAPIEN only logs it, and crashes at the first picture.

    Raises:
        RuntimeError: there is no render device.
    """
    return summary_has_ray_tracing(render.get_device_summary(), new_render_system().device.name)


def summary_has_ray_tracing(summary: str, name: str) -> bool:
    """Returns whether SAPIEN's device summary lists ray tracing for a name; True if the name is not in it."""
    devices = [device.splitlines() for device in summary.split("GPU: ")[1:]]
    said = [line for title, *lines in devices if title.strip() == name for line in lines if "rayTrace:" in line]
    return not said or any(line.split()[-1] == "1" for line in said)


def cpu_renderer() -> str | None:
    """Returns the name of the render device if it is a driver that renders on the CPU. RuntimeError without one."""
    name: str = new_render_system().device.name
    return name if name.startswith(("llvmpipe", "SwiftShader")) else None


@contextmanager
def ray_tracing_quality(samples: int, *, denoise: bool) -> Generator[None]:
    """Sets the quality of ray tracing for cameras made within the block, and then restores SAPIEN's process-wide
    settings.

    Args:
        samples: per pixel.
        denoise: filter the noise if the device can. SAPIEN's denoisers need CUDA; elsewhere they only log errors.
    """
    before = render.get_ray_tracing_samples_per_pixel(), render.get_ray_tracing_denoiser()
    try:
        render.set_ray_tracing_samples_per_pixel(samples)
        if denoise and render_problem() is None and new_render_system().device.is_cuda():
            render.set_ray_tracing_denoiser("optix")
        yield
    finally:
        render.set_ray_tracing_samples_per_pixel(before[0])
        render.set_ray_tracing_denoiser(before[1])


@cache
def render_problem() -> str | None:
    """Returns why SAPIEN cannot render here, in its own words, or None if it can. Asked once per process."""
    try:
        new_render_system()
    except RuntimeError as error:
        return str(error)
    return None


@contextmanager
def engine_settings(physics: Physics) -> Generator[None]:
    """Sets SAPIEN's defaults to those of the plan and restores all of them, also after an error.

    The default material is excluded, because a build passes its own to shapes without one. So is the GPU memory, which
    only a GPU simulation reads.
    """
    before = {kind: getattr(physx, f"get_{kind}_config")() for kind in CONFIG_KINDS}
    try:
        for kind, given in process_wide_settings(physics).items():
            _set_config(kind, given, physics.cpu_workers if kind == "scene" else None)
        yield
    finally:
        # The objects hold everything, including the number of workers, which has no getter.
        for kind, config in before.items():
            getattr(physx, f"set_{kind}_config")(config)


def _set_config(kind: str, given: dict[str, Any], cpu_workers: int | None) -> None:
    config: Any = getattr(physx, f"get_{kind}_config")()
    if cpu_workers is not None:
        present = {name: getattr(config, name) for name in SCENE_CONFIG_FIELDS}
        physx.set_scene_config(**(present | given), cpu_workers=cpu_workers)
    elif given:
        for name, value in given.items():
            setattr(config, name, value)
        getattr(physx, f"set_{kind}_config")(config)


DROPPED_PART = "failed to load a component from file"
"""SAPIEN's log message for a convex part that it leaves out of a body."""

_STDERR = 2

_FLAT_MESH = Path(__file__).with_name("speck.obj")
"""A tetrahedron that PhysX considers flat (a critical message) and SAPIEN leaves out (a warning)."""


@dataclass(slots=True)
class EngineLog:
    """The captured text. Complete when the block ends."""

    text: str = ""


@contextmanager
def capture_engine_log() -> Generator[EngineLog]:
    """Captures the engine's warnings within the block, even if the user has silenced its log.

    The engine writes to the file descriptor of standard error, bypassing `sys.stderr`. The text is passed on
    afterwards, unless the log is silenced or the process has closed that descriptor.
    """
    log = EngineLog()
    if sys.stderr is not None:
        sys.stderr.flush()
    with tempfile.TemporaryFile() as file, _redirect_standard_error(file.fileno()) as kept:
        level = _log_level(file)
        if level is not None:
            sapien.set_log_level("warn")
        try:
            yield log
        finally:
            if level is not None:
                sapien.set_log_level(level)
            written = _drain(file)
            log.text = written.decode(errors="replace")
            if kept is not None and level is None:
                os.write(kept, written)


@contextmanager
def _redirect_standard_error(instead: int) -> Generator[int | None]:
    """Redirects standard error of the process to another descriptor. Yields the true one, or None if it is closed."""
    try:
        kept = os.dup(_STDERR)
    except OSError:
        kept = None
    os.dup2(instead, _STDERR)
    try:
        yield kept
    finally:
        if kept is None:
            os.close(_STDERR)
        else:
            os.dup2(kept, _STDERR)
            os.close(kept)


def _log_level(file: IO[bytes]) -> Literal["error", "critical", "off"] | None:
    """Returns the log level, None if warnings are written. SAPIEN has no getter for it, so this provokes messages."""
    material: Any = physx.get_default_material()
    # This fails, because no part is left.
    with suppress(RuntimeError):
        physx.PhysxCollisionShapeConvexMesh.load_multiple(str(_FLAT_MESH), (1, 1, 1), material)
    with suppress(RuntimeError):
        physx.PhysxCollisionShapeConvexMesh(str(_FLAT_MESH.with_name("none.obj")), (1, 1, 1), material)
    said = _drain(file).decode(errors="replace")
    if DROPPED_PART in said:
        return None
    return "error" if "[error]" in said else "critical" if "[critical]" in said else "off"


def _drain(file: IO[bytes]) -> bytes:
    """Returns what was written and empties the file."""
    file.seek(0)
    written = file.read()
    file.seek(0)
    file.truncate()
    return written
