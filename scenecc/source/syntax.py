"""What the parser says about bad YAML, in words that help."""

from __future__ import annotations

from yaml import MarkedYAMLError, YAMLError

from scenecc.source.faults import Faults
from scenecc.source.text import control_character


def report_syntax(error: YAMLError, faults: Faults) -> None:
    """Reports what ended the parser."""
    if isinstance(error, MarkedYAMLError) and error.problem_mark is not None:
        mark = error.problem_mark
        faults.report("SC003", str(error.problem), faults.lines.location(mark.line, mark.column, mark.column + 1))
        return
    offset = control_character(faults.lines.text)
    if offset is not None:
        faults.character(offset)
    else:
        faults.report("SC003", str(error), faults.lines.location(0, 0, 1))
