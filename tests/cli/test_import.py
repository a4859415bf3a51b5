"""`scenecc import` as a command."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from scenecc import import_scene

SDF = """<sdf version="1.9"><model name="cube"><link name="body">
<collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision>{more}
</link></model></sdf>"""

URDF = """<robot name="r"><link name="base">{more}
<collision><geometry><sphere radius="1"/></geometry></collision></link></robot>"""


@pytest.fixture
def cube(tmp_path: Path) -> Path:
    path = tmp_path / "cube.sdf"
    path.write_text(SDF.format(more=""))
    return path


def test_import_writes_and_builds_a_scene_file(run, cube: Path) -> None:
    done = run("import", cube, "-o", "cube.yaml")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("built 1 body; total moving mass 1 kg\n")
    text = cube.with_suffix(".yaml").read_text()
    assert text.startswith("# Imported from cube.sdf by scenecc.\nscenecc: 1\n")
    assert yaml.safe_load(text)["entities"]["cube"]["inertial"] == {"mass": 1, "inertia": [1, 1, 1]}
    again = run("import", cube, "-o", "cube.yaml")
    assert again.returncode == 0
    assert cube.with_suffix(".yaml").read_text() == text


def test_import_losses_are_listed_on_standard_error(run, cube: Path) -> None:
    cube.write_text(SDF.format(more='<sensor name="s" type="imu"/>'))
    done = run("import", cube, "-o", "cube.yaml")
    assert done.returncode == 0
    assert "warning SC432: sensors (1): <sensor> `imu`" in done.stderr


def test_a_loss_without_allow_ends_the_import(run, cube: Path) -> None:
    cube.write_text(SDF.format(more="<inertial><mass>0</mass></inertial>"))
    done = run("import", cube, "-o", "cube.yaml")
    assert done.returncode == 1
    assert "allow it with --allow inertias" in done.stderr
    assert not cube.with_suffix(".yaml").exists()
    assert run("import", cube, "-o", "cube.yaml", "--allow", "inertias").returncode == 0


@pytest.mark.parametrize("arguments", [("--allow", "everything"), ("-o", "nowhere/cube.yaml"), ("-o", "-")])
def test_wrong_usage_of_import_exits_with_status_2(run, cube: Path, arguments: tuple[str, ...]) -> None:
    done = run("import", cube, *(arguments if "-o" in arguments else ("-o", "cube.yaml", *arguments)))
    assert done.returncode == 2


@pytest.mark.parametrize("output", ["w${1}.yaml", "scenecc:x.yaml", "~.yaml", "a\nb.yaml"])
def test_an_output_name_that_a_scene_cannot_refer_to_is_refused_early(run, cube: Path, output: str) -> None:
    cube.write_text("no SDF")
    done = run("import", cube, "-o", output)
    assert done.returncode == 2
    assert "SC904" in done.stderr
    assert "-o" in done.stderr
    assert "SC430" not in done.stderr
    with pytest.raises(ValueError, match="output"):
        import_scene(cube, cube.with_name(output))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((".", "-o", "x.yaml"), "name the source file"),
        (("cube.sdf", "-o", "-"), "name the scene file"),
        (("cube.sdf", "-o", "cube.sdf"), "`cube.sdf` is the source itself"),
    ],
)
def test_wrong_paths_of_import_are_usage_errors(run, cube: Path, arguments: tuple[str, ...], words: str) -> None:
    done = run("import", *arguments)
    assert done.returncode == 2
    assert words in done.stderr
    assert cube.read_text() == SDF.format(more="")


def test_an_asset_folder_that_is_a_file_is_an_error(run, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in/arm.urdf").write_text(URDF.format(more=""))
    (tmp_path / "out").mkdir()
    (tmp_path / "out/arm_assets").write_text("mine")
    done = run("import", "in/arm.urdf", "-o", "out/arm.yaml")
    assert done.returncode == 2
    assert "out/arm_assets` cannot be written: Not a directory" in done.stderr
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["arm_assets"]


def test_an_imported_urdf_stays_a_file(run, tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(URDF.format(more=""))
    done = run("import", "arm.urdf", "-o", "arm.yaml")
    assert done.returncode == 0, done.stderr
    assert yaml.safe_load((tmp_path / "arm.yaml").read_text())["entities"] == {"arm": {"urdf": "arm.urdf"}}


MJCF = """<mujoco><option timestep="0.005" integrator="RK4"/>
<asset>
<texture name="grid" type="2d" builtin="checker" width="8" height="8"/><material name="m" texture="grid"/></asset>
<worldbody><light pos="0 0 3" dir="0 0 -1" directional="true"/><camera name="side" pos="0 -4 1"/>
<body name="cart"><joint type="slide"/><site name="s"/><geom type="box" size="1 1 1" mass="2" material="m"/></body>
</worldbody><sensor><gyro site="s"/></sensor></mujoco>"""


def test_an_imported_mjcf_stays_a_file_beside_its_lights_and_cameras(run, tmp_path: Path) -> None:
    (tmp_path / "cart.xml").write_text(MJCF)
    done = run("import", "cart.xml", "-o", "cart.yaml", "--keep-file")
    assert done.returncode == 0, done.stderr
    assert "compared with MuJoCo: 1 body\n" in done.stdout
    found = yaml.safe_load((tmp_path / "cart.yaml").read_text())
    assert found["entities"] == {"cart": {"mjcf": "cart.xml"}}
    assert found["physics"] == {"timestep": 0.005, "gravity": [0, 0, -9.81]}
    assert (list(found["lights"]), list(found["cameras"])) == (["light"], ["side"])
    kinds = [line.split(" (")[0].partition("SC432: ")[2] for line in done.stderr.splitlines() if "SC432" in line]
    assert sorted(kinds) == ["material properties", "sensors", "sites", "world settings"]
    assert "`integrator` of <option>" in done.stderr
    assert "0 errors, 4 warnings\n" in done.stderr


def test_findings_about_an_imported_scene_are_reported_at_the_source_file(run, tmp_path: Path) -> None:
    joint = '<joint type="hinge" limited="true" range="0 0.4"/><geom size="1"/>'
    (tmp_path / "cart.xml").write_text(f"<mujoco><worldbody><body>{joint}</body></worldbody></mujoco>")
    done = run("import", "cart.xml", "-o", "cart.yaml")
    assert "cart.xml:1:20: warning SC526" in done.stderr


def test_a_repair_of_a_urdf_must_be_allowed(run, tmp_path: Path) -> None:
    inertia = '<inertia ixx="0" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    (tmp_path / "arm.urdf").write_text(URDF.format(more=f'<inertial><mass value="1"/>{inertia}</inertial>'))
    done = run("import", "arm.urdf", "-o", "arm.yaml")
    assert done.returncode == 1
    assert "allow it with --allow inertias" in done.stderr
    assert run("import", "arm.urdf", "-o", "arm.yaml", "--allow", "inertias").returncode == 0
    found = yaml.safe_load((tmp_path / "arm.yaml").read_text())["entities"]["arm"]
    assert found == {"urdf": "arm.urdf", "repair": ["inertia"]}


def test_the_import_page_lists_every_loss_that_must_be_allowed() -> None:
    from scenecc.importers.imported_scene import LOSSES

    page = (Path(__file__).parents[2] / "docs/reference/imports.md").read_text()
    missing = [kind for kind, row in LOSSES.items() if row.changes_machine and f"`{kind}`" not in page]
    assert not missing


def test_many_files_are_imported_into_a_folder_despite_one_error(run, cube: Path, tmp_path: Path) -> None:
    worlds = tmp_path / "worlds"
    (worlds / "deep").mkdir(parents=True)
    (worlds / "deep/a.sdf").write_text(SDF.format(more=""))
    (worlds / "b.sdf").write_text("no SDF")
    (worlds / "package.xml").write_text("<package/>")
    (tmp_path / "arm.urdf").write_text(URDF.format(more=""))
    done = run("import", "arm.urdf", "worlds", "-o", "out", "--jobs", "2")
    assert done.returncode == 1
    assert done.stderr.count("error SC430") == 1
    assert [*dict.fromkeys(line.split(":")[0] for line in done.stdout.splitlines())] == [
        "out/arm.yaml",
        "out/worlds/deep/a.yaml",
    ]
    written = sorted(str(path.relative_to(tmp_path / "out")) for path in (tmp_path / "out").rglob("*.yaml"))
    assert written == ["arm.yaml", "worlds/deep/a.yaml"]
    assert run("validate", "out").returncode == 0
    alone = run("import", "arm.urdf", "worlds", "-o", "alone")
    assert (alone.returncode, alone.stdout) == (1, done.stdout.replace("out/", "alone/"))
    assert alone.stderr == done.stderr


def test_a_part_of_the_files_is_imported_under_the_same_names(run, cube: Path, tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    for name in ("a", "b", "deep/c"):
        (tmp_path / f"{name}.sdf").write_text(SDF.format(more=""))
    done = run("import", "a.sdf", "b.sdf", "deep", "-o", "out", "--shard", "2/2")
    assert (done.returncode, done.stderr) == (0, "1 of 3 files: 2 in other parts\n")
    assert [str(path.relative_to(tmp_path)) for path in (tmp_path / "out").rglob("*.yaml")] == ["out/b.yaml"]
    done = run("import", "a.sdf", "-o", "a.yaml", "--shard", "1/2")
    assert "'--shard': it needs several files, or a folder" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("worlds", "-o", "out"), "no source in the folder `worlds`"),
        (("cube.sdf", "cube.urdf", "-o", "out"), "would both be written to `out/cube.yaml`"),
        (("cube.sdf", "no.urdf", "-o", "cube.sdf"), "`cube.sdf` cannot be created"),
    ],
)
def test_an_output_that_cannot_take_many_files_is_a_usage_error(
    run, cube: Path, arguments: tuple[str, ...], words: str
) -> None:
    cube.with_name("worlds").mkdir()
    cube.with_name("cube.urdf").write_text(URDF.format(more=""))
    done = run("import", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr
    assert not list(cube.parent.rglob("*.yaml"))
