"""What a scene file of `tests/scenes/` says about its own diagnostics.

A comment at the end of the faulty line names codes and the columns where they are reported:

    - {type: box, half_size: [1, 1]}      # expect: SC106 @ 26
    a: {mass: -1, poze: []}               # expect: SC104 @ 11; SC101 @ 15

Where the line itself can hold no comment, a line of its own says it: `# expect at 3:5: SC003`.
"""

from __future__ import annotations

import codecs
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
GOOD, BAD = ROOT / "tests/scenes/good", ROOT / "tests/scenes/bad"

Expected = tuple[int, int, str]
"""Line, column and code."""

_AT_LINE = re.compile(r"#\s*expect:\s*(.*?)\s*$")
_AT = re.compile(r"^#\s*expect at (\d+):(\d+): (SC\d{3})\s*$")
_ITEM = re.compile(r"^(SC\d{3}) @ (\d+)$")


def scene_files(folder: Path) -> list[Path]:
    """Every scene file below a folder, in order."""
    return sorted(folder.rglob("*.yaml"))


def file_id(file: Path) -> str:
    return file.relative_to(ROOT).as_posix()


def expectations(file: Path) -> list[Expected]:
    """What the file states, in order.

    Raises:
        ValueError: a comment that speaks of expectations cannot be read.
    """
    found: list[Expected] = []
    for number, line in enumerate(_text(file).split("\n"), start=1):
        if match := _AT.match(line):
            found.append((int(match[1]), int(match[2]), match[3]))
        elif match := _AT_LINE.search(line):
            found += [_item(item, number, file) for item in match[1].split("; ")]
        elif re.search(r"#.*\bexpect\b", line):
            raise ValueError(f"{file}:{number}: no expectation: {line}")
    return sorted(found)


def _item(item: str, number: int, file: Path) -> Expected:
    match = _ITEM.match(item)
    if match is None:
        raise ValueError(f"{file}:{number}: an expectation is `SC101 @ COLUMN`, not {item!r}")
    return number, int(match[2]), match[1]


def _text(file: Path) -> str:
    """The comments of any file, one that is no text included."""
    content = file.read_bytes()
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    return content.decode("utf-8", errors="surrogateescape")
