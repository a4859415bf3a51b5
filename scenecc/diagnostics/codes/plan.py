"""Rows of the table of codes: plan."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = ()
