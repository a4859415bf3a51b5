"""The elements and attributes of a URDF that are known; what is not is told, once a kind, and not read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut
from scenecc.plan.geometry import LYING_SOLIDS, SOLIDS

if TYPE_CHECKING:
    from scenecc.robots.files import FileReport
    from scenecc.robots.xml import SourceElement


@frozen
class _ElementSchema:
    """What an element may hold.

    Attributes:
        attributes: names.
        left: names of attributes that other programs have there, and that mean nothing here.
        single: children of which only the first is read.
        many: children that may be repeated.
        skipped: children that mean nothing to a simulation of bodies, whatever they hold.
    """

    attributes: tuple[str, ...] = ()
    single: tuple[str, ...] = ()
    many: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()
    left: tuple[str, ...] = ()


_ELEMENT_SCHEMAS: dict[str, _ElementSchema] = {
    "robot": _ElementSchema(
        ("name", "version"),
        many=("link", "joint", "material"),
        skipped=("transmission", "gazebo", "sensor", "mujoco"),
    ),
    "link": _ElementSchema(("name", "type"), ("inertial",), ("visual", "collision")),
    "inertial": _ElementSchema((), ("origin", "mass", "inertia")),
    "visual": _ElementSchema(("name",), ("origin", "geometry", "material")),
    "collision": _ElementSchema(("name",), ("origin", "geometry")),
    "origin": _ElementSchema(("xyz", "rpy")),
    "mass": _ElementSchema(("value",)),
    "inertia": _ElementSchema(("ixx", "ixy", "ixz", "iyy", "iyz", "izz")),
    "geometry": _ElementSchema(many=(*SOLIDS, "mesh")),
    "box": _ElementSchema(("size",)),
    "sphere": _ElementSchema(("radius",)),
    **dict.fromkeys(LYING_SOLIDS, _ElementSchema(("radius", "length"))),
    "mesh": _ElementSchema(("filename", "scale")),
    "material": _ElementSchema(("name",), ("color", "texture")),
    "color": _ElementSchema(("rgba",)),
    "texture": _ElementSchema(("filename",)),
    "joint": _ElementSchema(
        ("name", "type"),
        ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
        skipped=("safety_controller", "calibration", "hardwareInterface"),
    ),
    "parent": _ElementSchema(("link",)),
    "child": _ElementSchema(("link",)),
    "axis": _ElementSchema(("xyz",)),
    "limit": _ElementSchema(("lower", "upper", "effort", "velocity")),
    "dynamics": _ElementSchema(("damping", "friction"), left=("D", "K", "mu_coulomb", "mu_viscous")),
    "mimic": _ElementSchema(("joint", "multiplier", "offset")),
}


def check_urdf_schema(robot: SourceElement, findings: FileReport) -> None:
    """Warns of every kind of element and attribute that a URDF does not have (SC454), and of sensors (SC470)."""
    stack = [robot]
    while stack:
        element = stack.pop()
        kind = _ELEMENT_SCHEMAS[element.tag]
        for name in element.attributes:
            if name not in kind.attributes + kind.left and ":" not in name and name != "xmlns":
                _report_unknown(element, name, kind, findings)
        seen: set[str] = set()
        for child in element.children:
            if child.tag in kind.single or child.tag in kind.many:
                if child.tag in seen and child.tag in kind.single:
                    what = f"a second <{child.tag}> in <{element.tag}> is not read"
                    findings.report_once("SC454", f"second {element.tag}/{child.tag}", what, child.location)
                    continue
                seen.add(child.tag)
                stack.append(child)
            elif child.tag in kind.skipped:
                _check_sensor(child, findings)
            else:
                known = kind.single + kind.many + kind.skipped
                near = findings.guess("SC454", f"{element.tag}/{child.tag}", child.tag, known)
                hint = _XACRO_HINT if child.tag.startswith("xacro:") else near and f"did you mean <{near}>?"
                findings.report_once(
                    "SC454",
                    f"{element.tag}/{child.tag}",
                    f"<{cut(child.tag)}> in <{element.tag}> is not known and not read",
                    child.location,
                    hint,
                )


_XACRO_HINT = "the file is a xacro: make it a URDF by `xacro robot.urdf.xacro > robot.urdf`"


def _report_unknown(element: SourceElement, name: str, kind: _ElementSchema, findings: FileReport) -> None:
    near = findings.guess("SC454", f"{element.tag}@{name}", name, kind.attributes)
    findings.report_once(
        "SC454",
        f"{element.tag}@{name}",
        f"`{cut(name)}` of <{element.tag}> is not known and not read",
        element.at(name),
        near and f"did you mean `{near}`?",
    )


def _check_sensor(element: SourceElement, findings: FileReport) -> None:
    """Warns of a camera, of which SAPIEN's loader makes one, at the top or for Gazebo."""
    sensors = [element] if element.tag == "sensor" else list(element.all("sensor"))
    for sensor in sensors:
        if sensor.find("camera") is not None:
            findings.report_once(
                "SC470",
                "camera",
                "cameras of a URDF are not built",
                sensor.location,
                "declare it under `cameras` of the scene, with `mount: ROBOT/LINK`",
            )
