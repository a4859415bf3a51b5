"""The command line run as a process, as people run it."""

from __future__ import annotations

import os

CUBE = """\
scenecc: 1
entities:
  cube: {shapes: [{type: box, half_size: [0.1, 0.2, 0.3]}]}
"""


def plain_environment(**changes: str) -> dict[str, str]:
    """This process's environment without what asks for or forbids colour."""
    kept = {k: v for k, v in os.environ.items() if k not in {"NO_COLOR", "FORCE_COLOR", "COLUMNS"}}
    return {**kept, "TERM": "xterm-256color", **changes}
