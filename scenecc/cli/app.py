"""The command `scenecc`: the table of its commands, and how the process exits."""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
from importlib import import_module
from keyword import iskeyword
from typing import Annotated, Final

import typer

from scenecc.cli.command import HELP_NAMES, Command, with_quiet
from scenecc.cli.completion import command_words
from scenecc.cli.output import Status, print_err

COMMANDS: Final = (
    "init",
    "build",
    "validate",
    "check",
    "sweep",
    "settle",
    "cover",
    "inspect",
    "describe",
    "patch",
    "draws",
    "coverage",
    "render",
    "view",
    "replay",
    "emit",
    "import",
    "decompile",
    "diff",
    "pack",
    "params",
    "prefabs",
    "schema",
    "explain",
    "lsp",
    "mcp",
    "doctor",
)
"""All commands in the order of `scenecc --help`. Each is a function in the module of the same name."""

_EPILOG = "Exit status: 0 success, 1 error in the scene, 2 wrong usage, 3 error of the engine or the machine."


def main() -> None:
    """Runs the command line of this process. Always raises SystemExit, with status 0, 1, 2 or 3."""
    # Searching all installed packages for Pydantic plugins takes time, and none is needed here.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # A closed pipe (`scenecc validate . | head`) ends this process, as is usual.
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    # If the process is started without these streams (`>&-`), its output is dropped.
    sys.stdout = sys.stdout or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123 - the process's own
    sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # Characters that the terminal cannot show are escaped.
            stream.reconfigure(errors="backslashreplace")
    try:
        application()(prog_name="scenecc")
    except MemoryError:
        sys.exit(_fault("out of memory"))
    except Exception as error:  # noqa: BLE001 - the process's edge: its status must not blame the scene
        import traceback

        from scenecc.diagnostics.formats.style import visible

        if isinstance(error, OSError) and error.errno == errno.ENOSPC:  # from standard output, for a help text
            sys.exit(_fault(os.strerror(errno.ENOSPC)))

        # The traceback may quote a scene.
        for line in traceback.format_exc().splitlines():
            print_err(f"{visible(line)}\n")
        sys.exit(_fault("this is a bug in scenecc, not an error in your scene"))


def application() -> typer.Typer:
    """Returns the app with all commands, or with only the command in this process's arguments."""
    # Plain help needs no imports and looks the same everywhere.
    app = typer.Typer(
        no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False, context_settings=HELP_NAMES
    )
    app.callback(epilog=_EPILOG)(_scenecc)
    # Load only the command that is run, or whose arguments a shell completes.
    completed = command_words()
    asked = completed[1:2] if "_SCENECC_COMPLETE" in os.environ and len(completed) > 2 else sys.argv[1:2]
    for name in asked if asked and asked[0] in COMMANDS else COMMANDS:
        # `import` is a Python keyword, so its module and function end in `_`.
        named = f"{name}_" if iskeyword(name) else name
        command = getattr(import_module(f"scenecc.cli.{named}"), named)
        app.command(name, cls=Command)(with_quiet(command))
    return app


def _print_version(on: bool) -> None:
    if on:
        from scenecc.version import VERSION

        typer.echo(f"scenecc {VERSION}")
        raise typer.Exit


def _scenecc(
    *,
    version: Annotated[
        bool, typer.Option("--version", "-V", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Check scene files for robot simulation and build them as parallel SAPIEN scenes.

    \b
    Examples:
      scenecc validate scenes
      scenecc build scenes/tabletop.yaml --num-scenes 4
      scenecc explain SC101
    """
    del version


def _fault(message: str) -> Status:
    print_err(f"scenecc: {message}\n")
    return Status.machine
