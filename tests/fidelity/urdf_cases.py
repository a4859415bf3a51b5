"""URDFs of our own, by name, each with its SRDF or None."""

from __future__ import annotations


def robot(content: str) -> str:
    """A URDF of some content."""
    return f'<?xml version="1.0"?>\n<robot name="r">{content}\n</robot>\n'


def joint(name: str, kind: str, parent: str, child: str, inner: str = "") -> str:
    """A joint."""
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'\n<joint name="{name}" type="{kind}">{ends}{inner}</joint>'


_GEOMETRIES = (
    '<box size="0.1 0.2 .3e0"/>',
    '<sphere radius="0.123"/>',
    '<capsule radius="0.05" length="0.31"/>',
    '<cylinder radius="0.07" length="0.4"/>',
    '<mesh filename="part.obj"/>',
    '<mesh filename="package://pack/meshes/part.stl" scale="0.001 -0.002 +0.003"/>',
)

_ORIGINS = (
    "",
    '<origin xyz="0.1 -0.2 0.3"/>',
    '<origin rpy="0.3 -1.2 2.9"/>',
    '<origin xyz="1 2 3" rpy="3.14159 0 1.5707963"/>',
    '<origin xyz="-1e-3 0 5" rpy="1.5707963267948966 1.5707963267948966 -1.5707963267948966"/>',
    "<origin/>",
)


def _shapes(tag: str) -> str:
    return "".join(
        f'\n<{tag} name="{tag}{i}{j}">{origin}<geometry>{geometry}</geometry></{tag}>'
        for i, geometry in enumerate(_GEOMETRIES)
        for j, origin in enumerate(_ORIGINS)
    )


_INERTIALS = (
    ("1.5", "0.1 0.2 0.25 0 0 0", _ORIGINS[3]),
    ("2.5", "0.3 0.2 0.25 0.01 -0.02 0.03", _ORIGINS[2]),
    ("0.7", "0.2 0.2 0.2 0.05 0 0", _ORIGINS[4]),
    ("0.7", "1e-6 2e-6 2.5e-6 1e-7 -2e-7 3e-8", _ORIGINS[0]),
    ("0", "0 0 0 0 0 0", ""),
    ("1", "0 0 0 0 0 0", ""),
    ("3", "0.2 0.1 0.25 0 -0.01 0", _ORIGINS[1]),
)

_TENSOR = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def _inertial(mass: str, tensor: str, origin: str) -> str:
    values = " ".join(f'{name}="{value}"' for name, value in zip(_TENSOR, tensor.split(), strict=True))
    return f'<inertial>{origin}<mass value="{mass}"/><inertia {values}/></inertial>'


_LIMIT = '<limit lower="-0.5" upper="1.25" effort="10" velocity="2"/>'

_JOINTS = (
    ("fixed", '<axis xyz="0 0 0"/><origin xyz="1 2 3" rpy="1 2 3"/>'),
    ("fixed", ""),
    ("revolute", _LIMIT + '<axis xyz="0 0 1"/><dynamics friction="0.3" damping="2"/>'),
    ("revolute", '<limit lower="-inf" upper="3"/><axis xyz="0.3 0.4 0.5"/><origin rpy="0.1 0.2 0.3"/>'),
    ("continuous", '<axis xyz="-1 0 0"/><dynamics damping="0.25"/>'),
    ("continuous", '<axis xyz="0.95 0.05 0"/><origin xyz="0.5 0 0.1"/>'),
    ("prismatic", _LIMIT + '<axis xyz="0 -1 0"/><dynamics friction="1"/>'),
    ("prismatic", _LIMIT + '<axis xyz="2 3 -7"/><origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/>'),
)

_TREE = "".join(f'\n<link name="{name}"/>' for name in "abcdefgh")

_BRANCHES = (
    joint("ab", "fixed", "a", "b")
    + joint("cd", "continuous", "c", "d")
    + joint("ac", "fixed", "a", "c")
    + joint("be", "prismatic", "b", "e", _LIMIT)
    + joint("bf", "revolute", "b", "f", _LIMIT)
    + joint("ag", "revolute", "a", "g", _LIMIT)
    + joint("eh", "continuous", "e", "h")
)


def _pair(first: str, second: str, reason: str = "Default") -> str:
    return f'\n<disable_collisions link1="{first}" link2="{second}" reason="{reason}"/>'


_MATERIALS = (
    '\n<material name="shared"><color rgba="0.1 0.2 0.3 1"/></material>'
    '\n<material name="wood"><texture filename="maps/wood.png"/></material>'
    '\n<link name="base">'
    + "".join(
        f'<visual><geometry><box size="1 1 1"/></geometry>{material}</visual>'
        for material in (
            '<material name="shared"/>',
            '<material name="wood"/>',
            '<material name="unknown"/>',
            '<material name="own"><color rgba="1.5 -1 0.5 0.25"/></material>',
            '<material name="own"><color rgba="0 0 0 1"/></material>',
            '<material name="shared"><color rgba="0 0 0 1"/></material>',
            '<material name="both"><color rgba="1 0 0 1"/><texture filename="nowhere.png"/></material>',
            '<material name=""><color rgba="0 1 0 1"/></material>',
            '<material name=""><color rgba="0 0 1 1"/></material>',
            "",
        )
    )
    + "</link>"
)

CASES: dict[str, tuple[str, str | None]] = {
    "shapes": (robot(f'<link name="base">{_shapes("visual")}{_shapes("collision")}</link>'), None),
    "inertials": (
        robot(
            "".join(f'\n<link name="l{i}">{_inertial(*given)}</link>' for i, given in enumerate(_INERTIALS))
            + "".join(joint(f"j{i}", "fixed", "l0", f"l{i}") for i in range(1, len(_INERTIALS)))
        ),
        None,
    ),
    "joints": (
        robot(
            '\n<link name="base"/>'
            + "".join(f'\n<link name="l{i}"/>' for i in range(len(_JOINTS)))
            + "".join(
                joint(f"j{i}", kind, "base" if i == 0 else f"l{i - 1}", f"l{i}", inner)
                for i, (kind, inner) in enumerate(_JOINTS)
            )
        ),
        None,
    ),
    "tree": (robot(_TREE + _BRANCHES), None),
    "srdf": (
        robot(_TREE + _BRANCHES),
        robot(
            _pair("d", "h")
            + _pair("a", "b")
            + _pair("f", "g", "default")
            + _pair("f", "e", "Never")
            + _pair("e", "b", "Default")
            + _pair("d", "h")
            + _pair("g", "f", "Adjacent")
            + "".join(_pair("h", name) for name in "abcdfg")
        ),
    ),
    "mimic": (
        robot(
            '<link name="a"/><link name="b"/><link name="c"/><link name="d"/>'
            + joint("j1", "revolute", "a", "b", _LIMIT)
            + joint("j2", "revolute", "a", "c", _LIMIT + '<mimic joint="j1" multiplier="-0.5" offset="0.1"/>')
            + joint("j3", "continuous", "c", "d", '<mimic joint="j1"/>')
        ),
        None,
    ),
    "materials": (robot(_MATERIALS), None),
    "bodies": (
        robot(
            '<link name="table"><collision><geometry><box size="1 1 1"/></geometry></collision></link>'
            '<link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
            '<link name="can"/>'
            + joint("f1", "floating", "table", "ball", '<origin xyz="0 0 2" rpy="0.1 0.2 0.3"/>')
            + joint("f2", "floating", "table", "can", '<origin xyz="0 3 2"/>')
        ),
        None,
    ),
    "robot_and_body": (
        robot(
            '<link name="base"/><link name="ball"/><link name="arm"/>'
            + joint("f", "floating", "base", "ball", '<origin xyz="0 0 2"/>')
            + joint("turn", "continuous", "base", "arm")
        ),
        None,
    ),
    "extras": (
        robot(
            "<!-- a comment --><gazebo><physics/></gazebo>"
            '<transmission name="t"><type>x</type><joint name="turn"/><actuator name="m"/></transmission>'
            '<link name="base"><visual><geometry><box size="1 1 1"/></geometry></visual><odd thing="1"/></link>'
            '<link name="arm"/>'
            + joint("turn", "continuous", "base", "arm", '<safety_controller k_velocity="1"/><calibration rising="0"/>')
        ),
        None,
    ),
}
