"""Shared by all exporters: XML elements, pose arithmetic, asset files, reports of unsupported features.

A pose is p [m], then q (wxyz).
"""

from __future__ import annotations

import re
from dataclasses import fields
from hashlib import sha256
from typing import TYPE_CHECKING, Any, Final
from xml.sax.saxutils import quoteattr

import numpy as np

from scenecc.diagnostics.diagnostic import Location, Origin
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, Vec3, normalized, rotate, to_pose
from scenecc.plan.articulation import friction_force
from scenecc.plan.display import SPEC_FIELD_NAMES
from scenecc.plan.scene import Physics

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from scenecc.diagnostics import Sink
    from scenecc.plan import Value
    from scenecc.plan.snapshot import MeasuredJoint

_INDENT = "  "


class XmlElement:
    """An element and its children. Attributes that are None are omitted."""

    __slots__ = ("attributes", "children", "tag")

    def __init__(self, tag: str, **attributes: Any) -> None:
        self.tag = tag
        self.attributes = {name: format_attribute(value) for name, value in attributes.items() if value is not None}
        self.children: list[XmlElement] = []

    def add(self, tag: str, **attributes: Any) -> XmlElement:
        """Appends a new child."""
        return self.take(XmlElement(tag, **attributes))

    def take(self, child: XmlElement) -> XmlElement:
        """Appends an element as the last child."""
        self.children.append(child)
        return child

    def walk(self) -> Iterator[XmlElement]:
        """Yields this element and all its descendants, in document order."""
        yield self
        for child in self.children:
            yield from child.walk()

    def lines(self, depth: int = 0) -> Iterator[str]:
        """Yields its text, line by line."""
        head = "".join(f" {name}={quoteattr(value)}" for name, value in self.attributes.items())
        if not self.children:
            yield f"{_INDENT * depth}<{self.tag}{head}/>"
            return
        yield f"{_INDENT * depth}<{self.tag}{head}>"
        for child in self.children:
            yield from child.lines(depth + 1)
        yield f"{_INDENT * depth}</{self.tag}>"


_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML does not allow, but names in a plan's JSON do."""


def format_document(root: XmlElement) -> bytes:
    """Returns an XML file with this root element."""
    text = "\n".join(['<?xml version="1.0" encoding="utf-8"?>', *root.lines(), ""])
    return _NOT_XML.sub("\ufffd", text).encode()


def format_attribute(value: Any) -> str:
    """Formats an attribute: a string, a flag, a number, or several numbers."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    return " ".join(format_number(float(one)) for one in np.atleast_1d(value))


def format_number(value: float) -> str:
    """Formats a number with the fewest digits. A float32 number gets the fewest that read back as the same float32."""
    if value == 0:
        return "0"
    with np.errstate(over="ignore"):
        single = np.float32(value)
    text = str(single) if float(single) == value else repr(value)
    return text.removesuffix(".0")


UNLIMITED: Final = 1e10
"""Written for a missing limit if the format requires one [m, rad]."""

MAX_LIMIT: Final = 1e38
"""A force or velocity limit above this means unlimited."""


def is_pure_damping(joint: MeasuredJoint) -> bool:
    """Returns whether a drive only damps its joint: no stiffness and no velocity target. It may have a force limit."""
    is_brake = friction_force(joint.joint) is not None
    return joint.drive_mode == "force" and joint.stiffness == 0 and joint.drive_velocity_target == 0 and not is_brake


def friction_loss(joint: MeasuredJoint) -> float:
    """Returns the friction that does not depend on the load [N, N·m]; 0 if there is none."""
    return 0.0 if friction_force(joint.joint) is None else joint.force_limit


Z_TO_X: Final[Pose7] = (0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5)
"""Rotates z to x, x to y and y to z: from shapes along z (MuJoCo) to shapes along x (SAPIEN)."""


def transform_direction(pose: Pose7, vector: Vec3) -> Vec3:
    """Transforms a direction from a pose's own frame to the parent frame."""
    return rotate(normalized(pose[3:]), vector)


def pose_in_row(value: Value | None, row: int) -> Pose7:
    """Returns one row of a pose of the plan, or the identity if it is None."""
    return IDENTITY_POSE if value is None else to_pose(value.row(row))


_DIGEST_LENGTH = 8


class AssetFolder:
    """The folder `NAME.assets` next to an exported file. Files with the same content are written once.

    Attributes:
        folder: its name.
        files: content by path, relative to the output folder.
    """

    def __init__(self, name: str) -> None:
        self.folder = f"{name}.assets"
        self.files: dict[str, bytes] = {}

    def add(self, stem: str, suffix: str, data: bytes) -> str:
        """Adds a file to the folder and returns its name there, which includes a hash of the content."""
        digest = sha256(data).hexdigest()[:_DIGEST_LENGTH]
        name = f"{re.sub(r'[^A-Za-z0-9_.-]+', '_', stem) or 'file'}-{digest}{suffix}"
        self.files[f"{self.folder}/{name}"] = data
        return name


def optional_fields(part: type, *without: str) -> tuple[str, ...]:
    """Returns the optional fields of a plan's dataclass, except those `without`, which a format supports."""
    return tuple(
        item.name for item in fields(part) if item.compare and item.default is None and item.name not in without
    )


PHYSX_SETTINGS: Final = optional_fields(Physics, "timestep", "gravity", "default_material")
"""Fields of `Physics` that are specific to PhysX or to parallel scenes, which no other format supports."""


class UnsupportedFeatures:
    """Collects what is omitted or changed, and reports it at the end: one warning for equal findings."""

    def __init__(self, sink: Sink, *, left_out: str, otherwise: str) -> None:
        """`left_out`, `otherwise`: codes of the two warnings."""
        self._sink = sink
        self._left_out = left_out
        self._otherwise = otherwise
        self._found: dict[tuple[str, str, str], tuple[Origin | None, int]] = {}

    def leave_out(self, name: str, what: str, place: Origin | None) -> None:
        """Records that a feature of the entity `name` is not in the file. `what`: as in "`damping` of a joint"."""
        self._take(self._left_out, name, f"left out: {what}", place)

    def change(self, name: str, what: str, place: Origin | None) -> None:
        """Records that a feature of the entity `name` is approximated. `what`: a sentence that says how."""
        self._take(self._otherwise, name, what, place)

    def fields(self, name: str, thing: object, fields: Iterable[str], place: Origin | None, of: str = "") -> None:
        """Records as omitted the `fields` that a part of the plan sets. `of`: as in " of a joint"."""
        names = [f"`{SPEC_FIELD_NAMES.get(field, field)}`" for field in fields if getattr(thing, field) is not None]
        if names:
            self.leave_out(name, f"{', '.join(names)}{of}", place)

    def report(self) -> None:
        """Reports everything that was collected."""
        for (code, name, what), (place, count) in self._found.items():
            times = f" ({count} times)" if count > 1 else ""
            self._sink.report(code, f"`{name}`: {what}{times}", place or Location(None))
        self._found.clear()

    def _take(self, code: str, name: str, what: str, place: Origin | None) -> None:
        key = (code, name, what)
        first, count = self._found.get(key, (place, 0))
        self._found[key] = (first, count + 1)
