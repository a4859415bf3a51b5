"""What expansion gives: plain data of one scene file, and where each part of it was written."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Origin
from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Path
    from scenecc.expand.documents import SceneDocument
    from scenecc.expand.loops import Loop
    from scenecc.spec.param_types import ParamType


@frozen
class Items:
    """The items of an expanded list that one written item stands for, up to the start of the next."""

    start: int
    index: int
    loop: Loop | None


@frozen
class Mark:
    """The place of a node as written, and the copy of it. Cheap to make: `origin` is asked for where something is told.

    Attributes:
        file, path, parent: as `Origin` has them.
        copies: the loops around, with the number of the copy in each.
    """

    file: str | None
    path: Path
    parent: Origin | None = None
    copies: tuple[tuple[Loop, int], ...] = ()

    @property
    def copy(self) -> str:
        """Which copy it is: "i=1, j=-1"."""
        return ", ".join([loop.text(number) for loop, number in self.copies])

    @property
    def origin(self) -> Origin:
        """The origin as written."""
        return Origin(self.file, self.path, self.copy, self.parent)


@frozen
class Record:
    """Where a named node of the expanded data (`entities.leg_0`) was written.

    Attributes:
        mark: of the node.
        lists: path as written below the node → items, for each list with repeated ones; None where there is none.
        by_scene: path as written below the node → scenes, for each `per_scene` list that was turned into a mapping.
    """

    mark: Mark
    lists: Mapping[Path, tuple[Items, ...]] | None = None
    by_scene: Mapping[Path, tuple[int, ...]] | None = None

    def trace(self, path: Path) -> Origin:
        """The origin as written of what stands at a path below the node."""
        written: list[str | int] = []
        mark = self.mark
        copies = [mark.copy] if mark.copies else []
        for step in path:
            items = self.lists.get(tuple(written)) if self.lists and isinstance(step, int) else None
            if items and isinstance(step, int):
                item = items[bisect_right(items, step, key=_start) - 1]
                written.append(item.index)
                if item.loop is not None:
                    copies.append(item.loop.text(step - item.start))
            elif self.by_scene and (scenes := self.by_scene.get(tuple(written))) is not None:
                # Its `default` is its first item.
                written.append(0 if step == "default" else scenes.index(int(step)))
            else:
                written.append(step)
        return Origin(mark.file, (*mark.path, *written), ", ".join(copies), mark.parent)


def _start(items: Items) -> int:
    return items.start


@dataclass(frozen=True, slots=True)
class Expansion:
    """One scene file that uses no other, as plain data.

    Names. Entities, frames, cameras, constraints and lights have their full names. An instance is also a frame; what is
    inside of it has the instance as its *scope*, and names written inside mean what is inside. So, with
    `S = scopes.get(owner, "")` for the node in which a name is written:

    - `relative_to: NAME`, and likewise what something is mounted on or ties together, is
      `prefixes.get(S, "") + NAME`; `world` and no `relative_to` are the frame `anchors[S]` (the world where S is "");
    - a material `NAME` is `S/NAME` (`NAME` where S is ""), and `/NAME` is `NAME` of the whole expansion;
    - a collision group and a draw read in a template are likewise `S/NAME`.

    Of a material, group or draw `A/B/NAME` the scope is `A/B`, except for the draws in `given`.

    Attributes:
        data: what `scenecc.spec.parse.parse(..., expanded=True)` takes: no `params`, `include`, `repeat`, `if`, `use`;
            where a draw or `scene` is read there is a `scenecc.values.template.Template`. `num_scenes` and `seed` in
            it are those that override the file's, where these are given.
        scopes: entity, frame, camera, constraint or light, as `scenecc.spec.known.known_as` has it → scope, for those
            inside an instance.
        prefixes: scope → what stands before the names of its entities and frames.
        anchors: scope → the frame in which it stands.
        given: draws that stand for what a `with` says → the scope in which the `with` is written.
        wanted: draws that stand for parameters → what the parameter takes.
        selections: the same → scene indices, ascending, where an instance narrows them; `scene_idxs` is then
            left out of the data.
        used_materials: materials that are not to be reported as never used: a `with` names them, they are inside an
            instance, or they may be named under other parameters.
        documents: by the name that origins have.
    """

    data: dict[str, Any]
    scopes: Mapping[str, str]
    prefixes: Mapping[str, str]
    anchors: Mapping[str, str]
    given: Mapping[str, str]
    wanted: Mapping[str, ParamType]
    selections: Mapping[str, tuple[int, ...]]
    used_materials: frozenset[str]
    documents: Mapping[str | None, SceneDocument]
    records: Mapping[tuple[str, str], Record]

    def trace(self, origin: Origin) -> Origin:
        """An origin in the expanded data as it was written: file, path, copy, and the uses that led there."""
        path = origin.path
        record = self.records.get((str(path[0]), str(path[1]))) if len(path) > 1 else None
        return origin if record is None else record.trace(path[2:])

    def reference(self, uri: str, origin: Origin) -> tuple[str, SceneDocument]:
        """A path as the document that wrote it means it, for `scenecc.source.paths.resolve`.

        Args:
            uri: as in the expanded data.
            origin: of the value, in the expanded data.

        Returns:
            The path or uri, and the document whose folder a path is relative to.
        """
        document = self.documents[self.trace(origin).file]
        return document.reference(uri), document
