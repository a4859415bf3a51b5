"""A session of `scenecc view` without a browser: what a server shows is asked of the server."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import viser

from scenecc import ViewOptions
from scenecc.diagnostics import Diagnostic
from scenecc.options import Options
from scenecc.viewer.session import Session

SCENE = """\
scenecc: 1
num_scenes: 2
params:
  size: {default: 0.1, min: 0.05, max: 0.5}
entities:
  ball: {pose: {p: [0, 0, {uniform: [1, 2]}]}, shapes: [{type: sphere, radius: "${size}"}]}
"""
MORE = "  more: {pose: [1, 0, 0.5], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}\n"
BALL = "/scene 0/ball"


class Shown:
    """A session, and what its page shows. `params`: given at its start."""

    def __init__(
        self,
        server: viser.ViserServer,
        path: Path,
        look: ViewOptions | None = None,
        params: dict[str, Any] | None = None,
    ) -> None:
        self.server, self.path = server, path
        self.told: list[list[str]] = []
        options = Options.of(params=params)
        self.session = Session(server, lambda: str(path), options, look or ViewOptions(), path=path, report=self._hear)

    def _hear(self, diagnostics: Any) -> None:
        found: list[Diagnostic] = list(diagnostics)
        self.told.append([one.code for one in found])

    def node(self, path: str) -> Any:
        return self.server.scene.get_handle_by_name(path)

    def texts(self) -> str:
        """All texts of the panels."""
        panel = self.session._panel
        return "\n".join(each.content for each in (panel._fault, panel._findings, panel._time)) + panel.selected.text
