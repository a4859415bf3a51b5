"""Results in the cache folder: damaged ones are not read, and old ones are removed where there are many."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from scenecc import files
from scenecc.files import keep_result, read_result


@pytest.fixture(autouse=True)
def _new_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "_pruned", set())


def kept(folder: Path, count: int) -> list[Path]:
    """Results of 100 bytes each, the oldest first."""
    paths = [folder / f"{number}" for number in range(count)]
    for number, path in enumerate(paths):
        keep_result(path, b"x" * 35)  # and 65 of the checksum
        os.utime(path, (number, number))
    return paths


def test_a_cached_result_is_read_back(tmp_path: Path) -> None:
    (path,) = kept(tmp_path / "kind", 1)
    assert read_result(path) == b"x" * 35
    path.write_bytes(path.read_bytes() + b"y")
    assert read_result(path) is None


@pytest.mark.parametrize(("limit", "most"), [("MOST_RESULTS", 9), ("MOST_RESULT_BYTES", 999)])
def test_the_oldest_half_of_many_results_is_removed(
    limit: str, most: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = kept(tmp_path, 10)
    monkeypatch.setattr(files, limit, most)
    monkeypatch.setattr(files, "_pruned", set())
    keep_result(tmp_path / "new", b"")
    assert {path.name for path in tmp_path.iterdir()} == {*(path.name for path in paths[5:]), "new"}
    keep_result(tmp_path / "more", b"")  # once a process
    assert len(list(tmp_path.iterdir())) == 7


def test_few_results_are_kept(tmp_path: Path) -> None:
    kept(tmp_path, 10)
    assert len(list(tmp_path.iterdir())) == 10
