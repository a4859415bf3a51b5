"""Arbitrary plans for Hypothesis, drawn by the fields of the plan's dataclasses: a new one needs no edit here.

Only what goes beyond one field stands here: that links are a tree, that names differ, that what is held on to is there.
"""

from __future__ import annotations

import math
import string
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from plugins.recipe_strategy import Shape, nodes

from scenecc.plan import (
    ArticulationStructure,
    BodyPair,
    BodyStructure,
    Camera,
    Condition,
    Constraint,
    Drive,
    Entity,
    Heightfield,
    Joint,
    Light,
    Link,
    Mimic,
    Mount,
    Nearness,
    NextTo,
    NoOverlap,
    Placement,
    Reading,
    ScenePlan,
    Settled,
    SettledStart,
    Value,
    recalled,
)
from scenecc.plan.articulation import MOVING_JOINT_FIELDS, NON_LINK_FIELDS
from scenecc.plan.body import AssetFile, NamedFile
from scenecc.plan.properties import ANY, NON_NEGATIVE, Bounds, Quantity
from scenecc.plan.schema import (
    BytesKind,
    ChoiceKind,
    FieldKind,
    ListKind,
    ObjectKind,
    ScalarKind,
    SceneSelectionKind,
    SharedDrawsKind,
    TemplateKind,
    UnionKind,
    VectorKind,
    plan_fields,
)
from scenecc.plan.starts import start_parts
from scenecc.variation.forms import Template
from scenecc.variation.nodes import Const

TABLES = ("files", "physical_materials", "visual_materials")
ONE_DRAW = (("u", Const(0.5)),)
_NAMES = st.text(string.ascii_letters + "_-. '\"\\\n→é", min_size=1, max_size=12)
_MOST = {"entities": 3, "structures": 2, "collisions": 2, "visuals": 2}
_HELD = {"constraints": Constraint, "lights": Light, "cameras": Camera, "placements": Placement}


@dataclass(frozen=True)
class _Scope:
    """`rows`: scenes of the entity; 0 outside of one. `sizes`: of the plan's tables. `draws`: shapes of shared ones."""

    num_scenes: int
    sizes: dict[str, int]
    draws: dict[str, Shape]
    rows: int = 0
    recipes: bool = False
    full: bool = False


@st.composite
def plans(draw: st.DrawFn, *, recipes: bool = False, full: bool = False) -> ScenePlan:
    """Valid plans of a few scenes and entities, whose files lie in /files.

    `recipes`: some have recipes, which take long to draw. `full`: nothing is left out of what may be.
    """
    shared, shapes = draw(_shared_draws()) if recipes else (draw(st.sampled_from([(), ONE_DRAW])), {})
    sizes = {table: draw(st.integers(1, 2)) for table in TABLES}
    scope = _Scope(draw(st.integers(1, 4)), sizes, shapes, recipes=recipes, full=full)
    made: dict[str, Any] = {"num_scenes": scope.num_scenes, "draws": shared}
    names = draw(st.lists(_NAMES, min_size=3 * full, max_size=_MOST["entities"] + 1, unique=True))
    cut = draw(st.integers(2 * full, len(names)))
    for slot in plan_fields(ScenePlan):
        if slot.name in TABLES and isinstance(slot.kind, ListKind):
            size = scope.sizes[slot.name]
            made[slot.name] = tuple(draw(_of(slot.kind.item, scope)) for _ in range(size))
        elif slot.name == "entities":
            made[slot.name] = tuple(_entity(draw, name, scope) for name in names[:cut])
        elif slot.name in _HELD:
            of = (
                names[cut:]
                if slot.name == "cameras"
                else draw(st.lists(_NAMES, min_size=int(full), max_size=1, unique=True))
            )
            held = [_held(draw, _HELD[slot.name], name, made["entities"], scope) for name in of]
            made[slot.name] = tuple(one for one in held if one is not None)
        elif slot.name == "expectations":
            made[slot.name] = draw(_expectations([one.name for one in made["entities"]], scope))
        elif slot.name == "environment":
            environment = _of(slot.kind, replace(scope, rows=scope.num_scenes))
            made[slot.name] = draw(environment if full else st.none() | environment)
        elif slot.name not in made and slot.name != "starts":
            made[slot.name] = draw(_of(slot.kind, scope))
    plan = ScenePlan(**made)
    scenes = range(plan.num_scenes) if full else draw(st.sets(st.integers(0, plan.num_scenes - 1), max_size=2))
    return replace(plan, starts=tuple(SettledStart(7, scene, _state(plan, scene)) for scene in sorted(scenes)))


def _state(plan: ScenePlan, scene: int) -> bytes:
    numbers = [(0.1, 0.2, 0.3, 1, 0, 0, 0, *(0.5 for _ in part.joints)) for part in start_parts(plan, scene)]
    return np.array([number for row in numbers for number in row], "<f4").tobytes()


@st.composite
def _expectations(draw: st.DrawFn, names: list[str], scope: _Scope) -> tuple[Any, ...]:
    """None, or one of each kind, about entities that exist."""
    if not names or not (scope.full or draw(st.booleans())):
        return ()
    a, b = draw(st.sampled_from(names)), draw(st.sampled_from(names))
    length = st.sampled_from([0.0, 0.001, 2.5])
    read = "distance('a', 'b')"
    return (
        Settled("settled", draw(length), draw(length), draw(length), (a,), (b,)),
        NoOverlap("desk/no_overlap", draw(length), (a,), (BodyPair(a, b),)),
        Condition(
            "holds[0]",
            (0,),
            draw(length),
            Template(f"${{{read} > h}}", {"h": draw(length)}),
            "they are apart",
            (Reading(read, "distance", (a, b)),),
        ),
    )


@st.composite
def _shared_draws(draw: st.DrawFn) -> tuple[tuple[tuple[str, Any], ...], dict[str, Shape]]:
    shapes: dict[str, Shape] = {}
    found: list[tuple[str, Any]] = []
    for name in draw(st.lists(st.sampled_from(["u", "prefab/u", "spot"]), max_size=2, unique=True)):
        shape = draw(st.sampled_from([(), (3,), (4,), (7,)]))
        found.append((name, draw(nodes(shape, shapes, 2))))
        shapes[name] = shape
    return tuple(found), shapes


def _entity(draw: st.DrawFn, name: str, scope: _Scope) -> Entity:
    scenes = st.lists(st.integers(0, scope.num_scenes - 1), min_size=1, unique=True)
    idxs = tuple(sorted(draw(scenes)))
    inner = replace(scope, rows=len(idxs))
    pose = next(slot.kind for slot in plan_fields(Entity) if slot.name == "pose")
    one = draw(st.sampled_from([_bodies(inner), _bodies(inner), _articulations(inner)]))
    structures = tuple(draw(st.lists(one, min_size=1, max_size=_MOST["structures"])))
    last = len(structures) - 1
    pick = draw(_values(Quantity("int64", bounds=Bounds(0, last)), inner)) if last else None
    return Entity(name, idxs, draw(_of(pose, inner)), structures, pick, hidden=draw(st.booleans()))


def _bodies(scope: _Scope, *, link: bool = False) -> st.SearchStrategy[BodyStructure]:
    if link:
        return _nodes(BodyStructure, scope, {"body_type": "link", **dict.fromkeys(NON_LINK_FIELDS)})
    types = st.sampled_from(["dynamic", "kinematic", "static", "none"])
    return types.flatmap(lambda body_type: _nodes(BodyStructure, scope, {"body_type": body_type}))


@st.composite
def _articulations(draw: st.DrawFn, scope: _Scope) -> ArticulationStructure:
    names = draw(st.lists(_NAMES, min_size=3 if scope.full else 1, max_size=3, unique=True))
    links = [_link(draw, index, name, scope) for index, name in enumerate(names)]
    joints = [link.joint.name for link in links if link.joint is not None and link.joint.type != "fixed"]
    named = [name for name in joints if name]
    mimics: tuple[Mimic, ...] = ()
    if len(named) > 1 and (scope.full or draw(st.booleans())):
        mimics = (draw(_nodes(Mimic, scope, {"joint": named[1], "source": named[0]})),)
    return draw(_nodes(ArticulationStructure, scope, {"links": tuple(links), "mimics": mimics}))


def _link(draw: st.DrawFn, index: int, name: str, scope: _Scope) -> Link:
    body = draw(_bodies(scope, link=True))
    if index == 0:
        return draw(_nodes(Link, scope, {"name": name, "body": body, "parent": None, "joint": None}))
    fixed = draw(st.integers(0, 4)) == 0
    its = {"name": draw(st.sampled_from(["", f"joint {index}", f"j{index}.é"]))}
    types = st.sampled_from(["revolute", "revolute_unwrapped", "prismatic"])
    its |= {"type": "fixed", **dict.fromkeys(MOVING_JOINT_FIELDS)} if fixed else {"type": draw(types)}
    parent, joint = draw(st.integers(0, index - 1)), draw(_nodes(Joint, scope, its))
    return draw(_nodes(Link, scope, {"name": name, "body": body, "parent": parent, "joint": joint}))


def _held(draw: st.DrawFn, cls: type, name: str, entities: tuple[Entity, ...], scope: _Scope) -> Any:
    """A constraint, light or camera; None of a constraint where there is nothing to constrain."""
    idxs = tuple(range(scope.num_scenes))
    mounts: dict[str, Any] = {}
    if cls is Placement:
        if not entities:
            return None
        names = [one.name for one in entities]
        near = Nearness(names[-1], draw(_floats(NON_NEGATIVE)), draw(_floats(NON_NEGATIVE)))
        mounts = {"target": Mount(names[0]), "members": (Mount(names[-1]),), "carriers": (Mount(names[0]),)}
        mounts |= {"near": (near,) if scope.full else (), "facing": Mount(names[0]) if scope.full else None}
        gap = draw(_floats(NON_NEGATIVE))
        mounts |= {"next_to": NextTo(Mount(names[0]), "left", gap, "max") if scope.full else None}
    for key in () if cls is Placement else ("child", "parent") if cls is Constraint else ("mount",):
        within = [entity for entity in entities if {*idxs} & {*entity.scene_idxs} and _grips(entity)]
        needed = key == "child"
        if not within or not (needed or scope.full or draw(st.booleans())):
            mounts[key] = None
            if needed:
                return None
            continue
        entity = draw(st.sampled_from(within))
        idxs = tuple(sorted({*idxs} & {*entity.scene_idxs}))
        mounts[key] = draw(st.sampled_from(_grips(entity)))
    idxs = idxs if draw(st.booleans()) else idxs[:1]
    return draw(_nodes(cls, replace(scope, rows=len(idxs)), {"name": name, "scene_idxs": idxs, **mounts}))


def _grips(entity: Entity) -> list[Mount]:
    """The entity, or the links that all its structures have."""
    links: list[set[str]] = []
    for structure in entity.structures:
        if not isinstance(structure, ArticulationStructure):
            return [Mount(entity.name)]
        links.append({link.name for link in structure.links})
    return [Mount(entity.name, name) for name in sorted(set.intersection(*links))]


def _of(kind: FieldKind, scope: _Scope, name: str = "") -> st.SearchStrategy[Any]:  # noqa: PLR0911 - one a kind
    match kind:
        case Quantity():
            return _values(kind, scope)
        case ScalarKind():
            return _plain(kind)
        case ChoiceKind():
            return st.sampled_from(kind.options)
        case VectorKind():
            return st.tuples(*[_floats(kind.bounds)] * kind.count)
        case ListKind():
            return st.lists(_of(kind.item, scope), min_size=int(scope.full), max_size=_MOST.get(name, 2)).map(tuple)
        case ObjectKind():
            return _nodes(kind.cls, scope)
        case UnionKind():
            return st.one_of(*[_nodes(cls, scope) for _, cls in kind.by_type])
        case SceneSelectionKind() | SharedDrawsKind() | BytesKind() | TemplateKind():
            raise AssertionError("drawn by those who know the scenes and the files")


@st.composite
def _nodes(draw: st.DrawFn, cls: type, scope: _Scope, its: dict[str, Any] | None = None) -> Any:
    """A dataclass. `its`: fields that are settled."""
    if cls is AssetFile:
        uri = draw(
            st.sampled_from(["a.obj", "sub/b.stl", "../c.png", "pkg://some/d.glb", "asset://e f.ply", "/x/g.obj"])
        )
        names = draw(st.sampled_from([(), (NamedFile("a.mtl", "0" * 64), NamedFile("maps/b.png", "f" * 64))]))
        data = draw(st.sampled_from([None, None, b"ply\n"]))
        uri = uri if data is None else "mesh://egg_2.ply"
        sha256, reader = draw(st.sampled_from([None, "0" * 64])), draw(st.sampled_from([None, "mujoco 4.0.0"]))
        return AssetFile(uri, Path("/files") / uri, sha256, names, data=data, read_by=reader)
    made: dict[str, Any] = dict(its or {})
    if cls is Heightfield:
        made["heights"] = draw(st.sampled_from([((0.0, 0.5, 0.25), (1.0, -1.0, 0.0)), ((0.0, 1.0), (1e-3, 2.0))]))
    full = scope.full or draw(st.sampled_from([False, False, True]))
    for slot in plan_fields(cls):
        if slot.name in made:
            continue
        strategy = _of(slot.kind, scope, slot.name)
        made[slot.name] = draw(st.none() | strategy if slot.nullable and not full else strategy)
    if cls is Drive:
        for name in ("limits", "drives"):
            made[name] = tuple({item.axis: item for item in made[name]}.values())
    return cls(**made)


def _plain(kind: ScalarKind) -> st.SearchStrategy[Any]:
    if kind.type is str:
        return st.text(max_size=20)
    if kind.type is bool:
        return st.booleans()
    return _integers(kind.bounds) if kind.type is int else _floats(kind.bounds)


@st.composite
def _values(draw: st.DrawFn, kind: Quantity, scope: _Scope) -> Value:
    count = 1 if scope.rows < 2 or draw(st.booleans()) else scope.rows
    rows = [draw(_rows(kind, scope)) for _ in range(count)]
    data = np.array(rows, dtype=kind.dtype).reshape(count, *kind.shape)
    data.flags.writeable = False
    if scope.recipes and kind.reset and draw(st.integers(0, 3)) == 0:
        return recalled(data, draw(nodes(kind.shape, scope.draws)))
    return Value(data)


def _rows(kind: Quantity, scope: _Scope) -> st.SearchStrategy[Any]:
    if kind.infinite:
        low = max(kind.bounds.low, ANY.low)
        finite = _floats(Bounds(low, ANY.high))
        pair = st.tuples(finite, finite).map(sorted)
        least = low if kind.bounds.low > ANY.low else -math.inf
        return pair | st.just([least, math.inf]) | finite.map(lambda high: [least, high])
    if kind.pose:
        rotation = st.lists(st.floats(-1, 1), min_size=4, max_size=4).map(_unit)
        return st.tuples(st.lists(_floats(kind.bounds), min_size=3, max_size=3), rotation).map(lambda x: [*x[0], *x[1]])
    if kind.table is not None:
        item: st.SearchStrategy[Any] = st.integers(0, scope.sizes[kind.table] - 1)
    elif kind.dtype == "bool":
        item = st.booleans()
    else:
        item = _integers(kind.bounds) if kind.dtype == "int64" else _floats(kind.bounds)
    return st.lists(item, min_size=kind.shape[0], max_size=kind.shape[0]) if kind.shape else item


def _unit(q: list[float]) -> list[float]:
    length = math.sqrt(sum(x * x for x in q))
    return [x / length for x in q] if length > 1e-3 else [1.0, 0.0, 0.0, 0.0]


def _integers(bounds: Bounds) -> st.SearchStrategy[int]:
    return st.integers(int(max(bounds.low, -(2**31))), int(min(bounds.high, 2**31 - 1)))


def _floats(bounds: Bounds) -> st.SearchStrategy[float]:
    low = None if bounds.low == -math.inf else bounds.low
    high = None if bounds.high == math.inf else bounds.high
    found = st.floats(low, high, allow_nan=False, allow_infinity=False)
    return found.filter(bool) if bounds.nonzero else found
