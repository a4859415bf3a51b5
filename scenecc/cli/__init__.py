"""The command line: one file per command, with no logic that the API lacks.

Importing this package loads almost nothing. Its commands load Typer, and a command loads the rest when it runs.
"""

import os
import sys
from contextlib import suppress

from scenecc.interrupt import end_at_signals

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn

__all__ = ["main"]

_YOUNG_CONTAINERS = 100_000
"""New containers between two runs of the garbage collector (Python's default is 700). The modules of a command make 40
000 that stay, and scanning them repeatedly took a tenth of a small check."""


def main() -> "NoReturn":
    """Runs the `scenecc` process. It exits with the status of its command, or of the signal that ended it."""
    end_at_signals()  # before the imports, which take longer than many commands
    import gc

    gc.set_threshold(_YOUNG_CONTAINERS, *gc.get_threshold()[1:])

    if sys.getfilesystemencoding() == "ascii" and os.environ.get("PYTHONUTF8") != "1":  # `-X utf8=0` has priority
        # With LC_ALL=C and PYTHONUTF8=0, no file name in a scene could go beyond ASCII, and SAPIEN rejects such names.
        os.environ["PYTHONUTF8"] = "1"
        os.execv(sys.executable, sys.orig_argv)  # noqa: S606 - restarts this process

    from scenecc.cli.app import main as run

    status: object = 0
    try:
        run()
    except SystemExit as ended:
        status = ended.code or 0
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError):  # the writer has reported it
            stream.flush()
    # Objects are not freed one by one: that takes longer than many commands, and signals would wait meanwhile.
    os._exit(status if isinstance(status, int) else 1)
