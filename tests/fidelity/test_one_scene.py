"""What is drawn for one scene alone is what the first scene of several has: in the plan, the engine and the script."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from fidelity.compare import assert_same_scene, scene_facts
from fidelity.test_emit_python import run_script

from scenecc import compile_scene, load_scene
from scenecc.inspect import summarize
from scenecc.plan import ScenePlan, Value
from scenecc.plan.json_codec import plan_to_json

Form = Callable[[Any, Any], Any]
MANY = 5

NUMERIC: dict[str, Form] = {
    "uniform": lambda a, b: {"uniform": sorted([a, b])},
    "log_uniform": lambda a, b: {"log_uniform": sorted([a, b])},
    "normal": lambda a, b: {"normal": [a, 0.1], "clip": sorted([a, b])},
    "computed": lambda a, b: f"${{{a} + ({b} - {a}) * u}}",
}
ANY: dict[str, Form] = {
    "choice": lambda a, b: {"choice": [a, b, a, b]},
    "weights": lambda a, b: {"choice": [a, b], "weights": [0, 1]},
    "cycle": lambda a, b: {"cycle": [b, a]},
    "map": lambda a, b: {"per_scene": {"0": b, "default": a}},
    "nested": lambda a, b: {"cycle": [{"choice": [a, b, b]}, a]},
}
FORMS = {**NUMERIC, **ANY}


def document(form: Form, numeric: Form, folder: Path) -> dict[str, Any]:
    """Every kind of field, each with a form. `numeric`: one where only numbers will do; files differ by `form`."""
    n = numeric

    def three(a: float, b: float) -> list[Any]:
        return [n(a, b), a, n(b, a)]

    mesh = {"type": "convex_mesh", "file": form(str(folder / "rock.obj"), str(folder / "wedge.obj"))}
    paint = {"visual": {"roughness": n(0.2, 0.8), "base_color": [*three(0.1, 0.9), n(0.5, 1)], "ior": n(1.1, 1.5)}}
    rub = {"physical": {"static_friction": n(0.5, 0.8), "dynamic_friction": n(0.2, 0.4), "restitution": n(0.1, 0.9)}}
    ball = {"type": "sphere", "radius": n(0.1, 0.2)}
    seen = {"body_type": "kinematic", "visuals": [ball]}
    bodies: dict[str, Any] = {
        "box": {"pose": three(1, 2), "shapes": [{"type": "box", "half_size": three(0.1, 0.2)}]},
        "turned": {"pose": {"p": three(1, 2), "rpy_deg": three(10, 20)}, "shapes": [ball]},
        "about": {"pose": {"axis_angle": {"axis": "z", "angle": n(0.1, 0.2)}}, "shapes": [ball]},
        "any_way": {"pose": {"q": "uniform"}, "shapes": [ball]},
        "static": {"body_type": "static", "pose": three(3, 4), "shapes": [ball]},
        "upon": {"pose": {"p": three(3, 4), "relative_to": "static"}, "shapes": [ball]},
        "rod": {"shapes": [{"type": "capsule", "radius": n(0.1, 0.2), "half_length": n(0.3, 0.4), "axis": "z"}]},
        "can": {"shapes": [{"type": "cylinder", "radius": n(0.1, 0.2), "half_length": 0.3, "pose": three(1, 2)}]},
        "mesh": {"shapes": [{**mesh, "scale": n(0.5, 1.5)}]},
        "heavy": {"mass": n(1, 2), "linear_damping": n(0.1, 0.2), "shapes": [ball]},
        "fast": {"linear_velocity": three(1, 2), "angular_velocity": three(1, 2), "shapes": [ball]},
        "inert": {"inertial": {"mass": n(1, 2), "com": three(1, 2), "inertia": [n(1, 1.1), 1, 1]}, "shapes": [ball]},
        "light": {"density": n(100, 200), "gravity": form(True, False), "shapes": [ball]},
        "made": {"material": form("one", "other"), "shapes": [ball, {**ball, "material": form("other", "one")}]},
        "rubbed": {"material": {**rub, **paint}, "shapes": [ball]},
        "near": {"shapes": [{**ball, "contact_offset": n(0.02, 0.03), "rest_offset": n(0.001, 0.01)}]},
        "seen": {**seen, "color": form("#ff0000", "#00ff0080"), "visibility": n(0.2, 1)},
        "iterated": {"solver_position_iterations": form(5, 9), "shapes": [ball]},
        "picked": {"variants": [{"shapes": [ball]}, {"shapes": [ball, ball], "mass": n(1, 2)}], "pick": form(0, 1)},
    }  # fmt: skip
    materials = {"one": rub, "other": {**rub, **paint}}
    draws = {"u": {"uniform": [0, 1]}}
    return {"scenecc": 1, "materials": materials, "draws": draws, "entities": bodies}


def row(plan: ScenePlan, node: Any, *, of: str = "") -> Any:
    """All that a part of a plan says of the first scene, with what its tables hold in place of the indices."""
    if isinstance(node, Value):
        found = node.row(0).tolist()
        if of.endswith(("file", "_texture")):
            return plan.files[found].uri
        return found
    if isinstance(node, tuple):
        return [row(plan, item, of=of) for item in node]
    names = [item.name for item in fields(node) if item.compare] if hasattr(node, "__dataclass_fields__") else []
    if not names:
        return node
    said = {name: row(plan, getattr(node, name), of=name) for name in names}
    if type(node).__name__ == "CollisionShape" and said["material"] is not None:
        said["material"] = row(plan, plan.physical_materials[said["material"]])
    if type(node).__name__ == "VisualShape" and said["material"] is not None:
        said["material"] = row(plan, plan.visual_materials[said["material"]])
    return said


def first(plan: ScenePlan) -> list[Any]:
    """All that is said of the first scene."""
    return [
        (entity.name, row(plan, entity.pose), row(plan, entity.structure(0)), entity.pose.recipe is None)
        for entity in plan.entities
    ]


@pytest.mark.parametrize("name", FORMS)
def test_one_scene_is_the_first_of_several(name: str, meshes: dict[str, Path], tmp_path: Path) -> None:
    form = ANY.get(name, ANY["choice"])
    given = document(form, FORMS[name], meshes["rock"].parent)
    one, several = (compile_scene(given, num_scenes=count, seed=3, allow_outside_assets=True) for count in (1, MANY))
    assert first(one) == first(several)
    assert compile_scene_again(one) == one
    with load_scene(one, render=False) as alone, load_scene(several, render=False) as batch:
        assert_same_scene(alone.scenes[0], batch.scenes[0])
        assert [entry.mass for entry in summarize(one, alone)] == [entry.mass for entry in summarize(several, batch)]
        assert len(summarize(one, None)) == len(one.entities)
        facts = scene_facts(alone.scenes[0])
        alone.reset(seed=8)
        batch.reset(seed=8)
        assert_same_scene(alone.scenes[0], batch.scenes[0])
    if name in {"choice", "uniform"}:
        assert run_script(one, tmp_path)[0] == [facts]


def compile_scene_again(plan: ScenePlan) -> ScenePlan:
    """A plan by way of its JSON."""
    return compile_scene(plan_to_json(plan), allow_outside_assets=True)
