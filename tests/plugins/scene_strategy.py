"""Valid scene documents for Hypothesis, drawn from the models of the language: a new key needs no edit here.

What a key may hold follows from its type, with a narrower range here and there. What may not stand side by side, and
which names exist, is mended afterwards: the rules across fields, one a function.
"""

from __future__ import annotations

import copy
import math
import typing
from collections.abc import Callable, Iterator
from random import Random
from typing import Any

import annotated_types
from hypothesis import strategies as st
from plugins.expectations import GOOD
from plugins.scene_models import Key, branches, is_model, leaves, parts
from pydantic import StringConstraints

from scenecc.checks.physics import LANGUAGE_KEYS, MOVING, SEEN
from scenecc.spec.base import NAME_PATTERN, REFERENCE_PATTERN
from scenecc.spec.document import SceneFile
from scenecc.spec.inertial import Inertial
from scenecc.spec.material import Physical, TextureMapping
from scenecc.spec.physics import DefaultMaterial, Physics
from scenecc.spec.pose import AxisAngle, PoseMapping
from scenecc.spec.shape_keys import CollisionKeys, FileKeys
from scenecc.spec.shape_types.convex_parts import CoacdKeys
from scenecc.spec.shape_types.plane import PlaneKeys

FOLDER = GOOD
"""The folder that the files of a document are relative to."""

MESHES = ("assets/tetra.obj", "assets/pair.obj")
IMAGES = ("assets/checker.png", "./assets/checker.png")

ENTITIES = ("a", "b", "_c", "D.1", "e-f", "World")
FRAMES = ("f", "g.0")
HELD = ("constraints", "lights", "cameras", "environment")
"""Sections of the document that hold on to entities; they have tests of their own, and so have robots."""

SHAPE_LISTS = ("shapes", "collisions", "visuals")
ROTATIONS = ("q", "rpy", "rpy_deg", "axis_angle", "look_at")

Make = Callable[[Random], Any]

_TURNS = [
    [1, 0, 0, 0],
    [0, 1, 0, 0],
    [-0.5, 0.5, -0.5, 0.5],
    [0.7071068, 0, -0.7071068, 0],
    [0.9238795, 0.0, 0.3826834, 0.0],
    [0.6, 0.8005, 0, 0],
]
_TEXT = "aZ0 _-.:#'\"{}[]$\\&*!%@é→漢🙂"


def _between(low: float, high: float) -> Make:
    """Numbers as people and as programs write them, and the ends of the range."""

    def make(random: Random) -> float:
        whole = range(math.ceil(low), math.floor(high) + 1)
        forms = [random.uniform(low, high), min(max(round(random.uniform(low, high), 2), low), high), low, high]
        return random.choice([*forms, random.choice(whole)] if whole else forms)

    return make


def _one_of(*options: Any) -> Make:
    return lambda random: copy.deepcopy(random.choice(options))


def _three(component: Make) -> Make:
    return lambda random: [component(random) for _ in range(3)]


def _direction(random: Random) -> list[int]:
    direction = [random.randint(-3, 3) for _ in range(3)]
    return direction if any(direction) else [0, 0, -1]


NARROWER: dict[Key, Make] = {
    (SceneFile, "scenecc"): _one_of(1),
    (SceneFile, "num_scenes"): _one_of(1, 2, 3, 4),
    (SceneFile, "seed"): _one_of(0, 7, 2**70),
    (SceneFile, "params"): _one_of({}, {"size": 1.5, "parts": {"type": "list", "default": []}}),
    (SceneFile, "draws"): _one_of({}, {"u": {"uniform": [0, 1]}, "v": "${2 * u}", "w": {"cycle": ["a", "b"]}}),
    (SceneFile, "include"): _one_of([]),
    **{(SceneFile, section): _one_of({}) for section in HELD},
    (Physics, "timestep"): _between(0.001, 0.02),
    (Physics, "cpu_workers"): _one_of(0),
    (Physics, "contact_offset"): _between(0.011, 0.05),
    (Physics, "rest_offset"): _between(-0.01, 0.009),
    (CollisionKeys, "contact_offset"): _between(0.011, 0.05),
    (CollisionKeys, "rest_offset"): _between(-0.01, 0.009),
    (Physical, "restitution"): _between(0, 1),
    (DefaultMaterial, "restitution"): _between(0, 1),
    (Inertial, "inertia"): _three(_between(1, 2)),
    (PoseMapping, "q"): _one_of(*_TURNS, "uniform"),
    (PoseMapping, "look_at"): lambda random: [random.uniform(20, 30), random.randint(-9, 9), random.uniform(-9, 9)],
    (PoseMapping, "matrix"): _one_of(
        [[0, -1, 0, 1], [1, 0, 0, 2.5], [0, 0, 1, -3], [0, 0, 0, 1]],
        [[-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
    ),
    (AxisAngle, "axis"): lambda random: random.choice(["x", "y", "z", _direction(random)]),
    (PlaneKeys, "normal"): _direction,
    (FileKeys, "file"): _one_of(*MESHES),
    (TextureMapping, "file"): _one_of(*IMAGES),
    (CoacdKeys, "seed"): _one_of(0, 9),
}
"""Where the type allows more than any scene can be built of, or not all that it allows is valid."""


def documents() -> st.SearchStrategy[dict[str, Any]]:
    """Valid scene documents as plain data. Their files are relative to `FOLDER`."""
    return randoms().map(document)


def randoms() -> st.SearchStrategy[Random]:
    """Sources of chance. Hypothesis's own, which it could shrink, gives hardly anything but empty documents."""
    return st.integers(0, 2**24 - 1).map(Random)


def document(random: Random) -> dict[str, Any]:
    """One valid scene document."""
    made = _model(random, SceneFile)
    for rule in RULES:
        rule(made, random)
    return made


def _model(random: Random, model: Any) -> dict[str, Any]:
    """A mapping with all required keys and half of the others."""
    return {
        name: _key(random, model, name)
        for name, field in model.model_fields.items()
        if field.is_required() or name == "entities" or random.random() < 0.5
    }


def _key(random: Random, model: Any, name: str) -> Any:
    for owner in model.__mro__:
        if (owner, name) in NARROWER:
            return NARROWER[owner, name](random)
    field = model.model_fields[name]
    return _value(random, field.annotation, list(field.metadata), name)


def _value(random: Random, annotation: Any, said: list[Any], name: str) -> Any:  # noqa: PLR0911 - one a kind of type
    bare, more = parts(annotation)
    said = [*said, *more]
    if options := branches(bare):
        return _value(random, random.choice(options), [], name)
    if is_model(bare):
        return _model(random, bare)
    args = typing.get_args(bare)
    match typing.get_origin(bare):
        case typing.Literal:
            return random.choice(args)
        case origin if origin is tuple:
            return [_value(random, arg, [], name) for arg in args]
        case origin if origin is list:
            size = random.randint(_bound(said, "min_length", 0), _bound(said, "max_length", 3))
            return [_value(random, args[0], [], name) for _ in range(size)]
        case origin if origin is dict:
            names = FRAMES if name == "frames" else ENTITIES
            return {entry: _value(random, args[1], [], name) for entry in random.sample(names, random.randint(0, 2))}
        case _:
            return _scalar(bare, said, name)(random)


def _scalar(kind: Any, said: list[Any], name: str) -> Make:
    if kind is bool:
        return _one_of(True, False)
    if kind is str:
        pattern = next((item.pattern for item in said if isinstance(item, StringConstraints) and item.pattern), None)
        assert pattern is None or isinstance(pattern, str)
        if pattern in {NAME_PATTERN, REFERENCE_PATTERN}:
            return _one_of(*ENTITIES)
        if pattern is not None:
            assert pattern.startswith("^#"), f"nothing is known of {pattern}: teach the strategy"
            return _one_of("#0080ff", "#0080FF80")
        return _one_of(*IMAGES) if name.endswith("_texture") else _text
    low, high = _bound(said, "ge", -10), _bound(said, "le", 10)
    assert kind in (int, float), f"nothing is known of {kind}: teach the strategy"
    if kind is int:
        low, high = max(low, -10), min(_bound(said, "lt", high + 1) - 1, 2**32)
        return lambda random: random.choice([low, high, random.randint(low, high)])
    low = max(low, 0.01 if _bound(said, "gt", -1) == 0 else -10)
    return _between(low, min(high, 10))


def _text(random: Random) -> str:
    text = "".join(random.choice(_TEXT) for _ in range(random.randint(1, 8)))
    return text.replace("${", "$ {")


def _bound(said: list[Any], name: str, otherwise: Any) -> Any:
    values = [getattr(item, name) for item in _flat(said) if getattr(item, name, None) is not None]
    return values[-1] if values else otherwise


def _flat(said: list[Any]) -> Iterator[Any]:
    for item in said:
        yield from item if isinstance(item, annotated_types.GroupedMetadata) else [item]


def nodes(node: Any) -> Iterator[dict[str, Any]]:
    """Every mapping of a document."""
    if isinstance(node, dict):
        yield node
    for item in node.values() if isinstance(node, dict) else node if isinstance(node, list) else ():
        yield from nodes(item)


def _bodies(document: dict[str, Any]) -> list[dict[str, Any]]:
    return list(document.get("entities", {}).values())


def _shapes(body: dict[str, Any], *lists: str) -> list[dict[str, Any]]:
    return [shape for name in lists for shape in body.get(name, [])]


def _one_rotation(document: dict[str, Any], random: Random) -> None:
    """A pose has one rotation, or a matrix alone; a turn has one angle."""
    for node in nodes(document):
        if "matrix" in node:
            for name in ("p", *ROTATIONS):
                node.pop(name, None)
        present = [name for name in ROTATIONS if name in node]
        for name in set(present) - {random.choice(present)} if present else ():
            del node[name]
        if "axis" in node and "type" not in node:
            for name in ("angle", "angle_deg"):
                node.pop(name, None)
            node[random.choice(["angle", "angle_deg"])] = random.uniform(-400, 400)


def _selections(document: dict[str, Any], random: Random) -> None:
    """Scenes that exist, each once."""
    count = document.get("num_scenes", 1)
    for body in _bodies(document):
        if "scene_idxs" not in body:
            continue
        some = random.sample(range(count), random.randint(1, count))
        last = max(some)
        forms = [some, f"{last}:", f":{last + 1}", "::2", [f"{last}:{last + 1}", *(i for i in some if i != last)]]
        body["scene_idxs"] = random.choice([*forms, f"-{count}:"])


def _relations(document: dict[str, Any], random: Random) -> None:
    """`relative_to` names what stands before it and is in every scene; inside of a body it has no meaning."""
    known: list[str] = ["world"]
    for section in ("frames", "entities"):
        for name, placed in document.get(section, {}).items():
            for node in nodes({key: item for key, item in placed.items() if key != "pose"}):
                node.pop("relative_to", None)
            pose = placed.get("pose")
            if isinstance(pose, dict) and "relative_to" in pose:
                pose["relative_to"] = random.choice(known)
            if "scene_idxs" not in placed:
                known.append(name)


def _references(document: dict[str, Any], random: Random) -> None:
    """Materials and collision groups that exist."""
    groups = list(document.get("collision_groups", {}))
    for group in document.get("collision_groups", {}).values():
        group.update({"ignore": [name for name in group["ignore"] if name in groups]} if "ignore" in group else {})
    materials = list(document.get("materials", {}))
    for node in nodes(document.get("entities", {})):
        if isinstance(node.get("material"), str):
            node["material"] = random.choice(materials) if materials else {}
        if "collision_group" in node:
            node.pop("collision_bits", None)
            node["collision_group"] = random.choice(groups) if groups else None
            if not groups:
                del node["collision_group"]


def _friction(document: dict[str, Any], random: Random) -> None:
    """What slides rubs no more than what sticks; what is left out is the default material's."""
    for node in nodes(document):
        given = [node[name] for name in ("static_friction", "dynamic_friction") if name in node]
        if given:
            node["static_friction"], node["dynamic_friction"] = max(given), min(given)


def _scales(document: dict[str, Any], random: Random) -> None:
    """No scale of 0, and parameters only where something is decomposed."""
    for node in nodes(document):
        if "scale" in node:
            scale = node["scale"]
            node["scale"] = [item or 1 for item in scale] if isinstance(scale, list) else scale or 1
        if "decomposition_params" in node:
            node["decomposition"] = "coacd"


def _body_types(document: dict[str, Any], random: Random) -> None:
    """Every body has shapes that mean something, no plane moves, and no key means nothing."""
    fallback = {"type": "sphere", "radius": 0.5}
    for body in _bodies(document):
        kind = body.get("body_type", "dynamic")
        if kind == "dynamic" and any(shape["type"] == "plane" for shape in _shapes(body, "shapes", "collisions")):
            kind = body["body_type"] = random.choice(["static", "kinematic"])
        if kind == "none":
            body["visuals"] = body.get("visuals") or [dict(fallback)]
            body["shapes"], body["collisions"] = [], []
        elif not _shapes(body, *SHAPE_LISTS) or (
            kind == "dynamic" and not _shapes(body, "shapes", "collisions") and "inertial" not in body
        ):
            body["shapes"] = [dict(fallback)]
        if kind != "dynamic":
            for field in MOVING:
                body.pop(LANGUAGE_KEYS.get(field, field), None)
        if not _shapes(body, "shapes", "visuals"):
            for name in (*SEEN, "color"):
                body.pop(name, None)
        if not _shapes(body, "shapes", "collisions"):
            for name in ("collision_bits", "collision_group", "density"):
                body.pop(name, None)


def _moving_shapes(document: dict[str, Any], random: Random) -> None:
    """A moving triangle mesh is a distance field, and no such field may meet a plane."""
    plane = any(s["type"] == "plane" for b in _bodies(document) for s in _shapes(b, "shapes", "collisions"))
    for body in _bodies(document):
        if body.get("body_type", "dynamic") != "dynamic":
            continue
        for shape in _shapes(body, "shapes", "collisions"):
            if shape["type"] == "triangle_mesh":
                shape["sdf"] = True
                if plane:
                    del shape["sdf"]
                    shape["type"] = "convex_mesh"


def _masses(document: dict[str, Any], random: Random) -> None:
    """What moves weighs something, and a mass has nothing beside it."""
    for body in _bodies(document):
        if "inertial" in body:
            body.pop("mass", None)
    if any(body.get("body_type", "dynamic") == "dynamic" and "inertial" not in body for body in _bodies(document)):
        for node in nodes(document):
            if node.get("density") == 0:
                node["density"] = 1


def _forms(document: dict[str, Any], random: Random) -> None:
    """Some of the values that may vary, as forms that leave them as they are: what goes together stays so."""
    for owner, key, is_number in list(leaves(SceneFile, document)):
        value = owner[key]
        if random.random() < 0.9 or (isinstance(value, dict) and "relative_to" in value):
            continue
        forms: list[dict[str, Any]] = [
            {"cycle": [value]},
            {"choice": [value, copy.deepcopy(value)], "weights": [1, 2]},
            {"per_scene": {"default": value}},
        ]
        if is_number:
            forms += [{"uniform": [value, value]}, {"normal": [value, 0], "clip": [value, value]}]
        owner[key] = random.choice(forms)


RULES: tuple[Callable[[dict[str, Any], Random], None], ...] = (
    _one_rotation,
    _selections,
    _relations,
    _references,
    _friction,
    _scales,
    _body_types,
    _moving_shapes,
    _masses,
    _forms,
)
