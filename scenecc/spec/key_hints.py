"""Hints for unknown keys: the entry to write instead, with the value that the file has."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator
from collections.abc import Set as AbstractSet
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from scenecc.diagnostics.messages import nearest
from scenecc.spec.hints import BRIGHTNESS, HALVES, KEY_SYNONYMS, MISPLACED_KEYS, PLACES, ROTATIONS, VALUE_SYNONYMS
from scenecc.spec.nodes import is_mapping, is_sequence

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.diagnostics.diagnostic import Path

_LONGEST: Final = 80
"""Maximum length of a value in a hint [characters]; `…` stands for a longer one."""

_PLAIN: Final = re.compile(r"(?!(?:true|false|null|yes|no|on|off|y|n)$)[A-Za-z_./][\w./-]*", re.IGNORECASE)
"""Strings that need no quotes in a flow mapping."""


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
        first, last = "{}" if is_mapping(value) else "[]"
        yield first
        for number, one in enumerate(value):
            yield ", " * bool(number) + (f"{one}: " if is_mapping(value) else "")
            yield from _tokens(value[one] if is_mapping(value) else one)
        yield last
    elif isinstance(value, float):
        yield f"{value:.12g}"
    else:
        is_plain = isinstance(value, str) and _PLAIN.fullmatch(value)
        yield value if is_plain else json.dumps(value, ensure_ascii=False)


def entry_at(path: Path, value: Any) -> str:
    """Returns what to write at a path: the entry of a mapping, or the item of a list."""
    text = value if isinstance(value, str) else flow(value)
    return f"`{path[-1]}: {text}`" if path and isinstance(path[-1], str) else f"`{text}`"


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


def suggest_key(key: str, known: Sequence[str], free: Sequence[str] | None = None) -> str | None:
    """Returns the known key that an unknown key probably means, or None.

    Args:
        key: the unknown key.
        known: the keys that the mapping may have.
        free: the candidates for a misspelling, normally the unused keys; None for all.
    """
    word = snake_case(key)
    renamed = next((one for one in (word, *HALVES.get(word, ()), *KEY_SYNONYMS.get(word, ())) if one in known), None)
    return renamed or nearest(key, known if free is None else free)


class _Key(NamedTuple):
    """An unknown key in snake case, its value, and the mapping that has it."""

    word: str
    value: Any
    owner: Mapping[str, Any]

    def among(self, *words: str) -> Any:
        """Returns the value of the first of some keys that the mapping has; None if it has none."""
        found = {snake_case(key): one for key, one in self.owner.items()}
        return next((found[word] for word in words if word in found), None)


def misplaced_hint(
    key: str, owner: Mapping[str, Any], known: Sequence[str], name: str, models: AbstractSet[str]
) -> str | None:
    """Returns what to write instead of a key that is known elsewhere or in another tool, or None.

    Args:
        key: the unknown key.
        owner: the mapping that has it.
        known: the keys that the mapping may have.
        name: the key of that mapping.
        models: the names of its model and of those that it inherits from.
    """
    word, value = snake_case(key), owner.get(key)
    if word != key and word in known:
        return None
    if word != key and "RigidBodyKeys" in models and word in _ENTITY_FORMS:
        return f"did you mean `{word}`?"
    unknown = _Key(word, value, owner)
    for places, words, make in MAKERS:
        if word in words.split() and not models.isdisjoint(places.split()) and (hint := make(unknown)):
            return _LONG_VALUE.sub(r"did you mean `\1`?", hint)
    ends = numbers(value)[:1] + numbers(value)[-1:]
    rows = (row for row in MISPLACED_KEYS if word in row[1].split() and (ends or "@first" not in row[2]))
    hint = next((hint for places, _, hint in rows if not models.isdisjoint(places.split())), None)
    if hint is None:
        return None
    listed = flow(value) if is_sequence(value) else f"[{flow(value)}]"
    (here, *_) = KEY_SYNONYMS.get(word, (key,))
    hint = hint.replace("@first", flow(ends[:1])[1:-1]).replace("@last", flow(ends[1:])[1:-1])
    hint = hint.replace("@name", flow(owner.get("name", name))).replace("@here", here)
    hint = hint.replace("@key", key).replace("[@]", listed).replace("@", flow(value))
    return _LONG_VALUE.sub(r"did you mean `\1`?", hint)


_LONG_VALUE: Final = re.compile(r"\Awrite `(\w+): …`\Z")
"""A hint whose value is too long to be shown: only the key changes."""


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


def _rotation(word: str, value: Any) -> tuple[str, str] | None:
    """Returns the entry of a pose for a rotation in another notation, and how its numbers are read."""
    found = _vector(value)
    if len(found) == 4:
        turned = flow([found[-1], *found[:-1]])
        if word == "xyzw":
            return f"q: {turned}", "w first"
        other = "" if word in {"q", "wxyz"} else f"; if w is the last number, `q: {turned}`"
        return f"q: {flow(found)}", f"w first{other}"
    if len(found) != 3:
        return None
    if word.endswith("deg") or any(abs(one) > 2 * math.pi for one in found if isinstance(one, int | float)):
        return f"rpy_deg: {flow(found)}", "in degrees"
    return f"rpy: {flow(found)}", "in radians, or `rpy_deg` in degrees"


def _vector(value: Any) -> list[Any]:
    """Returns the parts of a list, also those that are expressions; of a string, its numbers."""
    return list(value) if is_sequence(value) else numbers(value)


def _rotation_in_pose(key: _Key) -> str | None:
    entry = _rotation(key.word, key.value)
    return entry and f"write `{entry[0]}`, {entry[1]}"


def _pose(pose: str, key: _Key) -> str | None:
    """Returns a hint for a pose whose position and rotation are keys beside it, or have the names of a URDF or SDF."""
    if key.word in ROTATIONS.split():
        place, turn = key.among(pose, *PLACES.split()), _rotation(key.word, key.value)
        place, note = place.get("p") if is_mapping(place) else place, f", {turn[1]}" if turn else ""
        lead = f"write it in the {pose}: "
    elif is_mapping(key.value):
        inner = _Key(key.word, None, key.value)
        place, note, lead = inner.among(*PLACES.split()), "", "write "
        turn = next((entry for word in ROTATIONS.split() if (entry := _rotation(word, inner.among(word)))), None)
    else:
        return None
    parts = [f"p: {flow(_vector(place))}"] * (len(_vector(place)) == 3) + ([turn[0]] if turn else [])
    return f"{lead}`{pose}: {{{', '.join(parts)}}}`{note}" if turn or (parts and lead == "write ") else None


def _coordinates(key: _Key) -> str | None:
    """Returns a hint for coordinates that are written one by one."""
    entry, names = ("p", "xyz") if key.word in {"x", "y", "z"} else ("rpy", ("roll", "pitch", "yaw"))
    found = numbers([key.owner.get(name, 0) for name in names])
    return f"write `{entry}: {flow(found)}`" if found else None


def shape_hint(found: Mapping[str, Any], choices: Sequence[str]) -> str | None:
    """Returns a hint for a mapping without a `type`. `choices`: the types that it may have."""
    shape = _shape(found, choices)
    return None if shape is None else f"write `{flow(shape)}`"


def _shape(found: Mapping[str, Any], choices: Sequence[str]) -> dict[str, Any] | None:
    """Returns the shape that a mapping means: one whose type is a key, another key's value, or told by its sizes."""
    types = {key: kind for key in found if (kind := synonym(key, choices))}
    words = {key: kind for key, one in found.items() if isinstance(one, str) and (kind := synonym(one, choices))}
    key, kind = next(iter([*types.items(), *words.items()]), (None, None))
    sizes = {name: one for name, one in found.items() if name not in words and name != key}
    if kind is None and not sizes.keys().isdisjoint(("type", "shape")):
        return None  # of a type that is no shape
    inner = found[key] if key in types else None
    if is_mapping(inner):
        sizes |= inner
    elif inner is not None:
        sizes |= {"half_size" if len(numbers(inner)) == 3 else "file" if isinstance(inner, str) else "radius": inner}
    made = dict(_size(name, one) for name, one in sizes.items())
    guesses = (("half_size", "box"), ("file", "convex_mesh"), ("half_length", "capsule"), ("radius", "sphere"))
    kind = kind or next((guess for size, guess in guesses if size in made and guess in choices), None)
    return {"type": kind, **made} if kind and made else None


def synonym(word: str, choices: Sequence[str]) -> str | None:
    """Returns the one of some words that another means; None if there is none."""
    return next((one for one in (word, *VALUE_SYNONYMS.get(word, ())) if one in choices), None)


def _size(key: str, value: Any) -> tuple[str, Any]:
    """Returns the key and value here for a size of a shape in another notation."""
    word, found = snake_case(key), numbers(value)
    if word in _FILES.split():
        return "file", value
    near, *_ = HALVES.get(word, (key,))
    if near == key or not found:
        return key, value
    return near, [one / 2 for one in found] if len(found) > 1 else found[0] / 2


_TYPES: Final = "box sphere capsule cylinder plane convex_mesh triangle_mesh"
_FILES: Final = "file filename mesh_file path uri src"
_SHAPE_WORDS: Final = " ".join(("half_size half_length radius", *HALVES, _FILES, _TYPES, "mesh cube ball type shape"))


def _shape_of_body(key: _Key) -> str | None:
    """Returns a hint for a shape that is written as keys of a body."""
    if "shapes" in key.owner:
        return None
    if is_sequence(key.value) and key.value and all(map(is_mapping, key.value)):
        return f"write `shapes: {flow(key.value)}`"
    found = {name: one for name, one in key.owner.items() if snake_case(name) in _SHAPE_WORDS.split()}
    if is_mapping(key.value) and key.word not in _TYPES.split():
        found = key.value
    shape = _shape(found, _TYPES.split())
    return None if shape is None else f"write `shapes: [{flow(shape)}]`"


def _body_type(key: _Key) -> str | None:
    """Returns a hint for `type: static`, or a switch that means a body type."""
    if key.word == "type":
        meant = isinstance(key.value, str) and synonym(key.value, ("static", "kinematic", "dynamic"))
        return f"write `body_type: {meant}`" if meant else None
    is_off = key.value is False or key.value == 0
    meant = next((one for one in ("kinematic", "dynamic", "static") if one in key.word), "static")
    meant = "dynamic" if key.word == "movable" else meant
    return f"write `body_type: {meant if not is_off else 'static' if meant == 'dynamic' else 'dynamic'}`"


_FRICTIONS: Final = "friction mu mu1 lateral_friction"
_PHYSICAL: Final = "static_friction dynamic_friction restitution"


def _physical(key: _Key) -> str:
    """Returns the entry of a material for numbers that are written beside it."""
    found: dict[str, Any] = {name: key.owner[name] for name in _PHYSICAL.split() if name in key.owner}
    friction = key.among(*_FRICTIONS.split())
    if friction is not None:
        first = friction[0] if is_sequence(friction) and friction else friction
        found = {"static_friction": first, "dynamic_friction": first} | found
    return f"physical: {flow(found)}"


def _angle_of_view(key: _Key) -> str | None:
    found = re.match(r"\d+(?:\.\d+)?", str(key.value)) if isinstance(key.value, str | int | float) else None
    if found is None:
        return None
    is_small = float(found[0]) < math.pi and not key.word.endswith("deg") and "deg" not in str(key.value)
    other = f"`fovy: {found[0]}` in radians" if is_small else "`fovy` in radians"
    return f"write `fovy_deg: {found[0]}`, the vertical angle of view in degrees, or {other}"


def _robot_file(key: _Key) -> str | None:
    """Returns a hint for the file of an entity, by its suffix."""
    suffix = key.value.rpartition(".")[2].lower() if isinstance(key.value, str) else ""
    keys = {"urdf": "urdf", "xml": "mjcf", "mjcf": "mjcf", "yaml": "use", "yml": "use"}
    return f"write `{keys[suffix]}: {flow(key.value)}`" if suffix in keys else None


def _shape_switch(key: _Key) -> str | None:
    """Returns a hint for `collision: false` or `visual: false` of a body."""
    if not isinstance(key.value, bool):
        return None
    other = "visuals" if key.word == "collision" else "collisions"
    return "remove it: `shapes` collide and are visible" if key.value else f"write `{other}` instead of `shapes`"


def _gravity(key: _Key) -> str | None:
    vector = gravity(key.value)
    return vector and f"write it under `physics`: `physics: {{gravity: {vector}}}`"


def gravity(value: Any) -> str | None:
    """Returns gravity as a vector, if it is written as a number, a switch or three numbers."""
    found = numbers(value)
    if value is True:
        return None
    if not value:
        return "[0, 0, 0]"
    return flow([0, 0, -abs(found[0])]) if len(found) == 1 else flow(found) if len(found) == 3 else None


def _frequency(key: _Key) -> str | None:
    found = numbers(key.value)
    if len(found) != 1 or found[0] <= 0:
        return None
    return f"write `physics: {{timestep: {flow(1 / found[0])}}}` [s], one divided by the frequency"


def _brightness(key: _Key) -> str | None:
    """Returns a hint for the brightness of a light beside its colour."""
    colors, factor = numbers(key.owner.get("color", [1, 1, 1])), numbers(key.value)
    if len(factor) != 1 or len(colors) != 3:
        return None
    return f"write `color: {flow([factor[0] * one for one in colors])}`: its numbers also set the brightness"


def _look_at(key: _Key) -> str | None:
    """Returns a hint for the position of a camera and its target beside its pose."""
    place = key.among("eye", "pose", *PLACES.split())
    eye = numbers(place.get("p") if is_mapping(place) else place)
    target = numbers(key.among("look_at", "lookat", "target") or [0, 0, 0])
    if len(eye) != 3 or len(target) != 3:
        return None
    return f"write it in the pose: `pose: {{p: {flow(eye)}, look_at: {flow(target)}}}`"


def _entity(key: _Key) -> str | None:
    entry = f"{{{key.word}: {flow(key.value)}}}"
    return f"write it under `entities`: `entities: {entry}`" if is_mapping(key.value) else None


def _positions(key: _Key) -> str | None:
    return None if len(numbers(key.value)) == 4 else f"write `qpos: {flow(key.value)}`"


def _limits(key: _Key) -> str | None:
    """Returns a hint for the limits of a joint in the keys of a URDF."""
    pair = key.value if is_mapping(key.value) else key.owner
    ends = ("lower", "lower_limit", "min"), ("upper", "upper_limit", "max")
    found = [x for names in ends for one in names if one in pair for x in numbers(pair[one])]
    return f"write `limits: {flow(found)}`" if len(found) == 2 else None


def _look_of_shape(key: _Key) -> str | None:
    """Returns what to write for properties of the appearance that are beside the `material` of a shape."""
    material = key.owner.get("material", {})
    if not is_mapping(material) or not is_mapping(material.get("visual", {})):
        return None
    if key.word == "visual" and not is_mapping(key.value):
        return None
    added = key.value if key.word == "visual" else {key.word: key.value}
    visual = {**material.get("visual", {}), **added}
    return f"write it in the material: `material: {flow({**material, 'visual': visual}, 2 * _LONGEST)}`"


MAKERS: Final[tuple[tuple[str, str, Callable[[_Key], str | None]], ...]] = (
    ("ArticulationKeys PartKeys", "q", _positions),
    ("SceneFile", "robot table cube box arm object", _entity),
    ("PoseMapping", ROTATIONS, _rotation_in_pose),
    ("PoseMapping", "x y z roll pitch yaw", _coordinates),
    ("ShapeKeys EntityKeys PartKeys CameraSpec LightKeys FrameSpec", ROTATIONS, partial(_pose, "pose")),
    ("TreeJoint", ROTATIONS, partial(_pose, "origin")),
    ("ShapeKeys EntityKeys PartKeys CameraSpec LightKeys FrameSpec", f"{PLACES} origin", partial(_pose, "pose")),
    ("RigidBodyKeys", "collision visual", _shape_switch),
    (
        "VisualKeys",
        (
            "visual emission emission_texture roughness roughness_texture metallic metallic_texture specular ior "
            "transmission transmission_roughness transmission_texture normal_texture base_color base_color_texture"
        ),
        _look_of_shape,
    ),
    ("RigidBodyKeys", "file filename path uri src model mesh robot xml", _robot_file),
    ("CameraSpec", "fov fov_deg", _angle_of_view),
    ("SceneFile", "gravity", _gravity),
    ("PhysicsSpec SceneFile", "sim_freq control_freq frequency fps hz", _frequency),
    ("LightKeys", " ".join(BRIGHTNESS), _brightness),
    ("CameraSpec", "look_at lookat eye target", _look_at),
    ("ConstraintKeys JointKeys TreeJoint", "limit lower upper lower_limit upper_limit min max", _limits),
    (
        "RigidBodyKeys",
        (
            "type static immovable is_static fixed fix freeze frozen locked fix_root_link fix_base fixed_base "
            "kinematic is_kinematic dynamic is_dynamic movable"
        ),
        _body_type,
    ),
    ("RigidBodyKeys", f"{_SHAPE_WORDS} geometry geom geoms collider", _shape_of_body),
    (
        "ShapeKeys BodyKeys LinkKeys ArticulationKeys",
        f"{_FRICTIONS} {_PHYSICAL}",
        lambda key: f"write it in the material: `material: {{{_physical(key)}}}`",
    ),
    ("Material", f"{_FRICTIONS} {_PHYSICAL}", lambda key: f"write `{_physical(key)}`"),
)
"""Models, unknown keys, and what makes a hint of their values. The first hint is used."""
