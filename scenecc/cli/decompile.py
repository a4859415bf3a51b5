"""`scenecc decompile`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scenecc.cli.options import OutputFile, at_least
from scenecc.cli.output import STDOUT, Status, base_folder, end, print_err, refusal, usage_error, write_output

if TYPE_CHECKING:
    from scenecc.decompiler.decompile import Decompiled

_SHOWN = 20


def decompile(
    task: Annotated[str, typer.Argument(metavar="TASK", help="A task of ManiSkill, such as PickCube-v1.")],
    *,
    output: OutputFile = STDOUT,
    seed: Annotated[int, typer.Option("--seed", metavar="N", parser=at_least(0), help="Seed of the task's reset.")] = 0,
    num_envs: Annotated[
        int,
        typer.Option(
            "--num-envs", metavar="N", parser=at_least(1), help="Number of parallel scenes; each uses the next seed."
        ),
    ] = 1,
    check: Annotated[
        bool, typer.Option("--check/--no-check", help="Build the file and compare it with the task's scene.")
    ] = True,
) -> None:
    """Write the scene of a ManiSkill task as a scene file.

    The command builds and resets the task, and writes its live scene to a file: bodies, robots as their URDF with
    the task's changes, lights and cameras. It then builds the file, and prints all differences from the task's scene.
    The task runs its own code. The extra `maniskill` and a render device are needed. With `--num-envs`, the file has
    parallel scenes: environments reset with the seeds N, N + 1, and so on.

    Exit status: 0 equal, 1 different or not everything can be expressed in a scene file, 2 wrong usage, 3 the task
    cannot be built here.

    \b
    Examples:
      scenecc decompile PickCube-v1 -o pick.yaml
      scenecc decompile PegInsertionSide-v1 --seed 3 --num-envs 4
    """
    if (reason := refusal(output)) is not None:
        end([usage_error("SC904", reason, file=output)])
    # Output of the task must not get into the file.
    shown, sys.stdout = sys.stdout, sys.stderr
    try:
        from scenecc.maniskill.tasks import TaskFailure, decompile_task
    except ImportError as error:
        print_err(f"scenecc: {error}\n")
        raise typer.Exit(Status.machine) from None
    try:
        found = decompile_task(task, base=base_folder(output) or Path.cwd(), seed=seed, num_envs=num_envs, check=check)
    except TaskFailure as failure:
        print_err(f"scenecc: {failure}\n")
        raise typer.Exit(Status.machine) from None
    finally:
        sys.stdout = shown
    if (unwritten := write_output(output, found.text)) is not None:
        end([usage_error(*unwritten, file=output)])
    print_err(_summary(found))
    unequal = bool(found.problems or found.differences)
    raise typer.Exit(Status.scene if unequal else Status.fine)


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
