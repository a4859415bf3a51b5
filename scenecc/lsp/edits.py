"""Changes of texts: a name in all files that use it, and the corrections of findings."""

from __future__ import annotations

import re
from keyword import iskeyword
from typing import TYPE_CHECKING, Final, NamedTuple

from scenecc.diagnostics.fixing import with_fix
from scenecc.diagnostics.messages import cut
from scenecc.lsp.names import Definition, Use, definition_of, mention_at, mention_location, uses_of
from scenecc.lsp.references import SECTIONS_OF, defined_kind
from scenecc.spec.base import NAME_PATTERN, VARIABLE_PATTERN
from scenecc.spec.references import SHARED_NAMESPACE, WORLD
from scenecc.variation.expression import RESERVED_NAMES

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic
    from scenecc.diagnostics.diagnostic import Location
    from scenecc.lsp.analysis import SceneText
    from scenecc.lsp.workspace import WorkspaceView


class Edit(NamedTuple):
    """A text in place of a part of a 0-based line [characters]."""

    file: Path
    line: int
    start: int
    end: int
    text: str


class RefusedError(Exception):
    """Why a name cannot be changed; its text is for people."""


def renamed_part(view: WorkspaceView, path: Path, line: int, column: int) -> Edit:
    """The name at a 0-based place that can be changed, as an edit that changes nothing.

    Raises:
        RefusedError: there is none.
    """
    use, place = _find_mention(view, path, line, column)
    return _edit(use.text, place, str(use.definition.path[-1]))


def rename(view: WorkspaceView, path: Path, line: int, column: int, new: str) -> list[Edit]:
    """The changes that give what is named at a 0-based place another name, wherever it is named.

    Raises:
        RefusedError: the name is made by an expression or by repetition, is taken, or is none; or a file that uses it
            is at fault, so that it is not known what its names mean.
    """
    use, _ = _find_mention(view, path, line, column)
    wanted = use.definition
    _check_new_name(view, wanted, new)
    for user in view.judges(wanted.file):
        if not view.projects[user].is_current:
            raise RefusedError(f"{user.name} has errors: mend them first, so that it is known what its names mean")
    edits: dict[tuple[Path, int, int], Edit] = {}
    for found in uses_of(view, wanted):
        if found.definition.is_copy:
            name = found.leaf.text[found.definition.start : found.definition.end]
            raise RefusedError(
                f"`{cut(name)}` is made from this name by repetition or an expression: change both by hand"
            )
        place = mention_location(found.text, found.leaf, found.definition.start, found.definition.end)
        edit = _edit(found.text, place, new)
        if found.text.line(edit.line)[edit.start : edit.end] != wanted.path[-1]:
            raise RefusedError(f"line {edit.line + 1} of {found.text.path.name} writes this name in another way")
        edits[edit.file, edit.line, edit.start] = edit
    return list(edits.values())


def _find_mention(view: WorkspaceView, path: Path, line: int, column: int) -> tuple[Use, Location]:
    found = mention_at(view, path, line, column)
    if found is None:
        raise RefusedError("there is no name here")
    text, leaf, mention = found
    wanted = definition_of(view, text, leaf, mention)
    if wanted is None:
        raise RefusedError(f"it is not known what `{cut(mention.text)}` means")
    if not wanted.path:
        raise RefusedError("the names of files and of robots' links are changed in their files")
    if wanted.is_copy or not _is_plain_definition(view, wanted):
        raise RefusedError("this name is made by repetition or an expression: change that by hand")
    if wanted.file not in view.texts and not any(
        wanted.file.is_relative_to(user.parent) for user in view.users(text.path)
    ):
        raise RefusedError(f"{wanted.file.name} is not in the folder of the scene")
    return Use(text, leaf, wanted), mention_location(text, leaf, wanted.start, wanted.end)


def _is_plain_definition(view: WorkspaceView, wanted: Definition) -> bool:
    """Whether the name that is written is the name that things have."""
    text = view.text(wanted.file)
    keys = {} if text is None else text.scalars(wanted.path)
    return wanted.path[-2:-1] == ("repeat",) or keys.keys().isdisjoint(("repeat", "name"))


def _check_new_name(view: WorkspaceView, wanted: Definition, new: str) -> None:
    is_variable = defined_kind(wanted.path) == "variable"
    if not re.match(VARIABLE_PATTERN if is_variable else NAME_PATTERN, new) or new == WORLD or "\n" in new:
        raise RefusedError(f"`{cut(new)}` is not a name")
    if is_variable and (new in RESERVED_NAMES or iskeyword(new)):
        raise RefusedError(f"`{new}` is a word of expressions")
    section = str(wanted.path[0])
    related = next((many for many in SECTIONS_OF.values() if section in many), (section,))
    sections = SHARED_NAMESPACE if section in SHARED_NAMESPACE else related
    for text in view.namespace(wanted.file):
        for each in sections:
            if new in text.names(each):
                raise RefusedError(f"`{new}` is already among the {each} of {text.path.name}")


def _edit(text: SceneText, place: Location, new: str) -> Edit:
    return Edit(text.path, (place.line or 1) - 1, (place.column or 1) - 1, (place.end_column or 1) - 1, new)


def applied(view: WorkspaceView, made: list[Edit]) -> dict[Path, str]:
    """The texts of the files that some edits change, after them."""
    changed: dict[Path, str] = {}
    for file in {edit.file for edit in made}:
        text = view.text(file)
        lines = [] if text is None else [*text.lines]
        here = [edit for edit in made if edit.file == file]
        for edit in sorted(here, key=lambda one: (one.line, one.start), reverse=True):
            lines[edit.line] = lines[edit.line][: edit.start] + edit.text + lines[edit.line][edit.end :]
        changed[file] = "\n".join(lines)
    return changed


class Correction(NamedTuple):
    """A change that mends a finding.

    Attributes:
        title: for people.
        edit: the change.
        changed: the whole text after it, of a correction that `--fix` makes; None of a guess, which people judge.
    """

    title: str
    edit: Edit
    changed: str | None


_GUESS: Final = re.compile(r"\Adid you mean `([^`\n]{1,200})`\?")


def corrections(text: SceneText, found: Diagnostic) -> Iterator[Correction]:
    """What mends a finding in a text."""
    place = found.location if found.fix is None else found.fix.location
    if place.file != str(text.path) or place.line is None or place.column is None or not place.end_column:
        return
    edit = Edit(text.path, place.line - 1, place.column - 1, place.end_column - 1, "")
    old = text.line(edit.line)[edit.start : edit.end]
    if text.line(edit.line) != place.text:
        return
    if found.fix is not None:
        changed = with_fix(text.text, found)
        if changed is not None:
            yield Correction(f"Write `{cut(found.fix.text)}`", edit._replace(text=found.fix.text), changed)
        return
    guess = _GUESS.match(found.hint or "")
    if guess is not None and f"`{old}`" in found.message:
        yield Correction(f"Change to `{guess[1]}`", edit._replace(text=guess[1]), None)
