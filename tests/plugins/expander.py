"""Expanding texts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.expand.documents import scene_loader
from scenecc.expand.expand import expand
from scenecc.expand.expansion import Expansion
from scenecc.named_files import mesh_measurer
from scenecc.source import make_limits, read_file
from scenecc.source.paths import AssetScope


class Expander:
    """Writes files into a folder and expands `scene.yaml`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.sink = Sink()

    def __call__(
        self,
        text: str,
        files: Mapping[str, str] | None = None,
        *,
        params: Mapping[str, Any] | None = None,
        num_scenes: int | None = None,
        draws: tuple[str, ...] = (),
        limits: Mapping[str, int] | None = None,
    ) -> Expansion | None:
        for name, content in {**(files or {}), "scene.yaml": text}.items():
            file = self.folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(content if content.startswith("scenecc: 1") else "scenecc: 1\n" + content)
        self.sink = Sink()
        bounds = make_limits(limits)
        document = read_file(self.folder / "scene.yaml", self.sink, bounds)
        assert document is not None, self.sink.diagnostics()
        return expand(
            document,
            params=params or {},
            num_scenes=num_scenes,
            seed=None,
            draws=draws,
            load=scene_loader(AssetScope(self.folder), bounds, self.sink),
            measure=mesh_measurer(AssetScope(self.folder), bounds, self.sink),
            limits=bounds,
            sink=self.sink,
        )

    def data(self, text: str, files: Mapping[str, str] | None = None, **options: Any) -> dict[str, Any]:
        """The data; nothing may be reported."""
        expansion = self(text, files, **options)
        assert not self.found, "\n".join(map(str, self.found))
        assert expansion is not None
        return expansion.data

    def good(self, text: str, files: Mapping[str, str] | None = None, **options: Any) -> Expansion:
        """The expansion; no error may be reported."""
        expansion = self(text, files, **options)
        assert expansion is not None, "\n".join(map(str, self.found))
        return expansion

    def codes(self, text: str, files: Mapping[str, str] | None = None, **options: Any) -> list[tuple[str, int, int]]:
        """The codes that are found, with line and column."""
        self(text, files, **options)
        return [(found.code, found.line or 0, found.column or 0) for found in self.found]

    def one(self, text: str, files: Mapping[str, str] | None = None, **options: Any) -> Diagnostic:
        """The one finding."""
        assert self(text, files, **options) is None
        assert len(self.found) == 1, "\n".join(map(str, self.found))
        return self.found[0]

    @property
    def found(self) -> list[Diagnostic]:
        return self.sink.diagnostics()
