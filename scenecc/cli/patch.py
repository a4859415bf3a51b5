"""`scenecc patch`."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from scenecc.cli.completion import complete_scene
from scenecc.cli.options import TableFormatOption, takes_compile_options
from scenecc.cli.output import end, of_settings, print_note, unwritten, usage_error
from scenecc.cli.paths import STDIN, path_faults

_OPTIONS: Final = ("num_scenes", "params", "starts", "asset_roots", "allow_outside_assets", "limits")
_MOST: Final = 2**26
"""Maximum bytes of a patch."""


@partial(takes_compile_options, names=_OPTIONS)
def patch(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="A scene file.", autocompletion=complete_scene)],
    edits: Annotated[
        str, typer.Argument(metavar="PATCH", help="The JSON Patch, a file that holds it, or - for standard input.")
    ],
    *,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Show the change, but do not write the file.")] = False,
    allow_errors: Annotated[
        bool, typer.Option("--allow-errors", help="Write the file even if the scene has new errors.")
    ] = False,
    form: TableFormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Edit a scene file by a JSON Patch, and keep its comments.

    PATCH is a list of the operations of RFC 6902: add, remove, replace, move, copy and test. Paths are JSON Pointers
    into the file as it is written, such as /entities/cube/pose/0. New values take the style of their neighbours;
    nothing else changes.

    The operations apply in order, all or none. The result is validated first: if it has new errors, they are printed
    and the file stays unchanged. The change is printed as a diff.

    \b
    Examples:
      scenecc patch scene.yaml '[{"op": "remove", "path": "/entities/cube"}]'
      scenecc patch s.yaml '[{"op":"add","path":"/entities/a/mass","value":0.2}]'
      scenecc patch scene.yaml edits.json --dry-run
      cat edits.json | scenecc patch scene.yaml - --format json
    """
    from scenecc.errors import SceneError
    from scenecc.options import Options
    from scenecc.scene_file.json_patch import PatchError, parse_patch
    from scenecc.scene_file.patch import patch_file

    if scene == STDIN:
        raise typer.BadParameter("standard input cannot be edited: name a file", param_hint="'SCENE'")
    nothing = {"written": False, "diff": ""}
    if faults := path_faults(scene, None):
        end(faults, form, data=lambda: nothing)
    try:
        operations = parse_patch(_read_patch(edits))
    except PatchError as error:
        end([usage_error("SC941", str(error), hint=error.hint)], form, data=lambda: nothing)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        end([usage_error("SC901", f"`{edits}` cannot be read: {reason}", file=edits)], form, data=lambda: nothing)
    try:
        made = patch_file(scene, operations, Options.of(**options), dry_run=dry_run, allow_errors=allow_errors)
    except SceneError as error:
        end(of_settings(error.diagnostics, options["params"]), form, data=lambda: nothing)
    except OSError as error:
        end([usage_error(*unwritten(error.filename or scene, error), file=scene)], form, data=lambda: nothing)
    if form == "text":
        state = "not written: --dry-run" if dry_run else "written"
        state = state if made.diff else "not changed"
        if made.refused:
            state = "not written: it would have new errors (--allow-errors writes them)"
        print_note(f"{scene}: {state}\n")
    found = of_settings(made.diagnostics, options["params"])
    end(found, form, data=lambda: {"written": made.written, "diff": made.diff}, text=lambda: made.diff)


def _read_patch(edits: str) -> str:
    """Returns the text of a patch. Raises OSError, or ValueError if it is not UTF-8."""
    from scenecc.files import read_at_most

    if edits.lstrip().startswith(("[", "{")):
        return edits
    content = sys.stdin.buffer.read(_MOST) if edits == STDIN else read_at_most(Path(edits), _MOST)
    return content.decode("utf-8-sig")
