"""`scenecc build`."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from scenecc.cli.options import (
    Format,
    FormatOption,
    SceneArgument,
    Steps,
    takes_compile_options,
)
from scenecc.cli.output import (
    STDOUT,
    base_folder,
    end,
    print_err,
    print_needs,
    print_out,
    progress,
    scene_errors,
    usage_error,
    write_files,
)
from scenecc.cli.paths import checked_source
from scenecc.cli.tables import built, escape_text, planned, stage_times

if TYPE_CHECKING:
    from scenecc import Build, Diagnostic, SceneBatch, ScenePlan

_STRIDE = 10
"""Steps between two progress reports."""


Scenes = Annotated[
    str | None, typer.Option("--scenes", metavar="IDXS", help="Build only these scenes: 0:4 or 0,2 or ::2.")
]
Output = Annotated[
    str | None, typer.Option("--output", "-o", metavar="PLAN.json", help="Write the plan; - is standard output.")
]
AuditOption = Annotated[
    bool | None,
    typer.Option(
        "--audit/--no-audit",
        help="Compare poses, masses and counts in the engine with the plan.",
        show_default="audit",
    ),
]
Render = Annotated[
    bool | None,
    typer.Option("--render/--no-render", help="Also build visuals.", show_default="if a render device exists"),
]


@takes_compile_options
def build(
    scene: SceneArgument,
    *,
    scenes: Scenes = None,
    steps: Steps = 0,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Compile only, without starting the engine.")] = False,
    output: Output = None,
    render: Render = None,
    audit: AuditOption = None,
    every: Annotated[bool, typer.Option("--all", help="Print all rows of long tables.")] = False,
    form: FormatOption = Format.text,
    options: dict[str, Any],
) -> None:
    """Build a scene as parallel SAPIEN scenes.

    Prints a table of the entities and their scenes, and the time of each stage. If there are more than 30 entities,
    identical copies share a row. The scenes are simulated on the CPU; thousands of scenes on a GPU run through
    scenecc.maniskill.

    \b
    Examples:
      scenecc build scenes/tabletop.yaml --num-scenes 4
      scenecc build scenes/tabletop.yaml --steps 300 --no-render
      scenecc build scenes/tabletop.yaml --dry-run -o plan.json
      scenecc build scenes/parameters.yaml --set size=0.6 --set color="#884422"
    """
    import scenecc

    if dry_run:
        for option, is_given in (("--steps", steps), ("--audit", audit is True), ("--render", render is True)):
            if is_given:
                message = "it needs the engine, which --dry-run does not start"
                raise typer.BadParameter(message, param_hint=f"'{option}'")
    source = checked_source(scene, output, form)
    with scene_errors(options, form), progress("build") as show:
        result = scenecc.build_scene(
            source,
            **options,
            scenes=scenes,
            dry_run=dry_run,
            render=render,
            audit=audit is not False,
            progress=show,
        )
    _conclude(result, steps, output, form, whole=every)


def _conclude(result: Build, steps: int, output: str | None, form: Format, *, whole: bool) -> NoReturn:
    import scenecc

    timings, diagnostics = dict(result.timings), list(result.diagnostics)
    if result.batch is not None:
        try:
            with result.batch:
                timings |= _step(result.batch, steps)
        except scenecc.SceneError as error:
            end([*diagnostics, *error.diagnostics], form)
    if output is not None:
        try:
            diagnostics += _write_plan(result.plan, output)
        except scenecc.SceneError as error:
            end([*diagnostics, *error.diagnostics], form)
    if form is Format.text:
        (print_err if output == STDOUT else print_out)(_summary(result, timings, whole=whole))
    end(diagnostics, form)


def _write_plan(plan: ScenePlan, output: str) -> list[Diagnostic]:
    """Writes the plan, and beside it the files that it names outside the folder. Returns diagnostics."""
    from scenecc.diagnostics import Sink
    from scenecc.export import emit_text

    made = emit_text(plan, "json", Path(output).stem, Sink(), base=base_folder(output))
    reason = write_files(output, made.files, folder=False)
    if reason is not None:
        return [usage_error(*reason, file=output)]
    print_needs(output, made)
    return []


def _step(batch: SceneBatch, steps: int) -> dict[str, float]:
    """Simulates, and returns the time by stage."""
    if steps == 0:
        return {}
    started = time.perf_counter()
    with progress("step") as show:
        for done in range(0, steps, _STRIDE):
            if show is not None:
                show(done, steps)
            batch.step(min(_STRIDE, steps - done), check=True)
    return {"step": time.perf_counter() - started}


def _summary(result: Build, timings: dict[str, float], *, whole: bool) -> str:
    from scenecc.diagnostics.formats import wants_color

    show, done = (planned, "planned") if result.batch is None else (built, "built")
    rows = show(result.summary, color=wants_color(sys.stdout), whole=whole)
    return f"{rows}\n{escape_text(result.plan.name)}: {done} {_totals(result)}\n{stage_times(timings)}\n"


def _totals(result: Build) -> str:
    """Returns the numbers of scenes, objects and differing fields."""
    count, total = len(result.scene_idxs), result.plan.num_scenes
    scenes = f"{f'{count} of ' if count < total else ''}{_count(total, 'scene')}"
    objects = sum(len(row.scene_idxs) for row in result.summary)
    fields = [field for row in result.summary for field in row.varying]
    at_reset = sum(field.at_reset for field in fields)
    differing = f"; {_count(len(fields), 'field')} {'differs' if len(fields) == 1 else 'differ'}" if fields else ""
    again = f", {at_reset} drawn again at a reset" if at_reset else ""
    return f"{scenes}, {_count(objects, 'object')} in all{differing}{again}"


def _count(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"
