"""The examples run: a few rounds of each, which are too few to learn anything."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_reach_trains_and_says_how_well_it_reaches() -> None:
    few = ("--scenes", "4", "--iterations", "2", "--episodes", "1")
    command = [sys.executable, "-W", "ignore", str(EXAMPLES / "reach.py"), *few]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    untrained, steps, trained = done.stdout.splitlines()
    assert re.fullmatch(r"untrained: \d+\.\d% of episodes reach their goal", untrained)
    assert re.fullmatch(r" +256 steps, +\d+ s: mean return -?\d+\.\d\d", steps)
    assert re.fullmatch(r"trained: \d+\.\d%; \d+ s of CPU time in total", trained)


def test_reach_imports_nothing_of_maniskill() -> None:
    script = "import sys, reach; reach.make_envs(1); print('mani_skill' in sys.modules)"
    command = [sys.executable, "-W", "ignore", "-c", script]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=100, cwd=EXAMPLES)
    assert done.stdout == "False\n"


def test_reach_is_short() -> None:
    assert len((EXAMPLES / "reach.py").read_text().splitlines()) < 250
