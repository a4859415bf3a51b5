"""What is to be done, from many threads to the one that has the engine."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Generator


@contextmanager
def interrupts_kept(mail: TaskQueue) -> Generator[None]:
    """Posts each Ctrl-C as well as letting it happen at once: some imports swallow whatever is raised in them.

    Signals arrive in the main thread only; in another one, nothing is changed.
    """
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return

    def keep(number: int, frame: Any) -> None:
        mail.post("interrupt", lambda: handler(number, frame))
        handler(number, frame)

    signal.signal(signal.SIGINT, keep)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)


class TaskQueue:
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
