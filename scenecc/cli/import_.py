"""`scenecc import`."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.completion import complete_loss
from scenecc.cli.many_files import Jobs, Shard, Written, are_many, choose_files, write_each
from scenecc.cli.options import TableFormatOption, takes_compile_options
from scenecc.cli.output import end, progress, unwritten, usage_error
from scenecc.cli.paths import STDIN, Kind, find_files, path_faults

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


Paths = Annotated[
    list[str],
    typer.Argument(
        metavar="FILE...", help="SDF worlds or models, USD stages, MJCF or URDF files, or folders.", show_default=False
    ),
]

Accepted = Annotated[
    list[str] | None,
    typer.Option(
        "--allow",
        metavar="LOSS",
        help="Accept a loss that changes the mechanics, or `all`; may be repeated.",
        autocompletion=complete_loss,
    ),
]

_takes = partial(takes_compile_options, names=("asset_roots", "allow_outside_assets", "limits"))


@_takes
def import_(
    paths: Paths,
    *,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="SCENE", help="Output file, or folder for several files.")
    ],
    jobs: Jobs = None,
    shard: Shard = None,
    allow: Accepted = None,
    keep_file: Annotated[
        bool, typer.Option("--keep-file", help="Let the scene name an MJCF, instead of writing its bodies and robots.")
    ] = False,
    form: TableFormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Convert a world or robot in another format to a scene file.

    The formats are SDF (.sdf, .world), USD (.usd, .usda, .usdc), MJCF (.mjcf, .xml), URDF (.urdf), Drake's model
    directives (.dmd.yaml) and EmbodiedGen's layouts (layout.json). Files that the scene cannot reference by a
    relative path, pkg:// or asset:// are copied to the folder SCENE_assets beside it.

    For several files, or the files in a folder, each scene is written to the folder OUTPUT, under the name of its file.

    The command lists all content that a scene file cannot hold. If masses, joints, contacts or poses would differ, it
    writes nothing, unless --allow names the loss. It then builds the written scene and compares poses and masses with
    MuJoCo for MJCF, with UsdPhysics for USD, and with Drake for the others, if pydrake is installed.

    \b
    Examples:
      scenecc import world.sdf -o scene.yaml
      scenecc import world.sdf -o scene.yaml --asset-root ~/models
      scenecc import world.sdf -o scene.yaml --allow screw-joints
      scenecc import world.xml -o scene.yaml --allow all
      scenecc import stage.usd -o scene.yaml
      scenecc import robot.xml -o scene.yaml --keep-file
      scenecc import robot.urdf -o scene.yaml
      scenecc import room.dmd.yaml -o room.yaml --asset-root ~/drake_models
      scenecc import layout.json -o room.yaml
      scenecc import worlds robots/*.urdf -o scenes --jobs 2
    """
    _check_arguments(paths, output, allow or ())
    accepted = {"allow": allow or (), "keep_file": keep_file, **options}
    if are_many(paths, shard):
        choose = partial(choose_files, changed_since=None, shard=shard, files_of=lambda _: None)
        found = find_files(paths, kind=_source_kind())
        write_each("import", found, output, ".yaml", jobs, partial(_import, accepted, named=True), form, choose)
    if faults := path_faults(paths[0], output, source="source"):
        end(faults, form)
    with progress("import") as show:
        diagnostics, text, files = _import({"progress": show, **accepted}, paths[0], output)
    end(diagnostics, form, data=lambda: {"files": files}, text=lambda: text)


def _source_kind() -> Kind:
    """Returns the kind of files that can be imported."""
    from scenecc.importers import FORMATS
    from scenecc.importers.import_scene import is_source

    suffixes = tuple(dict.fromkeys(suffix for one in FORMATS for suffix in one.suffixes))
    return Kind("source", suffixes, lambda file: is_source(Path(file)), f"its suffix is {', '.join(suffixes)}")


def _check_arguments(paths: list[str], output: str, allow: Sequence[str]) -> None:
    from scenecc.diagnostics.messages import suggest
    from scenecc.importers.imported_scene import ALL_LOSSES, LOSSES

    unknown = next((kind for kind in allow if kind not in {*LOSSES, ALL_LOSSES}), None)
    if unknown is not None:
        hint = suggest(unknown, complete_loss())
        raise typer.BadParameter(f"there is no loss '{unknown}'; {hint}", param_hint="'--allow'")
    if STDIN in paths:
        raise typer.BadParameter("an import reads a file, not standard input", param_hint="'FILE'")
    if output == STDIN:
        raise typer.BadParameter("an import writes several files: name the scene file", param_hint="'--output' / '-o'")


def _import(options: Mapping[str, Any], file: str, scene: str, *, named: bool = False) -> Written:
    """Imports one file. The text is the comparison; with `named`, its lines begin with the scene's path."""
    import scenecc
    from scenecc.importers.assets import output_fault

    if (fault := output_fault(Path(scene))) is not None:
        hint = "name another file after -o: the scene names the files beside it by this name"
        return [usage_error("SC904", f"`{scene}` cannot be written: {fault}", file=scene, hint=hint)], "", []
    try:
        made = scenecc.import_scene(file, scene, **options)
    except scenecc.SceneError as error:
        return error.diagnostics, "", []
    except OSError as error:
        return [usage_error(*unwritten(error.filename or scene, error), file=scene)], "", []
    text = "".join(f"{f'{scene}: ' if named else ''}{line}\n" for line in made.certificate.lines())
    return made.diagnostics, text, [{"source": file, "file": scene, "certificate": asdict(made.certificate)}]
