"""What the nightly run asks that the one before a merge does not. SCENECC_NIGHTLY turns it on."""

from __future__ import annotations

import os

NIGHTLY = bool(os.environ.get("SCENECC_NIGHTLY"))


def examples(count: int) -> int:
    """How many examples Hypothesis draws: a quarter of `count` before a merge, four times as many at night."""
    return 4 * count if NIGHTLY else max(count // 4, 5)


def assert_took(seconds: float, *, most: float) -> None:
    """Holds a time [s] against a bound [s], at night: on a busy machine it would fail by bad luck.

    What hangs ends at pytest's own timeout in any run.
    """
    assert not NIGHTLY or seconds < most, f"took {seconds:.2f} s, at most {most} s expected"
