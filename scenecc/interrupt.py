"""Signals that end a process: what is undone before it ends, and what they wait for.

It loads next to nothing: until it is loaded, a signal ends the process with Python's traceback.
"""

from __future__ import annotations

import os
import signal
import threading
from contextlib import ExitStack, contextmanager, suppress

TYPE_CHECKING = False  # that of `typing` takes longer to load than all else here
if TYPE_CHECKING:
    import subprocess
    from collections.abc import Generator, Mapping
    from types import FrameType
    from typing import Any, NoReturn

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_stacks: list[ExitStack] = []
"""What is to be undone when the process ends."""


def end_at_signals() -> None:
    """Has Ctrl-C, SIGTERM and SIGHUP end this process with status 130, 143 and 129.

    It ends inside the handler. An exception raised there could come out of any line of Python: in a destructor or a
    callback it would be dropped, and an engine that is taken apart while its threads draw crashes.
    """
    for number in _SIGNALS:
        if number is not signal.SIGHUP or signal.getsignal(number) is not signal.SIG_IGN:  # ignored under nohup
            signal.signal(number, _end)


def _end(number: int, frame: FrameType | None) -> NoReturn:
    del frame
    for each in _SIGNALS:
        signal.signal(each, signal.SIG_IGN)
    try:
        while _stacks:
            with suppress(Exception):
                _stacks.pop().close()
    finally:
        os._exit(128 + number)


@contextmanager
def undoing() -> Generator[ExitStack]:
    """What is put on the stack is called when the block ends, however it ends: also where a signal ends the process.

    A signal may come in the middle of any function, so what is called must take no lock.
    """
    stack = ExitStack()
    _stacks.append(stack)
    try:
        yield stack
    finally:
        with interrupts_wait():
            try:
                stack.close()
            finally:
                _stacks.remove(stack)


@contextmanager
def temporary_folder(prefix: str | None = None, above: str | os.PathLike[str] | None = None) -> Generator[str]:
    """A folder that is gone when the block ends, or this process by a signal. `above`: the folder to make it in."""
    import shutil  # noqa: PLC0415 - few need them
    import tempfile  # noqa: PLC0415

    with undoing() as undo:
        with interrupts_wait():
            folder = tempfile.mkdtemp(prefix=prefix, dir=above and os.fspath(above))
            undo.callback(shutil.rmtree, folder, ignore_errors=True)
        yield folder


@contextmanager
def child(command: list[str], **options: Any) -> Generator[subprocess.Popen[bytes]]:
    """A process that is gone when the block ends, or this process by a signal. `options`: of `subprocess.Popen`."""
    import subprocess  # noqa: PLC0415 - few need it

    with undoing() as undo:
        with interrupts_wait():
            process: subprocess.Popen[Any] = subprocess.Popen(command, **options)  # noqa: S603 - known to who calls this
            undo.callback(process.kill)
        try:
            yield process
        finally:
            process.kill()
            process.wait()


def ask_module(
    module: str,
    request: Any,
    *,
    seconds: float | None = None,
    environment: Mapping[str, str] = os.environ,
    **options: Any,
) -> subprocess.CompletedProcess[bytes]:
    """Runs one of our modules in a process of its own, which imports what this one would, until it ends.

    Args:
        module: its name.
        request: plain data, which is its standard input as JSON.
        seconds: how long it may take; None: as long as it likes.
        environment: its variables; `PYTHONPATH` is added.
        options: of `subprocess.Popen`; its output and errors are read, unless these say otherwise.

    Raises:
        subprocess.TimeoutExpired: it has taken longer, and was killed.
    """
    import json  # noqa: PLC0415 - few need them
    import subprocess  # noqa: PLC0415
    import sys  # noqa: PLC0415

    command = [sys.executable, "-m", module]
    variables = {**environment, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    pipe = subprocess.PIPE
    with child(command, **{"stdin": pipe, "stdout": pipe, "stderr": pipe, "env": variables, **options}) as process:
        try:
            output, errors = process.communicate(json.dumps(request).encode(), timeout=seconds)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()  # closes its pipes
            raise
        return subprocess.CompletedProcess(command, process.returncode, output, errors)


@contextmanager
def interrupts_wait() -> Generator[None]:
    """Delivers signals at the end of the block instead of inside it. They arrive in the main thread only.

    For what nobody can let go of by halves: a `sapien.Scene` whose `__init__` was interrupted ends the whole process
    when it is freed, since its `__del__` clears what was never made.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    found: dict[int, Any] = {number: signal.getsignal(number) for number in _SIGNALS}
    handlers = {number: handler for number, handler in found.items() if callable(handler)}
    waiting: list[tuple[int, Any]] = []

    def wait(number: int, frame: Any) -> None:
        waiting.append((number, frame))

    for number in handlers:
        signal.signal(number, wait)
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number, _ in waiting:
            signal.raise_signal(number)


_PR_SET_PDEATHSIG = 1


def exit_with_parent(parent: int) -> None:
    """Has Linux end this process as soon as the one that asked for it ends, however that ends."""
    import ctypes  # noqa: PLC0415 - of workers alone
    import sys  # noqa: PLC0415

    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        sys.exit()
