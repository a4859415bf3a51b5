"""`scenecc explain`."""

from __future__ import annotations

from typing import Annotated

import typer

from scenecc.cli.completion import complete_code
from scenecc.cli.output import end, print_out, usage_error


def explain(
    code: Annotated[
        str | None, typer.Argument(metavar="[CODE]", help="A code, such as SC101.", autocompletion=complete_code)
    ] = None,
) -> None:
    """Explain a diagnostic code.

    Prints its cause, an example and the fix. Without a code, the command lists all codes.

    \b
    Examples:
      scenecc explain SC101
      scenecc explain
    """
    from scenecc.diagnostics.reference import explain_code as explanation
    from scenecc.diagnostics.reference import nearest_codes

    if code is None:
        print_out(_list())
        return
    text = explanation(code)
    if text is None:
        near = nearest_codes(code)
        hint = f"did you mean {' or '.join(near)}?" if near else "`scenecc explain` without a code lists them all"
        unknown = usage_error("SC905", f"unknown code `{code}`", hint=hint)
        end([unknown])
    print_out(text)


def _list() -> str:
    from scenecc.diagnostics.codes import BANDS, CODES

    lines: list[str] = []
    for digit, band in BANDS.items():
        rows = sorted((row.code, row.severity, row.title) for row in CODES.values() if row.code[2] == digit)
        if rows:
            lines += [f"SC{digit}: {band}", *(f"  {code}  {severity:7}  {title}" for code, severity, title in rows), ""]
    return "\n".join(lines)
