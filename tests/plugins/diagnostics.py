"""A sink that fails the test which leaves a diagnostic in it that nobody asked about."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import pytest

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Locator, nowhere


class TakingSink(Sink):
    """A sink from which a test takes what it expects; what is left at the end is a failure."""

    def __init__(self, locate: Locator = nowhere) -> None:
        super().__init__(locate)
        self._taken: Counter[Diagnostic] = Counter()

    def left(self) -> list[Diagnostic]:
        """What nobody has taken, in the order of `diagnostics()`."""
        taken = self._taken.copy()
        left: list[Diagnostic] = []
        for diagnostic in self.diagnostics():
            if taken[diagnostic]:
                taken[diagnostic] -= 1
            else:
                left.append(diagnostic)
        return left

    def take(self, code: str, *, path: str | None = None) -> Diagnostic:
        """The first diagnostic left with this code (and path), which counts as expected from now on."""
        left = self.left()
        for diagnostic in left:
            if diagnostic.code == code and path in (None, diagnostic.path):
                self._taken[diagnostic] += 1
                return diagnostic
        at = "" if path is None else f" at {path}"
        raise AssertionError(f"no {code}{at} among:{_listed(left)}")


def _listed(diagnostics: list[Diagnostic]) -> str:
    return "".join(f"\n  {diagnostic}" for diagnostic in diagnostics) or " nothing"


@pytest.fixture
def sink() -> Iterator[TakingSink]:
    """A sink for one test: `sink.take("SC101")` what is expected; anything else that was reported fails the test."""
    sink = TakingSink()
    yield sink
    if left := sink.left():
        pytest.fail(f"reported and never taken:{_listed(left)}", pytrace=False)
