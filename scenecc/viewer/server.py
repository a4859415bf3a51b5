"""The server of a page, and access control.

viser has no access control, so it listens where nothing can guess it, on a random loopback address. Browsers connect
to a server in front of it, which checks each request and relays the messages.
"""

from __future__ import annotations

import asyncio
import gzip
import logging
import re
import socket
from concurrent.futures import TimeoutError as FutureTimeoutError
from contextlib import suppress
from functools import cached_property
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from secrets import compare_digest, randbelow
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import parse_qs, quote, unquote, urlsplit

import viser
from websockets.asyncio.client import connect
from websockets.asyncio.server import serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Response

from scenecc.interrupt import interrupts_wait
from scenecc.viewer.head import titled

if TYPE_CHECKING:
    from websockets.asyncio.connection import Connection
    from websockets.asyncio.server import Server, ServerConnection
    from websockets.http11 import Request

    from scenecc.viewer.options import PageAddress


_FIRST: Final = 8080
"""The default port of a page."""

_OWN_PAGE: Final = re.compile(r"https?://(localhost|127\.[0-9]+\.[0-9]+\.[0-9]+|\[::1\])(:[0-9]+)?")
"""Origins of pages from this machine, on any port, because a tunnel has another port."""

_LARGEST: Final = 50 << 20
"""Maximum size of a message of a browser [bytes]."""

_GOODBYE: Final = 1.0
"""Maximum time to disconnect a browser [s]."""

_QUIET: Final = logging.getLogger("scenecc.viewer.server")
"""A browser may send anything. Invalid messages need no traceback."""

_QUIET.disabled = True

_BELOW: Final = logging.getLogger("websockets.server")
"""Where viser's server logs."""


class PageServer:
    """A server for browsers.

    Attributes:
        viser: the server of the page's content.
        port: the port that browsers connect to.
    """

    def __init__(self, place: PageAddress, label: str) -> None:
        """Starts to listen. Raises OSError if the address or port is not available."""
        import rich

        host, listener = _hidden_host(), _listener(place)
        self.port = int(listener.getsockname()[1])
        self._place, self._label = place, label
        # viser prints on rich's console, whatever it is told. A capture holds for one thread: this one, then viser's.
        console = rich.get_console()
        with console.capture():
            self.viser = _Viser(host, 0, label, verbose=False)
        loop = self.viser.get_event_loop()
        loop.call_soon_threadsafe(console.begin_capture)
        loop.call_soon_threadsafe(loop.set_exception_handler, _log)
        _BELOW.addFilter(self._is_foreign)
        self.viser.gui.configure_theme(show_logo=False, show_share_button=False)
        self._front: Server = asyncio.run_coroutine_threadsafe(self._serve(listener), loop).result()

    @interrupts_wait()
    def close(self) -> None:
        """Disconnects browsers, and stops."""
        with suppress(FutureTimeoutError):
            asyncio.run_coroutine_threadsafe(self._end(), self.viser.get_event_loop()).result(_GOODBYE)
        self.viser.stop()
        _BELOW.removeFilter(self._is_foreign)

    async def _serve(self, listener: socket.socket) -> Server:
        return await serve(
            self._relay,
            sock=listener,
            # Pages of other sites in the same browser must not reach a loopback address. Programs send no origin.
            origins=[_OWN_PAGE, None] if self._place.is_local else None,
            process_request=self._process,
            select_subprotocol=lambda _, offered: next(iter(offered), None),
            compression=None,
            max_size=_LARGEST,
            close_timeout=_GOODBYE,
            logger=_QUIET,
        )

    async def _end(self) -> None:
        self._front.close()
        await self._front.wait_closed()

    async def _relay(self, browser: ServerConnection) -> None:
        """Relays messages in both directions until one side closes its connection."""
        below = connect(
            f"ws://{self.viser.get_host()}:{self.viser.get_port()}",
            subprotocols=browser.subprotocol and [browser.subprotocol],
            compression=None,
            max_size=None,
            max_queue=1,  # for a slow browser, viser merges what it has not sent yet
            proxy=None,
            close_timeout=_GOODBYE,
            logger=_QUIET,
        )
        async with below as server:
            await asyncio.gather(_pass_on(browser, server), _pass_on(server, browser))

    def _process(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answers a request, or returns None to open its WebSocket. A page returns its token as a cookie."""
        token, name = self._place.token, f"scenecc-{self.port}"
        url = urlsplit(request.path)
        given = parse_qs(url.query).get("token", [""])[0]
        if token is not None:
            cookies = SimpleCookie()
            with suppress(CookieError):
                cookies.load("; ".join(request.headers.get_all("Cookie")))
            sent = given or (unquote(cookies[name].value) if name in cookies else "")
            # Compare in constant time.
            if not compare_digest(token.encode(), sent.encode(errors="replace")):
                return connection.respond(HTTPStatus.FORBIDDEN, "This page needs a token: /?token=...\n")
        if request.headers.get("Upgrade", "").lower() == "websocket":
            return None
        if url.path not in {"/", "/index.html"}:
            return connection.respond(HTTPStatus.NOT_FOUND, "There is only one page here: /\n")
        zipped = "gzip" in request.headers.get("Accept-Encoding", "")
        headers = Headers(
            {
                "Content-Type": "text/html; charset=utf-8",
                "Content-Encoding": "gzip" if zipped else "identity",
                "Content-Length": str(len(self._zipped if zipped else self._page)),
                "Connection": "close",
            }
        )
        response = Response(HTTPStatus.OK, "OK", headers, self._zipped if zipped else self._page)
        if token is not None and given:
            response.headers["Set-Cookie"] = f"{name}={quote(token, safe='')}; HttpOnly; SameSite=Strict; Path=/"
        return response

    @cached_property
    def _page(self) -> bytes:
        """Viser's page under its title."""
        page = Path(viser.__file__).with_name("client") / "build" / "index.html"
        return titled(page.read_text("utf-8"), self._label).encode()

    @cached_property
    def _zipped(self) -> bytes:
        return gzip.compress(self._page, 1)

    def _is_foreign(self, record: logging.LogRecord) -> bool:
        """Returns whether a record is not of a connection to this server."""
        connection: Any = getattr(record, "websocket", None)
        return connection is None or connection.local_address[:1] != (self.viser.get_host(),)


class _Viser(viser.ViserServer):
    """Any page may ask viser to publish itself through a server on the internet."""

    def request_share_url(self, verbose: bool = True) -> None:  # noqa: FBT001, FBT002 - viser's own signature
        del verbose


async def _pass_on(source: Connection, target: Connection) -> None:
    """Sends the messages of one connection to another, and then closes that."""
    with suppress(ConnectionClosed):
        async for message in source:
            await target.send(message)
    known = source.close_code is not None and source.close_code not in {1005, 1006}
    await target.close(source.close_code if known else 1000, source.close_reason or "")


def _listener(place: PageAddress) -> socket.socket:
    """Returns a socket that listens. Raises OSError."""
    wanted = range(_FIRST, _FIRST + 100) if place.port is None else (place.port,)
    for port in wanted[:-1]:
        with suppress(OSError):
            return _bound(place.host, port)
    return _bound(place.host, wanted[-1])


def _bound(host: str, port: int) -> socket.socket:
    """Returns a socket at a port. Raises OSError."""
    try:
        host.encode("idna")
    except UnicodeError as error:
        raise OSError(f"it cannot be a host name: {error}") from error
    return socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)


def _hidden_host() -> str:
    """Returns a random one of 16 million loopback addresses. Raises OSError if this system does not have it."""
    host = ".".join(["127", *(str(1 + randbelow(254)) for _ in range(3))])
    with socket.create_server((host, 0)):  # viser would hang if it cannot listen there
        return host


def _log(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    del loop
    logging.getLogger("scenecc.viewing").debug(context["message"], exc_info=context.get("exception"))
