"""The command line without the time that its imports take: forked from a process that has them already.

Each use is a process of its own, with its own arguments, folder, environment and streams, which ends as any other. What
imports themselves do (their order, what a command leaves unloaded) shows only where a test starts Python anew.
"""

from __future__ import annotations

import atexit
import functools
import gc
import json
import os
import pkgutil
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

_LONGEST_INPUT = 1 << 16
"""What a pipe holds before anybody reads it [bytes]."""

_STARTER = """\
#!{python} -IS
import json, os, signal, socket, sys
requests = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
requests.connect({address!r})
request = {{"arguments": sys.argv[1:], "cwd": os.getcwd(), "env": dict(os.environ)}}
socket.send_fds(requests, [json.dumps(request).encode()], [0, 1, 2])
status = json.loads(requests.recv(100))
if status < 0:
    signal.signal(-status, signal.SIG_DFL)
    os.kill(os.getpid(), -status)
sys.exit(status)
"""


def scenecc(
    arguments: Sequence[str], *, cwd: Path, stdin: bytes, env: Mapping[str, str]
) -> subprocess.CompletedProcess[bytes]:
    """Runs `scenecc` with these arguments."""
    assert len(stdin) < _LONGEST_INPUT
    source, sink = os.pipe()
    os.write(sink, stdin)
    os.close(sink)
    with (
        os.fdopen(source) as given,
        tempfile.TemporaryFile() as out,
        tempfile.TemporaryFile() as err,
        socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as requests,
    ):
        requests.settimeout(300)
        requests.connect(_server())
        request = json.dumps({"arguments": list(arguments), "cwd": str(cwd), "env": dict(env)})
        socket.send_fds(requests, [request.encode()], [given.fileno(), out.fileno(), err.fileno()])
        status = json.loads(requests.recv(100))
        for stream in (out, err):
            stream.seek(0)
        return subprocess.CompletedProcess(["scenecc", *arguments], status, out.read(), err.read())


def write_starter(path: Path) -> None:
    """Writes a program that runs `scenecc` as `scenecc` of this module does, for scripts. It passes no signal on."""
    path.write_text(_STARTER.format(python=sys.executable, address=_server()))
    path.chmod(0o755)


@functools.cache
def _server() -> str:
    """The address at which a process takes requests until this one ends."""
    folder = tempfile.mkdtemp()
    address = f"{folder}/requests"
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    listener.bind(address)
    listener.listen()
    ours, theirs = socket.socketpair()
    root = Path(__file__).parents[2]
    search = os.pathsep.join(filter(None, [str(root), os.environ.get("PYTHONPATH")]))
    process = subprocess.Popen(
        [sys.executable, __file__, str(listener.fileno()), str(theirs.fileno())],
        stdin=subprocess.DEVNULL,
        # No threads: they do not come along into a fork.
        env={**os.environ, "PYTHONPATH": search, "OPENBLAS_NUM_THREADS": "1"},
        pass_fds=[listener.fileno(), theirs.fileno()],
    )
    listener.close()
    theirs.close()

    def stop() -> None:
        ours.close()
        process.wait(timeout=60)
        shutil.rmtree(folder)

    atexit.register(stop)
    return address


def _import_everything() -> None:
    import importlib
    import warnings

    import scenecc

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # SAPIEN says that it cannot render
        for module in pkgutil.walk_packages(scenecc.__path__, "scenecc."):
            # What is for ManiSkill needs it, and PyTorch, whose threads would not come along.
            if module.name != "scenecc.__main__" and "maniskill" not in module.name:
                importlib.import_module(module.name)
    # The models of a small scene are made when there is one.
    scenecc.validate({"scenecc": 1, "entities": {"cube": {"shapes": [{"type": "box", "half_size": [1, 1, 1]}]}}})


def _become_a_process_that_is_asked_for(listener: socket.socket, life: socket.socket) -> None:
    """Serves until the other side of `life` has gone; comes back in the process of each request."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for those that wait for the commands
    while True:
        ready, _, _ = select.select([listener, life], [], [])
        if life in ready:
            sys.exit()
        requests, _ = listener.accept()
        if os.fork() == 0:
            break
        requests.close()
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    listener.close()
    life.close()
    message, streams, _, _ = socket.recv_fds(requests, 1 << 20, 3)
    if child := os.fork():
        for stream in streams:
            os.close(stream)
        requests.send(json.dumps(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])).encode())
        os._exit(0)
    requests.close()
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    # As Python makes them at its start: what they can do depends on what they lead to.
    sys.stdin = sys.__stdin__ = os.fdopen(0, closefd=False)
    sys.stdout = sys.__stdout__ = os.fdopen(1, "w", closefd=False)
    sys.stderr = sys.__stderr__ = os.fdopen(2, "w", buffering=1, errors="backslashreplace", closefd=False)
    text: Any
    for text, name in ((sys.stdin, "<stdin>"), (sys.stdout, "<stdout>"), (sys.stderr, "<stderr>")):
        text.buffer.raw.name = name
    request = json.loads(message)
    os.chdir(request["cwd"])
    os.environ.clear()
    os.environ.update(request["env"])
    sys.path[:1] = filter(None, request["env"].get("PYTHONPATH", "").split(os.pathsep))
    sys.argv = ["scenecc", *request["arguments"]]


if __name__ == "__main__":
    from scenecc.cli import main

    _import_everything()
    gc.collect()
    gc.freeze()
    _become_a_process_that_is_asked_for(*(socket.socket(fileno=int(number)) for number in sys.argv[1:]))
    main()
