"""Bytes to text: size, kind of file, encoding, and the characters that YAML does not have."""

from __future__ import annotations

import codecs
import os
import re
from typing import IO, TYPE_CHECKING, cast

from scenecc.diagnostics import Location, Sink
from scenecc.files import NotAFileError, open_regular
from scenecc.source.lines import Lines

if TYPE_CHECKING:
    from scenecc.source.limits import Limits

_CONTROLS = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufffe\uffff]")
"""What YAML may not hold (section 5.1 of its specification)."""

_SEPARATORS = re.compile("[\x85\u2028\u2029]")
"""Line breaks to YAML 1.1's parsers, and so to libyaml, but neither to YAML 1.2 nor to editors."""

_TAG_DIRECTIVE = re.compile(r"(?:^|[\r\n])%TAG")
_MAX_TAG_DIRECTIVES = 100
_TEXT_HINT = "a scene file is text in UTF-8"


def read_bytes(name: str, sink: Sink, limits: Limits) -> bytes | None:
    """The content of a regular file of at most the limit's size."""
    try:
        with open_regular(name) as file:
            if os.fstat(file.fileno()).st_size > limits.text_bytes:
                _too_long(name, sink, limits)
                return None
            content = read_some(file, name, sink, limits)
    except IsADirectoryError:
        sink.report("SC001", "this is a folder, not a file", Location(name), hint="name a scene file in it")
        return None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        is_pipe = isinstance(error, NotAFileError)
        hint = "give it as standard input (`-`)" if is_pipe else None
        sink.report("SC001", reason if is_pipe else f"cannot open the file: {reason}", Location(name), hint=hint)
        return None
    return content.encode() if isinstance(content, str) else content


def read_some(stream: IO[str] | IO[bytes], name: str | None, sink: Sink, limits: Limits) -> str | bytes | None:
    """The rest of a stream, unless it is longer than the limit."""
    text: list[str] = []
    content = bytearray()
    left = limits.text_bytes + 1
    piece: str | bytes | None = b""
    try:
        # An unbuffered stream gives what it has at the time, and nothing only at its end.
        while left > 0 and (piece := cast("str | bytes | None", stream.read(left))):
            if isinstance(piece, str):
                text.append(piece)
            else:
                content += piece
            left -= len(piece)
    except UnicodeDecodeError as error:
        _not_text(error, name, sink)
        return None
    except OSError as error:
        sink.report("SC001", f"cannot read: {error.strerror or error}", Location(name))
        return None
    if left <= 0:
        _too_long(name, sink, limits)
        return None
    if piece is None:
        hint = "give a stream that waits for its data (os.set_blocking)"
        sink.report("SC001", "the stream does not block, and its end is not there yet", Location(name), hint=hint)
        return None
    return "".join(text) if text else bytes(content)


def decode(text: str | bytes, name: str | None, sink: Sink, limits: Limits) -> str | None:
    """Text without its byte order mark, as the parser may be given it; None, reported, where it is no such text."""
    try:
        decoded = text if isinstance(text, str) else _decode_bytes(text)
    except UnicodeDecodeError as error:
        _not_text(error, name, sink)
        return None
    lines = Lines(name, decoded.removeprefix("\ufeff"))
    try:
        size = len(decoded) if decoded.isascii() else len(decoded.encode())
    except UnicodeEncodeError as error:
        # The place is in the text with its byte order mark, if it has one.
        report_character(lines, error.start - (len(decoded) - len(lines.text)), sink)
        return None
    if size > limits.text_bytes:
        _too_long(name, sink, limits)
        return None
    separator = None if decoded.isascii() else _SEPARATORS.search(lines.text)
    if separator is not None:
        report_character(lines, separator.start(), sink)
        return None
    if decoded.count("%TAG") > _MAX_TAG_DIRECTIVES:
        directives = [match.end() for match in _TAG_DIRECTIVE.finditer(lines.text)]
        if len(directives) > _MAX_TAG_DIRECTIVES:
            # The parser compares each with all before it.
            place = lines.location(*lines.position(directives[_MAX_TAG_DIRECTIVES] - 4))
            sink.report("SC008", f"more than {_MAX_TAG_DIRECTIVES} %TAG directives", place, hint="take them away")
            return None
    return lines.text


def control_character(text: str) -> int | None:
    """The offset of the first character that YAML may not hold."""
    match = _CONTROLS.search(text)
    return None if match is None else match.start()


def report_character(lines: Lines, offset: int, sink: Sink) -> None:
    """Reports a character that must not stand in a scene file."""
    line, column = lines.position(offset)
    code = ord(lines.text[offset])
    what, hint = f"the control character U+{code:04X}", _TEXT_HINT
    if code == 0:
        what, hint = "a zero byte (U+0000)", "is this a binary file? " + _TEXT_HINT
    elif 0xD800 <= code <= 0xDFFF:
        what = f"half of a character (the lone surrogate U+{code:04X})"
    elif code in (0x85, 0x2028, 0x2029):
        what = f"U+{code:04X}, a line break to some programs and not to others"
        hint = f'break the line, or write "\\u{code:04X}" in double quotes'
    sink.report("SC002", f"the text holds {what}", lines.location(line, column, column + 1), hint=hint)


def _decode_bytes(content: bytes) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16")
    return content.decode("utf-8")


def _not_text(error: UnicodeDecodeError, name: str | None, sink: Sink) -> None:
    """Reports bytes that are no text, at the line in which they stand where the text before them is good."""
    before = error.object[: error.start].decode(error.encoding, errors="replace").removeprefix("\ufeff")
    after = error.object[error.start : error.start + 200].decode(error.encoding, errors="replace")
    lines = Lines(name, before + after)
    line, column = lines.position(len(before))
    byte = f"0x{error.object[error.start]:02X}"
    encoding = "UTF-16" if error.encoding.startswith("utf-16") else "UTF-8"
    sink.report(
        "SC002",
        f"this is not {encoding} text: byte {error.start} ({byte}) belongs to no character",
        lines.location(line, column, column + 1),
        hint=_TEXT_HINT + "; save it in that encoding",
    )


def text_size(text: str) -> int:
    """The bytes that a YAML text counts for: at least four for each value, since a value takes far more in memory."""
    return max(len(text), 4 * (text.count(",") + text.count("\n")))


def check_values(text: str, name: str | None, sink: Sink, limits: Limits) -> bool:
    """Whether a YAML text may hold as many values as it does; otherwise that is reported."""
    if text_size(text) <= limits.text_bytes:
        return True
    most = limits.text_bytes // 4
    _too_long(name, sink, limits, f"the text has more than {most} commas and lines (a quarter of the limit text_bytes)")
    return False


def _too_long(name: str | None, sink: Sink, limits: Limits, message: str = "") -> None:
    sink.report(
        "SC601",
        message or f"the text is longer than {limits.text_bytes} bytes (limit text_bytes)",
        Location(name),
        hint="`--limit text_bytes=N` or `limits={'text_bytes': N}` raises the limit",
    )
