"""A client of `scenecc lsp` that speaks the protocol over pipes."""

from __future__ import annotations

import itertools
import json
import queue
import subprocess
import sys
import threading
from pathlib import Path

SECONDS = 60


class LanguageClient:
    """A process of the server, with its messages."""

    def __init__(self, folder: Path, *, command: list[str] | None = None) -> None:
        self._process = subprocess.Popen(
            command or [sys.executable, "-m", "scenecc", "lsp"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=folder,
        )
        self.pid = self._process.pid
        self._numbers = itertools.count(1)
        self._messages: queue.Queue = queue.Queue()
        self._kept: list[dict] = []
        self._versions: dict[str, int] = {}
        self.errors = b""
        self._readers = [threading.Thread(target=each, daemon=True) for each in (self._read, self._read_errors)]
        for thread in self._readers:
            thread.start()

    def _read(self) -> None:
        stream = self._process.stdout
        assert stream is not None
        while line := stream.readline():
            length = 0
            while line.strip():
                if line.lower().startswith(b"content-length:"):
                    length = int(line.split(b":")[1])
                line = stream.readline()
            self._messages.put(json.loads(stream.read(length)))
        self._messages.put(None)

    def _read_errors(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            self.errors += line

    def send(self, message: dict) -> None:
        data = json.dumps({"jsonrpc": "2.0", **message}).encode()
        assert self._process.stdin is not None
        self._process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(data) + data)
        self._process.stdin.flush()

    def notify(self, method: str, **params) -> None:
        self.send({"method": method, "params": params})

    def ask(self, method: str, params: dict | None = None):
        """The answer to a request: its result, or its error as a mapping with `code` and `message`."""
        number = next(self._numbers)
        self.send({"id": number, "method": method, "params": params})
        answer = self.wait(lambda one: one.get("id") == number and "method" not in one)
        return answer["error"] if "error" in answer else answer["result"]

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

    def initialize(self, folder: Path, encodings: tuple[str, ...] = (), *, shows: bool = False) -> dict:
        """`shows`: whether it can show a place that the server asks for."""
        general = {"positionEncodings": list(encodings)} if encodings else {}
        watched = {"didChangeWatchedFiles": {"dynamicRegistration": True}}
        capabilities = {"general": general, "textDocument": {}, "workspace": watched}
        if shows:
            capabilities["window"] = {"showDocument": {"support": True}}
        answer = self.ask("initialize", {"processId": None, "rootUri": folder.as_uri(), "capabilities": capabilities})
        self.notify("initialized")
        asked = self.wait(lambda one: one.get("method") == "client/registerCapability")
        self.send({"id": asked["id"], "result": None})
        return answer

    def open(self, path: Path, text: str | None = None) -> list[dict]:
        """Opens a file and waits for its findings."""
        self._versions[path.as_uri()] = 1
        text = path.read_text() if text is None else text
        document = {"uri": path.as_uri(), "languageId": "yaml", "version": 1, "text": text}
        self.notify("textDocument/didOpen", textDocument=document)
        return self.findings(path, 1)

    def change(self, path: Path, text: str) -> int:
        version = self._versions[path.as_uri()] = self._versions[path.as_uri()] + 1
        document = {"uri": path.as_uri(), "version": version}
        self.notify("textDocument/didChange", textDocument=document, contentChanges=[{"text": text}])
        return version

    def close(self, path: Path) -> None:
        self.notify("textDocument/didClose", textDocument={"uri": path.as_uri()})

    def findings(self, path: Path, version: int | None) -> list[dict]:
        """The next findings of a version of a file; None: of one that was closed."""

        def wanted(message: dict) -> bool:
            params = message.get("params") or {}
            is_one = message.get("method") == "textDocument/publishDiagnostics" and params["uri"] == path.as_uri()
            return is_one and params.get("version") == version

        return self.wait(wanted)["params"]["diagnostics"]

    def has_findings(self, path: Path, version: int) -> bool:
        """Whether findings of a version have come that nobody asked for."""
        told = [one["params"] for one in self._kept if one.get("method") == "textDocument/publishDiagnostics"]
        return any((one["uri"], one.get("version")) == (path.as_uri(), version) for one in told)

    def has_asked(self, method: str) -> bool:
        """Whether the server has sent a message that nobody waited for."""
        return any(one.get("method") == method for one in self._kept)

    def at(self, method: str, path: Path, line: int, character: int, **more):
        """The answer to a request about a 0-based place."""
        position = {"line": line, "character": character}
        place = {"textDocument": {"uri": path.as_uri()}, "position": position}
        return self.ask(f"textDocument/{method}", {**place, **more})

    def end(self) -> int:
        """Ends the server as an editor does; its status."""
        self.ask("shutdown")
        self.send({"method": "exit"})
        return self.status()

    def status(self) -> int:
        """Waits for the server's end."""
        status = self._process.wait(SECONDS)
        self.kill()
        return status

    def kill(self) -> None:
        """Ends the process, if it has not ended, and what reads its output."""
        self._process.kill()
        self._process.wait()
        for thread in self._readers:
            thread.join()
        for stream in (self._process.stdin, self._process.stdout, self._process.stderr):
            assert stream is not None
            stream.close()
