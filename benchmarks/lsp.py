"""`scenecc lsp`: from a key stroke to the findings, against a check of the same text in the process."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from typing import Any

from typing_extensions import Self

import scenecc
from benchmarks.paired import Row, alternating
from benchmarks.sources import scene_text

LINES = 2000
ALLOWED = 0.15
WHAT = f"lsp: from a key stroke in {LINES} lines to the findings, less `validate` in the process / {ALLOWED * 1e3:g} ms"


def run(repetitions: int) -> list[Row]:
    """A key stroke and a check in turn, each of a text that nobody has seen before."""
    if find_spec("pygls") is None:
        return [Row("lsp", WHAT, (), 1, note="not installed: pygls")]
    numbers = count()
    with tempfile.TemporaryDirectory() as folder, _Server(Path(folder)) as server:
        server.type(_text(next(numbers)))

        def stroke() -> float:
            text = _text(next(numbers))
            started = time.perf_counter()
            server.type(text)
            return time.perf_counter() - started

        def check() -> float:
            text = _text(next(numbers))
            started = time.perf_counter()
            scenecc.validate(io.StringIO(text))
            return time.perf_counter() - started

        rounds = alternating([stroke, check], repetitions)
    both = [sorted(each)[len(rounds) // 2] * 1e3 for each in zip(*rounds, strict=True)]
    over = tuple((one - other) / ALLOWED for one, other in rounds)
    return [Row("lsp", WHAT, over, 1, note=f"{both[0]:.0f} ms, of which `validate` {both[1]:.0f} ms")]


def _text(number: int) -> str:
    """A scene of so many lines, another for each number."""
    lines = scene_text(LINES // 4).splitlines()[:LINES]
    while not lines[-1].startswith("  ") or lines[-1].startswith("   "):
        del lines[-1]
    lines[-1] = f"  last_{number}: {{shapes: [{{type: sphere, radius: 0.1}}]}}"
    return "\n".join(lines) + "\n"


class _Server:
    """A process of the server, with one file open in it."""

    def __init__(self, folder: Path) -> None:
        self._uri = (folder / "scene.yaml").as_uri()
        self._version = 0
        command = [sys.executable, "-m", "scenecc", "lsp"]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, cwd=folder)

    def __enter__(self) -> Self:
        capabilities: dict[str, Any] = {"processId": None, "rootUri": None, "capabilities": {}}
        self._send({"id": 1, "method": "initialize", "params": capabilities})
        self._send({"method": "initialized", "params": {}})
        document = {"uri": self._uri, "languageId": "yaml", "version": 0, "text": ""}
        self._send({"method": "textDocument/didOpen", "params": {"textDocument": document}})
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.communicate()

    def type(self, text: str) -> None:
        """Changes the text and waits for its findings."""
        self._version += 1
        document = {"uri": self._uri, "version": self._version}
        changes = {"textDocument": document, "contentChanges": [{"text": text}]}
        self._send({"method": "textDocument/didChange", "params": changes})
        while True:
            found = self._receive()
            is_one = found.get("method") == "textDocument/publishDiagnostics"
            if is_one and found["params"].get("version") == self._version:
                return

    def _send(self, message: dict[str, Any]) -> None:
        data = json.dumps({"jsonrpc": "2.0", **message}).encode()
        assert self._process.stdin is not None
        self._process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(data) + data)
        self._process.stdin.flush()

    def _receive(self) -> dict[str, Any]:
        stream = self._process.stdout
        assert stream is not None
        length = 0
        while line := stream.readline().strip():
            if line.lower().startswith(b"content-length:"):
                length = int(line.split(b":")[1])
        return json.loads(stream.read(length))
