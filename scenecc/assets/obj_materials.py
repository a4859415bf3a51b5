"""Materials of Wavefront OBJ meshes as SAPIEN's reader finds them, and OBJ copies without missing images."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path

MATERIAL_LINE = re.compile(rb"(?m)^([ \t]*)mtllib[ \t]+([^\r\n]*)")
"""Matches what is before `mtllib`, and the name with trailing blanks, which SAPIEN's reader includes."""

_MAP_LINE = re.compile(r"(?i)(?:map_|bump|norm|disp|decal|refl)[^ \t]*[ \t]+(.*)")
"""SAPIEN's reader checks only the first letters of the word, and takes everything after it as the name."""

_OPTION_WORDS = (
    dict.fromkeys(("-blendu", "-blendv", "-boost", "-texres", "-clamp", "-bm", "-imfchan", "-type"), 1)
    | {"-mm": 2}
    | dict.fromkeys(("-o", "-s", "-t"), 3)
)
"""Number of words after an option, as SAPIEN's reader counts them."""

_WORDS = {count: re.compile(rf"(?:[^ \t]*[ \t]+){{{count + 1}}}") for count in (1, 2, 3)}
"""An option and this many words, with the blanks after each."""

_FIRST_WORD = re.compile(r"\S*")


def image_of_line(line: str) -> str:
    """Returns the image that a line of an MTL names, or "".

    Raises:
        ValueError: SAPIEN misreads the line.
    """
    match = _MAP_LINE.match(line)
    return "" if match is None else image_of_words(match[1])


def image_of_words(rest: str) -> str:
    """Returns the file of a `map_…` line: everything after its options, including blanks.

    Raises:
        ValueError: SAPIEN misreads the options.
    """
    at = 0  # without copies, because a line may have millions of options
    while rest.startswith("-", at):
        first = _FIRST_WORD.match(rest, at)
        option = first[0].lower() if first else ""
        if option not in _OPTION_WORDS:
            raise ValueError(f"SAPIEN does not support the option `{option[:40]}`, and misreads what follows it")
        words = _WORDS[_OPTION_WORDS[option]].match(rest, at)
        if words is None:
            raise ValueError(f"`{option}` must be followed by {_OPTION_WORDS[option]} values and the name of the file")
        at = words.end()
    return rest[at:]


def fallback_materials(material: str, mesh: Path) -> list[str]:
    """Returns the names in the mesh's folder that SAPIEN's reader tries if a material file is missing.

    These are the mesh's own name with `.mtl`, and the ends of either path from any slash, up to the length of its last
    part.
    """
    other = f"{mesh.name[:-3]}mtl"
    tried = [other]
    for path in (f"{mesh.parent}/{material}", f"{mesh.parent}/{other}"):
        at = path.rfind("/")
        length = len(path) - at
        while at > 0:
            tried.append(path[at + 1 : at + length])
            at = path.rfind("/", 0, at)
    # Unlike a `Path`, these do not raise for a name that is too long.
    return [name for name in dict.fromkeys(tried) if _file_exists(f"{mesh.parent}/{name}")]


def _file_exists(path: str) -> bool:
    return os.path.exists(path) and not os.path.isdir(path)  # noqa: PTH110, PTH112


def keep_named_images(
    mesh: bytes, path: Path, named: Mapping[str, Path], read: Callable[[Path], bytes]
) -> bytes | None:
    """Returns the materials of an OBJ as one MTL with only existing images, or None if no image is missing.

    SAPIEN fails if an image is missing. `named`: paths of files that may be opened, by their names in the OBJ or MTL.
    """
    kept: list[str] = []
    is_whole = True
    for found in dict.fromkeys(match[2].decode("utf-8", "replace") for match in MATERIAL_LINE.finditer(mesh)):
        file = next((named[name] for name in (found, *fallback_materials(found, path)) if name in named), None)
        text = "" if file is None else read(file).decode("utf-8", "surrogateescape")
        for line in text.split("\n"):
            image = image_of_line(line.lstrip(" \t").rstrip("\r"))
            if image and image not in named:
                is_whole = False
                continue
            kept.append(line[: line.rindex(image)] + str(named[image].absolute()) if image else line)
    return None if is_whole else "\n".join(kept).encode("utf-8", "surrogateescape")


def with_materials(mesh: bytes, name: str) -> bytes:
    """Returns an OBJ whose materials are in the file `name` beside it."""
    return b"mtllib " + name.encode() + b"\n" + MATERIAL_LINE.sub(b"", mesh)
