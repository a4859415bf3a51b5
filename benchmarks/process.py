"""The process `scenecc validate` against a process that only imports its dependencies."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.paired import Row, alternating, best, ratios, timed

_THREE_LINES = """\
scenecc: 1
entities:
  cube: {pose: [0, 0, 0.02], shapes: [{type: box, half_size: [0.02, 0.02, 0.02]}]}
"""


def run(repetitions: int) -> list[Row]:
    """Both are started by the same interpreter, one after the other, three times as often as others run."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "three_lines.yaml"
        scene.write_text(_THREE_LINES)
        sides = [
            timed(lambda: _start(folder, ["-m", "scenecc", "validate", str(scene)])),
            timed(lambda: _start(folder, ["-c", "import pydantic, typer, yaml"])),
            timed(lambda: _start(folder, ["-c", "import pydantic, typer, yaml; pydantic.BaseModel"])),
        ]
        rounds = alternating(sides, 3 * repetitions)
    what = "process: scenecc validate, three lines / python -c"
    return [
        Row(
            "process",
            f'{what} "import pydantic, typer, yaml"',
            ratios(rounds, 0, 1),
            2.0,
            note=f"{best(rounds, 0)} / {best(rounds, 1)}",
        ),
        Row(
            "process",
            f'{what} the same and "pydantic.BaseModel" (which `import pydantic` leaves unloaded)',
            ratios(rounds, 0, 2),
            note=f"{best(rounds, 0)} / {best(rounds, 2)}",
        ),
    ]


def _start(folder: str, arguments: Sequence[str]) -> None:
    """Runs Python with bytecode, as an installed package has it, which the round that is thrown away writes."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPYCACHEPREFIX"] = str(Path(folder, "bytecode"))
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True, env=environment)
