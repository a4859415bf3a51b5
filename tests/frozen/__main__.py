"""`python -m tests.frozen`: whether the compiler gives what it gave before, for every scene of this repository."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from frozen.outputs import FILES, difference, drawn_data, flat, update


def main() -> int:
    """1 where something differs."""
    parser = argparse.ArgumentParser(prog="python -m tests.frozen", description=__doc__)
    parser.add_argument("--update", action="store_true", help="write the files of tests/frozen")
    parser.add_argument("--show", type=Path, metavar="SCENE", help="print all numbers of a scene, to be diffed")
    parser.add_argument("--seed", type=int, default=1, help="of the draws that --show prints (1)")
    asked = parser.parse_args()
    if asked.show:
        print("\n".join(flat(json.loads(drawn_data(asked.show, asked.seed)))))
        return 0
    if asked.update:
        for name in FILES:
            update(name)
        return 0
    found = {name: difference(name) for name in FILES}
    for name, lines in found.items():
        if lines:
            print(f"{name}:", *lines, sep="\n")
    return int(any(found.values()))


if __name__ == "__main__":
    sys.exit(main())
