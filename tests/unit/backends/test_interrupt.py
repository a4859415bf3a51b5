"""Ctrl-C in a process that goes on afterwards: a notebook, a test runner."""

import subprocess
import sys

import pytest

PROGRAM = """
import os, signal, sys
import scenecc

def interrupt(done, count):
    if done == int(sys.argv[1]):
        os.kill(os.getpid(), signal.SIGINT)

scene = {"scenecc": 1, "entities": {"ball": {"shapes": [{"type": "sphere", "radius": 0.1}]}}}
try:
    scenecc.build_scene(scene, num_scenes=300, render=False, audit=False, progress=interrupt)
except KeyboardInterrupt:
    print("interrupted")
scenecc.load_scene(scene, render=False).close()
print("alive")
"""


@pytest.mark.parametrize("scenes_done", [1, 100, 300])
def test_an_interrupted_build_leaves_the_process_alive(scenes_done: int) -> None:
    command = [sys.executable, "-c", PROGRAM, str(scenes_done)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.split() == ["interrupted", "alive"]
