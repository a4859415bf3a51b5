"""The server of a page: viser's, which listens where it is asked to and talks to nobody else."""

from __future__ import annotations

import io
import re
import socket
import threading
from contextlib import contextmanager, redirect_stdout, suppress
from functools import partial
from ipaddress import ip_address
from typing import TYPE_CHECKING, Any, Final
from unittest.mock import patch

import viser
import websockets.asyncio.server as below

from scenecc.interrupt import interrupts_wait

if TYPE_CHECKING:
    from collections.abc import Generator

    from scenecc.viewing.look import Place

_FIRST: Final = 8080
"""The port of a page where none is asked for."""

_OPENING: Final = threading.Lock()
"""What is patched and redirected while a server starts is everybody's."""

_OWN_PAGE: Final = re.compile(r"https?://(localhost|127\.[0-9]+\.[0-9]+\.[0-9]+|\[::1\])(:[0-9]+)?")
"""Origins of pages from this machine, through another port as well: a tunnel has its own."""


def open_server(place: Place, label: str) -> viser.ViserServer:
    """A server that listens.

    Raises:
        OSError: the address or the port cannot be had.
    """
    port = _free_port(place)
    with _OPENING, _quiet(), _own_pages_only(place):
        server = viser.ViserServer(place.host, port, label, verbose=False)
    # Any page may ask viser to publish itself through a server on the internet.
    server.request_share_url = _refuse
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stops it; viser would print that."""
    with interrupts_wait(), _quiet():
        server.stop()


def _refuse(verbose: bool = True) -> None:  # noqa: FBT001, FBT002 - viser's own signature
    del verbose


def _free_port(place: Place) -> int:
    """A port that is free: viser itself would try a thousand others, and wait for ever where the address is wrong."""
    wanted = range(_FIRST, _FIRST + 100) if place.port is None else (place.port,)
    for port in wanted[:-1]:
        with suppress(OSError):
            return _bound(place.host, port)
    return _bound(place.host, wanted[-1])


def _bound(host: str, port: int) -> int:
    """The port that is had where this one is asked for. Raises OSError."""
    with socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
        return int(probe.getsockname()[1])


@contextmanager
def _own_pages_only(place: Place) -> Generator[None]:
    """Lets pages of other sites, open in the same browser, not talk to a server on a loopback address.

    viser asks nobody where a page comes from, and has no option for it; the library below it has one.
    """
    if not _is_loopback(place.host):
        yield
        return
    serve: Any = below.serve
    # A program that is no page names no origin.
    with patch.object(below, "serve", partial(serve, origins=[_OWN_PAGE, None])):
        yield


def _is_loopback(host: str) -> bool:
    try:
        return host == "localhost" or ip_address(host).is_loopback
    except ValueError:  # the name of a machine
        return False


@contextmanager
def _quiet() -> Generator[None]:
    """Keeps viser's own words from standard output."""
    with redirect_stdout(io.StringIO()):
        yield
