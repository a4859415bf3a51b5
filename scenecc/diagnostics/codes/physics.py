"""Rows of the table of codes: physics."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = ()
