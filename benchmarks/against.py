"""`python -m benchmarks.against COMMIT [NAME…]`: what scenecc takes now over what it took in another commit."""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path

from benchmarks.own import NAMES
from benchmarks.paired import Row, alternating_order
from benchmarks.process import REFERENCE

ROOT = Path(__file__).resolve().parents[1]
BOUND = 1.03

Measured = dict[str, float]
"""What was measured → seconds."""


def main() -> int:
    """Measures in pairs and prints ratios; 1 where one is above the bound and above the spread."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.against", description=__doc__)
    parser.add_argument("commit", help="what git knows it by")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"all by default: {', '.join(NAMES)}")
    parser.add_argument("--repetitions", type=int, default=9, metavar="N", help="pairs of each benchmark (9)")
    parser.add_argument("--spread", action="store_true", help="measure the commit against itself as well")
    asked = parser.parse_args()
    if unknown := set(asked.names) - set(NAMES):
        parser.error(f"no benchmark {', '.join(sorted(unknown))}; there are {', '.join(NAMES)}")
    over = False
    with tempfile.TemporaryDirectory() as folder, _checkout(asked.commit, Path(folder, "old")) as old:
        shutil.copytree(ROOT / "benchmarks", Path(folder, "run", "benchmarks"))
        sides = [old, ROOT, *([old] if asked.spread else [])]
        for name in asked.names or NAMES:
            rounds = _rounds(name, sides, asked.repetitions, Path(folder))
            for row in rows(name, rounds):
                over |= row.verdict == "OVER"
                print(f"{row.verdict:8} {row.what}\n{'':8} {row.note}", flush=True)
    return int(over)


@contextmanager
def _checkout(commit: str, folder: Path) -> Generator[Path]:
    """The tree of a commit, in a folder, for as long as it is needed."""
    git = ["git", "-C", str(ROOT), "worktree"]
    subprocess.run([*git, "add", "--quiet", "--detach", str(folder), commit], check=True)
    try:
        yield folder
    finally:
        subprocess.run([*git, "remove", "--force", str(folder)], check=True)


def _rounds(name: str, sides: Sequence[Path], repetitions: int, folder: Path) -> list[list[Measured]]:
    """A process for each side and round, in turns; the first round, which writes bytecode, is thrown away."""
    rounds: list[list[Measured]] = []
    for number in range(repetitions + 1):
        found: list[Measured] = [{}] * len(sides)
        for index in alternating_order(number, len(sides)):
            found[index] = _measured(name, sides[index], folder)
        rounds.append(found)
    return rounds[1:]


def _measured(name: str, package: Path, folder: Path) -> Measured:
    """One benchmark with one package. It runs where no other package lies, since Python looks there first."""
    environment = os.environ | {"PYTHONPATH": str(package), "PYTHONPYCACHEPREFIX": str(folder / "bytecode")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, "-m", "benchmarks.own", name]
    ran = subprocess.run(command, cwd=folder / "run", env=environment, check=True, stdout=subprocess.PIPE, text=True)
    found: Measured = json.loads(ran.stdout.splitlines()[-1])
    return found


def rows(name: str, rounds: Sequence[Sequence[Measured]]) -> list[Row]:
    """A row for each thing measured. With a third side, the first once more, the bound is at least the spread's."""
    what_of = [what for what in rounds[0][0] if what in rounds[0][1] and REFERENCE not in what]
    if not what_of:
        return [Row(name, name, (), note="something is missing that it needs")]
    return [_row(name, what, rounds) for what in what_of]


def _row(name: str, what: str, rounds: Sequence[Sequence[Measured]]) -> Row:
    ratios = tuple(found[1][what] / found[0][what] for found in rounds)
    old, new = (statistics.median(found[side][what] for found in rounds) for side in (0, 1))
    words = [f"new / old {_range(ratios)}", f"{old * 1e3:.1f} ms → {new * 1e3:.1f} ms"]
    bound = BOUND
    if len(rounds[0]) == 3:
        again = tuple(found[2][what] / found[0][what] for found in rounds)
        bound = max(bound, _upper_quartile(again))
        words.append(f"old / old {_range(again)}, so the bound is {bound:.3f}")
    for reference in (other for other in rounds[0][0] if REFERENCE in other):
        over = [statistics.median(found[side][what] / found[side][reference] for found in rounds) for side in (0, 1)]
        words.append(f"over the reference {over[0]:.2f} → {over[1]:.2f}")
    return Row(name, what, ratios, bound, note="; ".join(words))


def _range(ratios: Sequence[float]) -> str:
    return f"{statistics.median(ratios):.3f} ({min(ratios):.3f}–{max(ratios):.3f})"


def _upper_quartile(ratios: Sequence[float]) -> float:
    return statistics.quantiles(ratios, n=4, method="inclusive")[2] if len(ratios) > 1 else ratios[0]


if __name__ == "__main__":
    sys.exit(main())
