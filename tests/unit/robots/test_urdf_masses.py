"""Links of a URDF without a mass in the file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

import scenecc
from scenecc.diagnostics import Sink
from scenecc.robots.urdf import read_urdf
from scenecc.source.paths import AssetScope, ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path

INERTIAL = '<inertial><mass value="{}"/><inertia ixx="{}" iyy="{}" izz="{}" ixy="0" ixz="0" iyz="0"/></inertial>'
BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
JOINT = '<joint name="{1}" type="{0}"><parent link="shank"/><child link="{1}"/><axis xyz="0 1 0"/></joint>'


def read(folder: Path, foot: str, kind: str = "fixed", moment: float = 0.01, *repair: str) -> tuple[Any, list[str]]:
    shank = INERTIAL.format(1, moment, moment, moment)
    links = f'<link name="base"/><link name="shank">{shank}</link><link name="foot">{foot}</link>'
    knee = JOINT.format("continuous", "shank").replace('parent link="shank"', 'parent link="base"')
    file, sink = folder / "leg.urdf", Sink()
    file.write_text(f'<robot name="leg">{links}{knee}{JOINT.format(kind, "foot")}</robot>')
    found = read_urdf(ResolvedFile(file, file.name), scope=AssetScope(folder), sink=sink, repair=frozenset(repair))
    assert found is not None
    return found.robots[0].links[2].inertial, [f"{one.code} {one.message}" for one in sink.diagnostics()]


@pytest.mark.parametrize("foot", [BALL, INERTIAL.format(0, 0, 0, 0) + BALL])
def test_a_mass_that_follows_from_shapes_is_noted(tmp_path: Path, foot: str) -> None:
    inertial, told = read(tmp_path, foot)
    assert inertial is None
    assert told == ["SC448 `foot` has no mass in the file: it gets that of its collision shapes"]


def test_a_fixed_link_without_mass_gets_almost_none_with_repair_mass(tmp_path: Path) -> None:
    inertial, told = read(tmp_path, BALL, "fixed", 0.01, "mass")
    assert inertial.mass == 1e-6
    assert max(inertial.inertia) < 1e-12
    assert told == ["SC488 `foot` without mass, fixed to others: almost no mass, 1e-06 kg"]


def test_a_moving_link_keeps_the_mass_of_its_shapes(tmp_path: Path) -> None:
    inertial, told = read(tmp_path, BALL, "continuous", 0.01, "mass")
    assert (inertial, told) == (None, [])


@pytest.mark.parametrize(("moment", "codes"), [(0.01, []), (5e-5, ["SC448"])])
def test_a_frame_is_noted_if_its_inertia_matters(tmp_path: Path, moment: float, codes: list[str]) -> None:
    _, told = read(tmp_path, "", "fixed", moment)
    assert [one[:5] for one in told] == codes


def test_the_built_leg_has_the_mass_of_the_file_with_repair_mass(tmp_path: Path) -> None:
    read(tmp_path, BALL)
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {leg: {urdf: leg.urdf, repair: [mass]}}\n")
    with scenecc.load_scene(scene, render=False) as batch:
        links = batch.articulations["leg"].objs[0].links
        assert sum(link.mass for link in links[1:]) == pytest.approx(1, abs=1e-5)


def test_an_empty_root_above_a_floating_joint_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "drone.urdf").write_text(
        f'<robot name="drone"><link name="world"/><link name="body">{INERTIAL.format(1, 1, 1, 1)}{BALL}</link>'
        f'<link name="shank">{INERTIAL.format(1, 1, 1, 1)}</link>'
        '<joint name="free" type="floating"><parent link="world"/><child link="body"/></joint>'
        '<joint name="hinge" type="continuous"><parent link="body"/><child link="shank"/></joint></robot>'
    )
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {drone: {urdf: drone.urdf}}\n")
    with scenecc.load_scene(scene, render=False) as batch:
        assert [link.name for link in batch.articulations["drone"].objs[0].links] == ["body", "shank"]
