"""What `validate` and `check` have in common: their options, and how findings of many files are judged and shown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from scenecc.cli.findings_cache import FindingsCache
from scenecc.cli.many_files import choose_files, find_in_each
from scenecc.cli.options import Format
from scenecc.cli.output import Status, print_err, print_findings, print_json, print_out, status
from scenecc.cli.paths import STDIN
from scenecc.cli.settings import RULE_PREFIX, SettingsFinder, code_fault

if TYPE_CHECKING:
    from scenecc.checks.house_rules import Rule
    from scenecc.cli.many_files import FileChoices
    from scenecc.cli.paths import Found
    from scenecc.diagnostics import Diagnostic
    from scenecc.source.paths import PathCache

Check = Callable[[str, "Mapping[str, Rule]", "PathCache | None"], "list[Diagnostic]"]
"""What checks a file, with house rules; it notes what it reads in the last argument."""

StrictOption = Annotated[bool, typer.Option("--strict", help="Treat warnings as errors.")]
SelectOption = Annotated[
    list[str] | None,
    typer.Option("--select", metavar="CODES", help="Report only these warnings and notes, such as SC4,SC526."),
]
IgnoreOption = Annotated[
    list[str] | None, typer.Option("--ignore", metavar="CODES", help="Do not report these warnings and notes.")
]
StatisticsOption = Annotated[bool, typer.Option("--statistics", help="Print how often each code is found.")]

_STATISTICS_FORMATS: Final = (Format.text, Format.json)


def settings_finder(select: list[str] | None, ignore: list[str] | None, *, strict: bool) -> SettingsFinder:
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
    choices: FileChoices,
    options: Any,
    check: Check,
    finder: SettingsFinder,
    *,
    form: Format,
    statistics: bool,
) -> None:
    """Checks files and prints what is found; ends with the status.

    Args:
        command: its name.
        found: the paths that were asked for.
        choices: which of the files, and how.
        options: everything that findings follow from beside the files; has a `repr` that tells all of it.
        check: checks one file.
        finder: has the settings of each.
        form: of the findings.
        statistics: print counts in place of findings.
    """
    if statistics and form not in _STATISTICS_FORMATS:
        raise typer.BadParameter("counts are printed as text or json", param_hint="'--statistics'")
    cache = FindingsCache(command, options)
    diagnostics = [*found.faults(), *choose_files(found, choices, cache)]
    settings = {file: finder.of(file) for file in found.files}

    def find(file: str) -> list[Diagnostic]:
        rules = settings[file].rules or {}
        # What rules of other packages read is not known.
        if rules or not choices.cache or file == STDIN:
            return check(file, rules, None)
        return cache.findings(file, lambda memory: check(file, rules, memory))

    worst = status(diagnostics)
    for file, here in find_in_each(found.files, choices.jobs, command, find):
        wanted = settings[file].apply(here, file)
        worst = max(worst, status(wanted, strict=settings[file].strict))
        diagnostics += wanted
    cache.prune()
    worst = max(worst, status(finder.faults), Status.fine)
    diagnostics = [*finder.faults, *diagnostics]
    if statistics:
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
