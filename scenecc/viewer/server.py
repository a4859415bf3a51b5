"""The server of a page, and access control."""

from __future__ import annotations

import asyncio
import gzip
import io
import logging
import re
import socket
import threading
from contextlib import contextmanager, redirect_stdout, suppress
from functools import partial
from html import escape
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
"""The default port of a page."""

_OPENING: Final = threading.Lock()
"""Serializes server starts, which patch and redirect global state."""

_OWN_PAGE: Final = re.compile(r"https?://(localhost|127\.[0-9]+\.[0-9]+\.[0-9]+|\[::1\])(:[0-9]+)?")
"""Origins of pages from this machine, on any port, because a tunnel has another port."""


def open_server(place: PageAddress, label: str) -> viser.ViserServer:
    """Returns a server that listens.

    Raises:
        OSError: the address or port is not available.
    """
    port = _free_port(place)
    with _OPENING, _quiet(), patch.object(below, "serve", _Guard(place, label)):
        server = viser.ViserServer(place.host, port, label, verbose=False)
    # Any page may ask viser to publish itself through a server on the internet.
    server.request_share_url = _refuse
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stops the server without viser's message."""
    with interrupts_wait(), _quiet():
        server.stop()


def _refuse(verbose: bool = True) -> None:  # noqa: FBT001, FBT002 - viser's own signature
    del verbose


def _free_port(place: PageAddress) -> int:
    """Returns a free port. viser itself would try a thousand ports, and hang for a wrong address."""
    wanted = range(_FIRST, _FIRST + 100) if place.port is None else (place.port,)
    for port in wanted[:-1]:
        with suppress(OSError):
            return _bound(place.host, port)
    return _bound(place.host, wanted[-1])


def _bound(host: str, port: int) -> int:
    """Returns the port that is bound when this one is requested. Raises OSError."""
    try:
        host.encode("idna")
    except UnicodeError as error:
        raise OSError(f"it cannot be a host name: {error}") from error
    with socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
        return int(probe.getsockname()[1])


class _Guard:
    """Wraps viser's WebSocket library to restrict access.

    viser has no access control, but the library below it does.
    """

    def __init__(self, place: PageAddress, title: str) -> None:
        self._place = place
        self._title = title
        self._pages: dict[str, bytes] = {}
        self._serve: Any = below.serve

    def __call__(self, *given: Any, process_request: Any, **options: Any) -> Any:
        # A browser may send anything. Invalid messages need no traceback.
        asyncio.get_running_loop().set_exception_handler(_log)
        logger = logging.getLogger("scenecc.viewer.page")
        logger.disabled = True
        # Pages of other sites in the same browser must not reach a loopback address. Programs send no origin.
        origins = [_OWN_PAGE, None] if self._place.is_local else None
        handler = partial(self._process, process_request)
        return self._serve(*given, process_request=handler, origins=origins, logger=logger, **options)

    def _process(self, process: Any, connection: ServerConnection, request: Request) -> Any:
        """Answers a request, or returns None to open its WebSocket. A page returns its token as a cookie."""
        token, name = self._place.token, f"scenecc-{connection.local_address[1]}"
        given = parse_qs(urlsplit(request.path).query).get("token", [""])[0]
        if token is not None:
            cookies = SimpleCookie()
            with suppress(CookieError):
                cookies.load("; ".join(request.headers.get_all("Cookie")))
            sent = given or (unquote(cookies[name].value) if name in cookies else "")
            # Compare in constant time.
            if not compare_digest(token.encode(), sent.encode(errors="replace")):
                return connection.respond(HTTPStatus.FORBIDDEN, "This page needs a token: /?token=...\n")
        response = process(connection, request)
        if response is not None and response.headers.get("Content-Type", "").startswith("text/html"):
            self._entitle(response)
        if token is not None and response is not None and given:
            response.headers["Set-Cookie"] = f"{name}={quote(token, safe='')}; HttpOnly; SameSite=Strict; Path=/"
        return response

    def _entitle(self, response: Any) -> None:
        """Sets the page's title; viser has no option for it."""
        encoding = response.headers["Content-Encoding"]
        if encoding not in self._pages:
            zipped = encoding == "gzip"
            body = titled((gzip.decompress(response.body) if zipped else response.body).decode(), self._title).encode()
            self._pages[encoding] = gzip.compress(body, 1) if zipped else body
        response.body = self._pages[encoding]
        del response.headers["Content-Length"]
        response.headers["Content-Length"] = str(len(response.body))


def titled(page: str, title: str) -> str:
    """Returns viser's page with another title, and without the fade-in that every loop of a recording begins again."""
    return page.replace("<title>Viser</title>", f"<title>{escape(title)}</title>{_NO_FADE}", 1)


def _log(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    del loop
    logging.getLogger("scenecc.viewing").debug(context["message"], exc_info=context.get("exception"))


@contextmanager
def _quiet() -> Generator[None]:
    """Suppresses viser's messages on standard output."""
    with redirect_stdout(io.StringIO()):
        yield


_NO_FADE: Final = "<style>canvas{opacity:1!important}</style>"
