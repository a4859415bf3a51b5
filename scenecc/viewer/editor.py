"""Edits of the open scene file, with undo: completely or not at all, and never another file."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.diagnostics import Sink
from scenecc.files import open_regular, replace_unchanged
from scenecc.pipeline import compile_source
from scenecc.source import read_text
from scenecc.source.edits import EditError
from scenecc.source.text import encoded_as
from scenecc.viewer.posing import check_written, with_pose

if TYPE_CHECKING:
    from scenecc.geometry.rotations import Pose7
    from scenecc.options import Options
    from scenecc.plan import Entity
    from scenecc.source import Document
    from scenecc.viewer.world import Loaded

_PLACE, _TURN = 2e-4, 1e-3
"""Maximum error of a written pose due to rounding: [m], and quaternion components."""


class FileEditor:
    """Edits of a file. The last one can be undone."""

    def __init__(self, path: Path | None, *, writes: bool = True) -> None:
        """`path`: the file; None if the source is not a file. `writes`: whether users of the page may change it."""
        self._writes = writes
        self._name = path
        # Resolve links now: a link that is changed later has no effect.
        self._path = None if path is None else Path(os.path.realpath(path))
        self._edits: list[tuple[bytes, bytes]] = []

    @property
    def can_undo(self) -> bool:
        """Whether there is an edit to undo."""
        return bool(self._edits)

    def check(self, loaded: Loaded, name: str) -> None:
        """Raises EditError if the pose of an entity cannot be written; the message gives the reason."""
        check_written(name, self._document(loaded).data)

    def write_pose(self, loaded: Loaded, options: Options, entity: Entity, scene: int, pose: Pose7) -> bool:
        """Writes the initial pose of an entity, and returns whether the file has changed.

        Args:
            loaded: the displayed scene.
            options: its compile options, without values set on the page.
            entity: entity of its plan.
            scene: index of the scene in which the entity was moved.
            pose: p [m] then q (wxyz) in that scene.

        Raises:
            EditError: it cannot be written; the message gives the reason, and the file is unchanged.
        """
        document = self._document(loaded)
        check_written(entity.name, document.data)
        before = self._content()
        text = document.text or ""
        if encoded_as(before, text) != before:
            raise EditError("the file has changed since it was loaded")
        x, y, z, *q = map(float, entity.pose.row(entity.scene_idxs.index(scene)))
        start = (x, y, z, q[0], q[1], q[2], q[3])
        changed = with_pose(text, document.data, entity.name, start, pose)
        if changed != text:
            self._check_result(changed, loaded, options, entity.name, scene, pose)
            after = encoded_as(before, changed)
            self._replace(before, after)
            self._edits.append((before, after))
        return changed != text

    def undo(self) -> None:
        """Undoes the last edit, byte for byte.

        Raises:
            EditError: the file has changed since, or cannot be written.
        """
        if not self._edits:
            return
        before, after = self._edits[-1]
        self._replace(after, before)
        self._edits.pop()

    def _document(self, loaded: Loaded) -> Document:
        if not self._writes:
            raise EditError("anyone who can reach this address could change the file: start with `--token auto`")
        document = loaded.result.document
        if self._path is None or document is None or document.path != self._name or not document.data:
            raise EditError("the open source is not a YAML scene file")
        return document

    def _check_result(self, text: str, loaded: Loaded, options: Options, name: str, scene: int, pose: Pose7) -> None:
        """Compiles a text in place of the file: it must have no error, and give the entity the wanted pose."""
        sink = Sink()
        document = read_text(text, str(self._name), sink, options.limits, self._name)
        found = document and compile_source(document, replace(options, params=dict(loaded.given)), sink)
        if not document or not found:
            raise EditError("the file would have an error")
        if _without_pose(document, name) != _without_pose(self._document(loaded), name):
            raise EditError("something else in the file uses this pose, and would change with it")
        moved = next((entity for entity in found.plan.entities if entity.name == name), None)
        if moved is None or scene not in moved.scene_idxs:
            raise EditError("it would be missing in the file")
        row = np.asarray(moved.pose.row(moved.scene_idxs.index(scene)), np.float64)
        turn = min(np.abs(row[3:] - pose[3:]).max(), np.abs(row[3:] + pose[3:]).max())
        if np.abs(row[:3] - pose[:3]).max() > _PLACE or turn > _TURN:
            raise EditError("something else in the file changes its pose")

    def _content(self) -> bytes:
        assert self._path is not None
        try:
            with open_regular(self._path) as stream:
                return stream.read()
        except OSError as error:
            raise EditError(f"the file cannot be read: {error.strerror}") from error

    def _replace(self, before: bytes, after: bytes) -> None:
        assert self._path is not None
        try:
            replace_unchanged(self._path, before, after)
        except OSError as error:
            raise EditError(f"the file cannot be written: {error.strerror}") from error


def _without_pose(document: Document, name: str) -> dict[str, Any]:
    """Returns a document's data without the pose of an entity."""
    entities = dict(document.data["entities"])
    entities[name] = {key: value for key, value in entities[name].items() if key != "pose"}
    return {**document.data, "entities": entities}
