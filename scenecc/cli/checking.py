"""The options that `validate` and `check` share, and how findings of many files are filtered and printed."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, NoReturn

import typer

from scenecc.cli.completion import complete_code
from scenecc.cli.many_files import ChangedSince, Jobs, Shard, choose_files, find_in_each
from scenecc.cli.options import Format
from scenecc.cli.output import Status, print_findings, print_json, print_note, print_out, status
from scenecc.cli.paths import STDIN, Found
from scenecc.cli.settings import RULE_PREFIX, SettingsFinder, code_fault
from scenecc.files import open_regular

if TYPE_CHECKING:
    from scenecc.checks.house_rules import Rule
    from scenecc.diagnostics import Diagnostic
    from scenecc.simulation.summary import Checked
    from scenecc.source.paths import PathCache

Check = Callable[[str, "Mapping[str, Rule]", "PathCache | None"], "Checked"]
"""Checks a file with house rules, and records the files that it reads in the last argument."""

ScenesOnly = Annotated[
    bool, typer.Option("--scenes-only", help="Skip named files that are not scenes (for commit hooks).")
]
_Cache = Annotated[
    bool, typer.Option("--cache/--no-cache", help="Reuse earlier findings for files that did not change.")
]
_Strict = Annotated[bool, typer.Option("--strict", help="Treat warnings as errors.")]
_Select = Annotated[
    list[str] | None,
    typer.Option(
        "--select",
        metavar="CODES",
        help="Report only these warnings and notes, such as SC4,SC526.",
        autocompletion=complete_code,
    ),
]
_Ignore = Annotated[
    list[str] | None,
    typer.Option(
        "--ignore", metavar="CODES", help="Do not report these warnings and notes.", autocompletion=complete_code
    ),
]
_Statistics = Annotated[bool, typer.Option("--statistics", help="Print how often each code is found.")]

CHECK_OPTIONS: Final[dict[str, tuple[Any, Any]]] = {
    "jobs": (Jobs, None),
    "shard": (Shard, None),
    "changed_since": (ChangedSince, None),
    "cache": (_Cache, True),
    "strict": (_Strict, False),
    "select": (_Select, None),
    "ignore": (_Ignore, None),
    "statistics": (_Statistics, False),
}
"""Options of all commands that check files: name → (option, default)."""

_STATISTICS_FORMATS: Final = ("text", "json")


def _settings_finder(select: list[str] | None, ignore: list[str] | None, *, strict: bool) -> SettingsFinder:
    """Returns the settings of a command line. Raises typer.BadParameter for an unknown code."""
    wanted = None if select is None else _codes(select, "'--select'", may_be_error=True)
    return SettingsFinder(wanted, _codes(ignore or [], "'--ignore'", may_be_error=False), strict=strict)


def _codes(given: list[str], option: str, *, may_be_error: bool) -> tuple[str, ...]:
    codes = tuple(code.strip() for item in given for code in item.split(","))
    for code in codes:
        reason = code_fault(code, may_be_error=may_be_error)
        # The packages of house rules are known only after the settings of a file are read.
        if reason and not RULE_PREFIX.fullmatch(code):
            raise typer.BadParameter(reason, param_hint=option)
    return codes


def run_checks(
    command: str,
    found: Found,
    asked: Mapping[str, Any],
    options: Any,
    check: Check,
    *,
    form: Format,
    corrections: Sequence[Diagnostic] | None = None,
) -> NoReturn:
    """Checks files, prints the findings, and exits with the status.

    Args:
        command: name of the command.
        found: the files to check.
        asked: the values of `CHECK_OPTIONS`.
        options: everything else that findings depend on. Its `repr` must be complete.
        check: checks one file.
        form: format of the findings.
        corrections: list to which `check` appends its corrections; None: it makes none.
    """
    if asked["statistics"] and form not in _STATISTICS_FORMATS:
        raise typer.BadParameter("counts can be printed only as text or json", param_hint="'--statistics'")
    finder = _settings_finder(asked["select"], asked["ignore"], strict=asked["strict"])
    from scenecc.cli.findings_cache import FindingsCache

    cache = FindingsCache(command, options)
    parts = Parts(found.files)
    diagnostics = [*found.faults(), *choose_files(found, asked["changed_since"], asked["shard"], cache.files_of)]
    settings = {file: finder.of(file) for file in found.files}

    def find(file: str) -> Checked:
        rules = settings[file].rules or {}
        # It is not known which files the rules of other packages read.
        if rules or not asked["cache"] or file == STDIN:
            return check(file, rules, None)
        return cache.findings(file, lambda memory: check(file, rules, memory))

    worst = status(diagnostics)
    results: dict[str, Checked] = {}
    for file, here in find_in_each(found.files, asked["jobs"] or 0, command, find):
        wanted = settings[file].apply(parts.without_lacks(file, here.diagnostics), file)
        results[file] = here
        worst = max(worst, status(wanted, strict=settings[file].strict))
        diagnostics += wanted
    worst = max(worst, status(finder.faults), Status.fine)
    diagnostics = [*finder.faults, *diagnostics]
    if asked["statistics"]:
        counts = Counter((one.code, one.severity) for one in diagnostics)
        if form == "json":
            print_json({"statistics": statistics(counts)}, diagnostics)
        else:
            print_statistics(counts)
    else:
        listed = {file: _simulated_data(one) for file, one in results.items()} if command == "check" else None
        strict = [file for file, one in settings.items() if one.strict]
        print_findings(diagnostics, form, files=found.files, corrections=corrections, simulated=listed, strict=strict)
    if form == "text":
        of_engine = f"; {_simulated_text(list(results.values()))}" if command == "check" and results else ""
        print_note(f"{found.counts()}{of_engine}\n")
    raise typer.Exit(worst)


def _simulated_data(file: Checked) -> dict[str, object] | None:
    """Returns what was simulated of a file for programs."""
    return None if file.simulated is None else {**asdict(file.simulated), "cached": file.cached}


def _simulated_text(files: Sequence[Checked]) -> str:
    """Returns what was simulated of all files: `4 scenes, seed 7, 1 s simulated, from the cache`."""
    from scenecc.diagnostics.messages import index_ranges

    found = [one.simulated for one in files if one.simulated is not None]
    scenes = sum(one.scenes for one in found)
    cached = sum(one.cached for one in files)
    origin = (
        ""
        if not cached
        else ", from the cache"
        if cached == len(files)
        else f", {cached} of {len(files)} files from the cache"
    )
    if not scenes:
        return f"nothing simulated{origin}"
    seeds = sorted({seed for one in found for seed in one.seeds})
    several = f"seeds {index_ranges(seeds)}" if len(seeds) > 1 else f"seed {seeds[0]}"
    times = sorted({one.seconds for one in found})
    time = f"{times[0]:g} to {times[-1]:g} s" if len(times) > 1 else f"{times[0]:g} s" if times[0] else "1 step"
    permuted = " and permuted" if any(one.permuted for one in found) else ""
    return f"{scenes} scene{'' if scenes == 1 else 's'}, {several}, {time} simulated{permuted}{origin}"


def print_statistics(counts: Counter[tuple[str, str]]) -> None:
    """Prints how often each code was found, the most frequent first. `counts`: by code and severity."""
    rows = statistics(counts)
    width = max((len(str(row["count"])) for row in rows), default=0)
    print_out("".join("{count:>{w}}  {code}  {severity:<7}  {title}\n".format(w=width, **row) for row in rows))


def statistics(counts: Mapping[tuple[str, str], int]) -> list[dict[str, Any]]:
    """Returns the same counts as rows with titles."""
    from scenecc.diagnostics.codes import CODES

    return [
        {"count": count, "code": code, "severity": severity, "title": CODES[code].title if code in CODES else ""}
        for (code, severity), count in sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    ]


_OF_SCENES: Final = frozenset({"SC543", "SC852"})
"""Codes of things that a part lacks and its users supply: bodies, and a surface below them."""

_NAME: Final = re.compile(r"[^\s\"'\[\]{},:#]+\.ya?ml\b")
_COMMENT: Final = re.compile(r"(?:^|\s)#.*")


class Parts:
    """Finds which of several files are parts of others.

    Args:
        files: all files of the command.
    """

    def __init__(self, files: Sequence[str]) -> None:
        self._files = tuple(files)

    def without_lacks(self, file: str, found: list[Diagnostic]) -> list[Diagnostic]:
        """Returns the findings of a file. For a part, those that arise only because it is checked separately are
        removed.
        """
        if _OF_SCENES.isdisjoint(one.code for one in found) or file not in self:
            return found
        return without_lacks(found)

    def __contains__(self, file: str) -> bool:
        return Path(file).resolve() in self._find_files

    @cached_property
    def _find_files(self) -> frozenset[Path]:
        """Returns every file that a text names. Names made by expressions are not known."""
        used: set[Path] = set()
        for file in self._files:
            with suppress(OSError), open_regular(file) as stream:
                data = stream.read()
                if b"\0" in data:
                    continue  # a pack, which uses no outside files
                text = _COMMENT.sub("", data.decode(errors="replace"))
                named = {Path(file).parent.joinpath(name).resolve() for name in _NAME.findall(text)}
                used |= named - {Path(file).resolve()}
        return frozenset(used)


def without_lacks(found: list[Diagnostic]) -> list[Diagnostic]:
    """Returns the findings of a part without those that arise only because it is checked separately."""
    return [one for one in found if one.code not in _OF_SCENES]
