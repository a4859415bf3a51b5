"""Wavefront MTL, the materials of an OBJ: the images that it names, and numbers where the reader needs them."""

from __future__ import annotations

import os
import re
from typing import TYPE_CHECKING

from scenecc.checks.mesh_data import AssetError, Reference
from scenecc.checks.mesh_text import Budget, Lines, words

if TYPE_CHECKING:
    from pathlib import Path

_MAPS = re.compile(r"(?i)(?:map_|bump|norm|disp|decal|refl)[^ \t]*[ \t]+(.*)")
"""SAPIEN's reader looks at the first letters of the word alone, and takes all that follows it for the name."""
_NUMBERS = re.compile(r"([kK][adse]|Tf|Ps)|disp|[da]|Tr|[nN][si]|P[rm]|Pcr?")
"""How lines begin that hold a colour (the group) or a number: SAPIEN's reader looks at their first letters alone."""
_NUMBER = re.compile(r"(?i)[-+]?(?:(?:[0-9]{1,18}\.?[0-9]*|\.[0-9]+)(?:e[-+]?[0-9]{1,3})?|nan|inf|infinity)")
_OPTION_WORDS = (
    dict.fromkeys(("-blendu", "-blendv", "-boost", "-texres", "-clamp", "-bm", "-imfchan", "-type"), 1)
    | {"-mm": 2}
    | dict.fromkeys(("-o", "-s", "-t"), 3)
)
"""How many words follow an option, as SAPIEN's reader counts them."""


def mtl_images(data: bytes, budget: Budget) -> tuple[Reference, ...]:
    """The images that an MTL names. SAPIEN seeks them beside the OBJ.

    Raises:
        AssetError: it is no text, SAPIEN reads a line of it otherwise, or it lacks a number, which ends the loading of
            the whole mesh.
    """
    names: dict[str, None] = {}
    row = 0
    try:
        lines = Lines(data, budget)
        while (raw := lines.raw()) is not None:
            row = lines.row
            line = raw.lstrip(" \t")
            _check_numbers(line)
            match = _MAPS.match(line)
            if match is not None:
                names[_without_options(match[1])] = None
    except ValueError as error:
        message = f"the MTL cannot be read (line {row}): {error}"
        raise AssetError("SC412", message, "export the mesh again") from error
    return tuple(Reference(name, "image") for name in names if name)


def _check_numbers(line: str) -> None:
    match = _NUMBERS.match(line)
    if match is None or match[0] == "disp":
        return
    said = words(line[match.end() :])
    if match[1] and len(said) != 1:
        said = [*said, "", ""][:3]
    elif match[1] and line[-1] in " \t":
        raise ValueError(f"`{line[:40]}` ends with a blank, after which SAPIEN's reader wants a number")
    wrong = next((word for word in said[: 3 if match[1] else 1] if _NUMBER.fullmatch(word) is None), None)
    if wrong is not None:
        raise ValueError(f"`{line[:40]}` lacks a number where SAPIEN's reader wants one")


def _without_options(rest: str) -> str:
    """The file of a `map_…` line: what follows its options, blanks and all."""
    while rest.startswith("-"):
        option = rest.split(maxsplit=1)[0].lower()
        if option not in _OPTION_WORDS:
            raise ValueError(f"SAPIEN does not know the option `{option[:40]}`, and misreads what follows it")
        parts = re.split(r"[ \t]+", rest, maxsplit=_OPTION_WORDS[option] + 1)
        if len(parts) < _OPTION_WORDS[option] + 2:
            raise ValueError(f"`{option}` has {_OPTION_WORDS[option]} values and then the name of the file")
        rest = parts[-1]
    return rest


def in_place_of(material: str, mesh: Path) -> list[str]:
    """What SAPIEN's reader finds for a material file that is not there: names in the folder of the mesh.

    That is the mesh's own name with `.mtl`, and what begins at a slash of the path of either, as long as its last part.
    """
    other = f"{mesh.name[:-3]}mtl"
    tried = [other]
    for path in (f"{mesh.parent}/{material}", f"{mesh.parent}/{other}"):
        at = path.rfind("/")
        length = len(path) - at
        while at > 0:
            tried.append(path[at + 1 : at + length])
            at = path.rfind("/", 0, at)
    # Unlike a `Path`, these raise nothing for a name that is too long.
    return [name for name in dict.fromkeys(tried) if _is_there(f"{mesh.parent}/{name}")]


def _is_there(path: str) -> bool:
    return os.path.exists(path) and not os.path.isdir(path)  # noqa: PTH110, PTH112
