"""Has pages and editors of one user tell each other what is selected: datagrams between sockets in a folder of theirs.

Each end has a socket that is named after its kind, and writes to all that are named after the other kind. So it does
not matter which of them starts first, and none waits for another. A message says where something is written, and asks
for nothing but a selection; what is anything else is dropped.
"""

from __future__ import annotations

import json
import os
import secrets
import socket
import stat
import threading
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from pydantic import TypeAdapter

from scenecc.diagnostics.diagnostic import Path as KeyPath  # noqa: TC001 - Pydantic reads it
from scenecc.files import cache_folder
from scenecc.interrupt import interrupts_wait, undoing

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

_MOST_BYTES: Final = 2**16
"""Of a message."""


class Place(NamedTuple):
    """Where an entity is written.

    Attributes:
        file: its absolute path, without symbolic links.
        path: of its node there.
    """

    file: str
    path: KeyPath


_MESSAGE: Final = TypeAdapter(list[Place])


class SelectionLink:
    """One end of the link. Where there is no folder for it, nothing is sent and nothing comes.

    Args:
        here: what this end is; the others are of the other kind.
        heard: called with the places of each message, innermost first, from a thread of its own.
    """

    def __init__(self, here: Literal["page", "editor"], heard: Callable[[list[Place]], None]) -> None:
        self._there = "editor" if here == "page" else "page"
        self._heard = heard
        self._closed = False
        self._ending = ExitStack()
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._thread = threading.Thread(target=self._receive, name="scenecc selection", daemon=True)
        with suppress(OSError), interrupts_wait():
            self._folder = _private_folder()
            address = self._folder / f"{here}-{secrets.token_hex(8)}"
            self._socket.bind(os.fspath(address))
            self._ending.enter_context(undoing()).callback(address.unlink, missing_ok=True)
            self._thread.start()

    def send(self, places: Iterable[Place]) -> None:
        """Tells all other ends where what is selected is written, innermost first. Waits for none of them."""
        if self._closed or not self._thread.is_alive():
            return
        message = json.dumps([*places]).encode()
        for other in self._folder.glob(f"{self._there}-*"):
            self._send(message, other)

    def _send(self, message: bytes, other: Path) -> None:
        with suppress(OSError):  # it is busy or gone
            try:
                self._socket.sendto(message, socket.MSG_DONTWAIT, os.fspath(other))
            except ConnectionRefusedError:  # its process was killed
                other.unlink()

    def close(self) -> None:
        """Ends it."""
        self._closed = True
        self._ending.close()
        if self._thread.is_alive():
            self._socket.shutdown(socket.SHUT_RD)
            self._thread.join()
        self._socket.close()

    def _receive(self) -> None:
        while True:
            message = self._socket.recv(_MOST_BYTES + 1)
            if self._closed:
                return
            if places := _places(message):
                self._heard(places)


def _places(message: bytes) -> list[Place]:
    """What a message says; none where it is no such message."""
    try:
        return _MESSAGE.validate_json(message, strict=True) if len(message) <= _MOST_BYTES else []
    except ValueError:
        return []


def _private_folder() -> Path:
    """The folder of the sockets, which only its user can enter. Raises OSError if it cannot be had."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    folder = Path(runtime) / "scenecc" if runtime else cache_folder("selection")
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    status = folder.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid() or stat.S_IMODE(status.st_mode) & 0o077:
        raise PermissionError(f"'{folder}' is not of its user alone")
    return folder
