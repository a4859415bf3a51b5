"""Mutated files, and cases that failed once."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from fuzz import corpus, driver, mutate, oracle

import scenecc

ROOT = Path(__file__).parents[2]
REGRESSIONS = sorted({path.parent for path in Path(__file__).with_name("regressions").glob("*/*")})


def run(*arguments: str | Path) -> str:
    command = [sys.executable, "-m", "tests.fuzz", *map(str, arguments)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_case_that_failed_once_passes() -> None:
    assert REGRESSIONS
    run(*REGRESSIONS)


def test_a_failing_case_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "scene.yaml").write_text("scenecc: 1\nentities: {a: {shapes: [{type: box}]}}\n")
    here = Path.cwd()
    try:
        assert oracle.judge(tmp_path, render=None) is None
        monkeypatch.setattr(scenecc, "validate", lambda *_, **__: [])
        assert "validate is clean, compile is not" in (oracle.judge(tmp_path, render=None) or "")
        monkeypatch.setattr(scenecc, "validate", lambda *_, **__: 1 / 0)
        assert "ZeroDivisionError" in (oracle.judge(tmp_path, render=None) or "")
    finally:
        os.chdir(here)


def test_timeouts_memory_errors_and_signals_are_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def end(how: Callable[[], object]) -> str:
        monkeypatch.setattr(driver, "judge", lambda *_, **__: how())
        return driver.once(tmp_path, render=False) or ""

    monkeypatch.setattr(driver, "CPU_SECONDS", 1)
    assert end(lambda: [None for _ in iter(int, 1) if False]) == "more than 1 s"
    assert end(lambda: os.kill(os.getpid(), signal.SIGTERM)) == "the process dies of SIGTERM"
    assert end(lambda: os._exit(3)) == "the process ends with status 3"
    assert "MemoryError" in end(lambda: oracle.guarded(lambda: str(bytearray(2 * driver.MEMORY))))


def test_a_failing_case_is_minimized(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driver, "judge", lambda *_, **__: "bad" if b"#" in (tmp_path / "a").read_bytes() else None)
    (tmp_path / "a").write_bytes(b"one # two")
    (tmp_path / "b").write_bytes(b"not needed")
    driver.minimise(tmp_path, "a", "bad", render=False)
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_bytes() == b"#"


@pytest.mark.parametrize("target", corpus.TARGETS)
def test_mutations_are_reproducible_and_distinct(target: str, tmp_path: Path) -> None:
    seeds = corpus.make_corpus(target, tmp_path)
    assert len(seeds) >= {"srdf": 1, "passport": 5, "pack": 10}.get(target, 14)
    data = {seed: (seed.folder / seed.name).read_bytes() for seed in seeds}
    made = [
        [mutate.mutated(Path(seed.name), held, held, random.Random(i)) for i in range(5)] for seed, held in data.items()
    ]
    again = [
        [mutate.mutated(Path(seed.name), held, held, random.Random(i)) for i in range(5)] for seed, held in data.items()
    ]
    assert made == again
    assert sum(one != held for held, many in zip(data.values(), made, strict=True) for one in many) > 3 * len(seeds)
