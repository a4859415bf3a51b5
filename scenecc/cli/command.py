"""The class of all commands: how their usage, options and errors are shown."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import wraps
from inspect import Parameter, signature
from typing import Annotated, Any, Final

import typer
from typer.core import TyperCommand

_TYPE: Final = re.compile(r" <[^>]*>$")
"""The Python type that Typer prints after the name of an argument."""

_DEFAULT: Final = re.compile(r"\[default: \((.*)\)(?=\]|;)")
"""A default in words, which Typer prints in parentheses."""

_CHOICES: Final = re.compile(r"(?:Value error, )?'(.*)' is not one of ((?:'[^']*'(?:, )?)+)\.?")

HELP_NAMES: Final = {"help_option_names": ["-h", "--help"]}
"""Settings of the application, which its commands inherit."""

_Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Print only results and diagnostics: no counts, times or progress.")
]


class Command(TyperCommand):
    """A command with its arguments as in manual pages: `SCENE` required, `[NAME]` optional, `SCENE...` one or more."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Returns the words of the usage line after the name of the command."""
        arguments = [param for param in self.get_params(ctx) if param.param_type_name == "argument"]
        return ["[OPTIONS]", *(str(one.metavar) if one.required else f"[{one.metavar}]" for one in arguments)]

    def help_rows(self, ctx: Any, kind: str) -> list[tuple[str, str]]:
        """Returns names and meanings of its arguments or options. `kind`: "argument" or "option"."""
        params = [param for param in self.get_params(ctx) if param.param_type_name == kind]
        records = [record for param in params if (record := param.get_help_record(ctx)) is not None]
        shown = _TYPE if kind == "argument" else re.compile("$^")
        return [(shown.sub("", name), _DEFAULT.sub(r"[default: \1", meaning)) for name, meaning in records]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Writes the sections of its arguments and options."""
        for title, kind in (("Arguments", "argument"), ("Options", "option")):
            if rows := self.help_rows(ctx, kind):
                with formatter.section(title):
                    formatter.write_dl(rows)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parses the command line. An error about a value names the nearest possible one."""
        try:
            return super().parse_args(ctx, args)
        except typer.BadParameter as error:
            error.message = _with_nearest(error.message)
            raise


def _with_nearest(message: str) -> str:
    from scenecc.diagnostics.messages import nearest

    found = _CHOICES.fullmatch(message)
    if found is None:
        return message
    near = nearest(found[1], re.findall("'([^']*)'", found[2]))
    return f"'{found[1]}' is not one of {found[2]}" + (f"; did you mean '{near}'?" if near else "")


def with_quiet(command: Callable[..., None]) -> Callable[..., None]:
    """Adds the option `--quiet` to a command."""
    from scenecc.cli import output

    @wraps(command)
    def run(*arguments: Any, quiet: bool, **given: Any) -> None:
        """Sets the option and calls the command."""
        output.set_quiet(quiet)
        command(*arguments, **given)

    own = signature(command, eval_str=True)
    option = Parameter("quiet", Parameter.KEYWORD_ONLY, default=False, annotation=_Quiet)
    vars(run)["__signature__"] = own.replace(parameters=[*own.parameters.values(), option])
    run.__annotations__ = {each.name: each.annotation for each in (*own.parameters.values(), option)}
    del vars(run)["__wrapped__"]
    return run
