"""One browser for all tests, and `scenecc view` for those that ask."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from plugins.browser import Viewer, console_errors, hosts_asked, missing, start_browser

View = Callable[..., Viewer]


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Selenium's driver of a headless Chromium, which draws on the CPU and reaches no other host."""
    reason = missing()
    if reason:
        pytest.skip(reason)
    driver = start_browser(tmp_path_factory.mktemp("profile"))
    try:
        yield driver
    finally:
        driver.quit()


@pytest.fixture(scope="module")
def view(tmp_path_factory: pytest.TempPathFactory) -> Iterator[View]:
    """Starts `scenecc view` with some arguments; after the module's tests each one must end in peace."""
    with contextlib.ExitStack() as started:

        def view(*arguments: str | Path) -> Viewer:
            viewer = Viewer(arguments, tmp_path_factory.mktemp("view"))
            started.callback(viewer.stop)
            return viewer

        yield view


@pytest.fixture(autouse=True)
def nothing_wrong(browser: Any) -> Iterator[None]:
    """Holds for every test that its pages have no error on the console and ask no other host."""
    yield
    assert console_errors(browser) == []
    assert hosts_asked(browser) <= {"127.0.0.1", ""}
