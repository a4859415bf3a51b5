"""The description of a scene as text for people."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

_FOLDED: Final = 4
"""Minimum number of copies that share an entry."""

_NUMBER: Final = re.compile(r"\d+")

_VERBS: Final = (
    ("is_in", "in"),
    ("hangs_on", "suspended from"),
    ("attached_to", "attached to"),
    ("touches", "touches"),
    ("overlaps", "overlaps"),
    ("carries", "carries"),
)
"""Relations and their words, in order, after `on`."""

_MOST: Final = 8
"""Maximum number of names in a list."""

Object = Mapping[str, Any]


def description_text(data: Mapping[str, Any]) -> str:
    """Returns the text of a description: two or three lines per object. At least four copies share an entry."""
    objects: Sequence[Object] = data["objects"]
    lines = list(_head(data))
    for group in _groups(objects):
        lines += _entry(group, data["file"])
    return "\n".join(lines) + "\n"


def _head(data: Mapping[str, Any]) -> Iterator[str]:
    count = len(data["objects"])
    yield (
        f"{data['name'] or 'scene'}, scene {data['scene']} of {data['num_scenes']}, seed {data['seed']}: "
        f"{count} object{'s' * (count != 1)}"
    )
    if data["description"]:
        yield data["description"].partition("\n")[0]
    up = " ".join(f"{one:g}" for one in data["up"])
    axis = "z is up" if data["up"] == [0, 0, 1] else f"up is ({up})"
    yield f"Lengths in m; {axis}; `on`, `in` and `touches` mean a gap of at most {1000 * data['touch_m']:g} mm."
    yield ""


def _groups(objects: Sequence[Object]) -> list[list[Object]]:
    """Returns the objects that share an entry: those whose names differ only by numbers, of one kind and place."""
    alike: dict[tuple[Any, ...], list[Object]] = {}
    for one in objects:
        key = _NUMBER.sub("#", one["name"]), one["kind"], one["file"], one["line"], one["falls"]
        alike.setdefault(key, []).append(one)
    found: list[list[Object]] = []
    for group in alike.values():
        found += [group] if len(group) >= _FOLDED else [[one] for one in group]
    order = {one["name"]: number for number, one in enumerate(objects)}
    return sorted(found, key=lambda group: order[group[0]["name"]])


def _entry(group: Sequence[Object], file: str | None) -> Iterator[str]:
    first = group[0]
    name = first["name"] if len(group) == 1 else f"{first['name']} … {group[-1]['name']} ({len(group)})"
    facts = [
        "visual only" if first["kind"] == "visual" else first["kind"],
        _place(first, file),
        _sizes([one["size_m"] for one in group if one["size_m"]]),
        _range([one["mass_kg"] for one in group if one["mass_kg"] is not None], " kg"),
    ]
    yield f"{name}: {', '.join(filter(None, facts))}"
    yield f"  {'; '.join(filter(None, [_where(group), *_relations(group)]))}"


def _place(one: Object, file: str | None) -> str:
    if one["line"] is None:
        return ""
    return f"line {one['line']}" if one["file"] == file else f"{one['file']}:{one['line']}"


def _where(group: Sequence[Object]) -> str:
    if len(group) == 1 and group[0]["plane_height_m"] is not None:
        return f"a plane at z = {_number(group[0]['plane_height_m'])}"
    place = ", ".join(_range([one["position_m"][axis] for one in group]) for axis in range(3))
    boxes = [one["box_m"] for one in group if one["box_m"]]
    low, high = (
        _range([pick(one[end][2] for one in boxes)]) if boxes else "" for end, pick in (("low", min), ("high", max))
    )
    heights = f", z from {low} to {high}" if boxes else ""
    return f"at ({place}){_turn(group)}{heights}"


def _turn(group: Sequence[Object]) -> str:
    """Returns the rotation in words."""
    if len(group) > 1:
        return ", turned" if any(any(abs(angle) > 0.05 for angle in one["rpy_deg"]) for one in group) else ""
    words = [
        f"{name} {angle:.3g}°"
        for name, angle in zip(("roll", "pitch", "yaw"), group[0]["rpy_deg"], strict=True)
        if abs(angle) > 0.05
    ]
    return f", {', '.join(words)}" if words else ""


def _relations(group: Sequence[Object]) -> Iterator[str]:
    yield _related("on", group, [[name for name in one["stands_on"] if name not in one["is_in"]] for one in group])
    for key, verb in _VERBS:
        listed = [one[key] for one in group]
        if key == "attached_to":
            listed = [[name for name in one[key] if name not in one["hangs_on"]] for one in group]
        if key == "overlaps":
            shown = [[f"{each['name']} by {_length(each['depth_m'])}" for each in one[key]] for one in group]
            listed = shown if len(group) == 1 else [[each["name"] for each in one[key]] for one in group]
        yield _related(verb, group, listed)
    above = [one["above"] for one in group if one["above"]]
    gaps = [one["gap_m"] for one in above]
    if above:
        names = _counted([[one["name"]] for one in above], len(group))
        verb = "floats" if group[0]["falls"] else "is"
        yield f"{verb} {_lengths(gaps)} above {names}"
    if group[0]["falls"]:
        rests = all(one["stands_on"] or one["hangs_on"] for one in group)
        yield "and falls with it" if rests else "nothing holds it"


def _related(verb: str, group: Sequence[Object], listed: Sequence[Sequence[str]]) -> str:
    return f"{verb} {_counted(listed, len(group))}" if any(listed) else ""


def _counted(listed: Sequence[Sequence[str]], count: int) -> str:
    """Returns names; for several objects, with the number of objects that each is related to."""
    if count == 1:
        return _names(listed[0])
    counts = Counter(name for names in listed for name in {_NUMBER.sub("#", one) for one in names})
    return _names([name if number == count else f"{name} ({number})" for name, number in counts.most_common()])


def _names(names: Sequence[str]) -> str:
    """Returns a list of names, with copies folded."""
    alike: dict[str, list[str]] = {}
    for name in names:
        alike.setdefault(_NUMBER.sub("#", name.partition(" ")[0]), []).append(name)
    shown = [
        text
        for found in alike.values()
        for text in ([f"{found[0]} … {found[-1]} ({len(found)})"] if len(found) >= _FOLDED else found)
    ]
    more = f" and {len(shown) - _MOST} more" if len(shown) > _MOST else ""
    return ", ".join(shown[:_MOST]) + more


def _sizes(sizes: Sequence[Sequence[float]]) -> str:
    if not sizes:
        return ""
    return " × ".join(_range(axis) for axis in zip(*sizes, strict=True)) + " m"


def _range(numbers: Sequence[float], unit: str = "") -> str:
    if not numbers:
        return ""
    low, high = _number(min(numbers)), _number(max(numbers))
    return (low if low == high else f"{low}…{high}") + unit


def _number(number: float) -> str:
    return f"{round(number, 4) + 0.0:.4g}"


def _lengths(lengths: Sequence[float]) -> str:
    low, high = _length(min(lengths)), _length(max(lengths))
    return low if low == high else f"{low} to {high}"


def _length(length: float) -> str:
    return (
        f"{length:.3g} m" if length >= 1 else f"{100 * length:.3g} cm" if length >= 0.01 else f"{1000 * length:.2g} mm"
    )
