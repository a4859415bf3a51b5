"""Signals that end a command, whenever they come. `python tests/plugins/struck.py 100` sends many of them."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from typing import Any

import pytest
from cli.running import CUBE
from plugins.struck import COMMANDS, hears, starve, strike, strike_at

WRITING = ("build", "emit", "emit_folder", "fix", "import", "init", "pack", "render")


def names(commands: Iterable[str]) -> list[Any]:
    return [pytest.param(name, marks=[pytest.mark.render] * (name == "render")) for name in commands]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("name", names(COMMANDS))
def test_a_signal_ends_a_running_command_without_leftovers(name: str, number: signal.Signals) -> None:
    found = strike_at("begun", name, number)
    assert found.peace(number), found


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("name", names(WRITING))
@pytest.mark.parametrize("moment", ["opened", "placed"])
def test_a_signal_ends_a_writing_command_without_leftovers(moment: str, name: str, number: signal.Signals) -> None:
    found = strike_at(moment, name, number)
    assert found.peace(number), found


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("name", names(COMMANDS))
def test_a_signal_at_any_moment_ends_a_command_without_leftovers(name: str, number: signal.Signals) -> None:
    after = random.uniform(0, 1)
    found = strike(name, number, after, ours=True)
    while found.status == 0 and after > 0.05:
        # It had finished by then, as a fast machine may: a signal that is not heeded would let it finish each time.
        after /= 2
        found = strike(name, number, after, ours=True)
    assert found.peace(number) or (name == "validate" and found.status == 0), (after, found)


@pytest.mark.parametrize("most", [0, 300])
@pytest.mark.parametrize(
    ("name", "old"),
    [
        pytest.param("fix", (), marks=pytest.mark.quick),
        ("import", ("work/world.yaml", "work/world_assets/gem.obj")),
        ("build", ("work/plan.json",)),
        ("emit", ("work/scene.xml",)),
        ("emit_folder", ()),
        ("pack", ("work/scene.scn",)),
    ],
)
def test_a_full_disk_is_reported_and_changes_no_file(name: str, old: tuple[str, ...], most: int) -> None:
    """The files are larger; that of `fix` is not, and is written whole."""
    found = starve(name, most, old)
    assert found.clean()
    assert not found.written
    assert (found.status == 3) != (name == "fix" and most > 100), found.errors
    assert "Traceback" not in found.errors
    assert found.errors.count("error SC") == (1 if found.status and name != "fix" else 0)


def test_signals_are_handled_before_slow_imports() -> None:
    """Whoever hears a signal from then on ends the process in peace."""
    code = "import sys, scenecc.cli; print(len([name for name in sys.modules if name not in BEFORE]))"
    before = "import signal, threading, contextlib, sys; BEFORE = set(sys.modules); "
    done = subprocess.run([sys.executable, "-c", before + code], capture_output=True, text=True, check=True, timeout=60)
    assert int(done.stdout) <= 5  # scenecc, its version, scenecc.interrupt, scenecc.cli, __future__


def test_an_interruption_inside_a_destructor_is_not_lost() -> None:
    """Python drops an exception that is raised there."""
    code = (
        "import os, signal\nfrom scenecc.interrupt import end_at_signals\n"
        "class Freed:\n    def __del__(self): os.kill(os.getpid(), signal.SIGTERM)\n"
        "end_at_signals()\nFreed()\nprint('not ended')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "")


def test_a_hangup_ends_a_command() -> None:
    assert strike("view", signal.SIGHUP, 0, ours=True).peace(signal.SIGHUP)


def test_a_hangup_does_not_end_a_command_under_nohup() -> None:
    process = subprocess.Popen(
        ["sh", "-c", "trap '' HUP; exec $0 -m scenecc validate -", sys.executable],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    while process.poll() is None and not hears(process.pid):
        time.sleep(0.01)
    process.send_signal(signal.SIGHUP)
    assert process.communicate(CUBE.encode(), timeout=60)[1] == b"1 file checked\n"
    assert process.returncode == 0
