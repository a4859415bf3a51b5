"""The command `python -m benchmarks.teaching`: see `docs/reference/errors.md`."""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter

from benchmarks.teaching.judge import CLASSES, ROOT, Pair, Verdict, draw_cases, draw_pairs, judge
from benchmarks.teaching.scene_text import lines_of


def main() -> int:
    """Judges faults and prints the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.teaching", description=__doc__)
    parser.add_argument("--seed", type=int, action="append", help="seeds (1, 2 and 3)")
    parser.add_argument("--faults", type=int, default=300, help="faults of each seed (300)")
    parser.add_argument("--pairs", type=int, default=10, help="pairs of faults for each pair of classes and seed (10)")
    parser.add_argument("--class", dest="kinds", action="append", choices=list(CLASSES), help="only faults of a class")
    parser.add_argument("--show", choices=["missed", "line", "hint", "all"], help="print single faults too")
    parser.add_argument("--no-check", action="store_true", help="do not simulate what `validate` does not report")
    parser.add_argument("--format", choices=["text", "json"], default="text")
    asked = parser.parse_args()
    kinds, seeds = tuple(asked.kinds or CLASSES), asked.seed or [1, 2, 3]
    verdicts: dict[int, list[Verdict]] = {}
    pairs: dict[int, list[Pair]] = {}
    for seed in seeds:
        verdicts[seed] = []
        for case in draw_cases(seed, asked.faults, kinds):
            verdicts[seed].append(judge(case, simulate=not asked.no_check))
            if asked.show and _is_shown(verdicts[seed][-1], asked.show):
                print(describe(verdicts[seed][-1]), flush=True)
        pairs[seed] = [] if asked.kinds else list(draw_pairs(seed, asked.pairs))
    if asked.format == "json":
        print(json.dumps({seed: figures(verdicts[seed], pairs[seed]) for seed in seeds}, indent=2))
    else:
        print(*table(verdicts, pairs), sep="\n")
    return 0


def _is_shown(one: Verdict, what: str) -> bool:
    is_missed = one.outcome == "missed"
    shown = {
        "missed": is_missed,
        "line": not is_missed and not one.is_right_line,
        "hint": not is_missed and not one.fixed,
    }
    return shown.get(what, True)


def describe(one: Verdict) -> str:
    """Returns a fault and what is said of it."""
    case = one.case
    lines = sorted(lines_of(case.scene.text, case.fault, case.fault.edits))
    said = (
        "nothing"
        if one.finding is None
        else f"{one.finding.line}: {one.finding.code} {one.finding.message} -> {one.finding.hint}"
    )
    marks = f"{one.outcome}{' line' * one.is_right_line}{' fixed' * one.fixed}{' clean' * one.clean}"
    shown = "".join(
        f"\n    | {case.text.splitlines()[line - 1]}" for line in lines[:2] if line <= len(case.text.splitlines())
    )
    place = f"{case.scene.path.relative_to(ROOT)}:{','.join(map(str, lines))}"
    return f"[{case.kind}] {case.fault.what} ({marks})\n  {place}{shown}\n    {said}"


def figures(verdicts: list[Verdict], pairs: list[Pair]) -> dict[str, dict[str, float]]:
    """Returns shares by class, of `all` faults, and of pairs."""
    made: dict[str, dict[str, float]] = {}
    for kind in (*CLASSES, "all"):
        of_kind = [one for one in verdicts if kind in {one.case.kind, "all"}]
        if not of_kind:
            continue
        found = [one for one in of_kind if one.outcome != "missed"]
        early = [one for one in found if one.outcome != "check"]
        outcomes = Counter(one.outcome for one in of_kind)
        made[kind] = {
            "faults": len(of_kind),
            "found": len(found) / len(of_kind),
            "legal": sum(one.is_legal for one in of_kind) / len(of_kind),
            "by_check": outcomes["check"] / len(of_kind),
            "right_line": sum(one.is_right_line for one in found) / max(len(found), 1),
            "fixed": sum(one.fixed for one in early) / max(len(early), 1),
            "clean": sum(one.clean for one in early) / max(len(early), 1),
        }
    for kinds in dict.fromkeys(pair.kinds for pair in pairs):
        of_kinds = [pair for pair in pairs if pair.kinds == kinds]
        hidden = [pair for pair in of_kinds if pair.hidden]
        made[" + ".join(kinds)] = {
            "pairs": len(of_kinds),
            "masked": len(hidden) / len(of_kinds),
            "unsaid": sum(not pair.is_said for pair in hidden) / len(of_kinds),
        }
    return made


def table(verdicts: dict[int, list[Verdict]], pairs: dict[int, list[Pair]]) -> list[str]:
    """Returns Markdown tables with the figures of each seed."""
    every = {seed: figures(verdicts[seed], pairs[seed]) for seed in verdicts}
    keys = ("found", "legal", "by_check", "right_line", "fixed", "clean")
    rows = [f"| class | {' | '.join(key.replace('_', ' ') for key in keys)} |", "| --- " * 7 + "|"]
    masked = ["", "| two faults | one masks the other | without a word |", "| --- | --- | --- |"]
    for kind in next(iter(every.values())):
        of_kind = [every[seed][kind] for seed in every]
        names, out = (keys, rows) if "found" in of_kind[0] else (("masked", "unsaid"), masked)
        out.append(f"| {kind} | {' | '.join(' '.join(f'{one[key]:.0%}' for one in of_kind) for key in names)} |")
    return rows if len(masked) == 3 else rows + masked


if __name__ == "__main__":
    sys.exit(main())
