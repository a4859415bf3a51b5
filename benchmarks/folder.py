"""`scenecc validate` of a folder: what a second run costs, and what two processes save."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.paired import Row, alternating, best, timed
from benchmarks.process import THREE_LINES, environment
from benchmarks.sources import scene_text

FILES = 1000
ENTITIES = 10
"""Of each file: about as many lines as the scenes of `scenes/` have."""


def run(repetitions: int) -> list[Row]:
    """Whole processes; the time of one that checks three lines alone is taken off."""
    with tempfile.TemporaryDirectory() as top:
        folder, small = Path(top, "scenes"), Path(top, "three_lines.yaml")
        folder.mkdir()
        small.write_text(THREE_LINES)
        for number in range(FILES):
            (folder / f"scene_{number:04}.yaml").write_text(scene_text(ENTITIES))
        time.sleep(2.1)  # what was written just now is kept by its hash and not by its times
        env = environment(top) | {"XDG_CACHE_HOME": str(Path(top, "cache"))}

        def validate(*arguments: str) -> None:
            command = [sys.executable, "-m", "scenecc", "validate", *arguments]
            subprocess.run(command, check=True, capture_output=True, env=env)

        validate(str(small), str(folder))
        sides = [
            timed(lambda: validate("--no-cache", str(small))),
            timed(lambda: validate(str(small))),
            timed(lambda: validate("--no-cache", str(folder))),
            timed(lambda: validate(str(folder))),
            timed(lambda: validate("--no-cache", "--jobs", "1", str(folder))),
            timed(lambda: validate("--no-cache", "--jobs", "2", str(folder))),
        ]
        rounds = alternating(sides, repetitions)
    second = tuple((kept - start_kept) / (first - start) for start, start_kept, first, kept, _, _ in rounds)
    two = tuple((both - start) / (one - start) for start, *_, one, both in rounds)
    load = f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
    return [
        Row(
            "folder",
            f"validate {FILES} unchanged scenes again / the first time",
            second,
            0.1,
            note=f"{best(rounds, 3)} / {best(rounds, 2)}, start-up {best(rounds, 1)} and {best(rounds, 0)} taken off",
        ),
        Row(
            "folder",
            f"validate {FILES} scenes with --jobs 2 / --jobs 1",
            two,
            1 / 1.7,
            note=f"{best(rounds, 5)} / {best(rounds, 4)}, start-up taken off both, {load}",
        ),
    ]
