"""Pictures of a scene, against the same by bare SAPIEN in the same process. Needs a device that renders."""

from __future__ import annotations

import time
from collections.abc import Callable
from math import radians
from typing import Any

from benchmarks.paired import Row, Side, alternating, best, ratios
from benchmarks.sources import boxes

BODIES, WIDTH, HEIGHT = 50, 320, 240
PICTURES = 20
FIRST = f"the first picture of {BODIES} boxes, {WIDTH} × {HEIGHT}, from the file / bare SAPIEN"
STARTED = "the same where the renderer runs already / bare SAPIEN"
FURTHER = f"{PICTURES} further pictures, a step between them / bare SAPIEN"
EYE = [-30.0, 0.0, 22.0]


def run(repetitions: int) -> list[Row]:
    """Time from the text to the first picture, and of pictures after that, one step between each."""
    from scenecc.backends.sapien.engine import new_render_system, render_problem

    if (problem := render_problem()) is not None:
        return [Row("render", what, (), note=f"no device renders: {problem}") for what in (FIRST, STARTED, FURTHER)]
    text = viewed_text()
    sides: list[Side] = [ours(text, 1), _by_hand(1)]
    # Nothing holds the renderer, so that each side starts it, as a process does: seconds on a CPU.
    first = alternating(sides, max(3, repetitions // 3))
    held = new_render_system()
    started = alternating(sides, repetitions)
    further = alternating([ours(text, 1 + PICTURES, clock_after=1), _by_hand(1 + PICTURES, clock_after=1)], repetitions)
    del held

    def row(what: str, rounds: list[list[float]], bound: float | None) -> Row:
        return Row("render", what, ratios(rounds, 0, 1), bound, note=f"{best(rounds, 0)}, {best(rounds, 1)} by hand")

    return [row(FIRST, first, 1.1), row(STARTED, started, None), row(FURTHER, further, 1.05)]


def viewed_text() -> str:
    """Boxes that are seen, and a camera that sees them."""
    lines = ["scenecc: 1", "cameras:", "  eye:", f"    pose: {{p: {EYE}, rpy_deg: [0, 40, 0]}}", f"    width: {WIDTH}"]
    lines += [f"    height: {HEIGHT}", "entities:"]
    for number, box in enumerate(boxes(BODIES)):
        lines.append(
            f"  box_{number}: {{pose: {_place(number)}, shapes: [{{type: box, half_size: {list(box.half)}}}]}}"
        )
    return "\n".join(lines) + "\n"


def _place(number: int) -> list[float]:
    """In rows that do not touch one another."""
    return [2.0 * (number % 20) - 20, 2.0 * (number // 20) - 2, 1.0]


def ours(text: str, pictures: int, clock_after: int = 0) -> Side:
    import io

    from scenecc import load_scene

    def work() -> tuple[Callable[[], Any], Callable[[], None], Callable[[], None]]:
        batch = load_scene(io.StringIO(text), render=True)
        eye = batch.cameras["eye"]
        return lambda: eye.capture("color")["color"], batch.step, batch.close

    return _clocked(work, pictures, clock_after)


def _by_hand(pictures: int, clock_after: int = 0) -> Side:
    import sapien

    def work() -> tuple[Callable[[], Any], Callable[[], None], Callable[[], None]]:
        scene = sapien.Scene()
        scene.set_ambient_light([0.3, 0.3, 0.3])
        scene.add_directional_light([1, 1, -1], [1, 1, 1])
        scene.add_directional_light([0, 0, -1], [1, 1, 1])
        for number, box in enumerate(boxes(BODIES)):
            builder = scene.create_actor_builder()
            builder.add_box_collision(half_size=box.half)
            builder.add_box_visual(half_size=box.half)
            builder.initial_pose = sapien.Pose(_place(number))
            builder.build(name=f"box_{number}")
        camera = scene.add_camera("eye", WIDTH, HEIGHT, radians(60), 0.01, 100)
        camera.get_entity().set_pose(sapien.Pose(EYE, [0.9396926, 0, 0.3420201, 0]))

        def take() -> Any:
            scene.update_render()
            camera.take_picture()
            return camera.get_picture("Color")

        return take, scene.step, scene.clear

    return _clocked(work, pictures, clock_after)


def _clocked(work: Callable[[], tuple[Any, Any, Any]], pictures: int, clock_after: int) -> Side:
    """Builds a scene and takes pictures with a step between them; the clock starts once `clock_after` are taken."""

    def side() -> float:
        started = time.perf_counter()
        take, step, close = work()
        for number in range(pictures):
            if number == clock_after:
                started = started if clock_after == 0 else time.perf_counter()
            if number:
                step()
            take()
        seconds = time.perf_counter() - started
        close()
        return seconds

    return side
