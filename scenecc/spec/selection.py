"""`scene_idxs` to scene indices."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink

_SLICE = re.compile(r"^\s*(-?[0-9]{0,9})\s*:\s*(-?[0-9]{0,9})\s*(?::\s*(-?[0-9]{0,9})\s*)?$")


def select(given: str | list[int | str] | None, num_scenes: int, origin: Origin, sink: Sink) -> tuple[int, ...] | None:
    """Scene indices, ascending; None where the selection was reported.

    Args:
        given: as written; None selects every scene.
        num_scenes: how many there are.
        origin: of the `scene_idxs` key's value.
        sink: takes the diagnostics.
    """
    if given is None:
        return tuple(range(num_scenes))
    first: dict[int, Origin] = {}
    failed = False
    # Of more items than scenes one repeats another or is wrong: what follows tells no more.
    for i, item in enumerate([given] if isinstance(given, str) else given[: num_scenes + 1]):
        place = origin if isinstance(given, str) else origin.child(i)
        indices = _indices(item, num_scenes, place, sink)
        if indices is None:
            failed = True
            continue
        for index in indices:
            if index in first:
                failed = True
                before = first[index]
                message = f"scene {index} is selected twice"
                sink.report("SC308", message, place, related=[("selected here already", before, "value")])
                break
            first[index] = place
    if not first and not failed:
        sink.report("SC309", "this selects no scene", origin, hint="leave `scene_idxs` out to select every scene")
    return None if failed or not first else tuple(sorted(first))


def count(given: str | list[int | str] | None, num_scenes: int) -> int:
    """How many scenes `select` would select, at most; wrong items, which it reports, may count."""
    if given is None:
        return num_scenes
    items = [given] if isinstance(given, str) else given[:num_scenes]
    return min(num_scenes, sum(1 if isinstance(item, int) else _length(item, num_scenes) for item in items))


def _length(text: str, num_scenes: int) -> int:
    match = _SLICE.match(text)
    if match is None:
        return 0
    start, stop, step = (int(part) if part else None for part in match.groups())
    return 0 if step == 0 else len(range(num_scenes)[start:stop:step])


def _indices(item: int | str, num_scenes: int, place: Origin, sink: Sink) -> range | None:
    if isinstance(item, int):
        if 0 <= item < num_scenes:
            return range(item, item + 1)
        _out_of_range(item, num_scenes, place, sink)
        return None
    match = _SLICE.match(item)
    if match is None or match[3] in {"0", "-0"} or (match[3] and int(match[3]) == 0):
        sink.report(
            "SC310", f"{item[:60]!r} is not a slice", place, hint='write a number, "start:stop" or "start:stop:step"'
        )
        return None
    start, stop, step = (int(part) if part else None for part in match.groups())
    for bound in (start, stop):
        # Python's slices clip; here a bound beyond the scenes is a mistake (stop may be one past the last).
        if bound is not None and not -num_scenes <= bound <= num_scenes:
            _out_of_range(bound, num_scenes, place, sink)
            return None
    indices = range(num_scenes)[start:stop:step]
    if not indices:
        sink.report("SC309", f"{item[:60]!r} selects none of the {num_scenes} scenes", place)
        return None
    return indices


def _out_of_range(index: int, num_scenes: int, place: Origin, sink: Sink) -> None:
    scenes = "the only scene is 0" if num_scenes == 1 else f"scenes are 0 to {num_scenes - 1}"
    sink.report(
        "SC307",
        f"there is no scene {index}: {scenes}",
        place,
        hint="raise `num_scenes` in the file, or on the command line with --num-scenes",
    )
