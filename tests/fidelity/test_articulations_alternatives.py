"""Robots that are read otherwise in each scene, against SAPIEN's own loader: scale, root, SRDF and file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.test_articulations_urdf import ARM, POSE, QPOS, by_loader, tell

from scenecc import compile_scene, load_scene
from scenecc.plan import ArticulationStructure, Box

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.plan import BodyStructure, Value

PAIRS = '<robot name="arm"><disable_collisions link1="left" link2="right" reason="Default"/></robot>'
LONG = ARM.replace('xyz="0.3 0 0"', 'xyz="0.5 0 0"')


def document(path: Path, **keys: Any) -> dict[str, Any]:
    entity = {"urdf": str(path), "qpos": QPOS, "pose": {"p": POSE[:3], "q": POSE[3:]}, **keys}
    return {"scenecc": 1, "num_scenes": 6, "entities": {"robot": entity}}


def assert_as_loaded(data: dict[str, Any], theirs: list[Any]) -> None:
    """Every property of every link and joint, and 300 steps to the last bit."""
    ours = load_scene(data, render=False, allow_outside_assets=True).scenes
    for a, b in zip(ours, theirs, strict=True):
        assert_same_scene(a, b)
    assert_same_trajectory(ours, theirs)


def test_scale_and_root_that_differ(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    scales, fixed = [0.5, 1.0, 1.7], [True, False]
    data = document(path, scale={"cycle": scales}, fix_root_link={"cycle": fixed})
    theirs = [by_loader(path, QPOS, tell, scale=scales[i % 3], fix_root_link=fixed[i % 2])[0] for i in range(6)]
    assert_as_loaded(data, theirs)


def test_scales_that_are_drawn_and_computed(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    data = document(path, scale="${0.5 + 0.25 * k}", fix_root_link={"choice": [True, False]})
    data["draws"] = {"k": {"integers": [0, 4]}}
    plan = compile_scene(data, allow_outside_assets=True)
    (robot,) = plan.entities
    assert len(robot.structures) == 10
    # What is drawn is told by the size of the base, and by its root.
    drawn = [as_read(robot.structures[int(number)]) for number in rows(robot.pick)]
    assert len(set(drawn)) > 2
    theirs = [by_loader(path, QPOS, tell, scale=scale, fix_root_link=fixed)[0] for scale, fixed in drawn]
    assert_as_loaded(data, theirs)


def rows(value: Value | None) -> list[float]:
    assert value is not None
    return value.data.tolist()


def as_read(structure: BodyStructure | ArticulationStructure) -> tuple[float, bool]:
    """Scale and root of the arm in the plan."""
    assert isinstance(structure, ArticulationStructure)
    base = structure.links[0].body.collisions[0].geometry
    assert isinstance(base, Box)
    return float(base.half_size.data[0, 0] / 0.1), structure.fix_root_link


def test_a_file_and_its_pairs_and_folder_go_together(tmp_path: Path) -> None:
    short, long = tmp_path / "arm.urdf", tmp_path / "long.urdf"
    short.write_text(ARM)
    long.write_text(LONG)
    (tmp_path / "pairs.srdf").write_text(PAIRS)
    data = document(short, scale={"cycle": [1, 0.5]}, srdf={"cycle": ["none", str(tmp_path / "pairs.srdf")]})
    data["entities"]["robot"]["urdf"] = {"cycle": [str(short), str(long)]}
    data["entities"]["robot"]["fix_root_link"] = "${scene < 3}"
    assert len(compile_scene(data, allow_outside_assets=True).entities[0].structures) == 4
    theirs = [by_loader(short, QPOS, tell, fix_root_link=i < 3)[0] for i in range(6)]
    short.with_suffix(".srdf").unlink(missing_ok=True)
    long.with_suffix(".srdf").write_text(PAIRS)
    longs = [by_loader(long, QPOS, tell, scale=0.5, fix_root_link=i < 3)[0] for i in range(6)]
    long.with_suffix(".srdf").unlink()
    assert_as_loaded(data, [longs[i] if i % 2 else theirs[i] for i in range(6)])
