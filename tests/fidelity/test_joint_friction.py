"""Friction of a joint that a file gives as a force: it holds and slows a joint as Coulomb friction, as in MuJoCo."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenecc
from scenecc.plan.articulation import BRAKE_DAMPING

MASS, MOMENT = 2.0, 0.02
TENSOR = f'<inertia ixx="{MOMENT}" iyy="{MOMENT}" izz="{MOMENT}" ixy="0" ixz="0" iyz="0"/>'
BOX = f'<inertial><mass value="{MASS}"/>{TENSOR}</inertial>'
LIMIT = {"prismatic": '<limit lower="-50" upper="50"/>', "continuous": ""}


def urdf(dynamics: str, kind: str = "prismatic", axis: str = "1 0 0") -> str:
    return f"""<robot name="r"><link name="base"/><link name="part">{BOX}</link>
      <joint name="j" type="{kind}"><parent link="base"/><child link="part"/><axis xyz="{axis}"/>{LIMIT[kind]}
        <dynamics {dynamics}/></joint></robot>"""


def mjcf(joint: str, rest: str = "", option: str = "") -> str:
    return f"""<mujoco><compiler angle="radian"/><option {option}/><worldbody><body name="base"><geom size="0.1"/>
      <body name="part"><joint name="j" {joint}/>
        <inertial pos="0 0 0" mass="{MASS}" diaginertia="{MOMENT} {MOMENT} {MOMENT}"/></body></body></worldbody>
      {rest}</mujoco>"""


def robot(batch: Any) -> Any:
    (found,) = {link.articulation for link in batch.scenes[0].physx_system.articulation_link_components}
    return found


def moved(entity: dict[str, Any], force: float, *, seconds: float = 0.5, **physics: Any) -> float:
    """How far the joint moves under a constant force [m, rad]."""
    free = {"linear_damping": 0, "angular_damping": 0, "max_linear_velocity": 1000, "max_angular_velocity": 1000}
    document = {"scenecc": 1, "physics": physics, "entities": {"r": {"links": {".*": free}, **entity}}}
    with scenecc.load_scene(document, render=False, allow_outside_assets=True) as batch:
        made = robot(batch)
        start = float(made.qpos[0])
        for _ in range(round(seconds / physics.get("timestep", 0.01))):
            made.qf = np.array([force], dtype=np.float32)
            batch.step()
        return float(made.qpos[0]) - start


def found(entity: dict[str, Any]) -> list[tuple[str, str]]:
    document = {"scenecc": 1, "entities": {"r": entity}}
    return [
        (d.code, d.message)
        for d in scenecc.validate(document, allow_outside_assets=True)
        if d.code in {"SC494", "SC495"}
    ]


@pytest.mark.parametrize("gravity", [[0, 0, -9.81], [0, 0, 0]])
@pytest.mark.parametrize("timestep", [0.01, 0.001])
@pytest.mark.parametrize(
    ("kind", "friction", "force"),
    [
        ("prismatic", 5, 4.9),
        ("prismatic", 5, -20),
        ("prismatic", 0.2, 4.9),
        ("continuous", 0.3, 0.29),
        ("continuous", 0.3, 0.5),
    ],
)
def test_a_joint_moves_as_with_coulomb_friction(
    tmp_path: Path, kind: str, friction: float, force: float, timestep: float, gravity: list[float]
) -> None:
    (tmp_path / "r.urdf").write_text(urdf(f'friction="{friction}"', kind, "0 0 1" if kind == "continuous" else "1 0 0"))
    acceleration = np.sign(force) * max(abs(force) - friction, 0) / (MASS if kind == "prismatic" else MOMENT)
    way = moved({"urdf": str(tmp_path / "r.urdf")}, force, timestep=timestep, gravity=gravity)
    assert way == pytest.approx(acceleration * 0.5**2 / 2, rel=0.03, abs=1e-5)


def test_it_holds_against_gravity_up_to_its_force(tmp_path: Path) -> None:
    weight = MASS * 9.81
    for friction, expected in ((weight + 0.1, 0.0), (weight / 2, -9.81 / 2 * 0.5**2 / 2)):
        (tmp_path / "r.xml").write_text(mjcf(f'type="slide" axis="0 0 1" frictionloss="{friction}"'))
        assert moved({"mjcf": str(tmp_path / "r.xml")}, 0) == pytest.approx(expected, rel=0.03, abs=1e-5)


def test_a_chain_swings_as_in_mujoco(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    inner = ""
    for number in reversed(range(3)):
        joint = '<joint axis="0 1 0" frictionloss="0.3" solreffriction="0.001 1" solimpfriction="0.9999 0.9999 0.001"/>'
        mass = '<inertial pos="0.1 0 0" mass="0.5" diaginertia="1e-4 1.7e-3 1.7e-3"/>'
        inner = f'<body pos="{0.2 if number else 0} 0 0">{joint}{mass}{inner}</body>'
    text = f'<mujoco><option timestep="0.001"/><worldbody><body><geom size="0.01"/>{inner}</body></worldbody></mujoco>'
    (tmp_path / "r.xml").write_text(text)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for _ in range(600):
        mujoco.mj_step(model, data)
    free = {"linear_damping": 0, "angular_damping": 0}
    entity = {"mjcf": str(tmp_path / "r.xml"), "links": {".*": free}}
    document = {"scenecc": 1, "physics": {"timestep": 0.002}, "entities": {"r": entity}}
    with scenecc.load_scene(document, render=False, allow_outside_assets=True) as batch:
        for _ in range(300):
            batch.step()
        assert robot(batch).qpos == pytest.approx(data.qpos, abs=0.02)


LOST = {
    "damping": (
        urdf('friction="5" damping="2"'),
        {},
        "SC494",
        "the friction of 5 N of `j` is not built: the joint has a damping of 2",
    ),
    "light damping": (
        urdf('friction="5" damping="0.1"'),
        {},
        "SC494",
        "the damping of 0.1 N·s/m is not built, but the friction of 5 N of",
    ),
    "drive": (
        urdf('friction="5"'),
        {"drives": {"j": {"stiffness": 9, "damping": 1}}},
        "SC495",
        "the friction of 5 N of `j`",
    ),
    "none": (urdf('friction="0" damping="2"'), {}, None, ""),
    "ratio of the scene": (urdf('friction="5" damping="2"'), {"joints": {"j": {"friction": 0.1}}}, None, ""),
    "spring": (
        mjcf('frictionloss="5" stiffness="2"'),
        {},
        "SC494",
        "the friction of 5 N·m of `j` is not built: the joint has a spring",
    ),
    "actuator": (
        mjcf('frictionloss="5"', '<actuator><position joint="j" kp="3"/></actuator>'),
        {},
        "SC494",
        "the friction of 5 N·m of `j` is not built: the joint has a spring or an actuator",
    ),
}


@pytest.mark.parametrize("case", LOST)
def test_what_cannot_be_built_is_reported_with_its_number(tmp_path: Path, case: str) -> None:
    text, keys, code, message = LOST[case]
    key = "mjcf" if text.startswith("<mujoco") else "urdf"
    (tmp_path / f"r.{key}").write_text(text)
    entity = {key: str(tmp_path / f"r.{key}"), **keys}
    reported = found(entity)
    assert [each for each, _ in reported] == ([] if code is None else [code])
    assert all(each.startswith(message) for _, each in reported)
    with scenecc.load_scene(
        {"scenecc": 1, "entities": {"r": entity}}, render=False, allow_outside_assets=True
    ) as batch:
        (joint,) = robot(batch).active_joints
        assert joint.friction < 0.2
        assert (joint.damping == BRAKE_DAMPING) == (case == "light damping")


def written(target: str, folder: Path, dynamics: str = 'friction="5"') -> dict[str, Any]:
    """The entity of a robot that is written as a file for another program."""
    (folder / "r.urdf").write_text(urdf(dynamics))
    made = scenecc.open_scene(
        {"scenecc": 1, "entities": {"r": {"urdf": str(folder / "r.urdf")}}}, allow_outside_assets=True
    ).emit(target, name="out")
    for name, content in made.files.items():
        (folder / name).write_bytes(content)
    return {target: str(folder / next(iter(made.files)))}


@pytest.mark.parametrize("target", ["urdf", "mjcf"])
def test_an_exported_friction_is_a_force_again(target: str, tmp_path: Path) -> None:
    entity = written(target, tmp_path)
    assert moved(entity, 4.9) == pytest.approx(0, abs=1e-5)
    assert moved(entity, 20) == pytest.approx(15 / MASS / 8, rel=0.03)


def test_a_live_friction_is_decompiled_as_a_key(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(urdf('friction="5"'))
    document = {"scenecc": 1, "entities": {"r": {"urdf": str(tmp_path / "r.urdf")}}}
    with scenecc.load_scene(document, render=False, allow_outside_assets=True) as batch:
        again = scenecc.decompile(batch.scenes[0])
    assert again.is_equal, (again.problems, again.differences)
    (child,) = again.document["entities"]["r"]["root"]["children"]
    assert child["joint"]["friction_force"] == 5
    assert "drives" not in again.document["entities"]["r"]


def test_a_drawn_friction_is_reset(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(urdf('friction="5"'))
    entity = {"urdf": str(tmp_path / "r.urdf"), "joints": {"j": {"friction_force": {"uniform": [1, 9]}}}}
    with scenecc.load_scene(
        {"scenecc": 1, "entities": {"r": entity}}, render=False, allow_outside_assets=True
    ) as batch:
        (joint,) = robot(batch).active_joints
        before = float(joint.force_limit)
        batch.reset(seed=3)
        assert 1 <= before != float(joint.force_limit) <= 9
        assert joint.friction == 0


def test_the_inspection_says_what_it_is(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(urdf('friction="5"'))
    document = {"scenecc": 1, "entities": {"r": {"urdf": str(tmp_path / "r.urdf")}}}
    text = str(scenecc.inspect_scene(document, allow_outside_assets=True))
    assert "friction_force" in text
    assert "1e+09" not in text
    python = scenecc.emit_scene(document, "python", allow_outside_assets=True)
    assert "a drive that brakes" in python
