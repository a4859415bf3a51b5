"""URDFs as scenes: by their file, which is copied only where the scene cannot name it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from scenecc import SceneError, open_scene
from scenecc.backends.sapien.measure import measure_bodies
from scenecc.diagnostics import Sink
from scenecc.importers.import_scene import import_scene
from scenecc.importers.imported_scene import ImportContext
from scenecc.importers.urdf import import_urdf
from scenecc.options import Options
from scenecc.source.paths import AssetScope

SCENES = Path(__file__).parents[3] / "scenes"

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
ROBOT = """<robot name="r"><link name="base">
<collision><geometry><mesh filename="{mesh}"/></geometry></collision>
<inertial><mass value="2"/><inertia ixx="{ixx}" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    (tmp_path / "in/meshes").mkdir(parents=True)
    (tmp_path / "out").mkdir()
    (tmp_path / "in/meshes/a.obj").write_text(TETRAHEDRON)
    (tmp_path / "in/robot.urdf").write_text(ROBOT.format(mesh="meshes/a.obj", ixx=1))
    return tmp_path / "in/robot.urdf"


def masses(scene: Path) -> dict[str, float]:
    with open_scene(scene).build(render=False) as batch:
        bodies = [body for entity in measure_bodies(batch).scenes[0].entities for body in entity.bodies]
        return {body.name: body.mass.mass for body in bodies if body.mass is not None}


def test_a_robot_is_copied_with_its_meshes(robot: Path, tmp_path: Path) -> None:
    made = import_scene(robot, tmp_path / "out/scene.yaml")
    assert list(made.files) == ["scene.yaml", "scene_assets/robot.urdf", "scene_assets/meshes/a.obj"]
    robot.unlink()
    assert masses(tmp_path / "out/scene.yaml") == {"robot": 2}


def test_a_robot_below_the_scene_or_in_an_asset_root_is_not_copied(robot: Path, tmp_path: Path) -> None:
    assert list(import_scene(robot, tmp_path / "scene.yaml").files) == ["scene.yaml"]
    assert "urdf: in/robot.urdf" in (tmp_path / "scene.yaml").read_text()
    import_scene(robot, tmp_path / "out/scene.yaml", asset_roots=[tmp_path / "in"])
    assert "urdf: asset://robot.urdf" in (tmp_path / "out/scene.yaml").read_text()


def test_a_repair_of_a_robot_must_be_allowed(robot: Path, tmp_path: Path) -> None:
    robot.write_text(ROBOT.format(mesh="meshes/a.obj", ixx=-1))
    with pytest.raises(SceneError) as caught:
        import_scene(robot, tmp_path / "scene.yaml")
    assert [each.code for each in caught.value.diagnostics] == ["SC431"]
    assert not (tmp_path / "scene.yaml").exists()
    import_scene(robot, tmp_path / "scene.yaml", allow=["inertias"])
    assert "repair: [inertia]" in (tmp_path / "scene.yaml").read_text()


ZERO = 'ixx="0" iyy="0" izz="0"'


@pytest.mark.parametrize(
    ("inertial", "mass", "repair"),
    [
        (f'<mass value="5"/><inertia {ZERO} ixy="0" ixz="0" iyz="0"/>', 5, True),
        ('<mass value="5"/><inertia ixx="1" iyy="1" izz="9" ixy="0" ixz="0" iyz="0"/>', 5, True),
        # No body has an inertia and no mass: the mass is that of the mesh, 1/6 m³ of water.
        ('<mass value="0"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>', 1000 / 6, False),
    ],
)
def test_a_zero_or_impossible_inertia_must_be_allowed(
    robot: Path, tmp_path: Path, inertial: str, mass: float, repair: bool
) -> None:
    robot.write_text(re.sub("<inertial>.*</inertial>", f"<inertial>{inertial}</inertial>", ROBOT, flags=re.DOTALL))
    robot.write_text(robot.read_text().format(mesh="meshes/a.obj"))
    with pytest.raises(SceneError) as caught:
        import_scene(robot, tmp_path / "scene.yaml")
    assert [each.code for each in caught.value.diagnostics] == ["SC431"]
    made = import_scene(robot, tmp_path / "scene.yaml", allow=["inertias"])
    assert [each.code for each in made.diagnostics if each.code != "SC525"] == ["SC432"]
    assert ("repair: [inertia]" in (tmp_path / "scene.yaml").read_text()) == repair
    assert masses(tmp_path / "scene.yaml") == pytest.approx({"robot": mass}, rel=1e-4)


def test_a_collision_without_volume_must_be_allowed(robot: Path, tmp_path: Path) -> None:
    ball = '<collision><geometry><sphere radius="0"/></geometry></collision><inertial>'
    robot.write_text(ROBOT.format(mesh="meshes/a.obj", ixx=1).replace("<inertial>", ball))
    with pytest.raises(SceneError) as caught:
        import_scene(robot, tmp_path / "scene.yaml")
    assert [each.code for each in caught.value.diagnostics] == ["SC431"]
    import_scene(robot, tmp_path / "scene.yaml", allow=["colliders"])
    assert "repair: [shapes]" in (tmp_path / "scene.yaml").read_text()


@pytest.mark.parametrize("mesh", ["../../secret.obj", "meshes/gone.obj", "/etc/passwd"])
def test_a_mesh_that_may_not_be_read_is_an_error(robot: Path, tmp_path: Path, mesh: str) -> None:
    (tmp_path / "secret.obj").write_text(TETRAHEDRON)
    robot.write_text(ROBOT.format(mesh=mesh, ixx=1))
    with pytest.raises(SceneError) as caught:
        import_scene(robot, tmp_path / "out/scene.yaml")
    assert {each.code for each in caught.value.diagnostics} <= {"SC401", "SC402", "SC403", "SC470", "SC472"}
    assert not list((tmp_path / "out").iterdir())


def test_links_above_which_an_empty_world_floats_have_their_names(robot: Path, tmp_path: Path) -> None:
    root = '<robot name="r"><link name="world"/><joint name="f" type="floating"><parent link="world"/>'
    joint = f'{root}<child link="base"/><origin xyz="0 0 1"/></joint>'
    robot.write_text(ROBOT.format(mesh="meshes/a.obj", ixx=1).replace('<robot name="r">', joint))
    found = import_urdf(robot, ImportContext(Sink(), AssetScope(robot.parent), Options().limits))
    assert found is not None
    assert found.bodies == {"robot": "base"}


@pytest.mark.parametrize("name", ["robot_arm", "robot_door"])
def test_an_exported_urdf_is_imported_again(name: str, tmp_path: Path) -> None:
    scene = SCENES / f"{name}.yaml"
    with open_scene(scene).build(render=False, scene_idxs=[0]) as batch:
        entities = {each.entity.name: each for each in measure_bodies(batch).scenes[0].entities}
    robots = [entity for entity in entities.values() if len(entity.bodies) > 1]
    assert robots
    for robot in robots:
        file = tmp_path / f"{robot.entity.name}.urdf"
        open_scene(scene).export(file, entity=robot.entity.name)
        import_scene(file, file.with_suffix(".yaml"))
        expected = {body.name: body.mass.mass for body in robot.bodies if body.mass is not None}
        assert masses(file.with_suffix(".yaml")) == pytest.approx(expected, rel=1e-6)


def test_a_failed_import_leaves_existing_files_unchanged(
    robot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise SceneError([])

    monkeypatch.setattr("scenecc.importers.certificate.certificate_of", fail)
    with pytest.raises(SceneError):
        import_scene(robot, tmp_path / "out/scene.yaml")
    assert not list((tmp_path / "out").iterdir())
    (tmp_path / "out/scene.yaml").write_text("mine")
    with pytest.raises(SceneError):
        import_scene(robot, tmp_path / "out/scene.yaml")
    assert (tmp_path / "out/scene.yaml").read_text() == "mine"
    assert len(list((tmp_path / "out").iterdir())) == 1
