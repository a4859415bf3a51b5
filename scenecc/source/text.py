"""Converts bytes to text, checks file type, size, encoding and characters, and finds lines for diagnostics."""

from __future__ import annotations

import codecs
import os
import re
from functools import cached_property
from typing import IO, TYPE_CHECKING, cast

from scenecc.diagnostics.diagnostic import Location
from scenecc.files import NotAFileError, open_regular

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.source.limits import Limits


class TextLines:
    """A named text with locations.

    Attributes:
        file: name of the document for messages.
        text: the text, without a byte order mark.
    """

    def __init__(self, file: str | None, text: str) -> None:
        self.file = file
        self.text = text
        self._split: list[str] = []

    @cached_property
    def _unified(self) -> str:
        return _unify_line_breaks(self.text)

    def line(self, line: int) -> str:
        """Returns a 0-based line; "" past the end."""
        if line >= len(self._split):
            # One line more than needed, because the last part is the rest of the text; and twice as many, so that
            # reading all lines in turn costs no more than reading the last.
            self._split = self._unified.split("\n", 2 * line + 100)
            if len(self._split) == 2 * line + 101:
                del self._split[-1]
        return self._split[line] if line < len(self._split) else ""

    def is_last(self, line: int) -> bool:
        """Returns whether only blanks follow a 0-based line."""
        parts = self._unified.split("\n", line + 1)
        return len(parts) <= line + 1 or not parts[-1].strip()

    def is_past(self, line: int) -> bool:
        """Returns whether a 0-based line is past the end."""
        return line > self._unified.count("\n")

    def location(self, line: int, column: int, end_column: int | None = None) -> Location:
        """Returns the location of columns `column` to `end_column` (excluded; None: the line's end); all are 0-based.

        It covers at least one character, and at most one past the end of the line.
        """
        text = self.line(line)
        end = len(text.rstrip()) if end_column is None else min(end_column, len(text))
        return Location(self.file, line + 1, column + 1, max(end, column + 1) + 1, text)

    def position(self, offset: int) -> tuple[int, int]:
        """Returns the 0-based line and column of a 0-based offset in the text."""
        before = self.text[:offset]
        if before.endswith("\r") and self.text.startswith("\n", offset):
            before = before[:-1]
        before = _unify_line_breaks(before)
        return before.count("\n"), len(before) - (before.rfind("\n") + 1)


def _unify_line_breaks(text: str) -> str:
    r"""Returns the text with `\n` for the parser's line breaks, which are fewer than those of `str.splitlines`."""
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


_CONTROL_CHARACTERS = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufffe\uffff]")
"""Characters that YAML does not allow (section 5.1 of its specification)."""

SEPARATORS = re.compile("[\x85\u2028\u2029]")
"""Line breaks in YAML 1.1 and thus in libyaml, but not in YAML 1.2 or editors."""

LONE_SURROGATES = re.compile("[\ud800-\udfff]")
"""Halves of characters, which an editor may contain temporarily, but UTF-8 cannot encode."""

_TAG_DIRECTIVE = re.compile(r"(?:^|[\r\n])%TAG")

_MAX_TAG_DIRECTIVES = 100

_TEXT_HINT = "a scene file must be UTF-8 text"


_LANGUAGE_KEY = re.compile(r"""^(?:\{[ \t]*)?(?:scenecc|"scenecc"|'scenecc')[ \t]*:""", re.MULTILINE)


def is_scene_text(text: str) -> bool:
    """Returns whether a text has the key that every scene has at its top level."""
    return _LANGUAGE_KEY.search(text) is not None


def read_bytes(name: str, sink: Sink, limits: Limits) -> bytes | None:
    """Returns the content of a regular file within the size limit; None if an error was reported."""
    try:
        with open_regular(name) as file:
            if os.fstat(file.fileno()).st_size > limits.text_bytes:
                _report_length(name, sink, limits)
                return None
            content = read_from_stream(file, name, sink, limits)
    except IsADirectoryError:
        sink.report("SC001", "it is a folder, not a file", Location(name), hint="name a scene file in it")
        return None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        is_pipe = isinstance(error, NotAFileError)
        hint = "give it as standard input (`-`)" if is_pipe else None
        sink.report("SC001", reason if is_pipe else f"cannot open the file: {reason}", Location(name), hint=hint)
        return None
    return content.encode() if isinstance(content, str) else content


def read_from_stream(stream: IO[str] | IO[bytes], name: str | None, sink: Sink, limits: Limits) -> str | bytes | None:
    """Returns the rest of a stream; None, reported, if it is too long.

    Raises:
        ValueError: the stream is closed.
    """
    if getattr(stream, "closed", False):
        raise ValueError("the stream is closed: keep it open until the scene is compiled")
    text: list[str] = []
    content = bytearray()
    left = limits.text_bytes + 1
    piece: str | bytes | None = b""
    try:
        # An unbuffered stream returns what is available, and nothing only at its end.
        while left > 0 and (piece := cast("str | bytes | None", stream.read(left))):
            if isinstance(piece, str):
                text.append(piece)
            else:
                content += piece
            left -= len(piece)
    except UnicodeDecodeError as error:
        _report_encoding(error, name, sink)
        return None
    except OSError as error:
        sink.report("SC001", f"cannot read: {error.strerror or error}", Location(name))
        return None
    if left <= 0:
        _report_length(name, sink, limits)
        return None
    if piece is None:
        hint = "use a blocking stream (os.set_blocking)"
        sink.report("SC001", "the stream is non-blocking, and its end has not been reached", Location(name), hint=hint)
        return None
    return "".join(text) if text else bytes(content)


def decode_text(text: str | bytes, name: str | None, sink: Sink, limits: Limits) -> str | None:
    """Returns text without its byte order mark, ready for the parser; None, reported, if it is invalid."""
    try:
        decoded = text if isinstance(text, str) else _decode_bytes(text)
    except UnicodeDecodeError as error:
        _report_encoding(error, name, sink)
        return None
    lines = TextLines(name, decoded.removeprefix("\ufeff"))
    try:
        size = len(decoded) if decoded.isascii() else len(decoded.encode())
    except UnicodeEncodeError as error:
        # The location is in the text with its byte order mark, if it has one.
        report_character(lines, error.start - (len(decoded) - len(lines.text)), sink)
        return None
    if size > limits.text_bytes:
        _report_length(name, sink, limits)
        return None
    separator = None if decoded.isascii() else SEPARATORS.search(lines.text)
    if separator is not None:
        report_character(lines, separator.start(), sink)
        return None
    if decoded.count("%TAG") > _MAX_TAG_DIRECTIVES:
        directives = [match.end() for match in _TAG_DIRECTIVE.finditer(lines.text)]
        if len(directives) > _MAX_TAG_DIRECTIVES:
            # The parser compares each with all earlier ones.
            place = lines.location(*lines.position(directives[_MAX_TAG_DIRECTIVES] - 4))
            sink.report("SC008", f"more than {_MAX_TAG_DIRECTIVES} %TAG directives", place, hint="remove them")
            return None
    return lines.text


def find_control_character(text: str) -> int | None:
    """Returns the offset of the first character that YAML does not allow."""
    match = _CONTROL_CHARACTERS.search(text)
    return None if match is None else match.start()


def report_character(lines: TextLines, offset: int, sink: Sink) -> None:
    """Reports a character that is not allowed in a scene file."""
    line, column = lines.position(offset)
    code = ord(lines.text[offset])
    what, hint = f"the control character U+{code:04X}", f'delete it, or write "\\u{code:04X}" in double quotes'
    if code == 0:
        what, hint = "a zero byte (U+0000)", "is this a binary file? " + _TEXT_HINT
    elif 0xD800 <= code <= 0xDFFF:
        what, hint = f"a lone surrogate (U+{code:04X})", _TEXT_HINT
    elif code in (0x85, 0x2028, 0x2029):
        what = f"U+{code:04X}, a line break only in some programs"
        hint = f'break the line, or write "\\u{code:04X}" in double quotes'
    sink.report("SC002", f"the text contains {what}", lines.location(line, column, column + 1), hint=hint)


_MARKS = ((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be"))


def encoded_as(content: bytes, text: str) -> bytes:
    """Returns a text in the encoding of a file, with the byte order mark of its content."""
    mark, encoding = next((row for row in _MARKS if content.startswith(row[0])), (b"", "utf-8"))
    return mark + text.encode(encoding)


def _decode_bytes(content: bytes) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16")
    return content.decode("utf-8")


def _report_encoding(error: UnicodeDecodeError, name: str | None, sink: Sink) -> None:
    """Reports invalid bytes, at their line if the text before them is valid."""
    before = error.object[: error.start].decode(error.encoding, errors="replace").removeprefix("\ufeff")
    after = error.object[error.start : error.start + 200].decode(error.encoding, errors="replace")
    lines = TextLines(name, before + after)
    line, column = lines.position(len(before))
    byte = f"0x{error.object[error.start]:02X}"
    encoding = "UTF-16" if error.encoding.startswith("utf-16") else "UTF-8"
    sink.report(
        "SC002",
        f"it is not {encoding} text: byte {error.start} ({byte}) is invalid",
        lines.location(line, column, column + 1),
        hint=_TEXT_HINT + "; save it in that encoding",
    )


def text_size(text: str) -> int:
    """Returns the size that a YAML text counts for: at least four bytes per value, because a value takes far more
    memory.
    """
    return max(len(text), 4 * (text.count(",") + text.count("\n")))


def check_value_count(text: str, name: str | None, sink: Sink, limits: Limits) -> bool:
    """Returns whether a YAML text is within the limit of values; otherwise reports it."""
    if text_size(text) <= limits.text_bytes:
        return True
    most = limits.text_bytes // 4
    _report_length(
        name, sink, limits, f"the text has more than {most} commas and lines (a quarter of the limit text_bytes)"
    )
    return False


def _report_length(name: str | None, sink: Sink, limits: Limits, message: str = "") -> None:
    sink.report(
        "SC601",
        message or f"the text is longer than {limits.text_bytes} bytes (limit text_bytes)",
        Location(name),
        hint="`--limit text_bytes=N` or `limits={'text_bytes': N}` raises the limit",
    )
