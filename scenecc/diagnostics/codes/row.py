"""The shape of a row in the table of codes."""

from __future__ import annotations

from typing import Literal

from scenecc.diagnostics.frozen import frozen

Fault = Literal["scene", "usage", "machine"]
"""What has to be put right: the scene file, the command, or the engine and the machine."""


@frozen
class Code:
    """What one diagnostic code means, for `scenecc explain` and `docs/diagnostics.md`.

    Attributes:
        code: `SC` and three digits. The first digit is the stage.
        severity: what a report of this code is.
        title: the rule, in a few words.
        cause: why it is refused: what SAPIEN would do, or what it could mean.
        example: a scene file (or the command) that gives it.
        cure: the same, mended, or what to do.
        at_fault: who has to put it right, where that is not whom `at_fault` of the package says by the first digit.
    """

    code: str
    severity: Literal["error", "warning", "note"]
    title: str
    cause: str
    example: str
    cure: str
    at_fault: Fault | None = None
