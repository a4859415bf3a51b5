"""Rows of the table of codes: assets."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = ()
