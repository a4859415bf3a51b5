"""Shares the selection between pages and editors of one user, by datagrams between sockets in a private folder.

Each end has a socket named after its kind, and writes to all sockets named after the other kind. So the start order
does not matter, and no end waits for another. A message gives the place of an entity and can only select it; other
messages are dropped.
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
"""Maximum size of a message."""


class Place(NamedTuple):
    """The place of an entity in a scene file.

    Attributes:
        file: absolute path, without symbolic links.
        path: path of its node in the file.
    """

    file: str
    path: KeyPath


_MESSAGE: Final = TypeAdapter(list[Place])


class SelectionLink:
    """One end of the link. Without a folder for the sockets, it neither sends nor receives.

    Args:
        here: kind of this end; it talks to the other kind.
        heard: called with the places of each message, innermost first, from a separate thread.
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
        """Sends the places of the selection, innermost first, to all other ends. Does not block."""
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
        """Closes this end."""
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
    """Returns the places in a message; empty for an invalid message."""
    try:
        return _MESSAGE.validate_json(message, strict=True) if len(message) <= _MOST_BYTES else []
    except ValueError:
        return []


def _private_folder() -> Path:
    """Returns the folder of the sockets, which only its user can enter. Raises OSError if that fails."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    folder = Path(runtime) / "scenecc" if runtime else cache_folder("selection")
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    status = folder.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid() or stat.S_IMODE(status.st_mode) & 0o077:
        raise PermissionError(f"'{folder}' is accessible to other users")
    return folder
