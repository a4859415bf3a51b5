"""Rows of the table of codes: names."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = ()
