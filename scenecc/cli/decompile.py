"""`scenecc decompile`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scenecc.cli.options import OutputFile, TableFormatOption, at_least
from scenecc.cli.output import STDOUT, Status, base_folder, end, refusal, usage_error, write_output
from scenecc.diagnostics import Diagnostic

if TYPE_CHECKING:
    from scenecc.decompiler.decompile import Decompiled

_SHOWN = 20


def decompile(
    task: Annotated[str, typer.Argument(metavar="TASK", help="A task of ManiSkill, such as PickCube-v1.")],
    *,
    output: OutputFile = STDOUT,
    seed: Annotated[int, typer.Option("--seed", metavar="N", parser=at_least(0), help="Seed of the task's reset.")] = 0,
    num_scenes: Annotated[
        int,
        typer.Option(
            "--num-scenes",
            "-n",
            metavar="N",
            parser=at_least(1),
            help="Number of parallel scenes; each uses the next seed.",
        ),
    ] = 1,
    check: Annotated[
        bool, typer.Option("--check/--no-check", help="Build the file and compare it with the task's scene.")
    ] = True,
    form: TableFormatOption = "text",
) -> None:
    """Write the scene of a ManiSkill task as a scene file.

    The command builds and resets the task, and writes its live scene to a file: bodies, robots as their URDF with
    the task's changes, lights and cameras. It then builds the file, and prints all differences from the task's scene.
    The task runs its own code. The extra `maniskill` and a render device are needed. With `--num-scenes`, the file has
    parallel scenes: environments reset with the seeds N, N + 1, and so on.

    Exit status: 0 equal, 1 different or not everything can be expressed in a scene file, 2 wrong usage, 3 the task
    cannot be built here.

    \b
    Examples:
      scenecc decompile PickCube-v1 -o pick.yaml
      scenecc decompile PegInsertionSide-v1 --seed 3 --num-scenes 4
    """
    if form == "json" and output == STDOUT:
        raise typer.BadParameter("with --format json, the scene is written to a file: -o FILE", param_hint="'-o'")
    if (reason := refusal(output)) is not None:
        end([usage_error("SC904", reason, file=output)], form)
    # Output of the task must not get into the file.
    shown, sys.stdout = sys.stdout, sys.stderr
    base = base_folder(output) or Path.cwd()
    try:
        found = _decompile(task, base, seed, num_scenes, check=check)
    finally:
        sys.stdout = shown
    if isinstance(found, Diagnostic):
        end([found], form)
    if (unwritten := write_output(output, found.text)) is not None:
        end([usage_error(*unwritten, file=output)], form)
    unequal = bool(found.problems or found.differences)
    end(
        [],
        form,
        data=lambda: {"file": output, "problems": found.problems, "differences": found.differences},
        text=lambda: _summary(found),
        beside=True,
        least=Status.scene if unequal else Status.fine,
    )


def _decompile(task: str, base: Path, seed: int, num_scenes: int, *, check: bool) -> Decompiled | Diagnostic:
    """Returns the scene of a task, or why the task cannot be built here."""
    try:
        from scenecc.maniskill.tasks import TaskFailure, decompile_task
    except ImportError as error:
        return usage_error("SC805", str(error))
    try:
        return decompile_task(task, base=base, seed=seed, num_envs=num_scenes, check=check)
    except TaskFailure as failure:
        message, _, hint = str(failure).partition("\n")
        return usage_error("SC805", message, hint=hint or None)


def _summary(found: Decompiled) -> str:
    lines = [f"not in the file: {problem}" for problem in found.problems]
    if found.differences is not None:
        lines += [f"different: {line}" for line in found.differences[:_SHOWN]]
        more = len(found.differences) - _SHOWN
        lines += [f"and {more} more"] if more > 0 else []
    count = len(found.text.splitlines())
    equal = (
        ""
        if found.differences is None
        else ", equal to the live scene"
        if found.is_equal
        else ", different from the live scene"
    )
    return "\n".join([*lines, f"{count} lines{equal}"]) + "\n"
