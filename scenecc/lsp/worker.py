"""The process that compiles the editor's texts: requests on standard input, answers on standard output.

It may take any time: the server can end it, and the editor never waits for it.
"""

from __future__ import annotations

import os
import pickle
import struct
import sys
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics import Origin, Sink
from scenecc.diagnostics.frozen import frozen
from scenecc.interrupt import exit_with_parent
from scenecc.spec.base import NOTE_PREFIX

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.diagnostics import Diagnostic
    from scenecc.diagnostics.diagnostic import Path as KeyPath
    from scenecc.options import Options
    from scenecc.pipeline import CompileResult
    from scenecc.source import Document
    from scenecc.source.paths import PathCache


@frozen
class OpenScene:
    """A scene file, and the editor's texts.

    Attributes:
        path: path of the file.
        texts: texts by file path, including that of `path`.
        options: what the scene may use.
    """

    path: Path
    texts: Mapping[Path, str]
    options: Options

    def __hash__(self) -> int:
        return hash(self.path)


@frozen
class CheckRequest:
    """Requests all findings of a scene that need no engine, and its names: a `CheckAnswer`."""

    scene: OpenScene


@frozen
class Describe:
    """Requests the facts of an entity from `scenecc inspect`: `EntityFacts`, or None if there are none."""

    scene: OpenScene
    entity: str


@frozen
class SourcePlace:
    """A place in a file: a path in a scene file, or a line of any file.

    Attributes:
        file: the file.
        path: path of the node; empty if the line is known.
        line, start, end: 0-based, in characters.
        is_copy: whether several names are generated from this place.
    """

    file: Path
    path: KeyPath = ()
    line: int = 0
    start: int = 0
    end: int | None = None
    is_copy: bool = False


@dataclass(frozen=True, slots=True)
class NamedObject:
    """The object of a name.

    Attributes:
        section: its section.
        place: where it is written; None if in no file.
        links: places of the links, for an articulation.
        joints: named joints of an articulation, each with the place of its link.
    """

    section: str
    place: SourcePlace | None
    links: Mapping[str, SourcePlace | None] = field(default_factory=dict[str, "SourcePlace | None"])
    joints: Mapping[str, SourcePlace | None] = field(default_factory=dict[str, "SourcePlace | None"])


@dataclass(frozen=True, slots=True)
class CheckAnswer:
    """The answer to a `CheckRequest`.

    Attributes:
        diagnostics: diagnostics of `validate`.
        files: paths of the scene files that were read, by their names in diagnostics.
        objects: entities, frames and cameras of the whole scene, by name; None without a plan.
    """

    diagnostics: list[Diagnostic]
    files: Mapping[str, Path]
    objects: Mapping[str, NamedObject] | None


@dataclass(frozen=True, slots=True)
class EntityFacts:
    """The answer to a `Describe`. `facts`: label and words of each fact."""

    kind: str
    facts: list[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Fault:
    """Replaces an answer if a request failed because of a bug in scenecc. `report`: the traceback."""

    report: str


_NO_YAML: Final = "SC003"
"""The code of invalid YAML."""


def answer(request: CheckRequest | Describe) -> CheckAnswer | EntityFacts | None:
    """Answers a request."""
    if isinstance(request, Describe):
        return _all_described(request.scene).get(request.entity)
    sink = Sink()
    document, memory = _read(request.scene, sink)
    if document is None:
        found = sink.diagnostics()
        # Empty or missing parts of an incomplete text may still be typed.
        return CheckAnswer([one for one in found if one.code == _NO_YAML] or found, {}, None)
    return _check_document(document, request.scene.options, memory, sink)


def _read(scene: OpenScene, sink: Sink) -> tuple[Document | None, PathCache]:
    from scenecc.source import read_text  # noqa: PLC0415 - nothing is needed before the first request
    from scenecc.source.paths import PathCache  # noqa: PLC0415

    text, limits = scene.texts[scene.path], scene.options.limits
    return read_text(text, str(scene.path), sink, limits, scene.path), PathCache(scene.texts)


def _check_document(document: Document, options: Options, memory: PathCache, sink: Sink) -> CheckAnswer:
    """`sink`: contains the comments of the document that silence findings."""
    from scenecc.pipeline import compile_source  # noqa: PLC0415

    result = compile_source(document, options, sink, placed=False, memory=memory)
    files = memory.files_by_name(document)
    objects = None if result is None else _Finder(result, files, sink).objects()
    return CheckAnswer(sink.diagnostics(), files, objects)


class _Finder:
    """Finds the objects of a scene's names."""

    def __init__(self, result: CompileResult, files: Mapping[str, Path], sink: Sink) -> None:
        self._result = result
        self._files = files
        self._sink = sink

    def objects(self) -> dict[str, NamedObject]:
        """Returns entities, frames and cameras, by name."""
        plan, found = self._result.plan, dict[str, NamedObject]()
        for name, origin in self._frames():
            found[name] = NamedObject("frames", self._place(origin, name))
        for camera in plan.cameras:
            found[camera.name] = NamedObject("cameras", self._place(camera.origin, camera.name))
        for entity in plan.entities:
            links: dict[str, SourcePlace | None] = {}
            joints: dict[str, SourcePlace | None] = {}
            for structure in entity.structures:
                for link in getattr(structure, "links", ()):
                    links.setdefault(link.name, self._place(link.body.origin, link.name))
                    if link.joint is not None and link.joint.name:
                        joints.setdefault(link.joint.name, links[link.name])
            place = self._place(entity.origin, entity.name)
            found[entity.name] = NamedObject("entities", place, links, joints)
        return found

    def _frames(self) -> Iterator[tuple[str, Origin]]:
        """Yields the frames of the document, because a plan has none."""
        expansion, document = self._result.expansion, self._result.document
        if document is not None:
            data = document.data if expansion is None else expansion.data
            names = (name for name in data.get("frames", {}) if not name.startswith(NOTE_PREFIX))
            yield from ((name, Origin(document.name, ("frames", name))) for name in names)

    def _place(self, origin: Origin | None, name: str) -> SourcePlace | None:
        """`name`: name of the object at the origin."""
        if origin is None:
            return None
        if (place := origin.location) is None:
            traced = self._sink.trace(origin)
            file = self._files.get(traced.file or "")
            is_copy = bool(traced.copy) or traced.path[-1:] != (name.rpartition("/")[2],)
            return None if file is None else SourcePlace(file, traced.path, is_copy=is_copy)
        file = self._files.get(place.file or "")
        if file is None or place.line is None:
            return None
        end = None if place.end_column is None else place.end_column - 1
        return SourcePlace(file, (), place.line - 1, (place.column or 1) - 1, end)


@lru_cache(maxsize=1)
def _all_described(scene: OpenScene) -> Mapping[str, EntityFacts]:
    """Returns the facts of all entities: building one takes as long."""
    from scenecc.errors import SceneError  # noqa: PLC0415
    from scenecc.inspect.inspection import inspect_source  # noqa: PLC0415
    from scenecc.pipeline import CompiledSource  # noqa: PLC0415

    document, memory = _read(scene, Sink())
    if document is None:
        return {}
    compiled = CompiledSource(document, scene.options, memory)
    for build in (True, False):  # without a working engine, only the file's facts
        try:
            found = inspect_source(compiled, entity="*", build=build).item
        except SceneError:
            continue
        items = (item for _, group in found.groups for item in (group if isinstance(group, tuple) else (group,)))
        return {
            item.name: EntityFacts(item.type, [(fact.label, fact.words) for fact in item.facts if fact.words])
            for item in items
        }
    return {}


_LENGTH: Final = struct.Struct(">Q")


def encode_message(message: Any) -> bytes:
    """Encodes a message of any type that can be pickled."""
    data = pickle.dumps(message)
    return _LENGTH.pack(len(data)) + data


HEADER_BYTES: Final = _LENGTH.size


def decode_length(header: bytes) -> int:
    """Returns the number of bytes after a header."""
    return _LENGTH.unpack(header)[0]


def main() -> None:
    """Answers requests until the input ends. The argument is the parent process."""
    exit_with_parent(int(sys.argv[1]))
    requests, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)  # keep the engine's output out of the answers
    while len(header := requests.read(HEADER_BYTES)) == HEADER_BYTES:
        request = pickle.loads(requests.read(decode_length(header)))  # noqa: S301 - from the parent process
        try:
            found: Any = answer(request)
        except Exception:  # noqa: BLE001 - a bug is reported, and the next request is answered
            import traceback  # noqa: PLC0415

            found = Fault(traceback.format_exc())
        answers.write(encode_message(found))
        answers.flush()


if __name__ == "__main__":
    main()
