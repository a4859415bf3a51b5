"""Absolute paths in an MJCF that is copied, as robosuite writes them, and in the files that it includes or attaches."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

from scenecc.files import open_regular

if TYPE_CHECKING:
    from collections.abc import Collection

_TAG: Final = re.compile(r"<!--.*?-->|<(\w+)\b[^<>]*>", re.DOTALL)
_FOLDER: Final = re.compile(r"""\b(meshdir|texturedir|assetdir)\s*=\s*["']([^"']*)""")
_FILE: Final = re.compile(r"""\bfile\s*=\s*["']([^"']*)""")
_ABSOLUTE: Final = re.compile(r"""(\b(?:file\w*|\w+dir)\s*=\s*["'])(/[^"']*)""")


def with_relative_paths(file: Path, copied: Collection[Path]) -> dict[Path, bytes]:
    """Returns MJCF files with their absolute paths made relative, so that copies in the same folders are found.

    Args:
        file: the absolute path of the MJCF. Its includes and the models that it attaches are read as well.
        copied: all files that are copied with it; no others are read.

    Raises:
        OSError: a file cannot be read.
    """
    found: dict[Path, bytes] = {}
    models = [file]
    for model in models:
        texts, folders = dict[Path, str](), dict[str, str]()
        _read(model, model, texts, folders, copied)
        for path, text in texts.items():
            relative = _TAG.sub(lambda tag, model=model, folders=folders: _relative(tag, model, folders), text)
            found.setdefault(path, relative.encode("utf-8", "surrogateescape"))
            attached = [_named(tag, model) for tag in _TAG.finditer(text) if tag[1] == "model"]
            models += [one for one in dict.fromkeys(attached) if one in copied and one not in models]
    return found


def _read(path: Path, model: Path, texts: dict[Path, str], folders: dict[str, str], copied: Collection[Path]) -> None:
    """Adds the text of a file and of its includes, and the folders of `<compiler>`, of which the last ones count."""
    with open_regular(path) as stream:
        texts[path] = stream.read().decode("utf-8", "surrogateescape")
    for tag in _TAG.finditer(texts[path]):
        if tag[1] == "compiler":
            folders.update(_FOLDER.findall(tag[0]))
        elif tag[1] == "include" and (included := _named(tag, model)) in copied and included not in texts:
            _read(included, model, texts, folders, copied)


def _named(tag: re.Match[str], model: Path) -> Path:
    """Returns the file that an `<include>` or `<model>` names, relative to the model, also in its includes."""
    name = _FILE.search(tag[0])
    return (model.parent / (name[1] if name else "")).resolve()


def _relative(tag: re.Match[str], model: Path, folders: dict[str, str]) -> str:
    own = {"mesh": "meshdir", "hfield": "meshdir", "texture": "texturedir"}.get(tag[1])
    folder = folders.get(own, folders.get("assetdir", "")) if own else ""
    start = (model.parent / folder).resolve()
    return tag[0] if tag[1] is None else _ABSOLUTE.sub(lambda name: name[1] + _path_from(start, name[2]), tag[0])


def _path_from(start: Path, path: str) -> str:
    return Path(os.path.relpath(Path(path).resolve(), start)).as_posix()
