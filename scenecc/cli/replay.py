"""`scenecc replay`."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.completion import complete_scene
from scenecc.cli.options import FormatOption, quote_text, takes_compile_options
from scenecc.cli.output import (
    STDOUT,
    end,
    outlive_pipes,
    print_asides,
    print_note,
    print_out,
    progress,
    refusal,
    scene_errors,
    usage_error,
    write_output,
)
from scenecc.cli.paths import STDIN, source_of
from scenecc.cli.tables import escape_text

if TYPE_CHECKING:
    from scenecc.passports import PassportContent
    from scenecc.pipeline import CompiledSource

Passport = Annotated[
    str,
    typer.Argument(
        metavar="PASSPORT",
        help="File with a passport, the passport itself, or - for standard input.",
        show_default=False,
    ),
]
File = Annotated[
    str | None,
    typer.Option(
        "--file",
        metavar="SCENE",
        help="The scene file.",
        show_default="the path in the passport",
        autocompletion=complete_scene,
    ),
]
AnyVersion = Annotated[
    bool, typer.Option("--any-version", help="Accept versions that differ from the passport, with a warning.")
]
Output = Annotated[
    str | None,
    typer.Option("--output", "-o", metavar="FILE.png", help="Write a picture of the scene; - is standard output."),
]
View = Annotated[bool, typer.Option("--view", help="Show the scene in the browser.")]


def replay(
    passport: Passport,
    *,
    file: File = None,
    any_version: AnyVersion = False,
    output: Output = None,
    view: View = False,
    form: FormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Rebuild one scene from its passport, bit for bit.

    A passport is the line of JSON that `batch.passport(k)` returns. The command compares files, parameters, versions
    and the initial state with it. Every difference is an error that gives both values.

    \b
    Examples:
      scenecc replay passport.json
      scenecc replay passport.json --file scenes/clutter.yaml --view
      scenecc replay - -o start.png < passport.json
    """
    from scenecc.passports import build_replay, open_passport

    if output is not None and (reason := refusal(output)) is not None:
        end([usage_error("SC904", reason, file=output)], form)
    if output not in {None, STDOUT} and not str(output).lower().endswith(".png"):
        raise typer.BadParameter(f"{quote_text(str(output))} must end in .png", param_hint="'-o'")
    is_text = passport.lstrip()[:1] == "{"
    if not is_text and passport != STDIN and not os.path.lexists(passport):
        end([usage_error("SC901", f"there is no file `{passport}`", file=passport)], form)
    source = source_of(file) if file is not None else None
    with scene_errors(options, form), progress("replay"):
        text = passport if is_text else source_of(passport)
        known, compiled = open_passport(text, file=source, any_version=any_version, **options)
        build_replay(known, compiled, render=False).close()
    found = compiled.sink.diagnostics()
    with scene_errors(options, form):
        if output is not None:
            found += _picture(known, compiled, output)
    said = f"scene {known.scene} of {known.num_scenes}: the initial state equals the passport's, bit for bit"
    if view:
        (print_note if form == "json" or output == STDOUT else print_out)(f"{said}\n")
        print_asides(found)
        with scene_errors(options, form):
            _serve(known, compiled)
    picture = f"{escape_text(output)}: scene {known.scene}\n" if output is not None and output != STDOUT else ""
    end(
        found,
        form,
        data=lambda: {"scene": known.scene, "num_scenes": known.num_scenes, "seed": known.seed, "picture": output},
        text=lambda: f"{said}\n{picture}",
        beside=output == STDOUT,
    )


def _picture(known: PassportContent, compiled: CompiledSource, target: str) -> list[Any]:
    """Writes a picture. Returns diagnostics."""
    import scenecc

    made = scenecc.render_scene(compiled, scenes=str(known.scene))
    reason = write_output(target, made.png())
    return [] if reason is None else [usage_error(*reason, file=target)]


def _serve(known: PassportContent, compiled: CompiledSource) -> None:
    import scenecc

    outlive_pipes()  # a browser may go away
    print_note("Press Ctrl-C to stop.\n")
    shown = scenecc.ViewOptions(scene=known.scene)
    scenecc.view_scene(compiled, options=shown, on_ready=lambda url: print_out(f"{url}\n"))


replay = takes_compile_options(replay, {"starts", "asset_roots", "allow_outside_assets", "limits"})
