"""Each attribute of the installed MuJoCo is built, told or without an effect, as docs/reference/mjcf.md says."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from scenecc.diagnostics import Sink
from scenecc.robots.mujoco.reader import read_mjcf
from scenecc.source.paths import AssetScope, ResolvedFile

mujoco: Any = pytest.importorskip("mujoco")

PAGE = Path(__file__).parents[3] / "docs/reference/mjcf.md"


def documented() -> dict[str, set[str]]:
    """The attributes of each element in the page's table."""
    table = PAGE.read_text().partition("| element | built |")[2].partition("\n\n")[0]
    rows = [line.split("|")[1:] for line in table.splitlines()[2:]]
    return {element.strip(): set(re.findall(r"`(\w+)`", " ".join(cells))) for element, *cells in rows}


def elements() -> dict[str, Any]:
    """One of each kind, with nothing said of it."""
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body()
    kinds = ("mesh", "hfield", "material", "texture", "actuator", "equality", "exclude", "key")
    return {
        "body": body,
        "joint": body.add_joint(),
        "geom": body.add_geom(),
        **{kind: getattr(spec, f"add_{kind}")() for kind in kinds},
    }


@pytest.mark.parametrize("kind", elements())
def test_the_mjcf_page_lists_every_attribute(kind: str) -> None:
    """A new attribute of a new MuJoCo is built or told, and then stands in the table."""
    element, page = elements()[kind], documented()
    known = {name for name in dir(element) if name[0] != "_" and not callable(getattr(element, name))}
    assert known
    assert known - page["each"] - page[kind] == set()


def test_the_mjcf_page_lists_every_element() -> None:
    assert set(documented()) == {"each", *elements()}


def told(folder: Path, text: str, keyframe: str | None = None) -> list[str]:
    """What is said of a file, without places."""
    file, sink = folder / "robot.xml", Sink()
    file.write_text(text)
    chosen = None if keyframe is None else (keyframe, None)
    found = read_mjcf(ResolvedFile(file, file.name), scope=AssetScope(folder), sink=sink, keyframe=chosen)
    assert found is not None, sink.diagnostics()
    return [f"{one.code} {one.line} {one.message}" for one in sink.diagnostics()]


def model_of(joint: str = "", geom: str = "", rest: str = "") -> str:
    body = f'<body>\n<joint name="j" {joint}/>\n<geom size="1" {geom}/></body>'
    return f"<mujoco><worldbody>{body}\n</worldbody>\n{rest}</mujoco>"


def actuator(attributes: str, *, kind: str = "position") -> str:
    return f'<actuator><{kind} joint="j" {attributes}/></actuator>'


KEY = "<keyframe><key name='k' {}/></keyframe>"
SINCE_4 = {
    "springyield": (model_of('stiffness="9" springyield="2"'), "SC484 2 joint springs that yield"),
    "adhesion": (model_of(geom='adhesion="1"'), "SC484 3 `adhesion` of geoms is not built"),
    "surfacevel": (model_of(geom='surfacevel="1 0 0 0 0 0"'), "SC484 3 `surfacevel` of geoms"),
    "damping": (model_of(rest=actuator('kp="3" damping="2"')), "SC484 5 `damping` and `armature` of actuators"),
    "plastic": (
        model_of('stiffness="9" springyield="2"', rest=KEY.format("plastic='1'")),
        "SC484 5 springs that have yielded in the keyframe",
    ),
}
TOLD = {
    **SINCE_4,
    "delay": (model_of(rest=actuator('kp="3" delay="0.02" nsample="9"')), "SC484 5 delays of actuators are not built"),
    "condim": (model_of(geom='condim="6"'), "SC484 3 torsional and rolling friction"),
    "priority": (model_of(geom='priority="1"'), "SC490 3 contacts and limits of PhysX are stiff"),
    "forcerange": (model_of(rest=actuator('kp="3" forcerange="0 5"')), "SC484 5 a drive has one force limit"),
    "actfrcrange": (
        model_of('actuatorfrcrange="0 5"', rest=actuator('kp="3"')),
        "SC484 2 a drive has one force limit",
    ),
    "dyntype": (
        model_of(rest=actuator('kp="3" timeconst="1"')),
        "SC484 5 actuators with a state of their own are not built (there are 1)",
    ),
    "plugin": (
        model_of(rest=actuator('plugin="a" instance="b" ctrlrange="0 1" actdim="3"', kind="plugin")),
        "SC484 5 actuators of plugins are not built: they drive no joint",
    ),
    "extension": (
        model_of(rest='<extension><plugin plugin="a"><instance name="b"/></plugin></extension>'),
        "SC490 5 plugins are code, which is not run",
    ),
    "sensor plugin": (
        model_of(rest='<sensor><plugin plugin="a" objtype="geom" objname="b"/></sensor>'),
        "SC490 5 sensors are read from the live scene",
    ),
    "several limits": (
        model_of(rest=actuator('kp="3" forcerange="-1 1"') + "\n" + actuator('kv="3"', kind="velocity")),
        "SC484 6 several actuators of a joint become one drive",
    ),
    "qvel": (model_of(rest=KEY.format("qvel='1'")), "SC484 5 velocities of the keyframe"),
    "mpos": (
        model_of(rest="<worldbody><body mocap='true'><geom size='1'/></body></worldbody>" + KEY.format("mpos='0 0 1'")),
        "SC484 5 poses of mocap bodies come from the file",
    ),
    "mocap": (
        model_of().replace("<body>", "<body mocap='true'><body>").replace("</body>", "</body></body>"),
        "SC484 1 a mocap body with joints becomes the fixed root",
    ),
    "fluid": (model_of(rest='<option viscosity="1"/>'), "SC484 5 `density` and `viscosity` of <option>"),
    "override": (model_of(rest='<option><flag override="enable"/></option>'), "SC484 5 `<flag override"),
    "reflectance": (
        model_of(rest='<asset><material name="m" reflectance="1"/></asset>'),
        "SC490 5 `reflectance` of materials is not shown",
    ),
    "texrepeat": (
        model_of(
            rest='<asset><texture name="t" file="t.png"/><material name="m" texture="t" texrepeat="2 1"/></asset>'
        ),
        "SC490 5 textures are not repeated",
    ),
}


@pytest.mark.parametrize("name", TOLD)
def test_unbuilt_attributes_are_reported_at_their_lines(tmp_path: Path, name: str) -> None:
    if name in SINCE_4 and int(mujoco.__version__.partition(".")[0]) < 4:
        pytest.skip("of MuJoCo 4")
    text, expected = TOLD[name]
    (tmp_path / "t.png").touch()
    found = told(tmp_path, text, keyframe="k" if "name='k'" in text else None)
    assert any(one.startswith(expected) for one in found), found


def test_default_values_are_not_reported(tmp_path: Path) -> None:
    text = model_of('margin="0"', 'condim="3" group="2"', actuator('kp="3" forcerange="-5 5" ctrlrange="-1 1"'))
    assert told(tmp_path, text.replace('margin="0"', "")) == []
    assert told(tmp_path, text.replace("<body>", '<body mocap="false">').replace('margin="0"', "")) == []


def test_unbuilt_elements_are_counted(tmp_path: Path) -> None:
    second = "<worldbody><body><freejoint/><geom size='1' condim='4'/></body></worldbody>"
    found = told(tmp_path, model_of(geom='condim="6"', rest=second))
    assert found == ["SC484 3 torsional and rolling friction (`condim` of 4 and 6) is not built (there are 2)"]
