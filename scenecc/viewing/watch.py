"""Files that are watched for a change."""

from __future__ import annotations

import threading
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from watchfiles import watch

from scenecc.backends.sapien.interrupt import interrupts_wait

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

_TOGETHER: Final = 400
"""How long changes are gathered at most [ms], where one follows the other."""

_QUIET: Final = 20
"""How long nothing may follow a change before it is told [ms]: an editor writes a file in several steps."""

_ASK: Final = 200
"""How often files are looked at where nothing is told [ms]: a network drive tells nothing."""

_Stamp = tuple[int, int, int] | None
"""Time of the last change [ns], size and inode of a file; None where there is none."""


class Watch:
    """Watches files, also such as are not there yet. What tells of a change is the file, whoever says it changed."""

    def __init__(self, changed: Callable[[], None]) -> None:
        """`changed` is called from a thread of its own."""
        self._changed = changed
        self._stamps: dict[Path, _Stamp] = {}
        self._folders: frozenset[Path] = frozenset()
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    @interrupts_wait()
    def see(self, files: Iterable[Path]) -> None:
        """Watches these files in place of those before; of new ones, changes from now on."""
        with self._lock:
            before = self._stamps
            self._stamps = {file: before[file] if file in before else _stamp(file) for file in files}
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
        """Ends the watch."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
        self._thread = None

    def _run(self, folders: frozenset[Path], stop: threading.Event) -> None:
        # A folder may be gone by now or not be readable, and the system watches so many folders and no more.
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
                self._look()
        while not stop.wait(_ASK / 1000):
            self._look()

    def _look(self) -> None:
        with self._lock:
            now = {file: _stamp(file) for file in self._stamps}
            changed = now != self._stamps
            self._stamps = now
        if changed:
            self._changed()


def _stamp(file: Path) -> _Stamp:
    try:
        status = file.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size, status.st_ino


def _nearest(folder: Path) -> Path:
    """The folder, or the nearest one above it that is there."""
    while not folder.is_dir() and folder != folder.parent:
        folder = folder.parent
    return folder
