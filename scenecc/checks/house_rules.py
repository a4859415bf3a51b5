"""Rules of a team's own over a plan: functions that report."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Protocol

from scenecc.diagnostics.diagnostic import Location, Origin, report_unused

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan


class HasOrigin(Protocol):
    """A part of a plan that knows where it is written: an entity, a light, a joint."""

    @property
    def origin(self) -> Origin | None:
        """The node of the file; None where there is none."""
        ...


class Report(Protocol):
    """Reports a warning of a rule."""

    def __call__(self, message: str, part: HasOrigin | None = None, *keys: str | int, hint: str | None = None) -> None:
        """Reports one.

        Args:
            message: one sentence about this scene.
            part: of the plan; None: the plan as a whole.
            keys: below it, as in the file: `"mass"`.
            hint: what to do.
        """
        ...


Rule = Callable[["ScenePlan", Report], None]
"""A rule: it looks at a plan, and reports."""


def run_rules(plan: ScenePlan, rules: Mapping[str, Rule], file: str | None, sink: Sink) -> None:
    """Runs rules over a plan.

    Args:
        plan: with its draws.
        rules: by id, which is the code of what they report.
        file: that is checked.
        sink: takes the warnings, and an error (SC917) for a rule that fails.
    """

    def report_as(code: str) -> Report:
        def report(message: str, part: HasOrigin | None = None, *keys: str | int, hint: str | None = None) -> None:
            origin = (plan if part is None else part).origin
            place = Location(file) if origin is None else origin.child(*keys)
            sink.report(code, message, place, at="key", hint=hint, severity="warning")

        return report

    for code, rule in rules.items():
        try:
            rule(plan, report_as(code))
        except Exception as error:  # noqa: BLE001, PERF203 - code of somebody else
            message = f"the rule {code} failed: {type(error).__name__}: {error}"
            sink.report("SC917", message, plan.origin or Location(file), hint="this is a fault of the rule's package")
    report_unused(sink, file, rules.__contains__)
