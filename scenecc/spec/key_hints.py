"""Hints for unknown keys: the entry to write instead, with the value that the file has."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.messages import nearest
from scenecc.spec.hints import HALVES, KEY_SYNONYMS, MISPLACED_KEYS, VALUE_SYNONYMS
from scenecc.spec.nodes import is_mapping, is_sequence

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

_LONGEST: Final = 80
"""Maximum length of a value in a hint [characters]; `…` stands for a longer one."""

_PLAIN: Final = re.compile(r"[A-Za-z_./][\w./-]*")
"""Strings that need no quotes in a flow mapping."""

_RESERVED: Final = frozenset(("true", "false", "null", "yes", "no", "on", "off", "y", "n"))


def flow(value: Any, longest: int = _LONGEST) -> str:
    """Returns a value as YAML in one line, or `…` if it is longer than `longest` characters."""
    text = ""
    for token in _tokens(value):  # a value with aliases may be far longer than its text
        text += token
        if len(text) > longest:
            return "…"
    return text


def _tokens(value: Any) -> Iterator[str]:
    if is_mapping(value) or is_sequence(value):
        yield "{" if is_mapping(value) else "["
        for number, one in enumerate(value):
            yield ", " if number else ""
            if is_mapping(value):
                yield f"{one}: "
            yield from _tokens(value[one] if is_mapping(value) else one)
        yield "}" if is_mapping(value) else "]"
    elif isinstance(value, bool) or value is None:
        yield json.dumps(value)
    elif isinstance(value, float):
        yield f"{value:.12g}"
    else:
        is_plain = isinstance(value, str) and _PLAIN.fullmatch(value) and value.lower() not in _RESERVED
        yield str(value) if is_plain or isinstance(value, int) else json.dumps(value, ensure_ascii=False)


def numbers(value: Any) -> list[float]:
    """Returns the numbers of a list, or of a string with blanks or commas between them; empty if it has other parts."""
    found = value if is_sequence(value) else value.replace(",", " ").split() if isinstance(value, str) else [value]
    try:
        return [one if isinstance(one, int) else float(one) for one in found]
    except (TypeError, ValueError):
        return []


def snake_case(key: str) -> str:
    """Converts a camelCase key of another tool (`useFixedBase`) to snake_case."""
    return _HUMP.sub("_", key).lower()


_HUMP = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")


def misplaced_hint(key: str, owner: Mapping[str, Any], known: Sequence[str], name: str) -> str | None:
    """Returns what to write instead of a key that is known elsewhere or in another tool, or None.

    Args:
        key: the unknown key.
        owner: the mapping that has it.
        known: the keys that the mapping may have.
        name: the key of that mapping.
    """
    word, value = snake_case(key), owner.get(key)
    if word != key and word in known:
        return None
    if word != key and "locked_axes" in known and word in _ENTITY_FORMS:
        return f"did you mean `{word}`?"
    for beside, words, make in _MAKERS:
        if beside in known and word in words and (hint := make(word, value, owner)):
            return hint
    rows = (row for row in MISPLACED_KEYS if word in row[1].split())
    hint = next((hint for beside, _, hint in rows if not set(beside.split()).isdisjoint(known)), None)
    if hint is None:
        return None
    listed = flow(value) if is_sequence(value) else f"[{flow(value)}]"
    (here, *_) = KEY_SYNONYMS.get(word, (key,))
    hint = hint.replace("@name", flow(owner.get("name", name))).replace("@here", here)
    return hint.replace("@key", key).replace("[@]", listed).replace("@", flow(value))


_ENTITY_FORMS: Final = frozenset(("urdf", "mjcf", "root", "use", "variants"))
"""Keys that make an entity something other than a body."""


def half_hint(key: str, near: str, value: Any, *, is_shape: bool = True) -> str:
    """Returns what to write instead of a key of which `near` takes the half.

    Args:
        key: the unknown key.
        near: the known one.
        value: its value.
        is_shape: whether it is a shape's.
    """
    found = numbers(value)
    if near == "radius" and len(found) == 2 and is_shape:
        return f"write `radius: {flow(found[0])}, half_length: {flow(found[1])}`, as in MuJoCo's `{key}`"
    if near == "half_size" and len(found) == 1:
        found *= 3
    if not found or len(found) not in ({2, 3} if near == "half_size" else {1}):
        return f"did you mean `{near}`? it is half of that"
    halves = [one / 2 for one in found]
    note = " (in MuJoCo, `size` is already half)" if key == "size" else ""
    return f"write `{near}: {flow(halves if near == 'half_size' else halves[0])}`, half of that{note}"


_PLACE_WORDS: Final = ("p", "pos", "xyz", "translation", "location", "position", "base_position")
_TURN_WORDS: Final = frozenset(
    [
        "q",
        "quat",
        "quaternion",
        "wxyz",
        "xyzw",
        "orientation",
        "rotation",
        "rot",
        "base_orientation",
        "euler",
        "euler_deg",
        "angles",
        "rpy",
        "rpy_deg",
        "roll_pitch_yaw",
    ]
)
_FREQUENCIES: Final = frozenset(("sim_freq", "control_freq", "frequency", "fps", "hz"))
_FULL_TURN: Final = 2 * math.pi


def _rotation(word: str, value: Any) -> str | None:
    """Returns the entry of a pose for a rotation in another notation."""
    found = numbers(value)
    if len(found) == 4:
        last, *others = found[-1], *found[:-1]
        if word == "xyzw":
            return f"q: {flow([last, *others])}"
        return f"q: {flow(found)}"
    if len(found) != 3:
        return None
    is_in_degrees = word.endswith("deg") or any(abs(one) > _FULL_TURN for one in found)
    return f"{'rpy_deg' if is_in_degrees else 'rpy'}: {flow(found)}"


def _in_pose(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for a rotation in a pose."""
    del owner
    entry = _rotation(word, value)
    if entry is None:
        return None
    if not entry.startswith("q: "):
        other = "in degrees" if entry.startswith("rpy_deg") else "in radians, or `rpy_deg` in degrees"
        return f"write `{entry}`, {other}"
    found = numbers(value)
    if word in {"xyzw", "wxyz", "q"}:
        return f"write `{entry}`, w first"
    return f"write `{entry}`, w first; if w is the last number, `q: {flow([found[-1], *found[:-1]])}`"


def _beside_pose(key: str) -> Callable[[str, Any, Mapping[str, Any]], str | None]:
    """Returns the maker of hints for a rotation beside the pose `key`."""

    def hint(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
        entry = _rotation(word, value)
        if entry is None:
            return None
        place = owner.get(key)
        if is_mapping(place):
            place = place.get("p")
        if place is None:
            place = next((one for name, one in owner.items() if snake_case(name) in _PLACE_WORDS), None)
        found = numbers(place)
        position = f"p: {flow(found)}, " if len(found) == 3 else ""
        note = ""
        if entry.startswith("q: ") and word not in {"q", "wxyz", "xyzw"}:
            last, *others = reversed(numbers(value))
            note = f"; `q` has w first: if w is the last number, `q: {flow([last, *reversed(others)])}`"
        return f"write it in the {key}: `{key}: {{{position}{entry}}}`{note}"

    return hint


def _coordinates(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for coordinates that are written one by one."""
    del value
    names = "xyz" if word in {"x", "y", "z"} else ("roll", "pitch", "yaw")
    found = numbers([owner.get(name, 0) for name in names])
    return f"write `{'p' if names == 'xyz' else 'rpy'}: {flow(found)}`" if found else None


def shape_hint(found: Mapping[str, Any], choices: Sequence[str]) -> str | None:
    """Returns a hint for a mapping without a `type`. `choices`: the types that it may have."""
    key = next((key for key in found if key in choices or key == "mesh"), None)
    inner = found[key] if key is not None else None
    kind = key or next((one for one in found.values() if isinstance(one, str) and one in choices), None)
    keys = {name: one for name, one in found.items() if name != key and one != kind}
    if is_mapping(inner):
        keys |= inner
    elif inner is not None:
        keys |= {"half_size" if len(numbers(inner)) == 3 else "file" if isinstance(inner, str) else "radius": inner}
    if kind is None:
        guesses = (("half_size", "box"), ("file", "convex_mesh"), ("half_length", "capsule"), ("radius", "sphere"))
        kind = next((guess for size, guess in guesses if size in found and guess in choices), None)
    if kind is None:
        return None
    if kind == "mesh" and kind not in choices:
        kind = "convex_mesh"
    return f"write `{flow({'type': kind, **dict(_size(*one) for one in keys.items())})}`"


_SHAPE_TYPES: Final = frozenset(
    ["box", "sphere", "capsule", "cylinder", "plane", "mesh", "convex_mesh", "triangle_mesh"]
)
_FILES: Final = frozenset(("file", "filename", "mesh_file"))
_SIZES: Final = frozenset(("half_size", "half_length", "radius", *HALVES, *_FILES))


def _shape(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for a shape that is written as keys of a body."""
    if is_sequence(value) and value and all(map(is_mapping, value)):
        return f"write `shapes: {flow(value)}`"
    beside = owner.get("type", owner.get("shape"))
    kind = word if word in _SHAPE_TYPES else beside if word in _SIZES else value
    keys = value if is_mapping(value) else {key: one for key, one in owner.items() if snake_case(key) in _SIZES}
    if is_mapping(value):
        kind = value.get("type", kind)
    elif word == "box" and len(numbers(value)) == 3:
        keys = {"half_size": value}
    kind = (
        kind if isinstance(kind, str) and kind in _SHAPE_TYPES else next(iter(VALUE_SYNONYMS.get(str(kind), ())), None)
    )
    if kind is None or not keys:
        return None
    sizes = (_size(key, one) for key, one in keys.items() if key != "type")
    return f"write `shapes: [{flow({'type': 'convex_mesh' if kind == 'mesh' else kind, **dict(sizes)})}]`"


def _size(key: str, value: Any) -> tuple[str, Any]:
    """Returns the key and value here for a size of a shape in another notation."""
    word = snake_case(key)
    if word in _FILES:
        return "file", value
    found = numbers(value)
    near, *_ = HALVES.get(word, (word,))
    if near == word or not found:
        return key, value
    return near, [one / 2 for one in found] if len(found) > 1 else found[0] / 2


def _body_type(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for `type: static`, or a switch that means a body type."""
    del owner
    if word == "type":
        meant = next((one for one in (value, *VALUE_SYNONYMS.get(str(value), ())) if one in _BODY_TYPES), None)
        return None if meant is None else f"write `body_type: {meant}`"
    is_off = value is False or value == 0
    if word in {"dynamic", "is_dynamic", "movable"}:
        return f"write `body_type: {'static' if is_off else 'dynamic'}`"
    return "write `body_type: dynamic`" if is_off else None


_BODY_TYPES: Final = ("static", "kinematic", "dynamic")

_FRICTIONS: Final = frozenset(("friction", "mu", "mu1", "lateral_friction"))
_PHYSICAL: Final = ("static_friction", "dynamic_friction", "restitution")


def _material(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for numbers of a material that are written beside it."""
    del word, value
    found: dict[str, Any] = {}
    for key, one in owner.items():
        if snake_case(key) in _FRICTIONS:
            first = one[0] if is_sequence(one) and one else one
            found |= {"static_friction": first, "dynamic_friction": first}
        elif key in _PHYSICAL:
            found[key] = one
    return f"write it in the material: `material: {{physical: {flow(found)}}}`"


def _physical(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    hint = _material(word, value, owner)
    return hint and hint.replace("write it in the material: `material: {", "write `")[:-2] + "`"


def _view(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for an angle of view."""
    del owner
    found = re.match(r"\d+(?:\.\d+)?", str(value)) if isinstance(value, str | int | float) else None
    if found is None:
        return None
    is_small = float(found[0]) < math.pi and not word.endswith("deg") and "deg" not in str(value)
    other = "`fovy` in radians" if not is_small else f"`fovy: {found[0]}` in radians"
    return f"write `fovy_deg: {found[0]}`, the vertical angle of view in degrees, or {other}"


def _file(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for the file of an entity, by its suffix."""
    del word, owner
    suffix = value.rpartition(".")[2].lower() if isinstance(value, str) else ""
    key = {"urdf": "urdf", "xml": "mjcf", "mjcf": "mjcf", "yaml": "use", "yml": "use"}.get(suffix)
    return key and f"write `{key}: {flow(value)}`"


def _part(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for `collision` or `visual` of a body."""
    del owner
    if isinstance(value, bool):
        other = "visuals" if word == "collision" else "collisions"
        return f"write `{other}` instead of `shapes`" if not value else "remove it: `shapes` collide and are visible"
    return None


def _pose_of_origin(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for a pose with the keys of a URDF or SDF."""
    del word, owner
    if not is_mapping(value):
        return None
    turn = next((_rotation(snake_case(key), one) for key, one in value.items() if snake_case(key) in _TURN_WORDS), None)
    place = next((numbers(one) for key, one in value.items() if snake_case(key) in _PLACE_WORDS), list[float]())
    parts = [*([f"p: {flow(place)}"] if place else []), *([turn] if turn else [])]
    return f"write `pose: {{{', '.join(parts)}}}`" if parts else None


def _gravity(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for gravity at the top of the file."""
    del word, owner
    found = gravity(value)
    return found and f"write it under `physics`: `physics: {{gravity: {found}}}`"


def gravity(value: Any) -> str | None:
    """Returns gravity as a vector, if it is written as a number, a switch or three numbers."""
    found = numbers(False if value is None else value)
    if isinstance(value, bool):
        return None if value else "[0, 0, 0]"
    if len(found) == 1:
        return flow([0, 0, -abs(found[0])] if found[0] else [0, 0, 0])
    return flow(found) if len(found) == 3 else None


def _frequency(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for a frequency [Hz] instead of a time step."""
    del word, owner
    found = numbers(value)
    if len(found) != 1 or found[0] <= 0:
        return None
    return f"write `physics: {{timestep: {flow(1 / found[0])}}}` [s], one divided by the frequency"


def _brightness(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for the brightness of a light beside its colour."""
    del word
    colors, factor = numbers(owner.get("color", [1, 1, 1])), numbers(value)
    if len(factor) != 1 or len(colors) != 3:
        return None
    return f"write `color: {flow([factor[0] * one for one in colors])}`: its numbers also set the brightness"


def _look_at(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for the places of a camera and its target beside its pose."""
    del word, value
    pose = owner.get("pose")
    eye = owner.get("eye", pose.get("p") if is_mapping(pose) else pose)
    eye = next((owner[key] for key in _PLACE_WORDS if key in owner), None) if eye is None else eye
    target = next((owner[key] for key in ("look_at", "lookat", "target") if key in owner), [0, 0, 0])
    if len(numbers(eye)) != 3 or len(numbers(target)) != 3:
        return None
    return f"write it in the pose: `pose: {{p: {flow(numbers(eye))}, look_at: {flow(numbers(target))}}}`"


def _clipping(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for the clipping planes of a camera in one key."""
    del word, owner
    found = numbers(value)
    return f"write `near: {flow(found[0])}` and `far: {flow(found[1])}` [m]" if len(found) == 2 else None


def _robot(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for a robot at the top of the file."""
    del owner
    return f"write it under `entities`: `entities: {{{word}: {flow(value)}}}`" if is_mapping(value) else None


def _positions(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for joint positions that are called `q`."""
    del word, owner
    return None if is_sequence(value) and len(value) == 4 else f"write `qpos: {flow(value)}`"


def _resolution(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for the size of a camera's image."""
    del word, owner
    found = numbers(value)
    return f"write `width: {flow(found[0])}` and `height: {flow(found[-1])}` [px]" if len(found) in {1, 2} else None


def _limits(word: str, value: Any, owner: Mapping[str, Any]) -> str | None:
    """Returns a hint for the limits of a joint in the keys of a URDF."""
    pair = value if word == "limit" and is_mapping(value) else owner
    ends = ("lower", "lower_limit", "min"), ("upper", "upper_limit", "max")
    found = [x for names in ends for one in names if one in pair for x in numbers(pair[one])]
    return f"write `limits: {flow(found)}`" if len(found) == 2 else None


_Maker = Callable[[str, Any, "Mapping[str, Any]"], str | None]

_MAKERS: Final[tuple[tuple[str, frozenset[str], _Maker], ...]] = (
    ("qpos", frozenset("q"), _positions),
    ("entities", frozenset(("robot", "table", "cube", "box", "arm", "object")), _robot),
    ("fovy", frozenset(("clip", "clipping", "near_far", "clip_range")), _clipping),
    ("rpy_deg", _TURN_WORDS, _in_pose),
    ("matrix", frozenset(("x", "y", "z", "roll", "pitch", "yaw")), _coordinates),
    ("pose", _TURN_WORDS, _beside_pose("pose")),
    ("origin", _TURN_WORDS, _beside_pose("origin")),
    ("pose", frozenset((*_PLACE_WORDS, "origin")), _pose_of_origin),
    ("locked_axes", frozenset(("collision", "visual")), _part),
    ("locked_axes", frozenset(("file", "filename", "path", "uri", "src", "model", "mesh", "robot", "xml")), _file),
    ("fovy", frozenset(("fov", "fov_deg")), _view),
    ("entities", frozenset(("gravity",)), _gravity),
    ("timestep", _FREQUENCIES, _frequency),
    ("entities", _FREQUENCIES, _frequency),
    ("color", frozenset(("intensity", "power", "energy", "brightness")), _brightness),
    ("fovy", frozenset(("look_at", "lookat", "eye", "target")), _look_at),
    ("fovy", frozenset(("resolution", "res", "image_size", "img_size", "size")), _resolution),
    ("limits", frozenset(("limit", "lower", "upper", "lower_limit", "upper_limit", "min", "max")), _limits),
    (
        "locked_axes",
        frozenset(["type", "static", "fixed", "kinematic", "dynamic", "is_dynamic", "movable"]),
        _body_type,
    ),
    (
        "locked_axes",
        _SIZES | _SHAPE_TYPES | frozenset(["type", "shape", "geometry", "geom", "geoms", "collider"]),
        _shape,
    ),
    ("material", _FRICTIONS | {*_PHYSICAL}, _material),
    ("physical", _FRICTIONS | {*_PHYSICAL}, _physical),
)
"""A key that the mapping may have, unknown keys, and what makes a hint of their values. The first hint is used."""


def suggest_key(key: str, known: tuple[str, ...], free: tuple[str, ...] | None = None) -> str | None:
    """Returns the known key that an unknown key probably means, or None.

    Args:
        key: the unknown key.
        known: the keys that the mapping may have.
        free: the candidates for a misspelling, normally the unused keys; None for all.
    """
    word = snake_case(key)
    renamed = next((one for one in (word, *HALVES.get(word, ()), *KEY_SYNONYMS.get(word, ())) if one in known), None)
    return renamed or nearest(key, known if free is None else free)
