"""A plan from its JSON, which may come from a stranger: every field is checked, every fault is reported."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeGuard

from scenecc.diagnostics import Location, Origin, Sink
from scenecc.plan.decode import Decoder
from scenecc.plan.decode_numbers import is_object
from scenecc.plan.json_object import RepeatedKeyError, json_object
from scenecc.plan.scene import ScenePlan
from scenecc.plan.to_json import PLAN_VERSION

Resolver = Callable[[str, Origin], Path | None]
"""Finds the file that a uri names; where it cannot, it reports why and returns None."""


@dataclass(frozen=True, slots=True)
class PlanLimits:
    """What the JSON of a plan may ask for.

    Attributes:
        characters: of text.
        scenes: `num_scenes`.
        objects: entities, each counted as often as it has shapes, summed over the scenes that they are in.
    """

    characters: int = 512 * 2**20
    scenes: int = 65_536
    objects: int = 10_000_000


def plan_from_json(
    text: str,
    *,
    base: Path,
    sink: Sink,
    resolve: Resolver | None = None,
    file: str | None = None,
    limits: PlanLimits | None = None,
) -> ScenePlan | None:
    """Reads what `plan_to_json` wrote; None if anything is wrong, which `sink` then tells.

    Ranges of single values are checked here. Rules over several values (friction order, the inertia's triangle) are
    checks on the plan, and so is whether files exist unless `resolve` asks for it.

    Args:
        text: the JSON.
        base: folder that relative uris start from.
        sink: takes diagnostics of band 7 and those of `resolve`.
        resolve: asked for every uri of the table of files; without it relative uris are joined to `base` and
            `pkg://` and `asset://` are errors.
        file: name of the document for diagnostics, and for the origins in the plan.
        limits: None takes the defaults of `PlanLimits`.
    """
    bounds = limits if limits is not None else PlanLimits()
    if len(text) > bounds.characters:
        message = f"the plan has {len(text)} characters, more than {bounds.characters}"
        sink.report("SC712", message, Location(file))
        return None
    data = _parse(text, sink, file)
    if data is _UNREAD or not _is_plan(data, sink, Origin(file)):
        return None
    del data["scenecc_plan"]
    decoder = Decoder(sink, file, bounds.scenes, bounds.objects, resolve or _Beside(base, sink).resolve)
    plan = decoder.plan(data)
    return plan if isinstance(plan, ScenePlan) else None


_UNREAD: Final = object()


def _parse(text: str, sink: Sink, file: str | None) -> object:
    try:
        return json.loads(text.removeprefix("\ufeff"), object_pairs_hook=json_object)
    except json.JSONDecodeError as error:
        lines = text.splitlines()
        line = lines[error.lineno - 1] if error.lineno <= len(lines) else None
        place = Location(file, error.lineno, error.colno, error.colno + 1, line)
        sink.report("SC701", f"this is not JSON: {error.msg}", place)
    except RepeatedKeyError as error:
        sink.report("SC713", f"the key {error} stands twice in one object", Location(file))
    except RecursionError:
        sink.report("SC712", "the plan is nested too deeply", Location(file))
    except ValueError:  # an integer of more digits than Python reads
        sink.report("SC701", "the plan holds a number with thousands of digits", Location(file))
    return _UNREAD


def _is_plan(data: object, sink: Sink, origin: Origin) -> TypeGuard[dict[str, Any]]:
    if not is_object(data) or "scenecc_plan" not in data:
        sink.report("SC702", "this is not a plan: it has no key `scenecc_plan`", origin)
        return False
    version: object = data["scenecc_plan"]
    if type(version) is int and version in (1, PLAN_VERSION):
        return True
    message = f"this plan has version {_shown(version)}; versions 1 and {PLAN_VERSION} are read here"
    sink.report("SC702", message, origin.child("scenecc_plan"))
    return False


def _shown(item: object) -> str:
    text = json.dumps(item)
    return text if len(text) <= 40 else text[:40] + "…"


@dataclass(frozen=True, slots=True)
class _Beside:
    """Finds relative uris only."""

    base: Path
    sink: Sink

    def resolve(self, uri: str, origin: Origin) -> Path | None:
        if "://" not in uri and "\0" not in uri:
            return self.base.absolute() / uri
        self.sink.report("SC711", f"nothing here can find `{uri[:200]}`", origin)
        return None
