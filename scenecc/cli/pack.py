"""`scenecc pack`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.completion import complete_scene
from scenecc.cli.options import TableFormatOption, takes_compile_options
from scenecc.cli.output import (
    STDOUT,
    end,
    scene_errors,
    unwritten,
    usage_error,
    write_output,
)
from scenecc.cli.paths import STDIN, path_faults
from scenecc.cli.tables import escape_text

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic
    from scenecc.source.pack import Manifest


@partial(takes_compile_options, names=("num_scenes", "params", "asset_roots", "allow_outside_assets", "limits"))
def pack(
    scene: Annotated[
        str, typer.Argument(metavar="SCENE", help="A scene file; with --list, a pack.", autocompletion=complete_scene)
    ],
    *,
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="FILE", help="Output file, NAME.scn; - is standard output.")
    ] = None,
    add: Annotated[
        list[Path] | None,
        typer.Option("--add", metavar="PATH", help="Add a file or folder; may be repeated."),
    ] = None,
    listed: Annotated[bool, typer.Option("--list", help="List the files in a pack, with SHA-256 hashes.")] = False,
    form: TableFormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Pack a scene and all files that it uses into one archive.

    Every command and function that takes a scene also takes a pack. A pack needs no asset roots and no packages, and
    reads no outside files. The same files give the same bytes on any machine.

    The pack contains the files for all seeds, the parameters' defaults and --set. If file names depend on parameters of
    the type choice or boolean, it contains the files for all their values.

    \b
    Examples:
      scenecc pack scenes/tray.yaml -o tray.scn
      scenecc pack scenes/tray.yaml --add scenes/assets/bowl.obj -o tray.scn
      scenecc pack --list tray.scn
      scenecc build tray.scn
    """
    import scenecc

    _check_usage(scene, output, listed=listed)
    if faults := [*path_faults(scene, output, form), *_report_missing(add or [])]:
        end(faults, form)
    with scene_errors(options, form):
        if listed:
            from scenecc.pack import read_pack

            manifest, content, found = read_pack(scene).manifest, None, ()
        else:
            try:
                packed = scenecc.pack_scene(scene, add=add or (), **options)
            except OSError as error:
                end([usage_error(*unwritten(error.filename or output or scene, error), file=output)], form)
            manifest, content, found = packed.manifest, packed.content, packed.diagnostics
    if content is not None and output is not None and (fault := write_output(output, content)) is not None:
        end([usage_error(*fault, file=output)], form)
    end(found, form, data=manifest.model_dump, text=lambda: _text(manifest, output, content), beside=not listed)


def _check_usage(scene: str, output: str | None, *, listed: bool) -> None:
    from scenecc.files import PACK_SUFFIX

    if listed == (output is not None):
        raise typer.BadParameter("give either -o FILE or --list", param_hint="'-o'")
    if scene == STDIN:
        raise typer.BadParameter("a scene on standard input has no folder: name its file", param_hint="'SCENE'")
    if output is not None and output != STDOUT and Path(output).suffix.lower() != PACK_SUFFIX:
        raise typer.BadParameter(f"the name of a pack must be NAME{PACK_SUFFIX}", param_hint="'-o'")


def _report_missing(paths: list[Path]) -> list[Diagnostic]:
    missing = [str(path) for path in paths if not path.exists()]
    return [usage_error("SC901", f"file or folder `{path}` not found", file=path) for path in missing]


def _text(manifest: Manifest, output: str | None, content: bytes | None) -> str:
    """Returns a line about the written pack; or one line per file, in the format of `sha256sum`, the scene first."""
    if content is not None:
        return f"{output}: {len(manifest.files)} file{'s' * (len(manifest.files) != 1)}, {len(content)} bytes\n"
    names = [manifest.entry, *(name for name in manifest.files if name != manifest.entry)]
    return "".join(f"{manifest.files[name]}  {escape_text(name)}\n" for name in names)
