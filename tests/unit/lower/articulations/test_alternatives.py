"""Robots whose file, scale, pairs, folder and root differ from scene to scene: one structure for what goes together."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import pytest

from scenecc import SceneError, compile_scene, validate
from scenecc.plan import ArticulationStructure, Box

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic
    from scenecc.plan import ScenePlan

BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
ARM = (
    '<robot name="r"><link name="a"><collision><geometry><box size="{size} 2 2"/></geometry></collision></link>'
    f'<link name="b">{BALL}</link><link name="{{tip}}">{BALL}</link>'
    '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
    '<joint name="k" type="continuous"><parent link="b"/><child link="{tip}"/></joint></robot>'
)
PAIRS = '<robot name="r"><disable_collisions link1="a" link2="{tip}" reason="Default"/></robot>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, size, tip in (("one", 2, "c"), ("two", 4, "d")):
        (tmp_path / f"{name}.urdf").write_text(ARM.format(size=size, tip=tip))
        (tmp_path / f"{name}.pairs").write_text(PAIRS.format(tip=tip))
    return tmp_path


def written(folder: Path, robot: str, *, head: str = "") -> Path:
    path = folder / "scene.yaml"
    path.write_text(f"scenecc: 1\nnum_scenes: 6\n{head}entities:\n  r: {{{robot}}}\n")
    return path


def plan_of(folder: Path, robot: str, *, head: str = "") -> ScenePlan:
    return compile_scene(written(folder, robot, head=head))


def found(folder: Path, robot: str, *, head: str = "") -> list[Diagnostic]:
    return validate(written(folder, robot, head=head))


def places(folder: Path, robot: str, *, head: str = "") -> list[tuple[str, Any]]:
    return [(one.code, one.path) for one in found(folder, robot, head=head)]


def robots(plan: ScenePlan) -> list[tuple[float, bool]]:
    """Length of the root, and whether it is fixed, of each structure."""
    made: list[tuple[float, bool]] = []
    for structure in plan.entities[0].structures:
        assert isinstance(structure, ArticulationStructure)
        base = structure.links[0].body.collisions[0].geometry
        assert isinstance(base, Box)
        made.append((2 * base.half_size.numbers()[0], structure.fix_root_link))
    return made


def picked(plan: ScenePlan) -> list[tuple[float, bool]]:
    """Of each scene."""
    pick, made = plan.entities[0].pick, robots(plan)
    assert pick is not None
    return [made[number] for number in pick.data.tolist()]


def test_one_structure_for_what_goes_together_in_the_order_written(folder: Path) -> None:
    plan = plan_of(folder, "urdf: {cycle: [one.urdf, two.urdf]}, scale: {cycle: [1, 3]}")
    assert robots(plan) == [(2, True), (12, True)]
    assert picked(plan) == [(2, True), (12, True)] * 3
    plan = plan_of(folder, "urdf: {cycle: [one.urdf, two.urdf]}, scale: {cycle: [1, 3, 2]}")
    assert robots(plan) == [(2, True), (6, True), (4, True), (4, True), (12, True), (8, True)]
    assert picked(plan) == [(2, True), (12, True), (4, True), (4, True), (6, True), (8, True)]


def test_what_reads_one_draw_goes_together_and_what_draws_alone_does_not(folder: Path) -> None:
    head = "draws: {k: {choice: [1, 2]}}\n"
    robot = "urdf: \"${'one.urdf' if k == 1 else 'two.urdf'}\", scale: \"${k}\", fix_root_link: {choice: [true, false]}"
    plan = plan_of(folder, robot, head=head)
    assert robots(plan) == [(2, True), (2, False), (8, True), (8, False)]
    assert set(picked(plan)) <= set(robots(plan))
    plan = plan_of(folder, "urdf: one.urdf, scale: {choice: [1, 2]}, fix_root_link: {choice: [true, false]}")
    assert robots(plan) == [(2, True), (2, False), (4, True), (4, False)]


def test_whole_numbers_may_be_drawn_and_the_scenes_index_computes(folder: Path) -> None:
    assert robots(plan_of(folder, "urdf: one.urdf, scale: {integers: [1, 3]}")) == [(2, True), (4, True), (6, True)]
    plan = plan_of(
        folder, 'urdf: one.urdf, scale: "${1 + scene / 2}", fix_root_link: {per_scene: {0: true, default: false}}'
    )
    assert picked(plan) == [(2 + scene, scene == 0) for scene in range(6)]


def test_what_is_the_same_in_all_scenes_is_one_structure(folder: Path) -> None:
    plan = plan_of(folder, 'urdf: one.urdf, scale: {cycle: [2, 2.0]}, fix_root_link: "${1 > 0}"')
    assert robots(plan) == [(4, True)]
    assert plan.entities[0].pick is None


def test_what_was_left_out_is_as_it_was(folder: Path) -> None:
    plan = plan_of(folder, "urdf: one.urdf, srdf: {cycle: [none, one.pairs]}")
    assert robots(plan) == [(2, True)] * 2
    bits = [[link.body.collision_groups is not None for link in one.links] for one in plan.entities[0].structures
            if isinstance(one, ArticulationStructure)]  # fmt: skip
    assert bits == [[False, False, False], [True, False, True]]


def test_a_root_of_a_tree_may_be_free_in_some_scenes(folder: Path) -> None:
    tree = "root: {name: a, shapes: [{type: box, half_size: [1, 1, 1]}]}, linear_velocity: [1, 0, 0]"
    plan = plan_of(folder, f"{tree}, fix_root_link: {{cycle: [true, false]}}")
    assert picked(plan) == [(2, True), (2, False)] * 3
    said = [one.linear_velocity is not None for one in plan.entities[0].structures
            if isinstance(one, ArticulationStructure)]  # fmt: skip
    assert said == [False, True]
    assert places(folder, f"{tree}, fix_root_link: {{cycle: [true]}}") == [("SC115", "entities.r.linear_velocity")]


def test_what_no_scene_has_is_judged_with_what_stands_beside_it(folder: Path) -> None:
    eight = ["one", "two"] * 3
    robot = f"urdf: {{cycle: [{', '.join(f'{one}.urdf' for one in eight)}, two.urdf]}}"
    assert not found(folder, f"{robot}, srdf: {{cycle: [{', '.join(f'{one}.pairs' for one in eight)}, two.pairs]}}")
    robot = "urdf: one.urdf, scene_idxs: [0], "
    assert places(folder, robot + "srdf: {cycle: [none, three.pairs]}") == [("SC401", "entities.r.srdf.cycle[1]")]
    assert places(folder, robot + "package_dir: {choice: [., other], weights: [1, 0]}") == [
        ("SC401", "entities.r.package_dir.choice[1]")
    ]
    assert places(folder, robot + "scale: {per_scene: {0: 1, default: -1}}") == [
        ("SC104", "entities.r.scale.per_scene.default")
    ]


def test_a_folder_of_packages_by_scene(folder: Path) -> None:
    mesh = '<robot name="r"><link name="a"><visual><geometry><mesh filename="package://p/m.obj"/></geometry></visual></link></robot>'
    (folder / "meshed.urdf").write_text(mesh)
    (folder / "here" / "p").mkdir(parents=True)
    (folder / "here" / "p" / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "there").mkdir()
    (fault,) = [
        one
        for one in found(folder, "urdf: meshed.urdf, package_dir: {cycle: [here, there]}")
        if one.severity == "error"
    ]
    assert (fault.code, str(fault.file).endswith("meshed.urdf")) == ("SC401", True)


@pytest.mark.parametrize(
    ("robot", "code", "key"),
    [
        ("scale: {uniform: [0.5, 1]}", "SC317", "scale"),
        ("scale: {cycle: [1, {normal: [1, 0.1], clip: [0.5, 1]}]}", "SC317", "scale.cycle[1]"),
        ('scale: "${u}"', "SC317", "scale"),
        ('scale: "${k - 1}"', "SC513", "scale"),
        ("scale: \"${'large' if k > 1 else 'small'}\"", "SC515", "scale"),
        ('scale: "${[1, k]}"', "SC515", "scale"),
        ('scale: "${1 / (k - 1)}"', "SC202", "scale"),
        ('fix_root_link: "${k}"', "SC515", "fix_root_link"),
        ('srdf: "${k}"', "SC317", "srdf"),
        ('package_dir: "${[k, k]}"', "SC317", "package_dir"),
        ("scale: {integers: [0, 3]}", "SC104", "scale.integers[0]"),
        ("scale: {choice: [1, true]}", "SC103", "scale.choice[1]"),
        ("scale: {per_scene: [1, 2]}", "SC314", "scale.per_scene"),
    ],
)
def test_what_cannot_be(folder: Path, robot: str, code: str, key: str) -> None:
    head = "draws: {u: {uniform: [0.5, 1]}, k: {integers: [1, 3]}}\n"
    told = [place for place in places(folder, f"urdf: one.urdf, {robot}", head=head) if place[0] != "SC310"]
    assert (code, f"entities.r.{key}") in told


def test_a_range_is_refused_with_what_can_be_written(folder: Path) -> None:
    (fault,) = found(folder, "urdf: one.urdf, scale: {uniform: [0.5, 1]}")
    assert fault.message == "this gives more than 64 values"
    assert fault.hint == "each value is a structure of its own: write them in a `choice`"


def test_files_of_several_robots_have_no_alternatives(folder: Path) -> None:
    free = '<joint name="f" type="floating"><parent link="a"/><child link="b"/></joint>'
    (folder / "three.urdf").write_text(f'<robot name="r"><link name="a"/><link name="b"/>{free}</robot>')
    (fault,) = found(folder, "urdf: three.urdf, scale: {cycle: [1, 2]}")
    assert (fault.code, fault.path) == ("SC327", "entities.r.urdf")
    assert fault.message.endswith("three.urdf` contains 2")


def test_they_share_the_number_by_which_their_links_ignore_one_another(folder: Path) -> None:
    plan = plan_of(folder, "urdf: one.urdf, scale: {cycle: [1, 2]}, disable_self_collisions: true")
    bits = [one.links[0].body.collision_groups for one in plan.entities[0].structures
            if isinstance(one, ArticulationStructure)]  # fmt: skip
    assert [one is not None and one.numbers() for one in bits] == [(1, 1, 1 << 29, 0)] * 2


def test_one_robot_by_an_expression_that_may_have_no_value_is_checked_by_the_build(folder: Path) -> None:
    head = "draws: {k: {integers: [0, 20]}}\n"
    scene = written(folder, 'urdf: one.urdf, scale: "${[1, 1][k // 10]}"', head=head)
    (warning,) = validate(scene)
    assert warning.code == "SC516"
    seed = re.search(r"with seed (\d+)", warning.message)
    assert seed is not None
    with pytest.raises(SceneError, match="out of range"):
        compile_scene(scene, seed=int(seed[1]))
