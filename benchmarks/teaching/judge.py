"""Draws faults of shipped scenes, and judges what the compiler says of each."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from benchmarks.teaching.key_faults import KEY, NAME
from benchmarks.teaching.scene_text import Edit, Fault, SceneText, applied, lines_of
from benchmarks.teaching.structure_faults import STRUCTURE
from benchmarks.teaching.value_faults import NUMBER, PHYSICS, UNIT
from scenecc import check_scene
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.formats.style import Style, unchecked
from scenecc.errors import SceneError
from scenecc.options import Options
from scenecc.pipeline import compile_source
from scenecc.plan.diff import diff_plans
from scenecc.source import Document, make_limits, read_text
from tests.plugins.pasting import pasted

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan

ROOT: Final = Path(__file__).resolve().parents[2]

Mutator = Callable[[SceneText, Random], Iterator[Fault]]

CLASSES: Final[dict[str, tuple[Mutator, ...]]] = {
    "key": KEY,
    "unit": UNIT,
    "name": NAME,
    "number": NUMBER,
    "structure": STRUCTURE,
    "physics": PHYSICS,
}
"""Class of faults → functions that list the faults of a scene."""

Outcome = Literal["error", "warning", "check", "missed"]
"""What reports a fault first: an error or a warning of `validate`, `check`, or nothing."""


class Case(NamedTuple):
    """A fault in a scene."""

    scene: SceneText
    kind: str
    fault: Fault

    @property
    def text(self) -> str:
        return applied(self.scene.text, self.fault.edits)


class Verdict(NamedTuple):
    """What the compiler says of a fault.

    Attributes:
        outcome: what reports it first.
        is_legal: whether `validate` reports nothing: the scene is another one, which the language allows.
        finding: the first finding that names it.
        is_right_line: whether a finding that names it is on its line.
        fixed: whether its hints, applied as they are, give the plan of the shipped scene.
        clean: whether they give a scene without findings.
    """

    case: Case
    outcome: Outcome
    is_legal: bool
    finding: Diagnostic | None
    is_right_line: bool
    fixed: bool
    clean: bool


class Pair(NamedTuple):
    """Two faults in one file, of which each alone is found on its line.

    Attributes:
        kinds: their classes.
        hidden: those that are not reported while the other is there.
        is_said: whether the report says which checks did not run because of errors.
    """

    kinds: tuple[str, str]
    hidden: tuple[str, ...]
    is_said: bool


@cache
def shipped_scenes() -> tuple[SceneText, ...]:
    """Returns the scenes that need no other package, and are valid."""
    files = sorted((*(ROOT / "scenes").glob("*.yaml"), *(ROOT / "scenes/recipes").glob("*.yaml")))
    texts = (SceneText(file) for file in files)
    return tuple(
        one
        for one in texts
        if not re.search(r"mani_?skill|table_scene", one.text.partition("\nscenecc:")[2])
        and not findings(one.text, one)
    )


def draw_cases(seed: int, count: int, kinds: tuple[str, ...] = tuple(CLASSES)) -> Iterator[Case]:
    """Yields faults that change the scene, `count` in all, as many of each class."""
    draw, seen = Random(seed), set[tuple[str, str]]()
    for number in range(count):
        kind = kinds[number % len(kinds)]
        case = _draw_case(draw, kind)
        while (case.text, str(case.scene.path)) in seen or is_same(case):
            case = _draw_case(draw, kind)
        seen.add((case.text, str(case.scene.path)))
        yield case


def _draw_case(draw: Random, kind: str) -> Case:
    """Returns a fault of a class: of each kind as often, in any scene that can have it."""
    mutator = draw.choice(CLASSES[kind])
    while True:
        scene = draw.choice(shipped_scenes())
        if faults := list(mutator(scene, draw)):
            return Case(scene, kind, draw.choice(faults))


def is_same(case: Case) -> bool:
    """Whether a fault gives the plan of the shipped scene without a finding."""
    return not findings(case.text, case.scene) and is_equal(case.text, case.scene)


def findings(text: str, scene: SceneText) -> list[Diagnostic]:
    """Returns what `validate` reports of a text in the place of a scene."""
    return _compiled(text, scene, placed=False)[1]


def is_equal(text: str, scene: SceneText) -> bool:
    """Whether a text has the plan of a shipped scene."""
    here, there = _plan(scene), _compiled(text, scene, placed=True)[0]
    return here is not None and there is not None and not diff_plans(here, there)


@cache
def _plan(scene: SceneText) -> ScenePlan | None:
    return _compiled(scene.text, scene, placed=True)[0]


def _document(text: str, scene: SceneText, sink: Sink) -> Document | None:
    return read_text(text, str(scene.path), sink, make_limits(), scene.path)


def _compiled(text: str, scene: SceneText, *, placed: bool) -> tuple[ScenePlan | None, list[Diagnostic]]:
    sink = Sink()
    sink.stage = "YAML"
    document = _document(text, scene, sink)
    if document is None or sink.failed:
        return None, sink.diagnostics()
    result = compile_source(document, Options(), sink, placed=placed)
    return result and result.plan, sink.diagnostics()


def checked(text: str, scene: SceneText) -> list[Diagnostic]:
    """Returns what `check` reports."""
    document = _document(text, scene, Sink())
    try:
        return [] if document is None else check_scene(document)
    except SceneError as error:
        return list(error.diagnostics)


@cache
def _known(scene: SceneText) -> frozenset[tuple[str, str]]:
    """Code and path of what `check` reports of a shipped scene."""
    return frozenset((one.code, one.path) for one in checked(scene.text, scene))


def judge(case: Case, *, simulate: bool = True) -> Verdict:
    """Returns what the compiler says of a fault. `simulate`: run `check` where `validate` reports nothing."""
    found = findings(case.text, case.scene)
    naming = _naming(case.fault, found)
    outcome: Outcome = "error" if naming and naming[0].severity == "error" else "warning"
    if not naming and simulate and not found:
        known = _known(case.scene)
        naming = [one for one in checked(case.text, case.scene) if (one.code, one.path) not in known]
        naming = _naming(case.fault, naming)
        outcome = "check"
    if not naming:
        return Verdict(
            case, "missed", not found, next(iter(found), None), is_right_line=False, fixed=False, clean=False
        )
    lines = lines_of(case.scene.text, case.fault, case.fault.edits)
    result = pasted(case.text, lambda text: _as_errors(findings(text, case.scene))) if found else None
    return Verdict(
        case,
        outcome,
        not found,
        naming[0],
        is_right_line=any(one.line in lines for one in naming),
        fixed=result is not None and is_equal(result, case.scene),
        clean=result is not None,
    )


def _naming(fault: Fault, found: list[Diagnostic]) -> list[Diagnostic]:
    """Returns the findings that name a fault."""
    return [one for one in found if one.severity != "note" and re.match(fault.codes, one.code)]


def _as_errors(found: list[Diagnostic]) -> list[Diagnostic]:
    """Returns errors, then warnings as errors, so that their hints are applied too."""
    ordered = sorted(found, key=lambda one: one.severity != "error")
    return [replace(one, severity="error") for one in ordered if one.severity != "note"]


def draw_pairs(seed: int, count: int) -> Iterator[Pair]:
    """Yields pairs of faults of different classes, `count` for each pair of classes."""
    draw = Random(seed)
    for kinds in combinations(CLASSES, 2):
        for _ in range(count):
            while (pair := _draw_pair(draw, kinds)) is None:
                pass
            yield pair


def _draw_pair(draw: Random, kinds: tuple[str, str]) -> Pair | None:
    """Returns two faults in one scene; None if one of them alone is not reported by `validate` on its line."""
    first = _draw_case(draw, kinds[0])
    others = [one for mutator in CLASSES[kinds[1]] for one in mutator(first.scene, draw)]
    if not others:
        return None
    second = Case(first.scene, kinds[1], draw.choice(others))
    both = (*first.fault.edits, *second.fault.edits)
    if _touch(first.scene, first.fault.edits, second.fault.edits):
        return None
    if not all(_is_found(one, one.text, one.fault.edits) for one in (first, second)):
        return None
    text = applied(first.scene.text, both)
    hidden = tuple(one.kind for one in (first, second) if not _is_found(one, text, both))
    found = findings(text, first.scene)
    return Pair(kinds, hidden, bool(unchecked(found, Style())))


def _touch(scene: SceneText, first: tuple[Edit, ...], second: tuple[Edit, ...]) -> bool:
    """Whether edits are on the same lines or on neighbours."""
    spans = [
        [(scene.text.count("\n", 0, one.start), scene.text.count("\n", 0, one.end)) for one in edits]
        for edits in (first, second)
    ]
    return any(a[0] <= b[1] + 1 and b[0] <= a[1] + 1 for a in spans[0] for b in spans[1])


def _is_found(case: Case, text: str, edits: tuple[Edit, ...]) -> bool:
    """Whether a finding on the fault's line names it."""
    lines = lines_of(case.scene.text, case.fault, edits)
    return any(one.line in lines for one in _naming(case.fault, findings(text, case.scene)))
