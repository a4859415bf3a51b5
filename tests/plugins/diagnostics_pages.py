"""The pages on diagnostics: `python tests/plugins/diagnostics_pages.py docs/reference/diagnostics` writes an index, and
one page for each first digit.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from scenecc.diagnostics.codes import BANDS, CODES, Code
from scenecc.diagnostics.reference import markdown

_MARK = (
    "<!-- Generated from scenecc/diagnostics/codes.yaml by "
    "`python tests/plugins/diagnostics_pages.py docs/reference/diagnostics`. -->\n"
)

_INTRODUCTION = """\
Every finding has a code, a severity, a place in the file and often a hint. `scenecc explain CODE` prints the entry of a
code. Processing stops after a stage that finds errors, so you see all errors of a stage at once. Warnings and notes do
not stop it; with `--strict`, `validate` and `check` also fail on warnings. The first digit is the stage:
"""

_FORMATS = """\

## Formats

Lines and columns count from 1, and columns count characters (Unicode code points). A scene given as a dict has no
lines; its places are only paths. A machine error that no part of the scene causes has no file. Nor does wrong
usage; its path is the argument or option (`camera`, `--camera`).

`--format` of `validate` and `check` is one of:

- `text`, for people: the place, the message, the source line underlined, the hint. Notes come first and errors last,
  nearest to the prompt; within one severity they are sorted by place. The other formats sort only by place.
  A last line names what was not checked because of the errors; other formats have it as well, except `gitlab`.
  Coloured on a terminal (see `NO_COLOR` and `FORCE_COLOR`). Control characters are spelled out.
- `json`, for programs: an object with the command's result, whose `diagnostics` is a list of `code`, `severity`
  (`error`, `warning` or `note`), `message`, `file`, `line`, `column`, `end_column` (after the last), `path`, `hint`
  and `related` (a list of
  `message`, `file`, `line`, `column` and `end_column`). Unknown values are `null`. ASCII only.
  With `--fix` it also has `corrections`, a list of the corrected findings, each with the written text (`wrote`).
  With `check`, it has `simulated`: for each file `scenes` (with each seed), `seeds`, `seconds` (0: only the first
  step), `permuted` and `cached`, or `null` if nothing was simulated. With `--statistics`, it has `statistics`. After
  errors that prevent later checks, it has `unchecked`: for each such file a list of what was not checked.
- `github`, for GitHub Actions: one workflow command per line (`::error file=…,line=…::…`), which annotates a pull
  request.
- `gitlab`, for GitLab: a Code Quality report.
- `junit`, for test reports: one test case per checked file, which fails if it has errors, or with `--strict` warnings;
  other findings are its output. Findings in a file that it uses or includes are among its own.
- `sarif`, for code scanning and editors: SARIF 2.1.0. Files are relative to `%SRCROOT%`, the working directory.
"""


def pages() -> dict[str, str]:
    """Returns file name → text: an index; for each first digit, a table of its codes, then each with cause, example and
    cure.
    """
    bands = {
        digit: sorted((row for row in CODES.values() if row.code[2] == digit), key=lambda row: row.code)
        for digit in BANDS
    }
    return {
        "index.md": _index({digit: len(rows) for digit, rows in bands.items()}),
        **{f"sc{digit}.md": _band(digit, rows) for digit, rows in bands.items() if rows},
    }


def main(arguments: Sequence[str]) -> int:
    """Writes the pages to the given folder."""
    if len(arguments) != 1:
        sys.stderr.write("usage: python tests/plugins/diagnostics_pages.py FOLDER\n")
        return 2
    folder = Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pages().items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
    return 0


def _index(counts: dict[str, int]) -> str:
    rows = [f"| [SC{digit}](sc{digit}.md) | {BANDS[digit]} | {count} |" for digit, count in counts.items() if count]
    table = ["| codes | stage | number of codes |", "| --- | --- | --- |", *rows]
    return "\n".join(["# Diagnostics", "", _MARK, _INTRODUCTION, *table, _FORMATS])


def _band(digit: str, rows: Sequence[Code]) -> str:
    head = [f"# SC{digit}: {BANDS[digit]}", "", _MARK, "| code | severity | rule |", "| --- | --- | --- |"]
    return "\n".join([*head, *_cells(rows), "", *map(_entry, rows)])


def _cells(rows: Sequence[Code]) -> Iterator[str]:
    for row in rows:
        title = row.title.replace("|", "\\|")
        yield f"| [{row.code}](#{row.code.lower()}) | {row.severity} | {title} |"


def _entry(row: Code) -> str:
    return f"## {row.code}\n\n**{row.title}** ({row.severity})\n\n{markdown(row)}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
