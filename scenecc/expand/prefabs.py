"""Prefabs: finding them, and looking through each once however often it is used."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics import Origin
from scenecc.diagnostics.messages import cut
from scenecc.expand.compiled import CompiledModule, compile_module
from scenecc.expand.contents import find_per_scene_lists
from scenecc.expand.modules import Library, shown_chain

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.expand.documents import SceneDocument
    from scenecc.expand.modules import Module

Chain = tuple["SceneDocument", ...]
"""The documents that use one another, from the top one on."""

_LEFT_OUT = ("physics", "environment", "num_scenes", "seed")
"""What a prefab says for the case that it is compiled by itself."""


class Prefabs:
    """The prefabs of one compilation."""

    def __init__(self, library: Library, sink: Sink) -> None:
        self._library = library
        self._sink = sink
        self._compiled: dict[str, CompiledModule | None] = {}

    def find(self, reference: str, owner: SceneDocument, place: Origin, chain: Chain) -> CompiledModule | None:
        """The prefab that a document uses; None where it was reported.

        Args:
            reference: as written.
            owner: the document.
            place: of the reference.
            chain: the modules that lead to it, its own last.
        """
        document = self._library.find(reference, owner, place)
        if document is None:
            return None
        names = [above.shown for above in (*chain, document)]
        if any(document.identity == above.identity for above in chain):
            message = f"a prefab uses itself: {shown_chain(names)}"
            self._sink.report("SC232", message, place, hint="leave one of these uses out")
            return None
        if self._library.is_too_deep(names, place):
            return None
        if document.identity not in self._compiled:
            module = self._library.module(document, place)
            self._check(module, place)
            self._compiled[document.identity] = compile_module(module, place, self._sink) if module.good else None
        return self._compiled[document.identity]

    def _check(self, module: Module, place: Origin) -> None:
        """Reports what has no meaning in a prefab."""
        for part in module.parts:
            data, parent = part.document.document.data, part.parent(place)
            for key in _LEFT_OUT:
                if key in data:
                    message = f"`{key}` of a prefab is left out: that of the scene counts"
                    self._sink.report("SC241", message, Origin(part.document.name, (key,), "", parent), at="key")
        for section in module.sections.values():
            for name, entry in section.items():
                for path in find_per_scene_lists(entry.node, entry.path) if not _is_param(entry.path) else ():
                    origin = entry.origin(place)
                    message = f"`{cut(name)}` lists its values by scene, and a prefab may be in any of them"
                    hint = "write {per_scene: {0: …, default: …}}, `cycle` or a parameter"
                    self._sink.report("SC242", message, Origin(origin.file, path, "", origin.parent), hint=hint)


def _is_param(path: tuple[str | int, ...]) -> bool:
    return path[:1] == ("params",)
