"""`scenecc explain`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from scenecc.cli.completion import complete_code
from scenecc.cli.options import TableFormatOption
from scenecc.cli.output import end, usage_error

if TYPE_CHECKING:
    from scenecc.diagnostics.codes import Code


def explain(
    code: Annotated[
        str | None, typer.Argument(metavar="CODE", help="A code, such as SC101.", autocompletion=complete_code)
    ] = None,
    *,
    form: TableFormatOption = "text",
) -> None:
    """Explain a diagnostic code.

    Prints its cause, an example and the fix. Without a code, the command lists all codes.

    \b
    Examples:
      scenecc explain SC101
      scenecc explain
      scenecc explain --format json
    """
    from scenecc.diagnostics.codes import CODES
    from scenecc.diagnostics.reference import explain_code as explanation
    from scenecc.diagnostics.reference import nearest_codes, normalize_code

    text = _list() if code is None else explanation(code)
    if text is None:
        near = nearest_codes(code or "")
        hint = f"did you mean {' or '.join(near)}?" if near else "`scenecc explain` without a code lists them all"
        unknown = usage_error("SC905", f"unknown code `{code}`", hint=hint)
        end([unknown], form)
    names = CODES if code is None else [normalize_code(code)]
    end([], form, data=lambda: {"codes": [_data(CODES[name]) for name in names]}, text=lambda: text)


def _data(row: Code) -> dict[str, str]:
    """Returns a code for programs."""
    from scenecc.diagnostics.codes import BANDS

    fixed = {"code": row.code, "severity": row.severity, "at_fault": row.at_fault, "stage": BANDS[row.code[2]]}
    return {**fixed, "title": row.title, "cause": row.cause, "example": row.example, "cure": row.cure}


def _list() -> str:
    from scenecc.diagnostics.codes import BANDS, CODES

    lines: list[str] = []
    for digit, band in BANDS.items():
        rows = sorted((row.code, row.severity, row.title) for row in CODES.values() if row.code[2] == digit)
        if rows:
            lines += [f"SC{digit}: {band}", *(f"  {code}  {severity:7}  {title}" for code, severity, title in rows), ""]
    return "\n".join(lines)
