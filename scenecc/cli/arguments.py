"""What can be wrong with the paths of a command before any work is done."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.cli.find import STDIN
from scenecc.cli.options import Format
from scenecc.cli.output import STDOUT, folder_refusal, refusal
from scenecc.cli.report import usage_error

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic


def path_faults(
    scene: str, output: str | None, form: Format = Format.text, *, folder: bool = False
) -> list[Diagnostic]:
    """Faults of the scene's path and the output's. `output`: None writes nothing. `folder`: whether it is to be one."""
    faults: list[Diagnostic] = []
    if scene != STDIN and not os.path.lexists(scene):
        faults.append(usage_error("SC901", f"there is no file `{scene}`", file=scene))
    elif scene != STDIN and Path(scene).is_dir():
        message = f"`{scene}` is a folder, and one file is read"
        faults.append(usage_error("SC901", message, file=scene, hint="name a scene file in it"))
    if output is None:
        return faults
    if output == STDOUT and form is not Format.text:
        message = f"standard output cannot hold both the result (`-o -`) and diagnostics as {form.value}"
        faults.append(usage_error("SC906", message, file=output, hint="name a file after -o"))
    elif scene != STDIN and _is_same_file(scene, output):
        message = f"`{output}` is the scene itself, which would be lost"
        faults.append(usage_error("SC904", message, file=output, hint="name another file after -o"))
    elif (reason := folder_refusal(output) if folder else refusal(output)) is not None:
        faults.append(usage_error("SC904", reason, file=output))
    return faults


def _is_same_file(scene: str, output: str) -> bool:
    try:
        return Path(scene).samefile(output)
    except OSError:  # one is not there, or cannot be
        return False
