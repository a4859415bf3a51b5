"""`scenecc import`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from scenecc.cli.options import takes_compile_options
from scenecc.cli.output import end, print_asides, print_out, progress, scene_errors, usage_error
from scenecc.cli.paths import STDIN, path_faults

_takes = partial(takes_compile_options, names=("asset_roots", "allow_outside_assets", "limits"))


@_takes
def import_(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE", help="An SDF world or model, a USD stage, an MJCF, or a URDF.", show_default=False
        ),
    ],
    *,
    output: Annotated[str, typer.Option("--output", "-o", metavar="SCENE", help="The scene file to write.")],
    allow: Annotated[
        list[str] | None,
        typer.Option("--allow", metavar="LOSS", help="Accept a loss that changes the machine; may be repeated."),
    ] = None,
    options: dict[str, Any],
) -> None:
    """Write a scene file for a world or a robot of another format.

    The formats are SDF (.sdf, .world), USD (.usd, .usda, .usdc), MJCF (.mjcf, .xml) and URDF (.urdf). Files that the
    scene can name neither relative to itself nor by pkg:// or asset:// are copied to the folder SCENE_assets beside
    it.

    The command lists all content that a scene file does not hold. If masses, joints, contacts or poses would differ,
    it writes nothing, unless --allow names the loss. It then builds the scene as written and compares poses and masses
    with MuJoCo for an MJCF, with UsdPhysics for a stage, and with Drake for the others, if pydrake is installed.

    \b
    Examples:
      scenecc import world.sdf -o scene.yaml
      scenecc import world.sdf -o scene.yaml --asset-root ~/models
      scenecc import world.sdf -o scene.yaml --allow screw-joints
      scenecc import stage.usd -o scene.yaml
      scenecc import world.xml -o scene.yaml
      scenecc import robot.urdf -o scene.yaml
    """
    from scenecc.importers.assets import output_fault
    from scenecc.importers.import_scene import import_scene
    from scenecc.importers.imported_scene import LOSSES

    unknown = next((kind for kind in allow or () if kind not in LOSSES), None)
    if unknown is not None:
        known = ", ".join(kind for kind, row in LOSSES.items() if row.changes_machine)
        raise typer.BadParameter(f"there is no loss '{unknown}'; the losses are {known}", param_hint="'--allow'")
    if file == STDIN:
        raise typer.BadParameter("the source is a file, and not standard input", param_hint="'FILE'")
    if output == STDIN:
        raise typer.BadParameter("an import writes several files: name the scene file", param_hint="'--output' / '-o'")
    faults = path_faults(file, output, source="source")
    if not faults and (fault := output_fault(Path(output))) is not None:
        hint = "name another file after -o: the scene names the files beside it by this name"
        faults = [usage_error("SC904", f"`{output}` cannot be written: {fault}", file=output, hint=hint)]
    if faults:
        end(faults)
    with scene_errors(options), progress("import") as show:
        try:
            made = import_scene(file, output, allow=allow or (), progress=show, **options)
        except OSError as error:
            end(
                [usage_error("SC904", f"`{error.filename or output}` cannot be written: {error.strerror}", file=output)]
            )
    print_asides(made.diagnostics)
    print_out("".join(f"{line}\n" for line in made.certificate.lines()))
