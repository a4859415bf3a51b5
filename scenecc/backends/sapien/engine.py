"""SAPIEN as this package uses it: the one place that imports it, its process-wide settings, its log, and what the
machine supports.

`EngineFailure` is how everything in this folder stops a build.
"""

from __future__ import annotations

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
    # SAPIEN warns at import where it finds no system libvulkan; physics needs none, and a user can do nothing with it.
    warnings.simplefilter("ignore")
    import sapien

# The stubs of these two leave most argument types open, so they are taken as untyped: the engine's edge.
physx: Any = importlib.import_module("sapien.physx")

render: Any = importlib.import_module("sapien.render")

REFUSED_CODE = "SC808"
"""The code of what the engine does not take of a body."""


class EngineFailure(CodedError):
    """The engine or the machine cannot do what the plan asks: a code of band 8, unless a file is at fault."""


def engine_refusal(what: str, error: Exception, origin: Origin | None) -> EngineFailure:
    """That the engine refuses a thing, in the first line of its own words."""
    words = str(error).partition("\n")[0]
    return EngineFailure(REFUSED_CODE, f"the engine refuses {what}: {words}", origin=origin)


def new_render_system() -> Any:
    """A `sapien.render.RenderSystem`. Raises RuntimeError where no device renders."""
    return render.RenderSystem()


@cache
def supports_ray_tracing() -> bool:
    """Whether the device that SAPIEN renders with can trace rays. Asked once a process.

    SAPIEN tells its log where it cannot, and crashes with the first picture.

    Raises:
        RuntimeError: no device renders.
    """
    return summary_has_ray_tracing(render.get_device_summary(), new_render_system().device.name)


def summary_has_ray_tracing(summary: str, name: str) -> bool:
    """What SAPIEN's summary of devices says of those of a name; True where it names none of them."""
    devices = [device.splitlines() for device in summary.split("GPU: ")[1:]]
    said = [line for title, *lines in devices if title.strip() == name for line in lines if "rayTrace:" in line]
    return not said or any(line.split()[-1] == "1" for line in said)


@contextmanager
def ray_tracing_quality(samples: int, *, denoise: bool) -> Generator[None]:
    """Has cameras that are made meanwhile take so many samples a pixel, and restores SAPIEN's process-wide settings.

    Args:
        samples: a pixel.
        denoise: filter the noise where the device can: SAPIEN's denoisers need CUDA, and elsewhere only log errors.
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
    """Why SAPIEN cannot render here, in its own words; None where it can. Asked once a process."""
    try:
        new_render_system()
    except RuntimeError as error:
        return str(error)
    return None


@contextmanager
def engine_settings(physics: Physics) -> Generator[None]:
    """Sets SAPIEN's defaults to what the plan names and restores all of them, also after an error.

    The default material is not among them: a build hands its own to the shapes that name none. Nor
    is the GPU memory, which only a GPU simulation reads and which SAPIEN lets nobody read back.
    """
    before = {kind: getattr(physx, f"get_{kind}_config")() for kind in CONFIG_KINDS}
    try:
        for kind, given in process_wide_settings(physics).items():
            _set_config(kind, given, physics.cpu_workers if kind == "scene" else None)
        yield
    finally:
        # The objects hold everything, also the number of workers, which has no property to read.
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
"""SAPIEN's words for a convex part that it leaves out of a body."""

_STDERR = 2

_FLAT_MESH = Path(__file__).with_name("speck.obj")
"""A tetrahedron that PhysX takes for flat (a critical message) and SAPIEN leaves out (a warning)."""


@dataclass(slots=True)
class EngineLog:
    """What was written; complete once the block is left."""

    text: str = ""


@contextmanager
def capture_engine_log() -> Generator[EngineLog]:
    """Reads the warnings that the engine writes meanwhile, also where the user has silenced its log.

    The engine writes to the descriptor of the standard error, past `sys.stderr`. What it wrote is
    passed on afterwards, unless the log is silenced or the process has closed that descriptor.
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
    """Has the process write its standard error to another descriptor; the true one, None where it is closed."""
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
    """The level of the log, None where warnings are written. SAPIEN lets nobody read it, so it is made to speak."""
    material: Any = physx.get_default_material()
    # With no part left over, this fails.
    with suppress(RuntimeError):
        physx.PhysxCollisionShapeConvexMesh.load_multiple(str(_FLAT_MESH), (1, 1, 1), material)
    with suppress(RuntimeError):
        physx.PhysxCollisionShapeConvexMesh(str(_FLAT_MESH.with_name("none.obj")), (1, 1, 1), material)
    said = _drain(file).decode(errors="replace")
    if DROPPED_PART in said:
        return None
    return "error" if "[error]" in said else "critical" if "[critical]" in said else "off"


def _drain(file: IO[bytes]) -> bytes:
    """What was written, and an empty file afterwards."""
    file.seek(0)
    written = file.read()
    file.seek(0)
    file.truncate()
    return written
