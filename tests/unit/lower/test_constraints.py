"""Constraints in the plan: what names mean, which scenes there are, where frames stand; inside of instances too."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from scenecc import SceneError, compile_scene, emit_scene, validate
from scenecc.diagnostics import Sink
from scenecc.plan import Constraint, Drive, Mount, ScenePlan
from scenecc.plan.json_codec import plan_from_json

BALL = [{"type": "sphere", "radius": 0.1}]
PAIR = """
scenecc: 1
params: {hung: true, count: 2}
entities:
  hook: {body_type: kinematic, pose: [0, 0, 1], shapes: [{type: sphere, radius: 0.1}]}
  bob: {pose: [0, 0, 0.5], shapes: [{type: sphere, radius: 0.1}]}
constraints:
  rope: {type: distance, parent: hook, child: bob, limits: [0, 0.5], if: "${hung}"}
  pin: {type: connection, parent: world, child: bob, pose_in_parent: [0, 0, 0.75]}
  nail: {repeat: {i: {count: "${count}"}}, name: "nail${i}", type: weld, parent: hook, child: bob}
"""


def plan_of(folder: Path, scene: dict[str, Any], **files: str) -> ScenePlan:
    for name, text in files.items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    file = folder / "scene.yaml"
    file.write_text(yaml.safe_dump({"scenecc": 1, **scene}, sort_keys=False), encoding="utf-8")
    return compile_scene(file)


def by_name(plan: ScenePlan) -> dict[str, Constraint]:
    return {constraint.name: constraint for constraint in plan.constraints}


def position(constraint: Constraint) -> list[list[float]]:
    assert constraint.pose_in_parent is not None
    return constraint.pose_in_parent.data[:, :3].tolist()


@pytest.mark.parametrize(
    ("keys", "code", "words"),
    [
        ({"drive": {"target": 0.5}}, "SC115", "`target` does nothing without `stiffness`"),
        (
            {"drive": {"stiffness": 1, "velocity_target": 1}},
            "SC115",
            "`velocity_target` does nothing without `damping`",
        ),
        ({"limits": [0, 1], "drive": {"stiffness": 1, "target": 90}}, "SC523", "pulls to 90, beyond the limits [0, 1]"),
        (
            {"limits": [0, 1], "drive": {"stiffness": 1, "target": {"uniform": [0, 2]}}},
            "SC523",
            "may pull to 2, beyond the limits [0, 1]",
        ),
    ],
)
@pytest.mark.parametrize("kind", ["hinge", "slider"])
def test_targets_that_are_never_reached_are_told(kind: str, keys: dict[str, Any], code: str, words: str) -> None:
    scene = {
        "scenecc": 1,
        "entities": {"door": {"pose": [0, 0, 1], "shapes": BALL}},
        "constraints": {"tie": {"type": kind, "parent": "world", "child": "door", **keys}},
    }
    (found,) = validate(scene)
    assert (found.code, found.message.endswith(words)) == (code, True)
    assert found.path.startswith("constraints.tie.drive.")


def test_an_instance_has_constraints_of_its_own(tmp_path: Path) -> None:
    scene = {
        "num_scenes": 3,
        "entities": {
            "left": {"use": "pair.yaml", "pose": [1, 0, 0], "scene_idxs": [0, 2]},
            "right": {"use": "pair.yaml", "pose": [2, 0, 0], "with": {"hung": False, "count": 1}, "prefix": ""},
        },
    }
    found = by_name(plan_of(tmp_path, scene, pair=PAIR))
    assert list(found) == ["left/rope", "left/pin", "left/nail0", "left/nail1", "pin", "nail0"]
    assert found["left/rope"].parent == Mount("left/hook")
    assert found["left/rope"].child == Mount("left/bob")
    assert found["left/rope"].scene_idxs == (0, 2)
    assert found["nail0"].scene_idxs == (0, 1, 2)
    # The world of a prefab is where its instance stands.
    assert position(found["left/pin"]) == [[1, 0, 0.75]]
    assert position(found["pin"]) == [[2, 0, 0.75]]
    assert position(found["left/nail0"]) == [[0, 0, -0.5]]


def test_a_varying_instance_takes_its_world_with_it(tmp_path: Path) -> None:
    scene = {"num_scenes": 2, "entities": {"pair": {"use": "pair.yaml", "pose": {"per_scene": [[1, 0, 0], [2, 0, 0]]}}}}
    assert position(by_name(plan_of(tmp_path, scene, pair=PAIR))["pair/pin"]) == [[1, 0, 0.75], [2, 0, 0.75]]


def test_an_included_file_adds_constraints(tmp_path: Path) -> None:
    more = "scenecc: 1\nconstraints:\n  other: {type: weld, parent: world, child: bob}\n"
    scene = {
        "include": ["more.yaml"],
        "entities": {"bob": {"shapes": BALL}},
        "constraints": {"own": {"type": "connection", "parent": "world", "child": "bob"}},
    }
    assert list(by_name(plan_of(tmp_path, scene, more=more))) == ["other", "own"]
    scene["constraints"] = {"other": {"type": "connection", "parent": "world", "child": "bob"}}
    with pytest.raises(SceneError) as caught:
        plan_of(tmp_path, scene, more=more)
    assert [found.code for found in caught.value.diagnostics] == ["SC231"]


def test_left_out_scenes_are_those_of_both_bodies(tmp_path: Path) -> None:
    scene = {
        "num_scenes": 4,
        "entities": {"a": {"scene_idxs": "0:3", "shapes": BALL}, "b": {"scene_idxs": "1:", "shapes": BALL}},
        "constraints": {
            "tie": {"type": "distance", "parent": "a", "child": "b", "limits": {"per_scene": [[0, 1], [0, 2]]}}
        },
    }
    (tie,) = plan_of(tmp_path, scene).constraints
    assert tie.scene_idxs == (1, 2)


def test_frames_follow_the_rows_of_their_bodies(tmp_path: Path) -> None:
    scene = {
        "num_scenes": 4,
        "entities": {
            "a": {"scene_idxs": "0:3", "pose": {"per_scene": [[0, 0, 0], [1, 0, 0], [2, 0, 0]]}, "shapes": BALL},
            "b": {"pose": {"per_scene": [[9, 0, 0], [8, 0, 0], [7, 0, 0], [6, 0, 0]]}, "shapes": BALL},
        },
        "constraints": {"tie": {"type": "weld", "parent": "a", "child": "b", "scene_idxs": [1, 2]}},
    }
    (tie,) = plan_of(tmp_path, scene).constraints
    assert position(tie) == [[7, 0, 0], [5, 0, 0]]


def test_the_longest_name_is_meant(tmp_path: Path) -> None:
    scene = {
        "entities": {"left": {"use": "pair.yaml"}, "top": {"shapes": BALL}},
        "constraints": {"tie": {"type": "weld", "parent": "left/bob", "child": "top"}},
    }
    assert by_name(plan_of(tmp_path, scene, pair=PAIR))["tie"].parent == Mount("left/bob")


def test_targets_are_reset_time_and_limits_are_not(tmp_path: Path) -> None:
    scene = {
        "entities": {"bob": {"shapes": BALL}},
        "constraints": {
            "tie": {
                "type": "drive",
                "parent": "world",
                "child": "bob",
                "limits": {"x": [0, {"uniform": [1, 2]}]},
                "drive": {"y": {"stiffness": 1}},
                "target": {"p": {"uniform": [[0, 0, 0], [1, 1, 1]]}},
                "velocity_target": {"linear": {"uniform": [[0, 0, 0], [1, 1, 1]]}},
            }
        },
    }
    (tie,) = plan_of(tmp_path, scene).constraints
    assert isinstance(tie.joint, Drive)
    assert tie.joint.target is not None
    assert tie.joint.target.recipe is not None
    assert tie.joint.linear_velocity_target is not None
    assert tie.joint.linear_velocity_target.recipe is not None
    assert tie.joint.limits[0].limits.recipe is None


def test_a_plan_with_constraints_is_read_back(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, {"entities": {"left": {"use": "pair.yaml"}}}, pair=PAIR)
    sink = Sink()
    again = plan_from_json(emit_scene(plan, "json"), base=tmp_path, sink=sink)
    assert not sink.diagnostics()
    assert again == plan


def arm(qpos: Any) -> dict[str, Any]:
    """At (1, 0, 0) and looking along y: half a metre on, a link that turns about z, and one that is pushed from it."""
    turn = {"name": "turn", "type": "revolute", "origin": [0.5, 0, 0], "axis": "z", "limits": [-3, 3]}
    push = {"name": "push", "type": "prismatic", "origin": [0, 0, 1], "axis": "x", "limits": [0, 1]}
    tip = {"name": "tip", "joint": push, "shapes": BALL}
    upper = {"name": "upper", "joint": turn, "shapes": BALL, "children": [tip]}
    root = {"name": "base", "shapes": BALL, "children": [upper]}
    return {"pose": {"p": [1, 0, 0], "rpy_deg": [0, 0, 90]}, "fix_root_link": True, "qpos": qpos, "root": root}


def test_poses_are_composed_through_joints(tmp_path: Path) -> None:
    tie = {"type": "weld", "parent": "world", "child": "arm/tip"}
    (found,) = plan_of(tmp_path, {"entities": {"arm": arm([np.pi / 2, 0.25])}, "constraints": {"tie": tie}}).constraints
    # Turned to -x and pushed along that.
    assert np.allclose(position(found), [[1 - 0.25, 0.5, 1]], rtol=0, atol=1e-12)


def test_poses_are_composed_through_joints_that_differ_from_scene_to_scene(tmp_path: Path) -> None:
    hook = {"body_type": "kinematic", "shapes": BALL}
    ties = {
        "there": {"type": "weld", "parent": "world", "child": "arm/tip"},
        "back": {"type": "weld", "parent": "arm/tip", "child": "hook"},
    }
    entities = {"arm": arm({"per_scene": [[np.pi / 2, 0.25], [0, 0.5]]}), "hook": hook}
    found = by_name(plan_of(tmp_path, {"num_scenes": 2, "entities": entities, "constraints": ties}))
    assert np.allclose(position(found["there"]), [[1 - 0.25, 0.5, 1], [1, 1, 1]], rtol=0, atol=1e-12)
    # The tip looks along -x, then along y.
    assert np.allclose(position(found["back"]), [[1 - 0.25, 0.5, -1], [-1, 1, -1]], rtol=0, atol=1e-12)


DRAWN = {"uniform": [[0, 0, 1], [1, 1, 2]]}


@pytest.mark.parametrize(
    ("pose", "written", "told"),
    [
        (DRAWN, {}, ["SC343"]),
        (DRAWN, {"pose_in_parent": [0, 0, 1]}, []),
        ({"per_scene": [[0, 0, 1]]}, {}, []),
        ({"p": [0, 0, 1], "relative_to": "hook"}, {}, ["SC343"]),
        ({"p": [0, 0, 1], "relative_to": "hook"}, {"parent": "hook"}, []),
        ({"p": DRAWN, "relative_to": "hook"}, {"parent": "hook"}, ["SC343"]),
    ],
)
def test_a_constraint_that_a_reset_tears_at_is_told(pose: Any, written: dict[str, Any], told: list[str]) -> None:
    scene = {
        "scenecc": 1,
        "entities": {
            "hook": {"body_type": "kinematic", "pose": DRAWN, "shapes": BALL},
            "bob": {"pose": pose, "shapes": BALL},
        },
        "constraints": {"tie": {"type": "weld", "parent": "world", "child": "bob", **written}},
    }
    assert [found.code for found in validate(scene)] == told
