"""What SAPIEN writes to its log and tells nobody else."""

from __future__ import annotations

import os
import sys
import tempfile
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Literal

from scenecc.backends.sapien.engine import physx, sapien

if TYPE_CHECKING:
    from collections.abc import Generator

DROPPED_PART = "failed to load a component from file"
"""SAPIEN's words for a convex part that it leaves out of a body."""

_STDERR = 2

_SPECK = Path(__file__).with_name("speck.obj")
"""A tetrahedron that PhysX takes for flat (a critical message) and SAPIEN leaves out (a warning)."""


@dataclass(slots=True)
class Log:
    """What was written; complete once the block is left."""

    text: str = ""


@contextmanager
def engine_log() -> Generator[Log]:
    """Reads the warnings that the engine writes meanwhile, also where the user has silenced its log.

    The engine writes to the descriptor of the standard error, past `sys.stderr`. What it wrote is
    passed on afterwards, unless the log is silenced or the process has closed that descriptor.
    """
    log = Log()
    if sys.stderr is not None:
        sys.stderr.flush()
    with tempfile.TemporaryFile() as file, _standard_error(file.fileno()) as kept:
        level = _level(file)
        if level is not None:
            sapien.set_log_level("warn")
        try:
            yield log
        finally:
            if level is not None:
                sapien.set_log_level(level)
            written = _take(file)
            log.text = written.decode(errors="replace")
            if kept is not None and level is None:
                os.write(kept, written)


@contextmanager
def _standard_error(instead: int) -> Generator[int | None]:
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


def _level(file: IO[bytes]) -> Literal["error", "critical", "off"] | None:
    """The level of the log, None where warnings are written. SAPIEN lets nobody read it, so it is made to speak."""
    material: Any = physx.get_default_material()
    # With no part left over, this fails.
    with suppress(RuntimeError):
        physx.PhysxCollisionShapeConvexMesh.load_multiple(str(_SPECK), (1, 1, 1), material)
    with suppress(RuntimeError):
        physx.PhysxCollisionShapeConvexMesh(str(_SPECK.with_name("none.obj")), (1, 1, 1), material)
    said = _take(file).decode(errors="replace")
    if DROPPED_PART in said:
        return None
    return "error" if "[error]" in said else "critical" if "[critical]" in said else "off"


def _take(file: IO[bytes]) -> bytes:
    """What was written, and an empty file afterwards."""
    file.seek(0)
    written = file.read()
    file.seek(0)
    file.truncate()
    return written
