"""Faults of YAML: indentation, brackets, colons, dashes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import yaml

from benchmarks.teaching.scene_text import Edit, Entry, Fault, SceneText

if TYPE_CHECKING:
    from random import Random

_ANY: Final = "SC00|SC01|SC1|SC2|SC3|SC5"


def _blocks(scene: SceneText) -> Iterator[Entry]:
    """Entries that begin a line after its indentation."""
    for entry in scene.entries:
        if entry.key is not None and not scene.text[scene.line_start(entry.start) : entry.start].strip():
            yield entry


def _line_end(scene: SceneText, at: int) -> int:
    return scene.text.find("\n", at)


def indentation(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in _blocks(scene):
        start, width = scene.line_start(entry.start), entry.start - scene.line_start(entry.start)
        step = draw.choice([-2, -1, 1, 2])
        if width + step >= 0 and width and scene.is_one_line(entry):
            new = " " * (width + step)
            yield Fault(f"indented by {step:+}", (Edit(start, entry.start, new),), (entry.start,), _ANY)


def dedented_block(scene: SceneText, draw: Random) -> Iterator[Fault]:
    """A key and its block beside the mapping that should have it."""
    for entry in _blocks(scene):
        start, end = scene.line_start(entry.start), scene.end(entry.value)
        if entry.start - start >= 2 and not scene.is_one_line(entry):
            block = re.sub(r"(?m)^  ", "", scene.text[start:end])
            yield Fault("block at the wrong parent", (Edit(start, end, block),), (entry.start,), _ANY)


def tab(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in _blocks(scene):
        start = scene.line_start(entry.start)
        if entry.start > start:
            new = "\t" * ((entry.start - start + 1) // 2)
            yield Fault("tabs", (Edit(start, entry.start, new),), (start,), _ANY)


def colon(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries:
        if entry.key is None or not scene.text.startswith(":", entry.key.end_mark.index):
            continue
        at = entry.key.end_mark.index
        has_blank = scene.text.startswith(": ", at)
        new, cut = draw.choice([("", 1), (" =", 1), (":", 2), (" -", 1)] if has_blank else [("", 1)])
        if new == ":" and scene.text[at + 2 : at + 3] in '[{"':
            continue
        yield Fault("no colon" if new != ":" else "no blank after a colon", (Edit(at, at + cut, new),), (at,), _ANY)


def twice(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in _blocks(scene):
        if scene.is_one_line(entry):
            start, end = scene.line_start(entry.start), _line_end(scene, entry.start) + 1
            yield Fault("key twice", (Edit(end, end, scene.text[start:end]),), (start, end), _ANY)


def bracket(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries:
        if isinstance(entry.value, yaml.CollectionNode) and entry.value.flow_style and scene.is_one_line(entry):
            start, end = entry.value.start_mark.index, entry.value.end_mark.index
            missing = Edit(end - 1, end, ""), Edit(start, start + 1, "")
            edit = draw.choice([*missing, Edit(end - 1, end, ")"), Edit(end, end, scene.text[end - 1])])
            yield Fault("bracket missing or wrong", (edit,), (start,), _ANY)


def comma(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries:
        is_flow = isinstance(entry.value, yaml.CollectionNode) and entry.value.flow_style
        if is_flow and (found := list(re.finditer(", ", scene.source(entry.value)))):
            at = entry.value.start_mark.index + draw.choice(found).start()
            yield Fault("no comma", (Edit(at, at + 1, draw.choice(["", ";"])),), (at,), _ANY)


def dash(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for found in re.finditer(r"(?m)^ *(- )(?=\S)", scene.text):
        new = draw.choice(["", "  ", "-"])
        yield Fault("dash forgotten", (Edit(found.start(1), found.end(1), new),), (found.start(1),), _ANY)


def list_for_mapping(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in _blocks(scene):
        if len(entry.path) > 1:
            yield Fault("dash before a key", (Edit(entry.start, entry.start, "- "),), (entry.start,), _ANY)


def quote(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for found in re.finditer(r'"[^"\n]*"', scene.text):
        line = scene.text[scene.line_start(found.start()) : found.start()]
        if "#" in line:
            continue
        edits = draw.choice([(0,), (1,), (0, 1)])
        ends = (found.start(), found.end() - 1)
        made = tuple(Edit(ends[one], ends[one] + 1, "") for one in edits)
        yield Fault("quotes left out", made, (found.start(),), _ANY)


def empty_value(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of():
        if scene.is_one_line(entry) and scene.begins_line(entry):
            edit = Edit(entry.value.start_mark.index, entry.value.end_mark.index, "")
            yield Fault("value left out", (edit,), (entry.start,), _ANY)


STRUCTURE: Final = (
    indentation,
    dedented_block,
    tab,
    colon,
    twice,
    bracket,
    comma,
    dash,
    list_for_mapping,
    quote,
    empty_value,
)
