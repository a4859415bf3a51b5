"""Rows of the table of codes: engine."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = ()
