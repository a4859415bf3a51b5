"""Paths of assets in an imported scene: relative, `pkg://`, `asset://`, or copied beside the scene."""

from __future__ import annotations

import errno
import os
import re
import sys
from collections.abc import Callable, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, Final, cast

from scenecc.diagnostics.messages import cut
from scenecc.expand.documents import SHIPPED_PREFIX
from scenecc.files import open_regular
from scenecc.importers.imported_scene import Asset
from scenecc.importers.mjcf_paths import with_relative_paths
from scenecc.source.paths import AssetScope, check_scheme, check_uri, has_package

IMPORTED_FROM: Final = "Imported from"
"""First words of a written file."""

_HEAD: Final = f"# {IMPORTED_FROM} ".encode()


def assets_of(output: Path) -> Path:
    """Returns the folder for the assets of a scene file."""
    return output.with_name(f"{output.stem}_assets")


def output_fault(output: Path) -> str | None:
    """Returns why a scene file of this name could not refer to its assets; None if it can."""
    name = assets_of(output).name if output.name else ""
    refusal = check_uri(name) or check_scheme(f"{name}/", ())
    if refusal is not None:
        return refusal.message
    if name.startswith(SHIPPED_PREFIX):
        return f"names that begin with `{SHIPPED_PREFIX}` are reserved for scenecc's own prefabs"
    return f"`${{` in `{cut(name)}` would be an expression" if "${" in name else None


def check_output_files(output: Path, files: Mapping[str, bytes]) -> list[Path]:
    """Checks that all files to overwrite are from an earlier import. Returns prefabs of that import to remove.

    Args:
        output: the scene file, which may exist.
        files: content to write, by path from its folder.

    Raises:
        OSError: the folder of assets is not a folder or belongs to another scene, or one of its files is not from an
            import.
    """
    folder = assets_of(output)
    if len(files) > 1 and folder.exists() and not folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(folder))
    mark = f"{folder.name}/".encode()
    others = [output.with_suffix(suffix) for suffix in (".yaml", ".yml") if suffix != output.suffix]
    other = next((each for each in others if each.is_file() and mark in each.read_bytes()), None)
    if other is not None and len(files) > 1:
        raise FileExistsError(errno.EEXIST, f"it belongs to `{other.name}`", str(folder))
    before = output.read_bytes() if output.is_file() else b""
    if not before.startswith(_HEAD):
        beside = {output.parent / name: data for name, data in files.items() if name != output.name}
        changed = next((path for path, data in beside.items() if path.is_file() and path.read_bytes() != data), None)
        if changed is not None:
            raise FileExistsError(
                errno.EEXIST, "it exists, and is not from an earlier import of this scene", str(changed)
            )
    elif other is None:
        made = [path for path in folder.glob("*.yaml") if f"{folder.name}/{path.name}" not in files]
        return [path for path in made if mark + path.name.encode() in before and path.read_bytes().startswith(_HEAD)]
    return []


def map_assets(node: Any, name: Callable[[Asset], str]) -> Any:
    """Returns the data with each asset replaced by a path."""
    if isinstance(node, Asset):
        return name(node)
    if isinstance(node, dict):
        return {key: map_assets(value, name) for key, value in cast("dict[str, Any]", node).items()}
    if isinstance(node, list):
        return [map_assets(item, name) for item in cast("list[Any]", node)]
    return node


def _content(path: Path) -> bytes:
    with open_regular(path) as stream:
        return stream.read()


class AssetNames:
    """Assigns paths to a scene's assets, and collects the necessary copies.

    Args:
        output: the scene file to write, absolute.
        scope: scope of the imported file, with that file's folder as root.
        companions: file → files that it refers to, which are copied with it.
        passed: file → highest folder in a reference to it, whose tree is kept.

    Attributes:
        copies: path relative to the output's folder → content.
    """

    def __init__(
        self,
        output: Path,
        scope: AssetScope,
        companions: Mapping[Path, tuple[Path, ...]],
        passed: Mapping[Path, Path],
    ) -> None:
        self.copies: dict[str, bytes] = {}
        self._folder = output.parent.resolve()
        self._copied = assets_of(output).name
        self._scope = scope
        self._companions = companions
        self._passed = passed
        self._made: dict[str, str] = {}
        self._originals: dict[str, Path | None] = {}

    def name(self, asset: Asset) -> str:
        """Returns the path of an asset in the scene file. Raises OSError if a file to copy cannot be read."""
        if isinstance(asset.source, bytes):
            return self._add_generated(asset.name, asset.source)
        return self._reference_path(asset.source) or self._copy(asset.source)

    def _reference_path(self, path: Path) -> str | None:
        """Returns a path without a copy; None if the scene could not read the file or one that it names there."""
        roots = [root.resolve() for root in self._scope.asset_roots]
        if path.is_relative_to(self._folder):
            is_readable = self._are_inside(path, [self._folder, *roots])
            return path.relative_to(self._folder).as_posix() if is_readable else None
        for root in roots:
            if path.is_relative_to(root):
                is_readable = self._are_inside(path, [self._folder, *roots])
                return f"asset://{path.relative_to(root).as_posix()}" if is_readable else None
        for folder in path.parents:
            if (folder / "__init__.py").is_file() and str(folder.parent) in sys.path:
                known = has_package(folder.name, self._scope) and self._are_inside(path, [folder, *roots])
                return f"pkg://{folder.name}/{path.relative_to(folder).as_posix()}" if known else None
        return None

    def _are_inside(self, path: Path, folders: list[Path]) -> bool:
        """Returns whether all files that a file refers to are in one of these folders."""
        return all(any(map(each.is_relative_to, folders)) for each in self._companions.get(path, ()))

    def _copy(self, path: Path) -> str:
        """Copies a file and those that it refers to, in their folders, so that relative references stay valid."""
        files = (path, *self._companions.get(path, ()))
        root = (self._scope.root or Path.cwd()).resolve()
        passed = [each.parent if each == path else self._passed.get(each, each.parent) for each in files]
        if not all(each.is_relative_to(root) for each in passed):
            root = Path(os.path.commonpath(passed))
        inner = {each: each.relative_to(root).as_posix() for each in files}
        folder, count = self._copied, 1
        # Files of two folders may have equal names.
        while any(self._originals.get(f"{folder}/{name}", each) != each for each, name in inner.items()):
            count += 1
            folder = f"{self._copied}/{count}"
        texts = with_relative_paths(path, files) if path.suffix.lower() in {".xml", ".mjcf"} else {}
        for each, name in inner.items():
            if f"{folder}/{name}" not in self.copies:
                self.copies[f"{folder}/{name}"] = texts[each] if each in texts else _content(each)
                self._originals[f"{folder}/{name}"] = each
        return f"{folder}/{inner[path]}"

    def _add_generated(self, name: str, data: bytes) -> str:
        digest = sha256(data).hexdigest()
        if digest not in self._made:
            safe = re.sub(r"[^A-Za-z0-9_.-]+", "_", name).lstrip(".") or "asset"
            stem, suffix = Path(safe).stem, Path(safe).suffix
            path, count = f"{self._copied}/{safe}", 1
            while path in self.copies:
                count += 1
                path = f"{self._copied}/{stem}_{count}{suffix}"
            self._made[digest] = path
            self.copies[path] = data
            self._originals[path] = None
        return self._made[digest]
