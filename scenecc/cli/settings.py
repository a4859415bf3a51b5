"""Which findings a team wants: `[tool.scenecc]` of the nearest pyproject.toml, and the options that override it."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from importlib import import_module
from os.path import relpath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

from scenecc.cli.output import usage_error
from scenecc.cli.paths import STDIN
from scenecc.files import open_regular

if TYPE_CHECKING:
    from scenecc.checks.house_rules import Rule
    from scenecc.diagnostics import Diagnostic, Severity


ENTRY_POINTS: Final = "scenecc.rules"
"""The entry point group in which a package lists its rules by id."""

_MAX_BYTES = 2**20
_PREFIX = re.compile(r"[A-Z]{2,3}[0-9]*|SC")
RULE_PREFIX: Final = re.compile(r"(?!SC)[A-Z]{3}[0-9]*")
_RULE_ID = re.compile(r"(?!SC)[A-Z]{3}[0-9]{1,4}")
_SEVERITIES = ("error", "warning", "note")


class SettingsError(Exception):
    """An error in a pyproject.toml.

    Attributes:
        words: the last of these words in the file marks the line.
        hint: how to fix it.
    """

    def __init__(self, message: str, *words: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.words = words
        self.hint = hint


@dataclass(frozen=True, slots=True)
class ProjectSettings:
    """The settings of one pyproject.toml, merged with the command line. Codes are complete or prefixes.

    Its `repr` is the same on every machine.

    Attributes:
        folder: folder to which patterns are relative.
        select: codes to report; None: all.
        ignore: codes to ignore. If both match, the longer prefix counts; at equal length, `ignore`.
        severity: severity of codes, where it differs from the default.
        per_file_ignores: path pattern of a scene, or of the file of a finding → more codes to ignore.
        strict: whether warnings count as errors.
        rules: house rules, by id.
    """

    folder: Path = field(repr=False)
    select: tuple[str, ...] | None = None
    ignore: tuple[str, ...] = ()
    severity: Mapping[str, Severity] | None = None
    per_file_ignores: Mapping[str, tuple[str, ...]] | None = None
    strict: bool = False
    rules: Mapping[str, Rule] | None = field(default=None, repr=False)

    def apply(self, diagnostics: list[Diagnostic], scene: str) -> list[Diagnostic]:
        """Returns the wanted diagnostics of a scene with the set severities. Errors are never changed."""
        return [
            self._with_severity(one) for one in diagnostics if one.severity == "error" or self._is_wanted(one, scene)
        ]

    def _is_wanted(self, found: Diagnostic, scene: str) -> bool:
        from scenecc.diagnostics.diagnostic import IN_PREFAB

        selected = 0 if self.select is None else _longest(found.code, self.select)
        ignored = _longest(found.code, self.ignore)
        places = (found.location, *(other.location for other in found.related if other.message == IN_PREFAB))
        files = {scene, *(place.file for place in places if place.file)}
        for pattern, codes in (self.per_file_ignores or {}).items():
            if any(fnmatchcase(self._relative(file), pattern) for file in files):
                ignored = max(ignored, _longest(found.code, codes))
        return selected > ignored

    def _relative(self, file: str) -> str:
        return file if "://" in file else Path(relpath(file, self.folder)).as_posix()

    def _with_severity(self, found: Diagnostic) -> Diagnostic:
        fitting = [code for code in self.severity or {} if found.code.startswith(code)]
        if found.severity == "error" or not fitting or self.severity is None:
            return found
        return replace(found, severity=self.severity[max(fitting, key=len)])


def _longest(code: str, prefixes: tuple[str, ...]) -> int:
    """Returns the length of the longest matching prefix of a code; -1 if none matches."""
    return max((len(prefix) for prefix in prefixes if code.startswith(prefix)), default=-1)


class SettingsFinder:
    """Finds the settings of each file, from the command line and the nearest pyproject.toml with a `[tool.scenecc]`.

    Args:
        select: from the command line; replaces `select` and `ignore` of the file.
        ignore: from the command line; adds to `ignore` of the file.
        strict: from the command line.

    Attributes:
        faults: diagnostics about these files.
    """

    def __init__(self, select: tuple[str, ...] | None, ignore: tuple[str, ...], *, strict: bool) -> None:
        self.faults: list[Diagnostic] = []
        self._select, self._ignore, self._strict = select, ignore, strict
        self._by_folder: dict[Path, ProjectSettings | None] = {}
        self._merged: dict[Path, ProjectSettings] = {}

    def of(self, scene: str) -> ProjectSettings:
        """Returns the settings for a scene's path; for standard input, those of the current folder."""
        folder = Path.cwd() if scene == STDIN else Path(scene).absolute().parent
        if folder not in self._merged:  # one entry per folder, which may have many files
            self._merged[folder] = self._with_command_line(folder)
        return self._merged[folder]

    def _with_command_line(self, folder: Path) -> ProjectSettings:
        found = self._nearest(folder) or ProjectSettings(Path.cwd())
        if self._select is not None:
            found = replace(found, select=self._select, ignore=())
        return replace(found, ignore=(*found.ignore, *self._ignore), strict=found.strict or self._strict)

    def _nearest(self, folder: Path) -> ProjectSettings | None:
        for above in (folder, *folder.parents):
            if above not in self._by_folder:
                self._by_folder[above] = self._read(above / "pyproject.toml")
            if (found := self._by_folder[above]) is not None:
                return found
        return None

    def _read(self, file: Path) -> ProjectSettings | None:
        try:
            with open_regular(file) as stream:
                text = stream.read(_MAX_BYTES).decode(errors="replace")
        except OSError:
            return None
        if "tool.scenecc" not in text:
            return None
        try:
            table = _table(text)
            return None if table is None else _settings(table, file.parent)
        except SettingsError as error:
            self.faults.append(_fault(file, text, error))
            return ProjectSettings(file.parent)


def _table(text: str) -> dict[str, Any] | None:
    """Returns `[tool.scenecc]`; None if it is missing."""
    try:
        toml: Any = import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")
    except ImportError:
        message = "it needs a TOML parser, which Python includes since 3.11"
        raise SettingsError(message, "tool.scenecc", hint="pip install tomli") from None
    try:
        data: Any = toml.loads(text)
    except (ValueError, RecursionError) as error:
        raise SettingsError(f"this is not TOML: {error}") from None
    tool = _mapping(data.get("tool", {}), "tool")
    return _mapping(tool["scenecc"], "scenecc") if "scenecc" in tool else None


def _settings(table: dict[str, Any], folder: Path) -> ProjectSettings:
    from scenecc.diagnostics.messages import suggest

    keys: dict[str, Callable[[Any], Any]] = {
        "select": lambda given: _codes(given, "select", rules),
        "ignore": lambda given: _codes(given, "ignore", rules, may_be_error=False),
        "severity": lambda given: _severity(given, rules),
        "per-file-ignores": lambda given: {
            pattern: _codes(codes, pattern, rules, may_be_error=False)
            for pattern, codes in _mapping(given, "per-file-ignores").items()
        },
        "strict": _flag,
        "rules": lambda given: load_rules(_strings(given, "rules")),
    }
    rules: Mapping[str, Rule] = keys["rules"](table.get("rules", []))
    for key in table:
        if key not in keys:
            raise SettingsError(f"unknown key `{key}` of [tool.scenecc]", key, hint=suggest(key, keys))
    return ProjectSettings(folder, **{key.replace("-", "_"): keys[key](given) for key, given in table.items()})


def _flag(given: object) -> bool:
    if not isinstance(given, bool):
        raise SettingsError("`strict` must be true or false", "strict")
    return given


def _strings(given: object, key: str) -> tuple[str, ...]:
    if not isinstance(given, list) or not all(isinstance(one, str) for one in cast("list[object]", given)):
        raise SettingsError(f"`{key}` must be a list of strings", key)
    return tuple(cast("list[str]", given))


def _mapping(given: object, key: str) -> dict[str, Any]:
    if not isinstance(given, dict):
        raise SettingsError(f"`{key}` must be a table", key)
    return cast("dict[str, Any]", given)


def _codes(given: object, key: str, rules: Mapping[str, Rule], *, may_be_error: bool = True) -> tuple[str, ...]:
    codes = _strings(given, key)
    for code in codes:
        if reason := code_fault(code, rules, may_be_error=may_be_error):
            raise SettingsError(reason, key, code, hint="`scenecc explain` lists the codes")
    return codes


def code_fault(code: str, rules: Mapping[str, Rule] = {}, *, may_be_error: bool = True) -> str | None:
    """Returns why a text is not a code or the prefix of one; None if it is."""
    from scenecc.diagnostics.codes import CODES

    if not may_be_error and code in CODES and CODES[code].severity == "error":
        return f"{code} is an error, and errors cannot be ignored"
    is_one = _PREFIX.fullmatch(code) and any(known.startswith(code) for known in (*CODES, *rules))
    if is_one:
        return None
    from scenecc.diagnostics.reference import nearest_codes

    near = nearest_codes(code, count=1)
    return f"unknown code `{code}`; {f'did you mean {near[0]}?' if near else 'no code begins with it'}"


def _severity(given: object, rules: Mapping[str, Rule]) -> dict[str, Any]:
    table = _mapping(given, "severity")
    for code, severity in table.items():
        _codes([code], "severity", rules, may_be_error=False)
        if severity not in _SEVERITIES:
            raise SettingsError(f"the severity of {code} must be error, warning or note", "severity", code)
    return table


def load_rules(wanted: tuple[str, ...]) -> dict[str, Rule]:
    """Loads the house rules of some ids or id prefixes from installed packages.

    Raises:
        SettingsError: a rule does not exist, or cannot be loaded.
    """
    if not wanted:
        return {}
    from importlib.metadata import entry_points

    found: dict[str, Rule] = {}
    installed = sorted(entry_points(group=ENTRY_POINTS), key=lambda one: one.name)
    for prefix in wanted:
        fitting = {one.name: one for one in installed if _RULE_ID.fullmatch(one.name) and one.name.startswith(prefix)}
        if not fitting:
            hint = f"a package lists its rules as entry points of the group `{ENTRY_POINTS}`, such as ACM001"
            raise SettingsError(f"no installed package has a rule `{prefix}`", "rules", prefix, hint=hint)
        try:
            found |= {name: one.load() for name, one in fitting.items()}
        except Exception as error:  # noqa: BLE001 - third-party code
            message = f"the rules `{prefix}` cannot be loaded: {type(error).__name__}: {error}"
            raise SettingsError(message, "rules", prefix) from None
    return found


def _fault(file: Path, text: str, error: SettingsError) -> Diagnostic:
    """Returns the error at the line of the last of its words, after the header of the table."""
    from scenecc.diagnostics.diagnostic import Location

    lines = text.splitlines()
    found = re.search(r"line (\d+)", str(error)) if not error.words else None
    number = int(found[1]) - 1 if found else next((i for i, line in enumerate(lines) if "scenecc" in line), 0)
    for word in error.words:
        pattern = re.compile(rf"(?<![\w-]){re.escape(word)}(?![\w-])")
        number = next((i for i in range(number, len(lines)) if pattern.search(lines[i])), number)
    shown = relpath(file)
    line = lines[number] if number < len(lines) else ""
    made = usage_error("SC916", str(error), file=shown, hint=error.hint)
    return replace(made, location=Location(shown, number + 1, 1, len(line) + 1, line))
