"""Workers that judge mutated files, each with a limit of time and memory, and what is kept of a case that fails."""

from __future__ import annotations

import os
import random
import re
import resource
import select
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.corpus import Seed, copy_of, make_corpus
from fuzz.mutate import mutated
from fuzz.oracle import judge

import scenecc.backends.sapien  # noqa: F401 - loaded before workers are forked

CPU_SECONDS = 10
"""What one case may take. Counted in time of the processor, so that a loaded machine makes no failure."""

_WALL_SECONDS = 120
MEMORY = 2**30
"""What one case may take of memory beside what is there when it starts."""

_MINIMISING_SECONDS = 20


def _limit() -> None:
    """Bounds this process. It dies of SIGPROF where a case takes too long."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _judge(folder: Path, *, render: bool) -> str:
    signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS)
    told = judge(folder, render=render)
    signal.setitimer(signal.ITIMER_PROF, 0)
    return told or ""


@dataclass
class _Worker:
    """A process that judges cases: `number`, `number + step`, …; it says which it begins, and what it finds of each."""

    pid: int
    pipe: int
    begun: int = -1
    since: float = field(default_factory=time.monotonic)
    unread: bytes = b""

    def death(self) -> str:
        """Why it is no more."""
        os.close(self.pipe)
        status = os.waitpid(self.pid, 0)[1]
        if not os.WIFSIGNALED(status):
            return f"the process ends with status {os.waitstatus_to_exitcode(status)}"
        name = signal.Signals(os.WTERMSIG(status)).name
        return f"more than {CPU_SECONDS} s" if name in {"SIGPROF", "SIGKILL"} else f"the process dies of {name}"


def _fork() -> tuple[int, int]:
    """A child whose output goes nowhere: its number and what it writes; in the child 0, and where to write."""
    reading, writing = os.pipe()
    pid = os.fork()
    if pid:
        os.close(writing)
        return pid, reading
    os.close(reading)
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    _limit()
    return 0, writing


def _say(pipe: int, text: str) -> None:
    os.write(pipe, text.replace("\n", " ")[:2000].encode("utf-8", "replace") + b"\n")


def once(folder: Path, *, render: bool) -> str | None:
    """What is wrong with a case, judged in a process of its own."""
    pid, pipe = _fork()
    if not pid:
        _say(pipe, _judge(folder, render=render))
        os._exit(0)
    worker = _Worker(pid, pipe)
    said = b""
    while select.select([pipe], [], [], _WALL_SECONDS)[0]:
        more = os.read(pipe, 4096)
        said += more
        if not more or said.endswith(b"\n"):
            break
    if not said:
        os.kill(pid, signal.SIGKILL) if not more else None
    death = worker.death()
    return said.decode().rstrip("\n") or None if said else death


class _Cases:
    """All cases of a run. Each is told by its number alone."""

    def __init__(self, seeds: dict[str, list[Seed]], seed: int, scratch: Path) -> None:
        self._seeds, self._seed, self._scratch = seeds, seed, scratch
        self._targets = list(seeds)

    def make(self, number: int) -> tuple[str, Seed, Path]:
        how = random.Random(f"{self._seed}/{number}")
        target = self._targets[number % len(self._targets)]
        seed, other = how.choice(self._seeds[target]), how.choice(self._seeds[target])
        folder = self._scratch / str(number)
        path = seed.folder / seed.name
        copy_of(seed, folder, mutated(path, path.read_bytes(), (other.folder / other.name).read_bytes(), how))
        return target, seed, folder


def _work(cases: _Cases, numbers: range, *, render: bool) -> _Worker:
    pid, pipe = _fork()
    if pid:
        return _Worker(pid, pipe)
    for number in numbers:
        _say(pipe, f"? {number}")
        folder = cases.make(number)[2]
        told = _judge(folder, render=render)
        shutil.rmtree(folder, ignore_errors=True)
        _say(pipe, f"= {told}")
    os._exit(0)


def fuzz(targets: Sequence[str], seconds: float, seed: int, jobs: int, out: Path, *, render: bool) -> list[Path]:
    """Tries mutated files for a while; what fails is saved, one case of each kind, and its folders are given."""
    out = out.resolve()
    kept: dict[str, Path] = {}
    with tempfile.TemporaryDirectory() as temporary:
        scratch = Path(temporary)
        cases = _Cases({target: make_corpus(target, scratch / "corpus") for target in targets}, seed, scratch)
        for folder in (cases.make(-number)[2] for number in range(1, 3 * len(targets))):
            judge(folder, render=None)  # loads what is loaded late, and makes nothing that a fork would lose
        workers = [_work(cases, range(i, 2**62, jobs), render=render) for i in range(jobs)]
        done, end = 0, time.monotonic() + seconds
        while time.monotonic() < end:
            ready = select.select([worker.pipe for worker in workers], [], [], 1)[0]
            for i, worker in enumerate(workers):
                told: list[tuple[int, str]] = []
                died = False
                if worker.pipe in ready:
                    more = os.read(worker.pipe, 65536)
                    died = not more
                    *lines, worker.unread = (worker.unread + more).split(b"\n")
                    for line in lines:
                        if line.startswith(b"?"):
                            worker.begun, worker.since = int(line[2:]), time.monotonic()
                            continue
                        done += 1
                        if line[2:]:
                            told.append((worker.begun, line[2:].decode()))
                elif time.monotonic() - worker.since > _WALL_SECONDS:
                    os.kill(worker.pid, signal.SIGKILL)
                    died = True
                if died:
                    told.append((worker.begun, worker.death()))
                    shutil.rmtree(scratch / str(worker.begun), ignore_errors=True)
                    workers[i] = _work(cases, range(worker.begun + jobs, 2**62, jobs), render=render)
                for number, failure in told:
                    _keep(cases, number, failure, out, kept, render=render)
        for worker in workers:
            os.kill(worker.pid, signal.SIGKILL)
            worker.death()
    print(f"{done} cases, {done / seconds:.0f} a second; {len(kept)} kinds of failure")
    return list(kept.values())


def _kind(failure: str) -> str:
    return re.sub(r"\d+|'[^']*'|`[^`]*`|\"[^\"]*\"|\S*/\S*", "#", failure)[:160]


def _keep(cases: _Cases, number: int, failure: str, out: Path, kept: dict[str, Path], *, render: bool) -> None:
    if _kind(failure) in kept:
        return
    target, seed, folder = cases.make(number)
    kept[_kind(failure)] = home = out / f"{target}-{number}"
    shutil.rmtree(home, ignore_errors=True)
    shutil.copytree(folder, home)
    shutil.rmtree(folder)
    minimise(home, seed.name, failure, render=render)
    print(f"{target}: {failure}\n  python -m tests.fuzz {'--render ' if render else ''}{home}", flush=True)


def minimise(folder: Path, name: str, failure: str, *, render: bool) -> None:
    """Leaves out what the failure does not need: files, and ever smaller pieces of the one that was mutated."""
    end = time.monotonic() + _MINIMISING_SECONDS
    path = folder / name

    def fails() -> bool:
        return _kind(once(folder, render=render) or "") == _kind(failure)

    if not fails():
        return
    for other in sorted(folder.iterdir()):
        if other.name not in {name, "scene.yaml"}:
            aside = Path(shutil.move(other, folder.with_name(folder.name + ".aside")))
            if not fails():
                shutil.move(aside, other)
            shutil.rmtree(aside) if aside.is_dir() else aside.unlink(missing_ok=True)
    data = path.read_bytes()
    size = len(data) // 2
    while size and time.monotonic() < end:
        at = 0
        while at < len(data) and time.monotonic() < end:
            path.write_bytes(data[:at] + data[at + size :])
            if fails():
                data = path.read_bytes()
            else:
                at += size
        size //= 2
    path.write_bytes(data)


def replay(folders: Sequence[Path], *, render: bool) -> int:
    """Judges saved cases. Gives 1 where one fails."""
    told = {folder: once(folder.resolve(), render=render) for folder in folders}
    for folder, failure in told.items():
        print(f"{folder}: {failure or 'nothing is wrong'}", file=sys.stderr)
    return 1 if any(told.values()) else 0
