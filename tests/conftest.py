"""What every test shares: Hypothesis's profiles, and which tests this machine can run."""

from __future__ import annotations

import functools
import importlib.util
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest
from plugins import browser, nightly, slow

pytest_plugins = ["plugins.diagnostics"]

# The run before a merge says the same of the same code: no example is drawn anew. The nightly one draws others.
hypothesis.settings.register_profile("quick", deadline=None, derandomize=True, max_examples=nightly.examples(100))
hypothesis.settings.register_profile("nightly", deadline=None, max_examples=nightly.examples(100))
hypothesis.settings.load_profile("nightly" if nightly.NIGHTLY else "quick")

# What an earlier run has kept of meshes must not decide what this one finds. Workers share the folder.
if "PYTEST_XDIST_WORKER" not in os.environ:
    _cache = tempfile.TemporaryDirectory(prefix="scenecc-cache-")
    os.environ["XDG_CACHE_HOME"] = _cache.name

# `nohup` and shells in the background ignore these for all that they start; tests send them to processes of their own.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)


@functools.cache
def _can_render() -> bool:
    """Asked in a process of its own: a driver that fails may take its process with it."""
    script = "import sapien; sapien.Scene()"
    return subprocess.run([sys.executable, "-c", script], capture_output=True, check=False, timeout=60).returncode == 0


@pytest.fixture(scope="module")
def held_renderer() -> Iterator[None]:
    """Keeps SAPIEN's renderer while the tests of a module run: else each of them starts it anew, for seconds."""
    if not _can_render():
        pytest.skip("SAPIEN finds no device to render with")
    import sapien

    scene = sapien.Scene()
    yield
    scene.clear()


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """A run of one mark alone reads the files in which it stands, or in whose folder: most of its time went there."""
    one_mark = re.fullmatch(r"(render|maniskill|browser|gpu)( and not \w+)*", config.option.markexpr)
    if one_mark is None or collection_path.suffix != ".py":
        return None
    near = (collection_path, collection_path.with_name("conftest.py"))
    text = "".join(file.read_text("utf-8") for file in near if file.exists() and file != Path(__file__))
    return None if f"mark.{one_mark[1]}" in text else True


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--record-slow", action="store_true", help="write tests/slow_tests.txt from the times of this run")


def pytest_configure(config: pytest.Config) -> None:
    # A test that is named runs, slow or not.
    if config.option.markexpr == "not slow" and (config.option.record_slow or any("::" in arg for arg in config.args)):
        config.option.markexpr = ""
    if config.option.record_slow and not hasattr(config, "workerinput"):
        config.pluginmanager.register(slow.SlowTestRecorder())


@pytest.hookimpl(tryfirst=True)  # before `-m` deselects
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    slow.mark_slow_tests(items)
    for item in items:
        if item.get_closest_marker("render") and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(300))  # a software driver takes up to 20 s for a camera's first picture


def pytest_runtest_setup(item: pytest.Item) -> None:
    if item.get_closest_marker("render") and not _can_render():
        pytest.skip("SAPIEN finds no device to render with")
    if item.get_closest_marker("maniskill") and importlib.util.find_spec("mani_skill") is None:
        pytest.skip("mani_skill is not installed: pip install torch 'scenecc[maniskill]'")
    if item.get_closest_marker("browser") and (reason := browser.missing()):
        pytest.skip(reason)
    if item.get_closest_marker("gpu") and not os.environ.get("SCENECC_TEST_GPU"):
        pytest.skip("tests on a GPU run where SCENECC_TEST_GPU is set")
