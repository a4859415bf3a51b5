"""A progress bar for long work: on a terminal only, on standard error, and gone when the work is done."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from typing import Final, TypeVar

from scenecc.interrupt import undoing

_PATIENCE: Final = 0.5
"""Seconds that work takes before it is called long."""

_EVERY: Final = 0.1
_WIDTH: Final = 40
_CLEAR: Final = "\r\x1b[K"

Show = Callable[[int, int], None]
"""Told how much is done, and of how much."""

Item = TypeVar("Item")


@contextmanager
def progress(label: str) -> Generator[Show | None, None, None]:
    """Shows a bar while something lasts. None where nobody would see it."""
    if not sys.stderr.isatty():
        yield None
        return
    shown_at = time.monotonic() + _PATIENCE - _EVERY

    def show(done: int, total: int) -> None:
        nonlocal shown_at
        now = time.monotonic()
        if now - shown_at < _EVERY:
            return
        shown_at = now
        filled = "#" * (_WIDTH * done // total)
        sys.stderr.write(f"{_CLEAR}{label} [{filled:-<{_WIDTH}}] {done}/{total}")
        sys.stderr.flush()

    with undoing() as undo:
        undo.callback(os.write, sys.stderr.fileno(), _CLEAR.encode())
        yield show


def counted(label: str, items: Sequence[Item]) -> Iterator[Item]:
    """The items one after another, with a bar that counts them."""
    with progress(label) as show:
        for done, item in enumerate(items):
            if show is not None:
                show(done, len(items))
            yield item
