"""Ctrl-C in a process that goes on afterwards: a notebook, a test runner."""

import subprocess
import sys

import pytest

PROGRAM = """
import os, signal, sys, threading, time
import scenecc

scene = {"scenecc": 1, "entities": {"ball": {"shapes": [{"type": "sphere", "radius": 0.1}]}}}
scenecc.load_scene(scene, render=False).close()
threading.Timer(float(sys.argv[1]), os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    scenecc.load_scene(scene, num_scenes=60000, render=False, audit="off")
except KeyboardInterrupt:
    print("interrupted")
scenecc.load_scene(scene, render=False).close()
print("alive")
"""


@pytest.mark.parametrize("delay", [0.3, 0.7])
def test_an_interrupted_build_leaves_the_process_alive(delay: float) -> None:
    command = [sys.executable, "-c", PROGRAM, str(delay)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.split() == ["interrupted", "alive"]
