"""Opens a USD stage whose layers all lie where the scene may read. Nothing else is opened, by usd-core or by us."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut
from scenecc.files import open_regular
from scenecc.source.paths import Refusal, ResolvedFile, resolve_asset_reference, shorten_uri

if TYPE_CHECKING:
    from scenecc.importers.imported_scene import ImportContext
    from scenecc.importers.usd_stage import Prim

_MAGIC: Final = (b"PXR-USDC", b"#usda 1.")

_MAX_LAYERS: Final = 1000

_PARSE_ERROR: Final = re.compile(r":(\d+):(\d+): ([^\n]*)")
"""Line, column and message of what usd-core says about a text that it cannot read."""

_OPENED_LIMIT: Final = 4
"""Layers take at most this many times the size of one asset together."""


class UsdLayers:
    """The layers of a stage, each checked before usd-core opens it.

    Attributes:
        uris: the checked layers, by their resolved path, as `ResolvedFile` has them.
    """

    def __init__(self, context: ImportContext) -> None:
        self.uris: dict[Path, str] = {}
        self._context = context
        self._bytes = 0
        self._sdf: Any = import_module("pxr.Sdf")
        self._tf: Any = import_module("pxr.Tf")

    def open(self, path: Path) -> Prim | None:
        """The composed stage of a file. None after an error, which is reported."""
        if not self._check(path):
            return None
        usd: Any = import_module("pxr.Usd")
        try:
            stage = usd.Stage.Open(str(path.resolve()), usd.Stage.LoadAll)
        except self._tf.ErrorException as error:
            self._report_unreadable(path, error)
            return None
        faults = stage.GetCompositionErrors()
        if faults:
            message = cut(" ".join(str(faults[0]).split()))
            self._context.sink.report("SC430", f"the stage does not compose: {message}", Location(str(path)))
            return None
        # What the layers say was followed above; here it is held against what usd-core has opened.
        for layer in stage.GetUsedLayers():
            if not layer.anonymous and Path(layer.realPath).resolve() not in self.uris:
                message = f"the stage opens `{shorten_uri(layer.identifier)}`, which none of its layers names"
                self._context.sink.report("SC430", message, Location(str(path)))
                return None
        return stage

    def resolve(self, name: str, owner: Path) -> ResolvedFile | Refusal:
        """The file that a layer names, if it may be read. `owner`: the resolved path of the layer."""
        return resolve_asset_reference(name, owner=owner, owner_uri=self.uris[owner], scope=self._context.scope)

    def _check(self, path: Path) -> bool:
        """Whether a layer and all that it names, at any depth and in any variant, may be read."""
        todo: list[tuple[Path, str]] = [(path.resolve(), path.name)]
        ok = True
        while todo:
            file, uri = todo.pop()
            if file in self.uris:
                continue
            self.uris[file] = uri
            layer = self._open_layer(file)
            if layer is None:
                return False
            for name in sorted({*layer.GetCompositionAssetDependencies(), *layer.GetExternalAssetDependencies()}):
                found = self.resolve(name, file) if name else None
                if isinstance(found, ResolvedFile):
                    todo.append((found.path.resolve(), found.uri))
                elif found is not None:
                    ok = False
                    place = Location(str(file), _line_of(file, name))
                    self._context.sink.report(found.code, found.message, place, hint=found.hint)
        return ok

    def _open_layer(self, file: Path) -> Any | None:
        sink, limit = self._context.sink, self._context.limits.asset_bytes
        place = Location(str(file))
        try:
            with open_regular(file) as stream:
                head = stream.read(8)
            size = file.stat().st_size
        except OSError as error:
            sink.report("SC430", f"the file cannot be read: {error.strerror or error}", place)
            return None
        self._bytes += size
        if head not in _MAGIC:
            sink.report("SC430", "the file is not what its name says: it is neither text nor crate of USD", place)
        elif size > limit or self._bytes > _OPENED_LIMIT * limit:
            message = f"the file has {size} bytes; the limit `asset_bytes` is {limit}"
            sink.report("SC430", message, place, hint="raise the limit with --limit asset_bytes=N")
        elif len(self.uris) > _MAX_LAYERS:
            sink.report("SC430", f"the stage has over {_MAX_LAYERS} layers", place)
        else:
            try:
                layer = self._sdf.Layer.FindOrOpen(str(file))
            except self._tf.ErrorException as error:
                self._report_unreadable(file, error)
                return None
            if layer is not None:
                return layer
            sink.report("SC430", "usd-core cannot read the file", place)
        return None

    def _report_unreadable(self, file: Path, error: Exception) -> None:
        found = _PARSE_ERROR.search(str(error))
        line, column, message = (
            (int(found[1]), int(found[2]), found[3].rstrip("'")) if found else (None, None, str(error).split("'")[-2])
        )
        self._context.sink.report(
            "SC430", f"usd-core cannot read the file: {message}", Location(str(file), line, column)
        )


def _line_of(file: Path, name: str) -> int | None:
    """The first line of a layer in text form that names an asset."""
    text = file.read_bytes()
    at = text.find(f"@{name}@".encode()) if text.startswith(b"#usda") else -1
    return None if at < 0 else text.count(b"\n", 0, at) + 1
