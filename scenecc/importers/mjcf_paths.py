"""Absolute paths in an MJCF that is copied, as robosuite writes them."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Final

_TAG: Final = re.compile(r"<(\w+)\b[^<>]*>")
_FOLDER: Final = re.compile(r"""\b(meshdir|texturedir|assetdir)\s*=\s*["']([^"']*)""")
_ABSOLUTE: Final = re.compile(r"""(\b(?:file\w*|\w+dir)\s*=\s*["'])(/[^"']*)""")


def with_relative_paths(data: bytes, file: Path) -> bytes:
    """Returns an MJCF with its absolute paths made relative, so that copies in the same folders are found.

    Args:
        data: its content.
        file: its absolute path. In MJCF, meshes and textures are relative to the folders that `<compiler>` names.
    """
    text = data.decode("utf-8", "surrogateescape")
    named = {
        name: folder for tag in _TAG.finditer(text) if tag[1] == "compiler" for name, folder in _FOLDER.findall(tag[0])
    }

    def relative(tag: re.Match[str]) -> str:
        own = {"mesh": "meshdir", "hfield": "meshdir", "texture": "texturedir"}.get(tag[1])
        folder = named.get(own, named.get("assetdir", "")) if own else ""
        start = file.parent / folder
        return _ABSOLUTE.sub(lambda name: name[1] + Path(os.path.relpath(name[2], start)).as_posix(), tag[0])

    return _TAG.sub(relative, text).encode("utf-8", "surrogateescape")
