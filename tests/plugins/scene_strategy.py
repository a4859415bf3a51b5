"""Valid scene documents for Hypothesis, drawn from the models of the language: a new key needs no edit here.

What a key may hold follows from its type, with a narrower range here and there. What may not stand side by side, and
which names exist, is mended afterwards: the rules across fields, one a function. Those of articulations, and of what
holds on to entities, stand in `articulation_rules` and `held_rules`.
"""

from __future__ import annotations

import copy
import math
import re
import typing
from collections.abc import Callable, Iterator
from itertools import chain
from random import Random
from typing import Any

import annotated_types
from hypothesis import strategies as st
from plugins import articulation_rules, held_rules, placing_rules
from plugins.expectations import GOOD
from plugins.scene_models import ARTICULATIONS, PARTS, Key, branches, is_model, leaves, parts
from plugins.scene_nodes import (
    COPIES,
    FALLBACK,
    KINDS,
    SHAPE_LISTS,
    articulations,
    bodies,
    colliding,
    drop,
    is_copied,
    links,
    nodes,
    shapes,
    units,
)
from pydantic import StringConstraints

from scenecc.checks.physics import DYNAMIC_FIELDS, LANGUAGE_KEYS, VISUAL_FIELDS
from scenecc.spec.articulation import ArticulationKeys, ChildLink, MjcfKeys, TreeJoint, TreeKeys, TreeLink, UrdfKeys
from scenecc.spec.attachments import PartKeys
from scenecc.spec.base import NAME_PATTERN, REFERENCE_PATTERN
from scenecc.spec.body import BodySpec
from scenecc.spec.document import SceneFile
from scenecc.spec.mesh_shapes import CoacdKeys
from scenecc.spec.physics import DefaultMaterial, InertialSpec, PhysicsSpec
from scenecc.spec.pose import AxisAngle, PoseMapping
from scenecc.spec.primitive_shapes import PlaneKeys
from scenecc.spec.rendering import CubeMapKeys, EnvironmentSpec
from scenecc.spec.repetition import CopyKeys
from scenecc.spec.shapes import CollisionKeys, MeshFileKeys, Physical, TextureMapping

FOLDER = GOOD
"""The folder that the files of a document are relative to."""

MESHES = ("assets/tetra.obj", "assets/pair.obj")
IMAGES = ("assets/checker.png", "./assets/checker.png")

ENTITIES = ("a", "b", "_c", "D.1", "e-f", "World")
FRAMES = ("f", "g.0")
CAMERAS = ("eye", "Cam.2", "_v")
"""They share one namespace with entities and frames; what other sections hold has one for each."""

SELECTING = ("entities", "constraints", "lights", "cameras")
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


def _tree(random: Random) -> dict[str, Any]:
    """One to five links, each but the first hung on an earlier one."""
    more = random.randrange(len(articulation_rules.LINK_NAMES))
    made = [_model(random, TreeLink), *(_model(random, ChildLink) for _ in range(more))]
    for number, link in enumerate(made):
        drop(link, "joint")
        if number:
            link["joint"] = _model(random, TreeJoint)
            made[random.randrange(number)].setdefault("children", []).append(link)
    return made[0]


def _parts(random: Random, most: int) -> dict[str, Any]:
    """Some parts of an articulation; the rules give them their links."""
    names = random.sample(ENTITIES, random.randint(0, most))
    return {name: _model(random, random.choice(PARTS)) for name in names}


NARROWER: dict[Key, Make] = {
    (SceneFile, "scenecc"): _one_of(1),
    (SceneFile, "num_scenes"): _one_of(1, 2, 3, 4),
    (SceneFile, "seed"): _one_of(0, 7, 2**70),
    (SceneFile, "params"): _one_of({}, {"size": 1.5, "parts": {"type": "list", "default": []}}),
    (SceneFile, "draws"): _one_of({}, {"u": {"uniform": [0, 1]}, "v": "${2 * u}", "w": {"cycle": ["a", "b"]}}),
    (SceneFile, "include"): _one_of([]),
    (PhysicsSpec, "timestep"): _between(0.001, 0.02),
    (PhysicsSpec, "cpu_workers"): _one_of(0),
    (PhysicsSpec, "contact_offset"): _between(0.011, 0.05),
    (PhysicsSpec, "rest_offset"): _between(-0.01, 0.009),
    (CollisionKeys, "contact_offset"): _between(0.011, 0.05),
    (CollisionKeys, "rest_offset"): _between(-0.01, 0.009),
    (Physical, "restitution"): _between(0, 1),
    (DefaultMaterial, "restitution"): _between(0, 1),
    (InertialSpec, "inertia"): _three(_between(1, 2)),
    (PoseMapping, "q"): _one_of(*_TURNS, "uniform"),
    (PoseMapping, "look_at"): lambda random: [random.uniform(20, 30), random.randint(-9, 9), random.uniform(-9, 9)],
    (PoseMapping, "matrix"): _one_of(
        [[0, -1, 0, 1], [1, 0, 0, 2.5], [0, 0, 1, -3], [0, 0, 0, 1]],
        [[-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
    ),
    (AxisAngle, "axis"): lambda random: random.choice(["x", "y", "z", _direction(random)]),
    (PlaneKeys, "normal"): _direction,
    (MeshFileKeys, "file"): _one_of(*MESHES),
    (TextureMapping, "file"): _one_of(*IMAGES),
    (CoacdKeys, "seed"): _one_of(0, 9),
    (CopyKeys, "repeat"): _one_of({"i": {"count": 2}}, {"i": [-1, 1]}, {"j": [0], "i": {"count": 3}}),
    (CopyKeys, "if_"): _one_of(True, False),
    (TreeKeys, "root"): _tree,
    (TreeLink, "children"): _one_of([]),
    **{(TreeLink, shapes): lambda random, of=shapes: _shape_list(random, of) for shapes in SHAPE_LISTS},
    (TreeJoint, "axis"): lambda random: random.choice(["x", "y", "z", _direction(random)]),
    (UrdfKeys, "urdf"): _one_of(*(file for file in articulation_rules.FILES if file.endswith("urdf"))),
    (UrdfKeys, "scale"): _between(0.5, 3),
    (UrdfKeys, "srdf"): _one_of("none"),
    (UrdfKeys, "package_dir"): _one_of("articulations"),
    (MjcfKeys, "mjcf"): _one_of(*(file for file in articulation_rules.FILES if file.endswith("xml"))),
    (MjcfKeys, "keyframe"): _one_of("up"),
    (MjcfKeys, "visual_groups"): _one_of([0], [0, 1, 2], [0, 5]),
    (ArticulationKeys, "attach"): lambda random: _parts(random, 2),
    (PartKeys, "attach"): lambda random: _parts(random, random.randint(0, 1)),
    (PartKeys, "to"): _one_of(""),
    (PartKeys, "prefix"): _one_of(""),
    (PartKeys, "ignore"): _one_of([]),
    (EnvironmentSpec, "map"): lambda random: random.choice(["assets/sky.png", _model(random, CubeMapKeys)]),
    **{(CubeMapKeys, face): _one_of(*IMAGES) for face in CubeMapKeys.model_fields},
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
    made.pop("starts", None)  # a file that only `settle` can make
    for rule in RULES:
        rule(made, random)
    return made


def _model(random: Random, model: Any) -> dict[str, Any]:
    """A mapping with all required keys and half of the others."""
    if model is BodySpec:
        model = random.choice([BodySpec, BodySpec, BodySpec, *ARTICULATIONS])
    return {
        field.alias or name: _key(random, model, name)
        for name, field in model.model_fields.items()
        if field.is_required() or name == "entities" or random.random() < 0.5
    }


def _shape_list(random: Random, name: str) -> list[dict[str, Any]]:
    """At most one shape of a link, for an articulation has several links."""
    made = _value(random, TreeLink.model_fields[name].annotation, [], name)
    return made[:1]


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
            least = _bound(said, "min_length", 0)
            size = random.randint(least, min(_bound(said, "max_length", 3), least + 3))
            if typing.get_origin(args[0]) is typing.Literal:
                words = typing.get_args(args[0])
                return random.sample(words, min(size, len(words)))  # none of them twice
            return [_value(random, args[0], [], name) for _ in range(size)]
        case origin if origin is dict:
            names = {"frames": FRAMES, "cameras": CAMERAS}.get(name, ENTITIES)
            size = random.randint(0, 3 if name in {"entities", "constraints"} else 2)
            return {entry: _value(random, args[1], [], name) for entry in random.sample(names, size)}
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
            return _one_of(*(color for color in ("#0080ff", "#0080FF80") if re.fullmatch(pattern, color)))
        return _one_of(*IMAGES) if name.endswith("texture") else _text
    low, high = _bound(said, "ge", -10), _bound(said, "le", 10)
    assert kind in (int, float), f"nothing is known of {kind}: teach the strategy"
    if kind is int:
        low, high = max(low, -10), min(_bound(said, "lt", high + 1) - 1, 2**32)
        return lambda random: random.choice([low, high, random.randint(low, high)])
    low = max(low, 0.01 if _bound(said, "gt", -1) == 0 else -10)
    return _between(low, min(high, 10, _bound(said, "lt", math.inf) - 0.01))


def _text(random: Random) -> str:
    text = "".join(random.choice(_TEXT) for _ in range(random.randint(1, 8)))
    return text.replace("${", "$ {")


def _bound(said: list[Any], name: str, otherwise: Any) -> Any:
    values = [getattr(item, name) for item in _flat(said) if getattr(item, name, None) is not None]
    return values[-1] if values else otherwise


def _flat(said: list[Any]) -> Iterator[Any]:
    for item in said:
        # To ask a protocol takes longer than all else that is done here.
        kind = type(item)
        if kind not in _GROUPED:
            _GROUPED[kind] = isinstance(item, annotated_types.GroupedMetadata)
        yield from item if _GROUPED[kind] else [item]


_GROUPED: dict[type, bool] = {}


def _one_rotation(document: dict[str, Any], random: Random) -> None:
    """A pose has one rotation, or a matrix alone; a turn has one angle."""
    for node in nodes(document):
        if "matrix" in node:
            for name in ("p", "anchor", *ROTATIONS):
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
    for one in chain.from_iterable(document.get(section, {}).values() for section in SELECTING):
        if "scene_idxs" not in one:
            continue
        some = random.sample(range(count), random.randint(1, count))
        last = max(some)
        forms = [some, f"{last}:", f":{last + 1}", "::2", [f"{last}:{last + 1}", *(i for i in some if i != last)]]
        one["scene_idxs"] = random.choice([*forms, f"-{count}:"])


def _copies(document: dict[str, Any], random: Random) -> None:
    """Some are repeated or left out; names of copies differ, and nothing else is called by one."""
    for section in SELECTING:
        for name, one in document.get(section, {}).items():
            if random.random() < 0.5:
                drop(one, *COPIES)
            elif "repeat" not in one:
                drop(one, "name")
            elif "name" in one:
                one["name"] = "-".join([name, *(f"${{{variable}}}" for variable in one["repeat"])])


def _relations(document: dict[str, Any], random: Random) -> None:
    """`relative_to` names what stands before it and is in every scene; inside of a body it has no meaning, nor beside a
    `mount`.
    """
    known: list[str] = ["world"]
    for section in ("frames", "entities", "cameras", "lights"):
        for name, placed in document.get(section, {}).items():
            for node in nodes({key: item for key, item in placed.items() if key != "pose"}):
                node.pop("relative_to", None)
            pose = placed.get("pose")
            if isinstance(pose, dict) and "mount" in placed:
                drop(pose, "relative_to")
            if isinstance(pose, dict) and "relative_to" in pose:
                pose["relative_to"] = random.choice(known)
            if section != "lights" and not is_copied(placed) and "scene_idxs" not in placed and "mount" not in placed:
                known.append(name)
                if any(key in placed for key in KINDS):
                    known += [f"{name}/{link}" for link in articulation_rules.robot_of(placed).links]


def _anchors(document: dict[str, Any], random: Random) -> None:
    """Only a body whose shapes end somewhere has an anchor: an articulation would keep some of its joints as built."""
    kept: set[int] = set()
    for body in bodies(document):
        common = shapes(body, *SHAPE_LISTS)
        everything = [
            *common,
            *(shape for variant in body.get("variants", []) for shape in shapes(variant, *SHAPE_LISTS)),
        ]
        if common and not any(shape["type"] == "plane" for shape in everything):
            kept.add(id(body.get("pose")))
    for node in nodes(document):
        if id(node) not in kept:
            drop(node, "anchor")


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


def _terrain(document: dict[str, Any], random: Random) -> None:
    """A heightfield has a grid of heights."""
    for node in nodes(document):
        if node.get("type") == "heightfield":
            drop(node, "file")
            drop(node, "heights")
            node.update(random.choice([{"file": "assets/terrain.png"}, {"heights": [[0, 0.5, 1], [0.25, 0, 0]]}]))


def _rings(document: dict[str, Any], random: Random) -> None:
    """A ring has a wall."""
    for node in nodes(document):
        if "inner_radius" in node:
            node["inner_radius"] = 0.7 * node["outer_radius"]


def _scales(document: dict[str, Any], random: Random) -> None:
    """No scale of 0, and parameters only where something is decomposed."""
    for node in nodes(document):
        if "scale" in node:
            scale = node["scale"]
            node["scale"] = [_scale(item) for item in scale] if isinstance(scale, list) else _scale(scale)
        if "decomposition_params" in node:
            node["decomposition"] = "coacd"


def _scale(item: float) -> float:
    """Never 0, and large enough for a mesh to weigh a milligram."""
    return max(item, 0.2) if item >= 0 else item


def _body_types(document: dict[str, Any], random: Random) -> None:
    """Every body has shapes that mean something, no plane moves, and no key means nothing."""
    for body in bodies(document):
        kind = body.get("body_type", "dynamic")
        if kind == "dynamic" and any(shape["type"] == "plane" for shape in colliding(body)):
            kind = body["body_type"] = random.choice(["static", "kinematic"])
        if kind == "none":
            body["visuals"] = body.get("visuals") or [dict(FALLBACK)]
            body["shapes"], body["collisions"] = [], []
        elif not shapes(body, *SHAPE_LISTS) or (kind == "dynamic" and not colliding(body) and "inertial" not in body):
            body["shapes"] = [dict(FALLBACK)]
        if kind != "dynamic":
            for field in DYNAMIC_FIELDS:
                body.pop(LANGUAGE_KEYS.get(field, field), None)
        if not shapes(body, "shapes", "visuals"):
            for name in (*VISUAL_FIELDS, "color"):
                body.pop(name, None)
        if not colliding(body):
            for name in ("collision_bits", "collision_group", "density"):
                body.pop(name, None)


def _moving_shapes(document: dict[str, Any], random: Random) -> None:
    """A moving triangle mesh is a distance field, and no such field may meet a plane."""
    plane = any(shape["type"] == "plane" for body in bodies(document) for shape in colliding(body))
    for body in _moving(document):
        for shape in colliding(body):
            if shape["type"] == "heightfield":
                shape |= {"type": "box", "half_size": shape.pop("size")}
                drop(shape, "heights")
                drop(shape, "file")
            if shape["type"] == "triangle_mesh":
                shape["sdf"] = True
                if plane:
                    del shape["sdf"]
                    shape["type"] = "convex_mesh"


def _moving(document: dict[str, Any]) -> list[dict[str, Any]]:
    """The bodies that forces move, links among them."""
    free = [body for body in bodies(document) if body.get("body_type", "dynamic") == "dynamic"]
    return [*free, *(link for entity in units(document) for link, _ in links(entity))]


def _masses(document: dict[str, Any], random: Random) -> None:
    """What moves weighs something, and a mass has nothing beside it."""
    for node in nodes(document.get("entities", {})):
        if "inertial" in node:
            drop(node, "mass", "com")
    if articulations(document) or any("inertial" not in body for body in _moving(document)):
        for node in nodes(document):
            if "density" in node:
                node["density"] = max(node["density"], 1)


def _forms(document: dict[str, Any], random: Random) -> None:
    """Some of the values that may vary, as forms that leave them as they are: what goes together stays so."""
    for owner, key, is_number in list(leaves(SceneFile, document)):
        value = owner[key]
        named = key in {"qpos", "qvel"} and isinstance(value, dict)
        if random.random() < 0.9 or named or (isinstance(value, dict) and not WHOLE.isdisjoint(value)):
            continue
        forms: list[dict[str, Any]] = [
            {"cycle": [value]},
            {"choice": [value, copy.deepcopy(value)], "weights": [1, 2]},
            {"per_scene": {"default": value}},
        ]
        of_a_robot = key == "scale" and not {"urdf", "mjcf"}.isdisjoint(owner)  # each value is a robot of its own
        if is_number and not of_a_robot and not _is_endless(value):
            # Of their own each: a fault in a list that stands at two places is told at the first.
            one, other, mean, low, high = (copy.deepcopy(value) for _ in range(5))
            forms += [{"uniform": [one, other]}, {"normal": [mean, 0], "clip": [low, high]}]
            if not isinstance(value, list) and random.random() < 0.3:
                name = f"order_{len(document.setdefault('draws', {}))}"
                document["draws"][name] = {"shuffle": [copy.deepcopy(value) for _ in range(3)]}
                owner[key] = f"${{{name}[1]}}"
                continue
        if key in {"p", "linear_velocity", "angular_velocity"} and isinstance(value, list):
            forms.append({"shuffle": copy.deepcopy(value)})  # any order of these is as good
        form = random.choice(forms)
        owner[key] = {"once": form} if random.random() < 0.2 else form


def _instances(document: dict[str, Any], random: Random) -> None:
    """Some documents use a prefab, and override what is in it."""
    if random.random() < 0.7:
        return
    overrides: list[dict[str, Any]] = [
        {"leg_0": {"pose": {"rpy_deg": [0, 0, {"uniform": [0, 90]}]}, "shapes": {"0": {"material": {}}}}},
        {"leg_1": {"inertial": {"mass": {"uniform": [1, 2]}, "inertia": [1, 1, 1]}}},
        {"arm": {"drives": {".*": {"stiffness": {"choice": [10, 20]}}}, "qpos": {"slide": 0.5}}},
        {"goal": "remove"},
        {"lights/lamp": {"color": {"shuffle": [0.1, 0.5, 1]}}},
        {"cameras/eye": {"fovx_deg": 70}},
        {"constraints/tie": {"enabled": {"choice": [True, False]}}},
        {"frames/spot": {"pose": {"p": [0, 0, 2]}}},
        {"materials/wood": {"physical": {"restitution": {"uniform": [0, 0.5]}}}},
    ]
    chosen = random.sample(overrides, random.randint(1, len(overrides)))
    instance = {
        "use": "expansion/parts/work.yml",
        "if": True,
        "override": dict(chain.from_iterable(map(dict.items, chosen))),
    }
    document["entities"]["instance"] = instance


def _expectations(document: dict[str, Any], random: Random) -> None:
    """What is expected is of entities that exist, in scenes that do."""
    expect = document.get("expect", {})
    plain = ((name, one) for name, one in document["entities"].items() if not is_copied(one) and "use" not in one)
    known = [name for name, one in plain if "scene_idxs" not in one]
    if "settled" in expect and "except" in expect["settled"]:
        expect["settled"]["except"] = random.sample(known, random.randint(0, len(known)))
    if "no_overlap" in expect and "except" in expect["no_overlap"]:
        expect["no_overlap"]["except"] = (
            [random.choices(known, k=2) for _ in range(random.randint(0, 2))] if known else []
        )
    for condition in expect.get("holds", ()):
        if "scene_idxs" in condition:
            condition["scene_idxs"] = random.choice(["::2", [0], ":1"])
        a, b = random.choices(known, k=2) if known else ("", "")
        reads = [
            f"position('{a}')[2] < 1",
            f"distance('{a}', '{b}') > 0",
            f"touching('{a}', '{b}')",
            f"tilt('{a}') < pi",
        ]
        condition["that"] = f"${{{' or '.join(random.sample(reads, 2))}}}" if known else random.choice([True, False])


WHOLE = frozenset(("relative_to", "anchor", "px"))
"""Keys of mappings that no form stands for: it is the same in every scene what a pose is relative to and which
point it places, and six pictures vary one by one."""


def _is_endless(value: Any) -> bool:
    return any(map(math.isinf, value if isinstance(value, list) else [value]))


RULES: tuple[Callable[[dict[str, Any], Random], None], ...] = (
    _one_rotation,
    _copies,
    _selections,
    articulation_rules.tree_links,
    articulation_rules.attachments,
    articulation_rules.files,
    articulation_rules.single_bodies,
    held_rules.mounts,
    _relations,
    _references,
    _friction,
    _rings,
    _terrain,
    _scales,
    _body_types,
    articulation_rules.link_bodies,
    articulation_rules.patterns,
    articulation_rules.whole,
    articulation_rules.joint_numbers,
    _moving_shapes,
    _anchors,
    _masses,
    held_rules.constraints,
    held_rules.lights,
    held_rules.cameras,
    articulation_rules.link_copies,
    _forms,
    _instances,
    placing_rules.placements,
    _expectations,
)
