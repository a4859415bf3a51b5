"""Writes `docs/diagnostics.md` from the table: `python -m scenecc.diagnostics.docs docs/diagnostics.md`."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from scenecc.diagnostics.codes import BANDS, CODES, Code
from scenecc.diagnostics.explain import markdown

_HEAD = """\
# Diagnostics

<!-- Generated from scenecc/diagnostics/codes.yaml by `python -m scenecc.diagnostics.docs docs/diagnostics.md`. -->

Everything that scenecc has to say about a scene has a code, a severity, a place in the file and, where there
is more to say, a hint. Errors stop the work after the stage that found them, so that all errors of a stage are
seen at once; warnings and notes do not (`scenecc validate --strict` fails on warnings too). `scenecc explain CODE`
prints the entry of one code. The first digit is the stage.

## Formats

Lines and columns count from 1, and columns count characters (Unicode code points). A scene given as a dict has no
lines: its places are the paths alone.

`--format` is one of:

- `text`, for people: the place, the message, the source line underlined, the hint. Coloured on a terminal
  (`NO_COLOR` and `FORCE_COLOR` are heeded). Characters that would steer the terminal are spelled out.
- `json`, for programs: an object whose `diagnostics` is a list of `code`, `severity` (`error`, `warning` or `note`),
  `message`, `file`, `line`, `column`, `end_column` (the one after the last), `path`, `hint` and `related` (a list of
  `message`, `file`, `line`, `column` and `end_column`). What is not known is `null`. ASCII only.
- `github`, for GitHub Actions: one workflow command a line (`::error file=…,line=…::…`), which annotates a pull
  request.
- `sarif`, for code scanning and editors: SARIF 2.1.0. Files are relative to `%SRCROOT%`, the working directory.
"""


def page(codes: Sequence[Code] | None = None) -> str:
    """The whole page: for each band a table of its codes, then each of them with cause, example and cure."""
    codes = tuple(CODES.values()) if codes is None else codes
    bands = {digit: sorted((row for row in codes if row.code[2] == digit), key=_by_code) for digit in BANDS}
    return "\n".join([_HEAD, *(_band(digit, rows) for digit, rows in bands.items() if rows)])


def main(arguments: Sequence[str]) -> int:
    """Writes the page to the file that is named, or prints it."""
    match arguments:
        case []:
            sys.stdout.write(page())
        case [name]:
            Path(name).write_text(page(), encoding="utf-8", newline="\n")
        case _:
            sys.stderr.write("usage: python -m scenecc.diagnostics.docs [FILE]\n")
            return 2
    return 0


def _by_code(row: Code) -> str:
    return row.code


def _band(digit: str, rows: Sequence[Code]) -> str:
    head = [f"## SC{digit}: {BANDS[digit]}", "", "| code | severity | rule |", "| --- | --- | --- |"]
    return "\n".join([*head, *_cells(rows), "", *map(_entry, rows)])


def _cells(rows: Sequence[Code]) -> Iterator[str]:
    for row in rows:
        title = row.title.replace("|", "\\|")
        yield f"| [{row.code}](#{row.code.lower()}) | {row.severity} | {title} |"


def _entry(row: Code) -> str:
    return f"### {row.code}\n\n**{row.title}** ({row.severity})\n\n{markdown(row)}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
