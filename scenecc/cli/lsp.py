"""`scenecc lsp`."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import typer

from scenecc.cli.options import takes_compile_options
from scenecc.cli.output import Status, print_err
from scenecc.cli.settings import SettingsFinder
from scenecc.extras import EXTRAS, install_hint

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic


@partial(takes_compile_options, names=("asset_roots", "allow_outside_assets", "limits"))
def lsp(*, options: dict[str, Any]) -> None:
    """Run the language server for editors.

    The editor starts this command and communicates with it by the Language Server Protocol on standard input and
    output; docs/how-to/editor.md describes the setup. It shows findings while you type, completes keys, names, links,
    files and parameters, shows units, sizes and masses, finds and renames names, and applies fixes. `[tool.scenecc]` of
    the nearest pyproject.toml applies as in `validate`.

    \b
    Examples:
      scenecc lsp
      scenecc lsp --asset-root ~/assets
    """
    if EXTRAS["lsp"].missing:
        print_err(f"scenecc: the language server needs the extra `lsp`: {install_hint('lsp')}\n")
        raise typer.Exit(Status.machine)
    from scenecc.lsp.features import serve
    from scenecc.options import Options

    serve(Options.of(**options), _select_wanted)


def _select_wanted(diagnostics: list[Diagnostic], scene: str) -> list[Diagnostic]:
    """Filters the findings of a scene by its current settings."""
    finder = SettingsFinder(None, (), strict=False)
    return finder.of(scene).apply(diagnostics, scene)
