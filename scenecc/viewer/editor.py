"""Writes into the scene file that is open, and takes it back: whole or not at all, and no other file."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.diagnostics import Sink
from scenecc.files import open_regular, replace_all
from scenecc.pipeline import compile_source
from scenecc.source import read_text
from scenecc.source.edits import EditError
from scenecc.viewer.posing import check_written, with_pose

if TYPE_CHECKING:
    from scenecc.geometry.rotations import Pose7
    from scenecc.options import Options
    from scenecc.plan import Entity
    from scenecc.source import Document
    from scenecc.viewer.world import Loaded

_PLACE, _TURN = 2e-4, 1e-3
"""How far from what was asked for a written pose may be: numbers are rounded [m]; components of a quaternion."""


class FileEditor:
    """Edits of a file, the last of which can be taken back."""

    def __init__(self, path: Path | None, *, writes: bool = True) -> None:
        """`path`: of the file; None: what is open is none. `writes`: whether whoever reaches the page may change it."""
        self._writes = writes
        self._name = path
        # What is opened is what is written: a link that leads elsewhere later changes nothing.
        self._path = None if path is None else Path(os.path.realpath(path))
        self._edits: list[tuple[bytes, bytes]] = []

    @property
    def can_undo(self) -> bool:
        """Whether there is an edit that was not taken back."""
        return bool(self._edits)

    def check(self, loaded: Loaded, name: str) -> None:
        """Raises EditError if the pose of an entity cannot be written; the message says why."""
        check_written(name, self._document(loaded).data)

    def write_pose(self, loaded: Loaded, options: Options, entity: Entity, scene: int, pose: Pose7) -> bool:
        """Writes where an entity is to be at the start, and returns whether the file has changed by it.

        Args:
            loaded: the scene that is shown.
            options: with which it was compiled, without values that were given by hand.
            entity: of its plan.
            scene: index of the scene in which the entity was moved.
            pose: p [m] then q (wxyz) in that scene.

        Raises:
            EditError: it cannot be written; the message says why, and the file is as it was.
        """
        document = self._document(loaded)
        check_written(entity.name, document.data)
        before = self._content()
        text, mark = _decoded(before)
        if text != document.text:
            raise EditError("the file has changed since it was shown")
        x, y, z, *q = map(float, entity.pose.row(entity.scene_idxs.index(scene)))
        start = (x, y, z, q[0], q[1], q[2], q[3])
        changed = with_pose(text, document.data, entity.name, start, pose)
        if changed != text:
            self._check_result(changed, loaded, options, entity.name, scene, pose)
            after = mark + changed.encode()
            self._write(after)
            self._edits.append((before, after))
        return changed != text

    def undo(self) -> None:
        """Takes back the last edit, to the byte.

        Raises:
            EditError: the file has changed since, or cannot be written.
        """
        if not self._edits:
            return
        before, after = self._edits[-1]
        if self._content() != after:
            raise EditError("the file has changed since the last move, which is not taken back")
        self._write(before)
        self._edits.pop()

    def _document(self, loaded: Loaded) -> Document:
        if not self._writes:
            raise EditError("anyone who reaches this address could change the file: start with `--token auto`")
        document = loaded.result.document
        if self._path is None or document is None or document.path != self._name or not document.data:
            raise EditError("what is open is no scene file in YAML")
        return document

    def _check_result(self, text: str, loaded: Loaded, options: Options, name: str, scene: int, pose: Pose7) -> None:
        """Compiles a text as if it were the file's: it must have no error, and put the entity where it is wanted."""
        sink = Sink()
        document = read_text(text, str(self._name), sink, options.limits, self._name)
        found = document and compile_source(document, replace(options, params=dict(loaded.given)), sink)
        if not document or not found:
            raise EditError("the file would have an error then")
        if _without_pose(document, name) != _without_pose(self._document(loaded), name):
            raise EditError("something else in the file uses what is written there, and would change with it")
        moved = next((entity for entity in found.plan.entities if entity.name == name), None)
        if moved is None or scene not in moved.scene_idxs:
            raise EditError("the file would not have it then")
        row = np.asarray(moved.pose.row(moved.scene_idxs.index(scene)), np.float64)
        turn = min(np.abs(row[3:] - pose[3:]).max(), np.abs(row[3:] + pose[3:]).max())
        if np.abs(row[:3] - pose[:3]).max() > _PLACE or turn > _TURN:
            raise EditError("something else in the file puts it elsewhere")

    def _content(self) -> bytes:
        assert self._path is not None
        try:
            with open_regular(self._path) as stream:
                return stream.read()
        except OSError as error:
            raise EditError(f"the file cannot be read: {error.strerror}") from error

    def _write(self, content: bytes) -> None:
        assert self._path is not None
        if not os.access(self._path, os.W_OK):  # in a folder that may be written, another file could take its place
            raise EditError("the file may not be written")
        try:
            replace_all({self._path: content})
        except OSError as error:
            raise EditError(f"the file cannot be written: {error.strerror}") from error


def _decoded(content: bytes) -> tuple[str, bytes]:
    """The text of a file in UTF-8, and its byte order mark."""
    mark = b"\xef\xbb\xbf" if content.startswith(b"\xef\xbb\xbf") else b""
    try:
        return content[len(mark) :].decode(), mark
    except UnicodeDecodeError:
        raise EditError("the file is not written in UTF-8") from None


def _without_pose(document: Document, name: str) -> dict[str, Any]:
    """What a document holds beside the pose of an entity."""
    entities = dict(document.data["entities"])
    entities[name] = {key: value for key, value in entities[name].items() if key != "pose"}
    return {**document.data, "entities": entities}
