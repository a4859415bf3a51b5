"""Options that several commands take. What they mean is the API's business."""

from __future__ import annotations

import re
from enum import Enum
from pathlib import Path
from typing import Annotated, Final

import typer

_INTEGER: Final = re.compile(r"[0-9][0-9_]{0,18}")


class Format(str, Enum):
    """How diagnostics are printed."""

    text = "text"
    json = "json"
    github = "github"
    sarif = "sarif"


def parse_limits(given: list[str] | None) -> dict[str, int]:
    """`["depth=200"]` as a mapping.

    Raises:
        typer.BadParameter: for what is not `name=value`, an unknown name, or a value that is no positive integer.
    """
    from scenecc import api

    limits: dict[str, int] = {}
    for item in given or ():
        name, _, value = (part.strip() for part in item.partition("="))
        if not _INTEGER.fullmatch(value):
            message = f"'{item}' is not name=integer, as in depth=200"
            raise typer.BadParameter(message, param_hint="'--limit'")
        limits[name] = int(value)
    try:
        api.check_limits(limits)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="'--limit'") from None
    return limits


SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="A scene file, or - for standard input.", show_default=False)
]
NumScenes = Annotated[
    int | None, typer.Option("--num-scenes", metavar="N", min=1, help="How many scenes, in place of the file's.")
]
Seed = Annotated[
    int | None, typer.Option("--seed", min=0, metavar="S", help="Seed of every draw, in place of the file's.")
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
FormatOption = Annotated[Format, typer.Option("--format", help="How diagnostics are printed.")]
