"""Reads and hashes the files of a plan and of its assets. Unchanged files are not read again."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Final
from urllib.parse import unquote

import numpy as np

from scenecc.assets.content_cache import ContentCache
from scenecc.assets.errors import AssetError, AssetReference
from scenecc.assets.images import ImageSize, check_image
from scenecc.assets.meshes import (
    MESH_SUFFIXES,
    MeshContent,
    MeshRecord,
    read_hulls,
    read_mesh,
    read_parts,
    read_triangles,
)
from scenecc.files import open_regular, state_of
from scenecc.geometry.rotations import MAX_COORDINATE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.assets.measures import Measures
    from scenecc.files import State
    from scenecc.plan.body import AssetFile

ResolveNamed = Callable[[str, "AssetFile"], "Path | tuple[str, str, str | None]"]
"""Finds a file that an asset names. Returns its path, or why it may not be read (code, message, hint)."""

_USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")

_MOST_HASHED = 16_384

_digests: dict[tuple[Path, State], str] = {}
"""SHA-256 of the files that this process has read, by path and state."""


_MOST_NAME_BYTES = 1000
"""Largest length of a file name in a mesh. SAPIEN truncates one at 1023 bytes, and would open another file."""

_IMAGES: Final = ContentCache("images", 3, ("pillow",))
"""Sizes of valid images. Increase its version if `check_image` rejects something else."""


class MissingError(AssetError):
    """A file does not exist."""


@dataclass(frozen=True, slots=True)
class AssetFiles:
    """The files of one compilation.

    Attributes:
        resolve_named: finds the files that an asset names, within what the scene may read.
        max_bytes: the limit `asset_bytes`, for a file and its decompressed content.
        opened: hash and state of each requested file, by its path.
        last_content: of the file that was read last, because a new mesh is read for several measures.
    """

    resolve_named: ResolveNamed
    max_bytes: int
    opened: dict[Path, tuple[str, State]] = field(default_factory=dict[Path, "tuple[str, State]"])
    last_content: dict[Path, bytes] = field(default_factory=dict[Path, bytes])

    def digest(self, path: Path) -> str:
        """Returns the SHA-256 of a file. Raises AssetError."""
        if path not in self.opened:
            _check_encoding(path)
            try:
                state = state_of(os.stat(path))  # noqa: PTH116 - a link as what it leads to
            except OSError as error:
                raise AssetError("SC407", f"{path.name} may not be read: {error.strerror}") from error
            if (path, state) in _digests and state[2] <= self.max_bytes:
                self.opened[path] = _digests[path, state], state
            else:
                self.content(path)
        return self.opened[path][0]

    def content(self, path: Path) -> bytes:
        """Returns the content of a file. Raises AssetError."""
        if path in self.last_content:
            return self.last_content[path]
        try:
            with open_regular(path) as file:
                state = state_of(os.fstat(file.fileno()))
                data = file.read(self.max_bytes + 1) if state[2] <= self.max_bytes else b""
        except OSError as error:
            raise AssetError("SC407", f"{path.name} may not be read: {error.strerror}") from error
        if max(state[2], len(data)) > self.max_bytes:
            raise AssetError(
                "SC607",
                f"{path.name} has {state[2]} bytes, but the limit asset_bytes is {self.max_bytes}",
                f"make it smaller, or raise the limit with --limit asset_bytes={state[2]}",
            )
        if len(_digests) >= _MOST_HASHED:
            del _digests[next(iter(_digests))]
        _digests[path, state] = digest = sha256(data).hexdigest()
        self.opened[path] = digest, state
        self.last_content.clear()
        self.last_content[path] = data
        return data

    def image(self, path: Path) -> ImageSize:
        """Returns the size of an image, and checks its content if it is new. Raises AssetError."""
        key = _IMAGES.key(self.digest(path), path.suffix)
        kept = _IMAGES.find(key)
        size = None if kept is None else ImageSize(**kept)
        if size is None or size.unpacked > self.max_bytes:
            size = check_image(self.content(path), self.max_bytes, path.suffix)
            _IMAGES.keep(key, asdict(size))
        return size

    def resolve(self, asset: AssetFile, reference: AssetReference) -> Path:
        """Returns the path of a file that an asset names.

        Raises:
            AssetError: the file cannot be used; `MissingError`: it does not exist.
        """
        by_mtl = reference.kind == "image" and asset.path.suffix.lower() == ".obj"
        it = "its MTL" if by_mtl else "it"
        if len(reference.uri.encode(errors="surrogatepass")) > _MOST_NAME_BYTES:
            raise AssetError("SC419", f"{it} names a file with more than {_MOST_NAME_BYTES} bytes", "rename the file")
        if "\ufffd" in reference.uri:
            message = f"{it} names `{reference.uri[:60]}`, which is not in UTF-8"
            raise AssetError("SC419", message, f"save {'the MTL' if by_mtl else 'the mesh'} in UTF-8")
        found = self.resolve_named(unquote(reference.uri) if reference.escaped else reference.uri, asset)
        if not isinstance(found, Path) and found[0] in {"SC402", "SC403"}:
            raise AssetError("SC419", f"{it} names a file that cannot be used: {found[1]}", found[2])
        if reference.escaped:
            raise AssetError(
                "SC418",
                f"{it} names `{reference.uri[:60]}`, but SAPIEN does not decode percent escapes",
                "rename the file so that its name needs none, and export the asset again",
            )
        if not isinstance(found, Path):
            fault = MissingError if found[0] == "SC401" else AssetError
            raise fault("SC418", f"{it} names a file that cannot be used: {found[1]}", found[2])
        return found

    def mesh(self, asset: AssetFile) -> MeshRecord:
        """Returns the record of a mesh. Raises AssetError."""
        return read_mesh(self._mesh_content(asset))

    def triangles(self, asset: AssetFile) -> list[tuple[NDArray[np.float64], NDArray[np.int64]]]:
        """Returns vertices (n, 3) [m] and faces (m, 3) of each part of a mesh. Raises AssetError."""
        check_measures(self.mesh(asset))
        return read_triangles(self._mesh_content(asset))

    def hull_parts(self, asset: AssetFile) -> tuple[Measures, ...]:
        """Returns measures of the convex parts that SAPIEN makes from a mesh. Raises AssetError."""
        return read_parts(self._mesh_content(asset))

    def hull_volume(self, asset: AssetFile, *, parts: bool) -> float:
        """Returns the volume of a mesh's convex hull, or of all its convex parts [m³]. Raises AssetError."""
        return sum(hull.hull_volume or 0.0 for hull in read_hulls(self._mesh_content(asset), parts=parts))

    def box_volume(self, asset: AssetFile) -> float:
        """Returns the volume of a mesh's bounding box [m³]. Raises AssetError."""
        whole = check_measures(self.mesh(asset))
        return math.prod(high - low for low, high in zip(whole.low, whole.high, strict=True))

    def _mesh_content(self, asset: AssetFile) -> MeshContent:
        suffix = Path(asset.path).suffix.lower()
        if suffix in _USD_SUFFIXES:
            what = "SAPIEN converts USD and writes the result next to the file"
            raise AssetError("SC411", what, "convert it to GLB and use that")
        if suffix not in MESH_SUFFIXES:
            kind = f"`{suffix}` is not a supported mesh format" if suffix else "a file without a suffix is not a mesh"
            raise AssetError("SC410", f"{kind}", f"convert it to one of {', '.join(MESH_SUFFIXES)}")

        def open_buffer(reference: AssetReference) -> tuple[str, Callable[[], bytes]]:
            path = self.resolve(asset, reference)
            return self.digest(path), lambda: self.content(path)

        return MeshContent(
            self.digest(asset.path), suffix, lambda: self.content(asset.path), self.max_bytes, open_buffer
        )


def _check_encoding(path: Path) -> None:
    try:
        str(path).encode()
    except UnicodeEncodeError as error:
        message = f"the path of {path.name} is not in UTF-8, so SAPIEN cannot open it"
        raise AssetError("SC403", message, "rename its folders and the file") from error


def check_measures(mesh: MeshRecord) -> Measures:
    """Returns the measures of a mesh. Raises AssetError if it has no triangles, or vertices out of range."""
    if mesh.whole is None:
        raise AssetError("SC413", "the mesh has no triangles", "export it with its faces")
    with np.errstate(over="ignore"):
        reach = float(np.float32(mesh.whole.reach))
    if not np.isfinite(reach):
        raise AssetError("SC414", "the mesh has coordinates that are not finite", "export it again")
    if reach > MAX_COORDINATE:
        raise AssetError(
            "SC417",
            f"the mesh reaches {reach:.3g} m from its origin; the limit is {MAX_COORDINATE:.0e} m",
            "export it in metres, about its own centre",
        )
    return mesh.whole
