"""Checks of numbers as they are written in the scene file: angles in the wrong unit, quaternions in another order, and
values that another key or the size of the batch leaves without effect.

A plan no longer contains these: it has only radians, and a mass. Included files and prefabs are not checked.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.diagnostic import Origin, dotted
from scenecc.plan import BodyStructure
from scenecc.spec.nodes import is_mapping, is_sequence

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.source import Document

    Rule = Callable[[Mapping[str, Any], Origin, Sink], None]

FULL_TURN: Final = math.tau + 0.01
"""[rad], and more than 6.28 and 6.2832."""

TWO_TURNS: Final = 4 * math.pi * (1 + 1e-6)
"""[rad] Larger angles in radians are reported where they are lowered."""

MIN_WHOLE: Final = 4
"""[rad] Nobody writes 4, 5 or 10 rad: it is more than half a turn, and no part of one."""

MIN_FOV: Final = 3.2
"""[deg] Of a camera or a spot light. A telephoto lens of 600 mm has 4°."""

MAX_LIMIT: Final = 7.0
"""[rad] Limits of a joint that may make a whole turn in each direction."""

ROUNDING: Final = 0.004
"""[rad] π/2 is written as 1.57, π as 3.14, π/3 as 1.05."""

SPEEDS: Final = frozenset((45.0, 90.0))
"""[rad/s] Speeds of rotation that are probably degrees per second. Larger ones are beyond what PhysX allows."""

_NAME: Final = re.compile(r"[\w-]+")
_SIMPLE_PATTERN: Final = re.compile(r"(?:[\w|-]|\.\*)+")
"""A pattern of alternatives and `.*` only."""

_FOV_KEYS: Final = ("fovy_deg", "fovx_deg", "outer_fov_deg")
_ANGLE_KEYS: Final = frozenset(("rpy", "angle", "yaw", "qpos", "target", "limits"))
_SPEED_KEYS: Final = frozenset(("angular_velocity", "velocity_target", "qvel"))
_SYMMETRIC: Final = frozenset(("box", "sphere", "capsule", "cylinder"))
"""Shapes that look the same after half a turn about z."""


def check_written_angles(document: Document, plan: ScenePlan, sink: Sink) -> None:
    """Reports angles that are probably in degrees where radians are expected, or the reverse.

    Args:
        document: the scene file, as written.
        plan: its plan, which says which joints slide.
        sink: collects diagnostics.
    """
    names = _named_values(document)
    structures = (one for entity in plan.entities for one in entity.structures)
    robots = (one for one in structures if not isinstance(one, BodyStructure))  # their class is loaded with the first
    slides = {joint.name for one in robots for joint in one.active_joints if joint.type == "prismatic"}
    for mapping, origin in _mappings(document):
        _check_degrees(_without_slides(mapping, origin, slides), origin, names, sink)
        _check_radians(mapping, origin, names, sink)


def _without_slides(mapping: Mapping[str, Any], origin: Origin, slides: set[str]) -> Mapping[str, Any]:
    """Returns an articulation or a drive without the positions of joints that slide, or that may be beyond limits."""
    qpos = mapping.get("qpos")
    if "qpos" in mapping and (slides or "beyond_limits" in mapping):
        kept = {} if not is_mapping(qpos) else {name: one for name, one in qpos.items() if name not in slides}
        return {**mapping, "qpos": {} if "beyond_limits" in mapping else kept}
    if "target" in mapping and any(_matches(str(origin.path[-1]), name) for name in slides):
        return {key: one for key, one in mapping.items() if key != "target"}
    return mapping


def check_written_values(document: Document, num_scenes: int, sink: Sink) -> None:
    """Applies the other rules of this module.

    Args:
        document: the scene file, as written.
        num_scenes: number of scenes.
        sink: collects diagnostics.
    """
    several = num_scenes > 1 or "num_scenes" in document.data
    for mapping, origin in _mappings(document):
        _check_quaternion(mapping, origin, sink)
        _check_half_turn(mapping, origin, sink)
        _check_density(mapping, origin, sink)
        _check_drives(mapping, origin, sink)
        items = mapping.get("cycle")
        if several and is_sequence(items) and len(items) > num_scenes:
            message = f"this `cycle` has {len(items)} values for {num_scenes} scene{'s' * (num_scenes > 1)}"
            hint = "shorten it, or raise `num_scenes`; `choice` draws from a list of any length"
            sink.report("SC575", message, origin.child("cycle"), at="key", hint=hint)


def _named_values(document: Document) -> dict[str, Any]:
    """Returns the draws of a document, and the defaults of its parameters, by name."""
    names: dict[str, Any] = {}
    for key in ("params", "draws"):
        section = document.data.get(key)
        names |= section if is_mapping(section) else {}
    return {
        name: value["default"] if is_mapping(value) and "default" in value else value for name, value in names.items()
    }


def _mappings(document: Document) -> Iterator[tuple[Mapping[str, Any], Origin]]:
    """Yields all mappings of a document and their origins, but those whose keys are names of the author's."""
    rest: list[tuple[Any, Origin]] = [(document.data, Origin(document.name))]
    while rest:
        node, origin = rest.pop()
        if is_mapping(node) and origin.path != ("draws",):
            yield node, origin
        rest += ((value, origin.child(key)) for key, value in _items(node) if _is_nested(value) and _is_known(key))


def _is_known(key: str | int) -> bool:
    return isinstance(key, int) or (key not in {"params", "with"} and key[:2] != "x-")


def _is_nested(value: Any) -> bool:
    return is_mapping(value) or is_sequence(value)


def _items(value: Any) -> Iterator[tuple[str | int, Any]]:
    """Yields the keys, or indices, and the values of a mapping or list; nothing for a scalar."""
    if is_mapping(value):
        yield from value.items()
    elif is_sequence(value):
        yield from enumerate(value)


def _numbers(value: Any, names: Mapping[str, Any]) -> Iterator[float]:
    """Yields the magnitudes of all numbers in a value, and of the parameters and draws that it names."""
    if isinstance(value, str):
        name = value[2:-1].strip() if value[:2] == "${" else ""
        yield from _numbers(names[name], {}) if name in names else ()
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield abs(float(value))
    for _, item in _items(value):
        yield from _numbers(item, names)


def _check_radians(mapping: Mapping[str, Any], origin: Origin, names: Mapping[str, Any], sink: Sink) -> None:
    """Reports radians under keys that end with `_deg`."""
    for key, value in mapping.items():
        if key[-4:] != "_deg" or key == "within_deg":
            continue
        if any(_RADIANS.search(text) and not _DEGREES.search(text) for text in _expressions(value)):
            hint = f"write `{key[:-4]}` instead of `{key}`, or use `degrees(…)`"
            sink.report("SC526", f"`{key}` takes degrees, but this is in radians", origin.child(key), hint=hint)
            continue
        numbers = [number for number in _numbers(value, names) if number]
        most = max(numbers, default=math.inf)
        if most > FULL_TURN:
            continue
        found = next(filter(_is_part_of_a_turn, numbers), None)
        if found is None and key in _FOV_KEYS and most < MIN_FOV:
            found = most
        if found is None and key == "limits_deg":
            found = next((number for number in numbers if not number.is_integer()), None)
        if found is not None:
            message = f"`{key}` has {found:g}°; {found:g} rad would be {math.degrees(found):.4g}°"
            hint = f"write `{key[:-4]}` instead of `{key}`, which takes degrees"
            sink.report("SC526", message, origin.child(key), hint=hint)


_RADIANS: Final = re.compile(r"\bpi\b|\bradians\(|\batan2\(")
_DEGREES: Final = re.compile(r"\bdegrees\(|180")
"""Parts of expressions that give radians or degrees."""


def _expressions(value: Any) -> Iterator[str]:
    """Yields all texts with an expression in a value."""
    if isinstance(value, str) and "${" in value:
        yield value
    for _, item in _items(value):
        yield from _expressions(item)


def _is_part_of_a_turn(number: float) -> bool:
    """Returns whether a number that is not whole is a multiple of π/12, or of π/36 with three decimals."""
    if number.is_integer():
        return False
    parts = [(math.pi / 12, ROUNDING)] + [(math.pi / 36, ROUNDING / 8)] * (round(number, 2) != number)
    return any(number > part / 2 and abs(number - round(number / part) * part) < near for part, near in parts)


def _check_degrees(mapping: Mapping[str, Any], origin: Origin, names: Mapping[str, Any], sink: Sink) -> None:
    """Reports degrees under keys that take radians. Angles beyond two turns are reported where they are lowered."""
    for key in _ANGLE_KEYS.intersection(mapping):
        value = mapping[key]
        if (key == "limits" and not _has_hinge(mapping)) or (key == "target" and not _is_joint_drive(value, origin)):
            continue
        if _exceeds_two_turns(value):
            continue
        least = MAX_LIMIT if key == "limits" else MIN_WHOLE
        step = 0.5 if key in {"rpy", "angle", "yaw"} else 1.0  # 12.5 and 22.5 are written for degrees, too
        found = [number for number in _numbers(value, names) if number >= least and (number / step).is_integer()]
        place = dotted(origin.child(key).path)
        is_told = key == "target" and any(one.code == "SC523" and one.path == place for one in sink.diagnostics())
        if found and not is_told:
            message = f"`{key}` has {found[0]:g} rad, which is {math.degrees(found[0]):.4g}°"
            hint = f"write `{key}_deg` instead of `{key}`: angles are in radians"
            if key in {"qpos", "target"}:
                hint = f"positions are radians or metres: for {found[0]:g}° write {math.radians(found[0]):.4g}"
                hint += "; if it is intended, `# scenecc: ignore SC526`"
            sink.report("SC526", message, origin.child(key), hint=hint)
    for key in _SPEED_KEYS.intersection(mapping):
        found = [number for number in _numbers(mapping[key], names) if number in SPEEDS]
        if found:
            message = f"`{key}` has {found[0]:g} rad/s, which is {math.degrees(found[0]):.4g}°/s"
            hint = f"it is in rad/s: for {found[0]:g}°/s write {math.radians(found[0]):.4g}"
            sink.report("SC526", message, origin.child(key), hint=hint)


def _exceeds_two_turns(value: Any) -> bool:
    """Returns whether all numbers but 0 exceed two turns. Elsewhere, a uniform distribution from 0 is not reported."""
    numbers = list(_numbers(value, {}))
    least = (min if is_mapping(value) else max)([number for number in numbers if number], default=0.0)
    return least > TWO_TURNS and not (is_mapping(value) and "uniform" in value and 0 in numbers)


def _has_hinge(mapping: Mapping[str, Any]) -> bool:
    return mapping.get("type") in {"revolute", "revolute_unwrapped", "hinge"}


def _is_joint_drive(target: Any, origin: Origin) -> bool:
    """Returns whether a target is that of `drives: {PATTERN: …}`, or of `drive` of a constraint, and no pose."""
    return not _is_nested(target) and (origin.path[-1:] == ("drive",) or origin.path[-2:-1] == ("drives",))


def _check_quaternion(mapping: Mapping[str, Any], origin: Origin, sink: Sink) -> None:
    """Reports rotations about z or y that are written xyzw: [0, 0, sin, cos] or [0, sin, 0, cos]."""
    if mapping.get("type") in _ROUND:
        return
    for key in ("pose", "origin", "place"):
        pose = mapping.get(key)
        for w, x, y, z in _quaternions(pose.get("q")) if is_mapping(pose) else ():
            about_z = x == 0 and min(abs(y), abs(z)) > _MIN_TURN
            about_y = y == 0 and min(abs(x), abs(z)) > _MIN_TURN and "cameras" not in origin.path  # one that looks back
            if w == 0 and (about_z or about_y):
                message = f"[{w:g}, {x:g}, {y:g}, {z:g}] is half a turn about a tilted axis: it looks like [x, y, z, w]"
                hint = f"quaternions are [w, x, y, z]: the same rotation is [{z:.4g}, {w:.4g}, {x:.4g}, {y:.4g}]"
                sink.report("SC549", message, origin.child(key, "q"), hint=hint)
                return


_ROUND: Final = frozenset(("capsule", "cylinder", "cone", "ring"))
"""Shapes whose rotation only turns their axis."""

_MIN_TURN: Final = 0.02
"""Smallest quaternion component that is not 0 by intent."""


def _quaternions(value: Any) -> Iterator[tuple[float, ...]]:
    """Yields the quaternions that are written as four numbers, in forms, too."""
    items = [item for _, item in _items(value)]
    if len(items) == 4 and all(isinstance(item, int | float) for item in items):
        yield tuple(items)
    for item in items:
        yield from _quaternions(item)


def _check_half_turn(mapping: Mapping[str, Any], origin: Origin, sink: Sink) -> None:
    """Reports [0, 0, 0, 1] of a body that looks the same after half a turn: the identity, if it is read as xyzw."""
    pose = mapping.get("pose")
    shapes = [
        shape for key in ("shapes", "collisions", "visuals") for shape in mapping.get(key, ()) if is_mapping(shape)
    ] or [mapping]
    if not (is_mapping(pose) and pose.get("q") == [0, 0, 0, 1]):
        return
    if all(shape.get("type") in _SYMMETRIC and (shape is mapping or "pose" not in shape) for shape in shapes):
        message = "[0, 0, 0, 1] is half a turn about z, which changes nothing here: it looks like the identity as xyzw"
        hint = "quaternions are [w, x, y, z]: the identity is [1, 0, 0, 0]"
        sink.report("SC549", message, origin.child("pose", "q"), hint=hint)


def _check_density(mapping: Mapping[str, Any], origin: Origin, sink: Sink) -> None:
    """Reports a density beside a mass, which scales whatever the density gives."""
    given = next((key for key in ("mass", "inertial") if key in mapping), None)
    if given is None or "inertia" in mapping:
        return
    material = mapping.get("material")
    physical = material.get("physical") if is_mapping(material) else None
    place = origin.child("density") if "density" in mapping else None
    if is_mapping(physical) and "density" in physical:
        place = origin.child("material", "physical", "density")
    shapes = [
        (origin.child(key, number), shape)
        for key in ("shapes", "collisions")
        for number, shape in _items(mapping.get(key))
    ]
    written = [shape.get("density") if is_mapping(shape) else None for _, shape in shapes]
    if shapes and isinstance(written[0], float | int) and written.count(written[0]) == len(written):
        place = place or shapes[0][0].child("density")
    elif any(density is not None for density in written):
        place = None  # its shapes share the mass by their densities
    if place is not None:
        message = f"this density has no effect on the mass: `{given}` sets it"
        sink.report("SC573", message, place, at="key", hint=f"remove the density, or `{given}`")


def _check_drives(mapping: Mapping[str, Any], origin: Origin, sink: Sink) -> None:
    """Reports drives without stiffness or damping that no other pattern gives them."""
    drives = mapping.get("drives")
    given = {pattern: keys for pattern, keys in drives.items() if is_mapping(keys)} if is_mapping(drives) else {}
    if "attach" in mapping or "mjcf" in mapping or "override" in origin.path:
        return  # a part, a prefab, and the actuators of an MJCF have drives of their own
    for pattern, keys in given.items():
        whole = {key: value for other, each in given.items() if _matches(other, pattern) for key, value in each.items()}
        whole |= keys
        why = hint = None
        if "velocity_target" in whole and "damping" not in whole:
            continue  # another rule reports it
        if not ("stiffness" in whole or "damping" in whole):
            why = "it has neither stiffness nor damping"
            hint = "give it a stiffness and a damping; both are 0 by default"
        elif whole.get("stiffness") and "damping" not in whole:
            why, hint = "it has a stiffness and no damping, so the joint oscillates", "give it a damping"
        elif "target" in keys and "stiffness" not in whole:
            why, hint = "it has a target, but no stiffness", "give it a stiffness, or remove the target"
        if why is not None:
            message = f"the drive of `{pattern}` cannot hold its joint: {why}"
            sink.report("SC537", message, origin.child("drives", pattern), at="key", hint=hint)


def _matches(pattern: str, name: str) -> bool:
    """Returns whether a pattern of joints may match what another one, or a name, matches: any of its alternatives."""
    if not all(map(_SIMPLE_PATTERN.fullmatch, (pattern, name))) and not any(map(_NAME.fullmatch, (pattern, name))):
        return True  # `joint(1|2)` and `joint[23]` are not compared
    try:
        return any(
            re.fullmatch(one, part) is not None
            for one, other in ((pattern, name), (name, pattern))
            for part in other.split("|")
        )
    except re.error:
        return True  # it is reported where it is used
