"""Drake's model directives as scenes: models are where Drake puts them, and what is wrong is told at its place."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from scenecc import SceneError
from scenecc.diagnostics import Sink
from scenecc.importers.dmd import import_dmd
from scenecc.importers.import_scene import Imported, import_scene
from scenecc.importers.imported_scene import ImportContext, ImportedScene
from scenecc.source import Limits, read_file
from scenecc.source.paths import AssetScope

INERTIAL = """<inertial><mass value="{mass}"/>
  <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>"""
URDF = f"""<robot name="box"><link name="base">{INERTIAL.format(mass=2)}</link>
<link name="arm">{INERTIAL.format(mass=1)}</link>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
  <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<frame name="tip" link="arm" xyz="0 0 0.3" rpy="0 0 0"/></robot>"""
BALL = """<sdf version="1.9"><model name="ball"><link name="b"><inertial><mass>0.5</mass></inertial>
  <collision name="c"><geometry><sphere><radius>0.05</radius></sphere></geometry></collision></link>
  <frame name="top" attached_to="b"><pose>0 0 0.05 0 0 0</pose></frame></model></sdf>"""
BOX = """<collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision></link>"""
ARM = f"""<sdf version="1.9"><model name="arm"><pose>0 0 0.1 0 0 0</pose>
<link name="l0"><inertial><mass>2</mass></inertial>{BOX}
<link name="l1"><pose>0.1 0 0.4 0 0 0.5</pose><inertial><mass>1</mass></inertial>{BOX}
<joint name="j0" type="revolute"><parent>l0</parent><child>l1</child>
  <axis><xyz>0 1 0</xyz><limit><lower>-2</lower><upper>2</upper></limit></axis></joint>
<frame name="ee" attached_to="l1"><pose>0 0 0.3 0 0.7 0</pose></frame></model></sdf>"""
INNER = """
- add_model: {name: tool, file: ball.sdf}
- add_frame: {name: mount, X_PF: {base_frame: tool::b, translation: [0.5, 0, 0]}}
- add_model: {name: tip, file: ball.sdf}
- add_weld: {parent: tool::mount, child: tip::top}
"""
ALL = """
- add_model: {name: one, file: a.urdf, default_joint_positions: {j: [0.6]}}
- add_frame:
    name: base_on_world
    X_PF: {base_frame: world, translation: [1, 0, 0.5], rotation: !Rpy {deg: [10, 20, 30]}}
- add_weld: {parent: base_on_world, child: one::base}
- add_model: {name: two, file: a.urdf, default_joint_positions: {j: [-0.4]}}
- add_weld:
    parent: one::tip
    child: two::base
    X_PC: {translation: [0, 0, 0.1], rotation: !AngleAxis {angle_deg: 45, axis: [1, 0, 1]}}
- add_model: {name: arm, file: arm.sdf, default_joint_positions: {j0: [1.1]}}
- add_weld: {parent: two::tip, child: arm::l0}
- add_model: {name: b, file: ball.sdf}
- add_weld: {parent: arm::ee, child: b::top, X_PC: {translation: [0, 0, 0.1]}}
- add_model:
    name: free
    file: ball.sdf
    default_free_body_pose: {top: {base_frame: arm::ee, translation: [1, 1, 1]}}
- add_model_instance: {name: left}
- add_directives: {file: inner.dmd.yaml, model_namespace: left}
- add_weld: {parent: world, child: left::tip::b, X_PC: {translation: [3, 3, 3]}}
- add_model: {name: backwards, file: arm.sdf}
- add_weld: {parent: world, child: backwards::ee, X_PC: {translation: [0, -2, 1]}}
"""
POSES = {
    "one/base": (1.0, 0.0, 0.5, 0.95155, 0.03813, 0.18931, 0.2393),
    "one/arm": (1.15141, 0.00721, 0.87017, 0.8531, -0.03429, 0.46205, 0.23988),
    "one/two/base": (1.46017, 0.11928, 1.09843, 0.73253, 0.3242, 0.50107, 0.32744),
    "one/two/arm": (1.83874, 0.06055, 1.21349, 0.81748, 0.38279, 0.34555, 0.2565),
    "arm/l0": (2.06714, -0.07403, 1.35392, 0.81748, 0.38279, 0.34555, 0.2565),
    "arm/l1": (2.43464, -0.18507, 1.50432, 0.49565, 0.15346, 0.58553, 0.62284),
    "b": (2.68076, 0.03586, 1.58216, 0.26483, -0.06941, 0.71999, 0.6377),
    "free": (1.65648, 1.31024, 1.95204, 0.26483, -0.06941, 0.71999, 0.6377),
    "left.tool": (2.5, 3.0, 3.05, 1.0, 0.0, 0.0, 0.0),
    "left.tip": (3.0, 3.0, 3.0, 1.0, 0.0, 0.0, 0.0),
    "backwards/l0": (0.38383, -1.95206, 0.40808, 0.91017, 0.08483, -0.33224, -0.2324),
    "backwards/l1": (0.19327, -2.0, 0.77055, 0.93937, 0.0, -0.3429, 0.0),
}
"""Poses of the bodies of `ALL` according to Drake 1.51.1: p [m], then q (wxyz)."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    files = {"a.urdf": URDF, "ball.sdf": BALL, "arm.sdf": ARM, "inner.dmd.yaml": f"directives:{INNER}"}
    (tmp_path / "in").mkdir()
    for name, text in files.items():
        (tmp_path / "in" / name).write_text(text)
    return tmp_path


def read(folder: Path, text: str, name: str = "w.dmd.yaml") -> tuple[ImportedScene | None, Sink]:
    """What the reader makes of directives; nothing is built."""
    path = folder / "in" / name
    path.write_text(f"directives:{text}" if text.startswith("\n") else text)
    sink = Sink()
    return import_dmd(path, ImportContext(sink, AssetScope(path.parent), Limits())), sink


def entities(folder: Path, text: str) -> dict[str, Any]:
    found, sink = read(folder, text)
    assert found is not None, sink.diagnostics()
    return found.document["entities"]


def imported(folder: Path, text: str) -> tuple[dict[str, Any], Imported]:
    (folder / "in/w.dmd.yaml").write_text(f"directives:{text}")
    made = import_scene(folder / "in/w.dmd.yaml", folder / "scene.yaml")
    found = read_file(str(folder / "scene.yaml"), Sink(), Limits())
    assert found is not None
    return found.data, made


def test_a_urdf_that_is_welded_to_the_world_is_fixed(folder: Path) -> None:
    found, made = imported(
        folder,
        """
- add_model: {name: a, file: a.urdf}
- add_weld: {parent: world, child: a::base, X_PC: {translation: [1, 2, 3], rotation: !Rpy {deg: [0, 0, 90]}}}
""",
    )
    entity = found["entities"]["a"]
    assert entity["urdf"].endswith("a.urdf")
    assert entity["pose"] == {"p": [1, 2, 3], "rpy_deg": [0, 0, 90]}
    assert "fix_root_link" not in entity
    assert made.losses == ()


def test_bodies_are_where_drake_puts_them(folder: Path) -> None:
    from scenecc import open_scene
    from scenecc.backends.sapien.measure import measure_bodies

    found, _ = imported(folder, ALL)
    built = {}
    with open_scene(folder / "scene.yaml").build(render=False) as batch:
        for entity in measure_bodies(batch).scenes[0].entities:
            for body in entity.bodies:
                name = entity.entity.name
                built[f"{name}/{body.name}" if len(entity.bodies) > 1 else name] = body.pose
    assert {name: pytest.approx(pose, abs=2e-5) for name, pose in POSES.items()} == built
    kinds = {name: row["type"] for name, row in found["constraints"].items()}
    assert set(kinds.values()) == {"weld"}
    assert len(kinds) == 3
    assert found["entities"]["one"]["attach"]["two"]["to"] == "arm"


def test_a_model_that_nothing_holds_is_free(folder: Path) -> None:
    found = entities(folder, "\n- add_model: {name: a, file: a.urdf}\n- add_model: {name: b, file: ball.sdf}\n")
    assert found["a"]["fix_root_link"] is False
    assert "body_type" not in found["b"]


def test_a_package_above_the_file_is_found_by_its_name(folder: Path) -> None:
    (folder / "in/package.xml").write_text("<package><name>things</name></package>")
    found = entities(folder, "\n- add_model: {name: a, file: 'package://things/a.urdf'}\n")
    assert found["a"]["urdf"].source == folder / "in/a.urdf"


def test_an_mjcf_stays_a_file(folder: Path) -> None:
    pytest.importorskip("mujoco")
    body = '<body name="arm" pos="0 0 0.3"><joint name="h"/><geom size="0.1"/></body>'
    world = (
        f'<worldbody><light/><body name="base" pos="0 0 0.5"><freejoint/><geom size="0.1"/>{body}</body></worldbody>'
    )
    option, equality = '<option cone="elliptic"/>', '<equality><connect body1="arm" anchor="0 0 0"/></equality>'
    (folder / "in/m.xml").write_text(f"<mujoco>{option}{world}{equality}</mujoco>")
    text = "\n- add_model: {name: m, file: m.xml}\n- add_weld: {parent: world, child: m::base}\n"
    found, _ = read(folder, text)
    assert found is not None
    assert [(loss.kind, loss.message) for loss in found.losses] == [
        ("settings", "time step, gravity and solver belong under `physics` of the scene"),
        ("lights", "lights belong to the scene: declare them under `lights`"),
        ("loops", found.losses[2].message),
        ("settings", "`cone` of <option>"),
    ]
    entity = found.document["entities"]["m"]
    assert entity["fix_root_link"] is True
    assert entity["pose"] == [0, 0, -0.5]
    assert found.bodies == {"m/base": "m::base", "m/arm": "m::arm"}


def test_a_mesh_is_a_body_of_water(folder: Path) -> None:
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = ["1 2 4", "1 4 3", "5 7 8", "5 8 6", "1 5 6", "1 6 2", "3 4 8", "3 8 7", "1 3 7", "1 7 5", "2 6 8", "2 8 4"]
    lines = [*(f"v {x} {y} {z}" for x, y, z in corners), *(f"f {each}" for each in faces)]
    (folder / "in/cube.obj").write_text("\n".join(lines))
    found = entities(folder, "\n- add_model: {name: m, file: cube.obj}\n")
    assert found["m"]["mass"] == pytest.approx(1000)
    assert found["m"]["shapes"][0]["type"] == "convex_mesh"


def test_groups_that_ignore_one_another_do_not_collide(folder: Path) -> None:
    found, _ = read(
        folder,
        """
- add_model: {name: a, file: ball.sdf}
- add_model: {name: b, file: ball.sdf}
- add_collision_filter_group: {name: g, members: [a::b, b::b], ignored_collision_filter_groups: [g]}
""",
    )
    assert found is not None
    assert found.losses == ()
    assert {"collision_group", "collision_bits"} & set(found.document["entities"]["a"])


def test_shapes_of_a_file_cannot_be_separated(folder: Path) -> None:
    found, _ = read(
        folder,
        """
- add_model: {name: a, file: a.urdf}
- add_collision_filter_group: {name: g, members: [a::base, a::arm], ignored_collision_filter_groups: [g]}
""",
    )
    assert found is not None
    assert [loss.kind for loss in found.losses] == ["collision-filters"]


def test_a_missing_model_is_a_loss_and_so_is_its_weld(folder: Path) -> None:
    found, _ = read(folder, "\n- add_model: {name: a, file: no.sdf}\n- add_weld: {parent: world, child: a::b}\n")
    assert found is not None
    assert [loss.kind for loss in found.losses] == ["models", "joints"]


def test_what_depends_on_a_missing_file_is_a_loss(folder: Path) -> None:
    found, _ = read(
        folder,
        """
- add_model: {name: a, file: no.sdf}
- add_model: {name: b, file: ball.sdf}
- add_frame: {name: f, X_PF: {base_frame: a::b}}
- add_weld: {parent: f, child: b::b}
- add_directives: {file: no.dmd.yaml, model_namespace: k}
- add_weld: {parent: k::frame, child: b::b}
- add_collision_filter_group: {name: g, members: [a::b, b::b], ignored_collision_filter_groups: [g]}
""",
    )
    assert found is not None
    assert [loss.kind for loss in found.losses] == ["models", "joints", "joints", "models", "joints", "joints"]
    assert [*found.document["entities"]] == ["b"]


def test_all_faults_are_told_at_once_with_the_nearest_name(folder: Path) -> None:
    (folder / "in/w.dmd.yaml").write_text(
        """directives:
- add_model: {name: a, file: bal.sdf}
- add_model: {name: b, file: ball.sdf}
- add_weld: {parent: word, child: b::tpo}
- add_frame: {name: f, X_PF: {base_frame: c::x}}
- add_weld: {parent: b::b, child: bb::top}
"""
    )
    with pytest.raises(SceneError) as caught:
        import_scene(folder / "in/w.dmd.yaml", folder / "scene.yaml")
    found = [(one.code, one.location.line, one.hint) for one in caught.value.diagnostics]
    assert found == [
        ("SC431", 2, "allow it with --allow models"),
        ("SC433", 4, "did you mean `world`?"),
        ("SC433", 4, "did you mean `top`?"),
        ("SC433", 5, "known here: world, b::b, b::top"),
        ("SC433", 6, "did you mean `b::top`?"),
    ]
    assert "did you mean" in caught.value.diagnostics[0].message


@pytest.mark.parametrize("xyz", ["0 0", "0 0 up", "0 0 1e9"])
def test_an_invalid_frame_of_a_urdf_is_unknown(folder: Path, xyz: str) -> None:
    file = folder / "in/a.urdf"
    file.write_text(file.read_text().replace('xyz="0 0 0.3"', f'xyz="{xyz}"'))
    with pytest.raises(SceneError, match=r"SC433.*tip"):
        imported(folder, "\n- add_model: {name: a, file: a.urdf}\n- add_weld: {parent: world, child: a::tip}\n")


def test_a_position_beyond_the_limits_is_a_loss(folder: Path) -> None:
    found, _ = read(folder, "\n- add_model: {name: a, file: a.urdf, default_joint_positions: {j: [2]}}\n")
    assert found is not None
    assert [loss.kind for loss in found.losses] == ["joint-positions"]
    assert found.document["entities"]["a"]["qpos"] == {"j": 1}


MODEL = "\n- add_model: {name: a, file: a.urdf}\n- "


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (f"{MODEL}add_weld: {{parent: world, child: a::bas}}", 3, "no frame `bas`"),
        (f"{MODEL}add_weld: {{parent: world, child: c::base}}", 3, "no frame `c::base`"),
        (f"{MODEL}add_weld: {{parent: world}}", 3, "needs the key `child`"),
        (f"{MODEL}add_weld: {{parent: world, child: a::base, X_PC: {{translation: [1, 2]}}}}", 3, "3 numbers"),
        (f"{MODEL}add_weld: {{parent: world, child: a::base, X_PC: {{rotation: [1, 2, 3]}}}}", 3, "mapping"),
        (f"{MODEL}add_frame: {{name: f, X_PF: {{translation: [1, 2, 3]}}}}", 3, "base_frame"),
        (f"{MODEL}add_frame: {{name: f, X_PF: {{base_frame: world, translation: !Uniform {{}}}}}}", 3, "random"),
        (f"{MODEL}add_frame: {{name: f, X_PF: {{base_frame: world, rotation: !Uniform {{}}}}}}", 3, "random"),
        (f"{MODEL}add_frame: {{name: f, X_PF: {{base_frame: world, rotation: !Euler {{}}}}}}", 3, "`!Euler`"),
        (f"{MODEL}add_model: {{name: a, file: a.urdf}}", 3, "a second model"),
        (f"{MODEL}add_modell: {{name: b, file: a.urdf}}", 3, "no key `add_modell`"),
        (f"{MODEL}add_weld: [world, a::base]", 3, "must be a mapping"),
        (f"{MODEL}add_directives: {{file: w.dmd.yaml}}", 3, "adds itself"),
        ("\n- add_model: {name: a, file: a.urdf, default_joint_positions: {k: [1]}}", 2, "no joint `k`"),
        ("\n- add_model: {name: a, file: a.urdf, default_joint_positions: {j: 1}}", 2, "must be a list"),
        (f"{MODEL}add_weld: {{parent: a::arm, child: a::base}}", 3, "to itself"),
        ("directives: 3", 1, "must be a list"),
        ("a: 3", 1, "no key `a`"),
        ("directives:\n- &x [*x]", 2, "must be a mapping"),
    ],
)
def test_a_fault_is_told_at_its_line(text: str, line: int, words: str, folder: Path) -> None:
    _, sink = read(folder, text)
    (fault,) = sink.diagnostics()
    assert fault.severity == "error"
    assert fault.location.line == line
    assert fault.location.column
    assert words in fault.message


def test_a_second_weld_of_a_fixed_model_is_refused(folder: Path) -> None:
    text = f"{MODEL}add_weld: {{parent: world, child: a::base}}\n- add_weld: {{parent: world, child: a::arm}}\n"
    _, sink = read(folder, text)
    assert [fault.location.line for fault in sink.diagnostics()] == [4]


def test_deep_and_endless_files_are_refused(folder: Path) -> None:
    bomb = "directives: &a [" + "x, " * 9 + "]\n"
    for text in ("directives: " + "[" * 3000, "directives: \0", bomb, ""):
        _, sink = read(folder, text)
        assert sink.failed


@pytest.mark.parametrize(
    ("kind", "axes", "row", "expected"),
    [
        ("ball", "", "[0.1, 0.2, 0.3]", (0.03788, 0.220124, 0.285772)),
        ("universal", "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>", "[0.1, 0.2]", (0.1, 0.2)),
    ],
)
def test_positions_of_joints_of_several_axes(
    folder: Path, kind: str, axes: str, row: str, expected: tuple[float, ...]
) -> None:
    """Drake's positions of a ball joint are roll, pitch and yaw, which is the rotation of the hinges."""
    bodies = "".join(f"<link name='{name}'><inertial><mass>1</mass></inertial></link>" for name in "ab")
    joint = f"<joint name='j' type='{kind}'><parent>a</parent><child>b</child>{axes}</joint>"
    (folder / "in" / "m.sdf").write_text(f"<sdf version='1.9'><model name='m'>{bodies}{joint}</model></sdf>")
    text = f"\n- add_model: {{name: m, file: m.sdf, default_joint_positions: {{j: {row}}}}}\n"
    found, sink = read(folder, text)
    assert found is not None, sink.diagnostics()
    (robot,) = found.document["entities"].values()
    assert tuple(robot["qpos"].values()) == pytest.approx(expected, abs=1e-6)
    _, sink = read(folder, text.replace("]}}", ", 1, 1]}}"))
    assert "positions" in str(sink.diagnostics())
