"""Poses relative to robots: those of a file that holds several, and those inside instances."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from scenecc import compile_scene, load_scene, validate

if TYPE_CHECKING:
    from pathlib import Path

BALL = "<collision><geometry><sphere radius='0.1'/></geometry></collision>"
TWO = (
    f"<robot name='two'><link name='base'>{BALL}</link><link name='ball'>{BALL}</link>"
    "<joint name='free' type='floating'><parent link='base'/><child link='ball'/>"
    "<origin xyz='0 0 1' rpy='0 0 1.5707963267948966'/></joint></robot>"
)
PREFAB = """scenecc: 1
entities:
  on: {pose: {p: [0, 0, 2], relative_to: r/ball}, shapes: [{type: sphere, radius: 0.1}]}
  r: {urdf: two.urdf, fix_root_link: false, pose: [0, 0, 5]}
"""
SCENE = """scenecc: 1
num_scenes: 3
frames:
  above: {pose: {p: [1, 0, 0.5], relative_to: r/ball}}
entities:
  before: {pose: {p: [1, 0, 0], relative_to: r/ball}, shapes: [{type: sphere, radius: 0.1}]}
  r: {urdf: two.urdf, fix_root_link: false, pose: [{uniform: [0, 9]}, 0, 5]}
  after: {pose: {p: [1, 0, 0], relative_to: r/ball}, shapes: [{type: sphere, radius: 0.1}]}
  framed: {pose: {relative_to: above}, shapes: [{type: sphere, radius: 0.1}]}
  p: {use: prefab.yaml, pose: [7, 0, 0]}
  outside: {pose: {p: [1, 0, 0], relative_to: p/r/ball}, shapes: [{type: sphere, radius: 0.1}]}
cameras:
  eye: {pose: {p: [1, 0, 0], relative_to: p/r/ball}}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "two.urdf").write_text(TWO)
    (tmp_path / "prefab.yaml").write_text(PREFAB)
    (tmp_path / "scene.yaml").write_text(SCENE)
    return tmp_path / "scene.yaml"


def test_whatever_comes_first_in_the_file_it_stands_relative_to_the_robot(scene: Path) -> None:
    assert validate(scene) == []
    plan = compile_scene(scene)
    at = {entity.name: entity.pose.data[:, :3] for entity in plan.entities}
    ball = at["r/ball"]
    assert len(ball) == 3
    # The ball is turned by a quarter: its x is y.
    assert np.allclose(at["before"], ball + np.array([0, 1, 0]))
    assert np.array_equal(at["before"], at["after"])
    assert np.allclose(at["framed"], ball + np.array([0, 1, 0.5]))
    assert at["p/r/ball"].tolist() == [[7, 0, 6]]
    assert np.allclose(at["p/on"], [[7, 0, 8]])
    assert np.allclose(at["outside"], [[7, 1, 6]])
    assert np.allclose(plan.cameras[0].pose.data[:, :3], [[7, 1, 6]])


def test_it_follows_the_robot_at_a_reset(scene: Path) -> None:
    with load_scene(scene, render=False) as batch:
        before = batch.entities["r/ball"].pose
        batch.reset(seed=5)
        ball = batch.entities["r/ball"].pose
        assert (ball[:, 0] != before[:, 0]).all()
        for name in ("before", "after"):
            assert np.allclose(batch.entities[name].pose[:, :3], ball[:, :3] + [0, 1, 0], atol=1e-6)


WRONG: dict[str, tuple[str, str, list[tuple[str, str | None]]]] = {
    "no such robot": ("r/ball", "r/bal", [("SC303", "did you mean `r/ball`?")] * 3),
    "a circle": ("pose: [{uniform: [0, 9]}, 0, 5]", "pose: {relative_to: before}", [("SC304", None)]),
    # The ball of which nothing is known is not missed as well.
    "a torn file": ("urdf: two.urdf, fix_root_link: false, pose: [{", "urdf: three.urdf, pose: [{", [("SC401", None)]),
}


@pytest.mark.parametrize(("old", "new", "expected"), WRONG.values(), ids=WRONG)
def test_mistakes(scene: Path, old: str, new: str, expected: list[tuple[str, Any]]) -> None:
    text = SCENE.replace("  p: {use", "  q: {use").replace("p/r/ball", "q/r/ball")
    scene.write_text(text.replace(old, new) if old != "r/ball" else text.replace(": r/ball", ": r/bal"))
    found = validate(scene)
    assert [one.code for one in found] == [code for code, _ in expected]
    assert [one.hint for one in found if one.code == "SC303"] == [hint for _, hint in expected if hint]


def test_a_link_is_nothing_that_a_pose_stands_relative_to() -> None:
    """Links move by themselves: the hint says what is fastened to them, and no name that is like the one written."""
    ball = [{"type": "sphere", "radius": 0.1}]
    entities: dict[str, Any] = {
        "arm": {"root": {"name": "base", "shapes": ball}},
        "ball": {"shapes": ball, "pose": {"relative_to": "arm/base"}},
        "other": {"shapes": ball, "pose": {"relative_to": "amr"}},
    }
    hints = [(one.code, one.hint) for one in validate({"scenecc": 1, "entities": entities})]
    fastened = "no pose is relative to a link; a light or a camera is fastened to one by `mount`"
    assert hints == [("SC303", fastened), ("SC303", "did you mean `arm`?")]
