"""The command `scenecc`: the table of its commands, and how the process ends."""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
from collections.abc import Callable
from typing import Annotated, Any, Final

import typer

from scenecc.cli.build import build
from scenecc.cli.diff import diff
from scenecc.cli.emit import emit
from scenecc.cli.explain import explain
from scenecc.cli.inspect import inspect
from scenecc.cli.output import Status, print_err
from scenecc.cli.params import params
from scenecc.cli.prefabs import prefabs
from scenecc.cli.render import render
from scenecc.cli.schema import schema
from scenecc.cli.validate import validate
from scenecc.cli.view import view

COMMANDS: Final[tuple[Callable[..., Any], ...]] = (
    build,
    validate,
    inspect,
    render,
    view,
    emit,
    diff,
    params,
    prefabs,
    schema,
    explain,
)
"""Every command, as `scenecc --help` lists them. A function's name is the command's."""

_EPILOG = "Exit status: 0 fine, 1 the scene is at fault, 2 wrong usage, 3 the engine or the machine is at fault."


def main() -> None:
    """Runs the command line of this process. Raises SystemExit at its end: 0, 1, 2 or 3."""
    # Plugins that observe pydantic's models have none of an application here, and finding them takes its time.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # A closed pipe (`scenecc validate . | head`) ends this process as it ends any other.
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    # Started without them (`>&-`), there is nobody to tell, and that is no fault.
    sys.stdout = sys.stdout or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123 - the process's own
    sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A name that the terminal cannot show is shown escaped.
            stream.reconfigure(errors="backslashreplace")
    try:
        _application()(prog_name="scenecc")
    except MemoryError:
        sys.exit(_fault("out of memory"))
    except Exception as error:  # noqa: BLE001 - the process's edge: its status must not blame the scene
        import traceback

        from scenecc.diagnostics.formats.style import visible

        if isinstance(error, OSError) and error.errno == errno.ENOSPC:  # of the standard output, for a help text
            sys.exit(_fault(os.strerror(errno.ENOSPC)))

        # What went wrong may quote a scene.
        for line in traceback.format_exc().splitlines():
            print_err(f"{visible(line)}\n")
        sys.exit(_fault("this is a fault of scenecc, not of your scene"))


def _application() -> typer.Typer:
    # Plain help: nothing to import, and the same wherever it is read.
    app = typer.Typer(no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False)
    app.callback(epilog=_EPILOG)(_scenecc)
    for function in COMMANDS:
        app.command(function.__name__)(function)
    return app


def _print_version(on: bool) -> None:
    if on:
        from scenecc.version import VERSION

        typer.echo(f"scenecc {VERSION}")
        raise typer.Exit


def _scenecc(
    *,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
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
