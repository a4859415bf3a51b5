"""`scenecc emit`."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.options import (
    SceneArgument,
    Show,
    at_least,
    shown,
    takes_compile_options,
)
from scenecc.cli.output import (
    STDOUT,
    base_folder,
    end,
    print_asides,
    progress,
    scene_errors,
    usage_error,
    write,
    write_files,
)
from scenecc.cli.paths import checked_source

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic


class Target(str, Enum):
    """What a scene is emitted as."""

    python = "python"
    json = "json"
    glb = "glb"
    mjcf = "mjcf"
    urdf = "urdf"
    usd = "usd"


_TEXTS = (Target.python, Target.json)
_SUFFIXES = {
    Target.glb: (".glb",),
    Target.mjcf: (".xml", ".mjcf"),
    Target.urdf: (".urdf", ".xml"),
    Target.usd: (".usda", ".usd", ".usdc"),
}
"""Of files that other programs tell by their names."""

_BINARY = (".usd", ".usdc")
"""Suffixes of USD's binary form."""

SceneIndex = Annotated[
    int | None,
    typer.Option("--scene", metavar="K", parser=at_least(0), help="Which scene, for all but python and json."),
]
Grid = Annotated[bool, typer.Option("--grid", help="All scenes side by side (glb).")]
Shown = Annotated[Show, typer.Option("--show", help="Draw what is seen, or the colliding shapes (glb, usd).")]
EntityName = Annotated[str | None, typer.Option("--entity", metavar="NAME", help="Write this entity alone (urdf).")]


@takes_compile_options
def emit(
    scene: SceneArgument,
    *,
    target: Annotated[Target, typer.Option("--to", help="What to write.")],
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FILE", help="Where to write it; - is standard output.")
    ] = STDOUT,
    index: SceneIndex = None,
    grid: Grid = False,
    show: Shown = Show.visual,
    entity: EntityName = None,
    options: dict[str, Any],
) -> None:
    """Write a scene for another program.

    python is a script of plain SAPIEN calls that needs no scenecc; json is the scene's plan. Both hold all scenes.

    mjcf is one scene for MuJoCo, urdf are its articulations, one in FILE.urdf or each in a file in the folder FILE.
    Meshes lie in the folder FILE.assets.

    glb is what is seen of one scene, or of all side by side, in a file that viewers show; usd has bodies, joints and
    what is seen, as text (.usda) or binary (.usdc). What a target cannot hold is told as warnings.

    \b
    Examples:
      scenecc emit scenes/tabletop.yaml --to python
      scenecc emit scenes/tabletop.yaml --to json -o tabletop.plan.json
      scenecc emit scenes/tabletop.yaml --to mjcf -o tabletop.xml
      scenecc emit scenes/robot_arm.yaml --to urdf --entity arm -o arm.urdf
      scenecc emit scenes/variation.yaml --to glb --grid -o variation.glb
      scenecc emit scenes/robot_arm.yaml --to usd -o arm.usda
    """
    import scenecc

    asked = {"scene": index, "grid": grid, "show": show is Show.collision, "entity": entity}
    folder = _check(target, output, asked)
    source = checked_source(scene, output, folder=folder)
    found: list[Diagnostic] = []
    with scene_errors(options):
        if target in _TEXTS:
            text = scenecc.emit_scene(source, target.value, base=base_folder(output), found=found, **options)
            reason = write(output, text)
        else:
            options |= {"scene": index, "grid": grid, "show": show.value, "entity": entity, "folder": folder}
            options["binary"] = target is Target.usd and Path(output).suffix.lower() in _BINARY
            name = None if output == STDOUT else Path(output).stem
            with progress("build") as told:
                files = scenecc.export_scene(source, target.value, name=name, found=found, progress=told, **options)
            reason = write_files(output, files, folder=folder)
    print_asides(found)
    if reason is not None:
        end([usage_error(*reason, file=output)])


def _check(target: Target, output: str, asked: Mapping[str, Any]) -> bool:
    """Whether the output is a folder. Raises typer.BadParameter for options or a file that the target does not take."""
    from scenecc.export import check_choice

    given = [word for word, value in asked.items() if value is not None and value is not False]
    try:
        check_choice(target.value, given)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    suffix, suffixes = Path(output).suffix.lower(), _SUFFIXES.get(target)
    if output == STDOUT or suffixes is None or suffix in suffixes:
        return False
    several = target is Target.urdf and "entity" not in given
    if not several or suffix in chain(*_SUFFIXES.values()):
        raise typer.BadParameter(f"{shown(output)} does not end in {' or '.join(suffixes)}", param_hint="'-o'")
    return True
