"""Findings over many scenes: each is reported once, with the scene in which it is worst."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import index_ranges

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin, RelatedPlace


@dataclass(frozen=True, slots=True)
class Finding:
    """One fault in one scene.

    Attributes:
        code: of its diagnostic.
        names: what it is about: ENTITY or ENTITY/LINK, the one where it is reported first.
        scene: index of the scene.
        amount: how bad it is: larger is worse.
        message: about this scene, without the scene.
        seed: of the draws.
    """

    code: str
    names: tuple[str, ...]
    scene: int
    amount: float
    message: str
    hint: str | None = None
    seed: int = 0


def length_text(length: float) -> str:
    """A length [m] as people say it: `4.8 mm`, `1.2 m`."""
    return f"{length:.3g} m" if length >= 1 else f"{length * 1000:.3g} mm"


def report_findings(
    findings: list[Finding], origins: Mapping[str, Origin | None], file: str | None, sink: Sink, *, several_seeds: bool
) -> None:
    """Reports each fault once: where it is worst, and in how many other scenes it is.

    Args:
        findings: of all scenes and seeds.
        origins: of the entities, by name.
        file: of the scene, to show it; None: there is none.
        sink: takes the diagnostics.
        several_seeds: whether more than one seed was checked.
    """
    alike: dict[tuple[str, tuple[str, ...]], list[Finding]] = {}
    for finding in findings:
        alike.setdefault((finding.code, finding.names), []).append(finding)
    for (code, names), group in alike.items():
        worst = max(group, key=lambda one: one.amount)
        places = [_origin_of(name, origins) for name in names]
        others: list[RelatedPlace] = [
            (f"`{name}` is here", place, "key")
            for name, place in zip(names[1:], places[1:], strict=True)
            if place is not None and place != places[0]
        ]
        show = f"`scenecc view {file} --seed {worst.seed} --scene {worst.scene}` shows it" if file else None
        sink.report(
            code,
            f"{worst.message}, {_where(worst, group, several_seeds=several_seeds)}",
            places[0] or Location(None),
            at="key",
            hint="; ".join(text for text in (worst.hint, show) if text) or None,
            related=others,
        )


def _where(worst: Finding, group: list[Finding], *, several_seeds: bool) -> str:
    found = {(one.seed, one.scene) for one in group}
    one = f"scene {worst.scene}" + (f" with seed {worst.seed}" if several_seeds else "")
    if len(found) == 1:
        return f"in {one}"
    scenes = f"{len(found)} scenes" if several_seeds else f"scenes {index_ranges(sorted({i for _, i in found}))}"
    return f"in {scenes}; worst in {one}"


def _origin_of(name: str, origins: Mapping[str, Origin | None]) -> Origin | None:
    """The origin of an entity, also of ENTITY/LINK: that of the longest entity that the name begins with."""
    while name not in origins and "/" in name:
        name = name.rpartition("/")[0]
    return origins.get(name)
