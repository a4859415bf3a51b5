"""Small MJCF files, one a feature."""

from __future__ import annotations


def mjcf(world: str, rest: str = "") -> str:
    return f"<mujoco>{rest}<worldbody>{world}</worldbody></mujoco>"


GEOM = '<geom type="box" size=".1 .2 .3"/>'
ARM = f'<body name="arm"><joint name="hinge" axis="0 0 1"/>{GEOM}</body>'

CASES: dict[str, str] = {
    "hinge": mjcf(
        f'<body name="a" pos=".1 .2 .3"><joint name="j" axis="0 1 0" range="-30 45" pos="0 .1 0"/>{GEOM}</body>'
    ),
    "radians": mjcf(
        f'<body name="a"><joint axis="1 2 3" range="-.5 1.25"/>{GEOM}</body>', '<compiler angle="radian"/>'
    ),
    "no limits": mjcf(f'<body name="a"><joint axis="1 0 0" range="-30 45" limited="false"/>{GEOM}</body>'),
    "limits said": mjcf(f'<body name="a"><joint axis="1 0 0" range="-30 45" limited="true"/>{GEOM}</body>'),
    "slide": mjcf(f'<body name="a"><joint type="slide" axis=".3 0 -1" range="-.1 .2" damping=".7"/>{GEOM}</body>'),
    "endless joint that starts elsewhere": mjcf(
        f'<body name="a"><joint type="slide" axis="0 0 1" ref="1.25"/>{GEOM}</body>'
    ),
    "slide without limits": mjcf(f'<body name="a"><joint type="slide" axis="-1 0 0"/>{GEOM}</body>'),
    "damping and friction": mjcf(f'<body name="a"><joint axis="0 0 1" damping="2e-6" frictionloss=".3"/>{GEOM}</body>'),
    "fixed by a class's axis": mjcf(
        f'<body name="a" childclass="c"><joint name="j"/>{GEOM}<body name="b" pos="0 0 1">{GEOM}</body></body>',
        '<default><default class="c"><joint axis="0 1 0" pos=".1 0 0" damping="3"/></default></default>',
    ),
    "several joints": mjcf(
        '<body name="a" pos="0 0 1" quat=".6 .8 0 0"><joint name="x" type="slide" axis="1 0 0"/>'
        f'<joint name="z" type="slide" axis="0 0 1" pos=".1 .2 .3"/><joint name="y" axis="0 1 0" range="-1 1"/>{GEOM}'
        f'<body name="b" pos=".5 0 0"><joint name="k" axis="0 1 0"/>{GEOM}</body></body>'
    ),
    "free": mjcf(f'<body name="a" pos="0 0 1"><freejoint name="root"/>{GEOM}</body>'),
    "free with joints inside": mjcf(
        f'<body name="a"><freejoint/>{GEOM}<body name="b" pos="1 0 0"><joint axis="0 1 0"/>{GEOM}</body></body>'
    ),
    "several robots and bodies": mjcf(
        f'{ARM}<body name="s"><geom name="g" size=".1"/><body name="t"><geom size=".2"/></body></body>'
        f'<body name="b"><joint axis="1 0 0"/>{GEOM}<body name="c"><joint axis="0 1 0"/>{GEOM}</body></body>'
        '<geom name="floor" type="box" size="1 1 .1" pos="0 0 -.1"/><geom size=".3"/>'
    ),
    "a body around another": mjcf(f'<body name="outer"><site name="s"/>{ARM}</body>'),
    "branches": mjcf(
        f'{ARM[:-7]}<body name="b"><joint axis="0 1 0"/>{GEOM}</body><body name="c"><joint axis="0 1 0"/>{GEOM}'
        f'<body name="d">{GEOM}</body></body></body>'
    ),
    "contacts switched off": mjcf(
        f'{ARM}<geom type="box" size="1 1 .1"/>', '<option><flag contact="disable" energy="enable"/></option>'
    ),
    "sphere": mjcf('<geom name="ball" size=".05" pos=".1 .2 .3" quat=".6 .8 0 0"/>'),
    "capsule": mjcf('<geom name="c" type="capsule" size=".05 .2" pos=".1 .2 .3" quat=".6 0 .8 0"/>'),
    "cylinder": mjcf('<geom name="c" type="cylinder" size=".05 .2" axisangle="1 2 3 40"/>'),
    "box": mjcf('<geom name="b" type="box" size=".05 .2 .1" axisangle="1 0 0 40" pos="1e-3 2E-2 +.5"/>'),
    "capsule between points": mjcf('<geom type="capsule" size=".05" fromto=".1 0 .3 -.2 .5 .7"/>'),
    "cylinder between points": mjcf('<geom type="cylinder" size=".05 4" fromto="0 0 0 0 0 1"/>'),
    "capsule along x": mjcf('<geom type="capsule" size=".05" fromto=".1 0 0 .4 0 0"/>'),
    "capsule against x": mjcf('<geom type="capsule" size=".05" fromto=".1 0 0 -.4 0 0"/>'),
    "capsule along its zaxis": mjcf('<geom type="capsule" size=".05 .2" zaxis="1 2 -3"/>'),
    "euler about x": mjcf('<geom type="box" size=".1 .2 .3" euler="33 0 0"/>'),
    "euler about z": mjcf('<geom type="box" size=".1 .2 .3" euler="0 0 -70"/>'),
    "almost unit quaternion": mjcf(f'<body name="a" quat="1.000 0 -.002 0"><joint axis="0 1 0"/>{GEOM}</body>'),
    "density": mjcf('<geom size=".1" density="5.5"/>'),
    "friction": mjcf('<geom size=".1" friction="1.5 .1 .1"/><geom size=".1" friction=".7"/>'),
    "condim": mjcf(
        '<geom size=".1" condim="1" friction=".7"/><geom size=".1" condim="3" friction=".7"/>'
        '<geom size=".1" condim="4"/>'
    ),
    "groups": mjcf('<geom size=".1" group="2"/><geom size=".2" group="3"/><geom size=".3" group="0"/>'),
    "seen only": mjcf('<geom size=".1" contype="0" conaffinity="0"/>'),
    "colour": mjcf('<geom size=".1" rgba=".1 .2 .3 .4"/>'),
    "material": mjcf(
        '<geom size=".1" material="m"/><geom size=".1" material="n"/>',
        '<asset><material name="m" rgba=".1 .2 .3 .9" emission=".3" specular=".4" shininess=".2" reflectance=".7"/>'
        '<material name="n"/></asset>',
    ),
    "texture": mjcf(
        '<geom size=".1" material="m"/>',
        '<asset><texture name="t" type="2d" file="wood.png"/><material name="m" texture="t"/></asset>',
    ),
    "mesh": mjcf(
        '<geom mesh="rock" pos="0 0 1"/><geom type="mesh" mesh="m" group="3"/><geom type="mesh" mesh="m" contype="0"'
        ' conaffinity="0" rgba="1 0 0 1"/>',
        '<compiler meshdir="meshes"/><asset><mesh file="rock.obj"/><mesh name="m" file="rock.obj"'
        ' scale="2 .5 1"/></asset>',
    ),
    "global defaults": mjcf(
        f'{ARM}<geom name="g"/>',
        '<default><geom size=".3" rgba="1 0 0 1" density="7"/><joint damping=".1" armature=".01"/></default>',
    ),
    "classes": mjcf(
        '<body name="a" childclass="arm"><joint name="j" class="stiff"/><geom name="g"/><geom class="look"/>'
        '<body name="b"><joint name="k"/><geom name="h" size=".5 .1"/></body></body>',
        '<default><geom density="3"/><default class="arm"><joint axis="0 1 0" damping=".2" limited="true"'
        ' range="-9 9"/><geom type="capsule" size=".1 .2"/><default class="stiff"><joint damping="5"/></default>'
        '<default class="look"><geom contype="0" conaffinity="0" group="2"/></default></default></default>',
    ),
    "classes of motors": mjcf(
        f'<body name="a"><joint axis="0 0 1"/>{GEOM}<geom class="motor_big" size=".1"/>'
        f'<body name="b" childclass="motor"><geom size=".2"/></body></body>',
        '<default><default class="motor"/><default class="motor_big"/></default>',
    ),
    "planes and ellipsoids": mjcf(f'<geom type="plane" size="1 1 .1"/><geom type="ellipsoid" size=".1 .2 .3"/>{GEOM}'),
    "thirty-two bonds": mjcf(
        '<body name="a"><joint axis="0 0 1"/><geom size=".1"/>'
        + "".join(f'<body name="b{i}"><joint axis="0 1 0"/><geom size=".1"/></body>' for i in range(31))
        + "</body>"
    ),
    "included": (
        f'<mujoco><include file="parts/common.xml"/><worldbody>{ARM}<geom size=".1" material="m"/></worldbody></mujoco>'
    ),
    "sections twice": (
        f'<mujoco><asset/><asset><material name="m" rgba="1 0 0 1"/></asset><worldbody>{ARM}'
        '<geom size=".1" material="m"/></worldbody></mujoco>'
    ),
    "euler about y": mjcf(f'<body name="a" euler="0 30 0"><joint name="j" axis="0 0 1"/>{GEOM}</body>'),
    "euler in order": mjcf(f'<body name="a" euler="10 20 30"><joint name="j" axis="0 0 1"/>{GEOM}</body>'),
    "euler in another order": mjcf(
        f'<body name="a" euler="10 20 30"><joint name="j" axis="0 0 1"/>{GEOM}</body>', '<compiler eulerseq="ZYX"/>'
    ),
    "xyaxes": mjcf(f'<body name="a" xyaxes="0 1 0 -1 1 0"><joint name="j" axis="0 0 1"/>{GEOM}</body>'),
    "zaxis of a body": mjcf(f'<body name="a" zaxis="1 2 3"><joint name="j" axis="0 0 1"/>{GEOM}</body>'),
    "zaxis straight up": mjcf(f'<body name="a" zaxis="0 0 2"><joint name="j" axis="0 0 1"/>{GEOM}</body>'),
    "zaxis straight down": mjcf('<geom type="capsule" size=".1 .2" zaxis="0 0 -1"/>'),
    "quaternion of another length": mjcf(f'<body name="a" quat="1 1 0 0"><joint name="j" axis="0 0 1"/>{GEOM}</body>'),
    "joint without axis": mjcf(f'<body name="a"><joint name="j"/>{GEOM}</body>'),
    "joint with a short axis": mjcf(f'<body name="a"><joint name="j" axis="0 1e-4 0"/>{GEOM}</body>'),
    "empty range": mjcf(f'<body name="a"><joint name="j" axis="1 0 0" range="0 0"/>{GEOM}</body>'),
    "limits of a joint that starts elsewhere": mjcf(
        f'<body name="a"><joint name="j" axis="1 0 0" range="-10 90" ref="30"/>{GEOM}</body>'
    ),
    "box between points": mjcf('<geom type="box" size=".1" fromto="0 0 0 .3 .4 1"/>'),
    "named global class": mjcf('<geom type="box"/>', '<default class="main"><geom size=".1 .2 .3"/></default>'),
    "class beside the body's": mjcf(
        f'<body name="a" childclass="c"><joint name="j" class="d" axis="0 0 1"/>{GEOM}</body>',
        '<default><default class="c"><joint damping="5"/></default><default class="d"><joint armature="1"/></default>'
        "</default>",
    ),
    "classes in one another": mjcf(
        '<body name="a" childclass="c"><joint name="j" axis="0 0 1"/><geom type="box" size=".1 .2 .3"/>'
        '<body name="b" childclass="d"><joint name="k" axis="0 0 1"/><geom type="box" size=".1 .2 .3"/></body></body>',
        '<default><default class="c"><geom density="7"/></default><default class="d"/></default>',
    ),
    "a moved body around another": mjcf(
        '<body name="o" pos="1 2 3" quat=".6 .8 0 0"><body name="a" pos="1 0 0"><joint name="j" axis="0 0 1"/>'
        f"{GEOM}</body></body>"
    ),
    "standing body": mjcf(f'<body name="s" pos="1 2 3" quat=".6 .8 0 0">{GEOM}</body>'),
    "bodies in a standing one": mjcf(
        f'<body name="s" pos="1 2 3">{GEOM}<body name="t" pos="0 1 0" quat=".6 .8 0 0">{GEOM}</body>'
        f'<body name="u" quat=".6 0 .8 0">{GEOM}<body name="v" pos="0 0 1">{GEOM}</body></body></body>'
    ),
}
"""Name → the file."""

COMMON = '<mujoco><asset><material name="m" rgba="0 1 0 1"/></asset><default><geom density="9"/></default></mujoco>'
"""What `parts/common.xml` holds, which a case includes."""
