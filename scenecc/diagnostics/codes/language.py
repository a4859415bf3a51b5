"""Rows of the table of codes: language."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = ()
