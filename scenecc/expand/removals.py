"""What overrides remove: nothing that is left may refer to it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut
from scenecc.expand.arguments import ABSOLUTE_PREFIX
from scenecc.expand.expansion import scoped_name
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.nodes import is_mapping, is_sequence
from scenecc.spec.references import SHARED_NAMESPACE, WORLD, qualified_name

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin, Path, RelatedPlace
    from scenecc.expand.expansion import ExpansionWriter

_OWNERS = (*SHARED_NAMESPACE, "constraints", "lights", "materials")
_LISTED = 10
"""How many of those that refer to something a message lists."""


def check_removals(output: ExpansionWriter, sink: Sink) -> None:
    """Reports each thing that was removed and that something else still refers to."""
    removed = {name: place for (section, name), place in output.removed.items() if section in SHARED_NAMESPACE}
    materials = {name: place for (section, name), place in output.removed.items() if section == "materials"}
    if not removed and not materials:
        return
    search = _ReferenceSearch(output, removed, materials)
    for section in _OWNERS:
        for name, node in output.sections[section].items():
            search.look(section, name, node)
    for (name, place), owners in search.found.items():
        shown = ", ".join(f"`{cut(owner)}`" for owner, _ in owners[:_LISTED])
        more = f" and {len(owners) - _LISTED} more" if len(owners) > _LISTED else ""
        message = f"`{cut(name)}` cannot be removed: {shown}{more} refer{'s' if len(owners) == 1 else ''} to it"
        related: list[RelatedPlace] = [("referred to here", origin, "value") for _, origin in owners[:_LISTED]]
        sink.report("SC245", message, place, hint="remove or override what refers to it too", related=related)


class _ReferenceSearch:
    """Looks for names of what was removed.

    Attributes:
        found: name and place of a removal → who refers to it, and where.
    """

    def __init__(self, output: ExpansionWriter, removed: dict[str, Origin], materials: dict[str, Origin]) -> None:
        self.found: dict[tuple[str, Origin], list[tuple[str, Origin]]] = {}
        self._output = output
        self._removed = removed
        self._materials = materials
        self._left = {name for section in SHARED_NAMESPACE for name in output.sections[section]}

    def look(self, section: str, owner: str, node: Any) -> None:
        """Looks through one named node."""
        if not is_mapping(node):
            return
        scope = self._output.names.scopes.get(qualified_name(section, owner), "")
        pose = node.get("pose")
        names: list[tuple[Path, Any]] = [((key,), node.get(key)) for key in ("mount", "parent", "child")]
        names.append((("pose", "relative_to"), pose.get("relative_to") if is_mapping(pose) else None))
        if is_mapping(place := node.get("place")):
            names += [(("place", key), place.get(key)) for key in ("on", "inside", "above", "facing", "relative_to")]
            names += [(("place", "near", name), name) for name in place.get("near") or ()]
        for path, written in names:
            if isinstance(written, str) and written != WORLD:
                self._take(self._output.names.full_name(written, scope), section, owner, path)
        for path, name in _materials_in(node, ()) if self._materials else ():
            full = name[1:] if name.startswith(ABSOLUTE_PREFIX) else scoped_name(scope, name)
            if full in self._materials:
                self._add(full, self._materials[full], section, owner, path)

    def _take(self, full: str, section: str, owner: str, path: Path) -> None:
        """A name, of which the end may be a link's: the longest is meant that is there, or was."""
        while full and full not in self._left:
            if full in self._removed:
                self._add(full, self._removed[full], section, owner, path)
                return
            full = full.rpartition("/")[0]

    def _add(self, name: str, place: Origin, section: str, owner: str, path: Path) -> None:
        self.found.setdefault((name, place), []).append((owner, self._output.trace(section, owner, path)))


def _materials_in(node: Any, path: Path) -> Iterator[tuple[Path, str]]:
    """The texts that name a material, alternatives of a form too, each with its path."""
    pairs = node.items() if is_mapping(node) else enumerate(node) if is_sequence(node) else ()
    for key, item in pairs:
        if isinstance(key, str) and key.startswith(NOTE_PREFIX):
            continue
        if isinstance(item, str):
            if "material" in {key, *path}:
                yield (*path, key), item
        else:
            yield from _materials_in(item, (*path, key))
