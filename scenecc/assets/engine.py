"""Opens untrusted meshes with SAPIEN in a worker process first, because some broken files crash it.

Files of installed packages and asset roots are trusted.
"""

from __future__ import annotations

import os
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Final

from scenecc.assets.content_cache import ContentCache
from scenecc.assets.errors import AssetError
from scenecc.assets.meshes import read_again
from scenecc.files import PACKS, cache_folder, state_now
from scenecc.worker import Worker, WorkerError

if TYPE_CHECKING:
    from scenecc.assets.mesh_uses import MeshUse
    from scenecc.plan.body import AssetFile

_MEMORY: Final = 12 * 2**30
"""Limit of the process's address space, most of which SAPIEN's libraries need [bytes]."""

_SECONDS: Final = 60.0
"""Timeout for one mesh [s]."""

_TRUSTED: Final = ("pkg://", "asset://", "mesh://")

_READER = Worker(
    "scenecc.assets.engine_process", memory=_MEMORY, seconds=_SECONDS, name="SAPIEN's reader", opens_files=True
)

_READ: Final = ContentCache("engine", 1, ("sapien",))
"""Meshes that SAPIEN could read."""


def engine_fault(file: AssetFile, use: MeshUse) -> str | None:
    """Returns why SAPIEN cannot read a mesh for a use, or None if it can or the file is trusted.

    Successful reads are cached in the user's cache folder, by content and SAPIEN's version.
    """
    if _is_trusted(file):
        return None
    try:
        digest = file.sha256 or sha256(read_again(file.path, None)).hexdigest()
    except AssetError as fault:
        return fault.message
    key = _READ.key(digest, [(one.uri, one.sha256) for one in file.names], use, file.path.suffix)
    if _READ.find(key):
        return None
    try:
        header, _ = _READER.ask({"path": str(file.path), "use": use}, [])
    except WorkerError as error:
        return str(error)
    if "error" in header:
        return str(header["error"])
    if _is_unchanged(file):
        _READ.keep(key, "read")
    return None


def _is_trusted(file: AssetFile) -> bool:
    """Returns whether a file is in an installed package or an asset root. A pack has its own packages and roots."""
    if not file.uri.startswith(_TRUSTED):
        return False
    packs = os.path.realpath(cache_folder(PACKS))
    return not Path(os.path.realpath(file.path)).is_relative_to(packs)


def _is_unchanged(file: AssetFile) -> bool:
    """Returns whether SAPIEN has read the checked content. The build reports changed files."""
    return all(one.path is None or one.state is None or state_now(one.path) == one.state for one in (file, *file.names))
