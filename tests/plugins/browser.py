"""Chromium steered by Selenium, and `scenecc view` as a process whose pages it opens."""

from __future__ import annotations

import functools
import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import urlsplit

from cli.running import plain_environment

Value = TypeVar("Value")

ELSEWHERE = "elsewhere.test"
"""A host that the browser takes for another one, and that is this one."""

_PACKAGES = ("selenium", "viser", "watchfiles")
_FLAGS = (
    "--headless=new",
    "--window-size=1280,800",
    "--no-sandbox",  # CI runs as root
    "--disable-dev-shm-usage",  # a container's /dev/shm is too small for it
    # WebGL on the CPU.
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    # No other host than this one: a page that asked one would have an error.
    f"--host-resolver-rules=MAP {ELSEWHERE} 127.0.0.1, MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
    "--no-proxy-server",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
_PREFERENCES = {"session.restore_on_startup": 4, "session.startup_urls": ["about:blank"]}
"""No first page of its own, which would ask for a hundred files."""


@functools.cache
def programs() -> tuple[str, str] | None:
    """Chromium and its driver: those that `.ci/chromium` names, or the machine's."""
    chromium = os.environ.get("SCENECC_TEST_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    driver = os.environ.get("SCENECC_TEST_CHROMEDRIVER") or shutil.which("chromedriver")
    return (chromium, driver) if chromium and driver else None


@functools.cache
def missing() -> str | None:
    """What a test in a browser has not got here."""
    if programs() is None:
        return 'chromium or chromedriver is missing: . "$(.ci/chromium FOLDER)"'
    absent = [name for name in _PACKAGES if importlib.util.find_spec(name) is None]
    return f"{', '.join(absent)} not installed: pip install -e '.[test]'" if absent else None


def start_browser(profile: Path) -> Any:
    """A driver of a new Chromium. `profile`: an empty folder."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    found = programs()
    assert found is not None
    options = webdriver.ChromeOptions()
    options.binary_location, driver = found
    for flag in (*_FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.add_experimental_option("prefs", _PREFERENCES)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    # With its place given, Selenium looks for no driver on the network.
    browser = webdriver.Chrome(options=options, service=Service(executable_path=driver))
    browser.set_page_load_timeout(60)
    browser.set_script_timeout(60)
    return browser


def console_errors(browser: Any) -> list[str]:
    """What the console says is an error, since it was last asked."""
    return [entry["message"] for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]


def hosts_asked(browser: Any) -> set[str]:
    """The hosts of all that pages asked for, since it was last asked; "" for what is no host's."""
    asked: set[str] = set()
    for entry in browser.get_log("performance"):
        event = json.loads(entry["message"])["message"]
        if event["method"] == "Network.requestWillBeSent":
            asked.add(urlsplit(event["params"]["request"]["url"]).hostname or "")
        elif event["method"] == "Network.webSocketCreated":
            asked.add(urlsplit(event["params"]["url"]).hostname or "")
    return asked


def soon(ask: Callable[[], Value], wanted: Callable[[Value], Any] = bool, *, within: float = 30) -> Value:
    """Asks until the answer is as wanted. AssertionError with the last answer, if it is not in time [s]."""
    end = time.monotonic() + within
    while True:
        answer = ask()
        if wanted(answer):
            return answer
        assert time.monotonic() < end, f"after {within} s: {answer!r}"
        time.sleep(0.05)


class Viewer:
    """`scenecc view` as a process. `url`: where it serves its page."""

    def __init__(self, arguments: Iterable[str | Path], folder: Path) -> None:
        self._out, self._err = folder / "out", folder / "err"
        with self._out.open("w") as out, self._err.open("w") as err:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "scenecc", "view", *map(str, arguments), "--port", "0"],
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=err,
                env=plain_environment(),
            )
        try:
            self.url = soon(self._announced, within=60)
        except BaseException:
            self._process.kill()
            self._process.wait()
            raise

    def _announced(self) -> str:
        assert self._process.poll() is None, self.said
        found = re.search(r"http://127\.0\.0\.1:\d+", self._out.read_text())
        return found[0] if found else ""

    @property
    def said(self) -> str:
        """All that it wrote, to both streams."""
        return self._out.read_text() + self._err.read_text()

    def stop(self) -> None:
        """Ends it as Ctrl-C does, and holds that it ends in peace."""
        self._process.send_signal(signal.SIGINT)
        try:
            status = self._process.wait(timeout=20)
        finally:
            self._process.kill()
            self._process.wait()
        assert "Traceback" not in self.said, self.said
        assert status in {0, 130}, (status, self.said)
