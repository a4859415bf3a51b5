"""`scenecc view`: a save, and many copies, against a start of the process. The page is any client of its WebSocket."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Generator
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from typing import Any

from benchmarks.paired import Row, alternating, best, ratios

OBJECTS = 200
WHAT = f"view: from a save to the page with {OBJECTS} objects / from the start of the process"
COPIES = 5000, 50
MANY = f"view: from the start of the process to the page with {COPIES[0]} boxes of as many colours / with {COPIES[1]}"
_TIMEOUT = 20


def run(repetitions: int) -> list[Row]:
    """A cold start and a reload in turn, each of a file that nobody has seen before."""
    if lacking := [name for name in ("viser", "watchfiles") if find_spec(name) is None]:
        note = f"not installed: {', '.join(lacking)}"
        return [Row("view", WHAT, (), 0.3, note=note), Row("view", MANY, (), 5.0, note=note)]
    numbers = count()
    with tempfile.TemporaryDirectory() as folder:
        saved, fresh = Path(folder, "saved.yaml"), Path(folder, "fresh.yaml")
        saved.write_text(_text(next(numbers)))
        with _page(saved) as page:
            _wait_for(page, 0)

            def reload() -> float:
                number = next(numbers)
                started = time.perf_counter()
                saved.write_text(_text(number))
                _wait_for(page, number)
                return time.perf_counter() - started

            def start() -> float:
                number = next(numbers)
                fresh.write_text(_text(number))
                started = time.perf_counter()
                with _page(fresh) as cold:
                    _wait_for(cold, number)
                    return time.perf_counter() - started

            rounds = alternating([reload, start], repetitions)
        crowds = alternating([partial(_start_crowd, fresh, count) for count in COPIES], repetitions)
    return [
        Row("view", WHAT, ratios(rounds, 0, 1), 0.3, note=f"{best(rounds, 0)}, {best(rounds, 1)} from the start"),
        Row("view", MANY, ratios(crowds, 0, 1), 5.0, note=f"{best(crowds, 0)} / {best(crowds, 1)}"),
    ]


def _start_crowd(scene: Path, count: int) -> float:
    """From the start of the process until its page has all of so many boxes, each of its own colour, and one more."""
    scene.write_text(
        "scenecc: 1\nentities:\n  box:\n"
        f"    repeat: {{i: {{count: {count}}}}}\n    pose: ['${{i % 71 * 0.3}}', '${{i // 71 * 0.3}}', 0.1]\n"
        f"    color: ['${{i / {count}}}', 0.5, 0.5]\n"
        "    shapes: [{type: box, half_size: [0.05, 0.05, 0.05]}]\n"
        "  last_0: {pose: [0, 0, 2], shapes: [{type: sphere, radius: 0.1}]}\n"
    )
    started = time.perf_counter()
    with _page(scene) as cold:
        # So few are nodes of their own.
        _wait_for(cold, 0, "/copies/" if count > COPIES[1] else f"/scene 0/box_{count - 1}/visual 0")
        return time.perf_counter() - started


def _text(number: int) -> str:
    """Boxes of many sizes and colours, and one whose name is new each time, the last to be shown."""
    lines = ["scenecc: 1", "entities:", "  ground: {body_type: static, shapes: [{type: plane}]}"]
    for index in range(OBJECTS - 1):
        place = [0.3 * (index % 20), 0.3 * (index // 20), 0.1 + 0.01 * (number % 7)]
        color = [round(index / OBJECTS, 3), 0.5, 0.5]
        size = [0.05, 0.05, round(0.05 + 0.0001 * index, 4)]
        lines.append(f"  box_{index}: {{pose: {place}, color: {color}, shapes: [{{type: box, half_size: {size}}}]}}")
    lines.append(f"  last_{number}: {{pose: [0, 0, 2], shapes: [{{type: sphere, radius: 0.1}}]}}")
    return "\n".join(lines) + "\n"


@contextmanager
def _page(scene: Path) -> Generator[Any]:
    """What a browser is told of a scene, message by message."""
    import viser
    from websockets.sync.client import connect
    from websockets.typing import Subprotocol

    command = [sys.executable, "-m", "scenecc", "view", str(scene), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        try:
            assert process.stdout is not None
            address = process.stdout.readline().strip().replace("http", "ws")
            protocol = Subprotocol(f"viser-v{viser.__version__}")
            with connect(address, subprotocols=[protocol], max_size=None, compression=None) as page:
                yield page
        finally:
            process.send_signal(signal.SIGINT)


def _wait_for(page: Any, number: int, *others: str) -> None:
    """Reads until the last object of a file is shown, and other nodes are, by the beginnings of their paths."""
    import zstandard

    wanted = {f"/scene 0/last_{number}/visual 0".encode(), *(path.encode() for path in others)}
    while True:
        message = page.recv(_TIMEOUT)
        # viser's messages: two lengths of 8 bytes, then what is compressed, then arrays.
        length = int.from_bytes(message[8:16], "little")
        content = zstandard.ZstdDecompressor().decompress(message[16 : 16 + length])
        wanted -= {path for path in wanted if path in content}
        if not wanted:
            return
