"""MJCF files to live scenes, and live scenes to scene files."""

from __future__ import annotations

import io
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any

from benchmarks.paired import Row, alternating, best, ratios, timed
from benchmarks.sources import plain_scene_text

FILES = 100
LINKS = 12
ENTITIES = 1_000

_READING = f"{FILES} MJCF files of {LINKS} links to live scenes / MuJoCo's own compile and the build of the plans"
_DECOMPILING = f"{ENTITIES} live boxes to a scene file / their build"


def run(repetitions: int) -> list[Row]:
    """Each file is another one, so that nothing that is kept of one serves the next."""
    return [*_read(repetitions), *_decompile(repetitions)]


def _read(repetitions: int) -> list[Row]:
    try:
        mujoco: Any = import_module("mujoco")
    except ImportError:
        return [Row("conversion", _READING, (), 2.5, note="mujoco is not installed")]
    from scenecc import compile_scene, load_scene

    with tempfile.TemporaryDirectory() as folder:
        count = 0

        def fresh_files() -> list[Path]:
            nonlocal count
            files = [Path(folder, f"{count + i}.xml") for i in range(FILES)]
            for number, file in enumerate(files, count):
                file.write_text(arm_text(number))
            count += FILES
            return files

        def scene(file: Path) -> dict[str, Any]:
            return {"scenecc": 1, "entities": {"arm": {"mjcf": f"asset://{file.name}"}}}

        def read() -> float:
            files = fresh_files()
            return timed(
                lambda: [load_scene(scene(file), asset_roots=[folder], render=False).close() for file in files]
            )()

        def compile_and_build() -> float:
            files = fresh_files()
            plans = [compile_scene(scene(file), asset_roots=[folder]) for file in files]
            compiled = timed(lambda: [mujoco.MjModel.from_xml_path(str(file)) for file in files])()
            return compiled + timed(lambda: [load_scene(plan, render=False).close() for plan in plans])()

        rounds = alternating([read, compile_and_build], repetitions)
    return [Row("conversion", _READING, ratios(rounds, 0, 1), 2.5, note=f"{best(rounds, 0)} / {best(rounds, 1)}")]


def arm_text(number: int) -> str:
    """An arm that no other number has."""
    body = ""
    for link in reversed(range(LINKS)):
        joint = f'<joint name="j{link}" axis="0 1 0" range="-90 90"/>'
        body = f'<body name="l{link}" pos="0 0 0.1">{joint}<geom type="capsule" size="0.02 0.05"/>{body}</body>'
    return f'<mujoco model="arm{number}"><worldbody>{body}</worldbody></mujoco>'


def _decompile(repetitions: int) -> list[Row]:
    from scenecc import load_scene
    from scenecc.decompiler.decompile import decompile

    text = plain_scene_text(ENTITIES)

    def build() -> float:
        return timed(lambda: load_scene(io.StringIO(text), render=False))()

    def back() -> float:
        with load_scene(io.StringIO(text), render=False) as batch:
            return timed(lambda: decompile(batch.scenes[0], check=False))()

    rounds = alternating([back, build], repetitions)
    return [Row("conversion", _DECOMPILING, ratios(rounds, 0, 1), 5, note=f"{best(rounds, 0)} / {best(rounds, 1)}")]
