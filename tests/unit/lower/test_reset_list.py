"""The list of what a reset draws anew, field by field, however the field is written."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

from scenecc import compile_scene
from scenecc.plan import ScenePlan, Value
from scenecc.variation.evaluation import Batch, to_field_rows

SCENES = 5

BODY = "entities: {a: {KEYS, shapes: [{type: box, half_size: [0.1, 0.2, 0.1]}]}}"
KINEMATIC = "entities: {a: {body_type: kinematic, KEYS, shapes: [{type: box, half_size: [0.1, 0.2, 0.1]}]}}"
ARM = """
entities:
  arm:
    fix_root_link: true
    KEYS
    root:
      name: base
      shapes: [{type: sphere, radius: 0.1}]
      children:
        - name: bar
          shapes: [{type: sphere, radius: 0.1}]
          joint: {name: hinge, type: revolute, axis: y, limits: [-2, 2]}
"""
TIE = """
entities: {a: {pose: [0, 0, 1], shapes: [{type: sphere, radius: 0.1}]}}
constraints: {tie: {type: drive, child: a, parent: world, pose_in_parent: [0, 0, 1], KEYS}}
"""
HINGE = TIE.replace("type: drive", "type: hinge")
LIGHT = "lights: {l: {type: point, KEYS}}"
SUN = "lights: {l: {type: directional, KEYS}}"
CAMERA = "cameras: {c: {KEYS}}"
LOOK = BODY.replace("KEYS", "material: {visual: {KEYS}}")
SURFACE = BODY.replace("KEYS", "material: {physical: {KEYS}}")
PLACED = """
entities:
  table: {body_type: static, shapes: [{type: box, half_size: [2, 2, 0.1]}]}
  a: {place: {on: table, KEYS}, shapes: [{type: sphere, radius: 0.05}]}
"""

FIELDS: dict[str, tuple[str, str, int | str, float, float]] = {
    "position": (BODY, "pose: {p: VALUE}", 3, 0, 1),
    "rotation": (BODY, "pose: {rpy: VALUE}", 3, 0, 1),
    "rotation in degrees": (KINEMATIC, "pose: {rpy_deg: VALUE}", 3, 0, 90),
    "axis of a rotation": (BODY, "pose: {axis_angle: {axis: VALUE, angle: 1}}", 3, 0.1, 1),
    "angle of a rotation": (BODY, "pose: {axis_angle: {axis: z, angle_deg: VALUE}}", 0, 0, 90),
    "look_at": (KINEMATIC, "pose: {look_at: VALUE}", 3, 0.1, 1),
    "pose as a position": (BODY, "pose: VALUE", 3, 0, 1),
    "linear_velocity": (BODY, "linear_velocity: VALUE", 3, 0, 1),
    "angular_velocity": (BODY, "angular_velocity: VALUE", 3, 0, 1),
    "qpos": (ARM, "qpos: VALUE", 1, 0, 1),
    "qpos by name": (ARM, "qpos: {hinge: VALUE}", 0, 0, 1),
    "qvel": (ARM, "qvel: VALUE", 1, 0, 1),
    "mass": (BODY, "mass: VALUE", 0, 1, 2),
    "com": (BODY, "com: VALUE", 3, 0, 0.1),
    "com of a link": (ARM, "links: {bar: {com: VALUE}}", 3, 0, 0.1),
    "inertial mass": (BODY, "inertial: {mass: VALUE, inertia: [1, 1, 1]}", 0, 1, 2),
    "inertial com": (BODY, "inertial: {mass: 1, com: VALUE, inertia: [1, 1, 1]}", 3, 0, 0.1),
    "inertia": (BODY, "inertial: {mass: 1, inertia: VALUE}", 3, 1, 1.1),
    "linear_damping": (BODY, "linear_damping: VALUE", 0, 0, 1),
    "angular_damping": (BODY, "angular_damping: VALUE", 0, 0, 1),
    "gravity": (BODY, "gravity: VALUE", "flag", 0, 1),
    "mass of a link": (ARM, "links: {bar: {mass: VALUE}}", 0, 1, 2),
    "gravity of a link": (ARM, "links: {bar: {gravity: VALUE}}", "flag", 0, 1),
    "static_friction": (SURFACE, "static_friction: VALUE", 0, 0.5, 1),
    "dynamic_friction": (SURFACE, "dynamic_friction: VALUE", 0, 0, 0.3),
    "restitution": (SURFACE, "restitution: VALUE", 0, 0, 1),
    "friction": (ARM, "joints: {hinge: {friction: VALUE}}", 0, 0, 1),
    "armature": (ARM, "joints: {hinge: {armature: VALUE}}", 0, 0, 1),
    "limits": (ARM, "joints: {hinge: {limits: VALUE}}", "pair", 0, 1),
    "limits_deg": (ARM, "joints: {hinge: {limits_deg: VALUE}}", "pair", 0, 90),
    "max_velocity": (ARM, "joints: {hinge: {max_velocity: VALUE}}", 0, 1, 2),
    "stiffness": (ARM, "drives: {hinge: {stiffness: VALUE}}", 0, 1, 2),
    "damping": (ARM, "drives: {hinge: {damping: VALUE}}", 0, 1, 2),
    "force_limit": (ARM, "drives: {hinge: {stiffness: 1, force_limit: VALUE}}", 0, 1, 2),
    "target": (ARM, "drives: {hinge: {stiffness: 1, target: VALUE}}", 0, 0, 1),
    "velocity_target": (ARM, "drives: {hinge: {damping: 1, velocity_target: VALUE}}", 0, 0, 1),
    "gain of a constraint": (TIE, "drive: {x: {stiffness: VALUE}}", 0, 1, 2),
    "target of a constraint": (TIE, "drive: {x: {stiffness: 1}}, target: {p: VALUE}", 3, 0, 1),
    "speed of a constraint": (TIE, "drive: {x: {damping: 1}}, velocity_target: {linear: VALUE}", 3, 0, 1),
    "target of a hinge": (HINGE, "drive: {stiffness: 1, target: VALUE}", 0, 0, 1),
    "speed of a hinge": (HINGE, "drive: {damping: 1, velocity_target: VALUE}", 0, 0, 1),
    "enabled": (TIE, "drive: {x: {stiffness: 1}}, enabled: VALUE", "flag", 0, 1),
    "color": (BODY, "color: VALUE", "color", 0, 1),
    "base_color": (LOOK, "base_color: VALUE", "color", 0, 1),
    "emission": (LOOK, "emission: VALUE", "color", 0, 1),
    "roughness": (LOOK, "roughness: VALUE", 0, 0, 1),
    "metallic": (LOOK, "metallic: VALUE", 0, 0, 1),
    "specular": (LOOK, "specular: VALUE", 0, 0, 1),
    "transmission_roughness": (LOOK, "transmission: 0.5, transmission_roughness: VALUE", 0, 0, 1),
    "color of a light": (LIGHT, "position: [0, 0, 1], color: VALUE", "light", 0, 1),
    "position of a light": (LIGHT, "color: [1, 1, 1], position: VALUE", 3, 0, 1),
    "direction of a light": (SUN, "color: [1, 1, 1], direction: VALUE", 3, 0.1, 1),
    "pose of a light": (SUN, "color: [1, 1, 1], pose: {rpy: VALUE}", 3, 0.1, 1),
    "pose of a camera": (CAMERA, "pose: {p: VALUE, look_at: [5, 5, 0]}", 3, 0, 1),
    "fovy": (CAMERA, "fovy: VALUE", 0, 0.5, 1),
    "fovx_deg": (CAMERA, "fovx_deg: VALUE", 0, 30, 60),
    "intrinsic": (CAMERA, "intrinsic: {fx: VALUE, fy: 500}", 0, 400, 500),
    "orthographic": (CAMERA, "orthographic: {top: VALUE}", 0, 1, 2),
    "near": (CAMERA, "near: VALUE", 0, 0.1, 0.2),
    "far": (CAMERA, "far: VALUE", 0, 10, 20),
    "ambient_light": ("environment: {KEYS}", "ambient_light: VALUE", "light", 0, 1),
    "at": (PLACED, "at: VALUE", 2, 0, 0.5),
    "corner": (PLACED, "region: [VALUE, [1, 1]]", 2, 0, 0.5),
    "yaw": (PLACED, "region: [[0, 0], [1, 1]], yaw: VALUE", 0, 0, 1),
    "height": (PLACED.replace("on:", "above:"), "at: [0, 0], height: VALUE", "pair", 0, 1),
}
"""Field → the document, the keys, how many numbers or of which kind it is, and between what they are drawn."""


def writings() -> Iterator[tuple[str, str, str]]:
    """Every field with every way to write it: a form, a form in a component, an expression that gives it whole."""
    for name, (_, _, kind, low, high) in FIELDS.items():
        one = f"{{uniform: [{low}, {high}]}}"
        count = {"pair": 2, "color": 3, "light": 3}.get(str(kind), kind)
        if kind == "flag":
            yield name, "form", "{choice: [true, false]}"
            yield name, "expression", '"${u > 0.5}"'
            continue
        number = f"({low} + {high - low} * u)"
        if not count:
            yield name, "form", one
            yield name, "expression", f'"${{{number}}}"'
            continue
        assert isinstance(count, int)
        halves = [(low, high)] * count if kind != "pair" else [(low, (low + high) / 2), ((low + high) / 2, high)]
        lows, highs = zip(*halves, strict=True)
        yield name, "form", f"{{uniform: [{list(lows)}, {list(highs)}]}}"
        yield name, "component", str([*lows[:-1], {"uniform": list(halves[-1])}]).replace("'", "")
        items = ", ".join([*map(str, lows[:-1]), f"({lows[-1]} + {highs[-1] - lows[-1]} * u)"])
        yield name, "expression", f'"${{[{items}]}}"'
        if kind in {"color", "light"}:
            yield name, "form of texts", '{choice: ["#102030", "#405060"]}'
            yield name, "expression of texts", '"${paint}"'


def plan_of(name: str, written: str, seed: int) -> ScenePlan:
    document, keys, *_ = FIELDS[name]
    draws = 'draws: {u: {uniform: [0, 1]}, paint: {choice: ["#102030", "#405060"]}}\n' if "${" in written else ""
    text = f"scenecc: 1\n{draws}{document.replace('KEYS', keys.replace('VALUE', written))}\n"
    return compile_scene(io.StringIO(text), num_scenes=SCENES, seed=seed)


def values(node: Any) -> Iterator[Value]:
    """All values of a plan, in order."""
    if isinstance(node, Value):
        yield node
    elif isinstance(node, tuple):
        for one in node:  # pyright: ignore[reportUnknownVariableType]
            yield from values(one)
    elif is_dataclass(node):
        for field in fields(node):
            if field.name not in {"origin", "draws"}:
                yield from values(getattr(node, field.name))


@pytest.mark.parametrize(("name", "way", "written"), list(writings()))
def test_it_is_drawn_anew_as_a_fresh_build_draws_it(name: str, way: str, written: str) -> None:
    del way
    plan, fresh = plan_of(name, written, 0), plan_of(name, written, 8)
    batch = Batch(np.arange(SCENES), 8, SCENES, dict(plan.draws), {})
    drawn = 0
    for one, other in zip(values(plan), values(fresh), strict=True):
        if one.recipe is None:
            # What is placed is where the recipes of its placement put it.
            assert np.array_equal(one.data, other.data) or name in {"at", "corner", "yaw", "height"}
            continue
        if FIELDS[name][0].startswith(PLACED[:40]) and one.data.shape[1:] == (7,):
            continue
        rows = to_field_rows(batch.evaluate(one.recipe))
        wanted = np.broadcast_to(other.data, (SCENES, *other.data.shape[1:]))
        assert rows.astype(wanted.dtype).tobytes() == wanted.tobytes()
        drawn += rows.tobytes() != np.broadcast_to(one.data, wanted.shape).astype(rows.dtype).tobytes()
    assert drawn
