"""The corpus of plausible mistakes in `tests/scenes/mistakes`: base scenes, and edits that spoil them.

    python tests/plugins/mistakes.py [--static] [NAME …]

prints what `validate` and `check` report of each mistake, which mistakes nothing reports, and how many there are.
"""

from __future__ import annotations

import argparse
import copy
import sys
from functools import cache
from pathlib import Path
from typing import Any, Final, NamedTuple

from scenecc import check_scene, validate
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.options import Options
from scenecc.pipeline import compile_source
from scenecc.simulation.check import check_plan
from scenecc.source import make_limits, read_text

ROOT: Final = Path(__file__).resolve().parents[2]
CORPUS: Final = ROOT / "tests/scenes/mistakes"
ASSETS: Final = [ROOT / "scenes/assets", ROOT / "scenes/robots"]
SECTIONS: Final = ("physics", "lights", "cameras", "environment", "constraints", "collision_groups", "materials")
"""Edits of any other key are edits of an entity, but for `num_scenes`, `seed` and `draws`."""


class Mistake(NamedTuple):
    """A mistake of the corpus.

    Attributes:
        name: `base/name`.
        base: the base scene.
        edits: dotted path → the value that is written there; `remove` removes it, and `+` appends to a list.
        stage: the first command that reports it: `validate`, `static` (rules of `check` that build nothing), `check` or
            `silent`.
        codes: the codes that may report it.
    """

    name: str
    base: str
    edits: dict[str, Any]
    stage: str
    codes: frozenset[str]

    def scene(self) -> dict[str, Any]:
        """Returns the base scene with this mistake."""
        data = copy.deepcopy(base_scene(self.base))
        for path, value in self.edits.items():
            _write(data, path, value)
        return data


@cache
def base_scene(name: str) -> dict[str, Any]:
    """Returns the data of a base scene."""
    file = CORPUS / "bases" / f"{name}.yaml"
    return _read(file if file.exists() else CORPUS / "good" / file.name)


@cache
def mistakes() -> tuple[Mistake, ...]:
    """Returns all mistakes of the corpus."""
    return tuple(
        Mistake(f"{base}/{name}", base, edits, stage, frozenset(codes.split()))
        for base, rows in _read(CORPUS / "mistakes.yaml").items()
        for name, (edits, stage, codes) in rows.items()
    )


def static_findings(scene: Any) -> list[Diagnostic]:
    """Returns what `check` reports of a scene, file or dict, before it builds anything."""
    sink = Sink()
    result = compile_source(scene, Options(asset_roots=tuple(ASSETS)), sink)
    if result is not None:
        check_plan(result, sink)
    return sink.diagnostics()


def check_findings(scene: Any) -> list[Diagnostic]:
    """Returns what `check` reports of a scene."""
    return check_scene(scene, asset_roots=ASSETS)


def codes_of(found: list[Diagnostic]) -> set[str]:
    """Returns the codes that fail under `--strict`."""
    return {one.code for one in found if one.severity != "note"}


def _read(file: Path) -> dict[str, Any]:
    sink = Sink()
    document = read_text(file.read_text(encoding="utf-8"), str(file), sink, make_limits(), file)
    assert document is not None, sink.diagnostics()
    return document.data


def _write(data: Any, path: str, value: Any) -> None:
    keys = path.split("/")
    if keys[0] not in (*SECTIONS, "num_scenes", "seed", "draws", "entities"):
        keys.insert(0, "entities")
    for key in keys[:-1]:
        data = data[int(key)] if isinstance(data, list) else data.setdefault(key, {})
    last = keys[-1]
    if last == "+":
        data.append(value)
    elif isinstance(data, list):
        data[int(last)] = value
    elif value == "remove":
        del data[last]
    else:
        data[last] = value


def main() -> int:
    """Prints the report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--static", action="store_true", help="build and simulate nothing")
    parser.add_argument("names", nargs="*", help="parts of the names of mistakes")
    asked = parser.parse_args()
    counts: dict[str, int] = dict.fromkeys(("validate", "static", "check", "silent"), 0)
    for mistake in mistakes():
        if asked.names and not any(name in mistake.name for name in asked.names):
            continue
        stage, found = first_stage(mistake, static=asked.static)
        counts[stage] += 1
        changed = "" if stage == mistake.stage else f"   (was {mistake.stage} {' '.join(sorted(mistake.codes))})"
        print(f"{stage:9} {mistake.name:45} {' '.join(sorted(found))}{changed}", flush=True)
        if asked.names:
            print(*check_findings(mistake.scene()), sep="\n")
    total = sum(counts.values())
    told = total - counts["silent"]
    print(f"{told} of {total} reported ({told / max(total, 1):.0%}):", counts)
    return 0


def first_stage(mistake: Mistake, *, static: bool) -> tuple[str, set[str]]:
    """Returns the first command that reports a mistake, and the codes that it reports there."""
    scene, found = mistake.scene(), set[str]()
    for stage, run in (("validate", _validate), ("static", static_findings), ("check", check_findings)):
        if stage == "check" and static:
            break
        found = codes_of(run(scene))
        if found & mistake.codes or (found and not mistake.codes):
            return stage, found
    return "silent", found


def _validate(scene: Any) -> list[Diagnostic]:
    return validate(scene, asset_roots=ASSETS)


if __name__ == "__main__":
    sys.exit(main())
