"""`scenecc build`."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.options import (
    FormatOption,
    SceneArgument,
    Scenes,
    Steps,
    Timings,
    takes_compile_options,
)
from scenecc.cli.output import (
    STDOUT,
    base_folder,
    end,
    print_err,
    print_needs,
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
    timings: Timings = False,
    form: FormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Build a scene as parallel SAPIEN scenes.

    Prints a table of the entities and their scenes. If there are more than 30 entities, copies share a row. The
    scenes are simulated on the CPU; thousands of scenes on a GPU run through scenecc.maniskill.

    \b
    Examples:
      scenecc build scenes/tabletop.yaml --num-scenes 4
      scenecc build scenes/tabletop.yaml --steps 300 --no-render
      scenecc build scenes/tabletop.yaml --dry-run -o plan.json
      scenecc build scenes/parameters.yaml --set size=0.6 --set color="#884422"
    """
    import scenecc

    if dry_run:
        _check_dry_run(steps, {"audit": audit, "render": render})
    if output is not None and Path(output).suffix.lower() not in {"", ".json"}:
        raise typer.BadParameter("the plan is JSON: NAME.json (`scenecc emit` writes other formats)", param_hint="'-o'")
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
    diagnostics, times = list(result.diagnostics), dict(result.timings)
    try:
        if result.batch is not None:
            with result.batch:
                times |= _step(result.batch, steps)
        if output is not None:
            diagnostics += _write_plan(result.plan, output, form)
    except scenecc.SceneError as error:
        end([*diagnostics, *error.diagnostics], form)
    if timings:
        print_err(f"{stage_times(times)}\n")
    text = partial(_summary, result, whole=every)
    end(diagnostics, form, data=partial(_data, result), text=text, beside=output == STDOUT)


def _check_dry_run(steps: int, flags: Mapping[str, bool | None]) -> None:
    """Raises typer.BadParameter for an option that concerns the engine."""
    given = [f"--{'' if on else 'no-'}{flag}" for flag, on in flags.items() if on is not None]
    for option in ["--steps"] * (steps > 0) + given:
        message = "it concerns the engine, which --dry-run does not start"
        raise typer.BadParameter(message, param_hint=f"'{option}'")


def _write_plan(plan: ScenePlan, output: str, form: str) -> list[Diagnostic]:
    """Writes the plan, and beside it the files that it names outside the folder. Returns diagnostics."""
    from scenecc.diagnostics import Sink
    from scenecc.export import emit_text

    made = emit_text(plan, "json", Path(output).stem, Sink(), base=base_folder(output))
    reason = write_files(output, made.files, folder=False)
    if reason is not None:
        return [usage_error(*reason, file=output)]
    if form == "text":
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


def _data(result: Build) -> dict[str, Any]:
    """Returns the summary for programs."""
    scenes = {"num_scenes": result.plan.num_scenes, "scene_idxs": result.scene_idxs}
    rows = list(map(asdict, result.summary))
    return {"name": result.plan.name, **scenes, "built": result.batch is not None, "objects": rows}


def _summary(result: Build, *, whole: bool) -> str:
    show, done = (planned, "planned") if result.batch is None else (built, "built")
    rows = show(result.summary, whole=whole)
    return f"{rows}\n{escape_text(result.plan.name)}: {done} {_totals(result)}\n"


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
