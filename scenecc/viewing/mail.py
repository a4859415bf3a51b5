"""What is to be done, from many threads to the one that has the engine."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable


class Mail:
    """Tasks in the order in which they came. One with the key of another that waits takes its place.

    So a slider that is dragged through a hundred values asks for few of them.
    """

    def __init__(self) -> None:
        self._waiting: dict[object, Callable[[], None]] = {}
        self._came = threading.Condition()

    def post(self, key: object, task: Callable[[], None]) -> None:
        """Adds a task, from any thread."""
        with self._came:
            self._waiting.pop(key, None)
            self._waiting[key] = task
            self._came.notify()

    def take(self, timeout: float | None) -> Callable[[], None] | None:
        """The next task; None where none comes in time [s]. Without a timeout it waits until one comes."""
        with self._came:
            self._came.wait_for(lambda: self._waiting, timeout)
            if not self._waiting:
                return None
            return self._waiting.pop(next(iter(self._waiting)))
