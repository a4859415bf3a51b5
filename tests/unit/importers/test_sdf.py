"""SDF files as scenes: what is built is what the format means, and what is not built is told."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pytest

from scenecc import SceneError, open_scene
from scenecc.importers.certificate import Certificate, certificate_of
from scenecc.importers.import_scene import Imported, import_scene
from scenecc.importers.imported_scene import ImportedScene
from scenecc.source.read import read_file

LINK = """<link name="{name}"><pose {frame}>{pose}</pose><inertial><mass>{mass}</mass>
  <inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>
  <collision name="c"><geometry><box><size>0.2 0.4 0.6</size></box></geometry></collision></link>"""


def link(name: str, pose: str = "0 0 0 0 0 0", mass: float = 1, frame: str = "") -> str:
    return LINK.format(name=name, pose=pose, mass=mass, frame=frame)


def joint(kind: str, parent: str, child: str, inside: str = "", name: str = "j") -> str:
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{inside}</joint>'


def world(inside: str, version: str = "1.9") -> str:
    return f'<?xml version="1.0"?>\n<sdf version="{version}"><world name="w">\n{inside}\n</world></sdf>\n'


def model(inside: str, name: str = "m", rest: str = "") -> str:
    return world(f'<model name="{name}" {rest}>\n{inside}\n</model>')


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    return tmp_path


def imported(folder: Path, text: str, **options) -> tuple[dict, Imported]:
    """The document as written, which was built by then."""
    (folder / "in/world.sdf").write_text(text)
    made = import_scene(folder / "in/world.sdf", folder / "out/scene.yaml", **options)
    return document(folder), made


def document(folder: Path) -> dict:
    from scenecc.diagnostics import Sink
    from scenecc.source import Limits

    found = read_file(str(folder / "out/scene.yaml"), Sink(), Limits())
    assert found is not None
    return found.data


def refused(folder: Path, text: str, **options) -> list[str]:
    """Codes of the errors; nothing was written."""
    with pytest.raises(SceneError) as caught:
        imported(folder, text, **options)
    assert not list((folder / "out").iterdir())
    errors = [each for each in caught.value.diagnostics if each.severity == "error"]
    assert all(each.file and each.file.endswith((".sdf", ".png")) for each in errors), errors
    return [each.code for each in errors]


def body_poses(folder: Path) -> dict[str, tuple[list[float], list[float]]]:
    """Pose of every body as built, by `ENTITY` or `ENTITY/LINK`."""
    found = {}
    with open_scene(folder / "out/scene.yaml").build(render=False) as batch:
        for name, entity in batch.entities.items():
            pose = entity.objs[0].get_pose()
            found[name] = list(pose.p), list(pose.q)
        for name, robot in batch.articulations.items():
            for each in robot.objs[0].get_links():
                pose = each.get_entity().get_pose()
                found[f"{name}/{each.get_name()}"] = list(pose.p), list(pose.q)
    return found


def test_a_model_with_one_link_becomes_a_body(folder: Path) -> None:
    found, made = imported(folder, model("<pose>1 2 3 0 0 0.5</pose>" + link("a", "0 0 1 0 0 0", 2)))
    cube = found["entities"]["m"]
    assert cube["pose"]["p"] == [1, 2, 4]
    assert cube["inertial"] == {"mass": 2, "inertia": [0.1, 0.1, 0.1]}
    assert cube["collisions"] == [{"type": "box", "half_size": [0.1, 0.2, 0.3]}]
    assert made.losses == ()
    assert body_poses(folder)["m"][1][3] == pytest.approx(math.sin(0.25))


def test_a_collision_and_a_visual_of_equal_geometry_become_one_shape(folder: Path) -> None:
    visual = """<visual name="v"><geometry><box><size>0.2 0.4 0.6</size></box></geometry>
      <material><diffuse>1 0 0 1</diffuse></material></visual></link>"""
    found, _ = imported(folder, model(link("a").replace("</link>", visual)))
    assert found["entities"]["m"]["shapes"] == [{"type": "box", "half_size": [0.1, 0.2, 0.3]}]
    assert found["entities"]["m"]["color"] == [1, 0, 0]
    assert "visuals" not in found["entities"]["m"]


def test_links_and_joints_become_a_link_tree(folder: Path) -> None:
    axis = "<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>2</upper></limit></axis>"
    parts = link("base") + link("arm", "0 0 1 0 0 0") + joint("revolute", "base", "arm", axis)
    found, _ = imported(folder, model(parts))
    robot = found["entities"]["m"]
    assert robot["disable_self_collisions"] is True
    (arm,) = robot["root"]["children"]
    expected = {"name": "j", "type": "revolute", "origin": [0, 0, 1], "axis": "z", "limits": [-1, 2], "friction": 0}
    assert arm["joint"] == expected
    assert body_poses(folder)["m/arm"][0] == pytest.approx([0, 0, 1])


def test_a_joint_to_the_world_fixes_the_root(folder: Path) -> None:
    parts = link("base") + link("arm", "0 0 1 0 0 0") + joint("fixed", "world", "base", name="w")
    axis = "<axis><xyz>1 0 0</xyz><limit><lower>-1e16</lower><upper>2</upper></limit></axis>"
    found, _ = imported(folder, model(parts + joint("prismatic", "base", "arm", axis)))
    robot = found["entities"]["m"]
    assert robot["fix_root_link"] is True
    assert robot["root"]["children"][0]["joint"]["limits"] == [-math.inf, 2]


def test_a_hinge_to_the_world_gets_a_base_link(folder: Path) -> None:
    found, _ = imported(folder, model(link("arm", "0 0 1 0 0 0") + joint("revolute", "world", "arm")))
    root = found["entities"]["m"]["root"]
    assert root["name"] == "base"
    assert [child["name"] for child in root["children"]] == ["arm"]
    assert body_poses(folder)["m/arm"][0] == pytest.approx([0, 0, 1])


def test_two_hinges_make_a_universal_joint(folder: Path) -> None:
    axes = "<pose>0 0 -0.5 0 0 0</pose><axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
    found, _ = imported(folder, model(link("a") + link("b", "0 0 1 0 0 0") + joint("universal", "a", "b", axes)))
    first = found["entities"]["m"]["root"]["children"][0]
    assert first["joint"].get("axis", "x") == "x"
    assert first["joint"]["origin"] == [0, 0, 0.5]
    assert body_poses(folder)["m/b"][0] == pytest.approx([0, 0, 1])


def test_a_joint_that_closes_a_loop_becomes_a_constraint(folder: Path) -> None:
    parts = "".join(link(name, f"{x} 0 0 0 0 0") for name, x in (("a", 0), ("b", 1), ("c", 2)))
    joints = joint("revolute", "a", "b", name="ab") + joint("revolute", "b", "c", name="bc")
    found, _ = imported(folder, model(parts + joints + joint("fixed", "a", "c", name="ac")))
    assert found["constraints"]["ac"]["type"] == "weld"
    assert (found["constraints"]["ac"]["parent"], found["constraints"]["ac"]["child"]) == ("m/a", "m/c")


def test_an_axis_may_be_expressed_in_another_frame(folder: Path) -> None:
    turned = "0 0 1 0 0 1.5707963267948966"
    axis = '<axis><xyz expressed_in="__model__">1 0 0</xyz></axis>'
    found, _ = imported(folder, model(link("a") + link("b", turned) + joint("revolute", "a", "b", axis)))
    assert found["entities"]["m"]["root"]["children"][0]["joint"]["axis"] == pytest.approx([0, -1, 0])


def test_axes_of_old_versions_are_in_the_model_frame(folder: Path) -> None:
    parts = link("a") + link("b", "0 0 1 0 0 1.5707963267948966")
    text = model(parts + joint("revolute", "a", "b", "<axis><xyz>1 0 0</xyz></axis>")).replace('"1.9"', '"1.4"')
    found, _ = imported(folder, text)
    assert found["entities"]["m"]["root"]["children"][0]["joint"]["axis"] == pytest.approx([0, -1, 0])


def test_poses_may_be_relative_to_frames(folder: Path) -> None:
    frames = '<frame name="f" attached_to="a"><pose>1 0 0 0 0 1.5707963267948966</pose></frame>'
    parts = link("a", "0 0 1 0 0 0") + frames + link("b", "1 0 0 0 0 0", frame='relative_to="f"')
    imported(folder, model(parts))
    assert body_poses(folder)["m.b"][0] == pytest.approx([1, 1, 1], abs=1e-6)


def test_the_pose_of_a_model_applies_to_its_placement_frame(folder: Path) -> None:
    text = model("<pose>5 0 0 0 0 0</pose>" + link("a", "0 0 2 0 0 0"), rest='placement_frame="a"')
    imported(folder, text)
    assert body_poses(folder)["m"][0] == pytest.approx([5, 0, 0])


def test_links_of_nested_models_have_dotted_names(folder: Path) -> None:
    inner = f'<model name="inner"><pose>0 1 0 0 0 0</pose>{link("b")}</model>'
    found, _ = imported(folder, model(link("a") + inner + joint("fixed", "a", "inner::b")))
    assert found["entities"]["m"]["root"]["children"][0]["name"] == "inner.b"
    assert body_poses(folder)["m/inner.b"][0] == pytest.approx([0, 1, 0])


def test_a_model_is_found_in_its_folder_and_in_an_asset_root(folder: Path) -> None:
    (folder / "in/cup").mkdir()
    (folder / "in/cup/model.config").write_text("<model><sdf version='1.9'>cup.sdf</sdf></model>")
    (folder / "in/cup/cup.sdf").write_text(f'<sdf version="1.9"><model name="cup">{link("body")}</model></sdf>')
    include = "<include><uri>model://cup</uri><name>{}</name><pose>{} 0 0 0 0 0</pose></include>"
    found, _ = imported(folder, world(include.format("one", 1) + include.format("two", 2)))
    assert list(found["entities"]) == ["one", "two"]
    (folder / "in/cup").rename(folder / "cup")
    (folder / "out/scene.yaml").unlink()
    assert refused(folder, world(include.format("one", 1))) == ["SC431"]
    imported(folder, world(include.format("one", 1)), asset_roots=[folder])
    assert body_poses(folder)["one"][0] == pytest.approx([1, 0, 0])


def test_a_static_model_does_not_move(folder: Path) -> None:
    plane = "<collision name='c'><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>"
    found, _ = imported(folder, model(f"<static>true</static><link name='l'>{plane}</link>"))
    assert found["entities"]["m"] == {"body_type": "static", "collisions": [{"type": "plane"}]}


def test_friction_and_physics_settings_are_imported(folder: Path) -> None:
    surface = "<surface><friction><ode><mu>0.4</mu></ode></friction></surface></collision>"
    text = model(link("a").replace("</collision>", surface))
    text = text.replace(
        "<model", "<gravity>0 0 -3</gravity><physics><max_step_size>0.004</max_step_size></physics><model"
    )
    found, _ = imported(folder, text)
    default = {"static_friction": 1, "dynamic_friction": 1, "restitution": 0}
    assert found["physics"] == {"timestep": 0.004, "gravity": [0, 0, -3], "default_material": default}
    physical = {"static_friction": 0.4, "dynamic_friction": 0.4, "restitution": 0}
    assert found["entities"]["m"]["material"] == {"physical": physical}


def test_lights_and_cameras_are_imported(folder: Path) -> None:
    sun = '<light name="sun" type="directional"><direction>0 1 -1</direction><diffuse>1 1 0.5 1</diffuse></light>'
    sensor = """<sensor name="eye" type="camera"><pose>0 0 0.1 0 0 0</pose><camera><horizontal_fov>1.2</horizontal_fov>
      <image><width>64</width><height>48</height></image></camera></sensor></link>"""
    found, _ = imported(folder, world(sun + f'<model name="m">{link("a").replace("</link>", sensor)}</model>'))
    assert found["lights"]["sun"] == {"type": "directional", "color": [1, 1, 0.5], "direction": [0, 1, -1]}
    eye = found["cameras"]["m.a.eye"]
    assert (eye["mount"], eye["fovx"], eye["width"], eye["pose"]) == ("m", 1.2, 64, [0, 0, 0.1])


def test_the_mass_of_an_auto_inertial_is_computed_from_the_density(folder: Path) -> None:
    auto = '<inertial auto="true"><density>500</density></inertial><collision name="c"><geometry><cylinder>'
    text = f'<link name="a">{auto}<radius>0.1</radius><length>0.4</length></cylinder></geometry></collision></link>'
    found, made = imported(folder, model(text))
    assert found["entities"]["m"]["mass"] == pytest.approx(500 * math.pi * 0.01 * 0.4)
    assert made.certificate.mass == pytest.approx(500 * math.pi * 0.01 * 0.4, rel=1e-6)


def test_an_inertia_tensor_is_rotated_to_its_principal_axes(folder: Path) -> None:
    tensor = "<ixx>0.2</ixx><iyy>0.2</iyy><izz>0.1</izz><ixy>0.05</ixy>"
    text = link("a").replace("<ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz>", tensor)
    found, _ = imported(folder, model(text))
    assert sorted(found["entities"]["m"]["inertial"]["inertia"]) == pytest.approx([0.1, 0.15, 0.25])


def test_bitmasks_become_groups_or_collision_bits(folder: Path) -> None:
    def masked(name: str, mask: str) -> str:
        surface = f"<surface><contact><collide_bitmask>{mask}</collide_bitmask></contact></surface></collision>"
        return f'<model name="{name}">{link("a").replace("</collision>", surface)}</model>'

    found, _ = imported(folder, world(masked("one", "0x01") + masked("two", "2")))
    assert found["collision_groups"] == {"one": {"ignore": ["one"]}}
    assert [found["entities"][name]["collision_group"] for name in ("one", "two")] == ["one", "one"]
    second = '<collision name="other"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>'
    both = masked("one", "0x01").replace("</link>", f"{second}</link>")
    found, made = imported(folder, world(both + masked("two", "2")))
    assert not [loss for loss in made.losses if loss.kind == "collision-bitmasks"]
    bits = [shape["collision_bits"] for shape in found["entities"]["one"]["collisions"]]
    assert bits == [[1, 1, 0, 0], [0xFFFF, 0xFFFF, 0, 0]]


def test_a_mesh_is_copied_beside_the_scene(folder: Path) -> None:
    (folder / "in/meshes").mkdir()
    tetrahedron = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    (folder / "in/meshes/a.obj").write_text(tetrahedron)
    (folder / "in/meshes/a.mtl").write_text("newmtl m\nKd 1 0 0\n")
    mesh = "<geometry><mesh><uri>meshes/a.obj</uri><scale>0.5 0.5 0.5</scale></mesh></geometry>"
    text = link("a").replace("<geometry><box><size>0.2 0.4 0.6</size></box></geometry>", mesh)
    found, made = imported(folder, model(text))
    (shape,) = found["entities"]["m"]["collisions"]
    assert shape == {"type": "convex_mesh", "file": "scene_assets/meshes/a.obj", "scale": 0.5}
    assert (folder / "out/scene_assets/meshes/a.mtl").read_text().startswith("newmtl")
    assert [loss.kind for loss in made.losses] == ["hulls"]


def test_a_mirrored_collision_mesh_faces_outwards(folder: Path) -> None:
    (folder / "in/a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    mesh = "<geometry><mesh><uri>a.obj</uri><scale>-1 1 1</scale></mesh></geometry>"
    found, _ = imported(
        folder, model(link("a").replace("<geometry><box><size>0.2 0.4 0.6</size></box></geometry>", mesh))
    )
    assert found["entities"]["m"]["collisions"][0]["file"] == "scene_assets/a.obj"
    assert "v -1.0 0.0 0.0" in (folder / "out/scene_assets/a.obj").read_text()


@pytest.mark.parametrize(
    ("shape", "kind"),
    [
        ("<ellipsoid><radii>0.1 0.2 0.3</radii></ellipsoid>", "convex_mesh"),
        ("<capsule><radius>0.1</radius><length>0.3</length></capsule>", "capsule"),
        ("<cone><radius>0.1</radius><length>0.3</length></cone>", "cone"),
        ("<sphere><radius>0.1</radius></sphere>", "sphere"),
        (
            "<polyline><point>0 0</point><point>1 0</point><point>1 1</point><height>1</height></polyline>",
            "convex_mesh",
        ),
    ],
)
def test_every_geometry_is_imported(folder: Path, shape: str, kind: str) -> None:
    text = link("a").replace("<box><size>0.2 0.4 0.6</size></box>", shape)
    found, _ = imported(folder, model(text))
    assert found["entities"]["m"]["collisions"][0]["type"] == kind


def test_losses_are_reported_at_their_places(folder: Path) -> None:
    plugin = '<plugin filename="libwind.so" name="wind"/>'
    _, made = imported(folder, model(link("a") + plugin + plugin))
    assert [(loss.kind, loss.place.line) for loss in made.losses] == [("plugins", 6), ("plugins", 6)]
    (told,) = [each for each in made.diagnostics if each.code == "SC432"]
    assert told.message.startswith("plugins (2): <plugin> `libwind.so`")


def test_a_loss_that_changes_the_dynamics_must_be_allowed(folder: Path) -> None:
    text = model(link("a") + link("b") + joint("screw", "a", "b", "<axis><xyz>1 0 0</xyz></axis>"))
    assert refused(folder, text) == ["SC431"]
    found, made = imported(folder, text, allow=["screw-joints"])
    assert found["entities"]["m"]["root"]["children"][0]["joint"]["type"] == "continuous"
    assert [loss.kind for loss in made.losses] == ["screw-joints"]


def test_double_hyphens_in_comments_are_accepted(folder: Path) -> None:
    """Gazebo reads them, and libxml2 would end the document at `--->`."""
    text = world(f'<!-- a -- b --><model name="m"><!-- the link --->{link("a")}</model>')
    found, made = imported(folder, text)
    assert list(found["entities"]) == ["m"]
    assert made.losses == ()


@pytest.mark.parametrize("damage", [" & ", "</visual>", '<pose x="1" x="2"/>'])
def test_malformed_xml_is_read_only_if_allowed(folder: Path, damage: str) -> None:
    text = world(f'<model name="m">{link("a")}</model>{damage}')
    assert refused(folder, text) == ["SC450"]
    found, made = imported(folder, text, allow=["malformed-xml"])
    assert list(found["entities"]) == ["m"]
    assert [loss.kind for loss in made.losses] == ["malformed-xml"]


@pytest.mark.parametrize("allow", [(), ("malformed-xml",)])
def test_a_truncated_file_is_refused(folder: Path, allow: tuple[str, ...]) -> None:
    whole = world("".join(f'<model name="m{number}">{link("a")}</model>' for number in range(3)))
    for text in (whole[: len(whole) // 2], whole[: whole.index("</world>")], "<sdf", "<sdf><!-- </sdf>"):
        assert refused(folder, text, allow=allow) == ["SC450"]


BOMB = '<?xml version="1.0"?><!DOCTYPE sdf [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><sdf version="1.9">&b;</sdf>'


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("hello", "SC430"),
        ("<robot name='r'/>", "SC430"),
        (BOMB, "SC451"),
        (BOMB.replace("<sdf", "<!-- -- --><sdf"), "SC451"),
        ("<sdf version='1.9'>" + "<model name='m'>" * 200, "SC452"),
        (world("<include><uri>https://fuel.gazebosim.org/x</uri></include>"), "SC431"),
        (world("<include><uri>file:///etc/passwd.sdf</uri></include>"), "SC431"),
        (world("<include><uri>world.sdf</uri></include>"), "SC433"),
        (model(link("a", "1 2 3")), "SC433"),
        (model(link("a", "nan 0 0 0 0 0")), "SC433"),
        (model(link("a") + link("a")), "SC433"),
        (model(link("a") + joint("revolute", "a", "b")), "SC433"),
        (model(link("a") + link("b", frame='relative_to="b"')), "SC433"),
        (model(link("a") + joint("revolute", "a", "a")), "SC433"),
        (model(link("a", mass=-1)), "SC431"),
        (model(link("a").replace("<size>0.2", "<size>-0.2")), "SC431"),
        (model(link("a").replace("box><size>0.2 0.4 0.6</size></box", "mesh><uri>../../x.obj</uri></mesh")), "SC431"),
    ],
)
def test_bad_input_is_an_error_with_a_place_and_nothing_is_written(folder: Path, text: str, code: str) -> None:
    assert code in refused(folder, text)


def test_an_asset_above_the_size_limit_is_an_error(folder: Path) -> None:
    (folder / "in/a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n" * 9)
    mesh = "<geometry><mesh><uri>a.obj</uri></mesh></geometry>"
    text = model(link("a").replace("<geometry><box><size>0.2 0.4 0.6</size></box></geometry>", mesh))
    (folder / "in/world.sdf").write_text(text)
    with pytest.raises(SceneError):
        import_scene(folder / "in/world.sdf", folder / "out/scene.yaml", limits={"asset_bytes": 100})
    assert not list((folder / "out").iterdir())


def test_an_unknown_loss_is_a_value_error(folder: Path) -> None:
    with pytest.raises(ValueError, match="there is no loss `x`"):
        imported(folder, model(link("a")), allow=["x"])


@pytest.mark.parametrize(
    "text",
    [
        model(
            "".join(link(f"a{i}") for i in range(600))
            + "".join(joint("fixed", f"a{i}", f"a{i + 1}", name=f"j{i}") for i in range(599))
        ),
        model(
            link("a")
            + "".join(f'<frame name="f{i}" attached_to="f{i + 1}"/>' for i in range(4000))
            + link("b", frame='relative_to="f0"')
        ),
    ],
    ids=["links", "frames"],
)
def test_a_long_chain_of_frames_is_an_error(folder: Path, text: str) -> None:
    assert "SC433" in refused(folder, text)


def test_a_mesh_with_missing_materials_is_imported_without_them(folder: Path) -> None:
    (folder / "in/a.obj").write_text(
        "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    )
    visual = "<visual name='v'><geometry><mesh><uri>a.obj</uri></mesh></geometry></visual></link>"
    found, made = imported(folder, model(link("a").replace("</link>", visual)))
    assert found["entities"]["m"]["visuals"][0]["file"] == "scene_assets/a.obj"
    assert [loss.kind for loss in made.losses] == ["mesh-looks"]


def test_a_mesh_that_cannot_be_read_is_a_loss(folder: Path) -> None:
    (folder / "in/a.stl").write_text("hello")
    mesh = "<geometry><mesh><uri>a.stl</uri></mesh></geometry>"
    text = model(link("a").replace("<geometry><box><size>0.2 0.4 0.6</size></box></geometry>", mesh))
    assert refused(folder, text) == ["SC431"]
    assert imported(folder, text, allow=["colliders"])[1].losses[0].kind == "colliders"


def test_a_joint_between_models_becomes_a_constraint(folder: Path) -> None:
    models = "".join(
        f'<model name="{name}"><pose>0 0 {z} 0 0 0</pose>{link("l")}</model>' for name, z in (("a", 0), ("b", 1))
    )
    found, _ = imported(folder, world(models + joint("ball", "a::l", "b::l")))
    assert found["constraints"]["j"] == {"type": "ball", "parent": "a", "child": "b", "pose_in_parent": [0, 0, 1]}


LOOP = "".join(link(name, f"{x} 0 0 0 0 0") for x, name in enumerate("abc")) + "".join(
    joint("revolute", pair[0], pair[1], "<axis><xyz>0 1 0</xyz></axis>", name=pair) for pair in ("ab", "bc")
)


@pytest.mark.parametrize(
    ("kind", "axis", "expected"),
    [
        (
            "revolute",
            "<limit><lower>-1</lower><upper>9</upper></limit><dynamics><damping>3</damping></dynamics>",
            {"type": "hinge", "limits": [-1, math.inf], "drive": {"damping": 3}},
        ),
        (
            "prismatic",
            "<dynamics><spring_stiffness>3</spring_stiffness><spring_reference>1</spring_reference></dynamics>",
            {"type": "slider", "drive": {"stiffness": 3, "target": 1}},
        ),
    ],
)
def test_a_joint_that_closes_a_loop_keeps_its_limits_and_its_drive(
    folder: Path, kind: str, axis: str, expected: dict[str, Any]
) -> None:
    found, _ = imported(folder, model(LOOP + joint(kind, "a", "c", f"<axis><xyz>1 0 0</xyz>{axis}</axis>")))
    ends = {"parent": "m/a", "child": "m/c", "pose_in_parent": [2, 0, 0]}
    assert found["constraints"]["j"] == {**ends, **expected}


@pytest.mark.parametrize(
    ("axis", "losses", "drive"),
    [
        ("<limit><velocity>2</velocity></limit>", ["joint-limits"], None),
        ("<mimic joint='ab'><multiplier>2</multiplier></mimic>", ["joint-couplings"], None),
        ("<dynamics><friction>5</friction><damping>0.1</damping></dynamics>", ["joint-friction"], {"damping": 0.1}),
    ],
)
def test_what_a_constraint_cannot_hold_of_a_joint_that_closes_a_loop_is_a_loss(
    folder: Path, axis: str, losses: list[str], drive: dict[str, float] | None
) -> None:
    text = model(LOOP + joint("revolute", "a", "c", f"<axis><xyz>1 0 0</xyz>{axis}</axis>"))
    found, made = imported(folder, text, allow="all")
    assert [loss.kind for loss in made.losses] == losses
    assert found["constraints"]["j"].get("drive") == drive


def test_a_joint_whose_child_does_not_move_is_turned_round(folder: Path) -> None:
    """Its position is the child's relative to the parent, so its axis is opposite."""
    fixed = f'<model name="s"><static>1</static>{link("l")}</model><model name="b">{link("l", "0 0 1 0 0 0")}</model>'
    axis = "<axis><xyz>1 0 0</xyz><limit><lower>-0.1</lower><upper>0.3</upper></limit></axis>"
    found, _ = imported(folder, world(fixed + joint("prismatic", "b::l", "s::l", axis)))
    made = found["constraints"]["j"]
    assert (made["parent"], made["child"], made["limits"]) == ("s", "b", [-0.1, 0.3])
    assert (made["axis"], made["pose_in_parent"], made["pose_in_child"]) == ([-1, 0, 0], [0, 0, 0], [0, 0, -1])


def test_a_joint_may_mimic_only_a_joint_that_moves(folder: Path) -> None:
    parts = link("a") + link("b") + link("c") + joint("fixed", "a", "b", name="still")
    parts += joint("revolute", "a", "c", "<axis><mimic joint='still'/></axis>", name="k")
    assert refused(folder, model(parts)) == ["SC433"]
    mimic = "<mimic joint='k'><multiplier>2</multiplier><offset>0.1</offset><reference>0.2</reference></mimic>"
    parts = link("a") + link("b") + link("c") + joint("revolute", "a", "b", f"<axis>{mimic}</axis>")
    found, _ = imported(folder, model(parts + joint("revolute", "a", "c", "<axis/>", name="k")))
    mimicking = found["entities"]["m"]["root"]["children"][0]["joint"]
    assert mimicking["mimic"] == {"joint": "k", "multiplier": 2, "offset": pytest.approx(-0.3)}


def test_bodies_of_one_model_share_a_group_that_ignores_itself(folder: Path) -> None:
    found, _ = imported(folder, model(link("a") + link("b", "1 0 0 0 0 0")))
    assert found["collision_groups"] == {"m": {"ignore": ["m"]}}
    found, _ = imported(folder, model("<self_collide>1</self_collide>" + link("a") + link("b", "1 0 0 0 0 0")))
    assert "collision_groups" not in found


def test_the_sides_of_a_plane_are_those_of_its_size(folder: Path) -> None:
    plane = "<visual name='v'><geometry><plane><size>4 2</size></plane></geometry></visual>"
    found, _ = imported(folder, model(f"<static>1</static><link name='l'>{plane}</link>"))
    assert found["entities"]["m"]["visuals"] == [{"type": "plane", "half_size": [1, 2]}]  # along the world's y and x


def test_densities_of_single_shapes_move_the_centre_of_mass(folder: Path) -> None:
    boxes = "".join(
        f"<collision name='{x}'><pose>{x} 0 0 0 0 0</pose>{density}<geometry><box/></geometry></collision>"
        for x, density in ((0, "<density>300</density>"), (2, ""))
    )
    auto = '<inertial auto="true"><density>100</density></inertial>'
    imported(folder, model(f"<link name='a'>{auto}{boxes}</link>"))
    with open_scene(folder / "out/scene.yaml").build(render=False) as batch:
        body: Any = batch.entities["m"].objs[0].components[0]
        assert body.mass == pytest.approx(400)
        assert body.cmass_local_pose.p[0] == pytest.approx(0.5)


def test_a_moment_above_the_sum_of_the_others_is_lowered(folder: Path) -> None:
    text = model(link("a").replace("<izz>0.1", "<izz>0.5"))
    assert refused_losses(folder, text) == ["inertias"]
    found, _ = imported(folder, text, allow=["inertias"])
    assert found["entities"]["m"]["inertial"]["inertia"] == [0.1, 0.1, 0.2]


def test_a_world_of_which_nothing_is_left_is_a_scene(folder: Path) -> None:
    found, made = imported(folder, world("<include><uri>model://gone</uri></include>"), allow=["models"])
    assert "entities" not in found
    assert [loss.kind for loss in made.losses] == ["models"]


def test_mutated_files_are_imported_or_refused(folder: Path) -> None:
    """Nothing else is raised, whatever stands in place of a word."""
    from random import Random

    from scenecc.importers.imported_scene import LOSSES

    random = Random(1)
    axis = "<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>2</upper></limit></axis>"
    shape = "<visual name='v'><geometry><cylinder><radius>0.1</radius><length>1</length></cylinder></geometry></visual>"
    parts = link("a") + link("b", "0 0 1 0 0 0").replace("</link>", f"{shape}</link>")
    text = model(f"{parts}{joint('revolute', 'a', 'b', axis)}<frame name='f' attached_to='a'/>")
    words = [match.span() for match in re.finditer(r"<[^>]*>|[^<>\s]+", text)]
    others = ["0", "-1", "nan", "inf", "1e400", "1e-300", "true", "world", "__model__", "", "é", "a::b", "1 2 3", "<x>"]
    built, codes = 0, set[str]()
    for _ in range(80):
        start, end = random.choice(words)
        try:
            imported(folder, f"{text[:start]}{random.choice(others)}{text[end:]}", allow=list(LOSSES))
            built += 1
        except SceneError as error:
            codes |= {each.code for each in error.diagnostics}
    assert 10 < built < 70
    assert {code[2] for code in codes} <= set("1345"), codes


MANY_BOXES = "".join(
    f'<collision name="c{i}"><pose>{i} {i * i} 0 0 0 0</pose><geometry><box><size>1 1 {i + 1}</size></box></geometry>'
    "<surface><friction><ode><mu>0.5</mu></ode></friction></surface></collision>"
    for i in range(24)
)


def test_a_long_comment_may_precede_the_root_element(folder: Path) -> None:
    text = f"<!-- <mujoco> {'-' * 70000}\n -->" + model(link("a")).partition("\n")[2]
    assert list(imported(folder, text)[0]["entities"]) == ["m"]


@pytest.mark.parametrize(
    ("drake", "words"),
    [
        (
            "raise RuntimeError('w.sdf:3: error: no such joint\\nand more')",
            "Drake refuses the file: w.sdf:3: error: no such",
        ),
        ("import os; os.abort()", "Drake crashes on the file"),
        ("import time; time.sleep(60)", "Drake did not read the file in 0.5 s"),
    ],
)
def test_the_certificate_says_why_drake_did_not_read_the_file(
    folder: Path, monkeypatch: pytest.MonkeyPatch, drake: str, words: str
) -> None:
    (folder / "pydrake/multibody").mkdir(parents=True)
    (folder / "pydrake/__init__.py").touch()
    for name in ("__init__", "tree"):
        (folder / f"pydrake/multibody/{name}.py").touch()
    (folder / "pydrake/multibody/plant.py").write_text("class MultibodyPlant:\n    def __init__(self, **_): pass\n")
    (folder / "pydrake/multibody/parsing.py").write_text(
        f"class Parser:\n    def __init__(self, _): pass\n    def package_map(self): return self\n"
        f"    def GetPackageNames(self): return []\n    def AddModels(self, _):\n        {drake}\n"
    )
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.setattr("scenecc.importers.certificate._DRAKE_SECONDS", 0.5 if "sleep" in drake else 60)
    _, made = imported(folder, model(link("a")))
    assert made.certificate.engine == ""
    assert words in made.certificate.lines()[1]


def test_equal_models_become_instances_of_a_prefab(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compared: list[set[str]] = []

    def spy(found: ImportedScene, *rest: Any) -> Certificate:
        compared.append({*found.bodies})
        return certificate_of(found, *rest)

    monkeypatch.setattr("scenecc.importers.certificate.certificate_of", spy)
    camera = '<sensor name="eye" type="camera"><camera/></sensor>'
    models = "".join(
        f'<model name="rack_{i}"><pose>0 0 {i * 9} 0 0 {i}</pose>{link("top")[:-7]}{MANY_BOXES}{camera}</link></model>'
        for i in range(2)
    )
    found, made = imported(folder, world(models + joint("fixed", "rack_0::top", "rack_1::top", name="tie")))
    assert [path.name for path in made.paths] == ["scene.yaml", "rack.yaml"]
    use = "scene_assets/rack.yaml"
    assert found["entities"]["rack_0"] == {"use": use}
    assert found["entities"]["rack_1"]["use"] == use
    assert found["constraints"]["tie"]["child"] == "rack_1/rack"
    assert "materials" not in found
    poses = body_poses(folder)
    assert poses["rack_1/rack"][0] == pytest.approx([0, 0, 9])
    plan = open_scene(folder / "out/scene.yaml").plan
    assert [each.mount and each.mount.entity for each in plan.cameras] == ["rack_0/rack", "rack_1/rack"]
    assert compared == [{"rack_0/rack", "rack_1/rack"}]


def test_invalid_names_are_replaced_and_reported(folder: Path) -> None:
    text = model(link("a:b") + link("c") + joint("fixed", "a:b", "c", name="k l"), name="\u65e5\u672c")
    found, made = imported(folder, text)
    assert list(found["entities"]) == ["_"]
    told = [loss.message for loss in made.losses if loss.kind == "names"]
    assert told == [
        "the model `\u65e5\u672c` is renamed to `_`",
        "the link `a:b` is renamed to `a_b`",
        "the joint `k l` is renamed to `k_l`",
    ]


def racks(name: str) -> str:
    return world(
        "".join(
            f'<model name="{name}_{i}"><pose>0 0 {i * 9} 0 0 0</pose>{link("top")[:-7]}{MANY_BOXES}</link></model>'
            for i in range(2)
        )
    )


def test_files_of_another_scene_are_not_replaced(folder: Path) -> None:
    imported(folder, racks("rack"))
    out = folder / "out"
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    with pytest.raises(FileExistsError, match=r"belongs to `scene\.yaml`"):
        import_scene(folder / "in/world.sdf", out / "scene.yml")
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before
    (out / "scene.yaml").unlink()
    (out / "scene_assets/rack.yaml").write_text("mine")
    with pytest.raises(FileExistsError, match="not from an earlier import"):
        import_scene(folder / "in/world.sdf", out / "scene.yaml")
    assert (out / "scene_assets/rack.yaml").read_text() == "mine"


def test_prefabs_of_an_earlier_import_are_removed(folder: Path) -> None:
    imported(folder, racks("rack"))
    assets = folder / "out/scene_assets"
    (assets / "mine.yaml").write_text("scenecc: 1\n")
    (folder / "in/world.sdf").write_text("broken")
    with pytest.raises(SceneError):
        import_scene(folder / "in/world.sdf", folder / "out/scene.yaml")
    assert {path.name for path in assets.iterdir()} == {"mine.yaml", "rack.yaml"}
    imported(folder, racks("shelf"))
    assert {path.name for path in assets.iterdir()} == {"mine.yaml", "shelf.yaml"}


ARM = """<robot name="arm"><link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision>
<inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="tool0"><inertial>
<mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="tool0"/><origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="10" velocity="1"/></joint></robot>"""


BALL = """<robot name="ball"><link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
</robot>"""


def included(rest: str = "", name: str = "robot", file: str = "arm.urdf", **attributes: str) -> str:
    words = "".join(f' {key}="{value}"' for key, value in attributes.items())
    named = f"<name>{name}</name>" if name else ""
    return f"<include{words}>{named}<uri>{file}</uri>{rest}</include>"


FIX = joint("fixed", "world", "robot::base")


@pytest.mark.parametrize(
    ("inside", "entity", "keys"),
    [
        (included("<pose>0 0 5 0 0 0</pose>"), "robot", {"pose": [0, 0, 5], "fix_root_link": False}),
        (included(name=""), "arm", {"fix_root_link": False}),
        (included("<static>true</static>"), "robot", {"body_type": "static"}),
        (included() + FIX, "robot", {}),
        (included() + joint("fixed", "robot", "world"), "robot", {}),
        (included(file="pole.urdf"), "robot", {}),
        (
            included("<placement_frame>tool0</placement_frame><pose>0 0 5 0 0 0</pose>"),
            "robot",
            {"pose": [0, 0, 4.5], "fix_root_link": False},
        ),
        (f'<model name="m"><pose>1 0 0 0 0 0</pose>{included()}</model>', "m.robot", {"pose": [1, 0, 0]}),
        (f'<model name="m">{included()}{FIX}</model>', "m.robot", {}),
        (f'<model name="m">{included(merge="true")}</model>', "m", {"fix_root_link": False}),
        (f'<model name="m"><static>1</static>{included()}</model>', "m.robot", {"body_type": "static"}),
    ],
)
def test_the_root_of_an_included_urdf_is_free_unless_something_fixes_it(
    folder: Path, inside: str, entity: str, keys: dict[str, Any]
) -> None:
    (folder / "in/arm.urdf").write_text(ARM)
    (folder / "in/pole.urdf").write_text(ARM.replace('="base"', '="world"'))
    found, _ = imported(folder, world(inside))
    if entity == "m.robot" and "pose" in keys:
        keys = {**keys, "fix_root_link": False}
    made = found["entities"][entity]
    assert {key: value for key, value in made.items() if key != "urdf"} == keys
    assert "constraints" not in found


def test_links_of_an_included_urdf_can_be_named(folder: Path) -> None:
    (folder / "in/arm.urdf").write_text(ARM)
    tool = link("l", mass=2)
    found, made = imported(
        folder,
        world(
            included("<pose>0 0 1 0 0 0</pose>")
            + f'<model name="tool"><pose relative_to="robot::tool0">0.1 0 0 0 0 0</pose>{tool}</model>'
            + joint("fixed", "robot::tool0", "tool::l", name="mount")
            + '<frame name="f" attached_to="robot::tool0"><pose>0 0 1 0 0 0</pose></frame>'
            + included('<pose relative_to="f"/>', name="two")
            + joint("revolute", "f", "two", name="turn")
        ),
    )
    mount = {"type": "weld", "parent": "robot/tool0", "child": "tool", "pose_in_parent": [0.1, 0, 0]}
    assert found["constraints"]["mount"] == mount
    turn = found["constraints"]["turn"]
    assert (turn["parent"], turn["child"]) == ("robot/tool0", "two/base")
    assert (turn["type"], turn["axis"], turn["pose_in_parent"]) == ("hinge", "z", [0, 0, 1])
    poses = body_poses(folder)
    assert poses["tool"][0] == pytest.approx([0.1, 0, 1.5])
    assert poses["two/base"][0] == pytest.approx([0, 0, 2.5])
    assert made.losses == ()


def test_an_included_urdf_in_a_model_is_jointed_to_the_links_beside_it(folder: Path) -> None:
    (folder / "in/arm.urdf").write_text(ARM)
    inside = link("l") + included("<pose>0 0 1 0 0 0</pose>") + joint("fixed", "l", "robot::base")
    found, _ = imported(folder, model(inside, rest=""))
    assert found["entities"]["m.robot"]["fix_root_link"] is False
    expected = {"type": "weld", "parent": "m", "child": "m.robot/base", "pose_in_parent": [0, 0, 1]}
    assert found["constraints"]["j"] == expected


def test_an_included_urdf_of_one_link_is_free_or_welded(folder: Path) -> None:
    (folder / "in/ball.urdf").write_text(BALL)
    found, _ = imported(folder, world(included(file="ball.urdf")))
    assert found["entities"]["robot"]["fix_root_link"] is False
    found, _ = imported(folder, world(included("<static>1</static><pose>0 0 1 0 0 0</pose>", file="ball.urdf")))
    assert found["entities"]["robot"] == {"urdf": "scene_assets/ball.urdf", "body_type": "static", "pose": [0, 0, 1]}


def test_a_static_urdf_is_one_body_to_which_joints_hold_others_in_the_world(folder: Path) -> None:
    (folder / "in/arm.urdf").write_text(ARM)
    static = included("<static>1</static><pose>0 0 1 0 0 0</pose>")
    hung = f'<model name="tool"><pose>1 0 1.5 0 0 0</pose>{link("l", mass=2)}</model>'
    held = joint("fixed", "robot::tool0", "tool::l", name="mount")
    found, made = imported(folder, world(static + hung + held))
    mount = {"type": "weld", "parent": "world", "child": "tool", "pose_in_parent": [1, 0, 1.5]}
    assert found["constraints"]["mount"] == mount
    assert set(body_poses(folder)) == {"robot", "tool"}
    assert made.losses == ()
    (folder / "in/arm.urdf").write_text(ARM.replace("collision>", "sensor>"))
    found, made = imported(folder, world(static + hung + held))
    assert [*found["entities"]] == ["tool"]
    assert [loss.kind for loss in made.losses] == ["empty-links"]


def test_a_broken_included_urdf_is_an_error_at_its_line_and_a_repaired_one_a_loss(folder: Path) -> None:
    (folder / "in/arm.urdf").write_text(ARM.replace('<child link="tool0"/>', '<child link="tool9"/>'))
    with pytest.raises(SceneError) as caught:
        imported(folder, world(included()))
    assert {Path(each.file or "").name for each in caught.value.diagnostics} == {"arm.urdf"}
    (folder / "in/arm.urdf").write_text(ARM.replace('<limit lower="-1" upper="1" effort="10" velocity="1"/>', ""))
    assert refused_losses(folder, world(included())) == ["joint-limits"]
    found, _ = imported(folder, world(included()), allow="joint-limits")
    assert found["entities"]["robot"]["repair"] == ["limits"]


def refused_losses(folder: Path, text: str) -> list[str]:
    with pytest.raises(SceneError) as caught:
        imported(folder, text)
    hints = [each.hint or "" for each in caught.value.diagnostics if each.code == "SC431"]
    return [hint.rpartition(" ")[2] for hint in hints]


def test_a_certificate_names_what_was_not_compared() -> None:
    assert Certificate(2, 1.0, "Drake").lines()[1].startswith("compared with Drake: nothing: none of the bodies has")
    assert Certificate(0, 0.0, "Drake").lines()[1] == "compared with Drake: nothing: no body is built"
    partly = Certificate(6, 1.0, "Drake", compared=1, not_compared=tuple("abcde"))
    assert partly.lines()[1] == "compared with Drake: 1 body; not compared: `a`, `b`, `c` and 2 more"


@pytest.mark.parametrize(
    ("dynamics", "expected", "lost"),
    [
        ("<friction>5</friction>", {"friction_force": 5}, []),
        ("<friction>5</friction><damping>0.1</damping>", {"friction_force": 5}, ["the damping 0.1 of `j`"]),
        ("<friction>5</friction><damping>2</damping>", {"damping": 2}, ["the friction 5 of `j`"]),
        ("<friction>5</friction><spring_stiffness>2</spring_stiffness>", {}, ["the friction 5 of `j`"]),
    ],
)
def test_the_friction_of_a_joint_is_a_force(
    folder: Path, dynamics: str, expected: dict[str, Any], lost: list[str]
) -> None:
    axis = f"<axis><xyz>0 0 1</xyz><dynamics>{dynamics}</dynamics></axis>"
    parts = link("base") + link("arm", "0 0 1 0 0 0") + joint("revolute", "base", "arm", axis)
    found, made = imported(folder, model(parts))
    (arm,) = found["entities"]["m"]["root"]["children"]
    assert {key: arm["joint"][key] for key in ("friction_force", "damping") if key in arm["joint"]} == expected
    assert [loss.message[: len(each)] for loss, each in zip(made.losses, lost, strict=True)] == lost


def test_a_plugin_of_an_include_is_lost(folder: Path) -> None:
    (folder / "in/arm.urdf").write_text(ARM)
    plugin = '<plugin filename="libdrive.so" name="drive"/>'
    _, made = imported(folder, world(f"<include><uri>arm.urdf</uri>{plugin}</include>"))
    assert [loss.kind for loss in made.losses] == ["plugins"]
