"""What scenecc takes, by itself: `python -m benchmarks.own NAME` prints seconds of the package that `PYTHONPATH` names.

Only public names are used, so that the same code runs with the package of another commit.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from inspect import signature
from pathlib import Path
from typing import Any

from benchmarks import live, reading, render, vary
from benchmarks.instantiate import BODIES, SCENES
from benchmarks.paired import Side, collector_off, collector_on, timed
from benchmarks.process import REFERENCE, THREE_LINES, environment
from benchmarks.sources import plain_scene_text, scene_text

VARIED_SCENES = 1024
LEAST_SECONDS, LEAST_TIMES = 1.0, 2
"""A side runs as long and as often as this at least."""


def measure(name: str) -> dict[str, float]:
    """What was measured → the least seconds that it took. Nothing where something is missing that it needs."""
    return _processes() if name == "process" else {what: _least(side) for what, side in SIDES[name]().items()}


def _least(side: Side) -> float:
    """Once to warm up, then a few times; the least is what other work on the machine disturbs least."""
    found: list[float] = []
    with collector_off():
        side()
        while len(found) < LEAST_TIMES or sum(found) < LEAST_SECONDS:
            found.append(side())
    return min(found)


def _validate() -> dict[str, Side]:
    from scenecc import validate

    text = scene_text(reading.ENTITIES)
    return {f"validate {reading.ENTITIES} entities": _cpu(lambda: validate(io.StringIO(text)))}


def _instantiate() -> dict[str, Side]:
    from scenecc import compile_scene, load_scene

    plan = compile_scene(io.StringIO(plain_scene_text(BODIES)), num_scenes=SCENES)
    what = f"instantiate {SCENES} × {BODIES} boxes"
    # Before it was a flag, the audit had levels: other commits are measured, too.
    off: Any = False if signature(load_scene).parameters["audit"].default is True else "off"
    return {
        f"{what}, audit off": _cpu(lambda: load_scene(plan, render=False, audit=off)),
        f"{what}, default audit": _cpu(lambda: load_scene(plan, render=False)),
    }


def _live() -> dict[str, Side]:
    from scenecc import load_scene

    text = plain_scene_text(live.BOXES)
    work = _cpu(lambda: load_scene(io.StringIO(text), render=False))

    def side() -> float:
        with collector_on():
            return work()

    return {f"{live.BOXES} boxes, text to live scene": side}


def _vary() -> dict[str, Side]:
    from scenecc import load_scene

    def side() -> float:
        plan = vary.varied(VARIED_SCENES)  # anew, since a plan keeps what was drawn
        return _cpu(lambda: load_scene(plan, render=False))()

    return {f"{VARIED_SCENES} × {vary.BODIES} boxes, drawn poses, sizes and colours, default audit": side}


def _render() -> dict[str, Side]:
    from scenecc import SceneError, load_scene

    text = render.viewed_text()
    first, further = render.ours(text, 1), render.ours(text, 1 + render.PICTURES, clock_after=1)
    try:
        held = load_scene(io.StringIO(text), render=True)
    except SceneError:  # no device renders
        return {}
    _HELD.append(held)  # the engine's renderer, which takes seconds to start, runs as long as one scene has it
    return {
        f"the first picture of {render.BODIES} boxes, the renderer running": first,
        f"{render.PICTURES} further pictures": further,
    }


_HELD: list[object] = []

SIDES: dict[str, Callable[[], dict[str, Side]]] = {
    "instantiate": _instantiate,
    "validate": _validate,
    "vary": _vary,
    "live": _live,
    "render": _render,
}
NAMES = (*SIDES, "process")


def _cpu(work: Callable[[], object]) -> Side:
    """Time of the processor, which is not spent while others have it."""
    return timed(work, clock=time.process_time)


def _processes() -> dict[str, float]:
    """CPU seconds of whole processes, the reference among them, in turns."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder, "three_lines.yaml")
        scene.write_text(THREE_LINES)
        commands = {
            'python -c "import scenecc"': ["-c", "import scenecc"],
            "scenecc --help": ["-m", "scenecc", "--help"],
            "scenecc validate, three lines": ["-m", "scenecc", "validate", str(scene)],
            f'python -c "{REFERENCE}"': ["-c", REFERENCE],
        }
        rounds = [{what: _child(folder, command) for what, command in commands.items()} for _ in range(6)]
    return {what: min(found[what] for found in rounds[1:]) for what in commands}


def _child(folder: str, arguments: Sequence[str]) -> float:
    """CPU seconds of one process. The first writes the bytecode that the others read."""
    command = [sys.executable, *arguments]
    process = subprocess.Popen(command, env=environment(folder), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return usage.ru_utime + usage.ru_stime


def main() -> None:
    """Prints what `measure` gives, as JSON."""
    import scenecc

    wanted = Path(os.environ["PYTHONPATH"]).resolve()
    assert Path(scenecc.__file__).resolve().is_relative_to(wanted), f"{scenecc.__file__} is not of {wanted}"
    print(json.dumps(measure(sys.argv[1])))


if __name__ == "__main__":
    main()
