"""What the nightly run asks that the one before a merge does not. SCENECC_NIGHTLY turns it on."""

from __future__ import annotations

import os

NIGHTLY = bool(os.environ.get("SCENECC_NIGHTLY"))


def examples(count: int) -> int:
    """How many examples Hypothesis draws: a quarter of `count`, at least 5, and at night four times `count`."""
    return 4 * count if NIGHTLY else max(count // 4, 5)


def assert_took(seconds: float, *, most: float) -> None:
    """Asserts an upper bound on a duration [s], in the nightly run only: a busy machine would fail it by chance.

    In any run, pytest's timeout ends a test that hangs.
    """
    assert not NIGHTLY or seconds < most, f"took {seconds:.2f} s, at most {most} s expected"
