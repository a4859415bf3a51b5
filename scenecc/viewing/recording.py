"""A page as a file."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Final

from scenecc.viewing.nodes import Files
from scenecc.viewing.page import Page

if TYPE_CHECKING:
    from collections.abc import Callable

    import viser

    from scenecc.viewing.look import Look
    from scenecc.viewing.world import World

_FRAMES_A_SECOND: Final = 30


def record(
    server: viser.ViserServer,
    world: World,
    look: Look,
    steps: int,
    progress: Callable[[int, int], None] | None = None,
) -> str:
    """One page of HTML with a scene and, if there are steps, its simulation, as fast as its time goes.

    Raises:
        SceneError: a file cannot be shown, a package for it is missing, or the simulation diverges.
    """
    files, page = Files(), Page(server)
    picture = world.picture(look, files)
    page.show(picture, files.contents)
    page.frame()
    recording = server.get_scene_serializer()
    stride = max(1, round(1 / (_FRAMES_A_SECOND * world.timestep)))
    for done in range(0, steps, stride):
        if progress is not None:
            progress(done, steps)
        taken = min(stride, steps - done)
        world.step(taken, check=True)
        recording.insert_sleep(taken * world.timestep)
        page.move(world.keys, world.poses())
    title = f"<title>{escape(world.loaded.plan.name)}</title>"
    return recording.as_html().replace("<title>Viser</title>", title, 1)
