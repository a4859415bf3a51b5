"""`scenecc mcp`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from scenecc.cli.options import at_least, takes_compile_options
from scenecc.cli.output import Status, print_err
from scenecc.extras import EXTRAS, install_hint

Root = Annotated[
    Path,
    typer.Option(
        "--root",
        metavar="FOLDER",
        exists=True,
        file_okay=False,
        help="Folder of the scene files; files outside are refused.",
        show_default="the current folder",
    ),
]
Timeout = Annotated[
    int, typer.Option("--timeout", metavar="SECONDS", parser=at_least(1), help="Time limit of a tool call.")
]


@partial(takes_compile_options, names=("asset_roots", "allow_outside_assets", "limits"))
def mcp(*, root: Root = Path(), timeout: Timeout = 120, options: dict[str, Any]) -> None:
    """Run the server for agents.

    The client of an agent starts this command and communicates with it by the Model Context Protocol on standard input
    and output; docs/how-to/agents.md describes the setup. Its tools run the commands of the same names, and return
    their JSON.

    \b
    Examples:
      scenecc mcp
      scenecc mcp --root scenes --timeout 300
    """
    if EXTRAS["mcp"].missing:
        print_err(f"scenecc: the server for agents needs the extra `mcp`: {install_hint('mcp')}\n")
        raise typer.Exit(Status.machine)
    from scenecc.mcp.server import serve_agents

    shared = [f"--asset-root={Path(folder).resolve()}" for folder in options["asset_roots"]]
    shared += ["--allow-outside-assets"] if options["allow_outside_assets"] else []
    shared += [f"--limit={name}={value}" for name, value in options["limits"].items()]
    serve_agents(root, tuple(shared), timeout)
