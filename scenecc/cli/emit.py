"""`scenecc emit`."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.completion import complete_entity
from scenecc.cli.options import (
    OutputFile,
    SceneArgument,
    Show,
    at_least,
    quote_text,
    takes_compile_options,
)
from scenecc.cli.output import (
    STDOUT,
    base_folder,
    end,
    print_asides,
    print_needs,
    progress,
    scene_errors,
    usage_error,
    write_files,
)
from scenecc.cli.paths import checked_source

if TYPE_CHECKING:
    pass


class Target(str, Enum):
    """Export formats."""

    python = "python"
    json = "json"
    glb = "glb"
    mjcf = "mjcf"
    urdf = "urdf"
    usd = "usd"


_TEXTS = (Target.python, Target.json)
SceneIndex = Annotated[
    int | None,
    typer.Option(
        "--scene", metavar="K", parser=at_least(0), help="Index of the scene to export; not for python and json."
    ),
]
Grid = Annotated[bool, typer.Option("--grid", help="Export all scenes side by side (glb).")]
Shown = Annotated[Show, typer.Option("--show", help="Export visual or collision shapes (glb, usd).")]
Triangles = Annotated[
    int | None,
    typer.Option(
        "--max-triangles",
        metavar="N",
        parser=at_least(1),
        help="Simplify visual meshes from files that have more triangles; not for python and json.",
    ),
]
EntityName = Annotated[
    str | None,
    typer.Option("--entity", metavar="NAME", help="Export only this entity (urdf).", autocompletion=complete_entity),
]


@takes_compile_options
def emit(
    scene: SceneArgument,
    *,
    target: Annotated[Target, typer.Option("--to", help="Target format.")],
    output: OutputFile = STDOUT,
    index: SceneIndex = None,
    grid: Grid = False,
    show: Shown = Show.visual,
    entity: EntityName = None,
    triangles: Triangles = None,
    options: dict[str, Any],
) -> None:
    """Export a scene to another format.

    python: a script of plain SAPIEN calls that does not need scenecc. json: the plan. Both contain all scenes. Files
    outside the output's folder are copied to FILE.assets.

    mjcf: one scene for MuJoCo. urdf: its articulations, one in FILE.urdf, or each in its own file in the folder FILE.
    Meshes are written to the folder FILE.assets.

    glb: the visuals of one scene, or of all scenes side by side, for viewers. usd: bodies, joints and visuals, as text
    (.usda) or binary (.usdc). Features that a format does not support are reported as warnings.

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
    from scenecc.export import BINARY_SUFFIXES, EmitChoices

    asked = {"scene": index, "grid": grid, "show": show is Show.collision, "entity": entity, "max_triangles": triangles}
    folder = _check(target, output, asked)
    source = checked_source(scene, output, folder=folder)
    choices: EmitChoices = {"scene": index, "grid": grid, "show": show.value, "entity": entity, "folder": folder}
    with scene_errors(options), progress("build") as told:
        name = None if output == STDOUT else Path(output).stem
        binary = target is Target.usd and Path(output).suffix.lower() in BINARY_SUFFIXES
        base = base_folder(output) if target in _TEXTS else None
        choices |= {"name": name, "binary": binary, "max_triangles": triangles, "progress": told}
        made = scenecc.open_scene(source, **options).emit(target.value, base=base, **choices)
    reason = write_files(output, made.files, folder=folder)
    print_asides(made.diagnostics)
    if reason is not None:
        end([usage_error(*reason, file=output)])
    if target in _TEXTS:
        print_needs(output, made)


def _check(target: Target, output: str, asked: Mapping[str, Any]) -> bool:
    """Returns whether the output is a folder. Raises typer.BadParameter for options or a file that the target does not
    accept.
    """
    from scenecc.export import SUFFIXES, check_choice

    given = [word for word, value in asked.items() if value is not None and value is not False]
    try:
        check_choice(target.value, given)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    suffix, suffixes = Path(output).suffix.lower(), None if target in _TEXTS else SUFFIXES[target.value]
    if output == STDOUT or suffixes is None or suffix in suffixes:
        return False
    several = target is Target.urdf and "entity" not in given
    if not several or suffix in chain(*(SUFFIXES[one.value] for one in Target if one not in _TEXTS)):
        raise typer.BadParameter(f"{quote_text(output)} must end in {' or '.join(suffixes)}", param_hint="'-o'")
    return True
