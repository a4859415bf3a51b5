"""Ctrl-C while something is made that nobody can let go of by halves: held back until it is whole."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Generator


@contextmanager
def interrupts_wait() -> Generator[None]:
    """Delivers SIGINT at the end of the block instead of inside it.

    A `sapien.Scene` whose `__init__` was interrupted ends the whole process when it is freed: its
    `__del__` clears what was never made. Signals arrive in the main thread only.
    """
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return
    waiting: list[tuple[int, Any]] = []
    signal.signal(signal.SIGINT, lambda number, frame: waiting.append((number, frame)))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if waiting:
            handler(*waiting[0])
