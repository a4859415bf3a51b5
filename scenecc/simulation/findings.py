"""Findings over many scenes. Each is reported once, for the scene where it is worst."""

from __future__ import annotations

import json
import math
import shlex
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import index_ranges
from scenecc.source import Limits
from scenecc.source.paths import asset_roots

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin, RelatedPlace
    from scenecc.options import Options


@dataclass(frozen=True, slots=True)
class Finding:
    """One fault in one scene.

    Attributes:
        code: code of its diagnostic.
        names: what it concerns: ENTITY or ENTITY/LINK; it is reported at the first.
        scene: index of the scene.
        amount: severity; larger is worse.
        message: message without the scene.
        seed: seed of the draws.
        span: the faulty part of an expression.
    """

    code: str
    names: tuple[str, ...]
    scene: int
    amount: float
    message: str
    hint: str | None = None
    seed: int = 0
    span: tuple[int, int] | None = None


def length_text(length: float) -> str:
    """Returns a length [m] with a readable unit: `4.8 mm`, `1.2 m`."""
    return f"{length:.3g} m" if length >= 1 else f"{length * 1000:.3g} mm"


def amount_text(way: float, *, slides: bool) -> str:
    """Returns a movement of a joint [m] or [rad] as text: `4.8 mm`, `12°`."""
    return length_text(way) if slides else f"{math.degrees(way):.3g}°"


def view_command(file: str, options: Options) -> str | None:
    """Returns the command that shows a checked scene, without seed and scene; None if no command can express the
    options.
    """
    if options.draws:
        return None
    command = ["scenecc", "view", file]
    try:
        for name, value in options.params.items():
            command += ["--set", f"{name}={json.dumps(value, ensure_ascii=False, allow_nan=False)}"]
    except (TypeError, ValueError):  # a Python object, or an infinite number
        return None
    if options.num_scenes is not None:
        command += ["--num-scenes", str(options.num_scenes)]
    of_environment = {*asset_roots(())}
    for folder in options.asset_roots:
        command += [] if folder in of_environment else ["--asset-root", str(folder)]
    if options.starts is not None:
        command += ["--starts", str(options.starts)]
    if options.allow_outside_assets:
        command.append("--allow-outside-assets")
    for name, limit in sorted(asdict(options.limits).items() - asdict(Limits()).items()):
        command += ["--limit", f"{name}={limit}"]
    return shlex.join(command)


def report_findings(
    findings: list[Finding],
    origins: Mapping[str, Origin | None],
    command: str | None,
    sink: Sink,
    *,
    several_seeds: bool,
) -> None:
    """Reports each fault once: where it is worst, and in how many other scenes it occurs.

    Args:
        findings: findings of all scenes and seeds.
        origins: origins of the entities, by name.
        command: the result of `view_command`.
        sink: collects diagnostics.
        several_seeds: whether more than one seed was checked.
    """
    alike: dict[tuple[str, tuple[str, ...]], list[Finding]] = {}
    for finding in findings:
        alike.setdefault((finding.code, finding.names), []).append(finding)
    for (code, names), group in alike.items():
        worst = max(group, key=lambda one: one.amount)
        places = [origin_of(name, origins) for name in names]
        others: list[RelatedPlace] = [
            (f"`{name}` is here", place, "key")
            for name, place in zip(names[1:], places[1:], strict=True)
            if place is not None and place != places[0]
        ]
        show = f"`{command} --seed {worst.seed} --scene {worst.scene}` shows it" if command else None
        sink.report(
            code,
            f"{worst.message}, {_where(worst, group, several_seeds=several_seeds)}",
            places[0] or Location(None),
            at="key" if worst.span is None else "value",
            hint="; ".join(text for text in (worst.hint, show) if text) or None,
            related=others,
            span=worst.span,
        )


def _where(worst: Finding, group: list[Finding], *, several_seeds: bool) -> str:
    found = {(one.seed, one.scene) for one in group}
    one = f"scene {worst.scene}" + (f" with seed {worst.seed}" if several_seeds else "")
    if len(found) == 1:
        return f"in {one}"
    scenes = f"{len(found)} scenes" if several_seeds else f"scenes {index_ranges(sorted({i for _, i in found}))}"
    word = "worst" if any(other.amount < worst.amount for other in group) else "such as"
    return f"in {scenes}; {word} in {one}"


def origin_of(name: str, origins: Mapping[str, Origin | None]) -> Origin | None:
    """Returns the origin of an entity or ENTITY/LINK, by the longest entity name that matches."""
    while name not in origins and "/" in name:
        name = name.rpartition("/")[0]
    return origins.get(name)
