"""How an MJCF is to be read: its `<compiler>`, and the flag of its `<option>` that switches contacts off."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.robots.mjcf.attributes import own_attributes

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.robots.mjcf.report import Report
    from scenecc.robots.xml import Element

_READ = frozenset({"angle", "eulerseq", "meshdir", "texturedir", "assetdir", "strippath", "autolimits", "coordinate"})
_SWITCH = ("enable", "disable")
_TRUTH = ("true", "false")


@dataclass(slots=True)
class Compiler:
    """How an MJCF is to be read.

    Attributes:
        degrees: whether angles are in degrees, and not in radians.
        euler_sequence: about which axes, one after another; small letters turn along, capital ones stay.
        mesh_folder, texture_folder: from the file's own folder; "" is that.
        strip_path: whether folders in names of files are dropped.
        limits_by_range: whether a range alone limits a joint.
        contact: whether anything collides at all.
    """

    degrees: bool = True
    euler_sequence: str = "xyz"
    mesh_folder: str = ""
    texture_folder: str = ""
    strip_path: bool = False
    limits_by_range: bool = True
    contact: bool = True

    def radians(self, angle: float) -> float:
        """An angle as the file writes it."""
        return angle * math.pi / 180 if self.degrees else angle


def read_compiler(sections: Iterable[Element], report: Report) -> Compiler:
    """Reads the sections `compiler` and `option`, of several the later over the earlier, as MuJoCo does."""
    compiler = Compiler()
    for section in sections:
        if section.tag == "compiler":
            _compiler(section, compiler, report)
        elif section.tag == "option":
            report.unread_attributes(section, frozenset())
            _flags(section, compiler, report)
    return compiler


def _compiler(section: Element, compiler: Compiler, report: Report) -> None:
    given = own_attributes(section, report)
    report.unread_attributes(section, _READ)
    for child in section.children:
        report.unread_element(child)
    if "angle" in given:
        compiler.degrees = given.word("angle", ("degree", "radian"), "degree") == "degree"
    if "eulerseq" in given:
        sequence = given.text("eulerseq")
        if len(sequence) == 3 and set(sequence) <= set("xyzXYZ"):
            compiler.euler_sequence = sequence
        else:
            given.wrong("eulerseq", f"is three letters out of x, y, z, X, Y and Z, not `{cut(sequence)}`")
    folder = given.text("assetdir")
    compiler.mesh_folder = given.text("meshdir", folder or compiler.mesh_folder)
    compiler.texture_folder = given.text("texturedir", folder or compiler.texture_folder)
    if "strippath" in given:
        compiler.strip_path = given.word("strippath", _TRUTH, "false") == "true"
    if "autolimits" in given:
        compiler.limits_by_range = given.word("autolimits", _TRUTH, "true") == "true"
    if given.text("coordinate", "local") != "local":
        given.wrong("coordinate", "is `local`; MuJoCo took global coordinates away in its version 2.3.4")


def _flags(section: Element, compiler: Compiler, report: Report) -> None:
    for child in section.children:
        if child.tag != "flag":
            report.unread_element(child)
            continue
        report.unread_attributes(child, frozenset({"contact"}))
        given = own_attributes(child, report)
        if "contact" in given:
            compiler.contact = given.word("contact", _SWITCH, "enable") == "enable"
