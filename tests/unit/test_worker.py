"""Processes that read files of strangers: their messages."""

from __future__ import annotations

import io

from scenecc import worker_process


def test_half_a_message_is_none() -> None:
    whole = io.BytesIO()
    worker_process.write_message(whole, {"a": 1}, [b"one", b"", b"three"])
    data = whole.getvalue()
    assert worker_process.read_message(io.BytesIO(data)) == ({"a": 1, "sizes": [3, 0, 5]}, [b"one", b"", b"three"])
    assert all(worker_process.read_message(io.BytesIO(data[:end])) is None for end in range(len(data)))
