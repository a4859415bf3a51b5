"""MJCF files as scenes: what is copied, and what the certificate says."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

import scenecc
from scenecc.errors import SceneError
from scenecc.importers.import_scene import import_scene

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("mujoco")

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
ROCK = """<mujoco><asset><mesh name="rock" file="rock.obj"/></asset>
<worldbody><geom type="mesh" mesh="rock"/></worldbody></mujoco>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("in", "out", "private"):
        (tmp_path / name).mkdir()
    (tmp_path / "private/key.mtl").write_text("newmtl private\n")
    return tmp_path


def test_no_file_outside_the_folder_is_read_or_copied(folder: Path) -> None:
    (folder / "in/rock.obj").write_text("mtllib ../private/key.mtl\n" + TETRAHEDRON)
    (folder / "in/rock.xml").write_text(ROCK)
    made = import_scene(folder / "in/rock.xml", folder / "out/rock.yaml")
    assert all(b"private" not in path.read_bytes() for path in made.paths)
    for path in made.paths:
        path.unlink()
    (folder / "out/rock_assets").rmdir()
    with pytest.raises(SceneError) as caught:
        import_scene(folder / "in/rock.xml", folder / "out/rock.yaml", keep_file=True)
    assert any("key.mtl" in one.message for one in caught.value.diagnostics)
    assert not list((folder / "out").iterdir())
    roots = [folder / "private"]
    made = import_scene(folder / "in/rock.xml", folder / "out/rock.yaml", asset_roots=roots, keep_file=True)
    assert any(path.name == "key.mtl" for path in made.paths)


def test_a_file_without_a_moving_body_is_compared(folder: Path) -> None:
    (folder / "in/rock.obj").write_text(TETRAHEDRON)
    (folder / "in/rock.xml").write_text(ROCK)
    made = import_scene(folder / "in/rock.xml", folder / "out/rock.yaml")
    compared = "compared with MuJoCo: nothing: none of the bodies has the name of a body in MuJoCo"
    assert made.certificate.lines() == ["built 1 body; total moving mass 0 kg", compared]


def test_joints_that_cannot_be_at_0_are_compared_within_their_limits(folder: Path) -> None:
    (folder / "arm.xml").write_text("""<mujoco><worldbody><body pos="0 0 1">
<joint type="hinge" axis="0 1 0" range="30 60"/><geom size="0.1" pos="0 0 1"/><body pos="0 0 1">
<joint type="hinge" axis="1 0 0" ref="10" range="-60 -20"/><joint type="slide" axis="0 0 1" range="0.1 0.2"/>
<geom size="0.1" pos="0 1 0"/></body></body></worldbody></mujoco>""")
    found = import_scene(folder / "arm.xml", folder / "arm.yaml").certificate
    assert (found.compared, found.not_compared) == (2, ())
    assert max(found.position, found.angle, found.relative_mass) < 1e-6


def test_joints_are_compared_where_equalities_hold_them(folder: Path) -> None:
    (folder / "hand.xml").write_text("""<mujoco><worldbody><body><joint name="a"/><geom size="0.1"/><body pos="0 1 0">
<joint name="b" ref="10"/><geom size="0.1" pos="1 0 0"/></body></body><body pos="0 0 2"><joint name="c"/>
<geom size="0.1" pos="1 0 0"/></body></worldbody><equality><joint joint1="a" polycoef="0.1 0 0 0 0"/>
<joint joint1="b" joint2="a" polycoef="0.2 1 0 0 0"/><joint joint1="c" joint2="a" polycoef="0.3 0 1 0 0"/></equality>
</mujoco>""")
    found = import_scene(folder / "hand.xml", folder / "hand.yaml", allow="all").certificate
    assert found.compared == 3
    assert max(found.position, found.angle) < 1e-6


def test_a_moment_of_0_is_listed(folder: Path) -> None:
    (folder / "arm.xml").write_text("""<mujoco><worldbody><body><freejoint/><geom size="0.1"/><body name="sensor">
<inertial pos="0 0 0" mass="0.002" diaginertia="0 0 0"/></body></body></worldbody></mujoco>""")
    found = import_scene(folder / "arm.xml", folder / "arm.yaml")
    assert [(one.code, "`sensor` is 0" in one.message) for one in found.diagnostics] == [("SC432", True)]


def test_links_of_a_kept_file_with_one_posed_robot_have_their_names(folder: Path) -> None:
    (folder / "arm.xml").write_text("""<mujoco><worldbody><body name="b" pos="0 0 1"><freejoint/><geom size="0.1"/>
<body name="c"><joint/><geom size="0.1" pos="0.3 0 0"/></body></body></worldbody>
<equality><connect body1="c" anchor="0.3 0 0"/></equality></mujoco>""")
    found = import_scene(folder / "arm.xml", folder / "scene.yaml", keep_file=True)
    assert found.certificate.compared == 2
    assert "child: arm/c" in (folder / "scene.yaml").read_text()


def test_the_mass_of_a_mocap_body_is_not_compared(folder: Path) -> None:
    (folder / "table.xml").write_text("""<mujoco><worldbody><body mocap="true"><geom size="1" density="0"/>
<inertial pos="0 0 0" mass="120" diaginertia="1 1 1"/></body><body pos="0 0 3"><freejoint/><geom size="0.1" mass="2"/>
</body></worldbody></mujoco>""")
    found = import_scene(folder / "table.xml", folder / "table.yaml").certificate
    assert (found.compared, found.masses, found.mass) == (2, 1, pytest.approx(2))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"file": 3}, "import_scene(): file must be a string or a path, not 3"),
        ({"output": None}, "import_scene(): output must be a string or a path, not None"),
        ({"allow": 3}, "import_scene(): allow must be names"),
        ({"allow": [3]}, "import_scene(): allow must be names"),
    ],
)
def test_a_wrong_argument_is_named_in_one_error(folder: Path, arguments: dict[str, Any], words: str) -> None:
    whole = {"file": folder / "in/rock.xml", "output": folder / "out/rock.yaml", **arguments}
    with pytest.raises(TypeError) as caught:
        import_scene(**whole)
    assert words in str(caught.value)


def test_the_file_is_kept_or_written_as_bodies(folder: Path) -> None:
    (folder / "world.xml").write_text("""<mujoco><worldbody><camera name="eye" pos="0 -1 0"/>
<body name="a/arm" pos="0 0 1"><joint name="a/hinge" axis="0 1 0"/><geom size="0.1" mass="2"/><body name="a/hand">
<joint name="a/wrist" type="ball"/><geom type="capsule" size="0.1 0.2" mass="1"/></body></body>
<body name="box" pos="0 0 3"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="2"/></body></worldbody>
<equality><weld name="held" body1="a/hand" body2="box"/></equality></mujoco>""")
    import_scene(folder / "world.xml", folder / "kept.yaml", keep_file=True)
    with scenecc.load_scene(folder / "kept.yaml", render=False) as batch:
        assert {*batch.entities, *batch.articulations} == {"world_2/dummy_root_0", "world_2/box"}
    import_scene(folder / "world.xml", folder / "written.yaml")
    text = (folder / "written.yaml").read_text()
    assert "mjcf:" not in text
    assert "held: {type: weld, parent: a/hand, child: box" in text
    assert "mass: 2" in text
    with scenecc.load_scene(folder / "written.yaml", render=False) as batch:
        (arm,) = batch.articulations.values()
        assert [link.name for link in arm.objs[0].links] == ["base", "arm", "hand_dummy_0", "hand_dummy_1", "hand"]
        assert [joint.name for joint in arm.objs[0].active_joints] == ["hinge", "wrist_x", "wrist_y", "wrist_z"]


BOX = '<body name="{0}" pos="0 0 1"><freejoint/><geom type="mesh" mesh="{0}" density="{1}"/></body>'


@pytest.mark.parametrize("marker", ["__init__.py", "package.xml"])
def test_files_outside_the_folder_are_copied_with_their_folders(folder: Path, marker: str) -> None:
    """Includes of includes through `..`, relative to the main file as MuJoCo has it, and files of one name."""
    package = folder / "robots"
    for name in ("worlds", "parts/a", "parts/b", "common"):
        (package / name).mkdir(parents=True)
    (package / marker).touch()
    (package / "parts/a/rock.obj").write_text(TETRAHEDRON)
    (package / "parts/b/rock.obj").write_text(TETRAHEDRON.replace("1", "2", 1))
    (package / "common/assets.xml").write_text(
        '<mujoco><asset><mesh name="a" file="a/rock.obj"/><mesh name="b" file="b/rock.obj"/></asset></mujoco>'
    )
    (package / "common/all.xml").write_text('<mujoco><include file="../../robots/common/assets.xml"/></mujoco>')
    (package / "worlds/world.xml").write_text(
        '<mujoco><compiler meshdir="../parts"/><include file="../common/all.xml"/>'
        f"<worldbody>{BOX.format('a', 100)}{BOX.format('b', 200)}</worldbody></mujoco>"
    )
    made = import_scene(package / "worlds/world.xml", folder / "out/world.yaml")
    assert made.certificate.masses == 2
    assert made.certificate.relative_mass < 1e-6
    package.rename(folder / "gone")
    with scenecc.load_scene(folder / "out/world.yaml", render=False) as batch:
        bodies: list[Any] = [held.objs[0].components[0] for held in batch.entities.values()]
        masses = [body.mass for body in bodies]
    assert sum(masses) == pytest.approx(made.certificate.mass)


def test_a_folder_beside_the_file_needs_an_asset_root(folder: Path) -> None:
    (folder / "private/rock.obj").write_text(TETRAHEDRON)
    (folder / "in/rock.xml").write_text(ROCK.replace("rock.obj", "../private/rock.obj"))
    with pytest.raises(SceneError) as caught:
        import_scene(folder / "in/rock.xml", folder / "out/rock.yaml")
    assert [one.code for one in caught.value.diagnostics] == ["SC402"]
    import_scene(folder / "in/rock.xml", folder / "out/rock.yaml", asset_roots=[folder / "private"], keep_file=True)
    assert (folder / "out/rock_assets/private/rock.obj").is_file()
    assert not [one for one in scenecc.validate(folder / "out/rock.yaml") if one.severity == "error"]


def test_cameras_and_lights_that_follow_a_body_are_aimed_at_where_it_starts(folder: Path) -> None:
    (folder / "aimed.xml").write_text("""<mujoco><worldbody><light mode="targetbody" target="a" pos="0 2 0"/>
<body name="a"><freejoint/><geom size="0.1"/><camera name="eye" pos="0 0 1" mode="targetbody" target="b"/></body>
<body name="b" pos="1 0 0"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>""")
    report = import_scene(folder / "aimed.xml", folder / "aimed.yaml")
    text = (folder / "aimed.yaml").read_text()
    assert "direction: [0, -1, 0]" in text
    assert "eye: {mount: a, pose: {p: [0, 0, 1], rpy_deg: [0, 45, 0]}" in text
    assert any("the tracking mode of the light" in one.message for one in report.diagnostics)


LOSSY = """<mujoco><worldbody><camera name="c" mode="track"/><body><joint name="j" range="30 60"/><geom size="0.1"/>
<site name="s"/></body><site name="t"/></worldbody><tendon><spatial><site site="s"/><site site="t"/></spatial></tendon>
</mujoco>"""


@pytest.mark.parametrize("allow", ["all", ["all"], ["tendons"]])
def test_what_the_import_lists_is_silenced_in_the_scene(folder: Path, allow: Any) -> None:
    (folder / "arm.xml").write_text(LOSSY)
    with pytest.raises(SceneError):
        import_scene(folder / "arm.xml", folder / "arm.yaml")
    import_scene(folder / "arm.xml", folder / "written.yaml", allow=allow)
    assert scenecc.validate(folder / "written.yaml") == []
    import_scene(folder / "arm.xml", folder / "arm.yaml", allow=allow, keep_file=True)
    text = (folder / "arm.yaml").read_text()
    assert "# Not as in the file, accepted by --allow: tendons.\n" in text
    assert "# scenecc: ignore SC484, SC490 -- listed by the import; allowed: tendons\n" in text
    assert "qpos: {j: 0.5235988}" in text
    assert scenecc.validate(folder / "arm.yaml") == []


@pytest.mark.parametrize("folder_key", ["meshdir", "assetdir", ""])
def test_absolute_paths_lead_to_the_copies(folder: Path, folder_key: str) -> None:
    (folder / "private/rock.obj").write_text(TETRAHEDRON)
    compiler = f'<compiler {folder_key}="{folder}/in"/>' if folder_key else ""
    absolute = ROCK.replace("<asset>", f"{compiler}<asset>").replace("rock.obj", f"{folder}/private/rock.obj")
    (folder / "in/rock.xml").write_text(absolute)
    import_scene(folder / "in/rock.xml", folder / "out/rock.yaml", asset_roots=[folder / "private"], keep_file=True)
    (folder / "private/rock.obj").unlink()
    assert not [one for one in scenecc.validate(folder / "out/rock.yaml") if one.severity == "error"]


def test_absolute_paths_in_included_and_attached_files_lead_to_the_copies(folder: Path) -> None:
    for name in ("parts", "models/meshes"):
        (folder / "in" / name).mkdir(parents=True)
    for name in ("rock.obj", "models/meshes/part.obj"):
        (folder / "in" / name).write_text(TETRAHEDRON)
    whole = """<mujoco><include file="{0}/parts/assets.xml"/><!-- <compiler meshdir="gone"/> -->
<asset><model name="m" file="{0}/models/part.xml"/></asset><worldbody><geom type="mesh" mesh="rock"/>
<body><freejoint/><geom size="0.1"/><attach model="m" body="part" prefix="a_"/></body></worldbody></mujoco>"""
    included = """<mujoco><include file="{0}/parts/folders.xml"/><asset><mesh file="{0}/rock.obj"/></asset></mujoco>"""
    folders = '<mujoco><compiler meshdir="{0}/models"/></mujoco>'
    attached = """<mujoco><compiler meshdir="{0}/models/meshes"/><asset><mesh file="part.obj"/></asset><worldbody>
<body name="part"><geom type="mesh" mesh="part"/></body></worldbody></mujoco>"""
    texts = {"all.xml": whole, "parts/assets.xml": included, "parts/folders.xml": folders, "models/part.xml": attached}
    for name, text in texts.items():
        (folder / "in" / name).write_text(text.format(folder / "in"))
    import_scene(folder / "in/all.xml", folder / "out/all.yaml", keep_file=True)
    (folder / "in").rename(folder / "gone")
    assert not [one for one in scenecc.validate(folder / "out/all.yaml") if one.severity == "error"]
    copies = [path.read_text() for path in (folder / "out/all_assets").rglob("*.xml")]
    assert len(copies) == len(texts)
    assert not any(str(folder) in text for text in copies)


PLANAR = """<mujoco><asset><material name="steel" rgba="0.5 0.5 0.5 1" shininess="0.8"/></asset><worldbody>
<body name="puck" pos="0 0 0.1"><joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.1" size="0.02" material="steel"/>
<body name="pin" euler="0 90 0"><geom size="0.01"/></body></body>
<body name="hand" mocap="true"/></worldbody>
<equality><weld body1="hand" body2="pin"/></equality></mujoco>"""


def test_a_robot_has_the_name_of_its_first_body_and_plain_rotations(folder: Path) -> None:
    (folder / "table.xml").write_text(PLANAR)
    import_scene(folder / "table.xml", folder / "table.yaml")
    text = (folder / "table.yaml").read_text()
    assert "\n  puck:\n" in text
    assert "\n  hand: {body_type: kinematic, shapes: []}\n" in text
    assert "{type: weld, parent: hand, child: puck/pin,\n" in text
    assert "rpy_deg: [0, 90, 0]" in text
    assert (
        "  steel: {visual: {base_color: [0.21404114, 0.21404114, 0.21404114], specular: 0.5, roughness: 0.2}}\n" in text
    )
    assert "{type: capsule, pose: [0, 0, -0.05], radius: 0.02, half_length: 0.05, axis: z" in " ".join(text.split())


@pytest.mark.parametrize(
    ("held", "parent", "pose"),
    [
        ("", "world", "{p: [1, 0, 2], rpy_deg: [0, 90, 0]}"),
        ('<geom size="0.01"/>', "post", "{p: [0, 0, 2], rpy_deg: [0, 90, 0]}"),
        ('mocap="true"', "post", "{p: [0, 0, 2], rpy_deg: [0, 90, 0]}"),
    ],
)
def test_a_weld_to_a_body_without_joints_is_to_what_is_built_of_it(
    folder: Path, held: str, parent: str, pose: str
) -> None:
    mocap, geom = (held, "") if "mocap" in held else ("", held)
    post = f'<body name="post" {mocap} pos="1 0 0">{geom}<body name="hand" pos="0 0 1" euler="0 90 0"/></body>'
    pin = '<body name="pin" pos="1 0 2" euler="0 90 0"><freejoint/><geom size="0.1"/></body>'
    weld = '<equality><weld body1="hand" body2="pin" relpose="-1 0 0 1 0 0 0"/></equality>'
    (folder / "a.xml").write_text(f"<mujoco><worldbody>{post}{pin}</worldbody>{weld}</mujoco>")
    import_scene(folder / "a.xml", folder / "a.yaml")
    found = " ".join((folder / "a.yaml").read_text().split())
    assert f"{{type: weld, parent: {parent}, child: pin, pose_in_parent: {pose}" in found


def test_equal_bodies_with_named_geoms_become_instances_of_a_prefab(folder: Path) -> None:
    parts = [f'<geom name="chair_{{0}}_part{n}" type="box" size="0.1 0.1 0.{n + 1}"/>' for n in range(7)]
    chair = f"<body name='chair_{{0}}' pos='{{0}} 0 {{0}}'><freejoint/>{''.join(parts)}</body>"
    chairs = "".join(chair.format(number) for number in range(5))
    (folder / "hall.xml").write_text(f"<mujoco><worldbody>{chairs}</worldbody></mujoco>")
    import_scene(folder / "hall.xml", folder / "hall.yaml")
    assert "  chair_4: {use: hall_assets/chair.yaml, pose: [4, 0, 4]}\n" in (folder / "hall.yaml").read_text()
    assert "{name: part6, type: box, " in (folder / "hall_assets/chair.yaml").read_text()
