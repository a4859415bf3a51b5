"""The plan's own JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.plan.json_writer import plan_to_json

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan


def write(plan: ScenePlan, sink: Sink, base: Path | None) -> str | None:
    """Canonical JSON; every plan can be written."""
    del sink
    return plan_to_json(plan, base=base)
