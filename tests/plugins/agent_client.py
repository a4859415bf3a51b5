"""A client of `scenecc mcp` that writes and reads lines itself."""

from __future__ import annotations

import itertools
import json
import queue
import subprocess
import sys
import threading
import time
from pathlib import Path

from typing_extensions import Self

SECONDS = 60


class AgentClient:
    """A process of the server, with its messages."""

    def __init__(self, root: Path, *arguments: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "scenecc", "mcp", "--root", str(root), *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd="/",  # `-m` imports modules from there
        )
        self._numbers = itertools.count(1)
        self._messages: queue.Queue = queue.Queue()
        self._kept: list[dict] = []
        self.errors = b""
        self._readers = [threading.Thread(target=each, daemon=True) for each in (self._read, self._read_errors)]
        for thread in self._readers:
            thread.start()
        about = {"capabilities": {}, "clientInfo": {"name": "test", "version": "1"}}
        self.started = self.ask("initialize", {"protocolVersion": "2025-06-18", **about})
        self.send({"method": "notifications/initialized"})

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            message = json.loads(line)  # nothing else may be on standard output
            assert message["jsonrpc"] == "2.0"
            self._messages.put(message)
        self._messages.put(None)

    def _read_errors(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.errors += line

    def write(self, line: bytes) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(line + b"\n")
        self.process.stdin.flush()

    def send(self, message: dict) -> None:
        self.write(json.dumps({"jsonrpc": "2.0", **message}).encode())

    def begin(self, method: str, params: dict | None = None) -> int:
        """Sends a request, and returns its number."""
        number = next(self._numbers)
        self.send({"id": number, "method": method, "params": params or {}})
        return number

    def begin_call(self, tool: str, **arguments) -> int:
        return self.begin("tools/call", {"name": tool, "arguments": arguments})

    def answer(self, number: int) -> dict:
        """The answer to a request: its result, or its error as a mapping with `code` and `message`."""
        message = self.wait(lambda one: one.get("id") == number and "method" not in one)
        return message["error"] if "error" in message else message["result"]

    def ask(self, method: str, params: dict | None = None) -> dict:
        return self.answer(self.begin(method, params))

    def call(self, tool: str, **arguments) -> dict:
        """The document that a tool returns. It must not be an error."""
        result = self.answer(self.begin_call(tool, **arguments))
        assert not result["isError"], result
        return document(result)

    def refusal(self, tool: str, **arguments) -> dict:
        """The document of a call that fails."""
        result = self.answer(self.begin_call(tool, **arguments))
        assert result["isError"], result
        return document(result)

    def wait(self, wanted) -> dict:
        """The first message that is wanted; the others are kept."""
        for number, message in enumerate(self._kept):
            if wanted(message):
                return self._kept.pop(number)
        while True:
            message = self._messages.get(timeout=SECONDS)
            assert message is not None, f"the server ended: {self.errors.decode()}"
            if wanted(message):
                return message
            self._kept.append(message)

    def commands(self) -> list[int]:
        """Processes that the server has started."""
        path = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        return [int(one) for one in path.read_text().split()]

    def wait_for_commands(self, count: int) -> list[int]:
        """The processes that the server has started, once there are so many."""
        deadline = time.monotonic() + SECONDS
        while len(found := self.commands()) < count:
            assert time.monotonic() < deadline
            time.sleep(0.05)
        return found

    def end(self) -> int:
        """Closes its input. Returns its exit status."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        return self.wait_until_ended()

    def wait_until_ended(self) -> int:
        status = self.process.wait(SECONDS)
        for thread in self._readers:
            thread.join(SECONDS)
        return status

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.process.kill()
        self.wait_until_ended()
        with self.process:  # closes its streams
            pass


def document(result: dict) -> dict:
    """What a result holds, which is there as data and as text."""
    (text,) = [one["text"] for one in result["content"] if one["type"] == "text"]
    assert json.loads(text) == result["structuredContent"]
    return result["structuredContent"]
