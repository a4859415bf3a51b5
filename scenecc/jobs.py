"""A pool of processes. Each is replaced after a number of items, and may crash."""

from __future__ import annotations

import gc
import multiprocessing
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import TYPE_CHECKING, Any, Final, TypeVar

from scenecc.interrupt import undoing

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from multiprocessing.process import BaseProcess

Item = TypeVar("Item")
Result = TypeVar("Result")

ITEMS_OF_A_PROCESS: Final = 100
"""Number of items after which a process is replaced: SAPIEN keeps some memory of every scene that it built."""


@dataclass(frozen=True, slots=True)
class Died:
    """The result of an item whose process crashed. `status`: exit status of the process."""

    status: int | None


_AHEAD: Final = 2
"""Number of items sent to a process at once, so that it need not wait for the next."""


@dataclass(slots=True)
class _Worker:
    """A worker process. `items`: those not finished yet; `given`: the number of items sent so far."""

    process: BaseProcess
    items: deque[int]
    given: int = 0


def completed(
    function: Callable[[Item], Result], items: Sequence[Item], jobs: int
) -> Iterator[tuple[int, Result | Died]]:
    """Yields (item's number, result) for each item, in the order of completion.

    Args:
        function: applied to each item. Its results can be pickled. It raises nothing.
        items: the items.
        jobs: number of processes, 1 or more.
    """
    pool = _Pool(function, items)
    with undoing() as undo:
        undo.callback(pool.kill)
        left = len(items)
        while left:
            pool.fill(jobs)
            found = pool.finished()
            left -= len(found)
            yield from found.items()


class _Pool:
    """A pool of worker processes."""

    def __init__(self, function: Callable[[Any], Any], items: Sequence[Any]) -> None:
        self._function = function
        self._items = items
        self._waiting = deque(range(len(items)))
        self._workers: dict[Connection, _Worker] = {}
        # Forked processes share what is loaded; this process has no threads.
        self._context = multiprocessing.get_context("fork")

    def fill(self, jobs: int) -> None:
        """Starts up to `jobs` processes for the waiting items, and sends them work."""
        while self._waiting and len(self._workers) < jobs:
            ours, theirs = self._context.Pipe()
            process = self._context.Process(target=self._serve, args=(theirs, ours), daemon=True)
            process.start()
            theirs.close()
            self._workers[ours] = _Worker(process, deque())
            self._give(ours)

    def finished(self) -> dict[int, Any]:
        """Waits for results and returns them. Free processes get new items."""
        done: dict[int, Any] = {}
        for connection in wait(list(self._workers)):
            assert isinstance(connection, Connection)
            worker = self._workers[connection]
            try:
                done[worker.items[0]] = connection.recv()
            except (EOFError, ConnectionResetError):
                worker.process.join()
                done[worker.items[0]] = Died(worker.process.exitcode)
                self._waiting.extendleft(reversed([*worker.items][1:]))
                self._drop(connection)
                continue
            worker.items.popleft()
            self._give(connection)
        return done

    def _give(self, connection: Connection) -> None:
        """Sends items to a process. A process without further items ends."""
        worker = self._workers[connection]
        while self._waiting and len(worker.items) < _AHEAD and worker.given < ITEMS_OF_A_PROCESS:
            number = self._waiting.popleft()
            worker.items.append(number)
            worker.given += 1
            with suppress(BrokenPipeError):  # the process crashed; reading its result shows that
                connection.send(number)
        if not worker.items:
            self._drop(connection)

    def kill(self) -> None:
        for worker in self._workers.values():
            worker.process.kill()

    def _drop(self, connection: Connection) -> None:
        worker = self._workers.pop(connection)
        connection.close()
        worker.process.join()

    def _serve(self, connection: Connection, parents: Connection) -> None:
        """Runs in the worker process until the pool closes the connection."""
        # The garbage collector would write to inherited pages, which the system then copies.
        gc.freeze()
        for inherited in (parents, *self._workers):
            inherited.close()
        while True:
            try:
                number = connection.recv()
            except EOFError:
                return
            connection.send(self._function(self._items[number]))
