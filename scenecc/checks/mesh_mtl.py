"""Wavefront MTL, the materials of an OBJ: the images that it names, and numbers where the reader needs them."""

from __future__ import annotations

import re

from scenecc.checks.mesh_data import AssetError, Reference
from scenecc.checks.mesh_text import Lines, words

_MAPS = re.compile(r"(?i)(?:map_\w+|bump|norm|disp|refl)[ \t]+(.*)")
_NUMBERS = re.compile(r"([kK][adse]|Tf|Ps)|disp|[da]|Tr|[nN][si]|P[rm]|Pcr?")
"""How lines begin that hold a colour (the group) or a number: SAPIEN's reader looks at their first letters alone."""
_NUMBER = re.compile(r"(?i)[-+]?(?:(?:[0-9]{1,18}\.?[0-9]*|\.[0-9]+)(?:e[-+]?[0-9]{1,3})?|nan|inf|infinity)")
_OPTION_WORDS = {"-mm": 2} | dict.fromkeys(
    ("-blendu", "-blendv", "-boost", "-texres", "-clamp", "-bm", "-imfchan", "-type", "-cc"), 1
)


def mtl_images(data: bytes) -> tuple[Reference, ...]:
    """The images that an MTL names. SAPIEN seeks them beside the OBJ.

    Raises:
        AssetError: it is no text, or lacks a number, which ends the loading of the whole mesh.
    """
    names: dict[str, None] = {}
    row = 0
    try:
        lines = Lines(data)
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


def _without_options(text: str) -> str:
    """The file of a `map_…` line: what follows its options, blanks and all."""
    while text.startswith("-"):
        option, text = _next(text)
        if option.lower() in {"-o", "-s", "-t"}:
            while _NUMBER.fullmatch(_next(text)[0]):
                text = _next(text)[1]
        else:
            for _ in range(_OPTION_WORDS.get(option.lower(), 0)):
                text = _next(text)[1]
    return text


def _next(text: str) -> tuple[str, str]:
    """The first word of a text, and what follows the blanks behind it."""
    word = re.match(r"[^ \t]*", text)
    end = 0 if word is None else word.end()
    return text[:end], text[end:].lstrip(" \t")
