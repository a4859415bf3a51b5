"""The files that an emitted script or plan needs: those outside its folder are copied beside it."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.files import read_checked
from scenecc.plan.body import rebase_file

if TYPE_CHECKING:
    from collections.abc import Collection

    from scenecc.plan import ScenePlan
    from scenecc.plan.body import AssetFile


def copy_outside_files(
    plan: ScenePlan, base: Path, folder: str, unread: Collection[int] = ()
) -> tuple[ScenePlan, dict[str, bytes]]:
    """Returns the plan with its files below `base`, and the content of those that must be written there.

    Files below `base`, of packages (`pkg://`) and of asset roots (`asset://`) stay where they are. The others, with the
    files that they name, keep their places relative to one another.

    Args:
        plan: the plan.
        base: folder of the emitted text.
        folder: name of the folder in `base` for the copies.
        unread: indices of files that the text does not read.

    Returns:
        The plan, and content by path relative to `base`.

    Raises:
        OSError: a file cannot be read, or has changed since the scene was compiled (ChangedError).
    """
    base = Path(os.path.realpath(base))
    outside = [at for at, file in enumerate(plan.files) if at not in unread and _is_outside(file, base)]
    hashes: dict[Path, str | None] = {}
    for index in outside:
        file = plan.files[index]
        hashes[file.path] = file.sha256
        hashes |= {named.path: named.sha256 for named in file.names if named.path is not None}
    if not hashes:
        return plan, {}
    top = Path(os.path.commonpath([path.parent for path in hashes]))
    places = {path: f"{folder}/{path.relative_to(top).as_posix()}" for path in hashes}
    files = list(plan.files)
    for index in outside:
        place = places[files[index].path]
        files[index] = replace(files[index], uri=place, path=base / place)
    return replace(plan, files=tuple(files)), {
        places[path]: read_checked(path, digest) for path, digest in hashes.items()
    }


def _is_outside(file: AssetFile, base: Path) -> bool:
    return "://" not in file.uri and file.data is None and not file.path.is_relative_to(base)


def list_needs(plan: ScenePlan, base: Path | None, unread: Collection[int] = ()) -> tuple[str, ...]:
    """Returns what an emitted text needs, besides the files that are written with it.

    These are paths relative to `base` (None: to the scene's folder), then packages and asset roots, in words.
    """
    needs: dict[str, None] = {}
    for index, file in sorted(enumerate(plan.files), key=lambda item: "://" in item[1].uri):
        scheme, _, inner = file.uri.partition("://")
        if index in unread or file.data is not None:
            continue
        if not inner:
            needs[f"`{file.uri if base is None else rebase_file(file, base).uri}`"] = None
        elif scheme == "pkg":
            needs[f"the package `{inner.partition('/')[0]}`"] = None
        else:
            needs[f"an asset root with `{inner}`"] = None
    return tuple(needs)
