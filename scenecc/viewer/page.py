"""The three-dimensional half of a page: viser's nodes, kept as a picture says."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.interrupt import interrupts_wait
from scenecc.plan.rendering import FRAMING_DIRECTION
from scenecc.viewer.nodes import Frame, Mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import viser
    from numpy.typing import NDArray

    from scenecc.viewer.nodes import Key, Node, PageContent

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
        """`clicked` is told, from a thread of viser's, which body somebody clicks on."""
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
        return {node.digest for node in self._nodes.values() if isinstance(node, Mesh)}

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
        elif isinstance(node, Mesh) and isinstance(before, Mesh) and node.is_moved(before):
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
        if not isinstance(node, Mesh):
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
