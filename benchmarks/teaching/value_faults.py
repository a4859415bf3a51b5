"""Faults of units, numbers and physics."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import yaml

from benchmarks.teaching.scene_text import Edit, Entry, Fault, SceneText, numbers

if TYPE_CHECKING:
    from random import Random

_UNIT: Final = "SC10[3468]|SC11[29]|SC5(1[2378]|2[036]|3\\d|4[01]|67)|SC8[56]|SC820|SC355|SC354"
_NUMBER: Final = (
    "SC014|SC006|SC003|SC10[2-8]|SC11[234789]|SC120|SC21[124]|SC220|SC222|SC5\\d\\d|SC8[56]|SC60[45]|SC35|SC202|SC20"
)
_PHYSICS: Final = "SC10[1345]|SC111|SC115|SC5\\d\\d|SC8[56]|SC820|SC35"

_LENGTHS: Final = ("half_size", "radius", "half_length", "p", "pose", "region", "at")
_SIZES: Final = ("half_size", "radius", "half_length")


def show(value: Any) -> str:
    """Returns numbers as YAML."""
    if isinstance(value, list):
        return f"[{', '.join(map(show, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {show(one)}" for key, one in value.items()) + "}"
    if isinstance(value, float):
        return f"{value:.15g}"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _changed(scene: SceneText, entry: Entry, what: str, new: str, codes: str, key: str = "") -> Fault:
    start = entry.value.start_mark.index
    edits = [Edit(start, scene.end(entry.value), new)]
    if key and entry.key is not None:
        edits.append(Edit(entry.key.start_mark.index, entry.key.end_mark.index, key))
    return Fault(what, tuple(edits), (entry.start, start), codes)


def _times(factor: float) -> Callable[[float], float]:
    return lambda one: one * factor


_UNITS: Final[tuple[tuple[str, tuple[str, ...], Callable[[float], float], str], ...]] = (
    ("millimetres", _SIZES, _times(1000), ""),
    ("millimetres", _LENGTHS, _times(1000), ""),
    ("centimetres", _SIZES, _times(100), ""),
    ("centimetres", _LENGTHS, _times(100), ""),
    ("grams", ("mass",), _times(1000), ""),
    ("g/cm³", ("density",), _times(1e-3), ""),
    ("degrees in `rpy`", ("rpy_deg",), _times(1), "rpy"),
    ("degrees in `fovy`", ("fovy_deg",), _times(1), "fovy"),
    ("degrees", ("rpy", "fovy", "outer_fov", "inner_fov", "yaw", "angular_velocity"), math.degrees, ""),
    ("degrees", ("qpos", "limits", "target"), math.degrees, ""),
    ("radians in degrees", ("rpy_deg", "fovy_deg", "yaw_deg", "limits_deg"), math.radians, ""),
    ("hertz", ("timestep",), lambda one: 1 / one, ""),
    ("milliseconds", ("timestep",), _times(1000), ""),
    ("bytes", ("color", "base_color"), lambda one: round(one * 255), ""),
    ("percent", ("restitution", "static_friction", "roughness", "metallic"), _times(100), ""),
)


def wrong_unit(unit: int, scene: SceneText, draw: Random) -> Iterator[Fault]:
    what, keys, change, key = _UNITS[unit]
    for entry in scene.entries_of(*keys):
        value = scene.at_path(entry.path)
        found = numbers(value)
        if not any(found) or (what == "degrees" and not _is_angle(entry, found)):
            continue
        made: list[Any] = [change(one) if one else 0 for one in found]
        if what == "radians in degrees" and max(map(abs, found)) < 20:
            continue
        new = made if isinstance(value, list) else made[0]
        yield _changed(scene, entry, f"{what}: `{entry.path[-1]}`", show(new), _UNIT, key)


_SLIDES: Final = 0.4


def _is_angle(entry: Entry, found: list[float]) -> bool:
    """Whether a value is of a joint that turns: one that slides has few centimetres here."""
    return entry.path[-1] not in {"qpos", "limits", "target"} or (entry.path[0] == "entities" and max(found) > _SLIDES)


def unit_as_text(scene: SceneText, draw: Random) -> Iterator[Fault]:
    units = {
        "mass": ("kg", " g"),
        "density": (" kg/m3",),
        "fovy": (" deg",),
        "timestep": ("ms", " s"),
        "fovy_deg": ("°",),
    }
    units |= dict.fromkeys(_LENGTHS, ("mm", " cm", "m"))
    for entry in scene.entries:
        value, name = scene.at_path(entry.path), entry.name
        is_item = isinstance(entry.path[-1], int) and entry.path[-2:-1] == (name,)
        if name in units and (entry.is_key or is_item) and isinstance(value, int | float) and value:
            unit = draw.choice(units[name])
            scale = {"mm": 1000, " cm": 100, " g": 1000, "ms": 1000, " deg": math.degrees(1)}.get(unit, 1)
            yield _changed(scene, entry, f"unit in the text: `{name}`", f"{value * scale:g}{unit}", _UNIT)


def _scalars(scene: SceneText) -> Iterator[tuple[Entry, float]]:
    """Entries and items with a number, and it."""
    for entry in scene.entries:
        value = scene.at_path(entry.path)
        if isinstance(value, int | float) and not isinstance(value, bool) and entry.path != ("scenecc",):
            yield entry, value


def text_for_number(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry, value in _scalars(scene):
        text = f"{value:g}"
        made = [f'"{text}"', text.replace(".", ","), "five", "auto", f"~{text}", f"{text}O", f"{text}f"]
        new = draw.choice([one for one in made if one != text])
        if "," in new and isinstance(entry.path[-1], int):
            continue
        yield _changed(scene, entry, f"`{new}` for a number", new, _NUMBER)


def not_a_number(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry, _ in _scalars(scene):
        new = draw.choice([".nan", ".inf", "nan", "null", "", "None", "1e400"])
        if new == "" and isinstance(entry.path[-1], int):
            continue
        yield _changed(scene, entry, f"`{new}` for a number", new, _NUMBER)


def negative(scene: SceneText, draw: Random) -> Iterator[Fault]:
    keys = (*_SIZES, "mass", "density", "timestep", "static_friction", "dynamic_friction", "stiffness", "damping")
    for entry in scene.entries_of(*keys, "fovy", "fovy_deg", "width", "height", "count", "force_limit"):
        value = scene.at_path(entry.path)
        if found := numbers(value):
            at = draw.randrange(len(found))
            made = [-one if index == at else one for index, one in enumerate(found)]
            new = show(made if isinstance(value, list) else made[0])
            yield _changed(scene, entry, f"negative `{entry.path[-1]}`", new, _NUMBER)


def wrong_length(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of():
        value = scene.at_path(entry.path)
        if isinstance(value, list) and entry.path[-1] not in {"repeat", "scene_idxs"} and len(numbers(value)) > 1:
            made = draw.choice([value[:-1], [*value, 0], value[0]])
            if "color" in entry.name and len(numbers(made)) > 2:
                continue
            yield _changed(scene, entry, f"wrong length of `{entry.path[-1]}`", show(made), _NUMBER)


def quaternion(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of("rpy_deg", "q"):
        found = numbers(scene.at_path(entry.path))
        if len(found) == 3 and sum(map(bool, found)) == 1:
            at, half = next(index for index, one in enumerate(found) if one), math.radians(sum(found)) / 2
            found = [math.cos(half), *(math.sin(half) * (index == at) for index in range(3))]
        if len(found) == 4:
            found = [round(one, 12) + 0.0 for one in found]
            what, made = draw.choice(
                [("x, y, z, w", [*found[1:], found[0]]), ("not of unit length", [2 * one for one in found]),
                 ("not of unit length", [*found[:3], found[3] + 0.5])]
            )  # fmt: skip
            yield _changed(scene, entry, f"quaternion: {what}", show(made), _NUMBER, "q")


def out_of_range(scene: SceneText, draw: Random) -> Iterator[Fault]:
    beyond = {
        "restitution": 1.5,
        "roughness": 3,
        "metallic": 2,
        "fovy": 4,
        "fovy_deg": 200,
        "num_scenes": 0,
        "width": 0,
    }
    beyond |= {"count": 2.5, "height": 64.5, "default": "-5", "timestep": 0, "transmission": 5, "scenecc": 2}
    for entry in scene.entries_of(*beyond):
        if numbers(scene.at_path(entry.path)):
            new = str(beyond[str(entry.path[-1])])
            yield _changed(scene, entry, f"`{entry.path[-1]}` out of range", new, _NUMBER + "|SC100")


def swapped_ends(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of("uniform", "limits", "limits_deg", "log_uniform", "integers"):
        value = scene.at_path(entry.path)
        if isinstance(value, list) and len(value) == 2 and value[0] != value[1] and "$" not in str(value):
            yield _changed(scene, entry, f"ends of `{entry.path[-1]}` swapped", show(value[::-1]), _NUMBER + "|SC560")


def _bodies(scene: SceneText) -> Iterator[tuple[str, dict[str, Any], Entry]]:
    """Bodies whose keys are written in a block, with the entry of the first."""
    entities = scene.data.get("entities", {})
    for entry in scene.entries:
        if len(entry.path) == 3 and entry.path[0] == "entities" and scene.begins_line(entry):
            body = entities[entry.path[1]]
            if isinstance(body, dict) and next(iter(body)) == entry.path[2] and "shapes" in body:
                yield str(entry.path[1]), body, entry


def _inserted(scene: SceneText, entry: Entry, what: str, text: str) -> Fault:
    assert entry.key is not None
    at = scene.line_start(entry.start)
    return Fault(what, (Edit(at, at, f"{' ' * entry.key.start_mark.column}{text}\n"),), (at,), _PHYSICS)


def static_that_moves(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for name, body, entry in _bodies(scene):
        if body.get("body_type") == "static":
            text = draw.choice(
                ["mass: 1", "linear_velocity: [0, 0, 1]", "linear_damping: 0.5", "gravity: false", "locked_axes: [x]"]
            )
            yield _inserted(scene, entry, f"static `{name}` with `{text}`", text)


def impossible_inertia(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for name, body, entry in _bodies(scene):
        if body.get("body_type", "dynamic") == "dynamic" and not {"mass", "inertial"} & body.keys():
            text = draw.choice(["[0.001, 0.001, 0.1]", "[1, 1, 1]", "[0, 0, 0]", "[0.01, 0.01, -0.01]"])
            yield _inserted(scene, entry, f"inertia of `{name}`", f"inertial: {{mass: 0.1, inertia: {text}}}")


def massless(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for name, body, entry in _bodies(scene):
        if body.get("body_type", "dynamic") == "dynamic" and not {"mass", "inertial"} & body.keys():
            yield _inserted(scene, entry, f"mass of `{name}`", draw.choice(["mass: 0", "mass: 1.0e-9", "mass: 1.0e+6"]))


def frictions_swapped(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of("dynamic_friction"):
        static = scene.at_path(entry.path[:-1]).get("static_friction")
        if numbers(static):
            yield _changed(scene, entry, "dynamic friction above static", show(static * 2 + 0.1), _PHYSICS)


def moved_into_another(scene: SceneText, draw: Random) -> Iterator[Fault]:
    """A body at the pose of another, under the ground or in the air."""
    placed = [one for one in scene.entries_of("pose") if len(one.path) == 3 and one.path[0] == "entities"]
    poses = [one for one in placed if len(numbers(scene.at_path(one.path))) == 3]
    for entry in poses:
        here = scene.at_path(entry.path)
        body = scene.data["entities"][entry.path[1]]
        others = [scene.at_path(one.path) for one in poses if one is not entry and scene.at_path(one.path) != here]
        if body.get("body_type", "dynamic") != "dynamic" or "shapes" not in body:
            continue
        made = [("under the ground", [*here[:2], -abs(here[2]) - 0.5]), ("half in the ground", [*here[:2], 0])]
        if others:
            made.append(("in another body", draw.choice(others)))
        what, pose = draw.choice(made)
        if pose != here:
            yield _changed(scene, entry, f"`{entry.path[1]}` {what}", show(pose), _PHYSICS)


def copied_body(scene: SceneText, draw: Random) -> Iterator[Fault]:
    """A second body where the first is, as after copy and paste."""
    for entry in scene.entries:
        if len(entry.path) == 2 and entry.path[0] == "entities" and scene.begins_line(entry) and entry.key is not None:
            body = scene.data["entities"][entry.path[1]]
            if not isinstance(body, dict) or "shapes" not in body or body.get("body_type", "dynamic") != "dynamic":
                continue
            if {"repeat", "place"} & body.keys() or isinstance(entry.value, yaml.ScalarNode):
                continue
            at = scene.text.find("\n", scene.end(entry.value)) + 1
            text = scene.text[scene.line_start(entry.start) : at].replace(f"{entry.path[1]}:", f"{entry.path[1]}_2:", 1)
            yield Fault(f"`{entry.path[1]}` copied in its place", (Edit(at, at, text),), (at, entry.start), _PHYSICS)


def concave(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of("type"):
        if scene.at_path(entry.path) in {"convex_mesh", "convex_parts"}:
            yield _changed(scene, entry, "concave triangles on a dynamic body", "triangle_mesh", _PHYSICS)
    for entry in scene.entries_of("body_type"):
        if any(one.get("type") in {"plane", "heightfield"} for one in _shapes(scene, entry)):
            yield _changed(scene, entry, "a dynamic plane", "dynamic", _PHYSICS)


def _shapes(scene: SceneText, entry: Entry) -> list[dict[str, Any]]:
    found = scene.at_path(entry.path[:-1]).get("shapes")
    return [one for one in found if isinstance(one, dict)] if isinstance(found, list) else []


_IMPOSSIBLE: Final = {
    "near": "1000",
    "qpos": "[9, 9]",
    "timestep": "0.5",
    "gravity": "[0, 0, 9.81]",
    "stiffness": "1.0e+9",
    "density": "0.001",
    "restitution": "1.4",
    "target": "9",
    "force_limit": "1.0e-4",
}


def impossible_value(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of(*_IMPOSSIBLE):
        if numbers(scene.at_path(entry.path)):
            key = str(entry.path[-1])
            yield _changed(scene, entry, f"`{key}: {_IMPOSSIBLE[key]}`", _IMPOSSIBLE[key], _PHYSICS)


UNIT: Final = (*(partial(wrong_unit, unit) for unit in range(len(_UNITS))), *[unit_as_text] * 4)
NUMBER: Final = (text_for_number, not_a_number, negative, wrong_length, quaternion, out_of_range, swapped_ends)
PHYSICS: Final = (
    static_that_moves,
    impossible_inertia,
    massless,
    frictions_swapped,
    moved_into_another,
    copied_body,
    concave,
    impossible_value,
    swapped_ends,
)
