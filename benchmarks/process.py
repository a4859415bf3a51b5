"""The process `scenecc validate` against a process that only imports its dependencies."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.paired import Row, alternating, best, ratios, timed

THREE_LINES = """\
scenecc: 1
entities:
  cube: {pose: [0, 0, 0.02], shapes: [{type: box, half_size: [0.02, 0.02, 0.02]}]}
"""

REFERENCE = "import typer, yaml; from pydantic import BaseModel"
"""What the command needs of others, and `import pydantic` alone leaves unloaded."""


def run(repetitions: int) -> list[Row]:
    """Both are started by the same interpreter, one after the other, three times as often as others run."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "three_lines.yaml"
        scene.write_text(THREE_LINES)
        sides = [
            timed(lambda: _start(folder, ["-m", "scenecc", "validate", str(scene)])),
            timed(lambda: _start(folder, ["-c", "import pydantic, typer, yaml"])),
            timed(lambda: _start(folder, ["-c", REFERENCE])),
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
            f'{what} "{REFERENCE}"',
            ratios(rounds, 0, 2),
            note=f"{best(rounds, 0)} / {best(rounds, 2)}",
        ),
    ]


def _start(folder: str, arguments: Sequence[str]) -> None:
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True, env=environment(folder))


def environment(folder: str) -> dict[str, str]:
    """That of a process with bytecode, as an installed package has it, which the round that is thrown away writes."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return kept | {"PYTHONPYCACHEPREFIX": str(Path(folder, "bytecode"))}
