"""Attributes of MJCF elements: their values, default classes and the settings of `<compiler>` and `<option>`.

An element's class is the one that it names, else the nearest `childclass` around it, else the global class. A class
inherits from the classes around it. ManiSkill's loader overlays them differently; where that changes a value, the
difference is reported.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.plan.properties import round_to_float32
from scenecc.robots.xml import SourceElement, parse_numbers

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Location
    from scenecc.robots.mjcf_files import MjcfReport

_INTEGER_PATTERN = re.compile(r"[+-]?\d{1,9}", re.ASCII)

ORIENTATION_ATTRIBUTES = ("quat", "euler", "axisangle", "xyaxes", "zaxis")
"""The attributes that give an orientation."""


@dataclass(frozen=True, slots=True)
class MjcfAttributes:
    """The attributes of an element.

    Attributes:
        element: whose they are.
        given: name → the element that gives it: itself, or one of its class's.
        report: where faults go.
    """

    element: SourceElement
    given: Mapping[str, SourceElement] = field(repr=False)
    report: MjcfReport = field(repr=False)

    def __contains__(self, name: str) -> bool:
        return name in self.given

    def text(self, name: str, default: str = "") -> str:
        """The attribute as it is written."""
        giver = self.given.get(name)
        return default if giver is None else giver.attributes[name]

    def at(self, name: str) -> Location:
        """Where an attribute stands, which may be in a class; the element where it has none."""
        return self.given.get(name, self.element).at(name)

    def word(self, name: str, words: Sequence[str], default: str) -> str:
        """An attribute that is one of some words; the default after an error."""
        text = self.text(name, default)
        if text in words:
            return text
        self.wrong(name, f"is one of {', '.join(words)}, not `{cut(text)}`")
        return default

    def integer(self, name: str, default: int) -> int:
        """An attribute that is a whole number."""
        text = self.text(name).strip()
        if name in self and _INTEGER_PATTERN.fullmatch(text) is None:
            self.wrong(name, f"is a whole number, not `{cut(text)}`")
            return default
        return int(text) if name in self else default

    def number(self, name: str, default: float, low: float = -math.inf, high: float = math.inf) -> float:
        """An attribute that is one number, no less than `low` and no more than `high`; in double precision."""
        values = self.numbers(name, (default,))
        if not low <= values[0] <= high:
            bounds = f"at least {low:g}" if high == math.inf else f"between {low:g} and {high:g}"
            self.wrong(name, f"is {bounds}, not {values[0]:g}")
            return default
        return values[0]

    def numbers(
        self, name: str, default: tuple[float, ...], *, least: int | None = None, infinite: bool = False
    ) -> tuple[float, ...]:
        """An attribute of several numbers, in double precision; the default after an error.

        Args:
            name: of the attribute.
            default: returned, the same object, if it is not given or wrong; its length is the maximum count.
            least: minimum count; None: that of the default.
            infinite: whether they may be infinite.
        """
        if name not in self:
            return default
        parts = self.text(name).split()
        count = len(default)
        least = count if least is None else least
        if not least <= len(parts) <= count:
            wanted = f"{count} number{'s' if count > 1 else ''}" if least == count else f"{least} to {count} numbers"
            self.wrong(name, f"is {wanted}, not {len(parts)}")
            return default
        try:
            return parse_numbers(parts, infinite=infinite)
        except ValueError as error:
            self.wrong(name, str(error))
            return default

    def singles(self, name: str, default: tuple[float, ...], *, least: int | None = None) -> tuple[float, ...]:
        """As `numbers`, in single precision."""
        return tuple(map(round_to_float32, self.numbers(name, default, least=least)))

    def orientation(self) -> str | None:
        """The orientation attribute in use: the element's own before its class's; two at once are an error."""
        own = [name for name in ORIENTATION_ATTRIBUTES if name in self.element.attributes]
        if len(own) > 1:
            self.wrong(own[1], f"gives an orientation, and so does `{own[0]}`")
        if own:
            return own[0]
        return next((name for name in ORIENTATION_ATTRIBUTES if name in self), None)

    def wrong(self, name: str, what: str, hint: str | None = None) -> None:
        """Reports an attribute's value."""
        tag = self.given.get(name, self.element).tag
        self.report.error("SC481", f"`{name}` of `<{tag}>` {what}", self.at(name), hint)


def own_attributes(element: SourceElement, report: MjcfReport) -> MjcfAttributes:
    """The attributes that stand in an element itself."""
    return MjcfAttributes(element, dict.fromkeys(element.attributes, element), report)


AttributeSources = dict[str, "SourceElement"]
"""Attribute → the element that gives it."""

_GLOBAL_CLASS = "main"

IGNORED_CLASS = "motor"
"""Geoms and bodies whose class begins so are not built, by ManiSkill's loader."""


@dataclass(frozen=True, slots=True)
class _DefaultClass:
    """What one class says itself. `parent`: name of the class around it."""

    parent: str | None
    tags: dict[str, AttributeSources] = field(default_factory=dict[str, AttributeSources])


@dataclass(frozen=True, slots=True)
class ClassScope:
    """The classes that bodies around an element set, outermost first."""

    names: tuple[str, ...] = ()


@dataclass(slots=True)
class DefaultClasses:
    """The default classes of a file."""

    report: MjcfReport
    _classes: dict[str, _DefaultClass] = field(default_factory=lambda: {_GLOBAL_CLASS: _DefaultClass(None)})
    _chains: dict[tuple[str, str, bool], AttributeSources] = field(
        default_factory=dict[tuple[str, str, bool], AttributeSources]
    )

    def known(self, name: str, element: SourceElement, attribute: str) -> bool:
        """Whether there is a class of some name; if not, it is reported at the attribute that names it."""
        if name in self._classes:
            return True
        hint = suggest_name(
            name, (known for known in self._classes if known != _GLOBAL_CLASS), self.report.findings.sink
        )
        self.report.error("SC482", f"there is no default class `{cut(name)}`", element.at(attribute), hint)
        return False

    def attributes(self, element: SourceElement, scope: ClassScope, read: frozenset[str]) -> MjcfAttributes:
        """What an element has, its class's values with it.

        Args:
            element: of any kind.
            scope: where it stands.
            read: names of the attributes to read; others are reported as unread.
        """
        named = element.attributes.get("class")
        names = scope.names
        if named is not None and self.known(named, element, "class"):
            names = (*names, named)
        given = self._chain(names[-1] if names else _GLOBAL_CLASS, element.tag)
        own = dict.fromkeys(element.attributes, element)
        self.report.unread_attributes(element, read | {"class"})
        if len(names) > 1:
            self._compare(element, {**given, **own}, names, read)
        return MjcfAttributes(element, {**given, **own}, self.report)

    def inherited(self, tag: str, element: SourceElement, scope: ClassScope) -> MjcfAttributes:
        """What an element of some kind would have that says nothing itself, in the body `element`."""
        return MjcfAttributes(element, self._chain(scope.names[-1] if scope.names else _GLOBAL_CLASS, tag), self.report)

    def _compare(
        self, element: SourceElement, given: Mapping[str, SourceElement], names: Iterable[str], read: frozenset[str]
    ) -> None:
        """Reports a difference from ManiSkill's loader, which overlays all classes."""
        laid: AttributeSources = {}
        for name in (_GLOBAL_CLASS, *names):
            laid.update(
                self._chain(name, element.tag, whole=False) if name != _GLOBAL_CLASS else self._own(name, element.tag)
            )
        laid.update(dict.fromkeys(element.attributes, element))
        for name in sorted(read):
            mine, theirs = given.get(name), laid.get(name)
            if (mine and mine.attributes[name]) != (theirs and theirs.attributes[name]):
                self.report.differs(
                    "class",
                    f"`{name}` is what the element's own class has; ManiSkill's loader takes that of the classes "
                    "around it, too",
                    element.location,
                )
                return

    def _own(self, name: str, tag: str) -> AttributeSources:
        return self._classes[name].tags.get(tag, {})

    def _chain(self, name: str, tag: str, *, whole: bool = True) -> AttributeSources:
        """What a class says of a kind of element, with what it has from the classes around it.

        `whole`: with the global one, too.
        """
        key = (name, tag, whole)
        chain = self._chains.get(key)
        if chain is None:
            parent = self._classes[name].parent
            above = self._chain(parent, tag, whole=whole) if parent and (whole or parent != _GLOBAL_CLASS) else {}
            chain = self._chains[key] = {**above, **self._own(name, tag)}
        return chain

    def read(self, sections: Iterable[SourceElement], read: Mapping[str, frozenset[str]]) -> None:
        """Reads the sections `default`. `read`: the kinds of elements that are heeded, and which attributes."""
        for section in sections:
            self._section(section, None, read)

    def _section(self, section: SourceElement, parent: str | None, read: Mapping[str, frozenset[str]]) -> None:
        name = section.attributes.get("class", _GLOBAL_CLASS if parent is None else "")
        if not name:
            self.report.error("SC481", "a default class inside another has a name, in `class`", section.location)
            return
        if parent is None and name != _GLOBAL_CLASS:
            # The outermost class is the global one whatever its name, as it was before MuJoCo 3.
            self._classes.setdefault(name, _DefaultClass(_GLOBAL_CLASS))
        elif parent is not None:
            if name in self._classes:
                self.report.error("SC486", f"the default class `{cut(name)}` is defined twice", section.at("class"))
                return
            self._classes[name] = _DefaultClass(parent)
        if parent is None and "class" in section.attributes:
            self._named_global(section)
        target = self._classes[_GLOBAL_CLASS if parent is None else name]
        for child in section.children:
            if child.tag == "default":
                self._section(child, name, read)
            elif child.tag in read:
                self.report.unread_attributes(child, read[child.tag])
                target.tags.setdefault(child.tag, {}).update(dict.fromkeys(child.attributes, child))

    def _named_global(self, section: SourceElement) -> None:
        if any(child.tag != "default" for child in section.children):
            self.report.differs(
                "global class",
                "the outermost default class holds for all elements, its name notwithstanding; ManiSkill's loader "
                "takes it for those only that name it",
                section.location,
            )


_COMPILER_ATTRIBUTES = frozenset(
    {"angle", "eulerseq", "meshdir", "texturedir", "assetdir", "strippath", "autolimits", "coordinate"}
)

_FLAG_WORDS = ("enable", "disable")

_BOOLEAN_WORDS = ("true", "false")


@dataclass(slots=True)
class CompilerSettings:
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


def read_compiler(sections: Iterable[SourceElement], report: MjcfReport) -> CompilerSettings:
    """Reads the sections `compiler` and `option`, of several the later over the earlier, as MuJoCo does."""
    compiler = CompilerSettings()
    for section in sections:
        if section.tag == "compiler":
            _read_compiler_section(section, compiler, report)
        elif section.tag == "option":
            report.unread_attributes(section, frozenset())
            _read_option_flags(section, compiler, report)
    return compiler


def _read_compiler_section(section: SourceElement, compiler: CompilerSettings, report: MjcfReport) -> None:
    given = own_attributes(section, report)
    report.unread_attributes(section, _COMPILER_ATTRIBUTES)
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
        compiler.strip_path = given.word("strippath", _BOOLEAN_WORDS, "false") == "true"
    if "autolimits" in given:
        compiler.limits_by_range = given.word("autolimits", _BOOLEAN_WORDS, "true") == "true"
    if given.text("coordinate", "local") != "local":
        given.wrong("coordinate", "is `local`; MuJoCo took global coordinates away in its version 2.3.4")


def _read_option_flags(section: SourceElement, compiler: CompilerSettings, report: MjcfReport) -> None:
    for child in section.children:
        if child.tag != "flag":
            report.unread_element(child)
            continue
        report.unread_attributes(child, frozenset({"contact"}))
        given = own_attributes(child, report)
        if "contact" in given:
            compiler.contact = given.word("contact", _FLAG_WORDS, "enable") == "enable"
