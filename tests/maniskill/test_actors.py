"""Bodies in ManiSkill's scenes: against the same by ManiSkill's own builder, property by property and step by step."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from plugins.maniskill_scenes import built_by_hand, new_scene
from plugins.mesh_files import TETRA
from plugins.trajectory import first_difference, trajectory

import scenecc
from scenecc.decompiler.reading import read_scene
from scenecc.decompiler.verify import differences

STEPS = 200

ROUGH = {"physical": {"static_friction": 0.9, "dynamic_friction": 0.8, "restitution": 0.2}}
GROUND = {"body_type": "static", "shapes": [{"type": "plane"}], "pose": [0, 0, -0.1]}


def _pose(p: Any, q: Any = (1, 0, 0, 0)) -> Any:
    import sapien

    return sapien.Pose(p, q)


def _rough() -> Any:
    from sapien import physx

    return physx.PhysxMaterial(0.9, 0.8, 0.2)


def _ground(scene: Any) -> None:
    builder = scene.create_actor_builder()
    builder.add_plane_collision(_pose([0, 0, 0], [0.7071067811865476, 0, -0.7071067811865476, 0]))
    builder.initial_pose = _pose([0, 0, -0.1])
    builder.build_static("ground")


def _one_of_each(scene: Any) -> None:
    _ground(scene)
    box = scene.create_actor_builder()
    box.add_box_collision(half_size=[0.02, 0.03, 0.04], density=200)
    box.initial_pose = _pose([0, 0, 0.3], [0.9238795325112867, 0, 0.3826834323650898, 0])
    box.build("box")
    ball = scene.create_actor_builder()
    ball.add_sphere_collision(radius=0.05, material=_rough())
    ball.initial_pose = _pose([0.01, 0, 0.6])
    (body,) = ball.build("ball")._bodies
    body.set_cmass_local_pose(_pose([0.01, 0, -0.02]))
    pill = scene.create_actor_builder()
    pill.add_capsule_collision(_pose([0, 0, 0.01]), radius=0.02, half_length=0.05)
    pill.add_cylinder_collision(_pose([0, 0.1, 0]), radius=0.03, half_length=0.02, density=500)
    pill.initial_pose = _pose([0, 0.02, 0.9])
    pill.build("pill")
    lift = scene.create_actor_builder()
    lift.add_box_collision(half_size=[0.1, 0.1, 0.01])
    lift.initial_pose = _pose([0.01, 0.02, 0.1])
    lift.build_kinematic("lift")


ONE_OF_EACH = {
    "ground": GROUND,
    "box": {
        "shapes": [{"type": "box", "half_size": [0.02, 0.03, 0.04]}],
        "density": 200,
        "pose": {"p": [0, 0, 0.3], "q": [0.9238795325112867, 0, 0.3826834323650898, 0]},
    },
    "ball": {
        "shapes": [{"type": "sphere", "radius": 0.05, "material": ROUGH}],
        "com": [0.01, 0, -0.02],
        "pose": [0.01, 0, 0.6],
    },
    "pill": {
        "shapes": [
            {"type": "capsule", "radius": 0.02, "half_length": 0.05, "pose": [0, 0, 0.01]},
            {"type": "cylinder", "radius": 0.03, "half_length": 0.02, "pose": [0, 0.1, 0], "density": 500},
        ],
        "pose": [0, 0.02, 0.9],
    },
    "lift": {
        "body_type": "kinematic",
        "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.01]}],
        "pose": [0.01, 0.02, 0.1],
    },
}


def _meshes(folder: Path) -> Callable[[Any], None]:
    def build(scene: Any) -> None:
        _ground(scene)
        rock = scene.create_actor_builder()
        rock.add_convex_collision_from_file(str(folder / "rock.obj"), scale=[1.5, 1.5, 1.5])
        rock.initial_pose = _pose([0, 0, 0.5])
        rock.build("rock")
        terrain = scene.create_actor_builder()
        terrain.add_nonconvex_collision_from_file(str(folder / "rock.obj"))
        terrain.initial_pose = _pose([0.02, 0, -0.05])
        terrain.build_static("terrain")

    return build


MESHES = {
    "ground": GROUND,
    "rock": {"collisions": [{"type": "convex_mesh", "file": "asset://rock.obj", "scale": 1.5}], "pose": [0, 0, 0.5]},
    "terrain": {
        "body_type": "static",
        "collisions": [{"type": "triangle_mesh", "file": "asset://rock.obj"}],
        "pose": [0.02, 0, -0.05],
    },
}


def _settings(scene: Any) -> None:
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.02, 0.03, 0.04])
    builder.collision_groups = [1, 2, 4, 8]
    builder.set_mass_and_inertia(0.3, _pose([0.01, 0, 0]), [1e-3, 2e-3, 2e-3])
    builder.initial_pose = _pose([0, 0, 1])
    actor = builder.build("box")
    actor.set_linear_damping(0.4)
    actor.set_angular_damping(0.3)
    actor.set_locked_motion_axes([False, False, False, True, False, False])
    (body,) = actor._bodies
    body.solver_position_iterations, body.solver_velocity_iterations = 12, 3
    body.set_max_depenetration_velocity(3)
    body.linear_velocity = [0.1, 0, 0.5]


SETTINGS = {
    "box": {
        "shapes": [{"type": "box", "half_size": [0.02, 0.03, 0.04]}],
        "collision_bits": [1, 2, 4, 8],
        "inertial": {"mass": 0.3, "com": [0.01, 0, 0], "inertia": [1e-3, 2e-3, 2e-3]},
        "linear_damping": 0.4,
        "angular_damping": 0.3,
        "locked_axes": ["rx"],
        "solver_position_iterations": 12,
        "solver_velocity_iterations": 3,
        "max_depenetration_velocity": 3,
        "linear_velocity": [0.1, 0, 0.5],
        "pose": [0, 0, 1],
    }
}

CASES: dict[str, tuple[dict[str, Any], Callable[[Any], None]]] = {
    "one of each": (ONE_OF_EACH, _one_of_each),
    "settings": (SETTINGS, _settings),
}


def _unlike(loaded: Any, by_hand: Any) -> list[str]:
    """What differs as built, and the first step in which the two move otherwise."""
    (ours,), (theirs,) = loaded.sub_scenes, by_hand.sub_scenes
    built = differences(read_scene(theirs), read_scene(ours))
    moved = first_difference(trajectory(theirs, STEPS), trajectory(ours, STEPS))
    return built if moved is None else [*built, moved]


@pytest.mark.parametrize("case", CASES)
def test_bodies_are_those_of_maniskills_own_builder_and_move_as_they_do(case: str) -> None:
    entities, build = CASES[case]
    scene = new_scene()
    scenecc.load_scene({"scenecc": 1, "entities": entities}, scene=scene)
    assert _unlike(scene, built_by_hand(build)) == []


def test_meshes_are_those_of_maniskills_own_builder_and_move_as_they_do(tmp_path: Path) -> None:
    (tmp_path / "rock.obj").write_text(TETRA)
    scene = new_scene()
    document = {"scenecc": 1, "entities": MESHES}
    scenecc.load_scene(document, scene=scene, asset_roots=[tmp_path], allow_outside_assets=True)
    assert _unlike(scene, built_by_hand(_meshes(tmp_path))) == []


def test_actors_are_at_the_poses_of_maniskills_own_builder() -> None:
    scene, by_hand = new_scene(), built_by_hand(_one_of_each)
    loaded = scenecc.load_scene({"scenecc": 1, "entities": ONE_OF_EACH}, scene=scene)
    assert list(scene.actors) == list(by_hand.actors) == list(loaded.actors)
    assert {name: actor.px_body_type for name, actor in scene.actors.items()} == {
        name: actor.px_body_type for name, actor in by_hand.actors.items()
    }
    assert {name: actor.name for name, actor in scene.actors.items()} == {name: name for name in by_hand.actors}
    ours, theirs = scene.get_sim_state(), by_hand.get_sim_state()
    assert ours.keys() == theirs.keys()
    assert list(ours["actors"]) == list(theirs["actors"])
    assert all((ours["actors"][name] == state).all() for name, state in theirs["actors"].items())
    for name, actor in by_hand.actors.items():
        assert (scene.actors[name].initial_pose.raw_pose == actor.initial_pose.raw_pose).all()
