"""Writes the pose of an entity into the text of its scene file."""

from __future__ import annotations

from math import copysign, degrees, pi
from typing import TYPE_CHECKING, Any, Final, cast

from scenecc.geometry.rotations import IDENTITY, compose, from_axis_angle, from_rpy, invert, normalized, to_rpy
from scenecc.scene_file.layout import number_text, value_text
from scenecc.source.edits import EditError, TextEdits, as_is

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.diagnostics.diagnostic import Path
    from scenecc.geometry.rotations import Pose7, Quat

_SAME_PLACE, _SAME_TURN = 1e-6, 1e-6
"""Positions [m] and quaternion components that differ by less count as unchanged."""

_ROTATIONS: Final = ("q", "rpy", "rpy_deg", "axis_angle", "look_at")

_AXES: Final = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def check_written(name: str, data: Mapping[str, Any]) -> None:
    """Checks that the pose of an entity can be written into a document.

    Args:
        name: name of the entity in the plan.
        data: content of the document.

    Raises:
        EditError: it cannot be written; the message gives the reason.
    """
    entities = _mapping(data.get("entities"))
    written = _mapping(entities.get(name))
    if not written:
        raise EditError(_maker(name, entities))
    for key in ("use", "variants", "place", "repeat"):
        if key in written:
            raise EditError(f"`{key}` sets its pose")
    _read_pose(written.get("pose", [0, 0, 0]))


def _maker(name: str, entities: Mapping[str, Any]) -> str:
    """Describes what generates an entity that has no node of its own in a document."""
    for key, written in entities.items():
        if name.startswith(f"{key}/") and "use" in _mapping(written):
            return f"the prefab that `{key}` uses sets its pose"
        if name.startswith(f"{key}_") and "repeat" in _mapping(written):
            return f"it is a copy made by the `repeat` of `{key}`"
    return "a `repeat`, a prefab or another file generates it"


def with_pose(text: str, data: Mapping[str, Any], name: str, start: Pose7, new: Pose7) -> str:
    """Returns the text with another pose of an entity.

    `relative_to` and `anchor` stay unchanged.

    Args:
        text: text of the scene file.
        data: content of the text.
        name: name of the entity; `check_written` must accept it.
        start: its pose in the text, in the world.
        new: its new pose in the world.

    Raises:
        EditError: it cannot be written; the message gives the reason.
    """
    pose = data["entities"][name].get("pose")
    old = _read_pose(pose or [0, 0, 0])
    mapping = _mapping(pose)
    if "relative_to" in mapping and "anchor" in mapping:
        raise EditError("it has both `relative_to` and `anchor`")
    if "relative_to" in mapping:
        wanted = compose(compose(old, invert(start)), new)
    else:
        wanted = compose(new, compose(invert(start), old))
    edits, path = TextEdits(text), ("entities", name, "pose")
    position, rotation = (
        _rounded(wanted[:3], old[:3], 4, _SAME_PLACE),
        _changed_rotation(normalized(wanted[3:]), old[3:]),
    )
    whole = position if rotation is None else {"p": position, "q": _digits(rotation, 6)}
    if pose is None:
        _add(edits, path, whole)
    elif isinstance(pose, list) and rotation is not None:
        inline = edits.source(path)
        if inline is None or not isinstance(inline(0, "any"), str):
            raise EditError("its pose is a list over several lines: write it in brackets")
        edits.replace(path, as_is(_text(whole, path)))
    elif isinstance(pose, list):
        _set_numbers(edits, path, old[:3], position)
    else:
        if rotation is not None:
            _turn(edits, path, mapping, rotation)
        if "p" in mapping:
            _set_numbers(edits, (*path, "p"), old[:3], position)
        elif any(position):
            _add(edits, (*path, "p"), position)
    return edits.result()


def _read_pose(written: Any) -> Pose7:
    """Returns a pose of plain numbers, without its reference frame. Raises EditError for other poses."""
    if isinstance(written, list):
        x, y, z = _numbers(written, 3, "pose")
        return (x, y, z, *IDENTITY)
    pose = _mapping(written) or {str(written): None}
    if not pose.keys() <= {"p", "anchor", "relative_to", *_ROTATIONS}:
        kind = next(key for key in pose if key != "p")
        raise EditError(f"its pose is written as an expression, a form or a matrix (`{kind}`)")
    x, y, z = _numbers(pose.get("p", [0, 0, 0]), 3, "p")
    return (x, y, z, *_rotation(pose))


def _rotation(pose: Mapping[str, Any]) -> Quat:
    if "look_at" in pose:
        raise EditError("`look_at` sets its rotation from its position")
    if "q" in pose:
        return normalized(_numbers(pose["q"], 4, "q"))
    if "rpy" in pose:
        roll, pitch, yaw = _numbers(pose["rpy"], 3, "rpy")
        return from_rpy(roll, pitch, yaw)
    if "rpy_deg" in pose:
        roll, pitch, yaw = (angle * pi / 180 for angle in _numbers(pose["rpy_deg"], 3, "rpy_deg"))
        return from_rpy(roll, pitch, yaw)
    if "axis_angle" in pose:
        said = _mapping(pose["axis_angle"])
        axis = said.get("axis")
        (angle,) = _numbers([said.get("angle", said.get("angle_deg"))], 1, "angle")
        x, y, z = _numbers(_AXES.get(axis, axis) if isinstance(axis, str) else axis, 3, "axis")
        return from_axis_angle((x, y, z), angle * pi / 180 if "angle_deg" in said else angle)
    return IDENTITY


def _mapping(written: Any) -> dict[str, Any]:
    """Returns the written mapping; empty for anything else."""
    return cast("dict[str, Any]", written) if isinstance(written, dict) else {}


def _numbers(written: Any, count: int, key: str) -> list[float]:
    numbers: list[Any] = [*written] if isinstance(written, list | tuple) else []
    if len(numbers) != count or not all(isinstance(one, int | float) and not isinstance(one, bool) for one in numbers):
        raise EditError(f"`{key}` is an expression or a form")
    return [float(one) for one in numbers]


def _turn(edits: TextEdits, path: Path, mapping: Mapping[str, Any], rotation: Quat) -> None:
    """Writes a rotation in the notation of the old one."""
    if "axis_angle" in mapping:
        raise EditError("its rotation is written as `axis_angle`: edit it there, or use `q` or `rpy_deg`")
    if "rpy" in mapping:
        _set_numbers(edits, (*path, "rpy"), mapping["rpy"], _digits(to_rpy(rotation), 5))
    elif "rpy_deg" in mapping:
        _set_numbers(edits, (*path, "rpy_deg"), mapping["rpy_deg"], _digits(map(degrees, to_rpy(rotation)), 3))
    elif "q" in mapping:
        _set_numbers(edits, (*path, "q"), mapping["q"], _digits(rotation, 6))
    else:
        _add(edits, (*path, "q"), _digits(rotation, 6))


def _set_numbers(edits: TextEdits, path: Path, old: Sequence[float], new: Sequence[float]) -> None:
    for number, (before, after) in enumerate(zip(old, new, strict=True)):
        if before != after:
            edits.replace((*path, number), as_is(number_text(after)))


def _rounded(new: Sequence[float], old: Sequence[float], digits: int, same: float) -> list[float]:
    return [
        before if abs(after - before) < same else round(after, digits) for before, after in zip(old, new, strict=True)
    ]


def _changed_rotation(new: Quat, old: Sequence[float]) -> Quat | None:
    """Returns the rotation; None if it is unchanged."""
    sign = copysign(1.0, sum(a * b for a, b in zip(new, old, strict=True)))
    w, x, y, z = (sign * one for one in new)
    return None if max(abs(a - b) for a, b in zip((w, x, y, z), old, strict=True)) < _SAME_TURN else (w, x, y, z)


def _digits(numbers: Any, digits: int) -> list[float]:
    return [round(one, digits) for one in numbers]


def _add(edits: TextEdits, path: Path, value: Any) -> None:
    edits.insert(path[:-1], path[-1], str(path[-1]), as_is(_text(value, path)))


def _text(value: Any, path: Path) -> str:
    return cast("str", value_text(value, path, 0, "flow"))
