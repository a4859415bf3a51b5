"""`python -m tests.fuzz --seconds 60`: mutates files, and tells what scenecc does wrong with them."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from fuzz.corpus import TARGETS
from fuzz.driver import fuzz, replay


def main() -> int:
    """1 where something failed."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path, help="cases to run again, and nothing else")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--target", choices=("all", *TARGETS), default="all")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--render", action="store_true", help="build what is seen, too: needs a render device")
    parser.add_argument("--out", type=Path, default=Path("fuzz-failures"), help="where cases that fail are saved")
    asked = parser.parse_args()
    if asked.folders:
        return replay(asked.folders, render=asked.render)
    targets = TARGETS if asked.target == "all" else (asked.target,)
    failures = fuzz(targets, asked.seconds, asked.seed, asked.jobs, asked.out, render=asked.render)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
