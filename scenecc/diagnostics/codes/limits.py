"""Rows of the table of codes: limits."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = ()
