"""tests/slow_tests.txt names tests that exist."""

from __future__ import annotations

from plugins.slow import FILE, exists


def test_each_line_names_a_test() -> None:
    """`pytest -n auto --record-slow` drops others."""
    assert not [line for line in FILE.read_text("utf-8").splitlines() if not exists(line)]
