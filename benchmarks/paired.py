"""Paired measurement: two sides, alternately, in one process; what counts is the ratio of each pair."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

Side = Callable[[], float]
"""Does the work once and gives the seconds that count; what it prepares and tears down is outside of them."""


@dataclass(frozen=True, slots=True)
class Row:
    """A line of the table.

    Attributes:
        benchmark: name by which it is selected.
        what: what is divided by what.
        ratios: one a repetition; empty where it was skipped.
        bound: the ratio that must not be exceeded; None: the number is for information.
        aim: the ratio that is aimed at.
        note: absolute times for orientation, or why it was skipped.
    """

    benchmark: str
    what: str
    ratios: tuple[float, ...]
    bound: float | None = None
    aim: float | None = None
    note: str = ""

    @property
    def median(self) -> float:
        """The ratio that is held against the bound."""
        return statistics.median(self.ratios)

    @property
    def verdict(self) -> str:
        """pass, OVER, skipped, or nothing where there is no bound."""
        if not self.ratios:
            return "skipped"
        if self.bound is None:
            return ""
        return "pass" if self.median <= self.bound else "OVER"


@contextmanager
def collector_off() -> Generator[None]:
    """No garbage collection inside, and none left over from before."""
    gc.collect()
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@contextmanager
def collector_on() -> Generator[None]:
    """The collector as a user has it, starting with nothing to collect."""
    gc.collect()
    yield


def timed(work: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> Side:
    """A side that is timed whole. The result lives until the clock has stopped."""

    def side() -> float:
        started = clock()
        result = work()
        seconds = clock() - started
        del result
        return seconds

    return side


def alternating(sides: Sequence[Side], repetitions: int, *, collector: bool = False) -> list[list[float]]:
    """Seconds of each side, a list a repetition; the first round, which warms everything, is thrown away.

    Every second round goes through the sides backwards, so that none is always the one after another.
    """
    guard = collector_on if collector else collector_off
    rounds: list[list[float]] = []
    for number in range(repetitions + 1):
        seconds = [0.0] * len(sides)
        for index in alternating_order(number, len(sides)):
            with guard():
                seconds[index] = sides[index]()
        rounds.append(seconds)
    return rounds[1:]


def alternating_order(number: int, sides: int) -> Sequence[int]:
    """In which order round `number` goes through the sides."""
    return range(sides) if number % 2 else range(sides)[::-1]


def ratios(rounds: Sequence[Sequence[float]], over: int, under: int, *, less: int | None = None) -> tuple[float, ...]:
    """Side `over`, less side `less`, divided by side `under`, of each repetition."""
    return tuple((r[over] - (0.0 if less is None else r[less])) / r[under] for r in rounds)


def best(rounds: Sequence[Sequence[float]], side: int) -> str:
    """The shortest time of a side, in words."""
    seconds = min(r[side] for r in rounds)
    return f"{seconds * 1e3:.0f} ms" if seconds < 10 else f"{seconds:.0f} s"
