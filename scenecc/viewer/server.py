"""The server of a page: viser's, which listens where it is asked to and talks to nobody else."""

from __future__ import annotations

import asyncio
import io
import logging
import re
import socket
import threading
from contextlib import contextmanager, redirect_stdout, suppress
from functools import partial
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from secrets import compare_digest
from typing import TYPE_CHECKING, Any, Final
from unittest.mock import patch
from urllib.parse import parse_qs, quote, unquote, urlsplit

import viser
import websockets.asyncio.server as below

from scenecc.interrupt import interrupts_wait

if TYPE_CHECKING:
    from collections.abc import Generator

    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request

    from scenecc.viewer.options import PageAddress

_FIRST: Final = 8080
"""The port of a page where none is asked for."""

_OPENING: Final = threading.Lock()
"""What is patched and redirected while a server starts is everybody's."""

_OWN_PAGE: Final = re.compile(r"https?://(localhost|127\.[0-9]+\.[0-9]+\.[0-9]+|\[::1\])(:[0-9]+)?")
"""Origins of pages from this machine, through another port as well: a tunnel has its own."""


def open_server(place: PageAddress, label: str) -> viser.ViserServer:
    """A server that listens.

    Raises:
        OSError: the address or the port cannot be had.
    """
    port = _free_port(place)
    with _OPENING, _quiet(), patch.object(below, "serve", _Guard(place)):
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


def _free_port(place: PageAddress) -> int:
    """A port that is free: viser itself would try a thousand others, and wait for ever where the address is wrong."""
    wanted = range(_FIRST, _FIRST + 100) if place.port is None else (place.port,)
    for port in wanted[:-1]:
        with suppress(OSError):
            return _bound(place.host, port)
    return _bound(place.host, wanted[-1])


def _bound(host: str, port: int) -> int:
    """The port that is had where this one is asked for. Raises OSError."""
    try:
        host.encode("idna")
    except UnicodeError as error:
        raise OSError(f"it cannot be a name: {error}") from error
    with socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
        return int(probe.getsockname()[1])


class _Guard:
    """Serves as the library below viser does, to whom it may.

    viser asks nobody who comes from where, and has no option for it; the library below it has.
    """

    def __init__(self, place: PageAddress) -> None:
        self._place = place
        self._serve: Any = below.serve

    def __call__(self, *given: Any, process_request: Any, **options: Any) -> Any:
        # What a browser sends may be anything: of a message that nobody understands, nobody needs a traceback.
        asyncio.get_running_loop().set_exception_handler(_log)
        logger = logging.getLogger("scenecc.viewer.server")
        logger.disabled = True
        # Pages of other sites, open in the same browser, do not talk to a loopback address; a program names no origin.
        origins = [_OWN_PAGE, None] if self._place.is_local else None
        handler = partial(self._process, process_request)
        return self._serve(*given, process_request=handler, origins=origins, logger=logger, **options)

    def _process(self, process: Any, connection: ServerConnection, request: Request) -> Any:
        """Answers a request, or lets its WebSocket be opened (None). A page gives its token back as a cookie."""
        token, name = self._place.token, f"scenecc-{connection.local_address[1]}"
        given = parse_qs(urlsplit(request.path).query).get("token", [""])[0]
        if token is not None:
            cookies = SimpleCookie()
            with suppress(CookieError):
                cookies.load("; ".join(request.headers.get_all("Cookie")))
            told = given or (unquote(cookies[name].value) if name in cookies else "")
            # Compared in a time that tells nothing of where they differ.
            if not compare_digest(token.encode(), told.encode(errors="replace")):
                return connection.respond(HTTPStatus.FORBIDDEN, "This page needs a token: /?token=...\n")
        response = process(connection, request)
        if token is not None and response is not None and given:
            response.headers["Set-Cookie"] = f"{name}={quote(token, safe='')}; HttpOnly; SameSite=Strict; Path=/"
        return response


def _log(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    del loop
    logging.getLogger("scenecc.viewing").debug(context["message"], exc_info=context.get("exception"))


@contextmanager
def _quiet() -> Generator[None]:
    """Keeps viser's own words from standard output."""
    with redirect_stdout(io.StringIO()):
        yield
