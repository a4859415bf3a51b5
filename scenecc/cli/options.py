"""Options that several commands take. What they mean is the API's business."""

from __future__ import annotations

import re
from collections.abc import Callable
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, Final

import typer

_INTEGER: Final = re.compile(r"[0-9]{1,18}|[0-9]{1,3}(?:_[0-9]{3}){1,5}")

_SHOWN: Final = 40


class Format(str, Enum):
    """How diagnostics are printed."""

    text = "text"
    json = "json"
    github = "github"
    sarif = "sarif"


class Show(str, Enum):
    """Which shapes of bodies are drawn."""

    visual = "visual"
    collision = "collision"


class TableFormat(str, Enum):
    """How a table is printed."""

    text = "text"
    json = "json"


def at_least(least: int, *, digits: int = 18) -> Callable[[str | int], int]:
    """What reads an option's integer: ASCII digits, and no more of them than what follows can count with."""

    def parse(text: str | int) -> int:
        written = str(text)
        if not (written.isascii() and written.isdecimal() and len(written) <= digits) or int(written) < least:
            raise typer.BadParameter(f"{shown(written)} is not an integer from {least} on, of at most {digits} digits")
        return int(written)

    return parse


def shown(text: str) -> str:
    """What somebody wrote, in quotes, in short and harmless."""
    from scenecc.diagnostics.render.terminal import visible

    return f"'{visible(text[:_SHOWN])}{'…' if len(text) > _SHOWN else ''}'"


def parse_limits(given: list[str] | None) -> dict[str, int]:
    """`["depth=200"]` as a mapping.

    Raises:
        typer.BadParameter: for what is not `name=value`, an unknown name, or a value that is no positive integer.
    """
    from scenecc import questions

    limits: dict[str, int] = {}
    for item in given or ():
        name, _, value = (part.strip() for part in item.partition("="))
        if not _INTEGER.fullmatch(value):
            message = f"{shown(item)} is not name=integer, as in depth=200"
            raise typer.BadParameter(message, param_hint="'--limit'")
        limits[name] = int(value)
    try:
        questions.check_limits(limits)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="'--limit'") from None
    return limits


def parse_params(given: list[str] | None) -> dict[str, Any]:
    """`["size=0.5"]` as a mapping.

    Raises:
        typer.BadParameter: for what is not `name=value` with a YAML value, or names a parameter twice.
    """
    from scenecc import questions
    from scenecc.diagnostics.render.terminal import visible

    params: dict[str, Any] = {}
    for item in given or ():
        try:
            name, value = questions.read_setting(item)
        except ValueError as error:
            message = f"{shown(item)}: {visible(str(error))}"
            raise typer.BadParameter(message, param_hint="'--set'") from None
        if name in params:
            raise typer.BadParameter(f"{shown(name)} is set twice", param_hint="'--set'")
        params[name] = value
    return params


SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="A scene file, or - for standard input.", show_default=False)
]
NumScenes = Annotated[
    int | None,
    typer.Option("--num-scenes", metavar="N", parser=at_least(1), help="How many scenes, in place of the file's."),
]
Seed = Annotated[
    int | None,
    typer.Option(
        "--seed", metavar="S", parser=at_least(0, digits=100), help="Seed of every draw, in place of the file's."
    ),
]
Steps = Annotated[
    int, typer.Option("--steps", metavar="N", parser=at_least(0), help="Simulate N steps once it is built.")
]
Params = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Give a parameter a value, in YAML; may be given several times."),
]
AssetRoots = Annotated[
    list[Path] | None,
    typer.Option("--asset-root", metavar="DIR", help="Where asset:// looks; may be given several times."),
]
AllowOutside = Annotated[
    bool, typer.Option("--allow-outside-assets", help="Let files lie outside the scene's folder and the asset roots.")
]
Limits = Annotated[
    list[str] | None, typer.Option("--limit", metavar="NAME=VALUE", help="Raise a limit; may be given several times.")
]
TableFormatOption = Annotated[TableFormat, typer.Option("--format", help="How the result is printed.")]
FormatOption = Annotated[Format, typer.Option("--format", help="How diagnostics are printed.")]
