"""What `check` has simulated of a file, and the text of several files."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import index_ranges

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.diagnostics import Diagnostic


@dataclass(frozen=True, slots=True)
class Simulated:
    """What was simulated of a file.

    Attributes:
        scenes: number of scenes with each seed.
        seeds: the seeds, ascending.
        seconds: simulated time [s]. 0: only the first step.
    """

    scenes: int
    seeds: tuple[int, ...]
    seconds: float


@dataclass(frozen=True, slots=True)
class Checked:
    """The result of checking a file. `simulated`: None if nothing was simulated."""

    diagnostics: list[Diagnostic] = field(default_factory=list["Diagnostic"])
    simulated: Simulated | None = None


def simulated_text(files: Iterable[Simulated | None]) -> str:
    """Returns what was simulated of all files: `4 scenes, seed 7, 1 s simulated`."""
    found = [one for one in files if one is not None]
    scenes = sum(one.scenes for one in found)
    if not scenes:
        return "nothing simulated"
    seeds = sorted({seed for one in found for seed in one.seeds})
    several = f"seeds {index_ranges(seeds)}" if len(seeds) > 1 else f"seed {seeds[0]}"
    times = sorted({one.seconds for one in found})
    time = f"{times[0]:g} to {times[-1]:g} s" if len(times) > 1 else f"{times[0]:g} s" if times[0] else "1 step"
    return f"{scenes} scene{'' if scenes == 1 else 's'}, {several}, {time} simulated"
