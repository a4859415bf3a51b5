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
from websockets.datastructures import Headers
from websockets.http11 import Request, Response
from websockets.server import ServerProtocol

from scenecc.interrupt import interrupts_wait
from scenecc.viewer.head import titled

if TYPE_CHECKING:
    from scenecc.viewer.options import PageAddress


_FIRST: Final = 8080
"""The default port of a page."""

_OWN_PAGE: Final = re.compile(r"https?://(localhost|127\.[0-9]+\.[0-9]+\.[0-9]+|\[::1\])(:[0-9]+)?")
"""Origins of pages from this machine, on any port, because a tunnel has another port."""

_TIMEOUT: Final = 10.0
"""Maximum time to receive a request [s]."""

_CHUNK: Final = 1 << 18
"""Number of bytes that are passed on at once, and maximum size of a request."""

_STOP: Final = 1.0
"""Maximum time to disconnect browsers [s]."""

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
        self._connections: set[asyncio.Task[None]] = set()
        self._front = asyncio.run_coroutine_threadsafe(self._serve(listener), loop).result()

    @interrupts_wait()
    def close(self) -> None:
        """Disconnects browsers, and stops."""
        with suppress(FutureTimeoutError):
            asyncio.run_coroutine_threadsafe(self._end(), self.viser.get_event_loop()).result(_STOP)
        self.viser.stop()
        _BELOW.removeFilter(self._is_foreign)

    async def _serve(self, listener: socket.socket) -> asyncio.Server:
        return await asyncio.start_server(self._accept, sock=listener, limit=_CHUNK)

    async def _end(self) -> None:
        self._front.close()
        for task in [*self._connections]:
            task.cancel()
        await asyncio.gather(*self._connections, return_exceptions=True)

    async def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answers the request of a new connection, or connects it to viser."""
        task = asyncio.current_task()
        assert task is not None
        self._connections.add(task)
        try:
            # A browser may send anything, and leave at any time.
            with suppress(OSError, EOFError, asyncio.LimitOverrunError, asyncio.TimeoutError):
                head = await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), _TIMEOUT)
                # Pages of other sites in the same browser must not reach a loopback address. Programs send no origin.
                protocol = ServerProtocol(origins=[_OWN_PAGE, None] if self._place.is_local else None)
                protocol.receive_data(head)
                for request in protocol.events_received():
                    assert isinstance(request, Request)
                    response = self._respond(protocol, request)
                    if response.status_code == HTTPStatus.SWITCHING_PROTOCOLS:
                        await self._relay(head, reader, writer)
                    else:
                        protocol.send_response(response)
                        writer.writelines(protocol.data_to_send())
                        await writer.drain()
        finally:
            writer.close()
            self._connections.discard(task)

    async def _relay(self, head: bytes, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Passes bytes in both directions, from a request on, until one side ends the connection."""
        below, above = await asyncio.open_connection(self.viser.get_host(), self.viser.get_port(), limit=_CHUNK)
        above.write(head)
        both = [asyncio.ensure_future(_pass_on(*ends)) for ends in ((reader, above), (below, writer))]
        try:
            await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for one in both:
                one.cancel()
            await asyncio.gather(*both, return_exceptions=True)
            above.close()

    def _respond(self, protocol: ServerProtocol, request: Request) -> Response:
        """Returns the response to a request. A page returns its token as a cookie."""
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
                return protocol.reject(HTTPStatus.FORBIDDEN, "This page needs a token: /?token=...\n")
        if request.headers.get("Upgrade") == "websocket":
            return protocol.accept(request)
        if url.path not in {"/", "/index.html"}:
            return protocol.reject(HTTPStatus.NOT_FOUND, "There is only one page here: /\n")
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


async def _pass_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while data := await reader.read(_CHUNK):
        writer.write(data)
        await writer.drain()


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
