"""Reads mesh files with libraries, each content once.

Records are cached in memory and in the user's cache folder, by the hashes of the file and its buffers and by the
versions of the libraries. Triangles are read, and cached, on request.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.assets.content_cache import ContentCache
from scenecc.assets.errors import AssetError, AssetReference
from scenecc.assets.measures import Measures
from scenecc.files import keep_result, read_checked, read_result
from scenecc.worker import Worker, WorkerError
from scenecc.worker_process import read_message, write_message

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan.body import AssetFile
    from scenecc.worker_process import Message

MESH_SUFFIXES: Final = (".obj", ".gltf", ".glb", ".stl", ".ply", ".dae")
"""Suffixes of supported formats, in lower case."""

_MEMORY: Final = 4 * 2**30
"""Limit of the reading process's address space [bytes]."""

_SECONDS: Final = 120.0
"""Timeout for one file [s]."""

_READER = Worker("scenecc.assets.mesh_process", memory=_MEMORY, seconds=_SECONDS, name="the mesh reader")


@dataclass(frozen=True, slots=True)
class MeshRecord:
    """Information about a mesh file.

    Attributes:
        key: of the record.
        names: the files that it names.
        visual_faults: reasons why it cannot be rendered, each with code, message and hint.
        parts: measures of each part that has triangles; see `scenecc.assets.mesh_process`.
        whole: measures of all parts together. None: there are no triangles.
        unused: number of vertices without triangles.
        beyond: how far these are outside the bounding box [m].
        vertex_colors: whether a part has colours at its vertices or faces, and no material.
    """

    key: str
    names: tuple[AssetReference, ...]
    visual_faults: tuple[tuple[str, str, str | None], ...]
    parts: tuple[Measures, ...]
    whole: Measures | None
    unused: int
    beyond: float
    vertex_colors: bool


@dataclass(frozen=True, slots=True)
class MeshContent:
    """Access to the content of a mesh file.

    Attributes:
        digest: SHA-256 of the file.
        suffix: its suffix in lower case, one of `MESH_SUFFIXES`.
        read: reads the file.
        max_bytes: limit of an image in it, and a third of the limit of its triangles; infinite if it was checked
            before.
        open_buffer: finds a buffer that the mesh names, and returns its SHA-256 and its reader. Raises AssetError.
    """

    digest: str
    suffix: str
    read: Callable[[], bytes]
    max_bytes: float
    open_buffer: Callable[[AssetReference], tuple[str, Callable[[], bytes]]]


def checked_content(file: AssetFile) -> MeshContent:
    """Returns access to a mesh of a checked plan, without limits. Raises AssetError (SC422) if it has changed."""
    buffers = {one.uri: one for one in file.names}

    def open_buffer(reference: AssetReference) -> tuple[str, Callable[[], bytes]]:
        one = buffers.get(reference.uri)
        if one is None or one.path is None:
            raise AssetError("SC418", f"it names `{reference.uri[:60]}`, which was not checked")
        path, digest = one.path, one.sha256
        return digest, lambda: read_again(path, digest)

    digest = file.sha256 or sha256(read_again(file.path, None)).hexdigest()
    suffix = Path(file.path).suffix.lower()
    return MeshContent(digest, suffix, lambda: read_again(file.path, digest), math.inf, open_buffer)


def read_again(path: Path, digest: str | None) -> bytes:
    """Returns the content of a checked file. Raises AssetError if it has changed."""
    try:
        return read_checked(path, digest)
    except OSError as error:
        raise AssetError("SC422", f"'{path}' changed while the scene was built", "build it again") from error


Header = dict[str, Any]

_RECORDS: Final = ContentCache("meshes", 4, ("trimesh", "pycollada", "pillow"))
"""Increase the version if `names`, `images`, `measures` or `mesh_process` reject or measure something else."""


def read_mesh(content: MeshContent) -> MeshRecord:
    """Returns the record of a mesh file, and reads the file only if its content is new.

    Raises:
        AssetError: the file or a buffer cannot be read.
    """
    key, header = _header(content, [], list)
    names = tuple(AssetReference(*one) for one in header["names"])
    if "parts" not in header:
        buffers = {one.uri: content.open_buffer(one) for one in names if one.kind == "buffer"}
        key, header = _header(content, list(buffers.items()), lambda: [read() for _, read in buffers.values()])
    faults = tuple((code, message, hint) for code, message, hint in header["visual_faults"])
    whole = None if header["whole"] is None else _measures(header["whole"])
    return MeshRecord(
        key, names, faults, tuple(map(_measures, header["parts"])), whole, header["unused"], header["beyond"],
        header["vertex_colors"],
    )  # fmt: skip


def read_triangles(content: MeshContent) -> list[tuple[NDArray[np.float64], NDArray[np.int64]]]:
    """Returns vertices (n, 3) [m] and faces (m, 3) of each part of a mesh file. Raises AssetError."""
    record = read_mesh(content)
    file = _RECORDS.file(f"{record.key}.triangles")
    kept = read_result(file)
    found = None if kept is None else read_message(io.BytesIO(kept))
    if found is None:
        found = _ask_again(content, record, "triangles")
        whole = io.BytesIO()
        write_message(whole, *found)
        keep_result(file, whole.getvalue())
    arrays = iter(found[1])
    return [
        (np.frombuffer(next(arrays)).reshape(-1, 3), np.frombuffer(next(arrays), np.int64).reshape(-1, 3))
        for _ in record.parts
    ]


def read_hulls(content: MeshContent, *, parts: bool) -> tuple[Measures, ...]:
    """Returns measures of a mesh file's convex hull, or of all its convex parts in SAPIEN. Raises AssetError."""
    return _read_measures(content, "hulls" if parts else "hull")


def read_parts(content: MeshContent) -> tuple[Measures, ...]:
    """Returns measures of all convex parts that SAPIEN makes from a mesh file, without volumes. Raises AssetError."""
    return _read_measures(content, "parts")


def _read_measures(content: MeshContent, wanted: str) -> tuple[Measures, ...]:
    record = read_mesh(content)
    key = f"{record.key}.{wanted}"
    if record.whole is None:
        return ()
    header = _RECORDS.find(key)
    if header is None:
        header, _ = _ask_again(content, record, wanted)
        _RECORDS.keep(key, header)
    return tuple(map(_measures, header["hulls"]))


def _ask_again(content: MeshContent, record: MeshRecord, wanted: str) -> Message:
    """Reads the file of a record again."""
    buffers = {one.uri: content.open_buffer(one)[1]() for one in record.names if one.kind == "buffer"}
    return _ask(_request(content, list(buffers), wanted), [content.read(), *buffers.values()])


def _measures(fields: Mapping[str, Any]) -> Measures:
    values: dict[str, Any] = {**fields, "low": tuple(fields["low"]), "high": tuple(fields["high"])}
    return Measures(**values)


def _header(
    content: MeshContent, buffers: list[tuple[str, tuple[str, Callable[[], bytes]]]], read: Callable[[], list[bytes]]
) -> tuple[str, Header]:
    """Returns the key and the header of the record, from memory, from the cache folder or from the file."""
    key = _RECORDS.key(content.digest, content.suffix, [(uri, each) for uri, (each, _) in buffers])
    header = _RECORDS.find(key)
    if header is None or header.get("bytes", 0) > content.max_bytes:
        names = [uri for uri, _ in buffers]
        header, _ = _ask(_request(content, names, "record"), [content.read(), *read()])
        if all(code != "SC607" for code, *_ in header.get("visual_faults", ())):  # another limit may allow it
            _RECORDS.keep(key, header)
    return key, header


def _request(content: MeshContent, buffers: list[str], wanted: str) -> Header:
    return {
        "suffix": content.suffix, "max_bytes": content.max_bytes, "buffers": buffers or None, "wanted": wanted,
    }  # fmt: skip


def _ask(request: Header, parts: list[bytes]) -> Message:
    try:
        header, arrays = _READER.ask(request, parts)
    except WorkerError as error:
        raise AssetError(
            "SC412", f"the mesh cannot be read: {error}", "simplify the mesh, or export it again"
        ) from error
    if "error" in header:
        raise AssetError(*header["error"])
    return header, arrays
