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
import socket
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

_LONGEST_INPUT = 1 << 16
"""What a pipe holds before anybody reads it [bytes]."""


def scenecc(
    arguments: Sequence[str], *, cwd: Path, stdin: bytes, env: Mapping[str, str]
) -> subprocess.CompletedProcess[bytes]:
    """Runs `scenecc` with these arguments."""
    assert len(stdin) < _LONGEST_INPUT
    source, sink = os.pipe()
    os.write(sink, stdin)
    os.close(sink)
    with os.fdopen(source) as given, tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        request = json.dumps({"arguments": list(arguments), "cwd": str(cwd), "env": dict(env)})
        socket.send_fds(_server(), [request.encode()], [given.fileno(), out.fileno(), err.fileno()])
        status = json.loads(_server().recv(100))
        for stream in (out, err):
            stream.seek(0)
        return subprocess.CompletedProcess(["scenecc", *arguments], status, out.read(), err.read())


@functools.cache
def _server() -> socket.socket:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ours.settimeout(60)
    root = Path(__file__).parents[2]
    search = os.pathsep.join(filter(None, [str(root), os.environ.get("PYTHONPATH")]))
    process = subprocess.Popen(
        [sys.executable, __file__, str(theirs.fileno())],
        stdin=subprocess.DEVNULL,
        # No threads: they do not come along into a fork.
        env={**os.environ, "PYTHONPATH": search, "OPENBLAS_NUM_THREADS": "1"},
        pass_fds=[theirs.fileno()],
    )
    theirs.close()

    def stop() -> None:
        ours.close()
        process.wait(timeout=60)

    atexit.register(stop)
    return ours


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


def _become_a_process_that_is_asked_for(requests: socket.socket) -> None:
    """Serves until the other side has gone; comes back in the process of each request."""
    while True:
        message, streams, _, _ = socket.recv_fds(requests, 1 << 20, 3)
        if not message:
            sys.exit()
        if (child := os.fork()) == 0:
            break
        for stream in streams:
            os.close(stream)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        requests.send(json.dumps(status).encode())
    requests.close()
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    request = json.loads(message)
    os.chdir(request["cwd"])
    os.environ.clear()
    os.environ.update(request["env"])
    sys.argv = ["scenecc", *request["arguments"]]


if __name__ == "__main__":
    from scenecc.cli import main

    _import_everything()
    gc.collect()
    gc.freeze()
    _become_a_process_that_is_asked_for(socket.socket(fileno=int(sys.argv[1])))
    main()
