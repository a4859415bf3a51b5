"""Executors of a sweep: processes of this machine, or tasks of a Ray cluster."""

from __future__ import annotations

import os
import signal
import socket
import threading
from collections import Counter, deque
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from scenecc.extras import install_hint
from scenecc.interrupt import undoing
from scenecc.jobs import ITEMS_OF_A_PROCESS, Died, completed
from scenecc.sweeps.folder import fail
from scenecc.sweeps.units import Unit

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from scenecc.sweeps.units import Outcome, Work

    Done = tuple[Unit, Outcome | str]
    """A unit, and its outcome or how its process crashed. Each unit has at most `ATTEMPTS` of these."""

ATTEMPTS: Final = 3
"""How often a unit is tried if its process crashes."""

_PATIENCE: Final = 5.0
"""[s] Maximum time for a cluster to answer."""


def on_processes(do: Callable[[Work, Unit], Outcome], work: Work, units: Sequence[Unit], jobs: int) -> Generator[Done]:
    """Runs units in `jobs` processes of this machine."""
    left = list(units)
    for _ in range(ATTEMPTS):
        died: list[Unit] = []
        for number, result in completed(partial(do, work), left, jobs):
            if isinstance(result, Died):
                died.append(left[number])
                yield left[number], _describe_ending(result.status)
            else:
                yield left[number], result
        left = died


def _describe_ending(status: int | None) -> str:
    return f"signal {-status}" if status is not None and status < 0 else f"status {status}"


def on_ray(
    do: Callable[[Work, Unit], Outcome], work: Work, units: Sequence[Unit], jobs: int, address: str | None
) -> Generator[Done]:
    """Runs units as Ray tasks.

    Args:
        do: applied to each unit.
        work: the work of all units.
        units: the units.
        jobs: CPUs of a local cluster that is started for this.
        address: address of a running cluster; None: a local one, or the one that this process is connected to.
    """
    with _connection(jobs, address) as ray:
        # Ray would retry silently; retries are made here so that they are logged.
        task = ray.remote(max_calls=ITEMS_OF_A_PROCESS, max_retries=0, num_cpus=1)(do)
        shared = ray.put(work)
        waiting, running, deaths = deque(units), dict[Any, Unit](), Counter[Unit]()
        while waiting or running:
            ahead = 2 * max(int(ray.cluster_resources().get("CPU", 1)), 1)
            while waiting and len(running) < ahead:
                unit = waiting.popleft()
                running[task.remote(shared, unit)] = unit
            done, _ = ray.wait(list(running), num_returns=1)
            for reference in done:
                unit = running.pop(reference)
                try:
                    result = ray.get(reference)
                except ray.exceptions.RayError as error:
                    result = type(error).__name__
                    deaths[unit] += 1
                    if deaths[unit] < ATTEMPTS:
                        waiting.append(unit)
                yield unit, result


@contextmanager
def _connection(jobs: int, address: str | None) -> Generator[Any]:
    """Yields the module `ray`, connected to a cluster."""
    # Ray would send usage statistics.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        ray: Any = import_module("ray")
    except ImportError:
        fail("SC828", "Ray is not installed here", None, install_hint("ray"))
    if ray.is_initialized():
        yield ray
        return
    if address is not None:
        _reach(address)
    options: dict[str, Any] = {"num_cpus": jobs, "include_dashboard": False} if address is None else {}
    handler = signal.getsignal(signal.SIGTERM)
    try:
        ray.init(address or "local", **options, log_to_driver=False, logging_level="error")
    except (RuntimeError, OSError, ValueError) as error:
        fail("SC828", f"Ray does not start: {error}", None, None if address is None else _SECURED_HINT)
    finally:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, handler)  # Ray replaces the handler
    with undoing() as undo:
        undo.callback(ray.shutdown)  # also if a signal ends this process
        yield ray


_SECURED_HINT: Final = "a cluster with token authentication needs RAY_AUTH_MODE=token and its token on this machine too"

_HELLO: Final = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes((0, 0, 0, 4, 0, 0, 0, 0, 0))
"""Beginning of an HTTP/2 connection, which gRPC uses: the preface and an empty SETTINGS frame (RFC 9113, 3.4)."""


def _reach(address: str) -> None:
    """Fails if no gRPC server answers at the address of a cluster: Ray itself would retry for minutes."""
    hint = "give HOST:PORT of its head node, as `ray start --head` prints it"
    host, _, port = address.rpartition(":")
    try:
        with socket.create_connection((host, int(port)), _PATIENCE) as connection:
            connection.sendall(_HELLO)
            # A server answers with a SETTINGS frame, of type 4. With TLS, it would wait for another beginning.
            is_ray = "RAY_USE_TLS" in os.environ or connection.recv(4)[3:] == b"\x04"
    except (OSError, ValueError, OverflowError) as error:
        fail("SC828", f"no Ray cluster answers at `{address}`: {error}", None, hint)
    if not is_ray:
        fail("SC828", f"what answers at `{address}` is not a Ray cluster", None, hint)
