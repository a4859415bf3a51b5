"""Processes that read files of strangers: their messages, their limits, and how they end."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from scenecc import worker as workers
from scenecc import worker_process
from scenecc.worker import Worker, WorkerError

PATIENCE = 60.0
"""No test waits so long, unless it fails [s]."""

ENDED = "the reader ended: the file needs too much memory, or crashes the library"

MakeWorker = Callable[..., Worker]


@pytest.fixture
def make_worker() -> Iterator[MakeWorker]:
    """Makes workers that answer as `plugins.worker_answers` does, and stops them."""
    made: list[Worker] = []

    def make(**changes: Any) -> Worker:
        options = {"memory": 2**30, "seconds": PATIENCE, "name": "the reader", **changes}
        made.append(Worker("plugins.worker_answers", **options))
        return made[-1]

    yield make
    for each in made:
        each.stop()


@pytest.fixture
def worker(make_worker: MakeWorker) -> Worker:
    return make_worker()


def pid_of(worker: Worker) -> int:
    return worker.ask({"pid": None}, [])[0]["pid"]


def test_a_truncated_message_is_none() -> None:
    whole = io.BytesIO()
    worker_process.write_message(whole, {"a": 1}, [b"one", b"", b"three"])
    data = whole.getvalue()
    assert worker_process.read_message(io.BytesIO(data)) == ({"a": 1, "sizes": [3, 0, 5]}, [b"one", b"", b"three"])
    assert all(worker_process.read_message(io.BytesIO(data[:end])) is None for end in range(len(data)))


def test_one_process_answers_all_requests(worker: Worker) -> None:
    assert worker.ask({"echo": {"a": [1, None, "ü"]}}, [b"\0\xff", b""]) == (
        {"echo": {"a": [1, None, "ü"]}, "sizes": [2, 0]},
        [b"\0\xff", b""],
    )
    first = pid_of(worker)
    assert first != os.getpid()
    assert pid_of(worker) == first


def test_output_of_a_library_is_not_an_answer(worker: Worker) -> None:
    assert worker.ask({"print": "words\n" * 10_000}, [b"a"])[1] == [b"a"]
    assert worker.ask({"echo": 1}, [])[0]["echo"] == 1


def test_requests_and_answers_may_be_larger_than_a_pipe(worker: Worker) -> None:
    part = bytes(range(256)) * 2**14
    assert worker.ask({"echo": "x" * 2**20}, [part, part])[1] == [part, part]


# --- limits -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("request_", [{"sleep": 2 * PATIENCE}, {"drip": 0.02}], ids=["no answer", "a slow one"])
def test_a_request_that_takes_too_long_is_stopped(request_: dict[str, float], make_worker: MakeWorker) -> None:
    worker = make_worker(seconds=0.2)
    with pytest.raises(WorkerError, match=r"^the reader took more than 0\.2 s$"):
        worker.ask(request_, [])
    assert worker._process is None
    worker._seconds = PATIENCE
    assert worker.ask({"echo": 1}, [])[0]["echo"] == 1


def test_a_request_that_needs_too_much_memory_fails(make_worker: MakeWorker) -> None:
    """The process needs some itself."""
    worker = make_worker(memory=2**28)
    assert worker.ask({"allocate": 2**25}, [])[0]["size"] == 2**25
    with pytest.raises(WorkerError, match=ENDED):
        worker.ask({"allocate": 2**28}, [])
    assert worker.ask({"echo": 1}, [])[0]["echo"] == 1


def test_a_request_larger_than_the_memory_limit_fails(make_worker: MakeWorker) -> None:
    worker = make_worker(memory=2**26)
    with pytest.raises(WorkerError, match=ENDED):
        worker.ask({"echo": 1}, [bytes(2**26)])


def test_workers_open_files_only_if_allowed(make_worker: MakeWorker, tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_text("content")
    assert make_worker().ask({"open": str(path)}, [])[0]["error"] == "Too many open files"
    assert make_worker(opens_files=True).ask({"open": str(path)}, [])[0]["content"] == "content"


def test_a_crashed_worker_leaves_no_core_dump(worker: Worker) -> None:
    assert worker.ask({"limits": None}, [])[0]["core"] == 0


# --- death --------------------------------------------------------------------------------------------------------

HALVES: dict[str, dict[str, Any]] = {
    "at once": {"exit": 0},
    "by a signal": {"abort": None},
    "by an exception": {"raise": "word"},
    "after a byte": {"send": "ff"},
    "after the length": {"send": "ff000000"},
    "within the header": {"send": "ff0000007b22"},
    "after the header": {"send header": {"sizes": [5]}},
    "within a part": {"send": b"\x0e\0\0\0".hex() + b'{"sizes": [5]}'.hex() + "616263"},
}


@pytest.mark.parametrize("request_", HALVES.values(), ids=HALVES.keys())
def test_a_worker_that_crashes_during_its_answer_raises(request_: dict[str, Any], worker: Worker) -> None:
    with pytest.raises(WorkerError, match=ENDED):
        worker.ask(request_, [b"some"])
    assert worker._process is None
    assert worker.ask({"echo": 1}, [])[0]["echo"] == 1


GARBAGE: dict[str, dict[str, Any]] = {
    "no JSON": {"send": b"\x04\0\0\0{{{{".hex()},
    "no text": {"send": "02000000ffff"},
    "a list": {"send header": [1, 2]},
    "no sizes": {"send header": {"a": 1}},
    "a word for the sizes": {"send header": {"sizes": "abc"}},
    "a size that is a word": {"send header": {"sizes": ["abc"]}},
    "a negative size": {"send header": {"sizes": [-1]}},
    "half a byte": {"send header": {"sizes": [0.5]}},
    "nested deeply": {"send": (b"\x10\x27\0\0" + b"[" * 10_000).hex()},
}


@pytest.mark.parametrize("request_", GARBAGE.values(), ids=GARBAGE.keys())
def test_an_invalid_answer_raises(request_: dict[str, Any], worker: Worker) -> None:
    with pytest.raises(WorkerError, match=r"^the answer of the reader cannot be read$"):
        worker.ask(request_, [])
    assert worker._process is None
    assert worker.ask({"echo": 1}, [])[0]["echo"] == 1


@pytest.mark.parametrize("request_", [{"send": "ffffffff"}, {"send header": {"sizes": [2**29, 2**29, 2**29]}}])
def test_an_answer_above_the_maximum_size_raises(
    request_: dict[str, Any], worker: Worker, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "MAX_ANSWER", 2**20)
    with pytest.raises(WorkerError, match=r"^the answer of the reader has more than 1048576 bytes$"):
        worker.ask(request_, [])
    assert worker.ask({"echo": 1}, [bytes(2**10)])[0]["echo"] == 1


def test_a_worker_that_crashes_while_reading_raises(worker: Worker) -> None:
    """The request fills the pipe, and nobody reads it."""
    pid = pid_of(worker)
    os.kill(pid, signal.SIGSTOP)
    threading.Timer(0.1, os.kill, (pid, signal.SIGKILL)).start()
    assert worker.ask({"echo": 1}, [bytes(2**22)])[0]["echo"] == 1
    assert pid_of(worker) != pid


@pytest.mark.parametrize("before", [0, 1])
def test_a_worker_that_crashed_while_idle_is_restarted(before: int, make_worker: MakeWorker, tmp_path: Path) -> None:
    """It may have ended with the thread that started it. One that was just started dies of the request."""
    worker = make_worker(opens_files=True)
    for _ in range(before):
        pid_of(worker)
    with pytest.raises(WorkerError, match=ENDED):
        worker.ask({"count": str(tmp_path / "count")}, [])
    assert (tmp_path / "count").read_text() == "asked\n" * (1 + before)


def test_a_killed_worker_is_restarted(worker: Worker) -> None:
    pid = pid_of(worker)
    os.kill(pid, signal.SIGKILL)
    assert pid_of(worker) != pid


def test_a_stopped_worker_starts_again(worker: Worker) -> None:
    pid = pid_of(worker)
    worker.stop()
    worker.stop()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert pid_of(worker) != pid


def test_an_interrupted_answer_is_not_used_for_the_next_request(
    worker: Worker, monkeypatch: pytest.MonkeyPatch
) -> None:
    pid_of(worker)
    with monkeypatch.context() as patch:

        def interrupt(stream: object) -> None:
            raise KeyboardInterrupt

        patch.setattr(worker_process, "read_message", interrupt)
        with pytest.raises(KeyboardInterrupt):
            worker.ask({"echo": 1}, [])
    assert worker.ask({"echo": 2}, [])[0]["echo"] == 2


# --- threads and processes ------------------------------------------------------------------------------------------


def test_concurrent_requests_get_their_own_answers(worker: Worker) -> None:
    with ThreadPoolExecutor(8) as pool:
        answers = pool.map(lambda number: worker.ask({"echo": number}, [bytes([number]) * 70_000]), range(40))
        assert [(header["echo"], parts[0][:1]) for header, parts in answers] == [(n, bytes([n])) for n in range(40)]


def test_a_worker_survives_the_thread_that_started_it(worker: Worker) -> None:
    """Linux ends the process with it."""
    for number in range(3):
        with ThreadPoolExecutor(1) as pool:
            assert pool.submit(pid_of, worker).result() > 0
        assert worker.ask({"echo": number}, [])[0]["echo"] == number


FORK = """
import os, sys
from scenecc.worker import Worker
worker = Worker("plugins.worker_answers", memory=2**30, seconds=60, name="the reader")
ask = lambda: worker.ask({"pid": None}, [])[0]["pid"]
first = ask()
reading, writing = os.pipe()
if os.fork() == 0:
    child = ask(), ask()
    os.write(writing, repr(child).encode())
    if sys.argv[1] == "exit":
        sys.exit()
    os._exit(0)
os.wait()
print(first, ask(), *eval(os.read(reading, 100)))
"""


@pytest.mark.parametrize("end", ["exit", "_exit"])
def test_a_forked_process_starts_its_own_worker(end: str) -> None:
    """And leaves that of its parent alone, also when it ends."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", FORK, end],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
        timeout=PATIENCE,
    )
    assert done.stderr == ""
    first, again, child, child_again = map(int, done.stdout.split())
    assert first == again
    assert child == child_again != first


def test_a_worker_ends_with_its_parent() -> None:
    script = (
        "import os\nfrom scenecc.worker import Worker\n"
        "worker = Worker('plugins.worker_answers', memory=2**30, seconds=60, name='')\n"
        "print(worker.ask({'pid': None}, [])[0]['pid'], flush=True)\nos._exit(0)\n"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment)
    deadline = time.monotonic() + PATIENCE
    while is_running(int(done.stdout)):
        assert time.monotonic() < deadline
        time.sleep(0.01)


def is_running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in {"Z", "X"}
    except OSError:
        return False
