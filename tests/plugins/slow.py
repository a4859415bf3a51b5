"""Which tests are slow: the run before a merge leaves them out, the nightly one has them.

A test that takes long is named in `tests/slow_tests.txt`, which `pytest -n auto --record-slow` writes.
Tests that render, those in a browser and those with ManiSkill are slow, except a few that are marked `quick`.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

FILE = Path(__file__).parents[1] / "slow_tests.txt"
SECONDS = 0.5
"""More than this of a test's own time makes it slow: it is a second where the machine has other things to do."""

_KINDS = ("browser", "maniskill", "render")


def _function(nodeid: str) -> str:
    return nodeid.partition("[")[0]


def _named() -> set[str]:
    return set(FILE.read_text(encoding="utf-8").splitlines())


def mark_slow_tests(items: list[pytest.Item]) -> None:
    """Marks each slow test `slow`. A line of the file names a test, or a function with all its parameters."""
    named = _named()
    for item in items:
        if item.get_closest_marker("quick"):
            continue
        is_named = item.nodeid in named or _function(item.nodeid) in named
        if is_named or any(item.get_closest_marker(kind) for kind in _KINDS):
            item.add_marker(pytest.mark.slow)


def mostly_slow(items: Sequence[Any], every: int) -> list[Any]:
    """Parameters of which one in `every` is tested before a merge, and the others at night."""
    marks = pytest.mark.slow, pytest.mark.quick
    return [pytest.param(item, marks=marks[number % every == 0]) for number, item in enumerate(items)]


def exists(line: str) -> bool:
    """Whether a line of the file names a test, whatever its parameters."""
    path, *_, name = _function(line).split("::")
    file = FILE.parents[1] / path
    return file.is_file() and re.search(rf"^ *(async )?def {name}\(", file.read_text("utf-8"), re.MULTILINE) is not None


class SlowTestRecorder:
    """Writes the file anew from a run of all tests, slow ones too. A function that did not run keeps its lines."""

    def __init__(self) -> None:
        self._seconds: dict[str, float] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Takes the time of a test without that of its fixtures."""
        if report.when == "call" and report.passed and "quick" not in report.keywords:
            self._seconds[report.nodeid] = report.duration

    def pytest_sessionfinish(self) -> None:
        """Names a function instead of its parameters where all are slow."""
        tests: dict[str, set[str]] = defaultdict(set)
        for nodeid in self._seconds:
            tests[_function(nodeid)].add(nodeid)
        named = {line for line in _named() if _function(line) not in tests and exists(line)}
        for function, nodeids in tests.items():
            slow = {nodeid for nodeid in nodeids if self._seconds[nodeid] > SECONDS}
            named |= {function} if slow == nodeids else slow
        FILE.write_text("".join(f"{line}\n" for line in sorted(named)), encoding="utf-8")
