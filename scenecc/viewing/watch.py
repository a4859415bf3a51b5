"""Files that are watched for a change."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import TYPE_CHECKING, Final

from watchfiles import watch

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

_TOGETHER: Final = 400
"""How long changes are gathered at most [ms], where one follows the other."""

_QUIET: Final = 20
"""How long nothing may follow a change before it is told [ms]: an editor writes a file in several steps."""

_ASK: Final = 200
"""How often it is asked whether to stop [ms]."""


class Watch:
    """Watches files, also such as are not there yet, by the folders that they are in."""

    def __init__(self, changed: Callable[[], None]) -> None:
        """`changed` is called from a thread of its own."""
        self._changed = changed
        self._files: frozenset[Path] = frozenset()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def see(self, files: Iterable[Path]) -> None:
        """Watches these files in place of those before."""
        wanted = frozenset(files)
        if wanted == self._files:
            return
        before = self._folders()
        self._files = wanted
        if self._folders() != before:
            self.close()
            self._start()

    def close(self) -> None:
        """Ends the watch."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
        self._thread = None

    def _folders(self) -> set[Path]:
        return {_nearest(file.parent) for file in self._files}

    def _start(self) -> None:
        folders = self._folders()
        if not folders:
            return
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(folders, self._stop), name="scenecc watch", daemon=True)
        self._thread.start()

    def _run(self, folders: set[Path], stop: threading.Event) -> None:
        def counts(change: object, path: str) -> bool:
            del change
            # A folder on the way to a file that is missing counts, too.
            return any(file == Path(path) or Path(path) in file.parents for file in self._files)

        for _ in watch(
            *folders,
            watch_filter=counts,
            debounce=_TOGETHER,
            step=_QUIET,
            stop_event=stop,
            rust_timeout=_ASK,
            raise_interrupt=False,
            recursive=False,
        ):
            self._changed()


def _nearest(folder: Path) -> Path:
    """The folder, or the nearest one above it that is there."""
    while not folder.is_dir() and folder != folder.parent:
        folder = folder.parent
    return folder
