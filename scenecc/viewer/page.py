"""The content of a page."""

from __future__ import annotations

from contextlib import suppress
from itertools import combinations, product
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.geometry.rotations import to_pose, to_vector
from scenecc.interrupt import interrupts_wait
from scenecc.plan.rendering import FRAMING_DIRECTION
from scenecc.viewer.cameras import BrowserView
from scenecc.viewer.lights import PageLight
from scenecc.viewer.nodes import BodyPoses, Frame, Instances, Name, SurfaceNode

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    import viser
    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Pose7, Vec3
    from scenecc.viewer.nodes import Key, Node, PageContent


_AXES_LENGTH, _AXES_RADIUS = 0.1, 0.003
"""Size of the axes of a body [m]."""

_AROUND, _BRIGHT = 0.4, 1.5
"""Intensity of ambient light and of a distant lamp: faces pointing up show about their own colour."""

_LAMP: Final = PageLight("directional", (255, 255, 255), _BRIGHT, (0.8, -0.5, 1.2), shadow=True)

_FOV: Final = float(np.radians(75))
"""Vertical field of view of viser's camera [rad]."""

_UNPLACED: Final = (-5.0, 0.0, 0.0)
"""Position that a new browser reports before it has placed its camera [m]."""

_DISTANCE: Final = 1.3 / np.sin(_FOV / 2)
"""Distance of a camera, in radii of the content: panels cover some of it."""

_OUTLINE, _GIZMO = "/selected", "/gizmo"
"""Paths of the selection outline and the gizmo."""

_WARNED, _TOUCHES = "/overlap ", "/contacts"

_ORANGE, _RED = (255, 120, 0), (224, 30, 30)

_LONGEST: Final = 0.3
"""Length of the arrow of the largest force, in radii of all content."""

_GIZMO_SIZE: Final = 120
"""Length of the arrows of a gizmo [px]."""

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
        self._opened: list[BrowserView] = []
        self.open_at()
        server.on_client_connect(self._meet)

    @property
    def files(self) -> set[str]:
        """Names of the displayed files."""
        return {node.file for node in self._nodes.values() if isinstance(node, SurfaceNode | Instances)}

    @interrupts_wait()
    def show(self, picture: PageContent, contents: Mapping[str, bytes]) -> None:
        """Replaces the displayed content. `contents`: its files, by name."""
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
    def hold(self, key: Key | None) -> None:
        """Adds a gizmo to drag a body; None: removes it."""
        self._unmark(_GIZMO)
        if key is None or self._dragged is None:
            return
        dragged, origin = self._dragged, self._poses.origins[self._poses.rows[key]]
        handle = self._server.scene.add_transform_controls(_GIZMO, scale=_GIZMO_SIZE, fixed=True, depth_test=False)
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
        """Sets the initial view of browsers; None: an overview. A browser that left its initial view is not moved."""
        self._opened.append(view or self._overview)
        self._look_from(self._server.initial_camera, self._opened[-1])
        for browser in self._server.get_clients().values():
            self._meet(browser)

    def _meet(self, browser: viser.ClientHandle) -> None:
        """Moves a browser that is still at an earlier initial view: it connected before the scenes were built."""
        *earlier, current = self._opened
        with suppress(AssertionError):
            place = browser.camera.position
            if any(np.allclose(place, known, atol=1e-3) for known in (_UNPLACED, *(view.position for view in earlier))):
                self._look_from(browser.camera, current)

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
            if node.colors is not None:
                handle.batched_colors = _bytes(node.colors)
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
            return self._added_instances(path, node, contents)
        if isinstance(node, Name):
            shown = node.is_shown(self._outlined)
            return scene.add_label(path, node.text, position=node.position, anchor="center-center", visible=shown)
        handle = scene.add_glb(path, contents[node.file], scale=node.scale, position=node.position, wxyz=node.wxyz)
        if self._clicked is not None:
            clicked, body = self._clicked, node.body
            handle.on_click(lambda _: clicked(body))
        return handle

    def _added_instances(self, path: str, node: Instances, contents: Mapping[str, bytes]) -> Any:
        def click(event: Any) -> None:
            self._click_instance(path, event.instance_index)

        scene, poses = self._server.scene, node.poses(self._poses)
        copies: dict[str, Any] = {
            "batched_wxyzs": poses[:, 3:],
            "batched_positions": poses[:, :3],
            "batched_scales": node.scales,
            "lod": "off",
        }
        if node.surface is None or node.colors is None:
            handle: Any = scene.add_batched_glb(path, contents[node.file], **copies)
        else:
            # All are equally transparent.
            copies |= {"batched_colors": _bytes(node.colors), "opacity": float(node.colors[0, 3])}
            handle = scene.add_batched_meshes_simple(path, node.surface.vertices, node.surface.faces, **copies)
        if self._clicked is not None:
            handle.on_click(click)
        return handle

    def _click_instance(self, path: str, number: Any) -> None:
        """A browser may send any number, and the node may have changed since."""
        node = self._nodes.get(path)
        if self._clicked is None or not isinstance(node, Instances) or not isinstance(number, int):
            return
        if 0 <= number < len(node.rows):
            self._clicked(self._poses.key(int(node.rows[number])))


def _bytes(colors: NDArray[np.float64]) -> NDArray[np.uint8]:
    """(N, 3) colours of copies; viser takes them as linear."""
    return np.round(255 * colors[:, :3].clip(0, 1)).astype(np.uint8)


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
