"""Text to a live scene against Drake's model directives, in whatever interpreter has Drake."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.live import BOXES, seconds
from benchmarks.paired import Row
from benchmarks.sources import boxes

INTERPRETER = "SCENECC_BENCH_DRAKE_PYTHON"
"""Names a Python that can import pydrake; this one by default."""

_WHAT = f"{BOXES} boxes, text to live scene / Drake LoadModelDirectives + ProcessModelDirectives"

_DRAKE = """
import sys, time
from pydrake.multibody.parsing import LoadModelDirectives, Parser, ProcessModelDirectives
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
parser = Parser(plant)
parser.package_map().Add("boxes", sys.argv[1])
started = time.perf_counter()
ProcessModelDirectives(LoadModelDirectives(sys.argv[1] + "/boxes.dmd.yaml"), parser)
plant.Finalize()
print(time.perf_counter() - started)
"""

_URDF = """\
<robot name="box"><link name="box">
  <inertial><mass value="{mass}"/><inertia ixx="{i[0]}" iyy="{i[1]}" izz="{i[2]}" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="{size}"/></geometry></collision>
</link></robot>
"""


def run(repetitions: int) -> list[Row]:
    """One URDF a box (each has a size of its own), named by one file of directives. Drake runs twice at most."""
    python = os.environ.get(INTERPRETER, sys.executable)
    with tempfile.TemporaryDirectory() as folder:
        _write(Path(folder))
        ratios: list[float] = []
        note = ""
        for _ in range(min(2, repetitions)):
            mine = seconds(1)
            ran = subprocess.run([python, "-c", _DRAKE, folder], capture_output=True, text=True, check=False)
            if ran.returncode:
                reason = ran.stderr.strip().splitlines()[-1] if ran.stderr.strip() else f"exit {ran.returncode}"
                return [Row("drake", _WHAT, (), note=f"{reason} (set {INTERPRETER})")]
            theirs = float(ran.stdout.split()[-1])
            ratios.append(mine / theirs)
            note = f"{mine * 1e3:.0f} ms / {theirs:.1f} s"
    return [Row("drake", _WHAT, tuple(ratios), note=note)]


def _write(folder: Path) -> None:
    directives = ["directives:\n"]
    for box in boxes(BOXES):
        x, y, z = box.half
        mass = 8000 * x * y * z
        inertia = tuple(mass / 3 * (a * a + b * b) for a, b in ((y, z), (x, z), (x, y)))
        name = f"box_{box.number:05d}"
        size = f"{2 * x} {2 * y} {2 * z}"
        (folder / f"{name}.urdf").write_text(_URDF.format(mass=mass, i=inertia, size=size))
        pose = f"{{translation: {list(box.p)}, rotation: !Rpy {{deg: [0, 0, {box.yaw}]}}}}"
        file = f"package://boxes/{name}.urdf"
        directives.append(
            f"- add_model:\n    name: {name}\n    file: {file}\n    default_free_body_pose:\n      box: {pose}\n"
        )
    (folder / "boxes.dmd.yaml").write_text("".join(directives))
