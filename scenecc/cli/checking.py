"""What `validate` and `check` have in common: their options, and how findings of many files are judged and shown."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from scenecc.cli.findings_cache import FindingsCache
from scenecc.cli.many_files import choose_files, find_in_each
from scenecc.cli.options import Format, at_least, shown
from scenecc.cli.output import Status, print_err, print_findings, print_json, print_out, status
from scenecc.cli.paths import STDIN
from scenecc.cli.settings import RULE_PREFIX, SettingsFinder, code_fault

if TYPE_CHECKING:
    from scenecc.checks.house_rules import Rule
    from scenecc.cli.paths import Found
    from scenecc.diagnostics import Diagnostic
    from scenecc.source.paths import PathCache

Check = Callable[[str, "Mapping[str, Rule]", "PathCache | None"], "list[Diagnostic]"]
"""What checks a file, with house rules; it notes what it reads in the last argument."""

_SHARD: Final = re.compile(r"([0-9]{1,6})/([0-9]{1,6})")


def _parse_shard(text: str | tuple[int, int]) -> tuple[int, int]:
    """`2/5` as (2, 5): the second of five parts."""
    found = _SHARD.fullmatch(str(text))
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise typer.BadParameter(f"{shown(str(text))} is not I/N with I from 1 to N, as in 2/5")
    return int(found[1]), int(found[2])


_Jobs = Annotated[
    int | None,
    typer.Option("--jobs", metavar="N", parser=at_least(1), help="Number of processes.", show_default="one"),
]
_Shard = Annotated[
    Any, typer.Option("--shard", metavar="I/N", parser=_parse_shard, help="Take only part I of N of the files.")
]
_ChangedSince = Annotated[
    str | None,
    typer.Option("--changed-since", metavar="REV", help="Take only scenes that changed since a revision of git."),
]
_Cache = Annotated[
    bool, typer.Option("--cache/--no-cache", help="Take over what was found before in files that did not change.")
]
_Strict = Annotated[bool, typer.Option("--strict", help="Treat warnings as errors.")]
_Select = Annotated[
    list[str] | None,
    typer.Option("--select", metavar="CODES", help="Report only these warnings and notes, such as SC4,SC526."),
]
_Ignore = Annotated[
    list[str] | None, typer.Option("--ignore", metavar="CODES", help="Do not report these warnings and notes.")
]
_Statistics = Annotated[bool, typer.Option("--statistics", help="Print how often each code is found.")]

CHECK_OPTIONS: Final[dict[str, tuple[Any, Any]]] = {
    "jobs": (_Jobs, None),
    "shard": (_Shard, None),
    "changed_since": (_ChangedSince, None),
    "cache": (_Cache, True),
    "strict": (_Strict, False),
    "select": (_Select, None),
    "ignore": (_Ignore, None),
    "statistics": (_Statistics, False),
}
"""Options of every command that checks files, by name: the option and its default."""

_STATISTICS_FORMATS: Final = (Format.text, Format.json)


def _settings_finder(select: list[str] | None, ignore: list[str] | None, *, strict: bool) -> SettingsFinder:
    """The settings of a command line.

    Raises:
        typer.BadParameter: one of them is no code.
    """
    wanted = None if select is None else _codes(select, "'--select'", may_be_error=True)
    return SettingsFinder(wanted, _codes(ignore or [], "'--ignore'", may_be_error=False), strict=strict)


def _codes(given: list[str], option: str, *, may_be_error: bool) -> tuple[str, ...]:
    codes = tuple(code.strip() for item in given for code in item.split(","))
    for code in codes:
        reason = code_fault(code, may_be_error=may_be_error)
        # A house rule's package is known only where a file names it.
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
) -> None:
    """Checks files and prints what is found; ends with the status.

    Args:
        command: its name.
        found: the paths that were asked for.
        asked: what was chosen of `CHECK_OPTIONS`.
        options: everything that findings follow from beside the files; has a `repr` that tells all of it.
        check: checks one file.
        form: of the findings.
    """
    if asked["statistics"] and form not in _STATISTICS_FORMATS:
        raise typer.BadParameter("counts are printed as text or json", param_hint="'--statistics'")
    finder = _settings_finder(asked["select"], asked["ignore"], strict=asked["strict"])
    cache = FindingsCache(command, options)
    diagnostics = [*found.faults(), *choose_files(found, asked["changed_since"], asked["shard"], cache)]
    settings = {file: finder.of(file) for file in found.files}

    def find(file: str) -> list[Diagnostic]:
        rules = settings[file].rules or {}
        # What rules of other packages read is not known.
        if rules or not asked["cache"] or file == STDIN:
            return check(file, rules, None)
        return cache.findings(file, lambda memory: check(file, rules, memory))

    worst = status(diagnostics)
    for file, here in find_in_each(found.files, asked["jobs"] or 0, command, find):
        wanted = settings[file].apply(here, file)
        worst = max(worst, status(wanted, strict=settings[file].strict))
        diagnostics += wanted
    cache.prune()
    worst = max(worst, status(finder.faults), Status.fine)
    diagnostics = [*finder.faults, *diagnostics]
    if asked["statistics"]:
        _print_statistics(diagnostics, form)
    else:
        print_findings(diagnostics, form, files=found.files)
    if form is Format.text:
        print_err(found.counts())
    raise typer.Exit(worst)


def _print_statistics(diagnostics: list[Diagnostic], form: Format) -> None:
    """How often each code is found, the most frequent first."""
    from scenecc.diagnostics.codes import CODES

    counts = Counter((one.code, one.severity) for one in diagnostics)
    rows = [
        {"count": count, "code": code, "severity": severity, "title": CODES[code].title if code in CODES else ""}
        for (code, severity), count in sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    ]
    if form is Format.json:
        print_json({"statistics": rows})
        return
    width = max((len(str(row["count"])) for row in rows), default=0)
    print_out("".join("{count:>{w}}  {code}  {severity:<7}  {title}\n".format(w=width, **row) for row in rows))
