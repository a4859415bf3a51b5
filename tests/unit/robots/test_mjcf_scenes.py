"""Scenes that name an MJCF: names, ids of self-collision, where what it holds stands."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from scenecc import SceneError, load_scene

if TYPE_CHECKING:
    from pathlib import Path

ARM = '<body name="arm" pos="0 0 1"><joint name="j" axis="0 0 1"/><geom size=".1"/></body>'
SILENT = '<option><flag contact="disable"/></option>'


def build(folder: Path, text: str, **entities: Any) -> Any:
    (folder / "robot.xml").write_text(text)
    if not entities:
        entities = {"robot": {}}
    named = {name: {"mjcf": "asset://robot.xml", **more} for name, more in entities.items()}
    return load_scene({"scenecc": 1, "entities": named}, asset_roots=[folder], render=False)


def ids(batch: Any) -> dict[str, set[tuple[int, int]]]:
    """Of each entity what its shapes ignore: the third and fourth collision integer."""
    found: dict[str, set[tuple[int, int]]] = {}
    for entity in batch.scenes[0].entities:
        shapes = [shape for part in entity.components for shape in part.collision_shapes]
        found.setdefault(entity.name, set()).update(tuple(shape.collision_groups[2:]) for shape in shapes)
    return found


def test_one_robot_gets_the_entity_name_and_several_their_root_names(tmp_path: Path) -> None:
    assert list(build(tmp_path, f"<mujoco><worldbody>{ARM}</worldbody></mujoco>").articulations) == ["robot"]
    (tmp_path / "many").mkdir()
    batch = build(tmp_path / "many", f'<mujoco><worldbody>{ARM}<geom name="rail" size="1"/></worldbody></mujoco>')
    assert list(batch.articulations) == ["robot/dummy_root_0"]
    assert list(batch.entities) == ["robot/rail"]


def test_contacts_disabled_in_a_file_are_off_only_within_the_file(tmp_path: Path) -> None:
    world = f'<worldbody>{ARM}<geom name="rail" type="box" size="1 1 .1"/></worldbody>'
    batch = build(tmp_path, f"<mujoco>{SILENT}{world}</mujoco>", one={}, two={})
    found = ids(batch)
    assert found["one/rail"] == {(1, 0)}
    assert found["two/rail"] == {(1, 1)}
    # The links of both robots are named alike: each has the id of its own rail.
    assert found["arm"] == {(1, 0), (1, 1)}


def test_the_pose_of_a_static_body_combines_file_and_scene(tmp_path: Path) -> None:
    text = '<mujoco><worldbody><body name="s" pos="1 0 0"><geom size=".1"/></body></worldbody></mujoco>'
    batch = build(tmp_path, text, robot={"pose": {"p": [0, 0, 2], "rpy_deg": [0, 0, 90]}})
    (entity,) = batch.scenes[0].entities
    np.testing.assert_allclose(entity.pose.p, [0, 1, 2], atol=1e-6)


def test_scene_settings_apply_where_the_file_has_none(tmp_path: Path) -> None:
    text = f"<mujoco><worldbody>{ARM}</worldbody></mujoco>"
    more = {"links": {"arm": {"mass": 3}}, "joints": {"j": {"armature": 0.25}}, "drives": {"j": {"stiffness": 7}}}
    (robot,) = build(tmp_path, text, robot=more).articulations["robot"].objs
    assert robot.links[1].mass == pytest.approx(3)
    (joint,) = robot.active_joints
    np.testing.assert_allclose(np.ravel(joint.armature), 0.25)
    assert joint.stiffness == 7


def test_an_error_in_the_mjcf_fails_the_scene(tmp_path: Path) -> None:
    with pytest.raises(SceneError) as caught:
        build(tmp_path, '<mujoco>\n<worldbody>\n<geom type="mesh" mesh="m"/></worldbody></mujoco>')
    (one,) = [one for one in caught.value.diagnostics if one.severity == "error"]
    assert (one.code, one.file, one.line) == ("SC481", "asset://robot.xml", 3)
    assert one.related[0].message == "used from here"
