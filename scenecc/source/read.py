"""The ways into the compiler: files, text, dicts, and single values."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Location
from scenecc.diagnostics.collector import collector_paused
from scenecc.source.document import Document
from scenecc.source.faults import Faults
from scenecc.source.limits import Limits
from scenecc.source.lines import Lines
from scenecc.source.reader import read_yaml
from scenecc.source.text import check_values, decode, read_bytes
from scenecc.source.values import plain_mapping

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink

_DEFAULT = Limits()


def read_file(path: str | PathLike[str], sink: Sink, limits: Limits = _DEFAULT) -> Document | None:
    """Reads a scene file. None, with errors in the sink, where it cannot be read or is no good."""
    name = fspath(path)
    content = read_bytes(name, sink, limits)
    return None if content is None else read_text(content, name, sink, limits, path=Path(name).absolute())


def read_text(
    text: str | bytes, name: str | None, sink: Sink, limits: Limits = _DEFAULT, path: Path | None = None
) -> Document | None:
    """Reads YAML text; bytes are UTF-8, or UTF-16 with a byte order mark.

    Args:
        text: the whole document.
        name: as shown to people.
        sink: takes what is wrong.
        limits: of the text's size, depth and aliases.
        path: absolute path of the file that the text is from.
    """
    decoded = decode(text, name, sink, limits)
    if decoded is None or not check_values(decoded, name, sink, limits):
        return None
    lines = Lines(name, decoded)
    faults = Faults(lines, sink)
    with collector_paused():
        data = read_yaml(faults, limits)
    return None if data is None or faults.any else Document(name, path, data, lines)


def read_value(text: str, sink: Sink) -> Any:
    """Reads a value that stands on one line, as it would after a key; None, reported, where it is no good.

    What begins with `#` is a string, since a value that is a comment alone would be none.
    """
    text = text.strip()
    if text.startswith("#"):
        return text
    if "\n" in text or "\r" in text:
        sink.report("SC003", "the value has several lines", Location(None), hint="write lists as [a, b]")
        return None
    document = read_text(f"value: {text}", None, sink)
    return None if document is None else document.data["value"]


def read_dict(data: Mapping[str, Any], sink: Sink, limits: Limits = _DEFAULT) -> Document | None:
    """Takes a scene given as Python data, which is copied and never changed.

    Tuples, numpy scalars and arrays, and paths become lists, numbers and strings. Whatever a text could not
    hold (sets, bytes, None, keys that are not strings, other objects) is reported at its path.
    """
    plain = plain_mapping(data, sink, limits)
    return None if plain is None else Document(None, None, plain, None)
