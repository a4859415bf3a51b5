"""Placing: what fits, what is drawn, and what is said where nothing fits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenecc import SceneError, compile_scene, emit_scene, load_scene, validate
from scenecc.plan.geometry import REVOLVED_SOLIDS

ROOT = Path(__file__).parents[3]
TABLE = {"body_type": "static", "pose": [0, 0, 0.4], "shapes": [{"type": "box", "half_size": [0.5, 0.35, 0.02]}]}
SHAPES: list[dict[str, Any]] = [
    {"type": "box", "half_size": [0.03, 0.02, 0.015]},
    {"type": "sphere", "radius": 0.025},
    {"type": "cylinder", "radius": 0.025, "half_length": 0.03, "axis": "z"},
    {"type": "capsule", "radius": 0.018, "half_length": 0.03},
]


def thing(number: int = 0, **place: Any) -> dict[str, Any]:
    return {"place": {"on": "table", **place}, "shapes": [SHAPES[number % 4]]}


def scene(num_scenes: int, **entities: Any) -> dict[str, Any]:
    return {"scenecc": 1, "num_scenes": num_scenes, "entities": {"table": TABLE, **entities}}


def clutter(num_scenes: int, count: int = 6) -> dict[str, Any]:
    turned = {"yaw_deg": {"uniform": [0, 360]}, "apart": 0.01}
    return scene(num_scenes, **{f"thing_{i}": thing(i, **turned) for i in range(count)})


def poses(document: dict[str, Any], **options: Any) -> dict[str, Any]:
    return {entity.name: entity.pose.data for entity in compile_scene(document, **options).entities}


def errors_of(source: Any) -> list[tuple[str, str]]:
    try:
        compile_scene(source)
    except SceneError as error:
        return [(one.code, one.message) for one in error.diagnostics]
    return []


def code_of(source: Any) -> list[str]:
    return [code for code, _ in errors_of(source)]


def test_a_placed_scene_is_the_same_in_every_batch() -> None:
    few, many = poses(clutter(8)), poses(clutter(300))
    assert all(few[name].tobytes() == many[name][: len(few[name])].tobytes() for name in few)


def test_an_entity_added_at_the_end_moves_no_other() -> None:
    before, after = poses(clutter(50, 5)), poses(clutter(50, 6))
    assert all(before[name].tobytes() == after[name].tobytes() for name in before)


def test_a_placed_entity_is_on_its_target_and_within_its_top() -> None:
    cube = poses(scene(200, cube=thing(0, gap=0.002)))["cube"]
    assert np.allclose(cube[:, 2], 0.42 + 0.002 + 0.015)
    assert np.abs(cube[:, 0]).max() <= 0.47
    assert np.abs(cube[:, 1]).max() <= 0.33
    assert np.ptp(cube[:, 0]) > 0.8


def test_a_reset_places_like_a_build_and_only_in_its_scenes() -> None:
    batch = load_scene(clutter(6))
    first = {name: batch.entities[name].pose.copy() for name in ("thing_0", "thing_5")}
    batch.reset(seed=3, scene_idxs=[1, 4])
    fresh = load_scene(clutter(6), seed=3)
    for name, before in first.items():
        now = batch.entities[name].pose
        assert np.array_equal(now[[1, 4]], fresh.entities[name].pose[[1, 4]])
        assert np.array_equal(now[[0, 2, 3, 5]], before[[0, 2, 3, 5]])
        assert not np.array_equal(now[[1, 4]], before[[1, 4]])


def test_a_plan_from_json_places_at_a_reset() -> None:
    plan = compile_scene(clutter(4, 3))
    again = compile_scene(emit_scene(plan, "json"))
    assert again == plan
    batch, fresh = load_scene(again), load_scene(clutter(4, 3), seed=9)
    batch.reset(seed=9)
    assert np.array_equal(batch.entities["thing_2"].pose, fresh.entities["thing_2"].pose)


def test_coplanar_planks_form_one_top() -> None:
    planks = [{"type": "box", "half_size": [0.4, 0.1, 0.02], "pose": [0, 0.2 * i, 0]} for i in (-1, 0, 1)]
    table = {"body_type": "static", "pose": {"p": [1, 0, 0.4], "rpy_deg": [0, 0, 30]}, "shapes": planks}
    cube = poses({**scene(100), "entities": {"table": table, "cube": thing(0)}})["cube"]
    across = np.abs(-np.sin(np.pi / 6) * (cube[:, 0] - 1) + np.cos(np.pi / 6) * cube[:, 1])
    assert ((across > 0.08) & (across < 0.12)).any(), "some stand on two planks"
    assert np.allclose(cube[:, 2], 0.42 + 0.001 + 0.015)


def test_a_note_among_the_distances_is_ignored() -> None:
    ball = {"place": {"on": "table", "near": {"x-old": [0, 1]}}, "shapes": [SHAPES[1]]}
    (placement,) = compile_scene(scene(1, ball=ball)).placements
    assert placement.near == ()


def test_inside_above_near_and_facing_place_as_specified() -> None:
    walls = [
        {"type": "box", "half_size": size, "pose": at}
        for size, at in (
            ([0.1, 0.1, 0.005], [0, 0, 0]),
            ([0.1, 0.005, 0.05], [0, 0.1, 0.05]),
            ([0.1, 0.005, 0.05], [0, -0.1, 0.05]),
            ([0.005, 0.1, 0.05], [0.1, 0, 0.05]),
            ([0.005, 0.1, 0.05], [-0.1, 0, 0.05]),
        )
    ]
    found = poses(
        scene(
            40,
            bin={"body_type": "kinematic", "place": {"on": "table", "yaw_deg": 30}, "shapes": walls},
            lid={"pose": {"p": [0, 0, 0.3], "relative_to": "bin"}, "shapes": [SHAPES[0]]},
            ball={"place": {"inside": "bin"}, "shapes": [SHAPES[1]]},
            drop={"place": {"above": "bin", "height": [0.02, 0.1], "q": "uniform"}, "shapes": [SHAPES[0]]},
            spoon={"place": {"on": "table", "near": {"bin": [0.05, 0.15]}, "facing": "bin"}, "shapes": [SHAPES[3]]},
        )
    )
    bin_, ball, drop, spoon = (found[name] for name in ("bin", "ball", "drop", "spoon"))
    assert np.allclose(found["lid"][:, :3], bin_[:, :3] + [0, 0, 0.3])
    assert np.allclose(ball[:, 2] - bin_[:, 2], 0.005 + 0.001 + 0.025)
    assert np.hypot(*(ball - bin_)[:, :2].T).max() < 0.11
    assert (drop[:, 2] - bin_[:, 2]).min() > 0.1 + 0.02
    away = bin_[:, :2] - spoon[:, :2]
    ahead = np.stack([2 * spoon[:, 3] ** 2 - 1, 2 * spoon[:, 3] * spoon[:, 6]], axis=1)
    assert np.allclose(ahead, away / np.hypot(*away.T)[:, None])


def test_a_prefab_instance_is_placed_as_a_whole(tmp_path: Any) -> None:
    part = {
        "scenecc": 1,
        "entities": {
            "low": {"shapes": [SHAPES[0]]},
            "high": {"pose": [0, 0, 0.1], "shapes": [SHAPES[1]]},
        },
    }
    (tmp_path / "part.yaml").write_text(repr(part), encoding="utf-8")
    document = {**scene(20), "entities": {"table": TABLE, "two": {"use": "part.yaml", "place": {"on": "table"}}}}
    file = tmp_path / "scene.yaml"
    file.write_text(repr(document), encoding="utf-8")
    plan = compile_scene(file)
    low, high = (entity.pose.data for entity in plan.entities[1:])
    assert [one.entities for one in plan.placements] == [("two/low", "two/high")]
    assert np.allclose(high - low, [0, 0, 0.1, 0, 0, 0, 0])
    assert np.allclose(low[:, 2], 0.42 + 0.001 + 0.015)
    assert np.ptp(low[:, 0]) > 0.5


def test_a_failed_placement_names_the_scene_and_the_tries() -> None:
    crowded = scene(3, cube=thing(0, region=[[0.49, 0], [0.5, 0.1]], tries=50))
    assert not [one for one in validate(crowded) if one.severity == "error"]
    with pytest.raises(SceneError, match="in scene 0: `cube` fits nowhere in 50 tries, nor in 2 other scenes"):
        compile_scene(crowded)
    assert code_of(crowded) == ["SC354"]


@pytest.mark.parametrize(("key", "value"), [("near", {"first": [3, 4]}), ("apart", 3)])
def test_a_distance_larger_than_the_target_is_reported(key: str, value: Any) -> None:
    wide = scene(1, first=thing(0), second=thing(0, **{key: value}))
    with pytest.raises(SceneError, match=f"`{key}` asks for 3 m, and the top of `table` is"):
        compile_scene(wide)


def test_a_failed_placement_names_the_main_reason() -> None:
    with pytest.raises(SceneError, match=r"of the last tries in scene 0, 50 of 50 are not completely on `table`"):
        compile_scene(scene(3, cube=thing(0, region=[[0.49, 0], [0.5, 0.1]], tries=50)))
    with pytest.raises(SceneError, match=r"of the last tries in scene 0, 5 of 5 are too close to `mug`"):
        compile_scene(scene(1, mug=thing(0, at=[0, 0]), cube=thing(0, at=[0.01, 0], tries=5)))


def test_a_reset_with_a_failed_placement_changes_nothing() -> None:
    narrow = {**scene(2, cube=thing(0, at=["${x}", 0], tries=3)), "draws": {"x": {"uniform": [0, 0.1]}}}
    batch = load_scene(narrow)
    before = batch.entities["cube"].pose.copy()
    with pytest.raises(ValueError, match="`cube` fits nowhere in 3 tries, in scenes 1"):
        batch.reset(draws={"x": [0.0, 0.6]})
    assert np.array_equal(batch.entities["cube"].pose, before)


@pytest.mark.parametrize(
    ("height", "apart", "told"),
    [
        (0.45, 0, ["in scene 0 `post` and `ball` overlap"]),
        (0.45, 0.001, ["in scene 0 `post` and `ball` are less than 0.001 m apart"]),
        # On top of the post: 0.42 + 0.001 + 0.06 m.
        (0.481 + 0.0254, 0, []),
        (0.481 + 0.0254, 0.001, ["in scene 0 `post` and `ball` are less than 0.001 m apart"]),
        (0.481 + 0.0262, 0.001, []),
    ],
)
def test_a_pose_drawn_at_reset_avoids_kept_placements(height: float, apart: float, told: list[str]) -> None:
    post = {**thing(2, at=[0, 0], apart=apart), "body_type": "static"}
    ball = {"pose": {"p": [{"uniform": [0, 0.001]}, 0, height]}, "shapes": [SHAPES[1]]}
    assert errors_of(scene(1, ball=ball, post=post)) == [("SC356", message) for message in told]


@pytest.mark.parametrize("kind", ["box", "triangle_mesh"])
def test_a_drawn_body_may_touch_a_placement_with_apart_0(kind: str, tmp_path: Path) -> None:
    corners = [(x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.01, 0.01)]
    sides = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
    lines = [*(f"v {x} {y} {z}" for x, y, z in corners), *(f"f {side}" for side in sides)]
    (tmp_path / "board.obj").write_text("\n".join(lines), encoding="utf-8")
    shape = {"box": {"half_size": [0.1, 0.1, 0.01]}, "triangle_mesh": {"file": "board.obj"}}[kind]
    place = {"on": "table", "at": [0, 0], "apart": 0, "gap": 0}
    board = {"body_type": "static", "place": place, "collisions": [{"type": kind, **shape}]}
    for height, codes in ((0.44 + 0.015, []), (0.44 + 0.015 - 1e-4, ["SC356"])):
        cube = {"pose": {"p": [{"uniform": [0, 0.05]}, 0, height]}, "shapes": [SHAPES[0]]}
        file = tmp_path / "scene.yaml"
        file.write_text(repr(scene(4, board=board, cube=cube)), encoding="utf-8")
        assert code_of(file) == codes


@pytest.mark.parametrize("kind", REVOLVED_SOLIDS)
def test_a_shape_without_known_distances_is_an_error(kind: str) -> None:
    sizes = dict.fromkeys(REVOLVED_SOLIDS[kind].__slots__, 0.05)
    varying = {"type": kind, **sizes, next(iter(sizes)): {"uniform": [0.02, 0.03]}}
    ((code, message),) = errors_of(scene(2, cube=thing(0), pipe={"pose": [0, 0, 3], "shapes": [varying]}))
    assert code == "SC357"
    assert f"a {kind} whose size differs between scenes" in message


def test_placement_avoids_a_robot_at_its_initial_joint_positions() -> None:
    tip = {
        "name": "tip",
        "joint": {"type": "prismatic", "axis": "x", "origin": [0, 0, 0.05], "limits": [-1, 1]},
        "shapes": [{"type": "box", "half_size": [0.3, 0.3, 0.02]}],
    }
    root = {"name": "base", "shapes": [{"type": "box", "half_size": [0.01, 0.01, 0.02]}], "children": [tip]}
    arm = {"pose": [0, 0, 0.45], "fix_root_link": True, "root": root, "qpos": {"tip_joint": 0.2}}
    tip["joint"]["name"] = "tip_joint"
    cylinder = poses(scene(100, arm=arm, mug=thing(2, apart=0)))["mug"]
    over = (np.abs(cylinder[:, 0] - 0.2) < 0.3) & (np.abs(cylinder[:, 1]) < 0.3)
    assert not over.any()


def test_placement_uses_meshes_as_cooked_by_the_engine(tmp_path: Any) -> None:
    corners = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n"
    (tmp_path / "tetra.obj").write_text(corners + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", encoding="utf-8")
    entities: dict[str, Any] = {"table": TABLE}
    for i in range(6):
        kind = ("convex_mesh", "triangle_mesh", "convex_parts")[i % 3]
        entities[f"thing_{i}"] = {
            "body_type": "kinematic" if kind == "triangle_mesh" else "dynamic",
            "place": {"on": "table", "q": "uniform", "apart": 0.005, "region": [[-0.3, -0.2], [0.3, 0.2]]},
            "collisions": [{"type": kind, "file": "tetra.obj", "scale": 1 + 0.1 * i}],
        }
    physics = {"contact_offset": 0.02, "gravity": [0, 0, 0]}
    file = tmp_path / "scene.yaml"
    file.write_text(repr({"scenecc": 1, "num_scenes": 60, "physics": physics, "entities": entities}), encoding="utf-8")
    # PhysX measures between a hull and a triangle along the triangle's normal, which tells no distance.
    meshes = {"thing_1", "thing_4"}
    apart: list[float] = []
    standing: list[float] = []
    for one in load_scene(file).scenes:
        one.step()
        for contact in one.get_contacts():
            names = {name for body in contact.bodies for name in entities if name in body.entity.name}
            if "table" not in names and names & meshes:
                continue
            (standing if "table" in names else apart).extend(point.separation for point in contact.points)
    assert len(apart) > 20
    assert min(apart) >= 0.005 - 2e-5
    assert min(standing) == pytest.approx(0.001, abs=1e-5)


def test_an_instance_with_placements_cannot_be_placed(tmp_path: Any) -> None:
    (tmp_path / "part.yaml").write_text(repr(scene(1, cube=thing(0))), encoding="utf-8")
    document = {"scenecc": 1, "entities": {"table": TABLE, "two": {"use": "part.yaml", "place": {"on": "table"}}}}
    (tmp_path / "scene.yaml").write_text(repr(document), encoding="utf-8")
    found = validate(tmp_path / "scene.yaml")
    assert [one.code for one in found if one.severity == "error"] == ["SC358"]


def test_an_instance_is_placed_beside_one_that_places_and_whose_name_begins_alike(tmp_path: Any) -> None:
    (tmp_path / "part.yaml").write_text(
        repr({"scenecc": 1, "entities": {"cube": {"shapes": SHAPES}}}), encoding="utf-8"
    )
    (tmp_path / "placing.yaml").write_text(repr(scene(1, cube=thing(0))), encoding="utf-8")
    entities = {
        "table": TABLE,
        "desk": {"use": "part.yaml", "place": {"on": "table"}},
        "desk2": {"use": "placing.yaml", "pose": [5, 0, 0]},
    }
    (tmp_path / "scene.yaml").write_text(repr({"scenecc": 1, "entities": entities}), encoding="utf-8")
    assert not [one for one in validate(tmp_path / "scene.yaml") if one.severity == "error"]


def test_a_body_without_collision_is_placed_by_its_origin_and_supports_nothing() -> None:
    mark = {"place": {"on": "table"}, "body_type": "none", "visuals": [{"type": "sphere", "radius": 0.1}]}
    found = poses(scene(50, cube=thing(0), mark=mark))
    assert np.allclose(found["mark"][:, 2], 0.421)
    assert code_of(scene(1, mark=mark, cube={**thing(0), "place": {"on": "mark"}})) == ["SC359"]


def test_long_chains_and_hopeless_placements_end_quickly() -> None:
    tower = {f"thing_{i}": thing(0, on=f"thing_{i - 1}" if i else "table", at=[0, 0]) for i in range(30)}
    found = poses(scene(1, **dict(reversed(tower.items()))))
    assert found["thing_29"][0, 2] == pytest.approx(0.42 + 30 * 0.001 + 59 * 0.015, abs=1e-5)
    huge = {"place": {"on": "table", "tries": 3}, "shapes": [{"type": "sphere", "radius": 1e6}]}
    assert code_of(scene(1, huge=huge)) == ["SC355", "SC354"]


def test_corners_of_a_region_may_be_in_any_order() -> None:
    """The first above the second put everything at [0, 0]."""
    corners = [[0.3, 0.2, 0.1], [0.1, 0.1, -0.1]]
    found = [poses(scene(20, cube=thing(0, region=region))) for region in (corners, corners[::-1])]
    assert (found[0]["cube"] == found[1]["cube"]).all()
    assert found[0]["cube"][:, 0].std() > 0.02


@pytest.mark.parametrize(
    ("at", "told"),
    [
        ({"at": [0.9, 0]}, True),
        ({"region": {"center": [0.9, 0], "radius": 0.1}}, True),
        ({"region": [[0.9, 0], [0.7, 0.1]]}, True),
        ({"at": [0.9, 0], "relative_to": "world"}, True),
        ({"region": [[0.9, 0], [0.4, 0.1]]}, False),
        ({"region": {"center": [0.9, 0], "radius": 0.6}}, False),
    ],
)
def test_a_region_outside_its_target_is_reported(at: dict[str, Any], told: bool) -> None:
    codes = [one.code for one in validate(scene(1, cube=thing(0, **at)))]
    assert codes == ["SC355"] * told


@pytest.mark.parametrize("name", ["heap", "regions"])
def test_shipped_placement_recipes_place_as_described(name: str) -> None:
    plan = compile_scene(ROOT / "scenes" / "recipes" / f"{name}.yaml", num_scenes=64)
    at = {entity.name: entity.pose.data for entity in plan.entities}
    if name == "heap":
        things = np.stack([pose for key, pose in at.items() if key.startswith("thing")])
        assert np.abs(things[:, :, :2]).max() <= 0.13
        assert things[:, :, 2].min() > 0.11
    else:
        assert np.abs(at["plate"][:, :2] - [0, 0.15]).max(axis=0).round(3).tolist() <= [0.15, 0.08]
        assert (np.hypot(*(at["bowl"] - at["plate"])[:, :2].T) <= 0.04 + 1e-6).all()
        assert (at["milk"][:, 1] < 0).all()


def test_a_body_drawn_onto_a_kept_placement_fails_the_reset() -> None:
    post = {**thing(2, at=[0.2, 0]), "body_type": "static"}
    ball = {"pose": {"p": ["${x}", 0, 0.45]}, "shapes": [SHAPES[1]]}
    batch = load_scene({**scene(2, post=post, ball=ball), "draws": {"x": {"uniform": [0, 0.01]}}})
    before = batch.entities["ball"].pose.copy()
    with pytest.raises(ValueError, match="in scene 1 `post` and `ball` are less than"):
        batch.reset(draws={"x": [0.0, 0.2]})
    assert np.array_equal(batch.entities["ball"].pose, before)
    batch.reset(draws={"x": [0.0, 0.1]})


def test_a_link_is_a_target_at_its_initial_joint_positions() -> None:
    tray = {
        "name": "tray",
        "joint": {"name": "lift", "type": "prismatic", "axis": "z", "limits": [0, 1]},
        "shapes": [{"type": "box", "half_size": [0.2, 0.2, 0.01]}],
    }
    root = {"name": "base", "shapes": [{"type": "box", "half_size": [0.05, 0.05, 0.05]}], "children": [tray]}
    arm = {"pose": [0, 0, 1], "fix_root_link": True, "root": root, "qpos": {"lift": {"uniform": [0.3, 0.6]}}}
    cup = {**thing(2), "place": {"on": "arm/tray", "near": {"arm": [0, 0.01]}, "facing": "arm"}}
    document = scene(30, cup=cup, arm=arm)
    plan = compile_scene(document)
    structure: Any = plan.entities[2].structures[0]
    lift = structure.links[1].joint.qpos.data
    cups = {entity.name: entity.pose.data for entity in plan.entities}["cup"]
    assert np.allclose(cups[:, 2], 1 + lift + 0.01 + 0.001 + 0.03, atol=1e-6)
    batch, fresh = load_scene(plan), load_scene(document, seed=4)
    batch.reset(seed=4)
    assert np.array_equal(batch.entities["cup"].pose, fresh.entities["cup"].pose)
