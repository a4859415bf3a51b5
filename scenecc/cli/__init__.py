"""The command line: one file a command, and no logic that the API does not have.

Importing it loads next to nothing, its commands load Typer, and a command loads what it needs when it runs.
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
"""New containers after which the garbage collector looks for cycles (Python's default is 700). The modules of a command
make 40 000 that stay, and looking through them again and again took a tenth of a small check."""


def main() -> "NoReturn":
    """The process `scenecc`: ends with the status of its command, or with that of a signal."""
    end_at_signals()  # before the imports, which take longer than many a command
    import gc

    gc.set_threshold(_YOUNG_CONTAINERS, *gc.get_threshold()[1:])

    if sys.getfilesystemencoding() == "ascii" and os.environ.get("PYTHONUTF8") != "1":  # `-X utf8=0` is stronger
        # LC_ALL=C and PYTHONUTF8=0: text from a file could name none beyond ASCII, and SAPIEN takes no such name.
        os.environ["PYTHONUTF8"] = "1"
        os.execv(sys.executable, sys.orig_argv)  # noqa: S606 - this process again

    from scenecc.cli.app import main as run

    status: object = 0
    try:
        run()
    except SystemExit as ended:
        status = ended.code or 0
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError):  # whoever wrote has told it
            stream.flush()
    # Nothing is freed one by one: that takes longer than many a command, and signals are not heard meanwhile.
    os._exit(status if isinstance(status, int) else 1)
