"""What is drawn belongs to its entity, field, scene and seed alone, through the whole compiler."""

from __future__ import annotations

import copy
from collections.abc import Callable
from random import Random
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from plugins.nightly import examples
from plugins.structures import body_of

from scenecc import Difference, compare_scenes, compile_scene
from scenecc.plan.diff import diff_plans

RANDOMS = st.integers(0, 2**32).map(Random)
"""What scenes are made of: to draw each form by Hypothesis takes longer than to compile it."""

Make = Callable[[Random], Any]

# Each scene holds several fields of each kind, drawn apart.
few = settings(max_examples=examples(40))


def number(random: Random) -> float:
    return round(random.uniform(0.1, 2), 3)


def vector(random: Random) -> list[float]:
    return [number(random) for _ in range(3)]


def between(random: Random, make: Make) -> list[Any]:
    low, high = make(random), make(random)
    return sorted((low, high)) if make is number else [list(map(min, low, high)), list(map(max, low, high))]


def varying(random: Random, make: Make) -> Any:
    """A plain value, an expression, or one of the forms that take any number of scenes."""
    items = [make(random) for _ in range(random.randint(1, 3))]
    bounds = between(random, make)
    mean, std = (number(random), 0.1) if make is number else (vector(random), [0.1, 0, 0.2])
    return random.choice(
        [
            items[0],
            "${u + 0.5}" if make is number else ["${u}", {"uniform": [0.1, "${1 + u}"]}, "${scene + 1}"],
            {"cycle": items},
            {"choice": items},
            {"choice": [items[0], {"uniform": bounds}], "weights": [1, 3]},
            {"per_scene": {"0": items[0], "default": {"cycle": items}}},
            {"uniform": bounds},
            {"log_uniform": bounds},
            {"normal": [mean, std], "clip": bounds},
        ]
    )


def body(random: Random) -> dict[str, Any]:
    rotation = random.choice([{}, {"q": "uniform"}, {"rpy": [0, 0, varying(random, number)]}])
    made: dict[str, Any] = {
        "pose": {"p": varying(random, vector), **rotation},
        "mass": varying(random, number),
        "linear_velocity": varying(random, vector),
        "shapes": [{"type": "box", "half_size": varying(random, vector)}],
    }
    if random.random() < 0.5:
        ball = {"shapes": [{"type": "sphere", "radius": varying(random, number)}]}
        made["variants"] = [ball, {}]
        made["pick"] = random.choice([{"cycle": [0, 1]}, {"integers": [0, 1]}, {"choice": [0, 1]}])
    return made


def arm(random: Random) -> dict[str, Any]:
    """A tree of two joints that move."""

    def link(of: str, **joint: Any) -> dict[str, Any]:
        """A link on a joint."""
        shape = {"type": "box", "half_size": varying(random, vector)}
        return {"name": of, "joint": joint, "mass": varying(random, number), "shapes": [shape]}

    axis = varying(random, vector)
    slide = link("slide", name="s", type="prismatic", origin=varying(random, vector), axis=axis, limits=[0, 0.5])
    turn = link("turn", name="t", type="revolute", friction=varying(random, number), limits_deg=[-20, 180])
    qpos = random.choice([{"t": varying(random, number)}, {"uniform": [[0, -0.1], [0.5, 1]]}, [0.1, 0.2]])
    return {
        "pose": {"p": varying(random, vector)},
        "qpos": qpos,
        "drives": {"s|t": {"stiffness": varying(random, number), "target": varying(random, number)}},
        "root": {"name": "base", "shapes": [{"type": "sphere", "radius": 0.1}], "children": [slide, turn]},
    }


def entity(random: Random) -> dict[str, Any]:
    return random.choice([body, body, arm])(random)


def held(random: Random) -> dict[str, Any]:
    """What holds on to the entity `a`, whatever that is."""
    spring = {"stiffness": varying(random, number), "damping": varying(random, number)}
    pose = {"p": varying(random, vector), "rpy": [0, 0, varying(random, number)]}
    made: dict[str, Any] = {
        "constraints": {"tie": {"type": "drive", "parent": "world", "child": "a", "drive": {"x": spring}}},
        "lights": {"lamp": {"type": "point", "color": varying(random, vector), "position": varying(random, vector)}},
        "cameras": {"eye": {"pose": pose, "fovy": varying(random, number), "mount": "a"}},
    }
    made["constraints"]["tie"]["pose_in_parent"] = pose
    return {section: made[section] for section in made if random.random() < 0.5}


def scene_of(random: Random) -> dict[str, Any]:
    return {
        "scenecc": 1,
        "num_scenes": 6,
        "seed": random.randint(0, 3),
        "draws": {"u": {"uniform": [0.1, 1]}},
        "entities": {name: entity(random) for name in random.choice(["a", "ab", "abc"])},
        **held(random),
    }


BUILT = ("entities", "constraints", "lights", "cameras")


def built(found: list[Difference]) -> list[tuple[str, str]]:
    """What differs of what is built. What resets give may differ beside it: they leave a draw alone as soon as anything
    built reads it.
    """
    entities = [one for one in found if one.section in BUILT and "at reset" not in f"{one.a} {one.b}"]
    return [(one.kind, one.name) for one in entities]


@given(RANDOMS)
@few
def test_a_scene_does_not_differ_from_itself(random: Random) -> None:
    scene = scene_of(random)
    assert compare_scenes(scene, copy.deepcopy(scene)) == []


@given(RANDOMS, st.integers(1, 9))
@few
def test_a_scene_is_the_same_among_any_number(random: Random, count: int) -> None:
    scene = scene_of(random)
    assert built(diff_plans(compile_scene(scene), compile_scene(scene, num_scenes=count))) == []


@given(RANDOMS)
@few
def test_an_edit_of_one_entity_leaves_all_others_as_they_were(random: Random) -> None:
    scene = scene_of(random)
    # Of the same kind: what is mounted on an articulation is mounted on its root link.
    make = arm if "root" in scene["entities"]["a"] else body
    edited = {**scene, "entities": {**scene["entities"], "a": make(random)}}
    assert {name for _, name in built(compare_scenes(scene, edited))} <= {"a"}


@given(RANDOMS, st.booleans())
@few
def test_a_new_entity_leaves_all_others_as_they_were(random: Random, first: bool) -> None:
    scene = scene_of(random)
    new, old = {"new": entity(random)}, scene["entities"]
    more = {**scene, "entities": {**new, **old} if first else {**old, **new}}
    assert built(compare_scenes(scene, more)) == [("added", "new")]


@given(RANDOMS, st.integers(0, 100))
@few
def test_another_seed_or_name_draws_otherwise(random: Random, seed: int) -> None:
    made = {**body(random), "mass": {"uniform": [1, 2]}}
    scene = {"scenecc": 1, "num_scenes": 6, "draws": {"u": {"uniform": [0.1, 1]}}, "entities": {"a": made, "b": made}}
    first, second = compile_scene(scene, seed=seed), compile_scene(scene, seed=seed + 1)
    masses = [body_of(plan.entities[i]).mass for plan in (first, second) for i in (0, 1)]
    assert len({mass.data.tobytes() for mass in masses if mass is not None}) == 4
