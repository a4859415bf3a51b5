"""From a source to pictures, top to bottom."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from typing_extensions import Unpack

from scenecc.diagnostics import Location, Sink
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, Options, integer
from scenecc.pictures.encode import WHATS, What
from scenecc.pictures.packages import INSTALL, missing
from scenecc.pipeline import Source, compiled, instantiated
from scenecc.plan.fields import PIXELS
from scenecc.plan.pictured import seen_by
from scenecc.rendering.setup import set_up, stop
from scenecc.rendering.studio import Studio
from scenecc.rendering.taken import Rendering

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.pictures.write import Film


def render_scene(
    source: Source,
    *,
    camera: str | None = None,
    scenes: str | None = None,
    grid: bool = False,
    size: tuple[int, int] | None = None,
    what: What = "color",
    steps: int = 0,
    film: Film | None = None,
    every: int | None = None,
    collision: bool = False,
    hidden: bool | None = None,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[CompileOptions],
) -> Rendering:
    """Builds scenes, simulates them and takes a picture of each; `scenecc render` writes these.

    Args:
        source: as for `validate`.
        camera: a camera of the file; None: one that frames each scene as it stands at its first picture.
        scenes: of which scenes, as `scene_idxs` of a file: `3`, `0:4`, `0,2`; None: the first that has the camera, or
            all that have it for a `grid`.
        grid: put the pictures on one sheet; so it is whenever there are several scenes.
        size: width and height of each picture [px], in place of the camera's (640 × 480, on a sheet 320 × 240, of one
            that frames the scene).
        what: "color", "depth", "segmentation" or "normal".
        steps: of the simulation, before the picture.
        film: take one over these steps, "mp4" or "gif".
        every: steps from one frame of the film to the next; None: as many as give about 30 a second. It plays as fast
            as the simulation's time goes.
        collision: show what collides, and not what is seen.
        hidden: show what is `hidden` too; None: where the camera is none of the file.
        progress: called with (scenes, steps, frames or pictures done, of how many) as one follows the other.
        options: those of `CompileOptions`.

    Raises:
        SceneError: the scene, the engine or the machine is at fault; there is no such camera or scene, or it does not
            take this picture.
        ValueError: an argument is out of its range.
    """
    _check(what, size, steps, film, every)
    sink = Sink()
    asked = Options.of(**options)
    _need_packages(sink, mp4=film == "mp4")
    found = compiled(source, asked, sink)
    setup = set_up(found.plan, camera, scenes, size, what, sink, grid=grid, film=film is not None)
    plan, timings = seen_by(found.plan, setup.camera, collision=collision), dict(found.timings)
    started = time.perf_counter()
    with instantiated(
        plan, sink, backend="cpu", scene_idxs=setup.scene_idxs, render=True, audit="fast", progress=progress
    ) as batch:
        timings["build"], started = time.perf_counter() - started, time.perf_counter()
        if collision:
            batch.show_collision()
        studio = Studio(batch, setup, what, progress, human=camera is None if hidden is None else hidden)
        try:
            pictures, made = studio.take(steps, film, every)
        except SceneError as error:
            raise SceneError([*sink.diagnostics(), *error.diagnostics]) from error
        except (RuntimeError, OSError) as error:
            sink.report("SC814", f"the picture cannot be made: {error}", plan.origin or Location(None))
            raise SceneError(sink.diagnostics()) from error
        timings["pictures"] = time.perf_counter() - started
    return Rendering(found.plan, camera, what, setup.grid, pictures, *made, sink.diagnostics(), timings)


def _need_packages(sink: Sink, *, mp4: bool) -> None:
    if lacking := missing(mp4=mp4):
        sink.report(
            "SC812", f"pictures need {' and '.join(lacking)}, not installed here", Location("scenecc"), hint=INSTALL
        )
    stop(sink)


def _check(what: str, size: tuple[int, int] | None, steps: int, film: str | None, every: int | None) -> None:
    """Raises ValueError."""
    if what not in WHATS:
        raise ValueError(f"what is one of {', '.join(WHATS)}, not {what!r}")
    if film not in {None, "mp4", "gif"}:
        raise ValueError(f"film is mp4 or gif, not {film!r}")
    for pixels in size or ():
        if not PIXELS.allow(integer(pixels, "a size", 1)):
            raise ValueError(f"a picture has {PIXELS.low} to {PIXELS.high} pixels a side, not {pixels}")
    if integer(steps, "steps", 0) == 0 and film is not None:
        raise ValueError("a film needs steps")
    if every is not None and (film is None or integer(every, "every", 1) > steps):
        raise ValueError("every is for a film, and at most its steps")
