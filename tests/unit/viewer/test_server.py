"""The server of a page: who may talk to it, and where it listens."""

from __future__ import annotations

import gc
import re
import socket
from collections.abc import Iterator
from contextlib import suppress
from typing import Any
from urllib.error import HTTPError
from urllib.parse import quote
from urllib.request import Request, urlopen

import pytest

pytest.importorskip("viser", reason="needs the extra `view`")

import msgspec
import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from scenecc import PageAddress
from scenecc.viewer.server import PageServer
from scenecc.viewer.view import page_url


@pytest.fixture
def server() -> Iterator[PageServer]:
    made = PageServer(PageAddress(port=0), "a label")
    yield made
    made.close()


def opened(server: PageServer, origin: str | None, headers: dict[str, str] | None = None) -> Any:
    protocols: Any = [f"viser-v{viser.__version__}"]
    where: Any = origin
    return connect(
        f"ws://127.0.0.1:{server.port}",
        origin=where,
        subprotocols=protocols,
        compression=None,
        additional_headers=headers,
    )


@pytest.mark.parametrize(
    "origin",
    [None, "http://127.0.0.1:{port}", "http://localhost:{port}", "http://localhost:9", "https://[::1]"],
)
def test_a_page_of_this_machine_may_connect(server: PageServer, origin: str | None) -> None:
    where = None if origin is None else origin.format(port=server.port)
    with opened(server, where) as page:
        assert page.recv(10)


@pytest.mark.parametrize(
    "origin",
    ["https://example.org", "http://127.0.0.1.example.org", "http://localhost.example.org:80", "null", "file://"],
)
def test_a_page_of_another_site_may_not_connect(server: PageServer, origin: str) -> None:
    with pytest.raises(InvalidStatus) as caught:
        opened(server, origin)
    assert caught.value.response.status_code == 403


@pytest.mark.parametrize(
    ("host", "closed"),
    [("127.0.0.1", True), ("127.0.1.1", True), ("localhost", True), ("::1", True), ("0.0.0.0", False), ("box", False)],
)
def test_every_loopback_address_is_closed_to_other_sites(host: str, closed: bool) -> None:
    assert PageAddress(host).is_local is closed


@pytest.mark.parametrize("host", ["", " "])
def test_an_empty_host_is_refused(host: str) -> None:
    """The system takes it for every address of the machine."""
    with pytest.raises(ValueError, match=r"a host must be an address or host name.*0\.0\.0\.0"):
        PageAddress(host=host)


def test_viser_listens_where_no_page_of_another_site_can_guess_it(server: PageServer) -> None:
    host, port = server.viser.get_host(), server.viser.get_port()
    assert re.fullmatch(r"127(\.\d+){3}", host)
    assert host != "127.0.0.1"
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port))


def test_a_page_cannot_publish_the_server(server: PageServer, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*given: object) -> None:
        raise AssertionError(f"a tunnel was asked for: {given}")

    monkeypatch.setattr("viser._viser.ViserTunnel", never)
    assert server.viser.request_share_url() is None


def test_a_port_in_use_and_an_unknown_host_are_refused(server: PageServer) -> None:
    with pytest.raises(OSError, match="in use"):
        PageServer(PageAddress(port=server.port), "")
    with pytest.raises(OSError, match="assign"):
        PageServer(PageAddress(host="192.0.2.1", port=0), "")


def test_without_a_port_the_first_free_one_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        first = taken.getsockname()[1]
        monkeypatch.setattr("scenecc.viewer.server._FIRST", first)
        made = PageServer(PageAddress(), "")
        assert first < made.port < first + 100
        made.close()


def test_the_viewer_library_prints_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    PageServer(PageAddress(port=0), "").close()
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("host", "opened"), [("127.0.0.1", "127.0.0.1"), ("::1", "[::1]"), ("box", "box"), ("192.0.2.7", "192.0.2.7")]
)
def test_the_printed_address_opens_in_a_browser(host: str, opened: str) -> None:
    assert page_url(PageAddress(host, token=None), 81) == f"http://{opened}:81"


@pytest.mark.parametrize(("host", "nowhere"), [("0.0.0.0", "0.0.0.0"), ("::", "[::]")])
def test_the_address_of_a_public_page_is_one_of_this_machine(host: str, nowhere: str) -> None:
    found = re.fullmatch(r"http://(.+):81/\?token=a%2Fb", page_url(PageAddress(host, token="a/b"), 81))
    assert found is not None
    assert found[1] != nowhere
    with socket.create_server((found[1].strip("[]"), 0), family=socket.AF_INET6 if "[" in found[1] else socket.AF_INET):
        pass  # nobody else has this address


def asked(server: PageServer, path: str, **headers: str) -> tuple[int, str]:
    """Status and cookie of an answer."""
    request = Request(f"http://127.0.0.1:{server.port}{path}", headers=headers)
    try:
        with urlopen(request, timeout=20) as answer:
            return answer.status, answer.headers.get("Set-Cookie", "")
    except HTTPError as error:
        with error:
            return error.code, error.headers.get("Set-Cookie", "")


def test_a_token_grants_access_to_the_page() -> None:
    server = PageServer(PageAddress(port=0, token="a/b c"), "")
    try:
        for path in ("/", "/?token=", "/?token=a/b", "/?token=%F0%9F%98%80", "/index.html", "/?other=a/b c"):
            assert asked(server, quote(path, safe="/?=&%")) == (403, "")
        status, cookie = asked(server, "/?token=a%2Fb%20c")
        name = f"scenecc-{server.port}"
        assert (status, cookie) == (200, f"{name}=a%2Fb%20c; HttpOnly; SameSite=Strict; Path=/")
        held = cookie.partition(";")[0]
        assert asked(server, "/", Cookie=held) == (200, "")
        for wrong in (f"{name}=", f"{name}=a", "scenecc-1=a%2Fb%20c", "=;,", held.replace("a", "é")):
            assert asked(server, "/", Cookie=wrong) == (403, "")
            with pytest.raises(InvalidStatus) as caught:
                opened(server, None, {"Cookie": wrong})
            assert caught.value.response.status_code == 403
        with opened(server, None, {"Cookie": f"other=1; {held}"}) as page:
            assert page.recv(10)
    finally:
        server.close()


@pytest.mark.parametrize("token", ["", "schlüssel"])
def test_a_token_that_does_not_fit_in_an_address_is_refused(token: str) -> None:
    with pytest.raises(ValueError, match="a token must have one or more ASCII characters"):
        PageAddress(token=token)


@pytest.mark.parametrize("host", ["x" * 64 + ".invalid", "..", "a\udcff"])
def test_an_invalid_host_name_is_an_unknown_host(host: str) -> None:
    with pytest.raises(OSError, match=r".+"):
        PageServer(PageAddress(host, 0), "")


def test_a_stopped_server_disconnects_browsers() -> None:
    server = PageServer(PageAddress(port=0), "")
    with opened(server, None) as page, suppress(ConnectionClosed):
        page.recv(10)
        server.close()
        list(page)  # ends with the connection
    with pytest.raises(OSError, match=r".+"):
        opened(server, None)


def test_only_the_page_is_served(server: PageServer) -> None:
    assert [asked(server, path)[0] for path in ("/", "/index.html", "/x", "/../pyproject.toml")] == [200, 200, 404, 404]
    with urlopen(f"http://127.0.0.1:{server.port}/?name=a", timeout=20) as answer:
        assert b"<title>a label</title>" in answer.read()


def test_invalid_messages_close_their_connection_silently(
    server: PageServer, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    box = server.viser.gui.add_number("a number", initial_value=1.0)
    updates = [{"value": "x"}, {"nothing": 1}, [1], None]
    known = [{"type": "GuiUpdateMessage", "uuid": box._impl.uuid, "updates": update} for update in updates]
    others: list[Any] = [{}, [], 3, {"type": "Nothing"}, {"type": 3}, {"type": "GuiUpdateMessage"}]
    for message in [b"", b"\xff" * 9, "text", b"x" * (51 << 20), *map(msgspec.msgpack.encode, [*known, *others])]:
        with opened(server, None) as page, suppress(ConnectionClosed):
            page.send(message)
            with suppress(TimeoutError):
                while True:
                    page.recv(0.2)
    with socket.create_connection(("127.0.0.1", server.port)) as plain:
        plain.sendall(b"\x00\xff" * 1000)
    gc.collect()  # of a task whose error nobody took, Python tells when it is freed
    with opened(server, None) as page:
        assert page.recv(10)
    assert capfd.readouterr() == ("", "")
    assert caplog.records == []
