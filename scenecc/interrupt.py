"""Handling of signals that end a process: cleanup before it ends, and blocks that delay them.

It imports almost nothing: until it is loaded, a signal ends the process with Python's traceback.
"""

from __future__ import annotations

import os
import signal
import threading
from contextlib import ExitStack, contextmanager, suppress

TYPE_CHECKING = False  # importing `typing` takes longer than everything else here
if TYPE_CHECKING:
    import subprocess
    from collections.abc import Generator, Mapping
    from types import FrameType
    from typing import Any, NoReturn

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_stacks: list[ExitStack] = []
"""Cleanup to run when the process ends."""


def end_at_signals() -> None:
    """Makes Ctrl-C, SIGTERM and SIGHUP end this process with status 130, 143 and 129.

    The process ends inside the handler. An exception raised there could surface in any line of Python: a destructor or
    callback would drop it, and an engine crashes if it is torn down while its threads draw.
    """
    for number in _SIGNALS:
        if number is not signal.SIGHUP or signal.getsignal(number) is not signal.SIG_IGN:  # nohup ignores SIGHUP
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
    """Yields a stack whose callbacks run when the block ends, even if a signal ends the process.

    A signal may arrive inside any function, so a callback must not take a lock.
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
    """Yields a temporary folder, removed when the block ends or a signal ends the process. `above`: its parent."""
    import shutil  # noqa: PLC0415 - few need them
    import tempfile  # noqa: PLC0415

    with undoing() as undo:
        with interrupts_wait():
            folder = tempfile.mkdtemp(prefix=prefix, dir=above and os.fspath(above))
            undo.callback(shutil.rmtree, folder, ignore_errors=True)
        yield folder


@contextmanager
def child(command: list[str], **options: Any) -> Generator[subprocess.Popen[bytes]]:
    """Yields a process, killed when the block ends or a signal ends this process. `options`: those of
    `subprocess.Popen`.
    """
    import subprocess  # noqa: PLC0415 - few need it

    with undoing() as undo:
        with interrupts_wait():
            process: subprocess.Popen[Any] = subprocess.Popen(command, **options)  # noqa: S603 - the caller knows the command
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
    """Runs one of our modules in a separate process until it ends. It imports the same modules as this process would.

    Args:
        module: name of the module.
        request: plain data, passed as JSON on standard input.
        seconds: time limit; None: no limit.
        environment: its environment variables; `PYTHONPATH` is added.
        options: those of `subprocess.Popen`. By default, standard output and error are captured.

    Raises:
        subprocess.TimeoutExpired: it exceeded the limit, and was killed.
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
    """Delays signals to the end of the block. They arrive only in the main thread.

    For work that must not be interrupted: if the `__init__` of a `sapien.Scene` is interrupted, freeing it crashes the
    process, because `__del__` clears what was never created.
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
    """Makes Linux end this process as soon as its parent ends, for any reason."""
    import ctypes  # noqa: PLC0415 - only workers need it
    import sys  # noqa: PLC0415

    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        sys.exit()
