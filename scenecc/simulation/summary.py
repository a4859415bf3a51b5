"""The result of checking a file: its findings, and what was simulated of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic


@dataclass(frozen=True, slots=True)
class Simulated:
    """What was simulated of a file.

    Attributes:
        scenes: number of scenes with each seed.
        seeds: the seeds, ascending.
        seconds: simulated time [s]. 0: only the first step.
        permuted: whether the scenes were compared with themselves in another order and in smaller batches.
    """

    scenes: int
    seeds: tuple[int, ...]
    seconds: float
    permuted: bool = False


@dataclass(frozen=True, slots=True)
class Checked:
    """The result of checking a file.

    Attributes:
        diagnostics: the findings.
        simulated: None if nothing was simulated.
        cached: whether the result is of an earlier check of the same files.
    """

    diagnostics: list[Diagnostic] = field(default_factory=list["Diagnostic"])
    simulated: Simulated | None = None
    cached: bool = False
