"""Finding the files that a scene, a plan or an asset names, inside what the scene may read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.source.paths import AssetScope, resolve, resolve_named
from scenecc.source.uris import Refusal

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.diagnostics import Origin, Sink
    from scenecc.expand.expansion import Expansion
    from scenecc.lower.tables import FileResolver
    from scenecc.plan import AssetFile

DICT = "<dict>"
"""What a scene is called that no file holds."""


def resolver(scope: AssetScope, sink: Sink, expansion: Expansion | None = None) -> FileResolver:
    """Finds what a scene names.

    Args:
        scope: what may be read.
        sink: takes what is wrong.
        expansion: knows which document a path is written in; None: all is written in the top one.
    """
    from scenecc.plan import AssetFile

    top = scope.root or Path.cwd()

    def find(uri: str, origin: Origin) -> AssetFile | None:
        """The file of a uri as written; None, reported, where it cannot be used."""
        if sink.full:
            return None
        base, by = top, origin.file
        if expansion is not None:
            uri, document = expansion.reference(uri, origin)
            base, by = document.folder, document.name
        found = resolve(uri, base=base, scope=scope)
        if isinstance(found, Refusal):
            sink.report(found.code, found.message, origin, hint=found.hint)
            return None
        scope.memory.note(found, by or DICT)
        return AssetFile(found.uri, found.path)

    return find


def named_resolver(scope: AssetScope) -> Callable[[str, AssetFile], Path | Refusal]:
    """Finds what an asset names: a `checks.assets.ResolveNamed`."""

    def find(reference: str, asset: AssetFile) -> Path | Refusal:
        """The file of a reference inside an asset, or why it cannot be used."""
        found = resolve_named(reference, owner=asset.path, owner_uri=asset.uri, scope=scope)
        if isinstance(found, Refusal):
            return found
        scope.memory.note(found, asset.uri)
        return found.path

    return find
