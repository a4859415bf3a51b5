"""Rows of the table of codes: usage."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = ()
