"""The page: its server, the access to it, and its content."""

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

import numpy as np
import viser
import websockets.asyncio.server as below

from scenecc.interrupt import interrupts_wait
from scenecc.plan.rendering import FRAMING_DIRECTION
from scenecc.viewer.nodes import Frame, SurfaceNode

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Mapping, Sequence

    from numpy.typing import NDArray
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request

    from scenecc.viewer.nodes import Key, Node, PageContent
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
        logger = logging.getLogger("scenecc.viewer.page")
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
            sent = given or (unquote(cookies[name].value) if name in cookies else "")
            # Compared in a time that tells nothing of where they differ.
            if not compare_digest(token.encode(), sent.encode(errors="replace")):
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


_AXES_LENGTH, _AXES_RADIUS = 0.1, 0.003
"""Of the axes of a body [m]."""

_AROUND, _BRIGHT = 0.4, 1.5
"""How strong the light from all sides is, and a lamp far away: what faces up has about its own colour."""

_FROM: Final = (0.8, -0.5, 1.2)
"""Where the lamp stands."""

_DISTANCE: Final = 1.3 / np.sin(np.radians(75 / 2))
"""Of a camera, in radii of what it sees: viser's camera sees 75° from top to bottom, and panels cover some of it."""


class Page:
    """What a server shows. Only what differs from before is sent, and nothing moves the camera of a browser.

    Ctrl-C waits for the end of each function: what viser was half told would not be what is kept here.
    """

    def __init__(self, server: viser.ViserServer, clicked: Callable[[Key], None] | None = None) -> None:
        """`clicked` is called with the body that was clicked, in a thread of viser."""
        self._server = server
        self._clicked = clicked
        self._nodes: dict[str, Node] = {}
        self._handles: dict[str, Any] = {}
        self._bodies: Mapping[Key, str] = {}
        self._overview = overview(np.zeros((0, 3)))
        # viser's own lights are so bright that colours are hardly the file's.
        server.scene.configure_default_lights(enabled=False)
        server.scene.configure_environment_map(environment_intensity=_AROUND)
        self._light = server.scene.add_light_directional("/light", intensity=_BRIGHT, position=_FROM)

    @property
    def digests(self) -> set[str]:
        """Of the files that are shown."""
        return {node.digest for node in self._nodes.values() if isinstance(node, SurfaceNode)}

    @interrupts_wait()
    def show(self, picture: PageContent, contents: Mapping[str, bytes]) -> None:
        """Shows a picture in place of the one before. `contents`: of its files, by digest."""
        self._light.cast_shadow = picture.shadows
        with self._server.atomic():
            for path in [path for path in self._nodes if path not in picture.nodes]:
                self._remove(path)
            for path, node in picture.nodes.items():
                self._put(path, node, contents)
        self._bodies = picture.bodies
        self._overview = overview(picture.corners)
        self._server.flush()

    @interrupts_wait()
    def move(self, keys: Sequence[Key], poses: NDArray[np.float32]) -> None:
        """Puts bodies elsewhere. `poses`: (N, 7) p [m] then q (wxyz), in their scenes."""
        with self._server.atomic():
            for key, pose in zip(keys, poses.tolist(), strict=True):
                handle = self._handles[self._bodies[key]]
                handle.position, handle.wxyz = pose[:3], pose[3:]
        self._server.flush()

    @interrupts_wait()
    def frame(self, browser: viser.ClientHandle | None = None) -> None:
        """Puts a browser's camera where it sees all that is shown. None: that of those that come from now on."""
        camera = self._server.initial_camera if browser is None else browser.camera
        camera.position, camera.look_at = self._overview

    def _remove(self, path: str) -> None:
        handle = self._handles.pop(path)
        del self._nodes[path]
        # What is below a node goes with it.
        if self._server.scene.get_handle_by_name(path) is handle:
            handle.remove()

    def _put(self, path: str, node: Node, contents: Mapping[str, bytes]) -> None:
        before = self._nodes.get(path)
        handle: Any = self._handles.get(path)
        if isinstance(node, Frame) and isinstance(before, Frame):
            # Also where it is to be where it was: a body may have moved since.
            handle.position, handle.wxyz, handle.show_axes = node.position, node.wxyz, node.axes
        elif node == before:
            return
        elif isinstance(node, SurfaceNode) and isinstance(before, SurfaceNode) and node.is_moved(before):
            handle.position, handle.wxyz, handle.scale = node.position, node.wxyz, node.scale
        else:
            handle = self._added(path, node, contents)
        self._nodes[path], self._handles[path] = node, handle

    def _added(self, path: str, node: Node, contents: Mapping[str, bytes]) -> Any:
        scene = self._server.scene
        if isinstance(node, Frame):
            return scene.add_frame(
                path,
                show_axes=node.axes,
                axes_length=_AXES_LENGTH,
                axes_radius=_AXES_RADIUS,
                position=node.position,
                wxyz=node.wxyz,
            )
        if not isinstance(node, SurfaceNode):
            return scene.add_label(path, node.text)
        handle = scene.add_glb(path, contents[node.digest], scale=node.scale, position=node.position, wxyz=node.wxyz)
        if self._clicked is not None:
            clicked, body = self._clicked, node.body
            handle.on_click(lambda _: clicked(body))
        return handle


def overview(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where a camera stands that sees all of these points (N, 3), and what it looks at [m]: as SAPIEN's pictures do."""
    low, high = (corners.min(axis=0), corners.max(axis=0)) if len(corners) else (np.full(3, -0.5), np.full(3, 0.5))
    middle, radius = (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 0.05)
    back = np.array(FRAMING_DIRECTION) / np.linalg.norm(FRAMING_DIRECTION)
    return middle + _DISTANCE * radius * back, middle
