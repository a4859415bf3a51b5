"""With the packages of README's install, and no extra, a command gives its result or names what to install."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from cli.running import plain_environment

from scenecc.extras import EXTRAS, ROBOTS_HINT, install_hint

ROOT = Path(__file__).parents[2]
ABSENT = {module for extra in EXTRAS.values() for module in extra.modules} - {"lxml"}  # pycollada needs lxml
START = f"import sys; sys.modules.update(dict.fromkeys({sorted(ABSENT)})); from scenecc.cli import main; main()"

NEEDY = {
    "view {scenes}/tabletop.yaml": install_hint("view"),
    "lsp": install_hint("lsp"),
    "mcp": install_hint("mcp"),
    "emit {scenes}/tabletop.yaml --to usd -o tabletop.usda": install_hint("export"),
    "import world.usda -o world.yaml": install_hint("import"),
    "draws {scenes}/draws.yaml -o draws.parquet": install_hint("sweep"),
    "sweep {scenes}/tabletop.yaml --seeds 0:2 -o table": install_hint("sweep"),
    "decompile PickCube-v1": install_hint("maniskill", "torch"),
    "init panda --robot panda": ROBOTS_HINT,
    "build {scenes}/maniskill/PickCube-v1.yaml": ROBOTS_HINT,
}


def run(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    (folder / "world.usda").write_text("#usda 1.0\n")
    return subprocess.run(
        [sys.executable, "-c", START, *command.format(scenes=ROOT / "scenes").split()],
        cwd=folder,
        env={**plain_environment(COLUMNS="400"), "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=100,
    )


@pytest.mark.parametrize(
    "command", [pytest.param(one, marks=[pytest.mark.quick] * (one[:4] == "view")) for one in NEEDY]
)
def test_a_command_that_needs_an_extra_names_it(command: str, tmp_path: Path) -> None:
    done, hint = run(command, tmp_path), NEEDY[command]
    said = done.stdout + done.stderr
    assert done.returncode in {1, 2, 3}, said
    assert "Traceback" not in said
    assert said.count("pip install") == said.count(hint) == 1, said


@pytest.mark.parametrize(
    "command",
    [
        "doctor",
        "init demo",
        "check {scenes}/tabletop.yaml",
        "inspect {scenes}/robot_arm.yaml",
        "draws {scenes}/draws.yaml",
        "emit {scenes}/tabletop.yaml --to mjcf -o tabletop.xml",
        "emit {scenes}/tabletop.yaml --to glb -o tabletop.glb",
        "emit {scenes}/robot_arm.yaml --to urdf --entity arm -o arm.urdf",
        "import {scenes}/robots/arm.urdf -o arm.yaml",
        "pack {scenes}/tabletop.yaml -o tabletop.scn",
        "settle {scenes}/clutter.yaml -o settled.json",
    ],
)
def test_a_command_that_needs_no_extra_succeeds(command: str, tmp_path: Path) -> None:
    done = run(command, tmp_path)
    assert (done.returncode, "Traceback" in done.stderr) == (0, False), done.stdout + done.stderr
