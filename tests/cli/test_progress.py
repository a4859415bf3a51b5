"""What a terminal shows while something lasts."""

from __future__ import annotations

import logging
import os
import pty
import select
import threading
import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace

import pytest

from scenecc.cli import output
from scenecc.cli.output import counted, progress

CLEAR = "\r\x1b[K"


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], str]]:
    """Standard error is a terminal: what has been written to it, once that holds a text."""
    main, other = pty.openpty()

    def read(text: str) -> str:
        found, end = "", time.monotonic() + 20
        while text not in found and time.monotonic() < end:
            if select.select([main], [], [], 0.01)[0]:
                found += os.read(main, 65536).decode()
        return found

    with os.fdopen(other, "w") as stream:
        monkeypatch.setattr(output, "sys", SimpleNamespace(stderr=stream))
        monkeypatch.setattr(output, "_PATIENCE", 0)
        monkeypatch.setattr(output, "_EVERY", 0.01)
        yield read
    os.close(main)


def test_the_bar_shows_time_and_current_work_before_counting(shown: Callable[[str], str]) -> None:
    with progress("build") as show:
        assert show is not None
        assert f"{CLEAR}build " in shown(" s")
        logging.getLogger("scenecc.anything").info("CoACD cuts %s", "bowl\x1b.obj")
        assert " s: CoACD cuts bowl␛.obj" in shown(".obj")
        show(1, 4)
        assert f"{CLEAR}build [##########------------------------------] 1/4" in shown("1/4")
    assert shown(CLEAR).endswith(CLEAR)


def test_the_clock_thread_ends_with_the_bar(shown: Callable[[str], str]) -> None:
    before, threads = list(logging.getLogger("scenecc").handlers), threading.active_count()
    with progress("build"):
        shown("build")
    assert shown(CLEAR).endswith(CLEAR)
    assert (logging.getLogger("scenecc").handlers, threading.active_count()) == (before, threads)


def test_forking_work_has_a_bar_without_a_thread(shown: Callable[[str], str]) -> None:
    before = threading.active_count()
    for _ in counted("files", range(3)):
        assert threading.active_count() == before
        time.sleep(0.02)
    assert f"{CLEAR}files [" in shown("/3")


def test_short_work_shows_no_bar(shown: Callable[[str], str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(output, "_PATIENCE", 60)
    with progress("build") as show:
        assert show is not None
        show(1, 2)
        time.sleep(0.05)
    assert shown(CLEAR) == CLEAR
