"""What every test shares: Hypothesis's profiles, and which tests this machine can run."""

from __future__ import annotations

import functools
import importlib.util
import os
import subprocess
import sys

import hypothesis
import pytest

pytest_plugins = ["plugins.diagnostics"]

hypothesis.settings.register_profile("default", deadline=None)
# A run of CI says the same of the same code: no example is drawn anew.
hypothesis.settings.register_profile("ci", deadline=None, derandomize=True)
hypothesis.settings.load_profile("ci" if os.environ.get("CI") else "default")


@functools.cache
def _can_render() -> bool:
    """Asked in a process of its own: a driver that fails may take its process with it."""
    script = "import sapien; sapien.Scene()"
    return subprocess.run([sys.executable, "-c", script], capture_output=True, check=False, timeout=60).returncode == 0


@functools.cache
def _held_renderer() -> object:
    """A scene that keeps SAPIEN's renderer for as long as the tests run: else each test starts it anew, for seconds."""
    import sapien

    return sapien.Scene()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.get_closest_marker("render") and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(300))  # a software driver takes up to 20 s for a camera's first picture


def pytest_runtest_setup(item: pytest.Item) -> None:
    if item.get_closest_marker("render"):
        if not _can_render():
            pytest.skip("SAPIEN finds no device to render with")
        _held_renderer()
    if item.get_closest_marker("maniskill") and importlib.util.find_spec("mani_skill") is None:
        pytest.skip("mani_skill is not installed: pip install torch 'scenecc[maniskill]'")
    if item.get_closest_marker("gpu") and not os.environ.get("SCENECC_TEST_GPU"):
        pytest.skip("tests on a GPU run where SCENECC_TEST_GPU is set")
