"""Options that several commands share."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Container, Mapping
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import typer

from scenecc.cli.completion import complete_camera, complete_limit, complete_scene, complete_setting

_INTEGER: Final = re.compile(r"[0-9]{1,18}|[0-9]{1,3}(?:_[0-9]{3}){1,5}")

_SHOWN: Final = 40


Format = Literal["text", "json", "github", "gitlab", "junit", "sarif"]
"""Formats of results and diagnostics, or of diagnostics only."""

Show = Literal["visual", "collision"]


TableFormat = Literal["text", "json"]
"""Formats of results with their diagnostics."""


def at_least(least: int, *, digits: int = 18) -> Callable[[str | int], int]:
    """Returns a parser for an integer option that accepts only ASCII digits, and no more than `digits`."""

    def parse(text: str | int) -> int:
        written = str(text)
        if not (written.isascii() and written.isdecimal() and len(written) <= digits) or int(written) < least:
            raise typer.BadParameter(
                f"{quote_text(written)} must be an integer of at least {least}, with at most {digits} digits"
            )
        return int(written)

    return parse


def quote_text(text: str) -> str:
    """Returns a user's text for a message: quoted, shortened, control characters escaped."""
    from scenecc.diagnostics.formats.style import visible

    return f"'{visible(text[:_SHOWN])}{'…' if len(text) > _SHOWN else ''}'"


def parse_limits(given: list[str] | None) -> dict[str, int]:
    """Parses `["depth=200"]` into a mapping.

    Raises:
        typer.BadParameter: an item is not `name=value`, its name is unknown, or its value is not a positive integer.
    """
    from scenecc.source import make_limits

    limits: dict[str, int] = {}
    for item in given or ():
        name, _, value = (part.strip() for part in item.partition("="))
        if not _INTEGER.fullmatch(value):
            message = f"{quote_text(item)} must be name=integer, as in depth=200"
            raise typer.BadParameter(message, param_hint="'--limit'")
        limits[name] = int(value)
    try:
        make_limits(limits)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="'--limit'") from None
    return limits


def _check_folders(roots: list[Path]) -> None:
    """Raises typer.BadParameter for an asset root that is not a folder."""
    from scenecc.diagnostics.formats.style import visible
    from scenecc.options import folder_fault

    if (fault := folder_fault(roots)) is not None:
        raise typer.BadParameter(visible(fault), param_hint="'--asset-root'")


def _check_starts(file: str) -> None:
    """Raises typer.BadParameter for a file of starts that does not exist."""
    if not Path(file).is_file():
        from scenecc.diagnostics.formats.style import visible

        what = "is not a file" if os.path.lexists(file) else "does not exist"
        raise typer.BadParameter(f"`{visible(file)}` {what}", param_hint="'--starts'")


def parse_params(given: list[str] | None) -> dict[str, Any]:
    """Parses `["size=0.5"]` into a mapping; values are YAML on one line.

    Raises:
        typer.BadParameter: an item is not `name=value` with a YAML value, or a parameter is set twice.
    """
    from scenecc.diagnostics.formats.style import visible

    params: dict[str, Any] = {}
    for item in given or ():
        name, value, fault = _read_setting(item)
        if fault is not None:
            raise typer.BadParameter(f"{quote_text(item)}: {visible(fault)}", param_hint="'--set'")
        if name in params:
            raise typer.BadParameter(f"{quote_text(name)} is set twice", param_hint="'--set'")
        params[name] = value
    return params


def _read_setting(text: str) -> tuple[str, Any, str | None]:
    """Parses `name=value` and returns the name, the value, and what is wrong with the text."""
    from scenecc.diagnostics import Sink
    from scenecc.source import read_value

    name, equals, written = text.partition("=")
    if not equals or not name.strip():
        return name, None, "it must be name=value, as in size=0.5"
    sink = Sink()
    value = read_value(written, sink)
    for found in sink.diagnostics():
        empty = found.code == "SC006"
        fault = found.message + (f" ({found.hint})" if found.hint else "")
        return name, None, 'it has no value (an empty string is "")' if empty else fault
    return name.strip(), value, None


SceneArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCENE",
        help="A scene file, or - for standard input.",
        show_default=False,
        autocompletion=complete_scene,
    ),
]
ScenePaths = Annotated[
    list[str],
    typer.Argument(
        metavar="PATH...",
        help="Scene files, folders of them, or - for standard input.",
        autocompletion=complete_scene,
    ),
]
OutputFile = Annotated[str, typer.Option("--output", "-o", metavar="FILE", help="Output file; - is standard output.")]
NumScenes = Annotated[
    int | None,
    typer.Option("--num-scenes", "-n", metavar="N", parser=at_least(1), help="Number of scenes, overriding the file."),
]
Seed = Annotated[
    int | None,
    typer.Option("--seed", metavar="S", parser=at_least(0, digits=100), help="Seed of all draws, overriding the file."),
]
Steps = Annotated[
    int, typer.Option("--steps", metavar="N", parser=at_least(0), help="Simulate N steps after the build.")
]
Params = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Set a parameter to a value in YAML; may be repeated.",
        autocompletion=complete_setting,
    ),
]
Scenes = Annotated[
    str | None, typer.Option("--scene", metavar="IDXS", help="Only these scenes: 3, or 0:4 or 0,2 or ::2.")
]
Starts = Annotated[
    str | None,
    typer.Option("--starts", metavar="FILE", help="Begin at the starts in this file, from `scenecc settle`."),
]
Camera = Annotated[
    str | None,
    typer.Option(
        "--camera",
        metavar="NAME",
        help="Name of a camera in the file.",
        show_default="frames the scene",
        autocompletion=complete_camera,
    ),
]
AssetRoots = Annotated[
    list[Path] | None,
    typer.Option("--asset-root", metavar="DIR", help="Search folder for asset:// paths; may be repeated."),
]
AllowOutside = Annotated[
    bool, typer.Option("--allow-outside-assets", help="Allow files outside the scene's folder and the asset roots.")
]
Limits = Annotated[
    list[str] | None,
    typer.Option(
        "--limit", metavar="NAME=VALUE", help="Change a limit; may be repeated.", autocompletion=complete_limit
    ),
]
TableFormatOption = Annotated[TableFormat, typer.Option("--format", help="Format of the output.")]
FormatOption = Annotated[
    Format, typer.Option("--format", help="Format of the output; the last four hold only diagnostics.")
]
Timings = Annotated[bool, typer.Option("--timings", help="Print the time of each stage, on standard error.")]

_COMPILE_OPTIONS: Final[dict[str, tuple[Any, Any]]] = {
    "num_scenes": (NumScenes, None),
    "seed": (Seed, None),
    "params": (Params, None),
    "starts": (Starts, None),
    "asset_roots": (AssetRoots, None),
    "allow_outside_assets": (AllowOutside, False),
    "limits": (Limits, None),
}
"""The fields of `CompileOptions` that the command line sets: name → (option, default)."""


def takes_compile_options(
    command: Callable[..., None],
    names: Container[str] = _COMPILE_OPTIONS,
    others: Mapping[str, tuple[Any, Any]] | None = None,
) -> Callable[..., None]:
    """Adds shared options to a command, before its own `--format`. Their values arrive as the keyword `options`.

    Args:
        command: the command.
        names: the compile options that it takes.
        others: further options, in the form of `_COMPILE_OPTIONS`. They arrive as the keyword `others`.
    """
    taken = {name: row for name, row in _COMPILE_OPTIONS.items() if name in names}
    more = others or {}

    @wraps(command)
    def run(*arguments: Any, **given: Any) -> None:
        """Gathers the shared options and calls the command."""
        options = {name: given.pop(name, default) for name, (_, default) in taken.items()}
        options["limits"] = parse_limits(options["limits"])
        if "params" in taken:
            options["params"] = parse_params(options["params"])
        if options.get("starts") is not None:
            _check_starts(options["starts"])
        options["asset_roots"] = options["asset_roots"] or ()
        if options["asset_roots"]:
            _check_folders(options["asset_roots"])
        if more:
            given["others"] = {name: given.pop(name, default) for name, (_, default) in more.items()}
        command(*arguments, options=options, **given)

    # Not `get_type_hints`: before Python 3.11 it turns an option whose default is None into Optional[Annotated[…]].
    own = list(signature(command, eval_str=True).parameters.values())
    last = [each for each in own if each.name == "form"]
    own = [each for each in own if each.name not in {"form", "options", "others"}]
    shared = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=option)
        for name, (option, default) in {**more, **taken}.items()
    ]
    # Typer reads these attributes, not those of the wrapped function.
    vars(run)["__signature__"] = Signature([*own, *shared, *last])
    run.__annotations__ = {each.name: each.annotation for each in (*own, *shared, *last)}
    del vars(run)["__wrapped__"]
    return run
