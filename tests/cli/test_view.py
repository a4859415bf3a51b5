"""`scenecc view` as a process; what its page shows is seen by tests/browser."""

from __future__ import annotations

import re
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import urlopen

import pytest
from cli.running import CUBE, plain_environment
from plugins.struck import hears

viser = pytest.importorskip("viser", reason="needs the extra `view`")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(CUBE)
    return path


def started(*arguments: str, given: str | None = None, folder: Path) -> subprocess.Popen[str]:
    pipe = subprocess.PIPE
    process = subprocess.Popen(
        [sys.executable, "-m", "scenecc", "view", *arguments],
        stdin=pipe,
        stdout=pipe,
        stderr=pipe,
        text=True,
        cwd=folder,
        env=plain_environment(),
    )
    assert process.stdin is not None
    process.stdin.write(given or "")
    process.stdin.close()
    return process


def ended(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    """Exit status, output and errors after Ctrl-C."""
    with process:
        process.send_signal(signal.SIGINT)
        status = process.wait(30)
        assert process.stdout is not None
        assert process.stderr is not None
        return status, process.stdout.read(), process.stderr.read()


def test_view_serves_a_page_until_interrupted(scene: Path, tmp_path: Path) -> None:
    process = started(scene.name, "--port", "0", folder=tmp_path)
    assert process.stdout is not None
    url = process.stdout.readline().strip()
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+", url)
    with urlopen(url, timeout=20) as page:
        assert b"<html" in page.read()[:500]
    assert ended(process) == (130, "", "Press Ctrl-C to stop.\n")


def test_a_public_page_has_a_token_unless_that_is_refused(scene: Path, tmp_path: Path) -> None:
    process = started(scene.name, "--port", "0", "--host", "0.0.0.0", "--no-token", folder=tmp_path)
    assert process.stdout is not None
    url = process.stdout.readline().strip()
    assert "0.0.0.0" not in url
    with urlopen(url, timeout=20) as page:
        assert page.status == 200
    status, _, errors = ended(process)
    assert (status, errors.splitlines()[0].startswith("WARNING: anyone who can reach")) == (130, True)

    process = started(scene.name, "--port", "0", "--host", "0.0.0.0", folder=tmp_path)
    assert process.stdout is not None
    url = process.stdout.readline().strip()
    bare, _, token = url.partition("/?token=")
    assert len(token) > 40
    with urlopen(url, timeout=20) as page:
        assert page.status == 200
    with pytest.raises(HTTPError) as caught:
        urlopen(bare, timeout=20)
    with caught.value as error:
        assert error.code == 403
    assert ended(process) == (130, "", "Press Ctrl-C to stop.\n")


def test_the_viewer_survives_a_disconnected_browser(scene: Path, tmp_path: Path) -> None:
    process = started(scene.name, "--port", "0", folder=tmp_path)
    assert process.stdout is not None
    url = process.stdout.readline().strip()
    for _ in range(8):
        client = socket.create_connection(("127.0.0.1", int(url.rpartition(":")[2])))
        client.sendall(
            b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
            b"Sec-WebSocket-Protocol: viser-v" + viser.__version__.encode() + b"\r\n\r\n"
        )
        client.recv(1)
        # A reset in place of a farewell.
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        client.close()
    with urlopen(url, timeout=20) as page:
        assert page.status == 200
    assert ended(process)[0] == 130


@pytest.mark.parametrize("after", [0, *(pytest.param(each, marks=pytest.mark.slow) for each in (0.2, 0.7, 1.2))])
def test_an_interrupt_at_any_time_ends_the_viewer_cleanly(scene: Path, tmp_path: Path, after: float) -> None:
    process = started(scene.name, "--port", "0", folder=tmp_path)
    while process.poll() is None and not hears(process.pid):  # until then, Python is starting
        time.sleep(0.01)
    time.sleep(after)
    status, _, errors = ended(process)
    assert (status, errors) in {(130, ""), (130, "Press Ctrl-C to stop.\n")}


@pytest.mark.parametrize(("text", "told"), [(CUBE.replace("box", "bx"), "SC105"), ("scenecc: [", "SC00")])
def test_the_viewer_reports_errors_and_waits_for_a_fix(scene: Path, tmp_path: Path, text: str, told: str) -> None:
    scene.write_text(text)
    process = started(scene.name, "--port", "0", folder=tmp_path)
    assert process.stdout is not None
    assert process.stdout.readline().startswith("http://")
    status, output, errors = ended(process)
    assert (status, output) == (130, "")
    assert told in errors
    assert "Traceback" not in errors


def test_the_viewer_reports_a_fixed_scene(scene: Path, tmp_path: Path) -> None:
    good = scene.read_text()
    scene.write_text(good.replace("box", "bx"))
    process = started(scene.name, "--port", "0", folder=tmp_path)
    assert process.stdout is not None
    assert process.stderr is not None
    assert process.stdout.readline().startswith("http://")
    scene.write_text(good)
    for line in process.stderr:
        if line == "scene.yaml: no errors\n":
            break
    assert ended(process)[0] == 130


def test_view_reads_a_scene_from_standard_input(tmp_path: Path) -> None:
    process = started("-", "--port", "0", given=CUBE, folder=tmp_path)
    assert process.stdout is not None
    assert process.stdout.readline().startswith("http://")
    assert ended(process)[::2] == (130, "Press Ctrl-C to stop.\n")


def test_view_export_writes_one_file(run, scene: Path, tmp_path: Path) -> None:
    done = run("view", scene, "-o", "page.html", "--steps", "5")
    assert done.returncode == 0, done.stderr
    assert re.fullmatch(r"page\.html: \d+\.\d\d MB\n", done.stdout)
    assert "<title>scene</title>" in (tmp_path / "page.html").read_text()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["page.html", "scene.yaml"]


def test_view_export_of_a_bad_scene_writes_nothing(run, scene: Path, tmp_path: Path) -> None:
    scene.write_text(CUBE.replace("box", "bx"))
    done = run("view", scene, "-o", "page.html")
    assert (done.returncode, done.stdout) == (1, "")
    assert "SC105" in done.stderr
    assert not (tmp_path / "page.html").exists()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--steps", "5"], "it needs -o FILE.html"),
        (["-o", "page.txt"], "'page.txt' must end in .html"),
        (["-o", "page.html", "--open"], "because no page is served"),
        (["-o", "page.html", "--host", "127.0.0.1"], "because no page is served"),
        (["-o", "page.html", "--port", "0"], "because no page is served"),
        (["-o", "no/page.html"], "SC904"),
        (["-o", "page.html", "--token", "auto"], "because no page is served"),
        (["--token", "a", "--no-token"], "it cannot be combined with --token"),
        (["--token", ""], "a token must have one or more ASCII characters"),
        (["--port", "65536"], "a port must be from 0 to 65535, not 65536"),
        (["--scene", "1", "--port", "0"], "SC908"),
        (["--scene", "1", "-o", "page.html"], "SC908"),
        (["--set", "size"], "must be name=value"),
    ],
)
def test_wrong_usage_of_view_gives_status_2(run, scene: Path, tmp_path: Path, arguments: list[str], told: str) -> None:
    done = run("view", scene, *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert told in done.stderr
    assert "Traceback" not in done.stderr


def test_a_missing_file_gives_status_2(run) -> None:
    done = run("view", "nowhere.yaml")
    assert done.returncode == 2
    assert "SC901" in done.stderr


def test_an_unknown_host_gives_status_3(run, scene: Path) -> None:
    done = run("view", scene, "--host", "nowhere.invalid", "--port", "0")
    assert (done.returncode, done.stdout) == (3, "")
    assert "SC815: no page can be served at nowhere.invalid, port 0: " in done.stderr
    assert "Unknown error" not in done.stderr


def test_a_port_in_use_gives_status_3(run, scene: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = run("view", scene, "--port", port)
    assert (done.returncode, done.stdout) == (3, "")
    assert f"scenecc: error SC815: no page can be served at 127.0.0.1, port {port}: Address already" in done.stderr
