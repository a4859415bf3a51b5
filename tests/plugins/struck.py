"""Commands that a signal strikes at a random moment of their life, and what they leave behind.

    python tests/plugins/struck.py [REPETITIONS [COMMAND...]]

prints how each command ended.
"""

from __future__ import annotations

import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]

_VIDEO = ("--steps", "8", "--every", "1", "-o", "video.mp4")

COMMANDS: Mapping[str, tuple[str, ...]] = {
    "validate": ("validate", str(ROOT / "scenes")),
    "check": ("check", str(ROOT / "scenes"), "--jobs", "2"),
    "build": ("build", "convex.yaml", "--no-render", "--steps", "20", "-o", "plan.json"),
    "emit": ("emit", str(ROOT / "scenes/materials.yaml"), "--to", "mjcf", "-o", "scene.xml"),
    "view": ("view", str(ROOT / "scenes/tabletop.yaml"), "--port", "0"),
    "render": ("render", str(ROOT / "scenes/tabletop.yaml"), "--size", "160x120", *_VIDEO),
    "fix": ("validate", "--fix", "wrong.yaml"),
    "import": ("import", "world.sdf", "-o", "world.yaml"),
    "pack": ("pack", str(ROOT / "scenes/robot_door.yaml"), "-o", "scene.scn"),
    "init": ("init", "demo"),
    "doctor": ("doctor",),
    "emit_folder": ("emit", str(ROOT / "scenes/robot_door.yaml"), "--to", "urdf", "-o", "robots"),
}

_CONVEX = """\
scenecc: 1
entities: {gem: {shapes: [{type: convex_parts, file: gem.stl, decomposition: coacd}]}}
"""

_WRONG = """\
scenecc: 1
entities: {gem: {shapes: [{type: convex_mesh, file: gem.stl}], masss: 2}}
"""

_WORLD = """\
<sdf version="1.9"><world name="w"><model name="m"><link name="l"><collision name="c"><geometry>
<mesh><uri>gem.stl</uri><scale>-1 1 1</scale></mesh></geometry></collision></link></model>
<model name="n"><link name="l"><collision name="c"><geometry>
<ellipsoid><radii>0.1 0.2 0.3</radii></ellipsoid></geometry></collision></link></model></world></sdf>
"""

_GIVEN = {"work/convex.yaml": _CONVEX, "work/wrong.yaml": _WRONG, "work/world.sdf": _WORLD}
_AFTERWARDS = {"work/wrong.yaml": _WRONG.replace("masss", "mass")}
"""What else a given file may hold in the end, whole."""

_OLD = b"as it was before\n"

# A command that sends itself a signal: "begun", at the first import after it has its handlers; "opened", when it opens
# a file to write in its folder; "placed", when it gives a file its name there.
_STRIKE_ITSELF = """
import os, runpy, signal, sys

moment, number, folder, process = sys.argv[1], int(sys.argv[2]), os.getcwd() + os.sep, os.getpid()
waiting = [True]

def is_inside(path):
    return not isinstance(path, int) and (os.path.abspath(os.fsdecode(path)) + os.sep).startswith(folder)

def has_come(event, arguments):
    if moment == "begun":
        return event == "import" and callable(signal.getsignal(signal.SIGTERM))
    if moment == "opened":
        return event == "open" and (arguments[2] or 0) & (os.O_WRONLY | os.O_RDWR) and is_inside(arguments[0])
    return event in ("os.rename", "os.link") and is_inside(arguments[1])

def strike(event, arguments):
    if waiting and os.getpid() == process and has_come(event, arguments):
        waiting.clear()
        os.kill(process, number)

sys.addaudithook(strike)
sys.argv[:] = ["scenecc", *sys.argv[3:]]
runpy.run_module("scenecc", run_name="__main__", alter_sys=True)
"""

_KEPT = re.compile(
    r"mesa|scenecc/coacd|scenecc/packs/[0-9a-f]{64}/"
    r"|scenecc/(?:findings|meshes|images|engine)/[0-9a-f]{64}(?:\.\w+)?$"
)
"""Cached files. A pack is in a folder of this name only when all of it is there."""


@dataclass(frozen=True)
class Struck:
    """How a command ended that a signal struck.

    Attributes:
        status: of the process, as Python tells it.
        errors: its standard error.
        heard: whether it had a handler of its own when the signal came.
        took: how long it lived on [s].
        written: which of the files that were there before are others now.
        broken: which of the given files hold neither what they did nor what the command writes.
        left: other files and folders.
        processes: command lines of processes that outlived it.
    """

    status: int
    errors: str
    heard: bool
    took: float
    written: frozenset[str]
    broken: frozenset[str]
    left: frozenset[str]
    processes: list[str]

    def peace(self, number: int) -> bool:
        """Whether it ended as it should have, and left nothing."""
        whole = not self.errors or self.errors == "Ctrl-C ends it.\n"
        return self.status == 128 + number and whole and not self.written and self.clean()

    def clean(self) -> bool:
        """Whether all that it left is whole."""
        return not (self.broken or self.left or self.processes)


def lifetime(name: str) -> tuple[float, frozenset[str]]:
    """Seconds from start to end (of a viewer, to its address and a little more), and the names of files it wrote."""
    with _started(name) as (process, home):
        began = time.monotonic()
        if name == "view":
            assert process.stdout is not None
            process.stdout.readline()
            time.sleep(0.5)
        else:
            process.wait(120)
        return time.monotonic() - began, _files(home)


def strike(name: str, number: signal.Signals, after: float, old: Collection[str] = (), *, ours: bool = False) -> Struck:
    """Runs a command and sends it a signal after some seconds.

    Args:
        name: of the command.
        number: the signal.
        after: since the process began.
        old: files that are there before.
        ours: count the seconds from when it has a handler of its own.
    """
    with _started(name, old) as (process, home):
        while ours and process.poll() is None and not hears(process.pid):
            time.sleep(0.002)
        time.sleep(after)
        heard = hears(process.pid)
        sent = time.monotonic()
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
        took = time.monotonic() - sent
        _wait_for_children(process.pid)
        return _judged(home, process, errors, heard, took, old)


def strike_at(moment: str, name: str, number: signal.Signals) -> Struck:
    """Runs a command that sends itself a signal at a moment: "begun", "opened" or "placed"."""
    with _started(name, program=("-c", _STRIKE_ITSELF, moment, str(number.value))) as (process, home):
        began = time.monotonic()
        _, errors = process.communicate(timeout=100)
        _wait_for_children(process.pid)
        return _judged(home, process, errors, True, time.monotonic() - began, ())


def starve(name: str, most: int, old: Collection[str] = ()) -> Struck:
    """Runs a command that may write no file of more than so many bytes, as on a disk that becomes full."""
    with _started(name, old, most=most) as (process, home):
        _, errors = process.communicate(timeout=120)
        return _judged(home, process, errors, True, 0, old)


def _judged(
    home: Path, process: subprocess.Popen[bytes], errors: bytes, heard: bool, took: float, old: Collection[str]
) -> Struck:
    written = frozenset(each for each in old if (home / each).read_bytes() != _OLD)
    broken = frozenset(
        each for each, text in _GIVEN.items() if (home / each).read_text() not in {text, _AFTERWARDS.get(each)}
    )
    left = _files(home).difference(old, (str(Path(each).parent) for each in old))
    outlived = sessions_processes(process.pid)
    return Struck(process.returncode, errors.decode(), heard, took, written, broken, left, outlived)


@contextmanager
def _started(
    name: str, old: Collection[str] = (), *, most: int | None = None, program: Collection[str] = ("-m", "scenecc")
) -> Iterator[tuple[subprocess.Popen[bytes], Path]]:
    """A command that runs in a session, a folder, a temporary folder and a cache of its own."""
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        for each in ("work", "tmp", "cache"):
            (home / each).mkdir()
        for given, text in _GIVEN.items():
            (home / given).write_text(text)
        shutil.copy(ROOT / "scenes/assets/gem.stl", home / "work")
        for each in old:
            (home / each).parent.mkdir(exist_ok=True, parents=True)
            (home / each).write_bytes(_OLD)
        limit = None if most is None else lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
        process = subprocess.Popen(
            [sys.executable, *program, *COMMANDS[name]],
            cwd=home / "work",
            env={**os.environ, "TMPDIR": str(home / "tmp"), "XDG_CACHE_HOME": str(home / "cache")},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
            preexec_fn=limit,  # noqa: PLW1509 - this process has no threads
        )
        try:
            yield process, home
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def _files(home: Path) -> frozenset[str]:
    """Names of what a command left but for what was given, and what Mesa and scenecc keep for another time."""
    found = {str(path.relative_to(home)) for path in (home / "work").rglob("*")}
    found |= {str(path.relative_to(home)) for path in home.rglob("*") if path.is_file()}
    return frozenset(name for name in found - {*_GIVEN, "work/gem.stl"} if not _KEPT.search(name))


def hears(pid: int) -> bool:
    """Whether a process has a handler for SIGTERM, which Python by itself has not."""
    with suppress(OSError, StopIteration):
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
        caught = next(line for line in lines if line.startswith("SigCgt"))
        return bool(int(caught.split()[1], 16) & 1 << signal.SIGTERM - 1)
    return False


def _wait_for_children(leader: int) -> None:
    """The system takes a moment to end the children of a process that has ended; what is left after that was left."""
    end = time.monotonic() + 5
    while sessions_processes(leader) and time.monotonic() < end:
        time.sleep(0.02)


def sessions_processes(leader: int) -> list[str]:
    found: list[str] = []
    for entry in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            state, _, _, session = (entry / "stat").read_text().rsplit(")", 1)[1].split()[:4]
            if int(session) == leader and state not in "ZX":
                found.append((entry / "cmdline").read_bytes().replace(b"\0", b" ").decode())
    return found


def main(repetitions: int, names: Collection[str]) -> None:
    for name in names:
        (_, files), (lasts, _) = lifetime(name), lifetime(name)
        old = {file for file in files if file.startswith("work/") and Path(file).suffix}
        for number in (signal.SIGINT, signal.SIGTERM):
            ends: Counter[str] = Counter()
            faults: Counter[str] = Counter()
            slowest = 0.0
            for _ in range(repetitions):
                found = strike(name, number, random.uniform(0, lasts), old)
                early = "" if found.heard or found.status == 0 else " in Python's own start"
                slowest = max(slowest, found.took)
                ends[f"{found.status}{early}"] += 1
                faults[f"traceback{early}"] += "Traceback" in found.errors
                faults["processes left"] += bool(found.processes)
                faults["some files written, others not"] += 0 < len(found.written) < len(old)
                faults["files broken"] += bool(found.broken)
                faults["files left"] += bool(found.left) and found.status != 0
            print(
                f"{name:9}{number.name:8} of {lasts:5.2f} s: ends {dict(ends)}, at most {slowest:.2f} s after;"
                f" faults {dict(+faults)}",
                flush=True,
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10, sys.argv[2:] or list(COMMANDS))
