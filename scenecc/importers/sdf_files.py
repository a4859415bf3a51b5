"""SDF files: parsing, also of slightly malformed XML, typed values of elements, and the search for files."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, Vec3, from_rpy, normalized
from scenecc.importers.imported_scene import ImportContext, Loss
from scenecc.robots.files import FileReport, read_robot_bytes
from scenecc.robots.xml import (
    SourceElement,
    XmlBounds,
    parse_number,
    parse_recovered_xml,
    parse_xml,
    without_hyphens_in_comments,
)
from scenecc.source.paths import Refusal, check_uri, resolve_path

_MAX_NUMBER: Final = 1e30
"""Larger numbers count as infinite, since the engine has single precision."""

_INFINITE: Final = frozenset({"lower", "upper", "effort", "velocity", "far", "mu", "mu2", "friction"})
"""Elements that may be infinite."""

SMALLEST: Final = 1e-9
"""Smallest size [m], and smallest length of a direction."""


class SdfFile:
    """Reads values from one file, and collects losses.

    Attributes:
        context: of the import.
        path: of the file.
        losses: losses so far, of all files of the import.
        version: SDF version of the file.
    """

    def __init__(self, context: ImportContext, path: Path, losses: list[Loss], version: str = "") -> None:
        self.context = context
        self.path = path
        self.losses = losses
        self.version = tuple(int(part) for part in re.findall(r"\d{1,9}", version)[:2])

    def is_before(self, *version: int) -> bool:
        """Returns whether the file has an older SDF version; False without a version."""
        return bool(self.version) and self.version < version

    def error(self, message: str, element: SourceElement, hint: str | None = None, code: str = "SC433") -> None:
        """Reports an error at an element."""
        self.context.sink.report(code, message, element.location, hint=hint)

    def lose(self, kind: str, message: str, element: SourceElement, path: str = "") -> None:
        """Adds a loss."""
        self.losses.append(Loss(kind, message, element.location, path))

    def numbers(self, element: SourceElement | None, count: int) -> tuple[float, ...] | None:
        """Returns `count` finite numbers in an element's text; None without an element, or after an error."""
        if element is None:
            return None
        values = [parse_number(word) for word in element.text.split()]
        numbers = [value for value in values if value is not None and abs(value) <= _MAX_NUMBER]
        if len(numbers) != count or len(values) != count:
            wanted = "a finite number" if count == 1 else f"{count} finite numbers"
            self.error(f"<{element.tag}> needs {wanted}, not `{element.text[:60]}`", element)
            return None
        return tuple(numbers)

    def number(self, parent: SourceElement | None, *path: str, default: float) -> float:
        """Returns the number in a descendant element; the default if there is none. Limits may be infinite."""
        element = find_element(parent, *path)
        if element is None or not element.text:
            return default
        value = parse_number(element.text)
        if value is not None and abs(value) <= _MAX_NUMBER:
            return value
        if value is None or math.isnan(value) or element.tag not in _INFINITE:
            self.error(f"<{element.tag}> needs a finite number, not `{element.text[:60]}`", element)
            return default
        return math.copysign(math.inf, value)

    def positive(self, parent: SourceElement, *path: str, default: float) -> float:
        """Returns a number; reports an error if it is not above 0."""
        value = self.number(parent, *path, default=default)
        if value >= SMALLEST:
            return value
        self.error(f"<{path[-1]}> must be positive, not {value:g}", find_element(parent, *path) or parent)
        return default

    def vector(self, parent: SourceElement | None, *path: str, default: Vec3) -> Vec3:
        """Returns three numbers in a descendant element."""
        found = self.numbers(find_element(parent, *path), 3)
        return default if found is None else (found[0], found[1], found[2])

    def flag(self, parent: SourceElement | None, *path: str, default: bool) -> bool:
        """Returns the boolean in a descendant element."""
        element = find_element(parent, *path)
        if element is None:
            return default
        text = element.text.lower()
        if text not in {"true", "false", "1", "0"}:
            self.error(f"<{element.tag}> must be true or false, not `{element.text[:60]}`", element)
        return text in {"true", "1"}

    def pose(self, parent: SourceElement) -> Pose7:
        """Returns the <pose> of an element, in the frame that it names."""
        element = parent.find("pose")
        if element is None or not element.text:
            return IDENTITY_POSE
        by_quaternion = element.attributes.get("rotation_format") == "quat_xyzw"
        found = self.numbers(element, 7 if by_quaternion else 6)
        if found is None:
            return IDENTITY_POSE
        if by_quaternion:
            x, y, z, w = found[3:]
            if math.hypot(x, y, z, w) < 1e-6:
                self.error("the quaternion of <pose> has length 0", element)
                return IDENTITY_POSE
            return (found[0], found[1], found[2], *normalized((w, x, y, z)))
        degrees = element.attributes.get("degrees", "").lower() in {"true", "1"}
        roll, pitch, yaw = (math.radians(angle) if degrees else angle for angle in found[3:])
        return (found[0], found[1], found[2], *from_rpy(roll, pitch, yaw))


def find_element(parent: SourceElement | None, *path: str) -> SourceElement | None:
    """Returns the first descendant along a path of tags."""
    for tag in path:
        parent = None if parent is None else parent.find(tag)
    return parent


def text_of(parent: SourceElement | None, *path: str) -> str:
    """Returns the text of a descendant; "" if there is none."""
    element = find_element(parent, *path)
    return "" if element is None else element.text


def read_sdf_file(path: Path, context: ImportContext, losses: list[Loss]) -> tuple[SdfFile, SourceElement] | None:
    """Returns the root element of a file; None after an error."""
    shown = str(path)
    report = FileReport(context.sink)
    data = read_robot_bytes(path, shown, report, XmlBounds().size)
    if data is None:
        return None
    file = SdfFile(context, path, losses)
    root = _parse(data, shown, file)
    if root is not None and root.tag != "sdf":
        file.error(f"the root element is <{root.tag}>, not <sdf>", root, code="SC430")
        return None
    return None if root is None else (SdfFile(context, path, losses, root.attributes.get("version", "")), root)


_COMMENT: Final = re.compile(rb"<!--.*?-->", re.DOTALL)


def _parse(data: bytes, shown: str, file: SdfFile) -> SourceElement | None:
    """Returns the root element; None after an error. A malformed file is recovered if the user allows it."""
    sink = file.context.sink
    trial = sink.another()
    root = parse_xml(data, shown, FileReport(trial))
    if root is not None:
        return root
    (fault,) = trial.diagnostics()
    if fault.code != "SC450":
        sink.report(fault.code, fault.message, fault.location, hint=fault.hint)
        return None
    root = parse_xml(without_hyphens_in_comments(data), shown, FileReport(sink.another()))
    if root is not None:
        return root
    text = _COMMENT.sub(b"", data)
    is_whole = b"<!--" not in text and text.rstrip().endswith(b"</sdf>")
    if is_whole and "malformed-xml" in file.context.allow:
        root = parse_recovered_xml(data, shown, FileReport(sink))
        if root is not None:
            file.losses.append(Loss("malformed-xml", f"{fault.message}; read as far as possible", fault.location))
        return root
    hint = "fix it, or read it as far as possible with --allow malformed-xml" if is_whole else fault.hint
    sink.report(fault.code, fault.message, fault.location, hint=hint)
    return None


_URI = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*):/{0,2}(.*)", re.DOTALL)


def find_file(uri: str, file: SdfFile) -> Path | str:
    """Returns the file of a URI, or the reason why there is none. Searches only the folders of the import's scope."""
    refusal = check_uri(uri)
    if refusal is not None:
        return refusal.message
    scope = file.context.scope
    reasons: list[Refusal] = []
    candidates = _candidates(uri, file)
    if isinstance(candidates, str):
        return candidates
    for candidate in candidates:
        found = resolve_path(str(candidate), base=file.path.absolute().parent, scope=scope)
        if not isinstance(found, Refusal):
            return found.path
        reasons.append(found)
    if _URI.fullmatch(uri) is None and reasons[0].code != "SC401":
        return reasons[0].message
    hint = next((f"; {each.hint}" for each in reasons if each.hint), "")
    return f"`{uri[:120]}` is neither near the file nor in an asset root (--asset-root){hint}"


def find_included_model(uri: str, file: SdfFile) -> Path | str:
    """Returns the SDF or URDF of an <include>, or the reason why there is none. A folder's model.config names it."""
    if not uri:
        return "<include> has no <uri>"
    if Path(uri).suffix.lower() in {".sdf", ".world", ".urdf", ".xml"}:
        return find_file(uri, file)
    config = find_file(f"{uri.rstrip('/')}/model.config", file)
    if isinstance(config, str):
        model = find_file(f"{uri.rstrip('/')}/model.sdf", file)
        return config.replace("/model.config", "") if isinstance(model, str) else model
    report = FileReport(file.context.sink)
    data = read_robot_bytes(config, str(config), report, XmlBounds().size)
    root = None if data is None else parse_xml(data, str(config), report)
    named = [] if root is None else sorted(root.all("sdf"), key=lambda one: _version(one.attributes.get("version", "")))
    name = named[-1].text if named else text_of(root, "sdf") or "model.sdf"
    return find_file(f"{uri.rstrip('/')}/{name}", file)


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", text))


def _candidates(uri: str, file: SdfFile) -> Iterator[Path] | str:
    """Returns the candidate paths of a URI, or the reason why there are none."""
    match = _URI.fullmatch(uri)
    scheme, inner = ("", uri) if match is None else (match[1].lower(), match[2])
    if scheme in {"http", "https", "fuel", "ignition.fuel"}:
        return f"`{uri[:120]}` is on the web, and scenecc downloads nothing"
    if scheme not in {"", "file", "model", "package"}:
        return f"`{scheme}://` is not supported, in `{uri[:120]}`"
    return _paths(scheme, inner, file)


def _paths(scheme: str, inner: str, file: SdfFile) -> Iterator[Path]:
    folder = file.path.absolute().parent
    name, _, rest = inner.partition("/")
    if scheme in {"", "file"}:
        yield folder / inner
    for root in file.context.scope.asset_roots:
        yield root.absolute() / inner.lstrip("/")
    if scheme in {"model", "package"}:
        for above in (folder, *folder.parents):
            yield above / inner
            if rest and (above.name == name or _package_name(above, file) == name):
                yield above / rest
        for root in file.context.scope.asset_roots:
            if rest and (root.absolute().name == name or _package_name(root.absolute(), file) == name):
                yield root.absolute() / rest


_PACKAGE_NAME: Final = re.compile(rb"<name>\s*([^<\s]{1,200})\s*</name>")


def _package_name(folder: Path, file: SdfFile) -> str:
    """Returns the name of a folder's ROS package, from its package.xml; "" without one in the import's scope."""
    found = resolve_path(str(folder / "package.xml"), base=folder, scope=file.context.scope)
    if isinstance(found, Refusal):
        return ""
    data = read_robot_bytes(found.path, found.uri, FileReport(file.context.sink.another()), XmlBounds().size)
    name = _PACKAGE_NAME.search(data or b"")
    return name[1].decode("utf-8", "replace") if name else ""
