"""What SAPIEN writes to its log and tells nobody else."""

from __future__ import annotations

import os
import sys
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Generator

DROPPED_PART = "failed to load a component from file"
"""SAPIEN's words for a convex part that it leaves out of a body."""

_STDERR = 2


@dataclass(slots=True)
class Log:
    """What was written; complete once the block is left."""

    text: str = ""


@contextmanager
def engine_log() -> Generator[Log]:
    """Reads what the engine writes to the process's standard error meanwhile, and passes it on afterwards.

    The engine writes to the descriptor, past `sys.stderr`. In a process that has closed it there is
    nothing to read.
    """
    log = Log()
    try:
        kept = os.dup(_STDERR)
    except OSError:
        yield log
        return
    with tempfile.TemporaryFile() as file:
        if sys.stderr is not None:
            sys.stderr.flush()
        os.dup2(file.fileno(), _STDERR)
        try:
            yield log
        finally:
            os.dup2(kept, _STDERR)
            os.close(kept)
            file.seek(0)
            written = file.read()
            log.text = written.decode(errors="replace")
            os.write(_STDERR, written)
