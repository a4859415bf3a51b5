"""Rows of the table of codes: reading."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = ()
