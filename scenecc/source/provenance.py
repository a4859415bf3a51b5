"""The sources of live scenes: file, hashes and parameters."""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenecc.files import ChangedError, open_regular, state_now
from scenecc.source.paths import AssetScope, name_of_file

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.source.document import Document


def hash_document(document: Document) -> str:
    """Returns the SHA-256 of a source: of its text without a byte order mark, or of a dict as JSON with sorted keys."""
    import json  # noqa: PLC0415 - few commands hash what they read
    from hashlib import sha256  # noqa: PLC0415

    text = document.text
    if text is None:
        text = json.dumps(document.data, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def hash_files(scope: AssetScope) -> dict[str, str]:
    """Returns the SHA-256 of every file that a compilation used besides its source, by name, sorted.

    A name is `pkg://PACKAGE/PATH`, else the path relative to the folder of the top scene file, else `asset://PATH`. A
    file outside these folders has a relative path with `..`.

    Raises:
        ChangedError: a file has changed since the scene was compiled.
        OSError: a file cannot be read.
    """
    found: dict[str, str] = {}
    for path, reference in scope.memory.named.items():
        found[name_of_file(path, scope)] = hash_file(path)
        if state_now(path) != reference.state:
            raise ChangedError(errno.ESTALE, "it changed since the scene was compiled", str(path))
    return dict(sorted(found.items()))


def hash_file(path: str | os.PathLike[str]) -> str:
    """Returns the SHA-256 of a regular file. Raises OSError if it cannot be read."""
    from hashlib import sha256  # noqa: PLC0415 - few commands hash what they read

    digest = sha256()
    with open_regular(path) as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def content_hash(path: str | os.PathLike[str]) -> str | None:
    """Returns the SHA-256 of a regular file; None if it cannot be read."""
    try:
        return hash_file(path)
    except OSError:
        return None


@dataclass(frozen=True)
class Provenance:
    """The sources of live scenes.

    Attributes:
        file: from `portable_path`; None for a dict or a stream.
        document: the source.
        scope: records what was read.
        params: given parameter values, as plain data.
        defaults: defaults of the other parameters, as written.
        draws: given values of shared draws: name → one row per scene.
    """

    file: str | None
    document: Document
    scope: AssetScope = field(repr=False)
    params: Mapping[str, Any]
    defaults: Mapping[str, Any]
    draws: Mapping[str, Any]

    @cached_property
    def source_hash(self) -> str:
        """SHA-256 of the source itself, see `hash_document`."""
        return hash_document(self.document)

    @cached_property
    def file_hashes(self) -> dict[str, str]:
        """SHA-256 of all other files. Errors as in `hash_files`."""
        return hash_files(self.scope)


def portable_path(path: str | os.PathLike[str]) -> str:
    """Returns a path relative to the current folder, with `/`; only the name for a file outside this folder."""
    here, there = Path.cwd(), Path(os.path.abspath(path))  # noqa: PTH100 - `..` removed, links kept
    return there.relative_to(here).as_posix() if there.is_relative_to(here) else there.name
