"""Uris of files as they read from another folder."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.plan.material import AssetFile


def rebased(file: AssetFile, base: Path) -> AssetFile:
    """The same file, named for a document in the folder `base`: a relative uri starts there, others stay."""
    if "://" in file.uri or Path(file.uri).is_absolute():
        return file
    return replace(file, uri=Path(os.path.relpath(file.path, base.absolute())).as_posix())
