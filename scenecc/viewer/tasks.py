"""Tasks of the engine's thread: a queue, and a file watcher that posts a task on changes."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

from watchfiles import watch

from scenecc.interrupt import interrupts_wait

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Iterator
    from pathlib import Path


@contextmanager
def interrupts_kept(mail: TaskQueue) -> Generator[None]:
    """Posts each Ctrl-C in addition to raising it, because some imports swallow exceptions.

    Signals arrive only in the main thread; in other threads, this does nothing.
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
    """Tasks in order of arrival. A new task replaces a waiting one with the same key.

    So dragging a slider through a hundred values runs only a few tasks.
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
        """Returns the next task; None after the timeout [s]. Without a timeout, it waits."""
        with self._came:
            self._came.wait_for(lambda: self._waiting, timeout)
            if not self._waiting:
                return None
            return self._waiting.pop(next(iter(self._waiting)))


_TOGETHER: Final = 400
"""Maximum time for which successive changes are merged [ms]."""

_QUIET: Final = 20
"""Quiet time before a change is reported [ms], because editors write a file in several steps."""

_ASK: Final = 200
"""Polling interval without notifications [ms], as on a network drive."""

_COARSE: Final = 10_000_000
"""Maximum lag of a file time behind the clock [ns]."""

_Stamp = tuple[int, int, int, int] | None
"""Times of the last changes of a file and its name [ns], its size and its inode; None if it does not exist."""


class FileWatcher:
    """Watches files, also files that do not exist yet. A change is detected from the file's stamp."""

    def __init__(self, changed: Callable[[], None]) -> None:
        """`changed` is called from a separate thread."""
        self._changed = changed
        self._stamps: dict[Path, _Stamp] = {}
        self._folders: frozenset[Path] = frozenset()
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    @interrupts_wait()
    def see(self, files: Iterable[Path], since: int | None = None) -> None:
        """Watches these files, replacing the last ones.

        Args:
            files: files to watch.
            since: changes of new files count from this time, in nanoseconds of `time.time_ns`; None: from now.
        """
        with self._lock:
            before = self._stamps
            self._stamps = {file: before[file] if file in before else _stamp(file, since) for file in files}
            folders = frozenset(_nearest(file.parent) for file in self._stamps)
        if folders != self._folders:
            self.close()
            self._folders = folders
            self._stop = threading.Event()
            self._thread = threading.Thread(
                target=self._run, args=(folders, self._stop), name="scenecc watch", daemon=True
            )
            self._thread.start()

    @interrupts_wait()
    def close(self) -> None:
        """Stops watching."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
        self._thread = None

    def _run(self, folders: frozenset[Path], stop: threading.Event) -> None:
        for _ in _moments(folders, stop):
            self._look()

    def _look(self) -> None:
        with self._lock:
            now = {file: _stamp(file) for file in self._stamps}
            changed = now != self._stamps
            self._stamps = now
        if changed:
            self._changed()


def _moments(folders: frozenset[Path], stop: threading.Event) -> Iterator[None]:
    """Yields when files should be checked: after a change in their folders, and periodically."""
    # A folder may be missing or unreadable, and the system limits the number of watched folders.
    with suppress(OSError, RuntimeError):
        for _ in watch(
            *folders,
            watch_filter=None,
            debounce=_TOGETHER,
            step=_QUIET,
            stop_event=stop,
            rust_timeout=_ASK,
            yield_on_timeout=True,
            raise_interrupt=False,
            recursive=False,
        ):
            yield
    while not stop.wait(_ASK / 1000):
        yield


def _stamp(file: Path, since: int | None = None) -> _Stamp:
    """Returns the stamp of a file; an impossible one if it has changed since `since`."""
    try:
        status = file.stat()
    except OSError:
        return None
    if since is not None and status.st_ctime_ns >= since - _COARSE:
        return (-1, -1, -1, -1)
    return status.st_mtime_ns, status.st_ctime_ns, status.st_size, status.st_ino


def _nearest(folder: Path) -> Path:
    """Returns the folder, or the nearest parent that exists."""
    while not folder.is_dir() and folder != folder.parent:
        folder = folder.parent
    return folder
