"""The corrections that `validate --fix` writes and `--diff` shows."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.cli.output import unwritten, usage_error
from scenecc.diagnostics.diagnostic import Fix
from scenecc.diagnostics.fixing import is_better
from scenecc.diagnostics.messages import cut
from scenecc.files import open_regular, replace_unchanged

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic
    from scenecc.options import Options


@dataclass(frozen=True, slots=True)
class Corrected:
    """A file's text before and after its corrections.

    Attributes:
        corrections: the findings that were fixed, in text order.
    """

    file: str
    before: str
    after: str
    corrections: Sequence[Diagnostic]

    def diff(self) -> str:
        """Returns the change in the format of `diff -u`."""
        from scenecc.source.edits import text_diff

        return text_diff(self.before, self.after, self.file)

    def write(self) -> Diagnostic | None:
        """Writes the file completely or not at all. Returns a diagnostic if that failed, or if the file changed
        meanwhile.
        """
        before, after = (text.encode("utf-8", errors="surrogateescape") for text in (self.before, self.after))
        try:
            replace_unchanged(self.file, before, after)
        except OSError as error:
            return usage_error(*unwritten(self.file, error), file=self.file)
        return None


Check = Callable[[str], "list[Diagnostic]"]
"""Checks a text as if it were the file's."""


def corrected(file: str, options: Options) -> Corrected | None:
    """Returns the corrected text of a file, or None if nothing can be corrected.

    A correction that causes a new error or does not remove its finding is dropped. Once the errors of one stage are
    corrected, the next stage runs and may find more.
    """
    from scenecc.source.hint_edits import may_be_safe

    before = _read(file)
    if before is None:
        return None
    text = before
    check = partial(_check_text, file, options)
    made: list[Diagnostic] = []
    then, last = check(text), ""
    while text != last:
        last = text
        for batch in _batches(one for one in then if may_be_safe(one) and one.file == file):
            text, then, better = _correct_together(check, text, then, batch)
            made += better
    return Corrected(file, before, text, sorted(made, key=_place)) if made else None


def _read(file: str) -> str | None:
    """Returns the text of a file; None if the file was deleted since the check."""
    try:
        with open_regular(file) as stream:
            return stream.read().decode("utf-8", errors="surrogateescape")
    except OSError:
        return None


def _batches(every: Iterable[Diagnostic]) -> Iterable[list[Diagnostic]]:
    """Yields batches of findings with at most one per line. The last finding of a line comes first."""
    batches: defaultdict[int, list[Diagnostic]] = defaultdict(list)
    of_line: Counter[int] = Counter()
    for found in sorted(every, key=_place, reverse=True):
        line, _ = _place(found)
        batches[of_line[line]].append(found)
        of_line[line] += 1
    return batches.values()


def _correct_together(
    check: Check, text: str, then: list[Diagnostic], batch: Sequence[Diagnostic]
) -> tuple[str, list[Diagnostic], list[Diagnostic]]:
    """Returns the corrected text, its findings, and the corrections made. If a batch fails, its halves are tried.

    One check per correction would take minutes for a file with hundreds of them.
    """
    from scenecc.source.document import written_tree
    from scenecc.source.hint_edits import safe_edit

    changed = text
    made: list[Diagnostic] = []
    tree, following = written_tree(text), len(text)
    for found in batch:
        edit = safe_edit(text, found, tree)
        if edit is not None and edit.splices[-1].end <= following:
            changed, following = edit.applied(changed), edit.splices[0].start
            made.append(found if found.fix else replace(found, fix=Fix(found.location, edit.splices[0].text)))
    if not made:
        return text, then, []
    now = check(changed)
    if all(is_better(now, then, found) for found in made):
        return changed, now, made
    if len(made) == 1:
        return text, then, []
    half = len(made) // 2
    text, then, first = _correct_together(check, text, then, made[:half])
    text, then, second = _correct_together(check, text, then, made[half:])
    return text, then, first + second


def _place(found: Diagnostic) -> tuple[int, int]:
    return found.line or 0, found.column or 0


def _check_text(file: str, options: Options, text: str) -> list[Diagnostic]:
    """Checks a text in place of a file, so that relative paths work."""
    from scenecc.diagnostics import Sink
    from scenecc.scene import validate_source
    from scenecc.source import read_text

    sink = Sink()
    document = read_text(text, file, sink, path=Path(file).absolute())
    return sink.diagnostics() if document is None else validate_source(document, options, {}, None)


def summary(corrections: Sequence[Diagnostic]) -> str:
    """Returns one line per correction, and their number; "" if there are none."""
    from scenecc.diagnostics.formats.style import visible

    if not corrections:
        return ""
    lines = [
        f"{one.file}:{one.line}:{one.column}: corrected {one.code}: {one.message}; wrote `{cut(one.fix.text)}`"
        for one in corrections
        if one.fix is not None
    ]
    lines.append(f"{len(lines)} correction{'s' * (len(lines) != 1)}")
    return "".join(visible(line) + "\n" for line in lines)
