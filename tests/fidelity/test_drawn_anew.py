"""What a reset draws anew: each field against the same file built with that seed, by properties and in motion."""

from __future__ import annotations

import io
import pickle
from textwrap import dedent, indent
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from fidelity.compare import assert_same_scene, assert_same_trajectory

import scenecc
from scenecc.backends.sapien import SceneBatch

if TYPE_CHECKING:
    from pathlib import Path

SCENES = 4

BODIES = """
scenecc: 1
entities:
  ground: {{body_type: static, shapes: [{{type: plane}}]}}
  cube:
    pose: [0, 0, 0.2]
    linear_velocity: [1, 0.3, 0]
    angular_velocity: [0, 3, 1]
    shapes: [{{type: box, half_size: [0.1, 0.05, 0.03]}}, {{type: sphere, radius: 0.04, pose: [0.1, 0, 0]}}]
    {cube}
  other: {{pose: [0.15, 0, 0.5], shapes: [{{type: sphere, radius: 0.06}}]}}
"""

ARM = """
scenecc: 1
entities:
  arm:
    pose: [0, 0, 1]
    fix_root_link: true
    qvel: {{near: 1.5}}
    {arm}
    root:
      name: base
      shapes: [{{type: box, half_size: [0.1, 0.1, 0.1]}}]
      children:
        - name: upper
          shapes: [{{type: box, half_size: [0.2, 0.02, 0.02], pose: [0.2, 0, 0]}}]
          joint: {{name: near, type: revolute, axis: y, limits: [-1, 1]}}
          children:
            - name: lower
              shapes: [{{type: box, half_size: [0.2, 0.02, 0.03], pose: [0.2, 0, 0]}}]
              joint:
                name: far
                type: revolute
                axis: z
                origin: {{p: [0.4, 0, 0], rpy: [0.3, 0, 0.1]}}
                limits: [-1, 1]
"""

DRIVE = """
scenecc: 1
entities:
  cube: {{pose: [0, 0, 0.5], shapes: [{{type: box, half_size: [0.1, 0.05, 0.03]}}]}}
constraints:
  tie:
    type: drive
    child: cube
    parent: world
    pose_in_parent: [0.1, 0, 0.7]
    drive: {{x: {{stiffness: 20, damping: 1}}, z: {{stiffness: 500, damping: 10}}, slerp: {{stiffness: 2}}}}
    {tie}
"""

TIE = """
scenecc: 1
entities:
  cube: {{pose: [0, 0, 0.5], shapes: [{{type: box, half_size: [0.1, 0.05, 0.03]}}]}}
  ball: {{pose: [0.3, 0, 0.5], linear_velocity: [0, 1, 0], shapes: [{{type: sphere, radius: 0.05}}]}}
constraints:
  tie: {{child: cube, parent: ball, {tie}}}
  hold:
    {{type: distance, child: cube, parent: world, limits: [0, 0.1], stiffness: 50, enabled: {{choice: [true, false]}}}}
"""

FRICTION = "static_friction: {uniform: [0.5, 1]}"
INERTIAL = "inertial: {{mass: {}, com: {}, inertia: {}}}"
COM = "{p: {uniform: [[0.1, -0.01, -0.01], [0.2, 0.01, 0.01]]}, rpy: [0.1, 0, {uniform: [0, 1]}]}"

CASES = {
    "mass": (BODIES, "mass: {uniform: [0.5, 2]}"),
    "mass by a shared draw": (BODIES, "mass: '${2 * u}'"),
    "inertial": (
        BODIES,
        INERTIAL.format("{uniform: [1, 2]}", COM, "{uniform: [[0.01, 0.01, 0.01], [0.015, 0.015, 0.015]]}"),
    ),
    "com": (BODIES, "com: {uniform: [[-0.05, -0.02, -0.02], [0.05, 0.02, 0.02]]}\n    mass: {uniform: [0.5, 2]}"),
    "linear_damping": (BODIES, "linear_damping: {uniform: [0, 2]}"),
    "angular_damping": (BODIES, "angular_damping: {uniform: [0, 2]}"),
    "gravity": (BODIES, "gravity: {choice: [true, false]}"),
    "gravity by a shared draw": (BODIES, "gravity: '${u > 0.75}'"),
    "static_friction": (BODIES, f"material: {{physical: {{{FRICTION}}}}}"),
    "dynamic_friction": (BODIES, "material: {physical: {dynamic_friction: {uniform: [0, 0.3]}}}"),
    "restitution": (BODIES, "material: {physical: {restitution: {uniform: [0, 1]}}}"),
    "link mass": (ARM, "links: {upper: {mass: {uniform: [0.5, 2]}}}"),
    "link com": (ARM, "links: {'.*er': {com: [{uniform: [0.1, 0.3]}, 0.01, 0]}}"),
    "link inertial": (ARM, "links: {upper: {" + INERTIAL.format("2", COM, "[0.01, 0.02, 0.015]") + "}}"),
    "links inertial": (ARM, "links: {'.*er': {" + INERTIAL.format("2", COM, "[0.01, 0.02, 0.015]") + "}}"),
    "link damping": (ARM, "links: {'.*': {linear_damping: {uniform: [0, 2]}, angular_damping: {uniform: [0, 1]}}}"),
    "link gravity": (ARM, "links: {lower: {gravity: {choice: [true, false, true]}}}"),
    "joint friction": (ARM, "joints: {'.*': {friction: {uniform: [0, 0.2]}}}"),
    "armature": (ARM, "joints: {'.*': {armature: {uniform: [0, 0.2]}}}"),
    "max_velocity": (ARM, "joints: {near: {max_velocity: {uniform: [0.1, 2]}}}"),
    "limits": (ARM, "joints: {near: {limits: [{uniform: [-1, -0.5]}, {uniform: [0.1, 0.3]}]}}"),
    "limits that hold qpos": (
        ARM,
        "joints: {near: {limits: [{uniform: [0.1, 0.2]}, {uniform: [0.3, 1]}]}}\n    qpos: {near: {uniform: [0, 2]}}",
    ),
    "limits in degrees that 0 is outside of": (ARM, "joints: {near: {limits_deg: [{uniform: [5, 10]}, 60]}}"),
    "stiffness": (ARM, "drives: {'.*': {stiffness: {uniform: [1, 50]}, damping: 1}}"),
    "damping": (ARM, "drives: {'.*': {stiffness: 20, damping: {uniform: [0, 5]}}}"),
    "force_limit": (ARM, "drives: {'.*': {stiffness: 50, damping: 1, target: 0.5, force_limit: {uniform: [0.1, 3]}}}"),
    "constraint stiffness": (DRIVE, "drive: {x: {stiffness: {uniform: [1, 50]}, damping: 1}, z: {stiffness: 500}}"),
    "enabled": (DRIVE, "drive: {z: {stiffness: 500, damping: 10}}\n    enabled: {choice: [true, false]}"),
    "enabled by a shared draw": (
        DRIVE,
        "drive: {z: {stiffness: 500, damping: 10}}\n    limits: {x: [0, 0], y: [0, 0]}\n    enabled: '${u > 0.75}'",
    ),
    "enabled weld": (TIE, "type: weld, enabled: '${u > 0.75}'"),
    "enabled connection": (TIE, "type: connection, enabled: {choice: [false, true]}"),
    "enabled hinge": (TIE, "type: hinge, enabled: {choice: [false, '${u > 0.75}']}"),
    "constraint damping": (DRIVE, "drive: {slerp: {stiffness: 5, damping: {uniform: [0, 5]}}, z: {stiffness: 500}}"),
    "constraint force_limit": (DRIVE, "drive: {z: {stiffness: 500, force_limit: {uniform: [1, 9]}}}"),
}


def document(case: str) -> str:
    """The scene file of a case."""
    text, keys = CASES[case]
    if text is DRIVE:
        text = text.replace(text[text.index("    drive:") : text.index("    {tie}")], "")
    found = text.format(cube=keys, arm=keys, tie=keys)
    return found.replace("scenecc: 1\n", "scenecc: 1\ndraws: {u: {uniform: [0.5, 1]}}\n") if "${" in keys else found


def loaded(text: str, seed: int = 0, **options: Any) -> SceneBatch:
    return scenecc.load_scene(io.StringIO(text), num_scenes=SCENES, seed=seed, render=False, **options)


def components(batch: SceneBatch, name: str) -> list[Any]:
    """What the simulation has of an entity, by scene."""
    return [obj.components[0] for obj in batch.entities[name].objs]


def assert_same(batch: SceneBatch, fresh: SceneBatch) -> None:
    for ours, theirs in zip(batch.scenes, fresh.scenes, strict=True):
        assert_same_scene(ours, theirs)


@pytest.mark.parametrize("case", CASES)
def test_a_reset_is_the_file_built_with_that_seed(case: str) -> None:
    batch, fresh, built = loaded(document(case)), loaded(document(case), seed=8), loaded(document(case))
    with pytest.raises(AssertionError):
        assert_same(batch, fresh)  # it is drawn at all
    batch.step(20)
    batch.reset(seed=8, exact=True)
    assert_same(batch, fresh)
    assert_same_trajectory(batch.scenes, fresh.scenes)
    batch.reset(seed=0)
    assert_same(batch, built)


@pytest.mark.parametrize("case", ["inertial", "links inertial", "limits that hold qpos", "static_friction"])
def test_some_scenes_are_drawn_as_they_all_would_be(case: str) -> None:
    batch, fresh, built = loaded(document(case)), loaded(document(case), seed=8), loaded(document(case))
    batch.step(5)
    batch.reset(seed=8, scene_idxs=[2, 1])
    batch.reset(scene_idxs=[0, 3])
    for index, (ours, other) in enumerate(zip(batch.scenes, fresh.scenes, strict=True)):
        assert_same_scene(ours, other if index in {1, 2} else built.scenes[index])


@pytest.mark.parametrize("case", CASES)
def test_a_state_holds_what_is_drawn(case: str) -> None:
    batch, other = loaded(document(case)), loaded(document(case), seed=3)
    batch.reset(seed=5)
    batch.step(7)
    state = pickle.loads(pickle.dumps(batch.state()))
    assert state.drawn
    for each in (batch, other):
        each.set_state(state, exact=True)
        assert each.state() == state
    assert_same_trajectory(batch.scenes, other.scenes)


@pytest.mark.parametrize("case", CASES)
def test_a_plan_read_back_is_reset_alike(case: str) -> None:
    plan = scenecc.compile_scene(io.StringIO(document(case)), num_scenes=SCENES)
    batch = scenecc.load_scene(io.StringIO(scenecc.emit_scene(plan, "json")), render=False)
    batch.reset(seed=8, exact=True)
    assert_same(batch, loaded(document(case), seed=8))


def test_one_material_a_scene_is_drawn_for_all_that_have_it() -> None:
    text = dedent("""
        scenecc: 1
        materials: {rubber: {physical: {static_friction: {uniform: [0.5, 1]}}}}
        entities:
          a: {material: rubber, shapes: [{type: sphere, radius: 0.1}, {type: sphere, radius: 0.1, pose: [1, 0, 0]}]}
          b: {scene_idxs: "1::2", pose: [3, 0, 0], material: rubber, shapes: [{type: sphere, radius: 0.1}]}
    """)
    batch = loaded(text)
    batch.reset(seed=4)
    fresh = loaded(text, seed=4)

    def materials(of: SceneBatch, name: str) -> list[list[Any]]:
        return [[shape.physical_material for shape in body.collision_shapes] for body in components(of, name)]

    for name in ("a", "b"):
        found, wanted = ([[one.static_friction for one in row] for row in materials(of, name)] for of in (batch, fresh))
        assert found == wanted
    first = [row[0] for row in materials(batch, "a")]
    assert len(set(map(id, first))) == SCENES
    assert all(one is other for one, other in materials(batch, "a"))


def test_which_material_a_shape_has_stays_as_built() -> None:
    choice = "{choice: [{physical: {restitution: {uniform: [0.6, 1]}}}, {physical: {restitution: 0.5}}]}"
    batch = loaded(BODIES.format(cube=f"material: {choice}"), seed=3)

    def restitutions() -> list[float]:
        return [body.collision_shapes[0].physical_material.restitution for body in components(batch, "cube")]

    before = restitutions()
    batch.reset(seed=4)
    assert len({one == 0.5 for one in before}) == 2
    assert [one == other for one, other in zip(before, restitutions(), strict=True)] == [one == 0.5 for one in before]


def test_only_what_is_drawn_is_written() -> None:
    """A friction and a damping that were changed by hand stay, beside a mass that is drawn."""
    # A material of its own: that of SAPIEN's process would keep the friction for all that comes after.
    keys = "mass: {uniform: [0.5, 2]}\n    material: {physical: {static_friction: 0.5}}"
    batch = loaded(BODIES.format(cube=keys))
    body = components(batch, "cube")[0]
    body.linear_damping = 3
    body.collision_shapes[0].physical_material.static_friction = 0.9
    batch.reset(seed=1)
    assert body.linear_damping == 3
    assert np.float32(body.collision_shapes[0].physical_material.static_friction) == np.float32(0.9)


def test_limits_that_are_infinite_in_some_scene_stay_as_built() -> None:
    limits = "joints: {near: {limits: [-1, {choice: [.inf, 1]}]}}"
    batch = loaded(ARM.format(arm=limits), seed=1)
    built = batch.articulations["arm"].qlimits.copy()
    assert np.isinf(built).any()
    batch.reset(seed=2)
    assert np.array_equal(batch.articulations["arm"].qlimits, built)


def test_what_a_size_reads_stays_as_built() -> None:
    text = "mass: '${10 * half}'\n" + indent("shapes: [{type: box, half_size: ['${half}', 0.1, 0.1]}]", " " * 4)
    text = f"scenecc: 1\ndraws: {{half: {{uniform: [0.1, 0.2]}}}}\nentities:\n  cube:\n    {text}\n"
    batch = loaded(text)
    masses = [body.mass for body in components(batch, "cube")]
    batch.reset(seed=3)
    assert [body.mass for body in components(batch, "cube")] == masses


def test_it_wakes_what_it_changes() -> None:
    batch = loaded(BODIES.format(cube="mass: {uniform: [0.5, 2]}"))
    batch.step(600)
    body = components(batch, "cube")[0]
    assert body.is_sleeping
    batch.reset(seed=1)
    assert not body.is_sleeping


URDF = """
<robot name="arm">
  <link name="base"/>
  <link name="bar">
    <inertial><mass value="2"/><inertia ixx="0.01" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="base"/><child link="bar"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>
"""


def test_the_inertia_of_a_file_scales_with_a_mass_that_is_drawn(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(URDF)
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {arm: {urdf: arm.urdf, links: {bar: {mass: {uniform: [1, 5]}}}}}\n")
    batch, fresh = (scenecc.load_scene(scene, num_scenes=SCENES, seed=seed, render=False) for seed in (0, 8))
    batch.reset(seed=8, exact=True)
    assert_same(batch, fresh)
    assert_same_trajectory(batch.scenes, fresh.scenes)
