"""House rules: a team's own functions that check a plan and report warnings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Protocol

from scenecc.diagnostics.diagnostic import Location, Origin, report_unused

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan


class HasOrigin(Protocol):
    """A part of a plan with an origin: an entity, a light, a joint."""

    @property
    def origin(self) -> Origin | None:
        """Its node in the file, if any."""
        ...


class Report(Protocol):
    """Callback with which a rule reports a warning."""

    def __call__(self, message: str, part: HasOrigin | None = None, *keys: str | int, hint: str | None = None) -> None:
        """Reports a warning.

        Args:
            message: one sentence about this scene.
            part: part of the plan; None: the whole plan.
            keys: keys below it, as in the file: `"mass"`.
            hint: how to fix it.
        """
        ...


Rule = Callable[["ScenePlan", Report], None]
"""A rule: it checks a plan, and reports."""


def run_rules(plan: ScenePlan, rules: Mapping[str, Rule], file: str | None, sink: Sink) -> None:
    """Runs rules over a plan.

    Args:
        plan: a plan with its draws.
        rules: rules by id, which is the code of their warnings.
        file: the checked file.
        sink: collects the warnings, and an error (SC917) for a rule that raises.
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
        except Exception as error:  # noqa: BLE001, PERF203 - third-party code
            message = f"the rule {code} failed: {type(error).__name__}: {error}"
            sink.report("SC917", message, plan.origin or Location(file), hint="this is a bug in the rule's package")
    report_unused(sink, file, rules.__contains__)
