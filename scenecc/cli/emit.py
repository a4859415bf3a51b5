"""`scenecc emit`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from scenecc.cli.completion import complete_entity
from scenecc.cli.options import (
    OutputFile,
    SceneArgument,
    Show,
    TableFormatOption,
    at_least,
    quote_text,
    takes_compile_options,
)
from scenecc.cli.output import (
    STDOUT,
    base_folder,
    end,
    print_needs,
    progress,
    scene_errors,
    usage_error,
    write_files,
)
from scenecc.cli.paths import checked_source

Target = Literal["python", "json", "glb", "mjcf", "urdf", "usd"]
_TEXTS = ("python", "json")
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
    output: OutputFile = STDOUT,
    to: Annotated[
        Target | None, typer.Option("--to", help="Target format.", show_default="that of the suffix of -o")
    ] = None,
    index: SceneIndex = None,
    grid: Grid = False,
    show: Shown = "visual",
    entity: EntityName = None,
    triangles: Triangles = None,
    form: TableFormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Export a scene to another format.

    python: a script of plain SAPIEN calls that does not need scenecc. json: the plan. Both contain all scenes. Files
    outside the output's folder are copied to FILE.assets.

    mjcf: one scene for MuJoCo. urdf: its articulations, one in FILE.urdf, or each in its own file in the folder FILE.
    Meshes are written to the folder FILE.assets.

    glb: the visuals of one scene, or of all scenes side by side, for viewers. usd: bodies, joints and visuals, as text
    (.usda) or binary (.usdc). Without --to, the suffix of -o selects the format; .xml is MJCF. Features that a format
    does not support are reported as warnings.

    \b
    Examples:
      scenecc emit scenes/tabletop.yaml --to python
      scenecc emit scenes/tabletop.yaml -o tabletop.plan.json
      scenecc emit scenes/tabletop.yaml -o tabletop.xml
      scenecc emit scenes/robot_arm.yaml --entity arm -o arm.urdf
      scenecc emit scenes/robot_arm.yaml --to urdf -o robots
      scenecc emit scenes/variation.yaml --grid -o variation.glb
      scenecc emit scenes/robot_arm.yaml -o arm.usda
    """
    import scenecc
    from scenecc.export import BINARY_SUFFIXES, EmitChoices

    asked = {"scene": index, "grid": grid, "show": show == "collision", "entity": entity, "max_triangles": triangles}
    target = _choose_target(to, output)
    folder = _is_folder(target, output, asked)
    source = checked_source(scene, output, form, folder=folder)
    choices: EmitChoices = {"scene": index, "grid": grid, "show": show, "entity": entity, "folder": folder}
    with scene_errors(options, form), progress("build") as told:
        name = None if output == STDOUT else Path(output).stem
        binary = target == "usd" and Path(output).suffix.lower() in BINARY_SUFFIXES
        base = base_folder(output) if target in _TEXTS else None
        choices |= {"name": name, "binary": binary, "max_triangles": triangles, "progress": told}
        made = scenecc.open_scene(source, **options).emit(target, base=base, **choices)
    reason = write_files(output, made.files, folder=folder)
    found = made.diagnostics if reason is None else [*made.diagnostics, usage_error(*reason, file=output)]
    if target in _TEXTS and reason is None and form == "text":
        print_needs(output, made)
    names = list(made.files)
    paths = [str(Path(output, name)) for name in names] if folder else [output, *_beside(output, names[1:])]
    written = {"target": target, "files": paths, "needs": made.needs}
    end(found, form, data=lambda: written if reason is None else {})


def _beside(output: str, names: list[str]) -> list[str]:
    return [str(Path(output).parent / name) for name in names]


def _choose_target(to: Target | None, output: str) -> str:
    """Returns the target that `--to` or the suffix of the output names. Raises typer.BadParameter if there is none, or
    if they differ.
    """
    from scenecc.export import SUFFIXES, target_of

    suffix = Path(output).suffix.lower()
    if to is None:
        try:
            return target_of(Path(output))
        except ValueError:
            known = ", ".join(f"{suffixes[0]} ({target})" for target, suffixes in SUFFIXES.items())
            message = f"give --to, or an output -o FILE with one of the suffixes {known}"
            raise typer.BadParameter(message, param_hint="'--to'") from None
    others = [target for target, suffixes in SUFFIXES.items() if suffix in suffixes]
    if others and to not in others:
        message = f"{quote_text(output)} must end in {' or '.join(SUFFIXES[to])}, or leave out --to: {suffix} is "
        raise typer.BadParameter(f"{message}{others[0]}", param_hint="'-o'")
    return to


def _is_folder(target: str, output: str, asked: Mapping[str, Any]) -> bool:
    """Returns whether the output is a folder. Raises typer.BadParameter for options or a file that the target does not
    accept.
    """
    from scenecc.export import SUFFIXES, check_choice

    given = [word for word, value in asked.items() if value is not None and value is not False]
    try:
        check_choice(target, given)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    suffixes = SUFFIXES[target]
    suffix = Path(output).suffix.lower()
    if output == STDOUT or suffix in suffixes or (target in _TEXTS and not suffix):
        return False
    if target != "urdf" or "entity" in given:
        raise typer.BadParameter(f"{quote_text(output)} must end in {' or '.join(suffixes)}", param_hint="'-o'")
    return True
