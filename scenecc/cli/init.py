"""`scenecc init`."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from importlib.util import find_spec
from typing import Annotated, Final, NoReturn

import typer

from scenecc.cli.completion import one_of
from scenecc.cli.output import Status, end, folder_refusal, print_err, print_out, usage_error, write_files
from scenecc.extras import EXTRAS, ROBOTS_HINT, Extra
from scenecc.starter import OWNER, ROBOTS, TEMPLATES, repository_address, starter_files

_HERE: Final = "."

_TEMPLATES: Final = "; ".join(f"{name}: {template.description}" for name, template in TEMPLATES.items())


def init(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="The folder to write; it must be new or empty.", show_default="the current one"
        ),
    ] = _HERE,
    *,
    template: Annotated[
        str, typer.Option("--template", metavar="NAME", help=f"{_TEMPLATES}.", autocompletion=one_of(TEMPLATES))
    ] = "pick_place",
    robot: Annotated[
        str | None,
        typer.Option(
            "--robot",
            metavar="NAME",
            help=f"One of {', '.join(ROBOTS)}.",
            show_default="the template's",
            autocompletion=one_of(ROBOTS),
        ),
    ] = None,
) -> None:
    """Create a starter folder with a scene, its robot and a test.

    The scene has comments, and an editor completes its keys with the schema beside it. The folder also has a commit
    hook and a GitHub workflow. `panda` needs the package mani_skill, which contains its files.

    \b
    Examples:
      scenecc init demo
      scenecc init demo --template kitchen --robot panda
      scenecc init demo --template locomotion
    """
    if template not in TEMPLATES:
        _refuse("template", template, TEMPLATES)
    chosen = _robot(template, robot)
    address = repository_address()
    files = starter_files(template, chosen, address)
    if (reason := folder_refusal(name, files)) is not None:
        end([usage_error("SC904", reason, file=name)])
    if (fault := write_files(name, files, folder=True)) is not None:
        end([usage_error(*fault, file=name)])
    print_out(_summary(name, list(files), address))


def _robot(template: str, robot: str | None) -> str | None:
    """Returns the robot to write. Ends the command if it is not available."""
    row = TEMPLATES[template]
    if robot is None:
        return row.robots[0] if row.needs_robot else None
    if robot not in ROBOTS:
        _refuse("robot", robot, row.robots)
    if robot not in row.robots:
        _end("robot", f"the template {template} does not support `{robot}`; it supports {' or '.join(row.robots)}")
    if ROBOTS[robot] is not None and find_spec("mani_skill") is None:
        print_err(f"scenecc: `{robot}` is in the package mani_skill, which is not installed: {ROBOTS_HINT}\n")
        raise typer.Exit(Status.machine)
    return robot


def _refuse(option: str, word: str, known: Iterable[str]) -> NoReturn:
    from scenecc.cli.options import quote_text
    from scenecc.diagnostics.messages import suggest

    _end(option, f"there is no {option} {quote_text(word)}; {suggest(word, known)}")


def _end(option: str, message: str) -> NoReturn:
    raise typer.BadParameter(message, param_hint=f"'--{option}'")


def _summary(folder: str, files: Sequence[str], address: str) -> str:
    """Returns what was written, the next commands, and what is to be replaced."""
    see = "scenecc inspect scene.yaml" if EXTRAS["view"].missing else "scenecc view scene.yaml"
    test = "pip install pytest && pytest" if Extra("", ("pytest",)).missing else "pytest"
    enter = [] if folder == _HERE else [f"cd {shlex.quote(folder)}"]
    commands = [*enter, "scenecc check scene.yaml", see, test]
    lines = [f"wrote {', '.join(files)}", "", "next:", *(f"  {command}" for command in commands)]
    if OWNER in address:
        lines += ["", f"in .github/workflows/scenes.yml, replace {OWNER} with the owner of scenecc's repository"]
    return "\n".join(lines) + "\n"
