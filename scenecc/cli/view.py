"""`scenecc view`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from scenecc.cli.options import (
    SceneArgument,
    Show,
    at_least,
    quote_text,
    takes_compile_options,
)
from scenecc.cli.output import (
    STDOUT,
    Status,
    end,
    of_settings,
    outlive_pipes,
    print_above,
    print_asides,
    print_err,
    print_note,
    print_out,
    progress,
    scene_errors,
    status,
    usage_error,
    write_output,
)
from scenecc.cli.paths import checked_source
from scenecc.cli.tables import escape_text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from scenecc import PageAddress
    from scenecc.diagnostics import Diagnostic

Scene = Annotated[int, typer.Option("--scene", metavar="K", parser=at_least(0), help="Scene to show first.")]
Grid = Annotated[bool, typer.Option("--grid", help="Show all scenes side by side.")]
Shadows = Annotated[bool, typer.Option("--shadows/--no-shadows", help="Draw shadows; slow in a browser without a GPU.")]
Lights = Annotated[bool, typer.Option("--lights", help="Light the scene with the lights of the file.")]
Output = Annotated[
    str | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE.html",
        help="Write a self-contained page instead of serving one; - is standard output.",
    ),
]
Steps = Annotated[int, typer.Option("--steps", metavar="N", parser=at_least(0), help="Steps to record (with -o).")]
Host = Annotated[
    str | None,
    typer.Option(
        "--host",
        metavar="ADDRESS",
        help="Address to listen on. 0.0.0.0 lets other machines connect, with a token.",
        show_default="127.0.0.1",
    ),
]
Port = Annotated[
    int | None,
    typer.Option(
        "--port",
        metavar="N",
        parser=at_least(0, digits=5),
        help="Port; 0 selects any free port.",
        show_default="8080, or the next free port",
    ),
]
Token = Annotated[
    str | None,
    typer.Option(
        "--token",
        metavar="TOKEN",
        help="Require this token in the address; auto generates one.",
        show_default="auto if other machines can connect",
    ),
]
NoToken = Annotated[bool, typer.Option("--no-token", help="Let anyone who can connect control the scene.")]
Open = Annotated[bool, typer.Option("--open", help="Open the page in the browser.")]


@takes_compile_options
def view(
    scene: SceneArgument,
    *,
    index: Scene = 0,
    grid: Grid = False,
    show: Annotated[Show, typer.Option("--show", help="Shapes to show first.")] = "visual",
    lights: Lights = False,
    shadows: Shadows = True,
    output: Output = None,
    steps: Steps = 0,
    host: Host = None,
    port: Port = None,
    token: Token = None,
    no_token: NoToken = False,
    open_it: Open = False,
    options: dict[str, Any],
) -> None:
    """Show a scene in the browser, live while you edit it.

    The page reloads the scene whenever one of its files changes. It shows the objects with their masses and materials,
    the simulation, and the parameters of the file. If the file has an error, the page shows it above the last valid
    scene. No GPU is needed. Press Ctrl-C to stop.

    \b
    Examples:
      scenecc view scenes/tabletop.yaml
      scenecc view scenes/clutter.yaml --num-scenes 16 --grid --port 0
      scenecc view scenes/tabletop.yaml -o tabletop.html --steps 200
    """
    import scenecc

    _check(output, steps, served=open_it or no_token or any(given is not None for given in (host, port, token)))
    source = checked_source(scene, output)
    visual, collision = show == "visual", show == "collision"
    shown = scenecc.ViewOptions(index, grid, visual, collision, lights=lights, shadows=shadows)
    with scene_errors(options):
        outlive_pipes()  # a browser may disconnect, and the processes that write a page end in any order
        if output is None:
            address = _address(host, port, token, no_token=no_token)
            with progress("build", clock=False) as told:
                scenecc.view_scene(
                    source,
                    options=shown,
                    address=address,
                    on_ready=lambda url: _ready(url, address, open_it=open_it),
                    on_diagnostics=_teller(scene, options["params"]),
                    on_progress=_counter(told),
                    **options,
                )
        else:
            with progress("view") as told:
                page = scenecc.open_scene(source, **options).page(options=shown, steps=steps, progress=told)
            _write(output, page.html, page.diagnostics)


def _check(output: str | None, steps: int, *, served: bool) -> None:
    """Raises typer.BadParameter if options do not fit together."""
    if output is None and steps:
        raise typer.BadParameter("it needs -o FILE.html; a served page has a button for it", param_hint="'--steps'")
    if output is not None and served:
        message = "it cannot be combined with --open, --host, --port, --token or --no-token, because no page is served"
        raise typer.BadParameter(message, param_hint="'-o'")
    if output not in {None, STDOUT} and not str(output).lower().endswith((".html", ".htm")):
        raise typer.BadParameter(f"{quote_text(str(output))} must end in .html", param_hint="'-o'")


def _address(host: str | None, port: int | None, token: str | None, *, no_token: bool) -> PageAddress:
    """Returns the page's address. Raises typer.BadParameter for an invalid option."""
    from secrets import token_urlsafe

    import scenecc

    if no_token and token is not None:
        raise typer.BadParameter("it cannot be combined with --token", param_hint="'--no-token'")
    given = {"host": host, "port": port, "token": token_urlsafe() if token == "auto" else token}  # noqa: S105
    chosen: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    if no_token:
        chosen["token"] = None
    name = ""
    try:
        for name, value in chosen.items():
            scenecc.PageAddress(**{name: value})
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint=f"'--{name}'") from None
    return scenecc.PageAddress(**chosen)


def _teller(scene: str, values: Mapping[str, Any]) -> Callable[[Sequence[Diagnostic]], None]:
    """Returns a function that prints findings, and reports when the last error is gone."""
    failed = False

    def tell(found: Sequence[Diagnostic]) -> None:
        nonlocal failed
        print_asides(of_settings(found, values))
        if failed and status(found) is Status.fine:
            print_note(f"{escape_text(scene)}: no errors\n")
        failed = status(found) is not Status.fine

    return tell


def _counter(show: Callable[[int, int], None] | None) -> Callable[[int, int], None] | None:
    """Returns a function that counts scenes on the terminal, if it is one, and leaves a line at the end."""

    def count(done: int, total: int) -> None:
        if done < total and show is not None:
            show(done, total)
        elif total > 1:
            print_above(f"{total} scenes built")

    return None if show is None else count


def _ready(url: str, address: PageAddress, *, open_it: bool) -> None:
    if address.token is None and not address.is_local:
        print_err("WARNING: anyone who can reach this address can view and control the scene\n")
    print_note("Press Ctrl-C to stop.\n")
    print_out(f"{url}\n")
    if open_it:
        import webbrowser

        webbrowser.open(url)


def _write(target: str, page: str, found: list[Diagnostic]) -> NoReturn:
    if (reason := write_output(target, page)) is not None:
        end([*found, usage_error(*reason, file=target)])
    if target != STDOUT:
        print_out(f"{escape_text(target)}: {len(page.encode()) / 1e6:.2f} MB\n")
    end(found)
