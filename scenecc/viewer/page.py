"""The page: its server, access control, and content."""

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
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from itertools import combinations, product
from secrets import compare_digest
from typing import TYPE_CHECKING, Any, Final
from unittest.mock import patch
from urllib.parse import parse_qs, quote, unquote, urlsplit

import numpy as np
import viser
import websockets.asyncio.server as below

from scenecc.geometry.rotations import to_pose, to_vector
from scenecc.interrupt import interrupts_wait
from scenecc.plan.rendering import FRAMING_DIRECTION
from scenecc.viewer.cameras import BrowserView
from scenecc.viewer.head import titled
from scenecc.viewer.lights import PageLight
from scenecc.viewer.nodes import BodyPoses, Frame, Instances, Name, SurfaceNode

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Mapping, Sequence

    from numpy.typing import NDArray
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request

    from scenecc.geometry.rotations import Pose7, Vec3
    from scenecc.viewer.nodes import Key, Node, PageContent
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


def _log(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    del loop
    logging.getLogger("scenecc.viewing").debug(context["message"], exc_info=context.get("exception"))


@contextmanager
def _quiet() -> Generator[None]:
    """Suppresses viser's messages on standard output."""
    with redirect_stdout(io.StringIO()):
        yield


_AXES_LENGTH, _AXES_RADIUS = 0.1, 0.003
"""Size of the axes of a body [m]."""

_AROUND, _BRIGHT = 0.4, 1.5
"""Intensity of ambient light and of a distant lamp: faces pointing up show about their own colour."""

_LAMP: Final = PageLight("directional", (255, 255, 255), _BRIGHT, (0.8, -0.5, 1.2), shadow=True)

_FOV: Final = float(np.radians(75))
"""Vertical field of view of viser's camera [rad]."""

_DISTANCE: Final = 1.3 / np.sin(_FOV / 2)
"""Distance of a camera, in radii of the content: panels cover some of it."""

_OUTLINE, _GIZMO = "/selected", "/gizmo"
"""Paths of the selection outline and the gizmo."""

_WARNED, _TOUCHES = "/overlap ", "/contacts"

_ORANGE, _RED = (255, 120, 0), (224, 30, 30)

_LONGEST: Final = 0.3
"""Length of the arrow of the largest force, in radii of all content."""

_SMALLEST: Final = 0.15
"""Minimum size of a gizmo, in radii of all content: a smaller one is hard to hit."""

_FARTHEST, _TURNED = 1e6, 0.5
"""Maximum drag distance of a body [m], and minimum norm of a valid quaternion."""

Box = tuple["NDArray[np.float64]", "NDArray[np.float64]"]
"""Lower and upper corner [m]."""


def _edges(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
    """(12, 2, 3) edges of a box."""
    corners = list(product(*zip(low, high, strict=True)))
    pairs = combinations(corners, 2)
    return np.array([pair for pair in pairs if sum(a != b for a, b in zip(*pair, strict=True)) == 1], np.float64)


class Page:
    """Content of a server. Only changes are sent, and nothing moves a browser's camera.

    Ctrl-C waits for the end of each method: otherwise viser's state could differ from the one kept here.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        clicked: Callable[[Key], None] | None = None,
        dragged: Callable[[Key, Pose7, bool], None] | None = None,
    ) -> None:
        """Both callbacks run in a viser thread.

        Args:
            server: the server that shows it.
            clicked: called with the clicked body.
            dragged: called with a body, its new pose in its scene, and whether the drag has ended.
        """
        self._server = server
        self._clicked = clicked
        self._dragged = dragged
        self._marks: dict[str, tuple[Key, Any]] = {}
        self._outlined: Key | None = None
        self._touches: Any = None
        self._origins: Mapping[int, Vec3] = {}
        self._nodes: dict[str, Node] = {}
        self._handles: dict[str, Any] = {}
        self._bodies: Mapping[Key, str] = {}
        self._poses = BodyPoses.of({}, {})
        self._overview, self._radius = overview(np.zeros((0, 3))), 1.0
        self._views: Mapping[str, BrowserView] = {}
        # viser's own lights are so bright that they distort the file's colours.
        server.scene.configure_default_lights(enabled=False)
        self._lit: tuple[tuple[PageLight, ...], bool] | None = None
        self._lights: list[Any] = []
        self._light_up((), shadows=True)

    @property
    def digests(self) -> set[str]:
        """Digests of the displayed files."""
        return {node.digest for node in self._nodes.values() if isinstance(node, SurfaceNode | Instances)}

    @interrupts_wait()
    def show(self, picture: PageContent, contents: Mapping[str, bytes]) -> None:
        """Replaces the displayed content. `contents`: its files, by digest."""
        self._light_up(picture.lights, shadows=picture.shadows)
        with self._server.atomic():
            for path in [path for path in self._nodes if path not in picture.nodes]:
                self._remove(path)
            self._bodies, self._poses, self._origins = picture.bodies, picture.poses, picture.origins
            for path, node in picture.nodes.items():
                self._put_node(path, node, contents)
            self._follow()
        self._overview, self._radius = overview(picture.corners), bounds(picture.corners)[1]
        self._views = {view.name: view for view in picture.views}
        self._server.flush()

    def _light_up(self, lights: tuple[PageLight, ...], *, shadows: bool) -> None:
        """Replaces the lights if they differ. Without any, the page has neutral light: ambient and a distant lamp."""
        if (lights, shadows) == self._lit:
            return
        for handle in self._lights:
            handle.remove()
        scene = self._server.scene
        if self._lit is None or bool(lights) != bool(self._lit[0]):
            scene.configure_environment_map(environment_intensity=0 if lights else _AROUND)
        self._lit = (lights, shadows)
        self._lights = [
            light.add(scene, f"/light {number}", shadows=shadows) for number, light in enumerate(lights or (_LAMP,))
        ]

    @interrupts_wait()
    def move(self, keys: Sequence[Key], poses: NDArray[np.float32]) -> None:
        """Moves bodies. `poses`: (N, 7) p [m] then q (wxyz), in their scenes."""
        with self._server.atomic():
            for key, pose in zip(keys, poses.tolist(), strict=True):
                if key in self._bodies:
                    handle = self._handles[self._bodies[key]]
                    handle.position, handle.wxyz = pose[:3], pose[3:]
            before, self._poses = self._poses, self._poses.moved(keys, poses)
            moved = (before.world != self._poses.world).any(axis=1)
            for path, node in self._nodes.items():
                if isinstance(node, Instances) and moved[node.rows].any():
                    self._place(self._handles[path], node)
            self._follow()
        self._server.flush()

    @interrupts_wait()
    def outline(self, key: Key | None, box: Box | None) -> None:
        """Draws a box around a body, in its frame, and names the links of its articulation; None: no box."""
        self._unmark(_OUTLINE)
        self._outlined = key
        for path, node in self._nodes.items():
            if isinstance(node, Name) and self._handles[path].visible != node.is_shown(key):
                self._handles[path].visible = node.is_shown(key)
        if key is not None and box is not None:
            self._mark(_OUTLINE, key, box, _ORANGE)

    @interrupts_wait()
    def warn(self, boxes: Mapping[Key, Box]) -> None:
        """Draws red boxes around bodies, replacing the last ones."""
        for path in [path for path in self._marks if path.startswith(_WARNED)]:
            self._unmark(path)
        for number, (key, box) in enumerate(boxes.items()):
            self._mark(f"{_WARNED}{number}", key, box, _RED)

    @interrupts_wait()
    def touch(self, scenes: NDArray[np.int64], points: NDArray[np.float32], forces: NDArray[np.float32]) -> None:
        """Draws arrows for forces (N, 3) at points (N, 3) [m] of scenes (N,), replacing the last ones."""
        if self._touches is not None:
            self._touches.remove()
            self._touches = None
        sizes = np.linalg.norm(forces, axis=1)
        if not len(sizes):
            return
        starts = points + np.array([self._origins[index] for index in scenes.tolist()])
        unit = _LONGEST * self._radius
        arrows = np.stack([starts, starts + forces * (unit / sizes.max())], axis=1)
        self._touches = self._server.scene.add_arrows(
            _TOUCHES, arrows, _RED, shaft_radius=unit / 50, head_radius=unit / 20, head_length=unit / 8
        )

    @interrupts_wait()
    def hold(self, key: Key | None, size: float) -> None:
        """Adds a gizmo to drag a body; None: removes it. `size`: size of the body [m]."""
        self._unmark(_GIZMO)
        if key is None or self._dragged is None:
            return
        dragged, origin = self._dragged, self._poses.origins[self._poses.rows[key]]
        handle = self._server.scene.add_transform_controls(
            _GIZMO, scale=max(size, _SMALLEST * self._radius), depth_test=False
        )
        self._marks[_GIZMO] = (key, handle)
        self._follow()

        async def update(event: viser.TransformControlsEvent) -> None:
            pose = np.concatenate([event.target.position - origin, event.target.wxyz])
            # A browser may send anything.
            if np.isfinite(pose).all() and np.abs(pose[:3]).max() < _FARTHEST and np.linalg.norm(pose[3:]) > _TURNED:
                dragged(key, to_pose(pose), event.phase == "end")

        handle.on_update(update)

    def _follow(self) -> None:
        """Moves the outline and the gizmo to their bodies, and removes those of missing bodies."""
        for path, (key, handle) in [*self._marks.items()]:
            row = self._poses.rows.get(key)
            if row is None:
                self._unmark(path)
            else:
                handle.position, handle.wxyz = self._poses.world[row, :3], self._poses.world[row, 3:]

    def _mark(self, path: str, key: Key, box: Box, color: tuple[int, int, int]) -> None:
        lines = self._server.scene.add_line_segments(path, _edges(*box), color, thickness=3, thickness_units="screen")
        self._marks[path] = (key, lines)
        self._follow()

    def _unmark(self, path: str) -> None:
        if path in self._marks:
            self._marks.pop(path)[1].remove()

    @interrupts_wait()
    def open_at(self, view: BrowserView | None = None) -> None:
        """Sets the initial view of browsers that connect from now on; None: an overview."""
        self._look_from(self._server.initial_camera, view or self._overview)

    @interrupts_wait()
    def frame(self, browsers: Iterable[viser.ClientHandle], name: str = "") -> None:
        """Moves the cameras of browsers to a view."""
        for browser in browsers:
            # A new browser has not sent its camera yet, which viser needs first.
            with suppress(AssertionError):
                self._look_from(browser.camera, self._views.get(name, self._overview))

    @interrupts_wait()
    def frame_all(self) -> None:
        """Moves the cameras of all browsers to an overview."""
        self.frame(self._server.get_clients().values())
        self.open_at()

    def _look_from(self, camera: Any, view: BrowserView) -> None:
        camera.position, camera.look_at, camera.fov = view.position, view.look_at, view.fov

    def _remove(self, path: str) -> None:
        handle = self._handles.pop(path)
        del self._nodes[path]
        # Nodes below a removed node are removed too.
        if self._server.scene.get_handle_by_name(path) is handle:
            handle.remove()

    def _put_node(self, path: str, node: Node, contents: Mapping[str, bytes]) -> None:
        before = self._nodes.get(path)
        handle: Any = self._handles.get(path)
        if isinstance(node, Frame) and isinstance(before, Frame):
            # Needed even for an unchanged pose, because a body may have moved since.
            handle.position, handle.wxyz, handle.show_axes = node.position, node.wxyz, node.axes
        elif isinstance(node, Instances) and isinstance(before, Instances) and node.is_moved(before):
            handle.batched_scales = node.scales
            self._place(handle, node)
        elif node == before:
            return
        elif isinstance(node, SurfaceNode) and isinstance(before, SurfaceNode) and node.is_moved(before):
            handle.position, handle.wxyz, handle.scale = node.position, node.wxyz, node.scale
        else:
            handle = self._add_node(path, node, contents)
        self._nodes[path], self._handles[path] = node, handle

    def _place(self, handle: Any, node: Instances) -> None:
        """Moves instances to their bodies; viser sends arrays that have changed."""
        poses = node.poses(self._poses)
        handle.batched_positions, handle.batched_wxyzs = poses[:, :3], poses[:, 3:]

    def _add_node(self, path: str, node: Node, contents: Mapping[str, bytes]) -> Any:
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
        if isinstance(node, Instances):
            return self._added_instances(path, node, contents[node.digest])
        if isinstance(node, Name):
            shown = node.is_shown(self._outlined)
            return scene.add_label(path, node.text, position=node.position, anchor="center-center", visible=shown)
        handle = scene.add_glb(path, contents[node.digest], scale=node.scale, position=node.position, wxyz=node.wxyz)
        if self._clicked is not None:
            clicked, body = self._clicked, node.body
            handle.on_click(lambda _: clicked(body))
        return handle

    def _added_instances(self, path: str, node: Instances, content: bytes) -> Any:
        poses = node.poses(self._poses)
        handle = self._server.scene.add_batched_glb(
            path,
            content,
            batched_wxyzs=poses[:, 3:],
            batched_positions=poses[:, :3],
            batched_scales=node.scales,
            lod="off",
        )
        if self._clicked is not None:
            handle.on_click(lambda event: self._click_instance(path, event.instance_index))
        return handle

    def _click_instance(self, path: str, number: Any) -> None:
        """A browser may send any number, and the node may have changed since."""
        node = self._nodes.get(path)
        if self._clicked is None or not isinstance(node, Instances) or not isinstance(number, int):
            return
        if 0 <= number < len(node.rows):
            self._clicked(self._poses.key(int(node.rows[number])))


def bounds(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Returns the centre of points (N, 3), and the radius of the ball around them [m]; without points, those of a 1 m
    cube.
    """
    low, high = (corners.min(axis=0), corners.max(axis=0)) if len(corners) else (np.full(3, -0.5), np.full(3, 0.5))
    return (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 0.05)


def overview(corners: NDArray[np.float64]) -> BrowserView:
    """Returns a view that contains all points (N, 3) [m], as in SAPIEN's pictures."""
    middle, radius = bounds(corners)
    back = np.array(FRAMING_DIRECTION) / np.linalg.norm(FRAMING_DIRECTION)
    return BrowserView("", to_vector(middle + _DISTANCE * radius * back), to_vector(middle), _FOV)
