"""The table of diagnostic codes, with its data in `codes.yaml`.

The file is read at the first report. Severities and titles are found without parsing it; cause, example and cure of a
code are parsed on request.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final, Literal, cast

from scenecc.diagnostics.frozen import frozen

Severity = Literal["error", "warning", "note"]

Fault = Literal["scene", "usage", "machine"]
"""What must be fixed: the scene file, the command, or the engine and machine."""

BANDS: Final[dict[str, str]] = {
    "0": "reading YAML",
    "1": "the language: structure of the data",
    "2": "parameters, expressions, prefabs and includes",
    "3": "names and scene selections",
    "4": "assets and robot files",
    "5": "physics",
    "6": "limits",
    "7": "plans as JSON, and files of other programs",
    "8": "the engine and the machine",
    "9": "usage",
}
"""The meaning of a code's first digit."""

_FAULTS: Final[dict[str, Fault]] = {"8": "machine", "9": "usage"}
"""What must be fixed, by the first digit of a code; for all other digits, the scene."""

_OF_CHECK: Final = re.compile(r"SC(?:43[4-9]|44|53|54|57|58[149]|8[56])")

_FILE = Path(__file__).with_name("codes.yaml")
_ENTRY = re.compile(
    r"^(SC\d{3}):\n"
    r"(?:  severity: (warning|note)\n)?"
    r"(?:  at_fault: (scene|usage|machine)\n)?"
    r"(?:  .*\n|\n)+",
    re.MULTILINE,
)


@frozen
class Code:
    """The meaning of a diagnostic code, for `scenecc explain` and the documentation.

    Attributes:
        code: `SC` and three digits. The first digit is the stage.
        severity: severity of its reports.
        at_fault: what must be fixed.
        entry: its entry in `codes.yaml`.
    """

    code: str
    severity: Severity
    at_fault: Fault
    entry: str

    @property
    def title(self) -> str:
        """The rule, in a few words."""
        return self._text("title")

    @property
    def cause(self) -> str:
        """Why it is reported: what SAPIEN would do, or what it could mean."""
        return self._text("cause")

    @property
    def example(self) -> str:
        """A scene file (or command) that causes it."""
        return self._text("example")

    @property
    def cure(self) -> str:
        """The fixed example, or what to do."""
        return self._text("cure")

    def _text(self, key: str) -> str:
        return _parsed(self.entry)[self.code][key]


@cache
def _parsed(entry: str) -> dict[str, dict[str, Any]]:
    import yaml  # noqa: PLC0415 - needed only for reports

    # Uses the C parser if PyYAML has it, because `scenecc explain` parses every entry for its list of titles.
    return yaml.load(entry, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))  # noqa: S506 - both are safe


class _Codes(Mapping[str, Code]):
    """All codes in order, read at first use."""

    def __init__(self) -> None:
        self._rows: dict[str, Code] = {}

    def _table(self) -> dict[str, Code]:
        if not self._rows:
            for found in _ENTRY.finditer(_FILE.read_text(encoding="utf-8")):
                code, severity, fault = found[1], found[2] or "error", found[3] or _FAULTS.get(found[1][2], "scene")
                self._rows[code] = Code(code, cast("Severity", severity), cast("Fault", fault), found[0])
        return self._rows

    def __getitem__(self, code: str) -> Code:
        return self._table()[code]

    def __iter__(self) -> Iterator[str]:
        return iter(self._table())

    def __len__(self) -> int:
        return len(self._table())


CODES: Final[Mapping[str, Code]] = _Codes()
"""All codes, by name."""


def is_of_check(code: str) -> bool:
    """Returns whether only `check` reports a code."""
    return _OF_CHECK.match(code) is not None
