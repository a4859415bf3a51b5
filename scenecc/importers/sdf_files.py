"""Files that an SDF names: meshes, textures, and models by <include>."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.importers.sdf_xml import text_of
from scenecc.robots.files import FileReport, read_robot_bytes
from scenecc.robots.xml import XmlBounds, parse_xml
from scenecc.source.paths import Refusal, check_uri, resolve_path

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.importers.sdf_xml import SdfFile

_URI = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*):/{0,2}(.*)", re.DOTALL)


def find_file(uri: str, file: SdfFile) -> Path | str:
    """The file of a uri, or why there is none, in words. Only the folders of the import's scope are searched."""
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
    return f"`{uri[:120]}` is neither in a folder of the file nor in an asset root (--asset-root)"


def find_model(uri: str, file: SdfFile) -> Path | str:
    """The SDF or URDF of an <include>, or why there is none, in words. A folder's model.config names its file."""
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
    """Paths that a uri may mean, or why it means none."""
    match = _URI.fullmatch(uri)
    scheme, inner = ("", uri) if match is None else (match[1].lower(), match[2])
    if scheme in {"http", "https", "fuel", "ignition.fuel"}:
        return f"`{uri[:120]}` is on the web, and nothing is downloaded"
    if scheme not in {"", "file", "model", "package"}:
        return f"`{scheme}://` is not read, in `{uri[:120]}`"
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
            if above.name == name and rest:
                yield above / rest
