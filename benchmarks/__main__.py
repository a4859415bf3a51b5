"""The one command: `python -m benchmarks [NAME…] [--json] [--repetitions N]`."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from dataclasses import asdict
from importlib import import_module

from benchmarks.paired import Row

BENCHMARKS = {
    "instantiate": "benchmarks.instantiate",
    "validate": "benchmarks.reading",
    "live": "benchmarks.live",
    "drake": "benchmarks.drake",
    "vary": "benchmarks.vary",
    "place": "benchmarks.place",
    "expand": "benchmarks.expand",
    "linear": "benchmarks.linear",
    "robots": "benchmarks.robots",
    "maniskill": "benchmarks.maniskill",
    "real": "benchmarks.real",
    "render": "benchmarks.render",
    "reset": "benchmarks.reset",
    "view": "benchmarks.view",
    "lsp": "benchmarks.lsp",
    "conversion": "benchmarks.conversion",
    "process": "benchmarks.process",
    "folder": "benchmarks.folder",
    "overlap": "benchmarks.overlap",
    "sweep": "benchmarks.sweep",
    "starts": "benchmarks.starts",
}
"""Name → module with a function `run`."""


def main() -> int:
    """Runs what was asked for, each in a fresh process, and prints the table; 1 where a bound is exceeded."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"all by default: {', '.join(BENCHMARKS)}")
    parser.add_argument("--json", action="store_true", help="print rows as JSON")
    parser.add_argument("--repetitions", type=int, default=9, metavar="N", help="pairs of each benchmark (9)")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if unknown := set(asked.names) - set(BENCHMARKS):
        parser.error(f"no benchmark {', '.join(sorted(unknown))}; there are {', '.join(BENCHMARKS)}")
    if asked.inside:
        rows: list[Row] = import_module(BENCHMARKS[asked.names[0]]).run(asked.repetitions)
        print(json.dumps([asdict(row) for row in rows]))
        return 0
    rows = []
    for name in asked.names or BENCHMARKS:
        found = _apart(name, asked.repetitions)
        rows += found
        if not asked.json:
            print("\n".join(map(_line, found)), flush=True)
    if asked.json:
        print(
            json.dumps(
                [asdict(r) | {"median": r.median if r.ratios else None, "verdict": r.verdict} for r in rows], indent=2
            )
        )
    return int(any(row.verdict == "OVER" for row in rows))


def _apart(name: str, repetitions: int) -> list[Row]:
    """Runs one benchmark in a process that nothing else has warmed or filled."""
    command = [sys.executable, "-m", "benchmarks", name, "--inside", "--repetitions", str(repetitions)]
    ran = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    return [Row(**(row | {"ratios": tuple(row["ratios"])})) for row in json.loads(ran.stdout.splitlines()[-1])]


def _line(row: Row) -> str:
    bound = "" if row.bound is None else f"≤ {row.bound:g}" + (f" (aim {row.aim:g})" if row.aim else "")
    ratio = f"{row.median:.3g} ({min(row.ratios):.3g}–{max(row.ratios):.3g})" if row.ratios else "–"
    note = f"\n{'':51}{row.note}" if row.note else ""
    return f"{ratio:24} {bound:16} {row.verdict:8} {row.what}{note}"


if __name__ == "__main__":
    sys.exit(main())
