"""The server of a page: who may talk to it, and where it listens."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("viser", reason="needs the extra `view`")

import viser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from scenecc.viewing.look import Place
from scenecc.viewing.server import close_server, open_server
from scenecc.viewing.view import address


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    made = open_server(Place(port=0), "a label")
    yield made
    close_server(made)


def opened(server: viser.ViserServer, origin: str | None) -> Any:
    protocols: Any = [f"viser-v{viser.__version__}"]
    where: Any = origin
    return connect(f"ws://127.0.0.1:{server.get_port()}", origin=where, subprotocols=protocols, compression=None)


@pytest.mark.parametrize(
    "origin",
    [None, "http://127.0.0.1:{port}", "http://localhost:{port}", "http://localhost:9", "https://[::1]"],
)
def test_a_page_of_this_machine_may_talk(server: viser.ViserServer, origin: str | None) -> None:
    where = None if origin is None else origin.format(port=server.get_port())
    with opened(server, where) as page:
        assert page.recv(10)


@pytest.mark.parametrize(
    "origin",
    ["https://example.org", "http://127.0.0.1.example.org", "http://localhost.example.org:80", "null", "file://"],
)
def test_a_page_of_another_site_may_not(server: viser.ViserServer, origin: str) -> None:
    with pytest.raises(InvalidStatus) as caught:
        opened(server, origin)
    assert caught.value.response.status_code == 403


@pytest.mark.parametrize(
    ("host", "closed"),
    [("127.0.0.1", True), ("127.0.1.1", True), ("localhost", True), ("::1", True), ("0.0.0.0", False), ("box", False)],
)
def test_every_loopback_address_is_closed_to_other_sites(host: str, closed: bool) -> None:
    from scenecc.viewing.server import _is_loopback

    assert _is_loopback(host) is closed


def test_a_page_cannot_make_it_public(server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*given: object) -> None:
        raise AssertionError(f"a tunnel was asked for: {given}")

    monkeypatch.setattr("viser._viser.ViserTunnel", never)
    assert server.request_share_url() is None


def test_a_port_in_use_and_an_address_of_nobody_are_refused(server: viser.ViserServer) -> None:
    with pytest.raises(OSError, match="in use"):
        open_server(Place(port=server.get_port()), "")
    with pytest.raises(OSError, match="assign"):
        open_server(Place(host="192.0.2.1", port=0), "")


def test_without_a_port_the_first_that_is_free_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        first = taken.getsockname()[1]
        monkeypatch.setattr("scenecc.viewing.server._FIRST", first)
        made = open_server(Place(), "")
        assert first < made.get_port() < first + 100
        close_server(made)


def test_nothing_of_it_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    close_server(open_server(Place(port=0), ""))
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("host", "opened"), [("127.0.0.1", "127.0.0.1"), ("0.0.0.0", "localhost"), ("::1", "[::1]"), ("box", "box")]
)
def test_an_address_is_one_that_a_browser_opens(host: str, opened: str) -> None:
    assert address(Place(host), 81) == f"http://{opened}:81"
