"""Both ends of what pages and editors tell each other, over real sockets."""

from __future__ import annotations

import json
import queue
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import pytest

from scenecc.selection_link import Place, SelectionLink

CUBE = Place("/a b/ö.yaml", ("entities", "cube"))
LAMP = Place("/a/desk.yaml", ("entities", "lamp"))
SECONDS = 20


class End:
    """One end, and what it has heard."""

    def __init__(self, here: Literal["page", "editor"]) -> None:
        self.heard: queue.Queue[list[Place]] = queue.Queue()
        self.link = SelectionLink(here, self.heard.put)

    def hears(self) -> list[Place]:
        return self.heard.get(timeout=SECONDS)


@pytest.fixture
def folder(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    above = tmp_path_factory.mktemp("run")  # the path of a socket is short
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(above))
    return above / "scenecc"


@pytest.fixture
def ends(folder: Path) -> Iterator[tuple[End, End]]:
    page, editor = End("page"), End("editor")
    yield page, editor
    page.link.close()
    editor.link.close()


def test_each_end_sends_only_to_the_other_kind(ends: tuple[End, End]) -> None:
    page, editor = ends
    second = End("page")
    editor.link.send([CUBE])
    assert (page.hears(), second.hears()) == ([CUBE], [CUBE])
    page.link.send([LAMP, CUBE])
    assert editor.hears() == [LAMP, CUBE]
    second.link.close()
    editor.link.send([LAMP])
    assert page.hears() == [LAMP]
    assert second.heard.empty()
    assert page.heard.empty()


HOSTILE = {
    "nothing": b"",
    "no JSON": b"[[",
    "no list": b'{"file": "/a", "path": []}',
    "a file alone": b'[["/a"]]',
    "too much": b'[["/a", ["b"], "rm"]]',
    "a file that is none": b'[[["/a"], ["b"]]]',
    "a path that is none": b'[["/a", "entities"]]',
    "a key that is none": b'[["/a", [1.5, null]]]',
    "deep": b"[" * 60_000,
    "no UTF-8": b'[["/\xff", ["b"]]]',
    "digits": b'[["/a", [' + b"9" * 50_000 + b"]]]",
    "large": json.dumps([["/a", ["b" * 2**16]]]).encode(),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_invalid_messages_are_dropped(ends: tuple[End, End], folder: Path, case: str) -> None:
    page, editor = ends
    (address,) = folder.glob("page-*")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as stranger:
        stranger.sendto(HOSTILE[case], str(address))
    editor.link.send([CUBE])
    assert page.hears() == [CUBE]


def test_sending_does_not_wait_for_a_busy_end(ends: tuple[End, End], folder: Path) -> None:
    _, editor = ends
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as busy:
        busy.bind(str(folder / "page-busy"))
        for _ in range(2_000):
            editor.link.send([CUBE])


def test_only_the_user_can_enter_the_socket_folder(ends: tuple[End, End], folder: Path) -> None:
    assert folder.stat().st_mode & 0o777 == 0o700
    assert len([*folder.iterdir()]) == 2


def test_a_socket_folder_of_another_user_is_not_used(folder: Path) -> None:
    folder.mkdir(mode=0o755)
    end = End("page")
    end.link.send([CUBE])
    end.link.close()
    assert [*folder.iterdir()] == []


def test_a_closed_end_removes_its_socket_and_sends_nothing(folder: Path) -> None:
    page, editor = End("page"), End("editor")
    page.link.close()
    editor.link.close()
    page.link.send([CUBE])
    assert [*folder.iterdir()] == []


WAITING = """\
import sys
from scenecc.interrupt import end_at_signals
from scenecc.selection_link import SelectionLink
end_at_signals()
link = SelectionLink("page", print)
print("ready", flush=True)
sys.stdin.read()
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_sockets_of_killed_processes_are_removed(folder: Path, number: int) -> None:
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", WAITING], stdin=pipe, stdout=pipe) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        assert len([*folder.glob("page-*")]) == 1
        process.send_signal(number)
    editor = End("editor")
    if number == signal.SIGKILL:
        editor.link.send([CUBE])
    assert [*folder.glob("page-*")] == []
    editor.link.close()


def test_without_a_runtime_folder_the_cache_is_used(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = tmp_path_factory.mktemp("cache")
    monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    end = End("page")
    assert len([*(cache / "scenecc" / "selection").glob("page-*")]) == 1
    end.link.close()
